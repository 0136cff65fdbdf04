//! `bia study` on a tiny study: its report, what is not run again, trouble, and wrong files.

use super::trial::{BODY, GRID, bia, copy_projects, read, rows, text};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};
use tempfile::TempDir;

fn study(repetitions: usize) -> Value {
    let mesh = |n: u32| json!({"label": format!("n={n}"), "h": 5.0 / f64::from(n), "values": {"n": n}});
    json!({
        "title": "Tiny <study>", "text": "What & why.", "advice": "Take the exact one.",
        "error": "/errors/displacement/relative_over_time", "repetitions": repetitions, "wanted_errors": [0.05, 1e-30],
        "sweep": [mesh(4), mesh(8), mesh(16)],
        "variants": [
            {"label": "MPM", "project": "mpm.json", "set": {GRID: ["${n}"], BODY: ["${n}"]}},
            {"label": "FEM", "project": "fem.json", "set": {GRID: ["${n}"]}},
            {"label": "DGMPM", "project": "dgmpm.json", "set": {GRID: ["${n}"]}},
            {"label": "unstable", "project": "mpm.json",
             "set": {GRID: ["${n}"], BODY: ["${n}"], "/solver_settings/time_stepping": {"time_step": 0.004}}},
            {"label": "refused", "project": "mpm.json", "set": {"/solver_settings/transfer": "apec"}},
        ],
    })
}

fn write(folder: &Path, study: &Value) {
    copy_projects(folder);
    std::fs::write(folder.join("study.json"), study.to_string()).unwrap();
}

/// What does not depend on the machine: variant, label, h, …, error, order, end and reason.
fn steady(folder: &Path) -> Vec<Vec<String>> {
    let rows = rows(&folder.join("study_results/results.csv"));
    let end = rows[0].iter().position(|name| name == "end").unwrap();
    assert_eq!(rows[0][10], "cpu_s");
    rows.iter().map(|row| [&row[..10], &row[end..]].concat()).collect()
}

fn modified(folder: &Path) -> Vec<(String, SystemTime)> {
    let entries = std::fs::read_dir(folder.join("study_results/runs")).unwrap().flatten();
    let of = |entry: std::fs::DirEntry| {
        (entry.file_name().to_string_lossy().into_owned(), entry.metadata().unwrap().modified().unwrap())
    };
    let mut all: Vec<_> = entries.map(of).collect();
    all.sort();
    all
}

#[test]
fn a_study_reports_errors_orders_times_and_troubles() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &study(2));
    let ended = bia(folder.path(), &["study", "study.json", "--html", "deep/page.html"]);
    let told = text(&ended.stderr);
    assert!(ended.status.success(), "{told}");
    assert!(told.contains("[26/30]") && told.contains("left"), "{told}");
    assert!(text(&ended.stdout).contains("15 cases, 4 did not end well"), "{}", text(&ended.stdout));

    let results = read(&folder.path().join("study_results/results.json"));
    let run = |variant: &str, label: &str| {
        let runs = results["runs"].as_array().unwrap();
        runs.iter().find(|run| run["variant"] == variant && run["label"] == label).unwrap().clone()
    };
    for variant in ["MPM", "FEM"] {
        let order = run(variant, "n=16")["order"].as_f64().unwrap();
        assert!((0.4..1.6).contains(&order), "{variant}: {order}");
        assert_eq!(run(variant, "n=16")["repeatable"], true);
    }
    assert!(run("DGMPM", "n=8")["error"].as_f64().unwrap() < 1e-12);
    assert!(run("FEM", "n=8")["cpu_s"]["median"].as_f64().unwrap() > 0.0);
    let front = results["pareto"].as_array().unwrap();
    assert!(front.iter().any(|name| name.as_str().unwrap().starts_with("DGMPM")), "{front:?}");
    // Some runs are not to be had, with their reasons; the others are there all the same.
    assert_eq!(run("unstable", "n=16")["end"], "failed");
    assert!(run("unstable", "n=16")["reason"].as_str().unwrap().contains("unstable"));
    assert_eq!(run("refused", "n=4")["end"], "input");
    assert!(run("refused", "n=4")["reason"].as_str().unwrap().contains("apec"));
    assert!(run("FEM", "n=8")["command"].as_str().unwrap().contains("--set '/modelers/0/parameters/divisions=[8]'"));

    let page = std::fs::read_to_string(folder.path().join("deep/page.html")).unwrap();
    assert_eq!(page, std::fs::read_to_string(folder.path().join("study_results/report.html")).unwrap());
    for part in
        ["Tiny &lt;study&gt;", "What &amp; why.", "Take the exact one.", "order 1", "apec", "prefers-color-scheme"]
    {
        assert!(page.contains(part), "{part:?} is not in the page");
    }
    assert_eq!(page.matches("<svg").count(), 2);
    assert!(!page.contains("<script") && !page.contains("src=") && page.len() < 400_000);
    assert!(!page.contains("://") || page.matches("://").count() == page.matches("http://www.w3.org/2000/svg").count());
}

