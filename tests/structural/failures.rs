//! Input that is wrong, and runs that go wrong: exit codes, who, where and what to try.

use super::body::{Body, fix, load, material};
use super::common::{Cell, Mesh, largest_difference, process};
use serde_json::{Value, json};
use std::process::Command;
use tempfile::TempDir;

/// A block on a floor that a process presses.
fn block(solver: Value) -> Body {
    let mesh = Mesh::block(Cell::Quadrilateral, [2, 2, 1], [0.0; 3], [1.0, 1.0, 0.0]);
    Body::new(mesh, material("HyperElasticNeoHookeanPlaneStrain2DLaw", 1000.0, 1e6, 0.3), solver, 1.0)
        .part("Floor", |x| x[1] == 0.0)
        .part("Top", |x| x[1] == 1.0)
        .with(fix("Floor", json!([0.0, 0.0, null])))
}

/// Runs, and compares exit code and what is said.
fn ends(body: &Body, code: i32, says: &[&str]) -> TempDir {
    let folder = TempDir::new().unwrap();
    body.write(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let output = command.current_dir(folder.path()).args(["run", "ProjectParameters.json"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(code), "{said}");
    for part in says {
        assert!(said.contains(part), "{part:?} is not in\n{said}");
    }
    folder
}

#[test]
fn an_element_turned_inside_out_is_named_and_the_state_saved() {
    let body = block(json!({})).with(fix("Top", json!([0.0, -1.2, null])));
    let says = ["step 1, time 1", "inside out", "element 3", "at (0.", "J = -", "smaller steps", "failed_state.vtu"];
    let folder = ends(&body, 3, &says);
    assert!(folder.path().join("failed_state.vtu").exists());
}

/// A press by more than a row of cells in one step, whole and, as three iterations are too few, in pieces: it ends where
/// a run in small steps ends, as the material is elastic.
#[test]
fn a_step_that_does_not_converge_is_taken_in_pieces() {
    for depth in [0.7, 0.9] {
        let press = |solver| block(solver).with(fix("Top", json!([0.0, format!("-{depth}*t"), null]))).run(&[]);
        let whole = press(json!({"max_iteration": 40}));
        let cut = press(json!({"on_no_convergence": "cut_step", "max_iteration": 3}));
        let small = press(json!({"time_stepping": {"time_step": 0.0625}}));
        assert_eq!((&whole.json["cut_steps"], &cut.json["cut_steps"]), (&json!([]), &json!([1])));
        for record in [&whole, &cut] {
            let (found, wanted) = (record.last().nodes("DISPLACEMENT"), small.last().nodes("DISPLACEMENT"));
            let difference = largest_difference(&found, &wanted);
            assert!(difference < 1e-8, "{depth}: {difference} m");
        }
    }
}

#[test]
fn a_body_without_support_is_singular() {
    let mut body = block(json!({})).part("Corner", |x| x == [1.0, 1.0, 0.0]).conditions(
        "Pull",
        "PointLoadCondition2D1N",
        vec![vec![8]],
    );
    body.processes.clear();
    let body = body.with(load("Pull", "POINT_LOAD", json!([1.0, 0.0, 0.0])));
    ends(&body, 3, &["singular", "DISPLACEMENT_", "of node", "fix enough displacements"]);
}

#[test]
fn steps_above_the_stable_one_are_told_and_blow_up() {
    // c = 36.7 m/s on cells of 0.5 m.
    let solver = |policy: &str| {
        json!({"solver_type": "structural_dynamic", "time_integration_method": "explicit",
               "time_stepping": {"time_step": 0.05, "time_step_policy": policy}})
    };
    let pressed = |policy| block(solver(policy)).with(fix("Top", json!([null, "-0.01 * t", null])));
    ends(&pressed("strict"), 3, &["the time step 5e-2 s is unstable", "stable step is", "element"]);
    ends(&pressed("warn"), 3, &["too large", "stable step is", "element", "smaller"]);
}

#[test]
fn wrong_input_is_refused() {
    let dynamic =
        json!({"solver_type": "structural_dynamic", "time_integration_method": "explicit", "scheme_type": "newmark"});
    ends(&block(dynamic), 2, &["\"newmark\" is no explicit scheme"]);
    let mut body = block(json!({"time_stepping": {"time_step": "auto"}}));
    ends(&body, 2, &["\"auto\" is for explicit runs"]);
    body.solver = json!({"domain_size": 3});
    ends(&body, 2, &["element 1 is a Quadrilateral4, which does not fit three-dimensional"]);
    body.solver = json!({"rotation_dofs": true});
    ends(&body, 2, &["rotation_dofs", "displacements alone"]);
    let shown = json!({"model_part_name": "Structure", "gauss_point_variables_in_elements": ["CAUCHY_STRESS_VECTR"]});
    let body = block(json!({})).with(process("vtk_output_process", shown));
    ends(&body, 2, &["did you mean \"CAUCHY_STRESS_VECTOR\""]);
    let mut body = block(json!({})).conditions("Stray", "PointLoadCondition2D1N", vec![vec![9]]);
    body.mesh.nodes.push([2.0, 2.0, 0.0]);
    ends(&body, 2, &["condition 1 has a node that belongs to no element"]);
    let mut body = block(json!({}));
    body.material["Variables"]["YOUNG_MODULUS"] = json!(-1.0);
    ends(&body, 2, &["YOUNG_MODULUS is -1"]);
}
