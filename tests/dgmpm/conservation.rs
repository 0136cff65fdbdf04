//! What the scheme must keep: rest, rigid motion, momentum, energy, objectivity, bits.

use super::scene::{Scene, constants, velocity};
use serde_json::{Value, json};

/// A free block in one, two or three dimensions with so many points a cell.
fn block(dimension: usize, cells: usize, points: usize, law: &'static str, start: Value) -> Scene {
    let size = std::array::from_fn(|a| if a < dimension { 1.0 } else { 0.0 });
    Scene::new(size, &vec![cells; dimension], law, constants(1000.0, 1e7, 0.3, points), 0.02)
        .solver(json!({"time_stepping": {"time_step": "auto", "courant_number": 0.9}}))
        .with(velocity("Background_Grid", start))
}

const SCHEMES: [&str; 4] = [
    r#"{}"#,
    r#"{"transverse_correction": true}"#,
    r#"{"time_integration": "rk2"}"#,
    r#"{"time_integration": "ssp_rk3", "riemann_solver": "hll"}"#,
];

fn schemes() -> impl Iterator<Item = Value> {
    SCHEMES.iter().map(|text| serde_json::from_str(text).unwrap())
}

const LAWS: [&str; 3] =
    ["HyperElasticNeoHookean3DLaw", "HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw"];

#[test]
fn rest_stays_rest_and_rigid_translation_is_not_felt() {
    for dimension in 1..=3 {
        for scheme in schemes() {
            // Layouts that are not symmetric, in the first place.
            let corner = |x: f64| vec![x; dimension];
            let positions = json!([corner(0.2), corner(0.5), corner(0.9)]);
            for layout in [json!({}), json!({"point_positions": positions})] {
                for start in [json!([0.0, 0.0, 0.0]), json!([3.0, -2.0, 5.0])] {
                    let scene = block(dimension, 4, 1, LAWS[dimension - 1], start.clone())
                        .solver(scheme.clone())
                        .solver(layout.clone());
                    let record = scene.run(&["--record-states", "2"]);
                    let last = record.last();
                    let wave = (1e7_f64 / 1000.0).sqrt();
                    let stress = last.points("MP_CAUCHY_STRESS_VECTOR").concat();
                    let largest = stress.iter().fold(0.0_f64, |most, s| most.max(s.abs()));
                    let moving = start[0] != 0.0;
                    assert!(largest <= if moving { 1e-11 * 1000.0 * wave * 5.0 } else { 0.0 }, "{scheme}: {largest:e}");
                    for (v, u) in last.points("MP_VELOCITY").iter().zip(last.points("MP_DISPLACEMENT")) {
                        for a in 0..dimension {
                            let expected = start[a].as_f64().unwrap();
                            assert!((v[a] - expected).abs() <= 1e-11 * expected.abs(), "{scheme}, {layout}: {v:?}");
                            assert!((u[a] - expected * last.time()).abs() <= 1e-11 * expected.abs());
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn momentum_is_kept_to_round_off_and_energy_never_grows() {
    for dimension in 1..=3 {
        for points in [1, 1 << dimension] {
            for scheme in schemes() {
                let start = json!(["5*sin(9*x + 7*y - 4*z)", "4*cos(8*x*y) - z", "3*sin(11*z - 5*x)"]);
                let scene = block(dimension, 6, points, LAWS[dimension - 1], start).solver(scheme.clone());
                let record = scene.run(&["--record-states", "40"]);
                let (first, mut before) = (record.first().total("momentum"), record.first().energy("total"));
                assert!(record.first().energy("strain") == 0.0 && before > 100.0);
                for state in &record.states()[1..] {
                    for (now, then) in state.total("momentum").iter().zip(first) {
                        assert!((now - then).abs() < 1e-13 * 1000.0 * 5.0 * 10.0, "{scheme}: {now} and {then}");
                    }
                    let energy = state.energy("total");
                    assert!(energy <= before * (1.0 + 1e-12), "{scheme}, {points} points: {energy} J after {before} J");
                    before = energy;
                }
                let most = record.states().iter().map(|state| state.energy("strain")).fold(0.0, f64::max);
                assert!(most > 1.0, "the block must deform: its strain energy is {most} J at most");
            }
        }
    }
}

/// The work of the boundary covers what the bar gains; the rest is what the scheme dissipates.
#[test]
fn boundary_work_balances_the_energy() {
    let record = super::bar::bar(120, 1, 100.0).run(&["--record-states", "20"]);
    for state in record.states() {
        let (energy, work) = (state.energy("total"), state.energy("boundary_work"));
        assert!((energy - work).abs() <= 1e-12 * work, "{energy} J and {work} J at {} s", state.time());
    }
    assert!(record.last().energy("boundary_work") > 1e6);
}

/// Two motions from stress-free states that differ by a rotation Q of space, F = Q F₀ and v = Q v₀, have
/// stresses that do: Π = Q Π₀.
#[test]
fn rotated_motions_have_rotated_stresses() {
    let (c, s) = (0.7_f64.cos(), 0.7_f64.sin());
    // About z by 0.7, then about x by 0.7.
    let q = [[c, -s, 0.0], [c * s, c * c, -s], [s * s, s * c, c]];
    let start = ["20*sin(3*x + 2*y)", "-15*cos(4*y*z)", "10*sin(5*z - x)"];
    let turned = |row: [f64; 3]| {
        let terms: Vec<String> = (0..3).map(|k| format!("({:?})*({})", row[k], start[k])).collect();
        terms.join(" + ")
    };
    let law = "HyperElasticNeoHookean3DLaw";
    for scheme in schemes() {
        let plain = block(3, 5, 1, law, json!(start)).solver(scheme.clone()).run(&[]);
        let mut scene = block(3, 5, 1, law, json!(q.map(turned))).solver(scheme);
        scene.processes[0]["Parameters"]["deformation_gradient"] = json!(q.concat());
        let rotated = scene.run(&[]);
        let (a, b) = (plain.last().points("MP_PK1_STRESS_TENSOR"), rotated.last().points("MP_PK1_STRESS_TENSOR"));
        let largest = a.concat().iter().fold(0.0_f64, |most, stress| most.max(stress.abs()));
        assert!(largest > 1e4, "the block must be loaded: {largest:e} Pa");
        for (a, b) in a.iter().zip(&b) {
            for (i, row) in q.iter().enumerate() {
                for k in 0..3 {
                    let expected: f64 = (0..3).map(|j| row[j] * a[3 * j + k]).sum();
                    assert!((b[3 * i + k] - expected).abs() < 1e-9 * largest, "{} and {expected}", b[3 * i + k]);
                }
            }
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let start = json!(["20*sin(3*x + 2*y)", "-15*cos(4*y*z)", "10*sin(5*z - x)"]);
    for (dimension, cells, points) in [(2, 40, 4), (3, 12, 1)] {
        for scheme in schemes() {
            let mut scene = block(dimension, cells, points, LAWS[dimension - 1], start.clone()).solver(scheme);
            scene.end_time = 0.002;
            let states = |threads: &str| scene.run(&["--threads", threads]).json["snapshots"].clone();
            let one = states("1");
            assert!(one == states("2") && one == states("5"), "threads change the result");
        }
    }
}
