//! Implicit material points: statics and dynamics, displacements alone and with pressures, both frames,
//! loads that move with the material.

use super::common::{Cell, Mesh, Scene, fix, gravity, material, process};
use super::trial::{assert_resumes, outputs_of_points};
use serde_json::{Value, json};

const STEPS: usize = 12;
const STEP: f64 = 0.002;

/// A block that is pushed over the cells of a grid by a load on its top.
fn scene(law: &str, members: &Value) -> Scene {
    let body = Mesh::block(Cell::Quadrilateral, [5, 5, 0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]);
    let room = Mesh::block(Cell::Quadrilateral, [12, 10, 0], [-0.6, 0.0, 0.0], [1.8, 2.0, 0.0]);
    let grid = if members["grid_reset"] == "never" { body.clone() } else { room };
    let mut solver = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": STEP},
        "residual_relative_tolerance": 1e-8, "compute_reactions": true});
    solver.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    let velocity = json!({"model_part_name": "MPM_Material", "value": ["30*y", "3*x", 0.0]});
    Scene::new(grid, body, material(law, 4, 1000.0, 1e5, 0.3), solver, (STEPS as f64 - 0.5) * STEP)
        .part("Floor", |x| x[1] == 0.0)
        .with(fix("Floor", json!(["0.0003*t", 0.0, null])))
        .with(gravity([0.0, -9.81, 0.0]))
        .with(process("assign_initial_field_to_material_point_process", velocity))
}

fn outputs() -> Vec<Value> {
    let grid = json!({"model_part_name": "Background_Grid", "time_frequency": 0.0, "output_file_name": "grid.json",
        "output_variables": ["DISPLACEMENT"], "resultant_solution": true});
    let mut all = outputs_of_points(2);
    all.push(process("json_output_process", grid));
    all
}

fn check(told: &str, law: &str, members: &Value) {
    assert_resumes(told, &|folder| scene(law, members).write(folder), &outputs(), [3, 8]);
}

const LAW: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";

#[test]
fn dynamics() {
    check("newmark", LAW, &json!({}));
    check("bossak", LAW, &json!({"scheme_type": "bossak"}));
    check("supports with their own motion", LAW, &json!({"held_motion": "imposed"}));
    check("quasi-static", LAW, &json!({"solver_type": "quasi_static"}));
}

#[test]
fn total_frame() {
    for scheme in ["newmark", "bossak", "energy_conserving"] {
        check(scheme, LAW, &json!({"scheme_type": scheme, "grid_reset": "never"}));
    }
    check("consistent", LAW, &json!({"consistent_mass_matrix": true, "grid_reset": "never"}));
}

#[test]
fn mixed() {
    let law = "HyperElasticNeoHookeanPlaneStrainUP2DLaw";
    for stabilization in ["ppp", "asgs", "osgs"] {
        check(stabilization, law, &json!({"pressure_dofs": true, "stabilization": stabilization}));
    }
    check("mixed, total", law, &json!({"pressure_dofs": true, "stabilization": "ppp", "grid_reset": "never"}));
}

/// Each load step begins with the increments of the last one.
#[test]
fn statics() {
    let write = |folder: &std::path::Path| {
        let mesh = Mesh::block(Cell::Quadrilateral, [8, 3, 0], [0.0; 3], [2.0, 0.5, 0.0]);
        let solver = json!({"solver_type": "static", "compute_reactions": true, "residual_relative_tolerance": 1e-8});
        let top = (0..8).map(|i| vec![3 * 9 + i, 3 * 9 + i + 1]).collect();
        let mut scene = Scene::new(mesh.clone(), mesh, material(LAW, 4, 1000.0, 1e6, 0.3), solver, 7.5)
            .part("Clamp", |x| x[0] == 0.0)
            .with(fix("Clamp", json!([0.0, 0.0, 0.0])));
        scene.loads.push(("Top", "MPMGridLineLoadCondition2D2N", top));
        let load = json!({"model_part_name": "Background_Grid.Top", "variable_name": "LINE_LOAD",
                          "modulus": "30*t", "direction": [0.0, -1.0, 0.0]});
        scene.with(process("assign_vector_by_direction_to_condition_process", load)).write(folder);
    };
    assert_resumes("static", &write, &outputs(), [2, 5]);
}

/// Conditions that move with the material, and their measurements.
#[test]
fn loads_that_move() {
    let write = |folder: &std::path::Path| {
        let mut scene = scene(LAW, &json!({}));
        let row = 5 * 13 + 3;
        let top = (0..5).map(|i| vec![row + i, row + i + 1]).collect();
        scene.loads.push(("Top", "LineCondition2D2N", top));
        let load = json!({"model_part_name": "Background_Grid.Top", "material_points_per_condition": 2,
            "variable_name": "POINT_LOAD", "modulus": "100*t", "constrained": "fixed", "direction": [1.0, 0.0, 0.0]});
        scene.with(process("apply_mpm_particle_neumann_condition_process", load)).write(folder);
    };
    let mut outputs = outputs();
    let probe = json!({"positions": [[0.5, 1.0, 0.0]], "output_variables": ["MPC_DISPLACEMENT"]});
    outputs.push(process("mpm_condition_output_process", probe));
    assert_resumes("moving loads", &write, &outputs, [3, 8]);
}
