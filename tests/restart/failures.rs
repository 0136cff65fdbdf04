//! A run that fails leaves the state of a good step, and goes on from there with other settings: to the
//! same bits as a run that had these settings from the start, as they change nothing before the failure.

use super::common::{Cell, Mesh, Scene, gravity, material, process};
use super::trial::{assert_same, folder, outputs_of_points, results, run, succeed};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

const LAW: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";

/// A block on rollers of which the top is pressed down ever faster: one step does not converge as a whole.
fn pressed(folder: &Path) {
    let mesh = Mesh::block(Cell::Quadrilateral, [2, 2, 0], [0.0; 3], [1.0, 1.0, 0.0]);
    let solver = json!({"solver_type": "dynamic", "scheme_type": "newmark", "frame": "total_lagrangian",
        "time_stepping": {"time_step": 0.01}, "max_iteration": 3, "residual_relative_tolerance": 1e-6,
        "on_no_convergence": "error"});
    let held = |part: &str, value: Value| super::common::fix(part, value);
    Scene::new(mesh.clone(), mesh, material(LAW, 4, 1000.0, 1e6, 0.3), solver, 0.095)
        .part("Floor", |x| x[1] == 0.0)
        .part("Top", |x| x[1] == 1.0)
        .with(held("Floor", json!([0.0, 0.0, null])))
        .with(held("Top", json!([0.0, "-2200*t**4", null])))
        .write(folder);
}

/// A block that flies out of its grid.
fn flying(folder: &Path) {
    let body = Mesh::block(Cell::Quadrilateral, [2, 2, 0], [0.5, 0.3, 0.0], [0.9, 0.7, 0.0]);
    let grid = Mesh::block(Cell::Quadrilateral, [5, 5, 0], [0.0; 3], [1.0, 1.0, 0.0]);
    let solver = json!({"solver_type": "dynamic", "time_integration_method": "explicit", "lost_points": "error",
                        "scheme_type": "forward_euler", "time_stepping": {"time_step": 0.001}});
    let velocity = json!({"model_part_name": "MPM_Material", "modulus": 10.0, "direction": [1.0, 0.0, 0.0]});
    Scene::new(grid, body, material(LAW, 4, 1000.0, 1e5, 0.3), solver, 0.0295)
        .with(gravity([0.0, -9.81, 0.0]))
        .with(process("assign_initial_velocity_to_material_point_process", velocity))
        .write(folder);
}

/// Changes a setting of the solver in the project's file.
fn set(folder: &Path, name: &str, value: &Value) {
    let path = folder.join("ProjectParameters.json");
    let mut project: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    project["solver_settings"][name] = value.clone();
    fs::write(path, project.to_string()).unwrap();
}

/// The run fails as it is; with another setting it goes on and leaves what it would have left with that
/// setting from the start.
fn assert_goes_on(write: &dyn Fn(&Path), says: &str, name: &str, value: &Value) {
    let outputs = outputs_of_points(2);
    let whole = folder(write, &outputs, None);
    set(whole.path(), name, value);
    succeed(whole.path(), &["--threads", "1", "--quiet"]);
    for restart in [json!({}), json!({"every_steps": 2})] {
        let failed = folder(write, &outputs, Some(restart));
        let (code, told) = run(failed.path(), &["--quiet"]);
        assert_eq!(code, Some(3), "{told}");
        assert!(told.contains(says) && told.contains("bia run --resume goes on from there"), "{told}");
        let (code, again) = run(failed.path(), &["--quiet", "--resume"]);
        assert_eq!(code, Some(3), "the same settings fail again: {again}");
        set(failed.path(), name, value);
        let (code, told) = run(failed.path(), &["--resume", "--threads", "2"]);
        assert_eq!(code, Some(0), "{told}");
        assert!(told.contains(&format!("resumed with another setting: {name} was ")), "{told}");
        fs::remove_file(failed.path().join("out/failed_state.vtu")).ok();
        assert_same(name, &results(whole.path()), &results(failed.path()));
    }
}

#[test]
fn steps_that_do_not_converge_are_cut_after_the_failure() {
    assert_goes_on(&pressed, "did not converge", "on_no_convergence", &json!("cut_step"));
}

#[test]
fn points_that_leave_are_erased_or_clamped_after_the_failure() {
    for policy in ["erase", "clamp"] {
        assert_goes_on(&flying, "has left the grid", "lost_points", &json!(policy));
    }
}

/// A smaller step can be chosen where the run has failed; the step and the time go on from there.
#[test]
fn a_smaller_time_step_goes_on_from_the_failure() {
    let failed = folder(&pressed, &outputs_of_points(2), Some(json!({"every_steps": 2})));
    assert_eq!(run(failed.path(), &["--quiet"]).0, Some(3));
    set(failed.path(), "time_stepping", &json!({"time_step": 0.005}));
    set(failed.path(), "max_iteration", &json!(20));
    let (code, told) = run(failed.path(), &["--resume"]);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("time_stepping/time_step was 0.01, and is now 0.005"), "{told}");
    let record: Value = serde_json::from_slice(&fs::read(failed.path().join("out/record.json")).unwrap()).unwrap();
    let (end, steps) = (record["end_time"].as_f64().unwrap(), record["steps"].as_u64().unwrap());
    assert!((end - 0.095).abs() < 1e-12, "{end}");
    // Step 10 fails; step 8 has a checkpoint, and step 9 is kept where that takes next to no time of the run.
    assert!(steps == 8 + 3 || steps == 9 + 1, "{steps} steps, the first of them large");
    let states = record["snapshots"].as_array().unwrap();
    assert_eq!(states.last().unwrap()["step"], steps, "the last state is in the record");
}

/// What decides what the state means must stay as it was.
#[test]
fn other_settings_may_not_change() {
    let failed = folder(&flying, &[], Some(json!({})));
    assert_eq!(run(failed.path(), &["--quiet"]).0, Some(3));
    set(failed.path(), "stress_update", &json!("usl"));
    let (code, told) = run(failed.path(), &["--resume"]);
    assert_eq!(code, Some(2), "{told}");
    assert!(told.contains("/project/solver_settings/stress_update was null, and is now \"usl\""), "{told}");
}

/// In the first step of all, and in the header what went wrong.
#[test]
fn the_first_step_may_fail_and_the_header_says_how() {
    let write = |folder: &Path| {
        pressed(folder);
        set(folder, "max_iteration", &json!(1));
        set(folder, "time_stepping", &json!({"time_step": 0.09}));
    };
    let failed = folder(&write, &outputs_of_points(1), Some(json!({})));
    assert_eq!(run(failed.path(), &["--quiet"]).0, Some(3));
    let bytes = fs::read(failed.path().join("out/restart/step_0000000000.checkpoint")).unwrap();
    let length = u64::from_le_bytes(bytes[8..16].try_into().unwrap()) as usize;
    let header: Value = serde_json::from_slice(&bytes[16..16 + length]).unwrap();
    assert_eq!(header["head"]["step"], 0);
    assert_eq!(header["head"]["failure"]["step"], 1);
    assert!(header["head"]["failure"]["what"].as_str().unwrap().contains("did not converge"), "{header}");
    set(failed.path(), "max_iteration", &json!(20));
    set(failed.path(), "time_stepping", &json!({"time_step": 0.01}));
    succeed(failed.path(), &["--resume"]);
}
