//! Angular momentum of a body that turns and swings, and its shape after a hundred turns.

use super::common::{Record, State};
use super::{CUBIC, Frame, Functions, HATS, SPLINE, explicit, initial_velocity, turning_block};
use serde_json::{Value, json};

/// Largest relative change of the angular momentum about z, which with APIC counts the affine velocity
/// about each point (Jiang et al. 2015).
fn spin_drift(record: &Record) -> f64 {
    let start = record.first().total("angular_momentum")[2];
    let drift = |state: &State| (state.total("angular_momentum")[2] / start - 1.0).abs();
    record.states().iter().map(drift).fold(0.0, f64::max)
}

fn momentum_drift(record: &Record) -> f64 {
    let start = record.first().total("momentum");
    let drift = |state: &State| {
        let now = state.total("momentum");
        (0..3).map(|a| (now[a] - start[a]).abs()).fold(0.0, f64::max) / (state.mass() * 5.0)
    };
    record.states().iter().map(drift).fold(0.0, f64::max)
}

fn run(frame: Frame, functions: Functions, members: &Value) -> Record {
    let solver = explicit(frame, functions, 2e-4, members);
    turning_block(frame, functions, solver, 0.12 - 1e-4).run(&["--record-states", "20"])
}

/// FLIP with the consistent mass, by every scheme that has it, and APIC with offsets to the present
/// nodes, whatever velocity the points move with.
#[test]
fn angular_momentum_is_kept_to_round_off() {
    let consistent =
        |scheme: &str| json!({"scheme_type": scheme, "stress_update": "musl", "consistent_mass_matrix": true});
    let apic = |update: &str| json!({"transfer": "apic", "stress_update": update});
    for functions in [HATS, SPLINE, CUBIC] {
        let mut cases = vec![(Frame::Updated, apic("usl")), (Frame::Updated, apic("musl"))];
        cases.extend(["usf", "usl", "musl"].map(|update| (Frame::Total, apic(update))));
        cases.extend(["forward_euler", "velocity_verlet"].map(|scheme| (Frame::Total, consistent(scheme))));
        if functions.order == 1 {
            cases.push((Frame::Total, consistent("yoshida")));
        }
        for (frame, members) in cases {
            let record = run(frame, functions, &members);
            let (spin, momentum) = (spin_drift(&record), momentum_drift(&record));
            assert!(spin < 1e-12, "{frame:?} {functions:?} {members}: angular momentum drifts by {spin:e}");
            assert!(momentum < 1e-12, "{frame:?} {functions:?} {members}: momentum drifts by {momentum:e}");
            assert!(record.last().energy("strain") > 1.0, "the block must swing");
            // That of affine parts included, which points have from the start.
            let lost = 1.0 - record.last().energy("total") / record.first().energy("total");
            assert!(lost.abs() < 0.02, "{frame:?} {functions:?} {members}: energy falls by {lost}");
        }
    }
}

/// What the others do in 600 steps, with hats: bounds about the measured drift, to the factor 2. The
/// linear momentum stays in all of them.
#[test]
fn other_transfers_lose_angular_momentum() {
    use Frame::{Total, Updated};
    for (frame, members, drift) in [
        (Total, json!({"stress_update": "usl"}), 2.8e-2),
        (Total, json!({"stress_update": "musl"}), 2.8e-2),
        (Total, json!({"scheme_type": "velocity_verlet"}), 2.8e-2),
        (Total, json!({"stress_update": "musl", "flip_fraction": 0.99}), 0.54),
        (Total, json!({"stress_update": "musl", "transfer": "pic"}), 1.0),
        (Total, json!({"stress_update": "usl", "transfer": "tpic"}), 1.6e-3),
        (Total, json!({"stress_update": "usl", "transfer": "xpic"}), 0.9),
        (Updated, json!({"stress_update": "musl"}), 0.13),
        (Updated, json!({"stress_update": "musl", "transfer": "pic"}), 1.0),
        (Updated, json!({"stress_update": "musl", "transfer": "tpic"}), 4.4e-3),
        (Updated, json!({"stress_update": "musl", "transfer": "xpic"}), 1.1),
    ] {
        let record = run(frame, HATS, &members);
        let (spin, momentum) = (spin_drift(&record), momentum_drift(&record));
        assert!(spin > 0.5 * drift && spin < 2.0 * drift, "{frame:?} {members}: angular momentum drifts by {spin:e}");
        assert!(momentum < 1e-12, "{frame:?} {members}: momentum drifts by {momentum:e}");
    }
}

