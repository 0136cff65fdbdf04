//! Points that stand exactly on edges and nodes of cells, where a node beyond has no mass, but its function a
//! gradient: it must not act as a support. A body in free flight keeps its velocity, and no stress arises.

use super::common::{Cell, Mesh, Scene, largest_difference, material, process};
use serde_json::{Value, json};

const LAW: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";
const VELOCITY: [f64; 3] = [1.0, 0.37, 0.0];

/// One point of 1 kg that starts at a place, on cells of 1 m.
fn flight(place: [f64; 2], solver: Value) -> Scene {
    let grid = Mesh::block(Cell::Quadrilateral, [12, 6, 1], [0.0; 3], [12.0, 6.0, 0.0]);
    let [x, y] = place;
    let body = Mesh::block(Cell::Quadrilateral, [1, 1, 1], [x - 0.5, y - 0.5, 0.0], [x + 0.5, y + 0.5, 0.0]);
    Scene::new(grid, body, material(LAW, 1, 1.0, 1.0, 0.3), solver, 9.95).with(process(
        "assign_initial_velocity_to_material_point_process",
        json!({"model_part_name": "MPM_Material", "modulus": 1.0, "direction": VELOCITY}),
    ))
}

#[test]
fn a_point_flies_from_inside_edges_and_nodes() {
    let newmark = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": 0.1}});
    let explicit = |frame: &str| {
        json!({"solver_type": "dynamic", "time_integration_method": "explicit", "scheme_type": "forward_euler",
               "stress_update": "musl", "frame": frame, "time_stepping": {"time_step": 0.1}})
    };
    // Steps of 0.1 m meet the faces of the cells again and again.
    for place in [[0.8, 0.7], [1.0, 0.7], [1.0, 1.0]] {
        for solver in [newmark.clone(), explicit("updated_lagrangian"), explicit("total_lagrangian")] {
            let record = flight(place, solver.clone()).run(&["--record-states", "1"]);
            let (first, last) = (record.first().points("MP_COORD"), record.last());
            let moved = first.iter().map(|x| (0..3).map(|a| x[a] + VELOCITY[a] * last.time()).collect());
            let exact: Vec<Vec<f64>> = moved.collect();
            let error = largest_difference(&last.points("MP_COORD"), &exact);
            assert!(error < 1e-9, "{place:?} {solver}: off by {error:e} m");
        }
    }
}
