//! The discontinuous Galerkin method: dimensions, schemes, Riemann solvers, small and finite strain.

use super::cells::{Scene, constants, hold, load, velocity};
use super::common::process;
use super::trial::assert_resumes;
use serde_json::{Value, json};

fn outputs(every: usize) -> Vec<Value> {
    let control =
        json!({"output_control_type": "step", "output_interval": every, "model_part_name": "Background_Grid"});
    let with = |members: Value| {
        let mut all = control.clone();
        all.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        all
    };
    let shown = json!({"file_format": "vtu", "output_path": "points", "gauss_point_variables_in_elements":
                       ["MP_DISPLACEMENT", "MP_VELOCITY", "MP_PK1_STRESS_TENSOR"]});
    vec![
        process("dgmpm_vtk_output_process", with(shown)),
        process("dgmpm_energy_output_process", with(json!({}))),
        process(
            "vtk_output_process",
            with(json!({"file_format": "ascii", "output_path": "cells",
                        "gauss_point_variables_in_elements": ["VELOCITY"]})),
        ),
    ]
}

fn check(told: &str, scene: &Scene) {
    assert_resumes(told, &|folder| scene.write(folder), &outputs(3), [4, 9]);
}

/// A block that is hit on one side and pushed on another.
fn block(divisions: &[usize], law: &'static str) -> Scene {
    let face = ["PointLoadCondition1D1N", "LineLoadCondition2D2N", "SurfaceLoadCondition3D4N"][divisions.len() - 1];
    let variable = ["POINT_LOAD", "LINE_LOAD", "SURFACE_LOAD"][divisions.len() - 1];
    let size = std::array::from_fn(|a| if a < divisions.len() { 0.1 * divisions[a] as f64 } else { 0.0 });
    Scene::new(size, divisions, law, constants(1000.0, 1e6, 0.3, 1), 0.05)
        .side("Left", "min_x", None)
        .side("Right", "max_x", Some(face))
        .with(hold("Left", json!([1.5, null, null])))
        .with(load("Right", variable, json!([-500.0, 200.0, 0.0])))
        .with(velocity("Background_Grid", json!(["sin(9*x)", "cos(7*x)", 0.0])))
}

#[test]
fn plane() {
    let law = "HyperElasticNeoHookeanPlaneStrain2DLaw";
    for scheme in ["euler", "rk2"] {
        check(scheme, &block(&[8, 6], law).solver(json!({"time_integration": scheme})));
    }
    check("hll", &block(&[8, 6], law).solver(json!({"riemann_solver": "hll"})));
    check("transverse", &block(&[8, 6], law).solver(json!({"transverse_correction": true})));
    let moved = json!({"model_part_name": "Background_Grid.Left", "variable_name": "DISPLACEMENT",
                       "constrained": [false, true, false], "value": [null, "0.01*t", null]});
    check("moved side", &block(&[8, 6], law).with(process("assign_vector_variable_process", moved)));
}

#[test]
fn line_and_space() {
    let bar = block(&[40], "KirchhoffSaintVenantUniaxialStress1DLaw");
    check("exact", &bar.solver(json!({"riemann_solver": "exact"})));
    let solid = block(&[6, 4, 3], "LinearElasticIsotropic3DLaw");
    check("space", &solid.solver(json!({"strain": "small", "transverse_correction": true})));
}
