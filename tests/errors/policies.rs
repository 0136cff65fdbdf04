//! What a run does with points that leave the grid and with steps that do not converge, as the project
//! asks for it.

use super::base::{BODY, MATERIALS, PROJECT, Scene, mesh, part};
use serde_json::Value;
use std::process::Command;
use tempfile::TempDir;

struct Run {
    code: Option<i32>,
    words: String,
    /// The account, if the run came to its end.
    record: Value,
}

fn run(scene: &Scene) -> Run {
    let folder = TempDir::new().unwrap();
    scene.write_to(folder.path());
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let arguments = ["run", PROJECT, "--threads", "1", "--record", "r.json", "--record-states", "1"];
    let output = command.current_dir(folder.path()).args(arguments).output().unwrap();
    let record = std::fs::read_to_string(folder.path().join("r.json")).unwrap_or("null".into());
    Run {
        code: output.status.code(),
        words: String::from_utf8(output.stderr)
            .unwrap()
            .replace('|', " ")
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" "),
        record: serde_json::from_str(&record).unwrap(),
    }
}

fn with_solver(scene: Scene, members: &str) -> Scene {
    scene.replace(PROJECT, "\"max_iteration\": 20", &format!("\"max_iteration\": 20, {members}"))
}

/// A block that flies to the right border with nothing to hold it: 16 points of 15.625 kg, 1 m/s, and
/// 0.25 m to go.
fn flying(members: &str, explicit: bool) -> Scene {
    let body = mesh("MPMUpdatedLagrangian2D4N", 100, 2, [0.25, 0.25], 0.25) + &part("Cube", 101..=109, 101..=104);
    let scene = with_solver(Scene::base().write(BODY, body), members)
        .replace(PROJECT, "[true, true, true]", "[false, false, false]")
        .replace(PROJECT, "\"value\": [0.0, \"0.0*t\", 0.0]", "\"value\": [0.0, null, null]")
        .replace(PROJECT, "assign_gravity_to_material_point", "assign_initial_velocity_to_material_point")
        .replace(PROJECT, "9.81", "1.0")
        .replace(PROJECT, "[0.0, -1.0, 0.0]", "[1.0, 0.0, 0.0]")
        .replace(PROJECT, "\"end_time\": 0.02", "\"end_time\": 0.45");
    match explicit {
        false => scene,
        true => scene
            .replace(PROJECT, "\"newmark\"", "\"forward_euler\", \"time_integration_method\": \"explicit\"")
            .replace(PROJECT, "0.01}", "0.002}"),
    }
}

fn last(record: &Value) -> &Value {
    record["snapshots"].as_array().unwrap().last().unwrap()
}

