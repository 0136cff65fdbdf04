//! Reference solutions and norms, in all applications.

use super::trial::{copy_projects, summary};
use serde_json::{Value, json};
use std::path::Path;
use tempfile::TempDir;

fn error(label: &str, part: &str, members: Value) -> Value {
    let mut parameters = json!({"label": label, "model_part_name": part});
    parameters.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
    json!({"python_module": "error_process", "Parameters": parameters})
}

/// The summary of a project with these errors.
fn errors(folder: &Path, project: &str, list: &[Value]) -> Value {
    let set = [format!("/processes/measurements={}", Value::from(list.to_vec()))];
    let told = summary(folder, project, &set);
    assert_eq!(told["status"], "done", "{told:#}");
    told["errors"].clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn bar(stress: f64) -> Value {
    json!({"type": "elastic_bar", "modulus": 250.0, "density": 0.0019355, "length": 5.0, "far_end": "held",
           "origin": 5.0, "reversed": true, "stress": stress})
}

/// At the Courant number 1 the discontinuous method follows the fronts exactly: displacements, velocities
/// and stresses are those of d'Alembert, and with another load they are not.
#[test]
fn an_exact_method_has_no_error_but_against_another_solution() {
    let folder = TempDir::new().unwrap();
    copy_projects(folder.path());
    let of = |variable: &str, stress: f64| json!({"variable": variable, "norm": "L1", "reference": bar(stress)});
    let list = [
        error("u", "Background_Grid", of("MP_DISPLACEMENT", -1.27)),
        error("v", "Background_Grid", of("MP_VELOCITY_X", -1.27)),
        error("s", "Background_Grid", of("MP_CAUCHY_STRESS_VECTOR_XX", -1.27)),
        error("double", "Background_Grid", of("MP_VELOCITY", -2.54)),
    ];
    let found = errors(folder.path(), "dgmpm.json", &list);
    for label in ["u", "v", "s"] {
        assert!(number(&found[label]["relative_over_time"]) < 1e-12, "{label}: {found:#}");
    }
    assert!((number(&found["double"]["relative_at_end"]) - 0.5).abs() < 1e-12, "half of it is missing");
    assert_eq!(found["s"]["field"], "MP_CAUCHY_STRESS_VECTOR_XX");
}

/// A bar at rest against a constant: each norm is the constant times what the norm makes of the volume,
/// which is the length of the bar in one dimension.
#[test]
fn norms_of_a_constant() {
    let folder = TempDir::new().unwrap();
    copy_projects(folder.path());
    for (project, part, variable, on, volume) in [
        ("fem.json", "Structure", "DISPLACEMENT", "nodes", 5.0_f64),
        // Points stand for volume: length times cross-section.
        ("mpm.json", "MPM_Material", "MP_DISPLACEMENT", "points", 5.0 * 19.635),
    ] {
        let of = |norm: &str| {
            let reference = json!({"type": "formula", "value": [0, "2 + 0*X", 0]});
            error(norm, part, json!({"variable": variable, "on": on, "norm": norm, "reference": reference}))
        };
        let list = ["L1", "L2", "max", "rms"].map(of);
        let set = vec![
            format!("/processes/measurements={}", Value::from(list.to_vec())),
            "/processes/loads_process_list=[]".to_string(),
        ];
        let found = summary(folder.path(), project, &set)["errors"].clone();
        for (norm, expected) in [("L1", 2.0 * volume), ("L2", 2.0 * volume.sqrt()), ("max", 2.0), ("rms", 2.0)] {
            for key in ["at_end", "largest", "over_time"] {
                let value = number(&found[norm][key]);
                assert!((value / expected - 1.0).abs() < 1e-12, "{project}, {norm}, {key}: {value} {expected}");
            }
            assert!((number(&found[norm]["relative_at_end"]) - 1.0).abs() < 1e-12);
        }
    }
}

/// A box holds the points and nodes that are in it at the start: here the half of a bar of 16 cells, whose
/// last node brings its share of the cell beyond.
#[test]
fn norms_within_a_box() {
    let folder = TempDir::new().unwrap();
    copy_projects(folder.path());
    for (project, part, variable, of, volume) in [
        ("fem.json", "Structure", "DISPLACEMENT", "nodes", 2.5 + 0.5 * 5.0 / 16.0),
        ("mpm.json", "MPM_Material", "MP_DISPLACEMENT", "points", 2.5 * 19.635),
    ] {
        let on = json!({"box": {"min": [0.0, 0.0, 0.0], "max": [2.5, 0.0, 0.0]}, "of": of});
        let reference = json!({"type": "formula", "value": [0, "2 + 0*X", 0]});
        let list = [error("e", part, json!({"variable": variable, "on": on, "norm": "L1", "reference": reference}))];
        let set = [
            format!("/processes/measurements={}", Value::from(list.to_vec())),
            "/processes/loads_process_list=[]".to_string(),
        ];
        let found = number(&summary(folder.path(), project, &set)["errors"]["e"]["at_end"]);
        assert!((found / (2.0 * volume) - 1.0).abs() < 1e-12, "{project}: {found} {volume}");
    }
}

/// A table that a run's own measurement wrote is a reference for another run: the same has no error, a
/// finer one a small error, and beyond its end it is no number.
#[test]
fn a_finer_run_is_a_reference() {
    let folder = TempDir::new().unwrap();
    copy_projects(folder.path());
    let probe = json!({"python_module": "line_output_process", "Parameters": {
        "model_part_name": "Structure", "start_point": [0.5, 0.0, 0.0], "end_point": [4.5, 0.0, 0.0],
        "sampling_points": 41, "output_variables": ["DISPLACEMENT"]}});
    let write = |divisions: usize| {
        let set = [
            format!("/processes/measurements={}", json!([probe])),
            format!("/modelers/0/parameters/divisions=[{divisions}]"),
        ];
        assert_eq!(summary(folder.path(), "fem.json", &set)["status"], "done");
        std::fs::rename(folder.path().join("line.csv"), folder.path().join(format!("line{divisions}.csv"))).unwrap();
    };
    [16, 256].iter().for_each(|n| write(*n));
    let columns = json!({"time": "TIME", "X": "X", "value": "DISPLACEMENT_X"});
    let places: Vec<[f64; 3]> = (0..5).map(|i| [0.5 + f64::from(i), 0.0, 0.0]).collect();
    let of = |file: &str, end: f64| {
        let reference = json!({"type": "table", "file": file, "columns": columns});
        json!({"variable": "DISPLACEMENT_X", "on": {"positions": places}, "norm": "rms", "reference": reference,
               "interval": [0.0, end]})
    };
    let list = [
        error("same", "Structure", of("line16.csv", 1.0)),
        error("finer", "Structure", of("line256.csv", 0.0075)),
        error("beyond", "Structure", of("line256.csv", 1.0)),
    ];
    let found = errors(folder.path(), "fem.json", &list);
    assert_eq!(number(&found["same"]["largest"]), 0.0, "{found:#}");
    let finer = number(&found["finer"]["relative_over_time"]);
    assert!((1e-4..0.1).contains(&finer), "{finer}");
    assert!(found["beyond"]["largest"].is_null(), "the coarse run ends later than the finer one: {found:#}");
}

/// What is wrong is told with its place, before anything runs.
#[test]
fn faults_of_references_are_input_errors() {
    let folder = TempDir::new().unwrap();
    copy_projects(folder.path());
    let u = |reference: Value| json!({"variable": "MP_DISPLACEMENT", "reference": reference});
    let with = |members: Value| error("e", "Background_Grid", members);
    for (wrong, part) in [
        (with(u(json!({"type": "elastic_barr"}))), "did you mean \\\"elastic_bar\\\""),
        (with(u(json!({"type": "formula", "value": "X"}))), "has 1 entries, MP_DISPLACEMENT has 3"),
        (
            with(u(json!({"type": "table", "file": "none.csv", "columns": {"time": "t", "value": ["a", "b", "c"]}}))),
            "none.csv cannot be read",
        ),
        (with(json!({"variable": "MP_DISPLACMENT", "reference": bar(1.0)})), "did you mean \\\"MP_DISPLACEMENT\\\""),
        (with(json!({"variable": "MP_CAUCHY_STRESS_VECTOR", "reference": bar(1.0)})), "compare the component XX"),
        (with(json!({"variable": "MP_MASS", "reference": bar(1.0)})), "does not give MP_MASS"),
        (error("a/b", "Background_Grid", u(bar(1.0))), "slash"),
        (error("e", "Background_Grod", u(bar(1.0))), "there are no points in"),
        (with(json!({"variable": "MP_VELOCITY", "on": {"of": "points"}, "reference": bar(1.0)})), "either"),
        (
            with(json!({"variable": "DISPLACEMENT", "on": "point", "reference": bar(1.0)})),
            "did you mean \\\"points\\\"",
        ),
    ] {
        let set = [format!("/processes/measurements={}", json!([wrong]))];
        let arguments = ["run", "dgmpm.json", "--quiet", "--set", &set[0]];
        let ended = super::trial::bia(folder.path(), &arguments);
        let told = super::trial::text(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{told}");
        assert!(told.contains(&part.replace("\\\"", "\"")), "{part:?} is not in\n{told}");
    }
}
