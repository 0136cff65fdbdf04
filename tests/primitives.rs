//! A whole scene in one JSON file: a disc of primitives falls freely (runs the program itself).

use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::process::{Command, Output};

const RADIUS: f64 = 0.2;
const HEIGHT: f64 = 0.7;
const DENSITY: f64 = 1200.0;
const THICKNESS: f64 = 0.5;
const GRAVITY: f64 = 9.81;
const AROUND: usize = 32;

fn scene(shape: &str, points: usize) -> Value {
    json!({
        "problem_data": {"end_time": 0.1},
        "modelers": [
            {"name": "Modelers.Bia.RegularGridModeler", "parameters": {
                "min": [-0.5, 0, 0], "max": [0.5, 1, 0], "cell_size": 0.1, "shape": shape,
                "parts": [{"name": "Floor", "side": "min_y"}]}},
            {"name": "Modelers.Bia.BodyModeler", "parameters": {"bodies": [
                {"name": "Disc", "primitive": {"type": "disc", "center": [0, HEIGHT, 0], "radius": RADIUS},
                 "divisions": [AROUND, 3], "shape": shape}]}}
        ],
        "solver_settings": {
            "solver_type": "dynamic", "scheme_type": "newmark", "domain_size": 2,
            "time_stepping": {"time_step": 0.01},
            "residual_relative_tolerance": 1e-10,
            "model_import_settings": {"input_type": "use_input_model_part"},
            "grid_model_import_settings": {"input_type": "use_input_model_part"},
            "material_import_settings": {"materials": [{
                "model_part_name": "Initial_MPM_Material.Disc", "properties_id": 1,
                "Material": {
                    "constitutive_law": {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"},
                    "Variables": {"DENSITY": DENSITY, "THICKNESS": THICKNESS, "YOUNG_MODULUS": 1e5,
                                  "POISSON_RATIO": 0.3, "MATERIAL_POINTS_PER_ELEMENT": points}}}]}
        },
        "processes": {"gravity": [{
            "python_module": "assign_gravity_to_material_point_process",
            "Parameters": {"model_part_name": "MPM_Material", "modulus": GRAVITY, "direction": [0.0, -1.0, 0.0]}}]}
    })
}

fn bia(folder: &Path, scene: &Value, arguments: &[&str]) -> Output {
    let file = folder.join("ProjectParameters.json");
    std::fs::write(&file, serde_json::to_string_pretty(scene).unwrap()).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder).arg(arguments[0]).arg(file).args(&arguments[1..]).output().unwrap()
}

#[test]
fn a_disc_has_its_mass_and_falls_freely() {
    for (shape, points) in [("quadrilateral", 4), ("triangle", 3)] {
        let folder = tempfile::tempdir().unwrap();
        let output =
            bia(folder.path(), &scene(shape, points), &["run", "--quiet", "--threads", "1", "--record", "record.json"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(folder.path().join("record.json")).unwrap();
        let record: Value = serde_json::from_str(&text).unwrap();
        let snapshots = record["snapshots"].as_array().unwrap();
        assert!(snapshots.len() > 3);
        let exact = DENSITY * PI * RADIUS * RADIUS * THICKNESS;
        // A regular polygon in the circle lacks this share of its area.
        let defect = 1.0 - (TAU / AROUND as f64).sin() / (TAU / AROUND as f64);
        for state in snapshots {
            let mass = state["sums"]["mass"].as_f64().unwrap();
            assert!((mass - exact * (1.0 - defect)).abs() < 1e-10 * exact, "{mass} kg for {exact} kg");
            let t = state["time"].as_f64().unwrap();
            let center = |i: usize| state["sums"]["com"][i].as_f64().unwrap();
            // Newmark with β = 1/4 is exact for a constant acceleration.
            let expected = HEIGHT - 0.5 * GRAVITY * t * t;
            assert!((center(1) - expected).abs() < 1e-12, "{shape}, t = {t}: {} for {expected}", center(1));
            assert!(center(0).abs() < 1e-14);
        }
        assert!((snapshots.last().unwrap()["time"].as_f64().unwrap() - 0.1).abs() < 0.011);
    }
}

#[test]
fn check_tells_the_area_of_the_body() {
    let folder = tempfile::tempdir().unwrap();
    let output = bia(folder.path(), &scene("quadrilateral", 4), &["check"]);
    assert!(output.status.success());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let area = 0.5 * AROUND as f64 * RADIUS * RADIUS * (TAU / AROUND as f64).sin();
    assert!(said.contains(&format!("area {area:.9e} m²")), "{said}");
}

#[test]
fn faults_of_materials_point_into_the_project() {
    let folder = tempfile::tempdir().unwrap();
    let mut wrong = scene("quadrilateral", 4);
    let place = "/solver_settings/material_import_settings/materials/0";
    wrong.pointer_mut(&format!("{place}/Material/Variables")).unwrap()["DENSITTY"] = 1.into();
    wrong.pointer_mut(place).unwrap()["model_part_name"] = "Initial_MPM_Material.Disk".into();
    let output = bia(folder.path(), &wrong, &["check"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    for part in
        [&format!("at {place}/Material/Variables/DENSITTY"), "did you mean \"DENSITY\"", "ProjectParameters.json"]
    {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }

    let settings = |value: Value| {
        let mut wrong = scene("quadrilateral", 4);
        wrong["solver_settings"]["material_import_settings"] = value;
        String::from_utf8_lossy(&bia(folder.path(), &wrong, &["check"]).stderr).into_owned()
    };
    assert!(settings(json!({})).contains("\"materials_filename\" is missing"));
    assert!(settings(json!({"materials": [], "materials_filename": "m.json"})).contains("keep one of the two"));
    assert!(settings(json!({"materials": {}})).contains("must be a list"));
}