/// A column of the last state, as a list of rows.
fn column(record: &Value, name: &str) -> Vec<Vec<f64>> {
    let rows = last(record)["mp"][name].as_array().unwrap_or_else(|| panic!("{name} in {}", last(record)));
    let row = |row: &Value| match row {
        Value::Array(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
        number => vec![number.as_f64().unwrap()],
    };
    rows.iter().map(row).collect()
}

#[test]
fn erased_points_are_named_with_their_mass() {
    for explicit in [false, true] {
        for members in ["\"echo_level\": 0", "\"lost_points\": \"erase\""] {
            let Run { code, words, record } = run(&flying(members, explicit));
            assert_eq!(code, Some(0), "{words}");
            let (count, lost) = (record["lost_points"].as_u64().unwrap(), record["lost_mass"].as_f64().unwrap());
            let ids: Vec<u64> = record["lost_ids"].as_array().unwrap().iter().map(|id| id.as_u64().unwrap()).collect();
            assert!((4..16).contains(&count) && ids.len() as u64 == count, "{count} {ids:?}");
            assert!((lost - 15.625 * count as f64).abs() < 1e-9, "{lost}");
            let kept: f64 = column(&record, "MP_MASS").iter().map(|row| row[0]).sum();
            assert!((kept + lost - 250.0).abs() < 1e-9, "{kept} {lost}");
            for says in ["left the grid", &format!("{}", ids[0]), "kg with them", "in the whole run"] {
                assert!(words.contains(says), "{says:?} is not in {words}");
            }
        }
    }
}

#[test]
fn a_point_that_may_not_leave_stops_the_run() {
    for explicit in [false, true] {
        let Run { code, words, .. } = run(&flying("\"lost_points\": \"error\"", explicit));
        assert_eq!(code, Some(3), "{words}");
        for says in [
            "a material point has left the grid",
            "material point ",
            " at (1.0",
            "body Cube, mass 1.5625",
            "law neo-Hookean, F = [1",
            "J = ",
            "velocity [",
            "\"lost_points\": \"erase\"",
            "the state was saved to failed_state.vtu",
        ] {
            assert!(words.contains(says), "{says:?} is not in {words}");
        }
    }
}

/// The border takes the momentum across it as a smooth wall does: nothing is lost but what flew outwards.
#[test]
fn clamped_points_stay_with_all_their_mass() {
    for explicit in [false, true] {
        let Run { code, words, record } = run(&flying("\"lost_points\": \"clamp\"", explicit));
        assert_eq!(code, Some(0), "{words}");
        assert_eq!(record["lost_points"], 0);
        let clamped = record["clamped_points"].as_u64().unwrap();
        assert!(
            clamped > 0 && words.contains(&format!("put back to the border of the grid {clamped} times")),
            "{words}"
        );
        let (places, masses) = (column(&record, "MP_COORD"), column(&record, "MP_MASS"));
        assert_eq!(places.len(), 16);
        let beyond = places.iter().map(|x| x[0]).fold(0.0, f64::max) - 1.0;
        assert!(beyond < 0.02, "points move out by at most a step: {beyond}");
        assert!((masses.iter().map(|m| m[0]).sum::<f64>() - 250.0).abs() < 1e-9);
        let momentum: f64 = column(&record, "MP_VELOCITY").iter().map(|v| 15.625 * v[0]).sum();
        assert!(momentum < 250.0 * (1.0 - 1e-3), "the border has taken no momentum: {momentum}");
    }
}

/// Points without stiffness that fly aslant to a smooth wall: those that reach it stop across it and go on
/// along it, and the velocity of the others stays what it was. One of four columns reaches it.
#[test]
fn clamped_points_lose_their_momentum_across_the_border_and_no_other() {
    let [across, along, end, step] = [0.96, 0.28, 0.45, 0.002];
    let scene = flying("\"lost_points\": \"clamp\"", true).replace(MATERIALS, "1e6", "1e-9").replace(
        PROJECT,
        "[1.0, 0.0, 0.0]",
        "[0.96, 0.28, 0.0]",
    );
    let Run { code, words, record } = run(&scene);
    assert_eq!(code, Some(0), "{words}");
    let first = &record["snapshots"][0]["mp"]["MP_COORD"];
    let begin = |point: usize, axis: usize| first[point][axis].as_f64().unwrap();
    let (places, velocities) = (column(&record, "MP_COORD"), column(&record, "MP_VELOCITY"));
    let mut stopped = 0;
    for (point, (x, v)) in places.iter().zip(&velocities).enumerate() {
        let reaches = begin(point, 0) + across * end > 1.0;
        stopped += usize::from(reaches);
        let speed = if reaches { 0.0 } else { across };
        for (found, expected) in [x[1] - begin(point, 1), v[0], v[1]].into_iter().zip([along * end, speed, along]) {
            assert!((found - expected).abs() < 1e-12, "point {point}: {x:?} {v:?}, {found} is not {expected}");
        }
        // What stands still is carried out again by its neighbours, a step at most.
        assert!(!reaches || (1.0..1.0 + across * step).contains(&x[0]), "point {point} at {x:?}");
    }
    assert_eq!(stopped, 4);
    let momentum = |axis: usize| velocities.iter().map(|v| 15.625 * v[axis]).sum::<f64>();
    assert!((momentum(0) - 0.75 * 250.0 * across).abs() < 1e-9, "the wall takes a quarter: {}", momentum(0));
    assert!((momentum(1) - 250.0 * along).abs() < 1e-9, "and nothing along it: {}", momentum(1));
    let mass: f64 = column(&record, "MP_MASS").iter().map(|m| m[0]).sum();
    assert!((mass - 250.0).abs() < 1e-9, "{mass}");
}

/// Each material point belongs to one cell, also where it lies on a face or a node: the masses of the nodes
/// sum up to that of the points. A quarter of the points lies on nodes, half of them on faces.
#[test]
fn points_on_faces_count_once() {
    for [x, y] in [[0.1875, 0.1875], [0.1875, 0.25], [0.25, 0.1875]] {
        let body = mesh("MPMUpdatedLagrangian2D4N", 100, 2, [x, y], 0.25) + &part("Cube", 101..=109, 101..=104);
        // Around a point on a node lies a cell whose far node has no stiffness: no matter to explicit runs.
        for explicit in [false, true].into_iter().filter(|explicit| *explicit || x != y) {
            let scene = flying("\"point_placement\": \"even\"", explicit).write(BODY, body.clone());
            let Run { code, words, record } = run(&scene.replace(PROJECT, "\"end_time\": 0.45", "\"end_time\": 0.002"));
            assert_eq!(code, Some(0), "{words}");
            let first = &record["snapshots"][0]["mp"]["MP_COORD"];
            let on_face = |x: &Value| x.as_array().unwrap().iter().any(|x| (4.0 * x.as_f64().unwrap()).fract() == 0.0);
            assert!(first.as_array().unwrap().iter().filter(|x| on_face(x)).count() >= 8);
            let masses = last(&record)["nodes"]["NODAL_MASS"].as_array().unwrap();
            let nodes: f64 = masses.iter().map(|m| m.as_f64().unwrap()).sum();
            let points: f64 = column(&record, "MP_MASS").iter().map(|row| row[0]).sum();
            assert!((points - 250.0).abs() < 1e-12 && (nodes - points).abs() < 1e-11, "{nodes} {points}");
        }
    }
}

/// The base scene with a gravity that its step is too long for.
fn hard(members: &str, step: &str) -> Scene {
    with_solver(Scene::base(), members)
        .replace(PROJECT, "9.81", "3000.0")
        .replace(PROJECT, "\"max_iteration\": 20, ", "\"max_iteration\": 4, \"residual_relative_tolerance\": 1e-10, ")
        .replace(PROJECT, "0.01}", step)
}

#[test]
fn a_step_that_does_not_converge_stops_the_run_if_asked_to() {
    let Run { code, words, .. } = run(&with_solver(Scene::base(), "\"on_no_convergence\": \"error\"").replace(
        PROJECT,
        "\"max_iteration\": 20",
        "\"max_iteration\": 1, \"residual_absolute_tolerance\": 0.0, \"residual_relative_tolerance\": 0.0",
    ));
    assert_eq!(code, Some(3), "{words}");
    for says in
        ["step 1, time 0.01", "did not converge: after 1 iterations the residual is", "of grid node", "cut_step"]
    {
        assert!(words.contains(says), "{says:?} is not in {words}");
    }
}

#[test]
fn a_step_is_halved_a_bounded_number_of_times() {
    let scene = with_solver(Scene::base(), "\"on_no_convergence\": \"cut_step\"");
    let Run { code, words, .. } =
        run(&scene.replace(PROJECT, "\"residual_criterion\"", "\"displacement_criterion\"").replace(
            PROJECT,
            "\"max_iteration\": 20",
            "\"max_iteration\": 1, \"displacement_absolute_tolerance\": 0.0, \"displacement_relative_tolerance\": 0.0",
        ));
    assert_eq!(code, Some(3), "{words}");
    for says in ["did not converge", "halved 8 times, to 3.90625e-5 s", "the state was saved to failed_state.vtu"] {
        assert!(words.contains(says), "{says:?} is not in {words}");
    }
}

/// A cut step ends in the state, to the last bit, of a run whose steps were given as short as its pieces:
/// what was tried in between has left no trace. Steps and outputs stay those of the project.
#[test]
fn cut_steps_equal_steps_given_as_short() {
    let cut = run(&hard("\"on_no_convergence\": \"cut_step\"", "0.01}"));
    assert_eq!(cut.code, Some(0), "{}", cut.words);
    assert_eq!((cut.record["steps"].as_u64(), cut.record["cut_steps"].as_array().unwrap().len()), (Some(2), 2));
    assert!(cut.words.contains("2 steps did not converge as given and were cut"), "{}", cut.words);
    let short = run(&hard("\"on_no_convergence\": \"error\"", "0.005}"));
    assert_eq!(short.code, Some(0), "{}", short.words);
    assert_eq!(short.record["steps"], 4);
    for name in ["MP_COORD", "MP_VELOCITY", "MP_CAUCHY_STRESS_VECTOR"] {
        assert_eq!(column(&cut.record, name), column(&short.record, name), "{name}");
    }
}

/// Imposed displacements are increments of a step: a piece has its share of them.
#[test]
fn a_piece_of_a_step_has_its_share_of_the_imposed_motion() {
    let lifted = |scene: Scene, by: &str| scene.replace(PROJECT, "\"0.0*t\"", by);
    let cut = run(&lifted(hard("\"on_no_convergence\": \"cut_step\"", "0.01}"), "0.004"));
    let short = run(&lifted(hard("\"on_no_convergence\": \"error\"", "0.005}"), "0.002"));
    assert_eq!((cut.code, short.code), (Some(0), Some(0)), "{}\n{}", cut.words, short.words);
    assert_eq!(cut.record["cut_steps"].as_array().unwrap().len(), 2);
    assert_eq!(column(&cut.record, "MP_COORD"), column(&short.record, "MP_COORD"));
}

/// One process holds the floor until a time inside of a step, another one from there on, whichever of them
/// acts first: the body stays on the floor.
#[test]
fn what_is_held_changes_between_the_pieces_of_a_step() {
    let held = |first: &str, second: &str| {
        let scene = hard("\"on_no_convergence\": \"cut_step\"", "0.01}");
        let text = scene.text(PROJECT);
        let begin = text.find("[{\n            \"python_module\": \"assign_vector").unwrap();
        let block = &text[begin + 1..begin + text[begin..].find("}],").unwrap() + 1];
        let within = |interval: &str| block.replace("[0.0, \"End\"]", interval);
        let both = text.replace(block, &format!("{}, {}", within(first), within(second)));
        run(&scene.write(PROJECT, both))
    };
    let (before, after) = ("[0.0, 0.007]", "[0.007, \"End\"]");
    let (one, other) = (held(before, after), held(after, before));
    assert_eq!((one.code, other.code), (Some(0), Some(0)), "{}\n{}", one.words, other.words);
    let whole = run(&hard("\"on_no_convergence\": \"cut_step\"", "0.01}"));
    for run in [one, other] {
        assert_eq!(column(&run.record, "MP_COORD"), column(&whole.record, "MP_COORD"));
    }
}

#[test]
fn parts_that_no_body_has_reached_are_told() {
    let body = mesh("MPMUpdatedLagrangian2D4N", 100, 2, [0.25, 0.5], 0.25) + &part("Cube", 101..=109, 101..=104);
    let Run { code, words, .. } = run(&Scene::base().write(BODY, body));
    assert_eq!(code, Some(0), "{words}");
    let says = "ProjectParameters.json:29:36 at /processes/constraints/0/Parameters/model_part_name: no body has \
                reached the nodes of Background_Grid.Floor in this run";
    assert!(words.contains(says), "{words}");
    let Run { words, .. } = run(&Scene::base());
    assert!(!words.contains("no body has reached"), "{words}");
}
