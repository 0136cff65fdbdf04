//! What the program says of projects that cannot run or go wrong, and of what a scene consists of.

use super::scene::{Scene, constants, hold, velocity};
use serde_json::{Value, json};

fn plane(points: usize) -> Scene {
    let law = "HyperElasticNeoHookeanPlaneStrain2DLaw";
    Scene::new([1.0, 1.0, 0.0], &[4, 4], law, constants(1000.0, 1e6, 0.3, points), 0.01)
}

fn line() -> Scene {
    let variables = json!({"DENSITY": 7800.0, "YOUNG_MODULUS": 2e11});
    Scene::new([6.0, 0.0, 0.0], &[50], "KirchhoffSaintVenantUniaxialStress1DLaw", variables, 1e-3)
}

#[test]
fn wrong_choices_are_refused_with_what_to_do() {
    let members = |text: &str| -> Value { serde_json::from_str(text).unwrap() };
    for (scene, expected) in [
        (plane(1).solver(members(r#"{"riemann_solver": "exact"}"#)), "exact Riemann solver is for one dimension"),
        (line().solver(members(r#"{"riemann_solver": "exact", "strain": "small"}"#)), "no shocks and fans"),
        (
            plane(1).solver(members(r#"{"transverse_correction": true, "time_integration": "rk2"}"#)),
            "rk2 with one point a cell has it built in",
        ),
        (plane(1).solver(members(r#"{"stability_criterion": "no_overshoot"}"#)), "for one dimension"),
        (plane(1).solver(members(r#"{"time_integration": "rk4"}"#)), "one of euler, rk2, ssp_rk3"),
        (plane(1).solver(members(r#"{"point_positions": [[0.5]]}"#)), "a list of 2 numbers from 0 to 1"),
        (plane(1).solver(members(r#"{"point_positions": [[0.0, 0.5]]}"#)), "without mass"),
        (plane(3), "MATERIAL_POINTS_PER_ELEMENT is 3"),
        (plane(1).solver(members(r#"{"transmitting_parts": ["Background_Grid.Rigth"]}"#)), "there is no part"),
        (plane(1).solver(members(r#"{"domain_size": 3}"#)), "must be a Hexahedron8"),
    ] {
        let (code, said) = scene.ask(&["check"]);
        assert_eq!(code, Some(2), "{expected}: {said}");
        assert!(said.contains(expected), "{expected:?} is not in\n{said}");
    }
}

/// Below F = 1/√3 a Saint-Venant–Kirchhoff bar has no waves.
#[test]
fn a_bar_without_waves_stops_and_tells_where() {
    let scene = line().side("Left", "min_x", None).with(hold("Left", json!([3000.0, null, null])));
    let (code, said) = scene.ask(&["run", "--quiet"]);
    assert_eq!(code, Some(3), "{said}");
    for part in ["no wave speed", "element 1", "deformation gradient", "the state was saved to"] {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
}

#[test]
fn a_step_above_the_stable_one_is_told_with_both_figures() {
    let start = velocity("Background_Grid", json!(["x", 0.0, 0.0]));
    let scene = |policy: &str| {
        let stepping = json!({"time_step": 0.008, "time_step_policy": policy});
        plane(1).with(start.clone()).solver(json!({"time_stepping": stepping, "strain": "small"}))
    };
    // c = 36.69 m/s crosses 0.25 m in 6.814 ms; .652 of that is stable.
    let (code, said) = scene("warn").ask(&["run"]);
    assert_eq!(code, Some(0), "{said}");
    for part in ["8e-3 s is above the stable one", "Courant number 1.17", "allows 0.65"] {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
    let (code, said) = scene("strict").ask(&["run"]);
    assert!(code == Some(3) && said.contains("Courant number 1.17"), "{said}");
}

/// Small strain has no det F that could stop a run that grows; its numbers stay numbers until it is stopped.
#[test]
fn an_unstable_run_of_small_strain_stops() {
    let start = velocity("Background_Grid", json!(["x", 0.0, 0.0]));
    let mut scene = plane(1).with(start).solver(json!({"time_stepping": {"time_step": 0.008}, "strain": "small"}));
    scene.end_time = 40.0;
    let (code, said) = scene.ask(&["run", "--quiet"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("the run is unstable") && !said.contains("NaN"), "{said}");
}

#[test]
fn the_inventory_tells_what_is_there_and_what_is_left_out() {
    let (code, said) = plane(4).solver(json!({"time_integration": "rk2"})).ask(&["check"]);
    assert_eq!(code, Some(0), "{said}");
    for part in [
        "64 points, plane strain, HyperElasticNeoHookeanPlaneStrain2DLaw, finite strain, mass 1.000000e3 kg",
        "16 of 1 forms",
        "24 between cells, 16 at the boundary",
        "mid-point rule",
        "stable Courant number",
        "cells' own nodes between stages",
    ] {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
    let left = said.lines().find(|line| line.trim().starts_with("left out")).unwrap();
    assert!(left.contains("acceleration") && left.contains("history") && !left.contains("nodes"), "{left}");
}

/// Points as .vtu, cells as .vtu, energies as a table.
#[test]
fn results_are_written() {
    let folder = tempfile::TempDir::new().unwrap();
    let output = |module: &str, parameters: Value| super::common::process(module, parameters);
    let mut scene = plane(4).with(velocity("Background_Grid", json!(["x", 0.0, 0.0])));
    scene.outputs = vec![
        output(
            "dgmpm_vtk_output_process",
            json!({"model_part_name": "Background_Grid", "file_format": "vtu", "output_interval": 2,
                   "gauss_point_variables_in_elements": ["MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR",
                       "MP_DEFORMATION_GRADIENT", "MP_DISPLACEMENT"]}),
        ),
        output(
            "vtk_output_process",
            json!({"model_part_name": "Background_Grid", "file_format": "vtu",
                   "element_data_value_variables": ["CAUCHY_STRESS_VECTOR", "VELOCITY", "DEFORMATION_GRADIENT"]}),
        ),
        output("dgmpm_energy_output_process", json!({"model_part_name": "Background_Grid"})),
    ];
    scene.write(folder.path());
    let record = super::common::run_project(folder.path(), &[]);
    let table = std::fs::read_to_string(folder.path().join("energy.dat")).unwrap();
    let last: Vec<f64> = table.lines().last().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
    assert!((last[3] - record.last().energy("total")).abs() <= 1e-15 * last[3], "{last:?}");
    for name in ["DGMPM_VTK_Output", "VTK_Output"] {
        let files = std::fs::read_dir(folder.path().join(name)).unwrap().count();
        assert!(files > 2, "{name} holds {files} files");
    }
}
