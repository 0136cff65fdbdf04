//! A part of a mesh as a data set.

use crate::io::dataset::{CellsOf, Dataset, Field, FieldData};
use crate::model::{Cells, Members, Model, ModelPart};
use crate::parameters::Settings;
use crate::processes::quantity::Quantity;
use crate::variables::Fields;

/// Which cells of a part are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellKind {
    /// The elements, or the conditions of a part without elements.
    Automatic,
    /// The elements.
    Elements,
    /// The conditions.
    Conditions,
}

impl CellKind {
    /// From `entity_type`.
    pub fn read(settings: &Settings) -> Self {
        match settings.text("entity_type") {
            "element" => Self::Elements,
            "condition" => Self::Conditions,
            _ => Self::Automatic,
        }
    }
}

/// Names of the parts directly below the part with this dotted path.
pub fn direct_parts(model: &Model, path: &str) -> Vec<String> {
    let (root, below) = path.split_once('.').map_or((path, None), |(root, below)| (root, Some(below)));
    let children = model.part(root).and_then(|root| match below {
        None => Some(&root.children),
        Some(below) => root.find(below).map(|part| &part.children),
    });
    children.map_or(Vec::new(), |children| children.iter().map(|child| child.name.clone()).collect())
}

/// The nodes and cells of a part, with `[nodal, elemental, conditional]` quantities and, with `ids`, the ids of
/// nodes, cells and properties under the names that Kratos gives them.
///
/// Nodes of shown cells that the part does not list are added.
pub fn mesh_dataset(
    part: &ModelPart,
    members: &Members,
    kind: CellKind,
    ids: bool,
    [nodal, elemental, conditional]: [&[Quantity]; 3],
) -> Dataset {
    let conditions = match kind {
        CellKind::Automatic => members.elements.is_empty(),
        CellKind::Elements => false,
        CellKind::Conditions => true,
    };
    let (cells, chosen, id_name) = if conditions {
        (&part.conditions, &members.conditions, "KRATOS_CONDITION_ID")
    } else {
        (&part.elements, &members.elements, "KRATOS_ELEMENT_ID")
    };
    let nodes = shown_nodes(part, members, cells, chosen);
    let mut data = Dataset::vertices(nodes.iter().map(|&n| part.nodes.coordinates[n as usize]).collect());
    data.cells = mesh(cells, chosen, &nodes, part.nodes.len());
    data.point_fields = fields(nodal, &part.node_fields, &nodes);
    data.cell_fields = match conditions {
        true => fields(conditional, &part.condition_fields, chosen),
        false => fields(elemental, &part.element_fields, chosen),
    };
    if ids {
        data.point_fields.push(numbers("KRATOS_NODE_ID", &part.nodes.ids, &nodes));
        data.cell_fields.push(numbers("PROPERTIES_ID", &cells.properties, chosen));
        data.cell_fields.push(numbers(id_name, &cells.ids, chosen));
    }
    data
}

/// Indices of the part's nodes and those of its cells, ascending.
fn shown_nodes(part: &ModelPart, members: &Members, cells: &Cells, chosen: &[u32]) -> Vec<u32> {
    let mut shown = vec![false; part.nodes.len()];
    members.nodes.iter().for_each(|&node| shown[node as usize] = true);
    for &cell in chosen {
        cells.nodes_of(cell as usize).iter().for_each(|&node| shown[node as usize] = true);
    }
    (0..part.nodes.len() as u32).filter(|&node| shown[node as usize]).collect()
}

fn mesh(cells: &Cells, chosen: &[u32], nodes: &[u32], node_count: usize) -> CellsOf {
    let mut number = vec![0; node_count];
    nodes.iter().enumerate().for_each(|(i, &node)| number[node as usize] = i as u32);
    let (mut starts, mut list, mut types) = (vec![0], Vec::new(), Vec::new());
    for &cell in chosen {
        list.extend(cells.nodes_of(cell as usize).iter().map(|&node| number[node as usize]));
        starts.push(list.len() as u32);
        types.push(cells.shapes[cell as usize].vtk_type());
    }
    CellsOf::Mesh { starts, nodes: list, types }
}

