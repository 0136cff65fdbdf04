//! A model part as an unstructured grid of VTK, and back.
//!
//! Cells stand in the order elements, conditions, geometries. Fields of integers hold what a grid has no words
//! for: `NODE_ID` and `CELL_ID`, `PROPERTIES_ID`, and zeros and ones under `Element NAME`, `Condition NAME`,
//! `Geometry NAME` for the kinds of cells and under `Part PATH` for the members of sub model parts, on points
//! and on cells. Viewers show them, and readers get everything back.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::geometry::Shape;
use crate::io::dataset::{CellsOf, Dataset, Field, FieldData};
use crate::io::mdpa::{Category, CellNames};
use crate::model::{Cells, ModelPart, Properties, SubModelPart, Value};
use std::collections::BTreeSet;
use std::path::Path;

const KINDS: [(&str, Category); 3] =
    [("Element ", Category::Element), ("Condition ", Category::Condition), ("Geometry ", Category::Geometry)];
const PART: &str = "Part ";

fn lists(part: &ModelPart) -> [&Cells; 3] {
    [&part.elements, &part.conditions, &part.geometries]
}

fn integers(name: String, values: Vec<i32>) -> Field {
    Field { name, components: 1, values: FieldData::I32(values) }
}

/// Zeros, and ones at these places.
fn mask(name: String, count: usize, places: impl Iterator<Item = usize>) -> Field {
    let mut values = vec![0; count];
    places.for_each(|place| values[place] = 1);
    integers(name, values)
}

/// The grid of a model part.
pub(super) fn dataset(part: &ModelPart) -> Dataset {
    let cells = lists(part);
    let (mut starts, mut nodes, mut types) = (vec![0], Vec::new(), Vec::new());
    let (mut ids, mut properties) = (Vec::new(), Vec::new());
    for list in cells {
        for cell in 0..list.len() {
            nodes.extend_from_slice(list.nodes_of(cell));
            starts.push(nodes.len() as u32);
            types.push(list.shapes[cell].vtk_type());
        }
        ids.extend(list.ids.iter().map(|&id| id as i32));
        properties.extend(list.properties.iter().map(|&id| id as i32));
    }
    let first = [0, cells[0].len(), cells[0].len() + cells[1].len()];
    let count = types.len();
    let mut data = Dataset::vertices(part.nodes.coordinates.clone());
    data.cells = CellsOf::Mesh { starts, nodes, types };
    data.point_fields.push(integers("NODE_ID".into(), part.nodes.ids.iter().map(|&id| id as i32).collect()));
    data.cell_fields.push(integers("CELL_ID".into(), ids));
    data.cell_fields.push(integers("PROPERTIES_ID".into(), properties));
    for ((list, (kind, _)), first) in cells.into_iter().zip(KINDS).zip(first) {
        for (index, name) in list.names.iter().enumerate() {
            let members = (0..list.len()).filter(|&cell| list.kinds[cell] as usize == index).map(|cell| first + cell);
            data.cell_fields.push(mask(format!("{kind}{name}"), count, members));
        }
    }
    for path in part.paths() {
        let Some(sub) = part.find(&path) else { continue };
        let members = [&sub.elements, &sub.conditions, &sub.geometries].into_iter().zip(first);
        let members = members.flat_map(|(list, first)| list.iter().map(move |&cell| first + cell as usize));
        data.cell_fields.push(mask(format!("{PART}{path}"), count, members));
        let members = sub.nodes.iter().map(|&node| node as usize);
        data.point_fields.push(mask(format!("{PART}{path}"), part.nodes.len(), members));
    }
    data.point_fields.extend(part.nodal_data.iter().filter_map(|(name, rows)| {
        let rows = rows.iter().map(|(node, fixed, value)| (*node, *fixed, value));
        whole_field(name, rows, part.nodes.len())
    }));
    data
}

/// Data of every node, free, as a field; none otherwise.
fn whole_field<'a>(name: &str, rows: impl Iterator<Item = (u32, bool, &'a Value)>, count: usize) -> Option<Field> {
    let (mut values, mut next) = (Vec::new(), 0);
    for (node, fixed, value) in rows {
        let before = values.len();
        match value {
            Value::Number(number) => values.push(*number),
            Value::Vector(numbers) => values.extend(numbers),
            _ => return None,
        }
        // Rows of one length, one for each node in their order.
        let same = next == 0 || (values.len() - before) * next as usize == before;
        if fixed || node != next || !same {
            return None;
        }
        next += 1;
    }
    let components = values.len().checked_div(count)?;
    let whole = next as usize == count && components > 0;
    whole.then(|| Field { name: name.into(), components, values: FieldData::F64(values) })
}

