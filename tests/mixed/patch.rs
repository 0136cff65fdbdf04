//! Patch tests on distorted grids: an affine displacement and its constant pressure, a constant pressure
//! of an incompressible solid, and the linear pressure of a column at rest under its weight.

use super::common::{Cell, Mesh, Scene, fix, gravity, largest_difference, material, process};
use serde_json::{Value, json};

const CELLS: [Cell; 4] = [Cell::Triangle, Cell::Quadrilateral, Cell::Tetrahedron, Cell::Hexahedron];
const YOUNG: f64 = 250.0;

fn points(cell: Cell) -> usize {
    match cell {
        Cell::Triangle => 3,
        Cell::Quadrilateral | Cell::Tetrahedron => 4,
        _ => 8,
    }
}

fn scene(mesh: Mesh, poisson: f64, solver: Value) -> Scene {
    let law = mesh.cell.law("HyperElasticNeoHookeanPlaneStrainUP2DLaw", "HyperElasticNeoHookeanUP3DLaw");
    let material = material(law, points(mesh.cell), 2.0, YOUNG, poisson);
    let mut settings = json!({"pressure_dofs": true, "residual_relative_tolerance": 1e-14});
    settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
    Scene::new(mesh.clone(), mesh, material, settings, 1.0)
}

/// A cube or square of four boxes a side, distorted inside.
fn distorted(cell: Cell) -> Mesh {
    let bump = move |x: [f64; 3]| {
        let inside = |t: f64| t * (1.0 - t);
        let size = inside(x[0]) * inside(x[1]) * if cell.dimension() == 3 { 4.0 * inside(x[2]) } else { 1.0 };
        [x[0] + 0.4 * size, x[1] - 0.6 * size, x[2] + if cell.dimension() == 3 { 0.5 * size } else { 0.0 }]
    };
    Mesh::block(cell, [4, 4, 3], [0.0; 3], [1.0; 3]).map(bump)
}

fn on_boundary(cell: Cell, x: [f64; 3]) -> bool {
    x.iter().take(cell.dimension()).any(|x| x.abs() < 1e-12 || (x - 1.0).abs() < 1e-12)
}

/// The boundary moves by (F − I) x; `gradient` is F − I.
fn affine(cell: Cell, gradient: [[f64; 3]; 3], poisson: f64, solver: Value) -> (Scene, Vec<Vec<f64>>) {
    let mesh = distorted(cell);
    let value = |row: [f64; 3]| Value::String(format!("{}*X + {}*Y + {}*Z", row[0], row[1], row[2]));
    let values: Vec<Value> = gradient.into_iter().map(value).collect();
    let exact = mesh.nodes.iter().map(|x| gradient.map(|row| (0..3).map(|j| row[j] * x[j]).sum()).to_vec()).collect();
    let scene = scene(mesh, poisson, solver).part("Boundary", move |x| on_boundary(cell, x));
    (scene.with(fix("Boundary", json!(values))), exact)
}

const GRADIENT: [[f64; 3]; 3] = [[0.1, 0.2, 0.0], [-0.05, -0.1, 0.0], [0.0, 0.0, 0.0]];

#[test]
fn affine_displacements_with_their_pressure() {
    let jacobian = 1.1 * 0.9 + 0.2 * 0.05;
    assert!((jacobian - 1.0f64).abs() < 1e-15);
    // Beside this shearing without change of volume, a stretch.
    let mut stretched = GRADIENT;
    stretched[0][0] = 0.3;
    let jacobian: f64 = 1.3 * 0.9 + 0.2 * 0.05;
    let kappa = YOUNG / 3.0 / (1.0 - 2.0 * 0.3);
    for cell in CELLS {
        for stabilization in ["none", "ppp", "asgs", "osgs"] {
            for (law, pressure) in [("kratos", kappa * (jacobian - 1.0)), ("miehe", kappa * (1.0 - 1.0 / jacobian))] {
                let solver = json!({"stabilization": stabilization, "volumetric_law": law});
                let (scene, exact) = affine(cell, stretched, 0.3, solver);
                let record = scene.run(&[]);
                let error = largest_difference(&record.last().nodes("DISPLACEMENT"), &exact);
                let pressures = record.last().nodes("PRESSURE").concat();
                let off = pressures.iter().map(|p| (p / pressure - 1.0).abs()).fold(0.0, f64::max);
                let told = format!("{cell:?} {stabilization} {law}: u {error:e}, p {off:e}");
                assert!(error < 1e-14 && off < 1e-12, "{told}");
            }
        }
    }
}

/// Only the pressure of one node is given; without change of volume it is that of all.
#[test]
fn constant_pressure_of_an_incompressible_solid() {
    for cell in CELLS {
        for stabilization in ["ppp", "asgs", "osgs"] {
            let (scene, exact) = affine(cell, GRADIENT, 0.5, json!({"stabilization": stabilization}));
            let corner =
                json!({"model_part_name": "Background_Grid.Corner", "variable_name": "PRESSURE", "value": 30.0});
            let scene = scene.part("Corner", |x| x.iter().all(|x| *x == 0.0));
            let record = scene.with(process("assign_scalar_variable_process", corner)).run(&[]);
            let error = largest_difference(&record.last().nodes("DISPLACEMENT"), &exact);
            let pressures = record.last().nodes("PRESSURE").concat();
            let off = pressures.iter().map(|p| (p / 30.0 - 1.0).abs()).fold(0.0, f64::max);
            assert!(error < 1e-14 && off < 1e-12, "{cell:?} {stabilization}: u {error:e}, p {off:e}");
        }
    }
}

/// A column 4 m high between smooth walls: p = −ρ g (H − y), without any displacement. Subscales know
/// weight and gradient of pressure and are exact; the projection resists every gradient.
#[test]
fn hydrostatic_pressure() {
    for cell in CELLS {
        for (stabilization, exact) in [("ppp", false), ("asgs", true), ("osgs", true)] {
            let mesh = Mesh::block(cell, [2, 8, 2], [0.0; 3], [1.0, 4.0, 1.0]);
            let mut scene = scene(mesh, 0.5, json!({"stabilization": stabilization}))
                .part("Floor", |x| x[1] == 0.0)
                .part("Sides", |x| x[0] == 0.0 || x[0] == 1.0)
                .with(fix("Floor", json!([null, 0.0, null])))
                .with(fix("Sides", json!([0.0, null, null])))
                .with(gravity([0.0, -10.0, 0.0]));
            if cell.dimension() == 3 {
                let ends = |x: [f64; 3]| x[2] == 0.0 || x[2] == 1.0;
                scene = scene.part("Ends", ends).with(fix("Ends", json!([null, null, 0.0])));
            }
            let record = scene.run(&[]);
            let pressures = record.last().nodes("PRESSURE").concat();
            let off = |(p, x): (&f64, &[f64; 3])| (p / 80.0 + (4.0 - x[1]) / 4.0).abs();
            let error = pressures.iter().zip(&scene.grid.nodes).map(off).fold(0.0, f64::max);
            let moved = record.last().nodes("DISPLACEMENT").concat().iter().fold(0.0, |m: f64, u| m.max(u.abs()));
            let told = format!("{cell:?} {stabilization}: p {error:e}, u {moved:e}");
            match exact {
                true => assert!(error < 1e-12 && moved < 1e-12, "{told}"),
                false => assert!((0.02..0.3).contains(&error), "{told}"),
            }
        }
    }
}