fn fields(quantities: &[Quantity], fields: &Fields, chosen: &[u32]) -> Vec<Field> {
    let field = |quantity: &Quantity| {
        let components = quantity.width(fields);
        let mut values = Vec::with_capacity(components * chosen.len());
        chosen.iter().for_each(|&i| quantity.append(fields, i as usize, &mut values));
        Field { name: quantity.name.clone(), components, values: FieldData::F64(values) }
    };
    quantities.iter().map(field).collect()
}

fn numbers(name: &str, ids: &[u32], chosen: &[u32]) -> Field {
    let values = chosen.iter().map(|&i| ids[i as usize] as i32).collect();
    Field { name: name.into(), components: 1, values: FieldData::I32(values) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Shape;
    use crate::model::SubModelPart;
    use crate::parameters::{Document, Parameters};
    use crate::variables::Variable;
    use std::path::Path;

    const SPEED: Variable = Variable::vector("SPEED", "m/s", "speed");

    /// Two triangles of a unit square and a line; a part with the second triangle and the line.
    fn model() -> Model {
        let mut part = ModelPart::new("Grid");
        for (i, corner) in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].iter().enumerate() {
            part.nodes.ids.push(10 + i as u32);
            part.nodes.coordinates.push([corner[0], corner[1], 0.0]);
        }
        part.elements.push(5, "Element2D3N", Shape::Triangle3, 1, &[0, 1, 2]);
        part.elements.push(7, "Element2D3N", Shape::Triangle3, 2, &[0, 2, 3]);
        part.conditions.push(1, "LineCondition2D2N", Shape::Line2, 0, &[2, 3]);
        let child = SubModelPart { name: "Half".into(), nodes: vec![2], elements: vec![1], ..SubModelPart::default() };
        let edge = SubModelPart { name: "Edge".into(), conditions: vec![0], ..SubModelPart::default() };
        part.children = vec![child, edge];
        part.node_fields.vector_mut(&SPEED, 4)[2] = [1.0, 2.0, 3.0];
        let mut model = Model::default();
        model.insert(part);
        model
    }

    fn speed(name: &str, component: Option<usize>) -> Quantity {
        let place = Parameters::root(Document::parse(Path::new("p.json"), "{}".into()).unwrap());
        Quantity { name: name.into(), variable: SPEED, component, place }
    }

    #[test]
    fn parts_are_renumbered_and_carry_their_values() {
        let model = model();
        let part = model.part("Grid").unwrap();
        let quantities = [speed("SPEED", None), speed("SPEED_Y", Some(1))];
        let members = model.members("Grid.Half").unwrap();
        let data = mesh_dataset(part, &members, CellKind::Automatic, true, [&quantities, &[], &[]]);
        assert_eq!(data.points, [[0.0; 3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(data.cells, CellsOf::Mesh { starts: vec![0, 3], nodes: vec![0, 1, 2], types: vec![5] });
        let zeros = [0.0; 3];
        assert_eq!(data.point_fields[0].values, FieldData::F64([zeros, [1.0, 2.0, 3.0], zeros].concat()));
        assert_eq!(data.point_fields[1].values, FieldData::F64(vec![0.0, 2.0, 0.0]));
        assert_eq!(data.point_fields[2].values, FieldData::I32(vec![10, 12, 13]));
        assert_eq!(data.cell_fields[0].values, FieldData::I32(vec![2]));
        assert_eq!(data.cell_fields[1].values, FieldData::I32(vec![7]));
        assert_eq!(data.check(), Ok(()));
    }

    #[test]
    fn conditions_are_shown_where_there_are_no_elements_or_when_asked_for() {
        let model = model();
        let part = model.part("Grid").unwrap();
        for (path, kind, types) in [
            ("Grid.Edge", CellKind::Automatic, vec![3]),
            ("Grid", CellKind::Conditions, vec![3]),
            ("Grid", CellKind::Automatic, vec![5, 5]),
            ("Grid.Edge", CellKind::Elements, vec![]),
        ] {
            let data = mesh_dataset(part, &model.members(path).unwrap(), kind, false, [&[], &[], &[]]);
            assert!(matches!(&data.cells, CellsOf::Mesh { types: found, .. } if *found == types), "{path} {kind:?}");
            assert_eq!(data.check(), Ok(()));
        }
        assert_eq!(direct_parts(&model, "Grid"), ["Half", "Edge"]);
        assert!(direct_parts(&model, "Grid.Half").is_empty() && direct_parts(&model, "Sea").is_empty());
    }
}
