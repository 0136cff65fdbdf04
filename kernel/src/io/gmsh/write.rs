//! Writer of Gmsh's mesh files, formats 2.2 and 4.1 as text.
//!
//! The format knows cells with nodes, and physical groups of cells of one dimension. A sub model part
//! becomes a group of its name for each dimension of its cells; nodes that none of its cells holds are
//! written as cells of one point. What has no place is told by [`losses`].

use crate::geometry::Shape;
use crate::io::files::write_atomically;
use crate::model::{ModelPart, SubModelPart};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io::{self, Write};
use std::path::Path;

/// Version of the format to be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Version {
    /// The older one, which nearly every program reads.
    V2,
    /// The present one.
    #[default]
    V4,
}

/// Gmsh's number of a shape.
fn number(shape: Shape) -> i32 {
    super::cells::KNOWN.iter().find(|(_, known)| *known == shape).map_or(0, |(number, _)| *number)
}

/// A cell with indices of its nodes and of its groups.
struct Cell {
    id: u32,
    shape: Shape,
    nodes: Vec<u32>,
    groups: BTreeSet<usize>,
}

/// Sub model parts of all levels with the names of their groups.
fn groups(part: &ModelPart) -> Vec<(String, &SubModelPart)> {
    fn walk<'a>(parts: &'a [SubModelPart], above: &str, out: &mut Vec<(String, &'a SubModelPart)>) {
        for part in parts {
            let path = if above.is_empty() { part.name.clone() } else { format!("{above}_{}", part.name) };
            out.push((path.clone(), part));
            walk(&part.children, &path, out);
        }
    }
    let mut out = Vec::new();
    walk(&part.children, "", &mut out);
    out
}

/// Elements with their ids, then conditions, geometries and lone nodes of parts. Cells over the same nodes are
/// one, as a reader of the format takes them.
fn cells(part: &ModelPart, groups: &[(String, &SubModelPart)]) -> Vec<Cell> {
    let mut cells: Vec<Cell> = Vec::new();
    let mut known: HashMap<(usize, Vec<u32>), usize> = HashMap::new();
    let mut next = part.elements.ids.last().copied().unwrap_or(0);
    let mut add = |cells: &mut Vec<Cell>, id: Option<u32>, shape: Shape, nodes: &[u32]| {
        let mut key = nodes.to_vec();
        key.sort_unstable();
        *known.entry((shape.dimension(), key)).or_insert_with(|| {
            let id = id.unwrap_or_else(|| {
                next = next.saturating_add(1);
                next
            });
            cells.push(Cell { id, shape, nodes: nodes.to_vec(), groups: BTreeSet::new() });
            cells.len() - 1
        })
    };
    let mut places: [Vec<usize>; 3] = Default::default();
    for (list, place) in [&part.elements, &part.conditions, &part.geometries].into_iter().zip(&mut places) {
        let own = std::ptr::eq(list, &part.elements);
        for cell in 0..list.len() {
            let id = own.then(|| list.ids[cell]);
            place.push(add(&mut cells, id, list.shapes[cell], list.nodes_of(cell)));
        }
    }
    for (group, (_, sub)) in groups.iter().enumerate() {
        let mut held = BTreeSet::new();
        for (list, place) in [&sub.elements, &sub.conditions, &sub.geometries].into_iter().zip(&places) {
            for &cell in list {
                let cell = place[cell as usize];
                cells[cell].groups.insert(group);
                held.extend(cells[cell].nodes.iter().copied());
            }
        }
        for node in sub.nodes.iter().filter(|node| !held.contains(node)) {
            let cell = add(&mut cells, None, Shape::Point1, &[*node]);
            cells[cell].groups.insert(group);
        }
    }
    cells
}

