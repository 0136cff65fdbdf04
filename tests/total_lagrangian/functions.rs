//! Functions of higher order in the plane and in space: patches, loads on faces, faults of input.

use super::common::{Cell, Mesh, Scene, fix, largest_difference, material, process};
use serde_json::{Value, json};

const BASES: [(&str, usize); 6] =
    [("mesh", 1), ("lagrange", 1), ("lagrange", 2), ("lagrange", 3), ("b_spline", 2), ("b_spline", 3)];

fn solver(basis: &str, order: usize, frame: &str) -> Value {
    json!({"solver_type": "quasi_static", "basis": basis, "basis_order": order, "frame": frame,
           "time_stepping": {"time_step": 0.5}})
}

fn law(cell: Cell) -> &'static str {
    cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw")
}

/// Uneven spacings, the same for grid and body.
fn graded(cell: Cell, cells: usize) -> Mesh {
    Mesh::block(cell, [cells; 3], [0.0; 3], [1.0; 3]).map(|x| x.map(|x| x + 0.2 * x * x))
}

/// Points enough that no combination of functions escapes them.
fn points(cell: Cell, order: usize) -> usize {
    (order + 1).pow(cell.dimension() as u32)
}

/// The boundary moves with a linear field; so does every point, and the stress is the same everywhere.
#[test]
fn linear_fields_are_exact() {
    for frame in ["total_lagrangian", "updated_lagrangian"] {
        for cell in [Cell::Quadrilateral, Cell::Hexahedron] {
            for (basis, order) in BASES.into_iter().filter(|basis| cell.dimension() == 2 || basis.1 < 3) {
                let grid = graded(cell, 3);
                let top = 1.2 - 1e-9;
                let outside = move |x: [f64; 3]| x[..cell.dimension()].iter().any(|x| *x < 1e-9 || *x > top);
                let increment = json!(["0.05*x - 0.02*y + 0.03*z", "0.04*x + 0.02*y", "-0.03*x + 0.04*z"]);
                let value = if cell.dimension() == 2 { json!([increment[0], increment[1], null]) } else { increment };
                let record = Scene::new(
                    grid.clone(),
                    grid,
                    material(law(cell), points(cell, order), 1.0, 1e3, 0.3),
                    solver(basis, order, frame),
                    0.4,
                )
                .part("Boundary", outside)
                .with(fix("Boundary", value))
                .run(&["--record-states", "1"]);
                let moved = |x: &Vec<f64>| {
                    let across = if cell.dimension() == 2 { 0.0 } else { -0.03 * x[0] + 0.04 * x[2] };
                    vec![0.05 * x[0] - 0.02 * x[1] + 0.03 * x[2], 0.04 * x[0] + 0.02 * x[1], across]
                };
                let expected: Vec<Vec<f64>> = record.first().points("MP_COORD").iter().map(moved).collect();
                let error = largest_difference(&record.last().points("MP_DISPLACEMENT"), &expected);
                assert!(error < 1e-10, "{frame} {cell:?} {basis} {order}: {error:e}");
                let stresses = record.last().points("MP_CAUCHY_STRESS_VECTOR");
                let spread = largest_difference(&stresses, &vec![stresses[0].clone(); stresses.len()]);
                assert!(spread < 1e-8 && stresses[0][0].abs() > 10.0, "{frame} {cell:?} {basis} {order}: {spread:e}");
            }
        }
    }
}

/// A traction on one face of a block on rollers: uniaxial stress, found in uniform deformation by
/// every basis if the loads of all functions are right.
#[test]
fn tractions_on_a_face_make_uniform_stress() {
    const TRACTION: f64 = 50.0;
    for cell in [Cell::Quadrilateral, Cell::Hexahedron] {
        for (basis, order) in BASES.into_iter().filter(|basis| cell.dimension() == 2 || basis.1 < 3) {
            let grid = graded(cell, 2);
            let top = grid.find(|x| x[0] > 1.2 - 1e-9);
            let faces: Vec<Vec<usize>> = face_cells(&grid, &top);
            let (condition, variable) = match cell {
                Cell::Quadrilateral => ("MPMGridLineLoadCondition2D2N", "LINE_LOAD"),
                _ => ("MPMGridSurfaceLoadCondition3D4N", "SURFACE_LOAD"),
            };
            let mut scene = Scene::new(
                grid.clone(),
                grid,
                material(law(cell), points(cell, order), 1.0, 1e3, 0.3),
                solver(basis, order, "total_lagrangian"),
                0.4,
            )
            .part("Left", |x| x[0] < 1e-9)
            .part("Bottom", |x| x[1] < 1e-9)
            .with(fix("Left", json!([0.0, null, null])))
            .with(fix("Bottom", json!([null, 0.0, null])));
            if cell.dimension() == 3 {
                scene = scene.part("Back", |x| x[2] < 1e-9).with(fix("Back", json!([null, null, 0.0])));
            }
            scene.loads.push(("Face", condition, faces));
            let load = json!({"model_part_name": "Background_Grid.Face", "variable_name": variable,
                              "modulus": TRACTION, "direction": [1, 0, 0]});
            let record = scene
                .with(process("assign_vector_by_direction_to_condition_process", load))
                .run(&["--record-states", "1"]);
            let (first, last) = (record.first(), record.last());
            let stretches = last
                .scalars("MP_VOLUME")
                .iter()
                .zip(first.scalars("MP_VOLUME"))
                .map(|(v, v0)| v / v0)
                .collect::<Vec<_>>();
            // P = σ J/F11 is the traction on the face before deformation, and nothing acts across.
            for (point, (x, x0)) in last.points("MP_COORD").iter().zip(first.points("MP_COORD")).enumerate() {
                let (stress, stretch) = (&last.points("MP_CAUCHY_STRESS_VECTOR")[point], x[0] / x0[0]);
                let nominal = stress[0] * stretches[point] / stretch;
                assert!((nominal / TRACTION - 1.0).abs() < 1e-9, "{cell:?} {basis} {order}: {nominal}");
                assert!(stress[1].abs() < 1e-8, "{cell:?} {basis} {order}: {stress:?}");
            }
        }
    }
}

