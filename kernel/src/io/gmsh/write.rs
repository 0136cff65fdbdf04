//! Writer of Gmsh's mesh files, formats 2.2 and 4.1, as text and binary.
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
fn number(shape: Shape) -> usize {
    super::cells::KNOWN.iter().find(|(_, known)| *known == shape).map_or(0, |(number, _)| *number as usize)
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

/// Numbers of a section, as text with a line end where the format has one, or as they are in memory.
struct Numbers<'a> {
    out: &'a mut dyn Write,
    binary: bool,
    /// The line has numbers already.
    inside: bool,
}

impl Numbers<'_> {
    fn put(&mut self, bytes: &[u8], text: std::fmt::Arguments) -> io::Result<()> {
        if self.binary {
            return self.out.write_all(bytes);
        }
        let blank = if std::mem::replace(&mut self.inside, true) { " " } else { "" };
        write!(self.out, "{blank}{text}")
    }

    fn int(&mut self, value: usize) -> io::Result<()> {
        let value = i32::try_from(value).map_err(io::Error::other)?;
        self.put(&value.to_ne_bytes(), format_args!("{value}"))
    }

    fn size(&mut self, value: usize) -> io::Result<()> {
        self.put(&(value as u64).to_ne_bytes(), format_args!("{value}"))
    }

    fn real(&mut self, value: f64) -> io::Result<()> {
        self.put(&value.to_ne_bytes(), format_args!("{value:?}"))
    }

    fn place(&mut self, place: [f64; 3]) -> io::Result<()> {
        place.into_iter().try_for_each(|x| self.real(x))
    }

    /// The end of a line of text.
    fn end(&mut self) -> io::Result<()> {
        self.inside = false;
        if self.binary { Ok(()) } else { writeln!(self.out) }
    }

    /// The end of a section, which is a line of its own in binary files, too.
    fn close(&mut self, name: &str) -> io::Result<()> {
        let before = if self.binary { "\n" } else { "" };
        writeln!(self.out, "{before}$End{name}")
    }
}

/// Writes a root model part to `path` and returns the size of the file in bytes. Coordinates are exact,
/// nodes and elements keep their ids.
///
/// # Errors
/// Those of the file system; no part of a file is left.
pub fn write(part: &ModelPart, path: &Path, version: Version, binary: bool) -> io::Result<u64> {
    let groups = groups(part);
    let cells = cells(part, &groups);
    write_atomically(path, |out| {
        let number = if version == Version::V4 { "4.1" } else { "2.2" };
        writeln!(out, "$MeshFormat\n{number} {} 8", u8::from(binary))?;
        if binary {
            // By which a reader tells the order of bytes.
            out.write_all(&1i32.to_ne_bytes())?;
            writeln!(out)?;
        }
        writeln!(out, "$EndMeshFormat")?;
        let names: BTreeSet<(usize, usize)> =
            cells.iter().flat_map(|cell| cell.groups.iter().map(|&group| (cell.shape.dimension(), group))).collect();
        if !names.is_empty() {
            writeln!(out, "$PhysicalNames\n{}", names.len())?;
            for (dimension, group) in names {
                writeln!(out, "{dimension} {} \"{}\"", group + 1, groups[group].0)?;
            }
            writeln!(out, "$EndPhysicalNames")?;
        }
        let mut numbers = Numbers { out, binary, inside: false };
        match version {
            Version::V2 => version2(part, &cells, &mut numbers),
            Version::V4 => version4(part, &cells, &mut numbers),
        }
    })
}

