//! Explicit material points: all schemes and transfers, both frames, points that cross cells and leave.

use super::common::{Cell, Mesh, Scene, fix, gravity, material, process};
use super::trial::{assert_resumes, outputs_of_points};
use serde_json::{Value, json};

const LAW: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";
const STEPS: usize = 24;
const STEP: f64 = 0.001;

/// A block that turns, falls on a moving floor, and crosses cells.
fn scene(members: &Value) -> Scene {
    let total = members["frame"] == "total_lagrangian";
    let body = Mesh::block(Cell::Quadrilateral, [6, 6, 0], [0.0, 0.02, 0.0], [1.0, 1.02, 0.0]);
    let room = Mesh::block(Cell::Quadrilateral, [18, 15, 0], [-1.0, 0.0, 0.0], [2.0, 2.5, 0.0]);
    let grid = if total { body.clone() } else { room };
    let bottom = if total { 0.02 } else { 0.0 };
    let mut solver = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
        "scheme_type": "forward_euler", "time_stepping": {"time_step": STEP}});
    solver.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    let parameters = json!({"model_part_name": "MPM_Material", "value": ["4 - 20*y", "20*x - 12", 0.0]});
    let points = if members["basis"].is_null() { 4 } else { 9 };
    Scene::new(grid, body, material(LAW, points, 1000.0, 1e6, 0.3), solver, (STEPS as f64 - 0.5) * STEP)
        .part("Floor", |x| x[1] == bottom)
        .with(fix("Floor", json!([null, "0.001*t", null])))
        .with(gravity([0.0, -9.81, 0.0]))
        .with(process("assign_initial_field_to_material_point_process", parameters))
}

fn check(told: &str, members: &Value) {
    assert_resumes(told, &|folder| scene(members).write(folder), &outputs_of_points(3), [5, 14]);
}

#[test]
fn schemes_of_the_updated_frame() {
    for stress in ["usf", "usl", "musl"] {
        check(stress, &json!({"stress_update": stress}));
    }
    check("central differences", &json!({"scheme_type": "central_difference"}));
    check("grid edges", &json!({"is_fix_explicit_mp_on_grid_edge": true, "stress_update": "musl"}));
}

#[test]
fn transfers() {
    for transfer in ["apic", "tpic", "xpic"] {
        check(transfer, &json!({"transfer": transfer}));
    }
    check("apic, total", &json!({"transfer": "apic", "frame": "total_lagrangian"}));
    let verlet = json!({"scheme_type": "velocity_verlet", "consistent_mass_matrix": true, "frame": "total_lagrangian"});
    check("consistent", &verlet);
}

#[test]
fn total_frame_with_steps_of_the_solver() {
    let stepping = json!({"time_step": "auto", "courant_number": 0.05});
    check("automatic, total", &json!({"time_stepping": stepping, "frame": "total_lagrangian"}));
    check("automatic", &json!({"time_stepping": stepping}));
    let functions = json!({"scheme_type": "yoshida", "frame": "total_lagrangian", "basis": "lagrange",
                           "basis_order": 2, "point_placement": "even"});
    check("yoshida", &functions);
}

/// Points are erased before and after the run is taken up.
#[test]
fn points_that_leave() {
    let write = |folder: &std::path::Path| {
        let body = Mesh::block(Cell::Quadrilateral, [6, 6, 0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
        let grid = Mesh::block(Cell::Quadrilateral, [9, 9, 0], [-0.25, -0.25, 0.0], [1.25, 1.25, 0.0]);
        let solver = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
            "scheme_type": "forward_euler", "time_stepping": {"time_step": STEP}});
        let velocity = json!({"model_part_name": "MPM_Material", "modulus": 1.0, "direction": [40.0, 1.0, 0.0]});
        Scene::new(grid, body, material(LAW, 4, 1000.0, 1e5, 0.3), solver, (STEPS as f64 - 0.5) * STEP)
            .with(process("assign_initial_velocity_to_material_point_process", velocity))
            .write(folder);
    };
    assert_resumes("points that leave", &write, &outputs_of_points(3), [9, 15]);
}