/// Every study that is shipped can be run: its pointers lead somewhere, its projects are right.
#[test]
fn shipped_studies_are_right() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seen = 0;
    for entry in std::fs::read_dir(root.join("examples/studies")).unwrap().flatten() {
        let study = format!("examples/studies/{}/study.json", entry.file_name().to_string_lossy());
        let planned = bia(root, &["study", &study, "--dry-run"]);
        assert!(planned.status.success(), "{study}: {}", text(&planned.stderr));
        assert!(text(&planned.stdout).lines().count() >= 12, "{study}");
        let page = root.join(format!("docs/studies/{}.html", entry.file_name().to_string_lossy()));
        assert!(page.is_file(), "{study} has no page in the documentation");
        for file in std::fs::read_dir(entry.path()).unwrap().flatten().map(|file| file.path()) {
            if file.extension().is_some_and(|extension| extension == "json") && !file.ends_with("study.json") {
                let checked = bia(root, &["check", &file.to_string_lossy()]);
                assert!(checked.status.success(), "{}: {}", file.display(), text(&checked.stderr));
            }
        }
        seen += 1;
    }
    assert!(seen >= 5, "{seen} studies");
}

/// An error may be made of any numbers of the summary.
#[test]
fn an_error_may_be_a_difference() {
    let folder = TempDir::new().unwrap();
    let mut tiny = study(1);
    tiny["variants"].as_array_mut().unwrap().truncate(2);
    tiny["error"] = json!({"quantity": "/steps", "minus": "/cells", "over": 2});
    write(folder.path(), &tiny);
    assert!(bia(folder.path(), &["study", "study.json", "--quiet"]).status.success());
    for run in read(&folder.path().join("study_results/results.json"))["runs"].as_array().unwrap() {
        let number = |pointer: &str| run["summary"].pointer(pointer).and_then(Value::as_f64).unwrap();
        assert_eq!(run["error"].as_f64().unwrap(), ((number("/steps") - number("/cells")) / 2.0).abs());
    }
}

/// What is done is not done again, unless its inputs have changed.
#[test]
fn finished_runs_are_kept() {
    let folder = TempDir::new().unwrap();
    write(folder.path(), &study(1));
    let run = || {
        let ended = bia(folder.path(), &["study", "study.json"]);
        assert!(ended.status.success(), "{}", text(&ended.stderr));
        text(&ended.stderr).lines().filter(|line| line.starts_with('[')).count()
    };
    assert_eq!(run(), 15);
    let (before, first) = (modified(folder.path()), steady(folder.path()));
    assert_eq!(run(), 0);
    assert_eq!((modified(folder.path()), steady(folder.path())), (before, first));
    // Another value in the project of one variant.
    let path = folder.path().join("fem.json");
    let mut project = read(&path);
    project["solver_settings"]["time_stepping"]["courant_number"] = json!(0.5);
    std::fs::write(&path, project.to_string()).unwrap();
    assert_eq!(run(), 3);
}

/// Killed at any time and started again, a study gives the same report.
#[test]
fn a_killed_study_goes_on() {
    let (whole, killed) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    write(whole.path(), &study(2));
    write(killed.path(), &study(2));
    assert!(bia(whole.path(), &["study", "study.json", "--quiet"]).status.success());
    let runs = killed.path().join("study_results/runs");
    for wanted in [1, 4, 9] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
        command.current_dir(killed.path()).args(["study", "study.json", "--quiet"]).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let begin = Instant::now();
        let finished = || {
            std::fs::read_dir(&runs)
                .map_or(0, |entries| entries.flatten().filter(|e| e.path().extension().is_some()).count())
        };
        while finished() < wanted && child.try_wait().unwrap().is_none() {
            assert!(begin.elapsed() < Duration::from_secs(60), "no run was kept");
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!killed.path().join("study_results/results.csv").exists(), "it was killed too late to show anything");
    }
    assert!(bia(killed.path(), &["study", "study.json", "--quiet"]).status.success());
    assert_eq!(steady(killed.path()), steady(whole.path()));
    let left =
        std::fs::read_dir(&runs).unwrap().flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    assert_eq!(left.filter(|name| name.starts_with("unfinished_") || name.starts_with('.')).count(), 0);
}

