//! A block in free fall: Newmark's rule is exact for a constant acceleration, and a rigid motion
//! makes no stress, also while points cross cells (Newton; no tolerance but round-off).

use super::common::{Cell, Mesh, Scene, gravity, largest_difference, material, process};
use serde_json::{Value, json};

const YOUNG: f64 = 1e6;

fn falling(cell: Cell, points: usize, solver: Value) -> Scene {
    let grid = Mesh::block(cell, [6, 8, 4], [0.0; 3], [3.0, 4.0, 2.0]);
    let body = Mesh::block(cell, [3, 3, 2], [0.4, 2.3, 0.3], [1.5, 3.4, 1.1]);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    Scene::new(grid, body, material(law, points, 1000.0, YOUNG, 0.3), solver, 0.3 - 1e-6)
        .with(gravity([0.0, -9.81, 0.0]))
        .with(process(
            "assign_initial_velocity_to_material_point_process",
            json!({"model_part_name": "MPM_Material", "modulus": 1.0, "direction": [1.5, -1.0, 0.5]}),
        ))
}

fn assert_exact(scene: &Scene) {
    let record = scene.run(&["--record-states", "3"]);
    let start = record.first().points("MP_COORD");
    let dimension = scene.grid.cell.dimension();
    for state in record.states() {
        let t = state.time();
        let moved = [1.5 * t, -t - 0.5 * 9.81 * t * t, if dimension == 3 { 0.5 * t } else { 0.0 }];
        let exact: Vec<Vec<f64>> = start.iter().map(|x| (0..3).map(|a| x[a] + moved[a]).collect()).collect();
        let error = largest_difference(&state.points("MP_COORD"), &exact);
        assert!(error < 1e-12, "{:?}: position is off by {error:e} m at t = {t}", scene.grid.cell);
        for stress in state.points("MP_CAUCHY_STRESS_VECTOR").concat() {
            assert!(stress.abs() < 1e-11 * YOUNG, "{:?}: stress {stress:e} Pa at t = {t}", scene.grid.cell);
        }
    }
    assert!(record.last().time() > 0.299, "the run stopped at {}", record.last().time());
}

#[test]
fn newmark_is_exact_on_all_cells() {
    let dynamic = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": 0.01}});
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Triangle, 3), (Cell::Hexahedron, 8), (Cell::Tetrahedron, 4)]
    {
        assert_exact(&falling(cell, points, dynamic.clone()));
    }
}

#[test]
fn bossak_and_consistent_mass_are_exact_too() {
    let bossak = json!({"solver_type": "dynamic", "scheme_type": "bossak", "time_stepping": {"time_step": 0.01}});
    assert_exact(&falling(Cell::Quadrilateral, 4, bossak));
    let consistent = json!({"solver_type": "dynamic", "scheme_type": "newmark", "consistent_mass_matrix": true,
                            "time_stepping": {"time_step": 0.01}});
    assert_exact(&falling(Cell::Quadrilateral, 9, consistent));
}

/// A body acceleration given as a function acts as gravity does, and ends with its interval: in the
/// step after it Newmark takes half of it, the mean of the step's two ends.
#[test]
fn a_body_acceleration_acts_in_its_interval() {
    let solver = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": 0.01}});
    let mut scene = falling(Cell::Quadrilateral, 4, solver);
    let parameters = json!({"model_part_name": "MPM_Material", "value": [null, "-9.81", 0.0]});
    let part = "assign_body_acceleration_to_material_point_process";
    scene.processes[0] = process(part, parameters.clone());
    assert_exact(&scene);

    let mut parameters = parameters;
    parameters["interval"] = json!([0.0, 0.1]);
    scene.processes[0] = process(part, parameters);
    for velocity in scene.run(&["--record-states", "1"]).last().points("MP_VELOCITY") {
        let exact = [1.5, -1.0 - 9.81 * 0.105, 0.0];
        assert!((0..3).all(|a| (velocity[a] - exact[a]).abs() < 1e-12), "{velocity:?}, exact {exact:?}");
    }
}

#[test]
fn a_body_acceleration_that_is_not_finite_is_a_failure_with_a_place() {
    let mut scene = falling(Cell::Quadrilateral, 4, json!({"solver_type": "dynamic"}));
    scene.solver["time_stepping"] = json!({"time_step": 0.01});
    let parameters = json!({"model_part_name": "MPM_Material", "value": ["1/(t - t)", 0.0, 0.0]});
    scene.processes[0] = process("assign_body_acceleration_to_material_point_process", parameters);
    let folder = tempfile::TempDir::new().unwrap();
    scene.write(folder.path());
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder.path()).args(["run", "ProjectParameters.json"]).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{message}");
    assert!(message.contains("not finite") && message.contains("material point"), "{message}");
}