/// What a model part holds and the grid does not, in words.
pub(super) fn losses(part: &ModelPart) -> Vec<String> {
    let mut losses = Vec::new();
    if part.properties.values().any(|p| p.law.is_some() || !p.values.is_empty() || !p.tables.is_empty()) {
        losses.push("constants of properties; their ids are kept".to_string());
    }
    if !part.tables.is_empty() {
        losses.push(format!("{} tables", part.tables.len()));
    }
    for (name, rows) in &part.nodal_data {
        let rows = rows.iter().map(|(node, fixed, value)| (*node, *fixed, value));
        if whole_field(name, rows, part.nodes.len()).is_none() {
            losses.push(format!("data {name}: not of every node, fixed, or no numbers"));
        }
    }
    for name in part.elemental_data.keys().chain(part.conditional_data.keys()) {
        losses.push(format!("data {name} of elements or conditions"));
    }
    losses
}

/// A grid with its masks by name.
struct Grid<'a> {
    data: &'a Dataset,
    starts: &'a [u32],
    nodes: &'a [u32],
    types: &'a [u8],
}

/// Values of a field of integers.
fn find<'a>(fields: &'a [Field], name: &str) -> Option<&'a [i32]> {
    fields.iter().find_map(|field| match &field.values {
        FieldData::I32(values) if field.name == name && field.components == 1 => Some(values.as_slice()),
        _ => None,
    })
}

/// The model part of a grid. Without fields that say otherwise, cells of the highest dimension become elements
/// called by their shapes after `prefix`, the others geometries, and numbers ids.
pub(super) fn model_part(
    data: Dataset,
    prefix: &str,
    kinds: &dyn CellNames,
    path: &Path,
) -> Result<ModelPart, InputErrors> {
    let told = |message: String| InputErrors::from(Diagnostic::error(Place::file(path), message));
    let CellsOf::Mesh { starts, nodes, types } = &data.cells else {
        return Err(told("the grid holds no cells".into()));
    };
    let grid = Grid { data: &data, starts, nodes, types };
    let mut part = ModelPart::new("Mesh");
    part.nodes.coordinates = data.points.clone();
    part.nodes.ids = ids(find(&data.point_fields, "NODE_ID"), data.points.len(), "NODE_ID").map_err(told)?;
    if !part.nodes.ids.is_sorted_by(|a, b| a < b) {
        return Err(told("the numbers NODE_ID do not ascend".into()));
    }
    let places = grid.fill(&mut part, prefix, kinds).map_err(told)?;
    let used: BTreeSet<u32> = lists(&part).into_iter().flat_map(|list| list.properties.iter().copied()).collect();
    part.properties = used.into_iter().map(|id| (id, Properties { id, ..Properties::default() })).collect();
    part.properties.entry(0).or_default();
    grid.sub_model_parts(&mut part, &places);
    grid.fields(&mut part);
    Ok(part)
}

/// Ids of a field, or 1, 2, …
fn ids(field: Option<&[i32]>, count: usize, name: &str) -> Result<Vec<u32>, String> {
    let Some(values) = field else { return Ok((1..=count as u32).collect()) };
    let id = |&value: &i32| match value as u32 {
        0 => Err(format!("the field {name} holds 0, which is no id")),
        id => Ok(id),
    };
    values.iter().map(id).collect()
}

