//! Tests of the meshes that modelers make.

mod bodies;
mod grids;
mod inputs;
mod surfaces;

use super::mesh::{Mesh, faces};
use crate::diagnostic::InputErrors;
use crate::geometry::{Shape, check_cells};
use crate::io::mdpa::Category;
use crate::model::{Cells, Model, ModelPart};
use crate::parameters::{Document, Parameters};
use crate::processes::RunOptions;
use crate::registry::Registry;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A registry with the names that the tests use.
fn registry() -> Registry {
    let mut registry = Registry::default();
    super::register(&mut registry);
    registry.body_mesh("Initial_MPM_Material", "MPMUpdatedLagrangian");
    for (name, shape) in [
        ("Element1D2N", Shape::Line2),
        ("Element2D3N", Shape::Triangle3),
        ("Element2D4N", Shape::Quadrilateral4),
        ("Element3D4N", Shape::Tetrahedron4),
        ("Element3D8N", Shape::Hexahedron8),
        ("MPMUpdatedLagrangian1D2N", Shape::Line2),
        ("MPMUpdatedLagrangian2D3N", Shape::Triangle3),
        ("MPMUpdatedLagrangian2D4N", Shape::Quadrilateral4),
        ("MPMUpdatedLagrangian3D4N", Shape::Tetrahedron4),
        ("MPMUpdatedLagrangian3D8N", Shape::Hexahedron8),
    ] {
        registry.cell(Category::Element, name, shape);
    }
    for (name, shape) in [
        ("Point", Shape::Point1),
        ("Line", Shape::Line2),
        ("Face3", Shape::Triangle3),
        ("Face4", Shape::Quadrilateral4),
    ] {
        registry.cell(Category::Condition, name, shape);
    }
    registry
}

/// The model that these modelers make.
fn build(modelers: Value) -> Result<Model, InputErrors> {
    let document = Document::parse(Path::new("p.json"), serde_json::to_string_pretty(&modelers).unwrap())?;
    let root = Parameters::root(document);
    let registry = registry();
    let options = RunOptions { folder: PathBuf::new(), output: PathBuf::new(), kratos_exact: false };
    let mut errors = InputErrors::default();
    let mut made = Vec::new();
    for block in root.entries() {
        made.extend(errors.absorb(registry.build_modeler(&block, &root, &options)));
    }
    errors.or(())?;
    let mut model = Model::default();
    for modeler in &mut made {
        modeler.setup_geometry(&mut model, &registry)?;
    }
    for modeler in &mut made {
        modeler.setup_model_part(&mut model, &registry)?;
    }
    Ok(model)
}

fn grid(parameters: Value) -> ModelPart {
    let model = build(json!([{"name": "Modelers.Bia.RegularGridModeler", "parameters": parameters}])).unwrap();
    model.part("Background_Grid").unwrap().clone()
}

fn bodies(list: Value) -> ModelPart {
    let model = build(json!([{"name": "Modelers.Bia.BodyModeler", "parameters": {"bodies": list}}])).unwrap();
    model.part("Initial_MPM_Material").unwrap().clone()
}

fn body(mut entry: Value) -> ModelPart {
    entry["name"] = "Body".into();
    bodies(json!([entry]))
}

/// Length, area or volume of all elements.
fn measure(part: &ModelPart) -> f64 {
    let of = |cell: usize| {
        let (shape, corners) = (part.elements.shapes[cell], part.corners(&part.elements, cell));
        if shape.dimension() == 2 { shape.plane_area(&corners) } else { shape.measure(&corners) }
    };
    (0..part.elements.len()).map(of).sum()
}

/// Normal of a line or face times its length or area; of warped faces the exact integral.
fn area_vector(corners: &[[f64; 3]]) -> [f64; 3] {
    let edge = |a: usize, b: usize| -> [f64; 3] { std::array::from_fn(|i| corners[b][i] - corners[a][i]) };
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]].map(|x| 0.5 * x)
    };
    match corners.len() {
        2 => [edge(0, 1)[1], -edge(0, 1)[0], 0.0],
        3 => cross(edge(0, 1), edge(0, 2)),
        _ => cross(edge(0, 2), edge(1, 3)),
    }
}

