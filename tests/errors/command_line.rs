//! Faults of the command line, of the place of results, and readers that go away.

use super::base::{PROJECT, Scene, listing};
use std::fs;
use std::process::{Command, Stdio};
use tempfile::TempDir;

#[test]
fn arguments() {
    let rows: &[(&[&str], &[&str])] = &[
        (&["--set", "/problem_data/end_time"], &["has no =", "/json/pointer=value"]),
        (&["--set", "problem_data/end_time=1"], &["problem_data/end_time", "a pointer looks like /"]),
        (&["--set", "/problem_dota/end_time=1"], &["/problem_dota/end_time", "its parent does not exist"]),
        (
            &["--set", "/problem_data/end_time=-1"],
            &["at /problem_data/end_time", "set on the command line", "end_time is -1"],
        ),
        (&["--set", "/processes/gravity/3=1"], &["no such entry"]),
        (&["--threads", "0"], &["--threads", "0"]),
        (&["--record", "r.json", "--record-states", "0"], &["--record-states", "0"]),
        (&["--record", "no/such/folder/r.json"], &["no/such/folder/r.json", "cannot be written"]),
        (&["--unknown"], &["--unknown"]),
    ];
    for (arguments, says) in rows {
        let outcome = Scene::base().command("run", arguments);
        assert_eq!(outcome.fault_as_refusal(says), None, "{arguments:?}");
    }
    let none = Command::new(env!("CARGO_BIN_EXE_bia")).args(["run", "Project.json"]).output().unwrap();
    let said = String::from_utf8_lossy(&none.stderr).into_owned();
    assert!(none.status.code() == Some(2) && said.contains("Project.json: cannot be read"), "{said}");
}

#[test]
fn a_folder_that_cannot_be_made_is_an_error() {
    let outcome = Scene::base().run(&["--output", "Grid.mdpa"]);
    let says = ["results cannot go to Grid.mdpa", "Grid.mdpa is no folder", "--output"];
    assert_eq!(outcome.fault_as_refusal(&says), None);
}

#[test]
fn a_run_that_fails_leaves_no_half_of_its_record() {
    let outcome = Scene::base().replace(PROJECT, "9.81", "-1e9").run(&["--record", "r.json"]);
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    assert_eq!(outcome.new_files, ["energy.dat", "failed_state.vtu"]);
}

/// The reading end of the pipe is closed before the program writes to it.
fn with_closed(stdout: bool, name: &str, scene: &Scene) -> (Option<i32>, String, Vec<String>) {
    let folder = TempDir::new().unwrap();
    scene.write_to(folder.path());
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let other = fs::File::create(folder.path().join("said")).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    command.current_dir(folder.path()).args([name, PROJECT]);
    let (out, err) = if stdout { (Stdio::from(writer), other.into()) } else { (other.into(), Stdio::from(writer)) };
    let status = command.stdout(out).stderr(err).status().unwrap();
    (status.code(), fs::read_to_string(folder.path().join("said")).unwrap(), listing(folder.path()))
}

#[test]
fn a_reader_that_goes_away_does_no_harm() {
    for name in ["check", "run"] {
        let (code, stderr, files) = with_closed(true, name, &Scene::base());
        assert!(code == Some(0) && !stderr.contains("panicked"), "{name}: {code:?} {stderr}");
        assert_eq!(files.contains(&"energy.dat".to_string()), name == "run");
    }
    let (code, _, _) = with_closed(false, "run", &Scene::base().replace(PROJECT, "\"newmark\"", "\"x\""));
    assert_eq!(code, Some(2));
    let (code, _, _) = with_closed(false, "run", &Scene::base().replace(PROJECT, "9.81", "-1e9"));
    assert_eq!(code, Some(3));
}
