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
    for part in [
        "3 scenes, 7 cells",
        "Of the 2 that must pass by theory, 2 do",
        "as fine as it is",
        "bytes a point",
        "the fullest of all: S",
    ] {
        assert!(page.contains(part), "{part:?} is not in the page");
    }
    assert!(!page.contains("<script") && !page.contains("://"));
    let table = std::fs::read_to_string(folder.path().join("survey_results/results.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 7);
}

/// What is the same for several runs stands in the survey once: with their method, their scene, or a run or
/// scene that they are like. The plan shows what each run comes to.
#[test]
fn what_runs_share_stands_once() {
    let folder = TempDir::new().unwrap();
    let set_end = |end: Value| json!({"/problem_data/end_time": end});
    let steps = |min: f64| json!([{"quantity": "/steps", "min": min}]);
    let survey = json!({
        "title": "Shared",
        "methods": [
            {"label": "A", "set": {"/problem_data/problem_name": "a", "/problem_data/start_time": 0.0}},
            {"label": "B", "criteria": steps(3.0)},
            {"label": "C"},
        ],
        "scenes": [
            {"id": "S1", "title": "one", "project": "mpm.json", "set": set_end(json!(1.0)), "values": {"last": 7.0}, "criteria": steps(1.0), "runs": {
                "A": {"must": true, "unset": ["/problem_data/start_time"], "more_criteria": steps(2.0)},
                "B": {"like": "A", "set": {"/problem_data/problem_name": "b"}, "must": false},
                "C": {"project": "fem.json", "set": set_end(json!("${last}"))},
            }},
            {"id": "S2", "title": "two", "like": "S1", "set": set_end(json!(2.0)), "runs": {
                "B": {"unset": ["/problem_data/problem_name"], "criteria": steps(9.0)},
                "C": {"cannot": "for no reason"},
            }},
        ],
    });
    write(folder.path(), &survey);
    let ended = bia(folder.path(), &["survey", "survey.json", "--dry-run", "--json"]);
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let plan: Value = serde_json::from_slice(&ended.stdout).unwrap();
    let (name, end) = ("/problem_data/problem_name", "/problem_data/end_time");
    for (index, (scene, method, project, set, least, must)) in [
        ("S1", "A", "mpm.json", json!([[name, "a"], [end, 1.0]]), vec![1.0, 2.0], true),
        ("S1", "B", "mpm.json", json!([[end, 1.0], [name, "b"]]), vec![1.0, 2.0, 3.0], false),
        ("S1", "C", "fem.json", json!([[end, 7.0]]), vec![1.0], false),
        ("S2", "A", "mpm.json", json!([[name, "a"], [end, 2.0]]), vec![1.0, 2.0], true),
        ("S2", "B", "mpm.json", json!([[end, 2.0]]), vec![9.0], false),
    ]
    .into_iter()
    .enumerate()
    {
        let run = &plan[index];
        assert_eq!((run["scene"].as_str(), run["method"].as_str()), (Some(scene), Some(method)), "{run:#}");
        assert_eq!((&run["set"], &run["project"], &run["must"]), (&set, &json!(project), &json!(must)), "{run:#}");
        let found: Vec<f64> = run["criteria"].as_array().unwrap().iter().map(|c| c["min"].as_f64().unwrap()).collect();
        assert_eq!(found, least, "{run:#}");
    }
    assert_eq!(plan.as_array().unwrap().len(), 5, "nothing else is run");
    for (pointer, value, part) in [
        ("/scenes/1/like", json!("S3"), "\"S3\" is no scene before this one"),
        ("/scenes/0/runs/B/like", json!("C"), "\"C\" is no method with a run before this one"),
        ("/scenes/0/runs/A/unset", json!([end, "/none"]), "is set neither by the method nor by the scene"),
    ] {
        let mut wrong = survey.clone();
        *wrong.pointer_mut(pointer).unwrap() = value;
        write(folder.path(), &wrong);
        let ended = bia(folder.path(), &["survey", "survey.json", "--dry-run"]);
        assert_eq!(ended.status.code(), Some(2));
        assert!(text(&ended.stderr).contains(part), "{part:?} is not in\n{}", text(&ended.stderr));
    }
}

/// What another program did, for the survey above.
fn beside() -> Value {
    json!({
        "program": "Other", "version": "1.2", "date": "today", "text": "by hand",
        "methods": {"FEM": "elements", "MPM": "points"},
        "scenes": {
            "S1": {"MPM": {"end": "done", "steps": 7, "cpu_s": 0.25, "found": {"error": -0.25}},
                   "FEM": {"end": "done", "found": {"error": 1e-10}}},
            "S2": {"MPM": {"end": "failed", "reason": "in its own words"}, "FEM": {"end": "input", "reason": "no such thing"}},
            "S3": {"MPM": {"end": "done"}},
        },
    })
}

/// Results of another program are judged by the criteria of the survey's own runs, in columns of their own.
#[test]
fn other_programs_stand_beside() {
    let folder = TempDir::new().unwrap();
    let mut survey = survey();
    survey["beside"] = json!(["other.json"]);
    write(folder.path(), &survey);
    std::fs::write(folder.path().join("other.json"), beside().to_string()).unwrap();
    let ended = bia(folder.path(), &["survey", "survey.json", "--quiet"]);
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let results = read(&folder.path().join("survey_results/results.json"));
    let cells = results["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 7 + 5);
    for (scene, method, result, reason) in [
        ("S1", "Other 1.2: points", "degraded", "error 0.250"),
        ("S1", "Other 1.2: elements", "pass", "error"),
        ("S2", "Other 1.2: points", "pass", "stops as it should: in its own words"),
        ("S2", "Other 1.2: elements", "refused", "no such thing"),
        ("S3", "Other 1.2: points", "unmeasured", "was not measured"),
    ] {
        let cell = cells.iter().find(|cell| cell["scene"] == scene && cell["method"] == method).unwrap();
        assert_eq!(cell["result"], result, "{cell:#}");
        assert!(cell["reason"].as_str().unwrap().contains(reason), "{cell:#}");
    }
    let page = std::fs::read_to_string(folder.path().join("survey_results/report.html")).unwrap();
    let parts = ["3 scenes, 7 cells", "Other 1.2 on 5 of these cells", "Other 1.2, measured today: by hand", "0.250 s"];
    for part in parts {
        assert!(page.contains(part), "{part:?} is not in the page");
    }
    for (pointer, value, part) in [
        ("/scenes/S1/MPM/found", json!({"eror": 1}), "did you mean \"error\"?"),
        ("/scenes/S1/MPM/found", json!({"error": "1"}), "must be a number, or null"),
        ("/scenes", json!({"S4": {}}), "is no scene of this survey"),
        ("/scenes/S1", json!({"MPN": {"end": "done"}}), "did you mean \"MPM\"?"),
        ("/scenes/S1", json!({"DGMPM": {"end": "done"}}), "is none of the methods above"),
        ("/scenes/S2/MPM/end", json!("fail"), "did you mean \"failed\"?"),
    ] {
        let mut wrong = beside();
        *wrong.pointer_mut(pointer).unwrap() = value;
        std::fs::write(folder.path().join("other.json"), wrong.to_string()).unwrap();
        let ended = bia(folder.path(), &["survey", "survey.json", "--dry-run"]);
        assert_eq!(ended.status.code(), Some(2));
        let told = text(&ended.stderr);
        assert!(told.contains(part) && told.contains("other.json"), "{part:?} is not in\n{told}");
    }
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