/// A body that flies, turns and deforms across the cells of a grid of splines, its search and all,
/// keeps its momentum in the updated frame.
#[test]
fn splines_keep_the_momentum_of_a_body_that_crosses_cells() {
    for cell in [Cell::Quadrilateral, Cell::Hexahedron] {
        for order in [2, 3] {
            let counts = if cell.dimension() == 2 { [8; 3] } else { [5; 3] };
            let grid = Mesh::block(cell, counts, [0.0; 3], [4.0; 3]);
            let body = Mesh::block(cell, [3, 3, 2], [1.0, 1.2, 1.1], [2.6, 2.3, 2.2]);
            let solver = json!({"solver_type": "dynamic", "scheme_type": "newmark", "basis": "b_spline",
                                "basis_order": order, "time_stepping": {"time_step": 0.02}});
            let velocity = json!({"model_part_name": "MPM_Material",
                                  "value": ["3 + 2*sin(3*x)*y", "1 + 2*cos(2*y + x)", "-0.5 + 2*x*z"]});
            let points = 1 << cell.dimension();
            let record = Scene::new(grid, body, material(law(cell), points, 1000.0, 1e6, 0.3), solver, 0.19)
                .with(process("assign_initial_field_to_material_point_process", velocity))
                .run(&["--record-states", "10"]);
            let start = record.first().total("momentum");
            let size = start.iter().map(|p| p * p).sum::<f64>().sqrt();
            for state in record.states() {
                let now = state.total("momentum");
                let drift = (0..3).map(|a| (now[a] - start[a]).abs()).sum::<f64>() / size;
                assert!(drift < 1e-12, "{cell:?}, {order}: momentum drifts by {drift:e} at t = {}", state.time());
            }
            assert!(record.last().energy("strain") > 0.0);
        }
    }
}

/// What the program says of a scene that it refuses.
fn refusal(scene: &Scene) -> String {
    let folder = tempfile::tempdir().unwrap();
    scene.write(folder.path());
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder.path()).args(["check", "ProjectParameters.json"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    said
}

#[test]
fn combinations_without_sense_are_refused() {
    let cell = Cell::Quadrilateral;
    let scene = |grid: Mesh, body: Cell, solver: Value| {
        let body = Mesh::block(body, [2; 3], [0.0; 3], [1.0; 3]);
        Scene::new(grid, body, material(law(cell), 1, 1.0, 1e3, 0.3), solver, 0.4)
    };
    let regular = Mesh::block(cell, [2; 3], [0.0; 3], [1.0; 3]);
    let skew = regular.clone().map(|[x, y, z]| [x + 0.1 * x * y, y, z]);
    let triangles = Mesh::block(Cell::Triangle, [2; 3], [0.0; 3], [1.0; 3]);
    let said = refusal(&scene(skew, cell, solver("b_spline", 2, "total_lagrangian")));
    assert!(said.contains("cell 1 is no line, rectangle or box"), "{said}");
    let said = refusal(&scene(triangles, Cell::Triangle, solver("lagrange", 2, "total_lagrangian")));
    assert!(said.contains("needs a regular grid"), "{said}");
    let said = refusal(&scene(regular.clone(), cell, solver("b_spline", 4, "total_lagrangian")));
    assert!(said.contains("must be at most 3"), "{said}");
    let conserving = |frame: &str| {
        json!({"solver_type": "dynamic", "scheme_type": "energy_conserving", "frame": frame,
               "time_stepping": {"time_step": 0.1}})
    };
    let said = refusal(&scene(regular.clone(), cell, conserving("updated_lagrangian")));
    assert!(said.contains("needs the total Lagrangian frame"), "{said}");
    let mut affine = conserving("total_lagrangian");
    affine["transfer"] = json!("apic");
    let said = refusal(&scene(regular, cell, affine));
    assert!(said.contains("flip_fraction 1"), "{said}");
}

/// Faces of cells all of whose nodes are in a list, turned outwards.
fn face_cells(mesh: &Mesh, nodes: &[usize]) -> Vec<Vec<usize>> {
    let faces: &[&[usize]] = match mesh.cell {
        Cell::Quadrilateral => &[&[1, 2]],
        _ => &[&[1, 2, 6, 5]],
    };
    let of_cell =
        |cell: &Vec<usize>| faces.iter().map(|face| face.iter().map(|&a| cell[a]).collect()).collect::<Vec<_>>();
    mesh.cells
        .iter()
        .flat_map(of_cell)
        .filter(|face: &Vec<usize>| face.iter().all(|node| nodes.contains(node)))
        .collect()
}