/// Writes a root model part to `path` and returns the size of the file in bytes. Coordinates are exact,
/// nodes and elements keep their ids.
///
/// # Errors
/// Those of the file system; no part of a file is left.
pub fn write(part: &ModelPart, path: &Path, version: Version) -> io::Result<u64> {
    let groups = groups(part);
    let cells = cells(part, &groups);
    write_atomically(path, |out| {
        let number = if version == Version::V4 { "4.1" } else { "2.2" };
        writeln!(out, "$MeshFormat\n{number} 0 8\n$EndMeshFormat")?;
        let names: BTreeSet<(usize, usize)> =
            cells.iter().flat_map(|cell| cell.groups.iter().map(|&group| (cell.shape.dimension(), group))).collect();
        if !names.is_empty() {
            writeln!(out, "$PhysicalNames\n{}", names.len())?;
            for (dimension, group) in names {
                writeln!(out, "{dimension} {} \"{}\"", group + 1, groups[group].0)?;
            }
            writeln!(out, "$EndPhysicalNames")?;
        }
        match version {
            Version::V2 => version2(part, &cells, out),
            Version::V4 => version4(part, &cells, out),
        }
    })
}

fn write_nodes(line: &[u32], ids: &[u32], out: &mut dyn Write) -> io::Result<()> {
    line.iter().try_for_each(|&node| write!(out, " {}", ids[node as usize]))?;
    writeln!(out)
}

/// A cell stands once for each of its groups, the second time under a new id.
fn version2(part: &ModelPart, cells: &[Cell], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "$Nodes\n{}", part.nodes.len())?;
    for (id, [x, y, z]) in part.nodes.ids.iter().zip(&part.nodes.coordinates) {
        writeln!(out, "{id} {x:?} {y:?} {z:?}")?;
    }
    let lines: usize = cells.iter().map(|cell| cell.groups.len().max(1)).sum();
    writeln!(out, "$EndNodes\n$Elements\n{lines}")?;
    let mut next = cells.iter().map(|cell| cell.id).max().unwrap_or(0);
    for cell in cells {
        let groups: Vec<usize> = cell.groups.iter().map(|group| group + 1).collect();
        let groups = if groups.is_empty() { vec![0] } else { groups };
        for (copy, group) in groups.into_iter().enumerate() {
            if copy > 0 {
                next += 1;
            }
            let id = if copy == 0 { cell.id } else { next };
            // The second tag, the elementary entity, must be there and above 0.
            write!(out, "{id} {} 2 {group} {}", number(cell.shape), group.max(1))?;
            write_nodes(&cell.nodes, &part.nodes.ids, out)?;
        }
    }
    writeln!(out, "$EndElements")
}

/// An entity for each dimension and set of groups that occurs.
fn version4(part: &ModelPart, cells: &[Cell], out: &mut dyn Write) -> io::Result<()> {
    let mut entities: BTreeMap<(usize, Vec<usize>), BTreeMap<i32, Vec<usize>>> = BTreeMap::new();
    for (index, cell) in cells.iter().enumerate() {
        let key = (cell.shape.dimension(), cell.groups.iter().copied().collect());
        entities.entry(key).or_default().entry(number(cell.shape)).or_default().push(index);
    }
    write_entities(part, entities.keys(), out)?;
    let (low, high) = ends(part.nodes.ids.iter().copied());
    // All nodes are said to lie in the last entity, which is of the highest dimension.
    let last = entities.keys().next_back().map_or(0, |(dimension, _)| *dimension);
    let tag = entities.keys().filter(|(dimension, _)| *dimension == last).count().max(1);
    let count = part.nodes.len();
    writeln!(out, "$Nodes\n1 {count} {low} {high}\n{last} {tag} 0 {count}")?;
    part.nodes.ids.iter().try_for_each(|id| writeln!(out, "{id}"))?;
    part.nodes.coordinates.iter().try_for_each(|[x, y, z]| writeln!(out, "{x:?} {y:?} {z:?}"))?;
    let blocks: usize = entities.values().map(BTreeMap::len).sum();
    let (low, high) = ends(cells.iter().map(|cell| cell.id));
    writeln!(out, "$EndNodes\n$Elements\n{blocks} {} {low} {high}", cells.len())?;
    let mut tags = [0; 4];
    for ((dimension, _), kinds) in &entities {
        tags[*dimension] += 1;
        for (kind, members) in kinds {
            writeln!(out, "{dimension} {} {kind} {}", tags[*dimension], members.len())?;
            for &cell in members {
                write!(out, "{}", cells[cell].id)?;
                write_nodes(&cells[cell].nodes, &part.nodes.ids, out)?;
            }
        }
    }
    writeln!(out, "$EndElements")
}

