//! Runs that go wrong physically: exit code 3, who, where and when, what to try, and the state.

use super::base::{BODY, Outcome, PROJECT, Scene, mesh};

fn fails(name: &str, scene: &Scene, says: &[&str]) -> Outcome {
    let outcome = scene.run(&["--output", "results"]);
    let words = outcome.words();
    assert_eq!(outcome.code, Some(3), "{name}: {}", outcome.stderr);
    for part in says.iter().chain(&["try:", "the state was saved to results/failed_state.vtu"]) {
        assert!(words.contains(part), "{name}: {part:?} is not in\n{}", outcome.stderr);
    }
    assert!(outcome.new_files.contains(&"results/failed_state.vtu".to_string()), "{name}: {:?}", outcome.new_files);
    outcome
}

fn without_support() -> Scene {
    Scene::base().replace(PROJECT, "[true, true, true]", "[false, false, false]")
}

#[test]
fn a_free_body_in_statics_is_singular() {
    let scene = without_support().replace(PROJECT, "\"dynamic\"", "\"static\"");
    fails(
        "free",
        &scene,
        &["step 1, time 0.01", "singular", "DISPLACEMENT_", "of grid node", "at (", "fix enough displacements"],
    );
}

#[test]
fn an_inverted_deformation_names_its_point() {
    let scene = Scene::base().replace(PROJECT, "9.81", "1e8");
    fails(
        "gravity",
        &scene,
        &["step 1, time 0.01", "material point", "at (0.", "J of this step = -", "smaller time step"],
    );
}

#[test]
fn values_that_are_not_finite_name_process_variable_node_and_time() {
    let scene = Scene::base().replace(PROJECT, "\"0.0*t\"", "\"log(0.015 - t)\"");
    let says =
        ["step 2, time 0.02", "assign_vector_variable", "DISPLACEMENT_Y", "node 1", "at (0, 0, 0)", "log(0.015 - t)"];
    fails("logarithm", &scene, &says);
    let scene = Scene::base().replace(PROJECT, "9.81", "1e308");
    fails("overflow", &scene, &["step 1", "finite"]);
}

#[test]
fn all_points_leaving_the_grid() {
    let scene = without_support().replace(PROJECT, "0.01}", "1.0}").replace(PROJECT, "0.02", "5.0");
    let outcome =
        fails("fall", &scene, &["all material points have left the grid", "material point 26", "a larger grid"]);
    assert!(outcome.words().contains("step 2"), "{}", outcome.stderr);
}

#[test]
fn a_state_that_cannot_be_saved_is_told() {
    let scene = Scene::base().replace(PROJECT, "9.81", "1e8").write("results/failed_state.vtu/other", "");
    let outcome = scene.run(&["--output", "results"]);
    assert_eq!(outcome.code, Some(3), "{}", outcome.stderr);
    let says = "the state could not be saved: results/failed_state.vtu";
    assert!(outcome.words().contains(says), "{}", outcome.stderr);
}

#[test]
fn steps_without_convergence_go_on_with_a_warning() {
    let scene = Scene::base().replace(
        PROJECT,
        "\"max_iteration\": 20",
        "\"max_iteration\": 1, \"residual_absolute_tolerance\": 0.0, \"residual_relative_tolerance\": 0.0",
    );
    let outcome = scene.run(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(
        outcome.words().contains("2 steps did not converge within max_iteration, the first is step 1"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn a_body_that_hangs_by_a_corner_is_singular() {
    // Two bodies in cells that share one grid node: the upper one is held there and turns about it.
    let nodes = mesh("MPMUpdatedLagrangian2D4N", 100, 1, [0.0, 0.0], 0.25);
    let second = "Begin Nodes\n111 0.25 0.25 0\n112 0.5 0.25 0\n113 0.5 0.5 0\n114 0.25 0.5 0\nEnd Nodes\n\
                  Begin Elements MPMUpdatedLagrangian2D4N\n111 0 111 112 113 114\nEnd Elements\n";
    let both =
        "Begin SubModelPart Cube\nBegin SubModelPartElements\n101\n111\nEnd SubModelPartElements\nEnd SubModelPart\n";
    let scene = Scene::base().write(BODY, nodes + second + both).replace(PROJECT, "\"dynamic\"", "\"static\"");
    let outcome = fails("hinge", &scene, &["singular", "of grid node"]);
    assert!(outcome.words().contains("by a corner"), "{}", outcome.stderr);
}
