//! `bia survey` on a tiny survey: every kind of result, each for its reason.

use super::trial::{bia, copy_projects, read, text};
use serde_json::{Value, json};
use std::path::Path;
use tempfile::TempDir;

fn survey() -> Value {
    let error = |max: f64, degraded: f64| json!([{"quantity": "/errors/displacement/relative_over_time", "max": max, "degraded": degraded, "text": "error"}]);
    let unstable = json!({"/solver_settings/time_stepping": {"time_step": 0.004}});
    json!({
        "title": "Tiny survey", "text": "Two scenes.",
        "methods": [{"label": "MPM", "text": "points"}, {"label": "FEM"}, {"label": "DGMPM"}],
        "scenes": [
            {"id": "S1", "title": "A wave", "text": "It is short.", "criteria": error(1e-9, 0.5), "runs": {
                "MPM": {"project": "mpm.json", "text": "as fine as it is"},
                "FEM": {"project": "fem.json", "criteria": error(1e-9, 1e-8)},
                "DGMPM": {"project": "dgmpm.json", "must": true},
            }},
            {"id": "S2", "title": "Too large a step", "criteria": [{"expect": "failed", "reason_contains": "UNSTABLE"}], "runs": {
                "MPM": {"project": "mpm.json", "set": unstable, "must": true},
                "FEM": {"project": "fem.json", "set": {"/solver_settings/solver_type": "structural_dynamik"},
                        "criteria": [{"quantity": "/steps", "min": 1}]},
                "DGMPM": {"cannot": "for the test's sake"},
            }},
            {"id": "S3", "title": "Too large a step, unawares", "criteria": [{"quantity": "/steps", "min": 1}], "runs": {
                "MPM": {"project": "mpm.json", "set": unstable},
            }},
        ],
    })
}

fn write(folder: &Path, survey: &Value) {
    copy_projects(folder);
    std::fs::write(folder.join("survey.json"), survey.to_string()).unwrap();
}

#[test]
fn every_cell_has_its_result_and_reason() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &survey());
    let ended = bia(folder.path(), &["survey", "survey.json", "--quiet"]);
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let results = read(&folder.path().join("survey_results/results.json"));
    let cell = |scene: &str, method: &str| {
        let cells = results["cells"].as_array().unwrap();
        cells.iter().find(|cell| cell["scene"] == scene && cell["method"] == method).unwrap().clone()
    };
    for (scene, method, result, reason) in [
        ("S1", "MPM", "degraded", "error"),
        ("S1", "FEM", "fails", "error"),
        ("S1", "DGMPM", "pass", "error"),
        ("S2", "MPM", "pass", "stops as it should"),
        ("S2", "FEM", "refused", "structural_dynamik"),
        ("S2", "DGMPM", "cannot", "for the test's sake"),
        ("S3", "MPM", "fails", "failed: the run is unstable"),
    ] {
        let cell = cell(scene, method);
        assert_eq!(cell["result"], result, "{cell:#}");
        assert!(cell["reason"].as_str().unwrap().contains(reason), "{cell:#}");
    }
    let page = std::fs::read_to_string(folder.path().join("survey_results/report.html")).unwrap();
    for part in ["3 scenes, 7 cells", "Of the 2 that must pass by theory, 2 do", "as fine as it is", "bytes a point"] {
        assert!(page.contains(part), "{part:?} is not in the page");
    }
    assert!(!page.contains("<script") && !page.contains("://"));
    let table = std::fs::read_to_string(folder.path().join("survey_results/results.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 7);
}

#[test]
fn wrong_surveys_are_told_as_wrong_projects_are() {
    let folder = TempDir::new().unwrap();
    let change = |pointer: &str, value: Value| {
        let mut survey = survey();
        *survey.pointer_mut(pointer).unwrap() = value;
        survey
    };
    for (wrong, part) in [
        (change("/scenes/0/criteria", json!([{"quantity": "/a"}])), "has neither \"max\" nor \"min\""),
        (change("/scenes/0/criteria", json!([])), "has no criteria"),
        (change("/scenes/1/id", json!("S1")), "another scene is called \"S1\", too"),
        (change("/scenes/2/runs", json!({"MPN": {"cannot": "x"}})), "did you mean \"MPM\"?"),
        (change("/scenes/2/runs/MPM", json!({"must": true})), "needs either \"project\" or \"cannot\""),
        (change("/scenes/0/criteria", json!([{"expect": "fail"}])), "did you mean \"failed\"?"),
    ] {
        write(folder.path(), &wrong);
        let ended = bia(folder.path(), &["survey", "survey.json"]);
        assert_eq!(ended.status.code(), Some(2));
        assert!(text(&ended.stderr).contains(part), "{part:?} is not in\n{}", text(&ended.stderr));
    }
}