/// No run outlives its study.
#[cfg(target_os = "linux")]
#[test]
fn runs_end_with_a_killed_study() {
    let folder = TempDir::new().unwrap();
    let mut long = study(1);
    long["variants"] = json!([{"label": "long", "project": "mpm.json", "set": {"/problem_data/end_time": 1e6}}]);
    long["sweep"] = json!([{"label": "only"}]);
    write(folder.path(), &long);
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let results = folder.path().join("results").to_string_lossy().into_owned();
    command.current_dir(folder.path()).args(["study", "study.json", "--quiet", "--output", &results]);
    let mut child = command.spawn().unwrap();
    let runs = || {
        let of = |entry: std::fs::DirEntry| std::fs::read(entry.path().join("cmdline")).ok();
        let lines = std::fs::read_dir("/proc").into_iter().flatten().flatten().filter_map(of);
        lines.filter(|line| text(line).contains("--end-with-input") && text(line).contains(&results)).count()
    };
    let begin = Instant::now();
    let wait_for = |count: usize| {
        while runs() != count {
            assert!(begin.elapsed() < Duration::from_secs(20), "never {count} runs");
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    wait_for(1);
    child.kill().unwrap();
    child.wait().unwrap();
    wait_for(0);
}

/// A run that takes too long is ended, and told so; with more time it is run again.
#[test]
fn a_run_without_end_is_ended() {
    let folder = TempDir::new().unwrap();
    let mut tiny = study(1);
    tiny["variants"] = json!([{"label": "long", "project": "mpm.json", "set": {"/problem_data/end_time": 1e6}}]);
    tiny["sweep"] = json!([{"label": "only"}]);
    tiny["time_limit"] = json!(0.3);
    write(folder.path(), &tiny);
    assert!(bia(folder.path(), &["study", "study.json", "--quiet"]).status.success());
    let results = read(&folder.path().join("study_results/results.json"));
    assert_eq!(results["runs"][0]["end"], "timed_out");
    assert!(results["runs"][0]["reason"].as_str().unwrap().contains("0.3 s"));
}

#[test]
fn wrong_studies_are_told_as_wrong_projects_are() {
    let folder = TempDir::new().unwrap();
    let variant = |members: Value| {
        let mut study = study(1);
        let of = study["variants"][0].as_object_mut().unwrap();
        of.extend(members.as_object().unwrap().clone());
        study
    };
    let with = |key: &str, value: Value| {
        let mut study = study(1);
        study[key] = value;
        study
    };
    for (wrong, part) in [
        (with("repetitons", json!(3)), "did you mean \"repetitions\"?"),
        (with("repetitions", json!(0)), "a whole number of at least 1"),
        (with("variants", json!([])), "names no variant"),
        (with("error", json!({"quantity": "errors"})), "looks at nothing"),
        (with("error", json!({"quantity": "/steps", "minus": "x"})), "must be a number, or a JSON pointer"),
        (with("wanted_errors", json!([-1])), "must be a number above 0"),
        (variant(json!({"project": "mpn.json"})), "mpm.json"),
        (variant(json!({"label": "FEM"})), "another variant is called \"FEM\", too"),
        (variant(json!({"set": {"/solver_setings/echo_level": 1}})), "did you mean /solver_settings?"),
        (variant(json!({"set": {"solver_settings": 1}})), "is no JSON pointer"),
        (variant(json!({"set": {GRID: ["${m}"]}})), "did you mean \"n\"?"),
        (variant(json!({"sweep": []})), "has no \"sweep\""),
    ] {
        write(folder.path(), &wrong);
        let ended = bia(folder.path(), &["study", "study.json"]);
        let told = text(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "{told}");
        assert!(told.contains(part), "{part:?} is not in\n{told}");
        assert!(!folder.path().join("study_results").exists(), "nothing is written");
    }
    let missing = bia(folder.path(), &["study", "stuby.json"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(text(&missing.stderr).contains("study.json"), "{}", text(&missing.stderr));
}