/// Faults of a mesh: cells that `check_cells` refuses, faces that more than two cells hold, two
/// cells on the same side of a face, nodes without a cell, nodes at the same place, a boundary
/// that is not closed. The outward normals must sum to nothing, and by the divergence theorem
/// their moments must give the measure (but for warped faces, whose moments are not looked at).
fn check_mesh(part: &ModelPart) {
    let space = part.elements.shapes.iter().map(|shape| shape.dimension()).max().unwrap_or(0);
    assert_eq!(check_cells(part, &part.elements, space), [], "{}", part.name);
    let shape = part.elements.shapes[0];
    let dimension = shape.dimension() as f64;
    let mut owners: HashMap<Vec<u32>, Vec<Vec<u32>>> = HashMap::new();
    for cell in 0..part.elements.len() {
        assert_eq!(part.elements.shapes[cell], shape);
        let nodes = part.elements.nodes_of(cell);
        for face in faces(shape) {
            let face: Vec<u32> = face.iter().map(|&corner| nodes[corner]).collect();
            let mut key = face.clone();
            key.sort_unstable();
            owners.entry(key).or_default().push(face);
        }
    }
    let (mut closure, mut moment, mut size, mut planar) = ([0.0; 3], 0.0, 0.0, true);
    for faces in owners.values() {
        let vector = |face: &[u32]| {
            let corners: Vec<[f64; 3]> = face.iter().map(|&n| part.nodes.coordinates[n as usize]).collect();
            let middle: [f64; 3] =
                std::array::from_fn(|i| corners.iter().map(|c| c[i]).sum::<f64>() / corners.len() as f64);
            let normal = area_vector(&corners);
            let off = corners.iter().map(|c| (0..3).map(|i| (c[i] - middle[i]) * normal[i]).sum::<f64>().abs());
            (normal, middle, off.fold(0.0, f64::max))
        };
        match faces.as_slice() {
            [face] => {
                let (normal, middle, off) = vector(face);
                (0..3).for_each(|i| closure[i] += normal[i]);
                moment += (0..3).map(|i| normal[i] * middle[i]).sum::<f64>() / dimension;
                let area = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
                size += area;
                planar &= off <= 1e-12 * area || is_parallelogram(part, face);
            }
            [one, two] => {
                let (one, two) = (vector(one).0, vector(two).0);
                let sum: f64 = (0..3).map(|i| (one[i] + two[i]).abs()).sum();
                let size: f64 = one.iter().map(|n| n.abs()).sum();
                assert!(sum <= 1e-12 * size, "two cells on the same side of a face");
            }
            more => panic!("{} cells hold a face", more.len()),
        }
    }
    assert!(closure.iter().all(|sum| sum.abs() <= 1e-13 * size), "the boundary is open: {closure:?}");
    if planar && shape.is_affine() {
        let volume = measure(part);
        assert!((moment - volume).abs() <= 1e-12 * volume, "normals point inwards: {moment} for {volume}");
    } else {
        assert!(moment > 0.0);
    }
    let mut used: Vec<u32> = part.elements.nodes.clone();
    used.sort_unstable();
    used.dedup();
    assert_eq!(used.len(), part.nodes.len(), "nodes without a cell");
    let place = |x: &[f64; 3]| x.map(|x| (x * 1e9).round() as i64);
    let places: std::collections::HashSet<[i64; 3]> = part.nodes.coordinates.iter().map(place).collect();
    assert_eq!(places.len(), part.nodes.len(), "two nodes at one place");
}

fn is_parallelogram(part: &ModelPart, face: &[u32]) -> bool {
    let x = |i: usize| part.nodes.coordinates[face[i] as usize];
    face.len() < 4 || (0..3).all(|i| (x(0)[i] + x(2)[i] - x(1)[i] - x(3)[i]).abs() < 1e-12)
}

/// Sum of the area vectors of conditions.
fn sum_of_normals(part: &ModelPart, cells: &Cells, indices: &[u32]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for &index in indices {
        let vector = area_vector(&part.corners(cells, index as usize));
        (0..3).for_each(|i| sum[i] += vector[i]);
    }
    sum
}

fn close(a: f64, b: f64, relative: f64) {
    assert!((a - b).abs() <= relative * b.abs().max(1e-300), "{a} is not {b} within {relative:e}");
}

#[test]
fn boundaries_of_all_shapes_are_seen_from_outside() {
    let line = vec![0.0, 1.0, 3.0];
    for dimension in 1..=3 {
        let mesh = Mesh::lattice(&vec![line.clone(); dimension]);
        let faces = mesh.boundary(|_| true);
        assert_eq!(faces.len(), [2, 8, 24][dimension - 1]);
    }
}

/// A plate that Gmsh wrote, with loads on its floor.
#[test]
fn meshes_of_gmsh_become_elements_and_conditions() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/gmsh/plate_4.1_binary.msh");
    let model = build(json!([
        {"name": "ImportGmshModeler", "parameters": {"input_filename": file, "model_part_name": "Background_Grid"}},
        {"name": "CreateEntitiesFromGeometriesModeler", "parameters": {"conditions_list": [
            {"model_part_name": "Background_Grid.Floor of plate", "condition_name": "Line"}]}}]));
    let model = model.unwrap();
    let part = model.part("Background_Grid").unwrap();
    assert_eq!(part.find("Floor of plate").unwrap().conditions.len(), 11);
    assert_eq!(part.elements.names, ["Element2D3N", "Element2D4N"]);
    assert_eq!(part.paths(), ["Corner", "Floor of plate", "Holed", "Whole", "Both"]);
    let missing = build(json!([{"name": "ImportGmshModeler", "parameters": {"input_filename": "no.msh",
        "model_part_name": "Background_Grid"}}]));
    assert!(missing.err().unwrap().to_string().contains("no.msh: the mesh file cannot be read"));
}
