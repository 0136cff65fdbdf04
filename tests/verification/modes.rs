//! What the default mode does as physics has it, and `--kratos-exact` as Kratos 10.4.4 does (spec 03
//! §3 and §8: seen in Kratos by experiment).

use super::common::{Cell, Mesh, Record, Scene, fix, gravity, material};
use serde_json::{Value, json};

/// A block between a floor and a plate whose displacement increments are a function of time.
fn pressed(solver: Value, arguments: &[&str]) -> Record {
    let mesh = Mesh::block(Cell::Quadrilateral, [4, 4, 1], [0.0; 3], [1.0, 1.0, 0.0]);
    let material = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 4, 1000.0, 1e5, 0.3);
    let mut all = vec!["--record-states", "10"];
    all.extend(arguments);
    Scene::new(mesh.clone(), mesh, material, solver, 0.1 - 1e-6)
        .part("Floor", |x| x[1] == 0.0)
        .part("Plate", |x| x[1] == 1.0)
        .with(fix("Floor", json!([0.0, 0.0, 0.0])))
        .with(fix("Plate", json!([0.0, "-0.02*t", 0.0])))
        .run(&all)
}

fn plate(record: &Record) -> Vec<f64> {
    record.states()[1..].iter().map(|state| state.nodes("DISPLACEMENT")[22][1]).collect()
}

#[test]
fn a_plate_that_moves_with_time_acts_by_default_only() {
    for kind in ["dynamic", "quasi_static"] {
        let solver = json!({"solver_type": kind, "scheme_type": "newmark", "time_stepping": {"time_step": 0.01},
                            "residual_relative_tolerance": 1e-9});
        let record = pressed(solver.clone(), &[]);
        let (steps, moved) = (record.states(), plate(&record));
        assert_eq!(moved.len(), 10);
        for (state, increment) in steps[1..].iter().zip(&moved) {
            let exact = -0.02 * state.time();
            assert!((increment - exact).abs() < 1e-15, "{kind}: the plate moves by {increment}, not {exact}");
        }
        // The block below follows: its height shrinks by what the plate has moved in all.
        let total: f64 = moved.iter().sum();
        let lowest = record.last().points("MP_DISPLACEMENT").iter().map(|u| u[1]).fold(0.0, f64::min);
        assert!(lowest < 0.8 * total && lowest > 1.5 * total, "{kind}: points sink by {lowest}, the plate by {total}");

        let ignored = pressed(solver, &["--kratos-exact"]);
        assert!(plate(&ignored).iter().all(|increment| *increment == 0.0), "{kind}: Kratos ignores it");
        let stress = ignored.last().points("MP_CAUCHY_STRESS_VECTOR").concat();
        assert!(stress.iter().all(|s| *s == 0.0), "{kind}: nothing moves in Kratos, so nothing is stressed");
    }
}

/// A static solver takes the value of each step as the increment of that step, in both modes.
#[test]
fn a_plate_moves_in_statics_in_both_modes() {
    let solver = json!({"solver_type": "static", "time_stepping": {"time_step": 0.01}});
    for arguments in [&[][..], &["--kratos-exact"]] {
        let record = pressed(solver.clone(), arguments);
        for (state, increment) in record.states()[1..].iter().zip(plate(&record)) {
            assert!((increment + 0.02 * state.time()).abs() < 1e-15, "{arguments:?}: {increment}");
        }
    }
}

/// Bodies at rest have no velocity. Kratos's gravity process sets the acceleration of the points,
/// from which the first static step makes a velocity of g dt/2 that stays.
#[test]
fn statics_with_gravity_have_no_velocity_by_default() {
    let dt = 0.25;
    for kind in ["static", "quasi_static"] {
        let run = |arguments: &[&str]| {
            let mesh = Mesh::block(Cell::Triangle, [3, 3, 1], [0.0; 3], [1.0, 1.0, 0.0]);
            let material = material("LinearElasticIsotropicPlaneStrain2DLaw", 3, 1000.0, 1e6, 0.3);
            let solver =
                json!({"solver_type": kind, "time_stepping": {"time_step": dt}, "residual_relative_tolerance": 1e-8});
            let mut all = vec!["--record-states", "2"];
            all.extend(arguments);
            Scene::new(mesh.clone(), mesh, material, solver, 0.5)
                .part("Floor", |x| x[1] == 0.0)
                .with(fix("Floor", json!([0.0, 0.0, 0.0])))
                .with(gravity([0.0, -9.81, 0.0]))
                .run(&all)
        };
        let default = run(&[]);
        assert!(default.last().points("MP_VELOCITY").iter().flatten().all(|v| *v == 0.0), "{kind}");
        assert_eq!(default.last().energy("kinetic"), 0.0);
        let sunk = default.last().points("MP_DISPLACEMENT").iter().map(|u| u[1]).fold(0.0, f64::min);
        assert!(sunk < -1e-3, "{kind}: the block must sink for the test to mean anything, {sunk}");
        let exact = run(&["--kratos-exact"]);
        for velocity in exact.last().points("MP_VELOCITY") {
            assert!((velocity[1] + 9.81 * dt / 2.0).abs() < 1e-14 && velocity[0] == 0.0, "{kind}: {velocity:?}");
        }
    }
}