/// A cell stands once for each of its groups, the second time under a new id.
fn version2(part: &ModelPart, cells: &[Cell], out: &mut Numbers) -> io::Result<()> {
    writeln!(out.out, "$Nodes\n{}", part.nodes.len())?;
    for (id, place) in part.nodes.ids.iter().zip(&part.nodes.coordinates) {
        out.int(*id as usize)?;
        out.place(*place)?;
        out.end()?;
    }
    out.close("Nodes")?;
    let mut next = cells.iter().map(|cell| cell.id).max().unwrap_or(0);
    let mut lines: Vec<(u32, usize, &Cell)> = Vec::new();
    for cell in cells {
        let groups: Vec<usize> = cell.groups.iter().map(|group| group + 1).collect();
        let groups = if groups.is_empty() { vec![0] } else { groups };
        for (copy, group) in groups.into_iter().enumerate() {
            next += u32::from(copy > 0);
            lines.push((if copy == 0 { cell.id } else { next }, group, cell));
        }
    }
    writeln!(out.out, "$Elements\n{}", lines.len())?;
    for run in lines.chunk_by(|(_, _, a), (_, _, b)| a.shape == b.shape) {
        let kind = number(run[0].2.shape);
        if out.binary {
            [kind, run.len(), 2].into_iter().try_for_each(|value| out.int(value))?;
        }
        for (id, group, cell) in run {
            out.int(*id as usize)?;
            if !out.binary {
                [kind, 2].into_iter().try_for_each(|value| out.int(value))?;
            }
            // The second tag, the elementary entity, must be there and above 0.
            [*group, (*group).max(1)].into_iter().try_for_each(|value| out.int(value))?;
            cell.nodes.iter().try_for_each(|&node| out.int(part.nodes.ids[node as usize] as usize))?;
            out.end()?;
        }
    }
    out.close("Elements")
}

/// An entity for each dimension and set of groups that occurs.
fn version4(part: &ModelPart, cells: &[Cell], out: &mut Numbers) -> io::Result<()> {
    let mut entities: BTreeMap<(usize, Vec<usize>), BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
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
    writeln!(out.out, "$Nodes")?;
    sizes(out, &[1, count, low, high])?;
    block(out, [last, tag, 0], count)?;
    for id in &part.nodes.ids {
        sizes(out, &[*id as usize])?;
    }
    for place in &part.nodes.coordinates {
        out.place(*place)?;
        out.end()?;
    }
    out.close("Nodes")?;
    let blocks: usize = entities.values().map(BTreeMap::len).sum();
    let (low, high) = ends(cells.iter().map(|cell| cell.id));
    writeln!(out.out, "$Elements")?;
    sizes(out, &[blocks, cells.len(), low, high])?;
    let mut tags = [0; 4];
    for ((dimension, _), kinds) in &entities {
        tags[*dimension] += 1;
        for (kind, members) in kinds {
            block(out, [*dimension, tags[*dimension], *kind], members.len())?;
            for &cell in members {
                out.size(cells[cell].id as usize)?;
                cells[cell].nodes.iter().try_for_each(|&node| out.size(part.nodes.ids[node as usize] as usize))?;
                out.end()?;
            }
        }
    }
    out.close("Elements")
}

/// A line of sizes.
fn sizes(out: &mut Numbers, values: &[usize]) -> io::Result<()> {
    values.iter().try_for_each(|value| out.size(*value))?;
    out.end()
}

/// The head of a block of nodes or elements: dimension, tag and kind, and how many there are.
fn block(out: &mut Numbers, values: [usize; 3], count: usize) -> io::Result<()> {
    values.into_iter().try_for_each(|value| out.int(value))?;
    sizes(out, &[count])
}

fn write_entities<'a>(
    part: &ModelPart,
    entities: impl Iterator<Item = &'a (usize, Vec<usize>)> + Clone,
    out: &mut Numbers,
) -> io::Result<()> {
    let count = |wanted: usize| entities.clone().filter(|(dimension, _)| *dimension == wanted).count();
    writeln!(out.out, "$Entities")?;
    sizes(out, &[count(0), count(1), count(2), count(3)])?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for x in &part.nodes.coordinates {
        (0..3).for_each(|axis| (low[axis], high[axis]) = (low[axis].min(x[axis]), high[axis].max(x[axis])));
    }
    let mut tags = [0; 4];
    for (dimension, groups) in entities.clone() {
        tags[*dimension] += 1;
        out.int(tags[*dimension])?;
        out.place(low)?;
        if *dimension > 0 {
            out.place(high)?;
        }
        out.size(groups.len())?;
        groups.iter().try_for_each(|group| out.int(group + 1))?;
        if *dimension > 0 {
            // No boundary is known.
            out.size(0)?;
        }
        out.end()?;
    }
    out.close("Entities")
}

fn ends(ids: impl Iterator<Item = u32> + Clone) -> (usize, usize) {
    (ids.clone().min().unwrap_or(0) as usize, ids.max().unwrap_or(0) as usize)
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
