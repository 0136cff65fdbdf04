//! Small projects and studies in temporary folders.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Projects of the step-loaded bar.
pub fn projects() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/studies/step_bar")
}

/// Copies the projects of the bar into a folder, with a tenth of its time.
pub fn copy_projects(folder: &Path) {
    for name in ["mpm.json", "fem.json", "dgmpm.json"] {
        let text = std::fs::read_to_string(projects().join(name)).unwrap();
        let mut project: Value = serde_json::from_str(&text).unwrap();
        project["problem_data"]["end_time"] = json!(0.008);
        std::fs::write(folder.join(name), project.to_string()).unwrap();
    }
}

pub const GRID: &str = "/modelers/0/parameters/divisions";
pub const BODY: &str = "/modelers/1/parameters/bodies/0/divisions";

/// Runs the program.
pub fn bia(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bia")).current_dir(folder).args(arguments).output().unwrap()
}

/// Runs a project with its summary.
pub fn summary(folder: &Path, project: &str, set: &[String]) -> Value {
    let mut arguments = vec!["run", project, "--quiet", "--threads", "1", "--summary", "summary.json"];
    set.iter().for_each(|set| arguments.extend(["--set", set]));
    let ended = bia(folder, &arguments);
    assert!(folder.join("summary.json").is_file(), "{}", text(&ended.stderr));
    read(&folder.join("summary.json"))
}

pub fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Rows of a table of comma-separated values, as texts.
pub fn rows(path: &Path) -> Vec<Vec<String>> {
    let table = std::fs::read_to_string(path).unwrap();
    table.lines().map(|line| line.split(',').map(str::to_string).collect()).collect()
}
