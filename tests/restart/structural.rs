//! Finite elements: statics, implicit and explicit dynamics, laws with and without history.

use super::body::{Body, fix, load, material};
use super::common::{Cell, Mesh, process};
use super::trial::assert_resumes;
use serde_json::{Value, json};

fn outputs() -> Vec<Value> {
    let control = json!({"output_control_type": "step", "output_interval": 2, "model_part_name": "Structure"});
    let with = |members: Value| {
        let mut all = control.clone();
        all.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        all
    };
    vec![
        process(
            "vtk_output_process",
            with(json!({"file_format": "vtu", "output_path": "vtk",
                "nodal_solution_step_data_variables": ["DISPLACEMENT", "REACTION"]})),
        ),
        process("resultant_output_process", with(json!({"output_variables": ["REACTION"]}))),
        process(
            "json_output_process",
            json!({"model_part_name": "Structure.Clamp", "time_frequency": 0.0, "output_file_name": "clamp.json",
                   "output_variables": ["REACTION"]}),
        ),
    ]
}

fn check(told: &str, law: &str, solver: &Value, end: f64) {
    let write = |folder: &std::path::Path| {
        let mesh = Mesh::block(Cell::Quadrilateral, [8, 3, 0], [0.0; 3], [2.0, 0.5, 0.0]);
        let top = (0..8).map(|i| vec![3 * 9 + i, 3 * 9 + i + 1]).collect();
        Body::new(mesh, material(law, 1000.0, 1e6, 0.3), solver.clone(), end)
            .part("Clamp", |x| x[0] == 0.0)
            .conditions("Top", "LineLoadCondition2D2N", top)
            .with(fix("Clamp", json!(["0.001*t", 0.0, 0.0])))
            .with(load("Top", "LINE_LOAD", json!([0.0, "-900*t", 0.0])))
            .write(folder);
    };
    assert_resumes(told, &write, &outputs(), [3, 8]);
}

#[test]
fn statics_and_dynamics() {
    let law = "HyperElasticNeoHookeanPlaneStrain2DLaw";
    check("static", law, &json!({"compute_reactions": true}), 10.5);
    let dynamic = |members: Value| {
        let mut all = json!({"solver_type": "structural_dynamic", "compute_reactions": true,
                             "time_stepping": {"time_step": 0.01}, "residual_absolute_tolerance": 1e-9});
        all.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        all
    };
    check("newmark", law, &dynamic(json!({"scheme_type": "newmark"})), 0.119);
    check("bossak", law, &dynamic(json!({"scheme_type": "bossak", "consistent_mass_matrix": true})), 0.119);
    let explicit = json!({"time_integration_method": "explicit",
                          "time_stepping": {"time_step": "auto", "courant_number": 0.8}});
    check("explicit", law, &dynamic(explicit), 0.1);
}
