//! What cannot be resumed is refused, with the reason: nothing wrong comes out in silence.

use super::common::{Cell, Mesh, Scene, gravity, material};
use super::trial::{folder, outputs_of_points, results, run, run_until, succeed};
use bia_kernel::analysis::Analysis;
use bia_kernel::parameters::Document;
use bia_kernel::processes::{Process, RunOptions};
use bia_kernel::registry::{ProcessEntry, Registry};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

fn scene(folder: &Path) {
    let body = Mesh::block(Cell::Quadrilateral, [2, 2, 0], [0.3, 0.3, 0.0], [0.7, 0.7, 0.0]);
    let grid = Mesh::block(Cell::Quadrilateral, [5, 5, 0], [0.0; 3], [1.0, 1.0, 0.0]);
    let solver = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
                        "scheme_type": "forward_euler", "time_stepping": {"time_step": 0.001}});
    let law = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 4, 1000.0, 1e6, 0.3);
    Scene::new(grid, body, law, solver, 0.0195).with(gravity([0.0, -9.81, 0.0])).write(folder);
}

fn restart() -> Option<Value> {
    Some(json!({"every_steps": 4}))
}

fn checkpoints(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join("out/restart")).into_iter().flatten();
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found
}

#[test]
fn the_newest_two_are_kept_and_none_of_a_run_that_is_done() {
    let folder = folder(&scene, &[], restart());
    run_until(folder.path(), 13, false);
    let names: Vec<String> =
        checkpoints(folder.path()).iter().map(|p| p.file_name().unwrap().to_string_lossy().into_owned()).collect();
    assert_eq!(names, ["step_0000000012.checkpoint", "step_0000000013.checkpoint"]);
    succeed(folder.path(), &["--resume"]);
    assert!(checkpoints(folder.path()).is_empty());
    let (code, told) = run(folder.path(), &["--resume"]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("there is no checkpoint to resume from"), "{told}");
}

#[test]
fn damaged_checkpoints_are_told_and_skipped() {
    let (outputs, whole) = (outputs_of_points(3), folder(&scene, &outputs_of_points(3), None));
    succeed(whole.path(), &[]);
    for cut in [true, false] {
        let folder = folder(&scene, &outputs, restart());
        run_until(folder.path(), 13, false);
        let newest = checkpoints(folder.path()).pop().unwrap();
        let mut bytes = fs::read(&newest).unwrap();
        let middle = bytes.len() / 2;
        if cut {
            bytes.truncate(middle);
        } else {
            bytes[middle] ^= 1;
        }
        fs::write(&newest, bytes).unwrap();
        let (code, told) = run(folder.path(), &["--resume"]);
        assert_eq!(code, Some(0), "{told}");
        assert!(told.contains("step_0000000013.checkpoint is damaged"), "{told}");
        assert!(told.contains("step_0000000012"), "{told}");
        super::trial::assert_same("from the older one", &results(whole.path()), &results(folder.path()));
    }
    let folder = folder(&scene, &outputs, restart());
    run_until(folder.path(), 13, false);
    checkpoints(folder.path()).iter().for_each(|path| fs::write(path, "nothing").unwrap());
    let (code, told) = run(folder.path(), &["--resume"]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("none of the 2 checkpoints is whole"), "{told}");
}

#[test]
fn another_project_is_refused_with_both_values() {
    let edit = |name: &str, from: &str, to: &str| {
        let folder = folder(&scene, &[], restart());
        run_until(folder.path(), 5, false);
        let path = folder.path().join(name);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{name} has no {from}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let (code, told) = run(folder.path(), &["--resume"]);
        assert_eq!(code, Some(2), "{told}");
        told.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let told = edit("ProjectParameters.json", "0.001", "0.002");
    assert!(told.contains("/project/solver_settings/time_stepping/time_step was 0.001, and is now 0.002"), "{told}");
    let told = edit("materials.json", "1000000.0", "2000000.0");
    assert!(told.contains("/files/materials.json was \"CRC-32"), "{told}");
    let told = edit("body.mdpa", "0.5", "0.51");
    assert!(told.contains("/files/body.mdpa was \"CRC-32"), "{told}");
}

/// How often checkpoints are written may change; whether there is a record may not.
#[test]
fn settings_of_the_restart_may_change() {
    let folder = folder(&scene, &[], restart());
    run_until(folder.path(), 5, false);
    let bare = ["run", "ProjectParameters.json", "--output", "out", "--resume"];
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder.path()).args(bare).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("/record was 3, and is now null"), "{told}");
    succeed(folder.path(), &["--resume", "--set", "/restart/every_steps=7"]);
}

#[test]
fn a_run_without_resume_begins_anew() {
    let folder = folder(&scene, &outputs_of_points(3), restart());
    run_until(folder.path(), 13, false);
    run_until(folder.path(), 5, false);
    assert_eq!(checkpoints(folder.path()).len(), 2, "steps 4 and 5 of the new run");
    let whole = super::trial::folder(&scene, &outputs_of_points(3), None);
    succeed(whole.path(), &[]);
    succeed(folder.path(), &["--resume"]);
    super::trial::assert_same("anew", &results(whole.path()), &results(folder.path()));
}

#[test]
fn a_table_that_was_shortened_is_refused() {
    let folder = folder(&scene, &outputs_of_points(3), restart());
    run_until(folder.path(), 13, false);
    fs::write(folder.path().join("out/energy.dat"), "#").unwrap();
    let (code, told) = run(folder.path(), &["--resume"]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("energy.dat") && told.contains("holds 1 bytes"), "{told}");
}

/// A process from outside that does not say what it keeps.
struct Silent;

impl Process for Silent {
    fn name(&self) -> &str {
        "silent"
    }
}

const SILENT: ProcessEntry = ProcessEntry {
    name: "silent_process",
    aliases: &[],
    application: None,
    keys: &[],
    help: "says nothing",
    build: |_| Ok(Box::new(Silent)),
};

/// Told before the first step, and before a file is written.
#[test]
fn a_process_that_cannot_be_saved_is_refused() {
    let silent = super::common::process("silent_process", json!({}));
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    registry.process(SILENT);
    for restart in [restart(), None] {
        let asks = restart.is_some();
        let mut outputs = outputs_of_points(3);
        outputs.push(silent.clone());
        let folder = folder(&scene, &outputs, restart);
        let out = folder.path().join("out");
        let options = RunOptions { folder: folder.path().into(), output: out.clone(), ..RunOptions::default() };
        let document = Document::read(&folder.path().join("ProjectParameters.json")).unwrap();
        let mut analysis = Analysis::prepare(document, &registry, options, false).map_err(|e| e.to_string()).unwrap();
        let result = analysis.run(&mut (), None).map(|_| ()).map_err(|error| error.to_string());
        match asks {
            true => {
                let error = result.unwrap_err();
                assert!(error.contains("the process \"silent\" does not say what it keeps"), "{error}");
                assert_eq!(fs::read_dir(&out).unwrap().count(), 0);
            }
            false => result.unwrap(),
        }
    }
}
