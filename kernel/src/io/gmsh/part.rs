//! From what the file says to a model part: ids become indices, groups sub model parts.

use super::{RawCell, RawMesh};
use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::geometry::Shape;
use crate::model::{Cells, ModelPart, Properties, SubModelPart};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;

/// Faults that are shown; the rest is counted.
const SHOWN: usize = 20;

/// A cell with node indices.
struct Cell {
    raw: RawCell,
    nodes: Vec<u32>,
}

pub(super) fn model_part(raw: RawMesh, name: &str, prefix: &str, path: &Path) -> Result<ModelPart, InputErrors> {
    let mut errors = InputErrors::default();
    let mut faults = 0;
    let mut fault = |message: String| {
        faults += 1;
        if faults <= SHOWN {
            errors.push(Diagnostic::error(Place::file(path), message));
        }
    };
    let dimension = raw.cells.iter().map(|cell| cell.kind.0.dimension()).max().unwrap_or(0);
    if dimension == 0 {
        fault("the mesh has no lines, faces or solids".into());
    }
    let cells = merge_twins(raw.cells);
    let known: HashSet<u32> = raw.nodes.iter().map(|(id, _)| *id).collect();
    for cell in &cells {
        if let Some(id) = cell.nodes.iter().find(|id| !known.contains(id)) {
            fault(format!("the cell {} holds the node {id}, which does not exist", cell.id));
        }
    }
    let held: HashSet<u32> = cells.iter().flat_map(|cell| cell.nodes.iter().copied()).collect();
    let mut nodes = raw.nodes;
    nodes.sort_by_key(|(id, _)| *id);
    nodes.dedup();
    for pair in nodes.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        fault(format!("the node {} stands twice, at different places", pair[0].0));
    }
    if faults > SHOWN {
        errors.push(Diagnostic::error(Place::file(path), format!("and {} more errors", faults - SHOWN)));
    }
    errors.or(())?;

    let all = nodes.len();
    nodes.retain(|(id, _)| held.contains(id));
    let mut part = ModelPart::new(name);
    part.properties.insert(0, Properties::default());
    (part.nodes.ids, part.nodes.coordinates) = nodes.into_iter().unzip();
    let index = ModelPart::index_map(&part.nodes.ids);
    let indices = |raw: &RawCell| raw.nodes.iter().filter_map(|id| index.get(id).copied()).collect();
    let mut cells: Vec<Cell> = cells.into_iter().map(|raw| Cell { nodes: indices(&raw), raw }).collect();
    cells.sort_by_key(|cell| cell.raw.id);
    let turned = if dimension == 2 { turn_over(&mut cells, &part.nodes.coordinates) } else { 0 };
    let groups = fill(&mut part, &cells, dimension, prefix);
    part.children = sub_model_parts(groups, &raw.names, dimension, &part);
    tracing::debug!(
        "{}: {} nodes without a cell left out, {turned} cells turned over",
        path.display(),
        all - held.len()
    );
    Ok(part)
}

/// Format 2.2 writes a cell once for each of its groups, under another id.
fn merge_twins(cells: Vec<RawCell>) -> Vec<RawCell> {
    let mut first: HashMap<(usize, Vec<u32>), usize> = HashMap::new();
    let mut merged: Vec<RawCell> = Vec::with_capacity(cells.len());
    for cell in cells {
        let mut key = cell.nodes.clone();
        key.sort_unstable();
        match first.get(&(cell.kind.0.dimension(), key.clone())) {
            Some(&twin) => merged[twin].groups.extend(cell.groups),
            None => {
                first.insert((cell.kind.0.dimension(), key), merged.len());
                merged.push(cell);
            }
        }
    }
    merged
}

/// Makes faces of plane meshes counter-clockwise; gives how many were not.
fn turn_over(cells: &mut [Cell], coordinates: &[[f64; 3]]) -> usize {
    let is_plane = coordinates.iter().all(|x| x[2] == 0.0);
    let mut turned = 0;
    for cell in cells.iter_mut().filter(|cell| is_plane && cell.raw.kind.0.dimension() == 2) {
        let corners: Vec<[f64; 3]> = cell.nodes.iter().map(|&node| coordinates[node as usize]).collect();
        if cell.raw.kind.0.plane_area(&corners) < 0.0 {
            cell.nodes[1..].reverse();
            turned += 1;
        }
    }
    turned
}

/// Indices of the elements and geometries of each group.
type Groups = BTreeMap<(usize, i32), Vec<u32>>;

/// Cells of the highest dimension as elements, the others as geometries.
fn fill(part: &mut ModelPart, cells: &[Cell], dimension: usize, prefix: &str) -> Groups {
    let mut groups = Groups::new();
    let mut used = [0u32, 0];
    for cell in cells {
        let shape = cell.raw.kind.0;
        let is_element = shape.dimension() == dimension;
        let name = if is_element { element(prefix, shape) } else { geometry(shape, dimension) };
        let list: &mut Cells = if is_element { &mut part.elements } else { &mut part.geometries };
        // Ids of the file may have been given twice, to elements and to points for instance.
        let last = &mut used[usize::from(is_element)];
        *last = (*last + 1).max(cell.raw.id);
        let index = list.len() as u32;
        list.push(*last, &name, shape, 0, &cell.nodes);
        for &group in cell.raw.groups.iter().collect::<BTreeSet<_>>() {
            groups.entry((shape.dimension(), group)).or_default().push(index);
        }
    }
    groups
}

fn element(prefix: &str, shape: Shape) -> String {
    format!("{prefix}{}D{}N", shape.dimension(), shape.node_count())
}

/// Kratos's name of a geometry, such as `Line2D2`.
pub(crate) fn geometry(shape: Shape, space: usize) -> String {
    let name = match shape {
        Shape::Point1 => return format!("Point{space}D"),
        Shape::Line2 => "Line",
        Shape::Triangle3 => "Triangle",
        Shape::Quadrilateral4 => "Quadrilateral",
        Shape::Tetrahedron4 => "Tetrahedra",
        Shape::Hexahedron8 => "Hexahedra",
    };
    format!("{name}{space}D{}", shape.node_count())
}

fn sub_model_parts(
    groups: Groups,
    names: &BTreeMap<(usize, i32), String>,
    dimension: usize,
    part: &ModelPart,
) -> Vec<SubModelPart> {
    let mut parts: Vec<SubModelPart> = Vec::new();
    for ((of_group, tag), indices) in groups {
        let unnamed = || format!("{}_{tag}", ["Point", "Line", "Surface", "Volume"][of_group.min(3)]);
        let name = names.get(&(of_group, tag)).cloned().unwrap_or_else(unnamed);
        let at = parts.iter().position(|known| known.name == name).unwrap_or_else(|| {
            parts.push(SubModelPart { name, ..SubModelPart::default() });
            parts.len() - 1
        });
        let is_element = of_group == dimension;
        let cells = if is_element { &part.elements } else { &part.geometries };
        parts[at].nodes.extend(indices.iter().flat_map(|&cell| cells.nodes_of(cell as usize)));
        if is_element { parts[at].elements.extend(indices) } else { parts[at].geometries.extend(indices) }
    }
    for part in &mut parts {
        for list in [&mut part.nodes, &mut part.elements, &mut part.geometries] {
            list.sort_unstable();
            list.dedup();
        }
    }
    parts
}
