//! Small projects against what Kratos 10.4.4 itself computed for them, with `--kratos-exact`.
//!
//! `tests/kratos/CASE/` holds a project as Kratos runs it and `reference.json`: of the first and the
//! last state the values of up to 24 points or conditions and 16 nodes, the largest magnitude of
//! each field over the run, the number of Newton iterations of every step, and the tolerances:
//! 100 times at least what a change of the body's nodes by 1e-12 m made in Kratos.

mod common;

use common::{Record, State, run_project};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Runs a copy of a case; results never land in the source tree.
fn run(case: &Path) -> Record {
    let folder = TempDir::new().unwrap();
    for entry in fs::read_dir(case).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    run_project(folder.path(), &["--kratos-exact", "--record-states", "1"])
}

/// The tolerance of a field, relative to its largest magnitude.
fn tolerance(reference: &Value, field: &str) -> f64 {
    let of_stress = ["STRESS", "STRAIN", "PRESSURE", "FORCE", "ACCELERATION", "REACTION", "strain"];
    let kind = if of_stress.iter().any(|word| field.contains(word)) { "stress" } else { "motion" };
    reference["tolerance"][kind].as_f64().unwrap()
}

/// Faults of the fields of points, conditions or nodes at the ids that the reference holds.
fn compare_kind(reference: &Value, expected: &Value, kind: &str, state: State) -> Vec<String> {
    let ids: Vec<u64> = state.json[kind]["ids"].as_array().unwrap().iter().map(|id| id.as_u64().unwrap()).collect();
    let wanted = expected[kind]["ids"].as_array().unwrap().iter().map(|id| id.as_u64().unwrap());
    let rows: Vec<usize> = wanted.map(|id| ids.iter().position(|i| *i == id).expect("the id exists")).collect();
    let mut faults = Vec::new();
    for field in expected[kind].as_object().unwrap().keys().filter(|field| *field != "ids") {
        let name = format!("{kind}.{field}");
        let theirs = State { json: expected }.field(kind, field);
        let ours = state.field(kind, field);
        let ours: Vec<Vec<f64>> = rows.iter().map(|&row| ours[row].clone()).collect();
        let largest = reference["largest"][&name].as_f64().unwrap();
        // A field that is zero in Kratos must be zero here, up to round-off of its unit.
        let scale = if largest > 0.0 { largest } else { 1.0 };
        let difference = common::largest_difference(&ours, &theirs) / scale;
        if difference > tolerance(reference, &name) {
            faults.push(format!("{name} at step {} differs by {difference:.1e}", state.step()));
        }
    }
    faults
}

fn compare(reference: &Value, record: &Record) -> Vec<String> {
    let mut faults = Vec::new();
    for key in ["n_mp", "steps", "iterations"] {
        if reference[key] != record.json[key] {
            faults.push(format!("{key}: {}, Kratos {}", record.json[key], reference[key]));
        }
    }
    for (expected, state) in reference["states"].as_array().unwrap().iter().zip(record.states()) {
        assert_eq!(expected["step"], state.json["step"]);
        for kind in ["mp", "mpc", "nodes"].into_iter().filter(|kind| expected[kind].is_object()) {
            faults.extend(compare_kind(reference, expected, kind, state));
        }
        let largest = reference["largest"]["energies"].as_f64().unwrap().max(f64::MIN_POSITIVE);
        for (name, theirs) in expected["energies"].as_object().unwrap() {
            let difference = (state.energy(name) - theirs.as_f64().unwrap()).abs() / largest;
            if difference.is_nan() || difference > tolerance(reference, name) {
                faults.push(format!("{name} energy at step {} differs by {difference:.1e}", state.step()));
            }
        }
    }
    faults
}

#[test]
fn cases_agree_with_kratos() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/kratos");
    let mut cases: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    cases.sort();
    assert!(cases.len() >= 12, "{} cases", cases.len());
    let mut report = String::new();
    for case in &cases {
        let text = fs::read_to_string(case.join("reference.json")).unwrap();
        let reference: Value = serde_json::from_str(&text).unwrap();
        let faults = compare(&reference, &run(case));
        if !faults.is_empty() {
            report += &format!("{}:\n  {}\n", case.file_name().unwrap().display(), faults.join("\n  "));
        }
    }
    assert!(report.is_empty(), "differences from Kratos 10.4.4:\n{report}");
}