/// Positions in the axes of the body: least-squares fit x = A X about the centre; the stretches of A,
/// and the farthest that a point is from A X.
fn shape(start: &[Vec<f64>], state: &State) -> (f64, f64, f64) {
    use nalgebra::{Matrix2, Vector2};
    let now = state.points("MP_COORD");
    let vectors = |rows: &[Vec<f64>]| -> Vec<Vector2<f64>> {
        let rows: Vec<Vector2<f64>> = rows.iter().map(|x| Vector2::new(x[0], x[1])).collect();
        let middle = rows.iter().sum::<Vector2<f64>>() / rows.len() as f64;
        rows.into_iter().map(|x| x - middle).collect()
    };
    let (first, now) = (vectors(start), vectors(&now));
    let (mut of_now, mut of_first) = (Matrix2::zeros(), Matrix2::zeros());
    for (a, b) in first.iter().zip(&now) {
        of_now += b * a.transpose();
        of_first += a * a.transpose();
    }
    let map = of_now * of_first.try_inverse().unwrap();
    let stretches = map.svd(false, false).singular_values;
    let off = first.iter().zip(&now).map(|(a, b)| (b - map * a).norm()).fold(0.0, f64::max);
    (stretches.min(), stretches.max(), off)
}

/// Turns at 20 rad/s from rest shape for a hundred turns: the centrifugal force makes the block swing
/// between its shape and one some 4 % wider, after a hundred turns as after one.
#[test]
fn a_hundred_turns_keep_shape_and_energy() {
    const SPEED: f64 = 20.0;
    let end = 100.0 * 2.0 * std::f64::consts::PI / SPEED;
    let verlet = json!({"scheme_type": "velocity_verlet", "consistent_mass_matrix": true});
    let implicit = json!({"time_integration_method": "implicit", "scheme_type": "energy_conserving",
        "max_iteration": 40, "residual_relative_tolerance": 1e-11});
    for (members, time_step, energy_bound, spin_bound) in [(verlet, 2e-3, 2e-3, 1e-12), (implicit, 1e-2, 1e-9, 1e-9)] {
        let solver = explicit(Frame::Total, HATS, time_step, &members);
        let mut scene = turning_block(Frame::Total, HATS, solver, end);
        scene.processes = vec![initial_velocity("MPM_Material", ["-20*y", "20*x", "0"])];
        let record = scene.run(&["--record-states", "400"]);
        let energy = record.first().energy("total");
        let drift = record.states().iter().map(|s| (s.energy("total") / energy - 1.0).abs()).fold(0.0, f64::max);
        assert!(drift < energy_bound, "{members}: energy drifts by {drift:e}");
        assert!(spin_drift(&record) < spin_bound, "{members}: angular momentum drifts by {:e}", spin_drift(&record));
        let start = record.first().points("MP_COORD");
        let widest = |states: &[State]| {
            states.iter().map(|state| shape(&start, state)).fold((f64::INFINITY, 0.0f64, 0.0f64), |most, of| {
                (most.0.min(of.0), most.1.max(of.1), most.2.max(of.2))
            })
        };
        let states = record.states();
        let (early, late) = (widest(&states[..40]), widest(&states[states.len() - 40..]));
        for (least, most, off) in [early, late] {
            assert!(least > 0.999 && most < 1.05 && most > 1.02, "{members}: stretches from {least} to {most}");
            assert!(off < 0.01, "{members}: a point is {off} m off");
        }
        assert!((late.1 - early.1).abs() < 0.003, "{members}: {early:?} {late:?}");
    }
}
