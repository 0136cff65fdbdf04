//! Runs that are killed, and stopped by signals, at arbitrary moments.

use super::common::{Cell, Mesh, Scene, fix, gravity, material};
use super::trial::{assert_same, command, folder, outputs_of_points, results, succeed};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn scene(solver: &Value, law: &str, end: f64) -> Scene {
    let body = Mesh::block(Cell::Quadrilateral, [8, 8, 0], [0.0; 3], [1.0, 1.0, 0.0]);
    let grid = Mesh::block(Cell::Quadrilateral, [16, 12, 0], [-0.5, 0.0, 0.0], [1.5, 1.5, 0.0]);
    Scene::new(grid, body, material(law, 4, 1000.0, 1e5, 0.3), solver.clone(), end)
        .part("Floor", |x| x[1] == 0.0)
        .with(fix("Floor", json!([0.0, 0.0, null])))
        .with(gravity([1.0, -9.81, 0.0]))
}

fn start(folder: &Path, resumes: bool) -> Child {
    let mut command = command(folder, &["--quiet", "--threads", if resumes { "2" } else { "1" }]);
    if resumes && std::fs::read_dir(folder.join("out/restart")).is_ok_and(|mut files| files.next().is_some()) {
        command.arg("--resume");
    }
    command.stderr(Stdio::piped()).spawn().unwrap()
}

/// Kills a run and its successors again and again, each a little later after its start, until one ends.
fn kill_again_and_again(told: &str, scene: &Scene, every_steps: usize) {
    let (write, outputs) = (|folder: &Path| scene.write(folder), outputs_of_points(5));
    let whole = folder(&write, &outputs, None);
    let begin = Instant::now();
    succeed(whole.path(), &["--quiet", "--threads", "1"]);
    let mut patience = begin.elapsed() / 5;
    // On a machine with other work a run may take much less time than the first one did.
    for _ in 0..8 {
        let pieces = folder(&write, &outputs, Some(json!({"every_steps": every_steps})));
        let kills = kill_until_one_ends(told, pieces.path(), patience);
        assert_same(&format!("{told}, killed {kills} times"), &results(whole.path()), &results(pieces.path()));
        if kills > 2 {
            return;
        }
        patience /= 2;
    }
    panic!("{told}: the run always ended before it was killed three times");
}

/// Gives how often the run was killed.
fn kill_until_one_ends(told: &str, pieces: &Path, mut patience: Duration) -> u64 {
    let mut kills = 0;
    loop {
        let mut child = start(pieces, kills > 0);
        std::thread::sleep(patience);
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            child.wait().unwrap();
            kills += 1;
            // Moments that have nothing to do with the steps.
            patience += Duration::from_micros(7919 * kills % 9973);
            assert!(kills < 200, "{told}: no progress");
            continue;
        }
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{told} after {kills} kills: {message}");
        return kills;
    }
}

#[test]
fn killed_runs_leave_no_trace() {
    let law = "HyperElasticNeoHookeanPlaneStrain2DLaw";
    let explicit = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
                          "scheme_type": "forward_euler", "stress_update": "musl",
                          "time_stepping": {"time_step": 0.0005}});
    kill_again_and_again("explicit", &scene(&explicit, law, 0.4), 7);
    let implicit = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": 0.002},
                          "residual_relative_tolerance": 1e-7});
    kill_again_and_again("implicit", &scene(&implicit, law, 0.12), 3);
}

/// The run finishes its step, writes a checkpoint and says by its exit code what stopped it.
#[cfg(unix)]
#[test]
fn signals_stop_a_run_after_a_step() {
    let explicit = json!({"solver_type": "dynamic", "time_integration_method": "explicit",
                          "scheme_type": "forward_euler", "time_stepping": {"time_step": 0.0005}});
    let scene = scene(&explicit, "HyperElasticNeoHookeanPlaneStrain2DLaw", 3.0);
    let (write, outputs) = (|folder: &Path| scene.write(folder), outputs_of_points(500));
    let whole = folder(&write, &outputs, None);
    succeed(whole.path(), &["--quiet", "--threads", "1"]);
    let pieces = folder(&write, &outputs, Some(json!({})));
    for (signal, code, resumes) in [("-INT", 130, false), ("-TERM", 143, true)] {
        let mut child = start(pieces.path(), resumes);
        std::thread::sleep(Duration::from_millis(100));
        assert!(child.try_wait().unwrap().is_none(), "the run was over before the signal");
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
    }
    succeed(pieces.path(), &["--quiet", "--resume"]);
    assert_same("after two signals", &results(whole.path()), &results(pieces.path()));
}