impl Grid<'_> {
    /// Adds the cells to the part; gives for each its category and index.
    fn fill(&self, part: &mut ModelPart, prefix: &str, kinds: &dyn CellNames) -> Result<Vec<(usize, u32)>, String> {
        let fields = &self.data.cell_fields;
        let shapes = self.types.iter().map(|&t| shape(t)).collect::<Result<Vec<Shape>, String>>()?;
        let dimension = shapes.iter().map(|shape| shape.dimension()).max().unwrap_or(0);
        let cell_ids = find(fields, "CELL_ID");
        let own_ids = ids(cell_ids, shapes.len(), "CELL_ID")?;
        let properties = find(fields, "PROPERTIES_ID");
        let named: Vec<(usize, &str, &[i32])> = fields
            .iter()
            .filter_map(|field| {
                let at = KINDS.iter().position(|(kind, _)| field.name.starts_with(kind))?;
                Some((at, &field.name[KINDS[at].0.len()..], find(fields, &field.name)?))
            })
            .collect();
        let mut places = Vec::with_capacity(shapes.len());
        for (cell, &shape) in shapes.iter().enumerate() {
            let nodes = &self.nodes[self.starts[cell] as usize..self.starts[cell + 1] as usize];
            if nodes.len() != shape.node_count() {
                return Err(format!(
                    "the cell {cell} has {} nodes, a {} has another number",
                    nodes.len(),
                    shape.name()
                ));
            }
            let named = named.iter().find(|(_, _, mask)| mask[cell] != 0);
            let (category, name) = match named {
                Some((category, name, _)) => (*category, (*name).to_string()),
                None if shape.dimension() == dimension => {
                    (0, format!("{prefix}{}D{}N", shape.dimension(), shape.node_count()))
                }
                None => (2, crate::io::gmsh::geometry(shape, dimension)),
            };
            if named.is_some() && category < 2 && kinds.shape(KINDS[category].1, &name) != Some(shape) {
                return Err(format!("the cell {cell} is of the kind {name:?}, which is not registered with its shape"));
            }
            let list = match category {
                0 => &mut part.elements,
                1 => &mut part.conditions,
                _ => &mut part.geometries,
            };
            let id = if cell_ids.is_some() { own_ids[cell] } else { list.len() as u32 + 1 };
            if list.ids.last().is_some_and(|last| *last >= id) {
                return Err(format!("the numbers CELL_ID do not ascend at the cell {cell}"));
            }
            places.push((category, list.len() as u32));
            list.push(id, &name, shape, properties.map_or(0, |ids| ids[cell] as u32), nodes);
        }
        Ok(places)
    }

    /// Parts in the order of the fields; parents stand before their children.
    fn sub_model_parts(&self, part: &mut ModelPart, places: &[(usize, u32)]) {
        for field in self.data.cell_fields.iter().filter(|field| field.name.starts_with(PART)) {
            let path = &field.name[PART.len()..];
            let (Some(cells), Some(points)) =
                (find(&self.data.cell_fields, &field.name), find(&self.data.point_fields, &field.name))
            else {
                continue;
            };
            let (above, name) = path.rsplit_once('.').map_or((None, path), |(above, name)| (Some(above), name));
            let mut sub = SubModelPart { name: name.into(), ..SubModelPart::default() };
            sub.nodes = (0..points.len() as u32).filter(|&node| points[node as usize] != 0).collect();
            for (&(category, index), _) in places.iter().zip(cells).filter(|(_, mask)| **mask != 0) {
                [&mut sub.elements, &mut sub.conditions, &mut sub.geometries][category].push(index);
            }
            let siblings = match above {
                None => Some(&mut part.children),
                Some(above) => find_mut(&mut part.children, above).map(|parent| &mut parent.children),
            };
            if let Some(siblings) = siblings {
                siblings.push(sub);
            }
        }
    }

    /// Fields of others become data of nodes and elements.
    fn fields(&self, part: &mut ModelPart) {
        let value = |field: &Field, row: usize| {
            let range = row * field.components..(row + 1) * field.components;
            let numbers: Vec<f64> = match &field.values {
                FieldData::F64(values) => values[range].to_vec(),
                FieldData::I32(values) => values[range].iter().map(|&value| f64::from(value)).collect(),
            };
            if let [number] = numbers[..] { Value::Number(number) } else { Value::Vector(numbers) }
        };
        let ours = |name: &str| {
            ["NODE_ID", "CELL_ID", "PROPERTIES_ID"].contains(&name)
                || name.starts_with(PART)
                || KINDS.iter().any(|(kind, _)| name.starts_with(kind))
        };
        for field in self.data.point_fields.iter().filter(|field| !ours(&field.name)) {
            let rows = (0..part.nodes.len()).map(|node| (node as u32, false, value(field, node))).collect();
            part.nodal_data.insert(variable(&field.name), rows);
        }
        // Elements come first among the cells only where the file is ours or has no others.
        if self.types.len() == part.elements.len() {
            for field in self.data.cell_fields.iter().filter(|field| !ours(&field.name)) {
                let rows = (0..part.elements.len()).map(|cell| (cell as u32, value(field, cell))).collect();
                part.elemental_data.insert(variable(&field.name), rows);
            }
        }
    }
}

/// A name that is one word.
fn variable(name: &str) -> String {
    name.replace(|c: char| c.is_whitespace(), "_")
}

fn find_mut<'a>(parts: &'a mut [SubModelPart], path: &str) -> Option<&'a mut SubModelPart> {
    let (first, below) = path.split_once('.').map_or((path, None), |(first, below)| (first, Some(below)));
    let part = parts.iter_mut().find(|part| part.name == first)?;
    match below {
        None => Some(part),
        Some(below) => find_mut(&mut part.children, below),
    }
}

fn shape(number: u8) -> Result<Shape, String> {
    Shape::ALL.into_iter().find(|shape| shape.vtk_type() == number).ok_or_else(|| {
        let known: Vec<&str> = Shape::ALL.iter().map(|shape| shape.name()).collect();
        format!("the grid holds cells of the type {number} of VTK; read are: {}", known.join(", "))
    })
}