fn write_entities<'a>(
    part: &ModelPart,
    entities: impl Iterator<Item = &'a (usize, Vec<usize>)> + Clone,
    out: &mut dyn Write,
) -> io::Result<()> {
    let count = |wanted: usize| entities.clone().filter(|(dimension, _)| *dimension == wanted).count();
    writeln!(out, "$Entities\n{} {} {} {}", count(0), count(1), count(2), count(3))?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for x in &part.nodes.coordinates {
        (0..3).for_each(|axis| (low[axis], high[axis]) = (low[axis].min(x[axis]), high[axis].max(x[axis])));
    }
    let place = |x: [f64; 3]| format!("{:?} {:?} {:?}", x[0], x[1], x[2]);
    let mut tags = [0; 4];
    for (dimension, groups) in entities.clone() {
        tags[*dimension] += 1;
        let bounds = if *dimension == 0 { place(low) } else { format!("{} {}", place(low), place(high)) };
        write!(out, "{} {bounds} {}", tags[*dimension], groups.len())?;
        groups.iter().try_for_each(|group| write!(out, " {}", group + 1))?;
        // No boundary is known.
        writeln!(out, "{}", if *dimension == 0 { "" } else { " 0" })?;
    }
    writeln!(out, "$EndEntities")
}

fn ends(ids: impl Iterator<Item = u32> + Clone) -> (u32, u32) {
    (ids.clone().min().unwrap_or(0), ids.max().unwrap_or(0))
}

/// What a model part holds and the format does not, in words.
pub fn losses(part: &ModelPart) -> Vec<String> {
    let mut losses = Vec::new();
    let dimension = part.elements.shapes.iter().map(|shape| shape.dimension()).max().unwrap_or(0);
    let lower = part.elements.shapes.iter().filter(|shape| shape.dimension() < dimension).count();
    if lower > 0 {
        losses.push(format!("{lower} elements of less than {dimension} dimensions are geometries when they are read"));
    }
    if !part.elements.is_empty() {
        losses.push(format!(
            "element names ({}): a reader names the cells by their shapes",
            part.elements.names.join(", ")
        ));
    }
    if !part.conditions.is_empty() {
        let names = part.conditions.names.join(", ");
        losses.push(format!("{} conditions ({names}) are geometries when they are read", part.conditions.len()));
    }
    let all = part.elements.len() + part.conditions.len() + part.geometries.len();
    let kept = cells(part, &[]).len();
    if kept < all {
        losses.push(format!("{} cells over the nodes of others: one of them is kept", all - kept));
    }
    if part.properties.keys().any(|id| *id != 0) || part.properties.values().any(|p| !p.values.is_empty()) {
        losses.push("properties and which of them a cell has".into());
    }
    if !part.tables.is_empty() {
        losses.push(format!("{} tables", part.tables.len()));
    }
    for (what, data) in [
        ("nodes", part.nodal_data.keys().collect::<Vec<_>>()),
        ("elements", part.elemental_data.keys().collect()),
        ("conditions", part.conditional_data.keys().collect()),
    ] {
        if !data.is_empty() {
            let names: Vec<&str> = data.into_iter().map(String::as_str).collect();
            losses.push(format!("data of {what}: {}", names.join(", ")));
        }
    }
    let held: BTreeSet<u32> = cells(part, &groups(part)).into_iter().flat_map(|cell| cell.nodes).collect();
    if held.len() < part.nodes.len() {
        let lone = part.nodes.len() - held.len();
        losses.push(format!("{lone} nodes in no cell and no sub model part: Bia's reader leaves them out"));
    }
    for (name, sub) in groups(part) {
        if name.matches('_').count() > sub.name.matches('_').count() {
            losses.push(format!("nesting of sub model parts: {:?} is the group {name:?}", sub.name));
        }
        let cells = sub.elements.len() + sub.conditions.len() + sub.geometries.len();
        if sub.nodes.is_empty() && cells == 0 {
            losses.push(format!("the sub model part {:?}, which is empty", sub.name));
        }
    }
    losses
}
