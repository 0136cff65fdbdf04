//! A plate of 4 m by 3 m on a roller, hit at 5 m/s over the lowest metre of its left side: plane strain,
//! steel. A plane wave of −ρ c_p v = −229.13 MPa runs ahead, release waves follow from the edge.
//!
//! Source: Renaud and Heuzé (2017), §5.2. Reference: finite volumes of order 2 with 1600 × 1200 cells.
//! The same problem by finite elements at Courant 0.9 has errors of 9.0, 11.0 and 9.8 % in the L1 norm, by
//! the explicit material point method 23.7, 21.5 and 20.9 % (independent prototypes, 32 × 24 cells).

use super::scene::{Scene, constants, hold};
use serde_json::{Value, json};

const IMPEDANCE_TIMES_SPEED: f64 = 229.12878;

/// Time in s, least σ_xx on the line in MPa, and its means over 32 cells; 0 beyond them.
const REFERENCE: [(f64, f64, &[f64]); 3] = [
    (
        0.00019999999999999998,
        -229.129,
        &[-219.786, -219.257, -218.179, -217.244, -220.542, -229.095, -229.129, -229.129, -229.129, -91.723],
    ),
    (
        0.00039999999999999996,
        -256.034,
        &[
            -214.229, -217.302, -222.478, -228.449, -234.48, -242.361, -253.182, -241.895, -226.925, -211.055,
            -195.852, -182.328, -171.186, -163.083, -159.082, -161.76, -182.815, -228.751, -183.303,
        ],
    ),
    (
        0.0005499999999999999,
        -255.353,
        &[
            -236.013, -239.247, -244.456, -249.797, -253.688, -255.219, -254.372, -251.532, -247.478, -243.341,
            -241.645, -247.508, -228.583, -208.353, -190.429, -174.845, -161.533, -150.392, -141.367, -134.497,
            -130.011, -128.54, -131.719, -144.871, -199.936, -192.505,
        ],
    ),
];

/// The plate at its largest stable step, whose last part ends at the wanted time.
fn plate(cells: [usize; 2], time: f64, courant: f64, solver: &Value) -> Scene {
    let size = (4.0 / cells[0] as f64).min(3.0 / cells[1] as f64);
    let step = courant * size / 5875.097;
    let whole = (time / step).floor();
    let (rest, change) = (time - whole * step, (whole - 0.5) * step);
    // Whole steps, then the rest.
    let table = json!([[0.0, step], [change, step], [change + 1e-3 * step, rest], [1.0, rest]]);
    let constants = constants(7800.0, 2e11, 0.3, 1);
    let law = "LinearElasticIsotropicPlaneStrain2DLaw";
    let mut scene = Scene::new([4.0, 3.0, 0.0], &cells, law, constants, time - 0.5 * rest)
        .solver(json!({"strain": "small", "time_stepping": {"time_step_table": table}}))
        .solver(solver.clone())
        .side("Floor", "min_y", None)
        .side("Right", "max_x", None)
        .with(hold("Hit", json!([5.0, null, null])))
        .with(hold("Floor", json!([null, 0.0, null])))
        .with(hold("Right", json!([0.0, null, null])));
    scene.parts.push(json!({"name": "Hit", "box": {"min": [0.0, 0.0, 0.0], "max": [0.0, 1.0, 0.0]}}));
    scene
}

/// Relative L1 error of σ_xx along the bottom row, and by how much it goes below the least of the
/// reference, of ρ c_p v.
fn errors(cells: [usize; 2], courant: f64, solver: &Value, (time, least, reference): (f64, f64, &[f64])) -> [f64; 2] {
    let record = plate(cells, time, courant, solver).run(&[]);
    assert!((record.last().time() / time - 1.0).abs() < 1e-9, "ends at {} s", record.last().time());
    let stress = record.last().points("MP_CAUCHY_STRESS_VECTOR");
    let fine = cells[0] / 32;
    let mean = |i: usize| (0..fine).map(|k| stress[i * fine + k][0]).sum::<f64>() / fine as f64 / 1e6;
    let exact = |i: usize| reference.get(i).copied().unwrap_or(0.0);
    let difference: f64 = (0..32).map(|i| (mean(i) - exact(i)).abs()).sum();
    let lowest = stress[..cells[0]].iter().map(|s| s[0] / 1e6).fold(0.0, f64::min);
    [difference / (0..32).map(|i| exact(i).abs()).sum::<f64>(), (least - lowest).max(0.0) / IMPEDANCE_TIMES_SPEED]
}

const CORRECTED: &str = r#"{"transverse_correction": true}"#;

#[test]
fn the_front_is_sharper_than_by_finite_elements_and_points() {
    let corrected: Value = serde_json::from_str(CORRECTED).unwrap();
    for (reference, others) in REFERENCE.into_iter().zip([[0.090, 0.237], [0.110, 0.215], [0.098, 0.209]]) {
        let [coarse, below] = errors([32, 24], 1.0, &corrected, reference);
        assert!(coarse < 0.6 * others[0] && coarse < others[1] / 3.0, "t = {} s: {coarse}", reference.0);
        assert!(below < 0.02, "t = {} s: {below} below the reference", reference.0);
        let [fine, _] = errors([64, 48], 1.0, &corrected, reference);
        assert!(fine < 0.65 * coarse, "t = {} s: {coarse}, then {fine} on cells half as wide", reference.0);
        // Cells that do not match the edge of the impact, as in the source.
        let [_, below] = errors([33, 25], 1.0, &corrected, reference);
        assert!(below < 0.04, "33 x 25, t = {} s: {below} below the reference", reference.0);
    }
}

/// Without the correction the stable step is .652 of that, and the front is smeared (12.5, 14.7 and 13.1 %
/// by an independent prototype).
#[test]
fn without_transverse_correction_the_front_is_smeared() {
    for (reference, prototype) in REFERENCE.into_iter().zip([0.125, 0.147, 0.131]) {
        let [error, _] = errors([32, 24], 0.65, &json!({}), reference);
        assert!((error / prototype - 1.0).abs() < 0.1, "t = {} s: {error}", reference.0);
    }
}

/// With one point a cell the mid-point rule on the cells' nodes is the transverse correction.
#[test]
fn the_mid_point_rule_has_the_correction_built_in() {
    let corrected: Value = serde_json::from_str(CORRECTED).unwrap();
    let stress = |solver: &Value| {
        let record = plate([32, 24], 0.4e-3, 1.0, solver).run(&[]);
        record.last().points("MP_CAUCHY_STRESS_VECTOR").concat()
    };
    let (euler, mid_point) = (stress(&corrected), stress(&json!({"time_integration": "rk2"})));
    let largest = euler.iter().zip(&mid_point).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(largest < 1e-13 * 1e6 * IMPEDANCE_TIMES_SPEED * 100.0, "{largest:e} Pa");
}

/// Means of σ_xx in MPa on y = 0 at 0.4 ms under a pressure that is smooth in time and space: finite
/// volumes with Richardson's extrapolation, which agree with finite elements of order 5 to 7e-4.
const SMOOTH: [f64; 19] = [
    -202.746, -208.037, -211.77, -212.627, -209.812, -202.926, -192.228, -179.525, -167.856, -159.718, -156.567,
    -159.237, -164.406, -156.805, -127.983, -84.162, -39.927, -10.256, -0.513,
];

/// Relative L1 error of σ_xx along the bottom row.
fn smooth_error(cells: usize, points: usize, courant: f64, solver: &str) -> f64 {
    let (time, size) = (0.4e-3, 4.0 / cells as f64);
    let step = time / (time * 5875.097 / (courant * size)).ceil();
    // A smooth step from 0 to 1: s³ (10 − 15 s + 6 s²). The load acts in the middle of each step.
    let smooth = |s: &str| format!("({s})**3*(10 - 15*({s}) + 6*({s})**2)");
    let ramp = smooth(&format!("min((t - {:?})/1.5e-4, 1)", 0.5 * step));
    let window = smooth("min(max(y - 0.5, 0), 1)");
    let load = json!([format!("2e8*{ramp}*(1 - {window})"), 0.0, 0.0]);
    let law = "LinearElasticIsotropicPlaneStrain2DLaw";
    let constants = constants(7800.0, 2e11, 0.3, points);
    let record = Scene::new([4.0, 3.0, 0.0], &[cells, cells * 3 / 4], law, constants, time - 0.5 * step)
        .solver(json!({"strain": "small", "time_stepping": {"time_step": step}}))
        .solver(serde_json::from_str(solver).unwrap())
        .side("Left", "min_x", Some("LineLoadCondition2D2N"))
        .side("Floor", "min_y", None)
        .side("Right", "max_x", None)
        .with(super::scene::load("Left", "LINE_LOAD", load))
        .with(hold("Floor", json!([null, 0.0, null])))
        .with(hold("Right", json!([0.0, null, null])))
        .run(&[]);
    let (start, last) = (record.first().points("MP_COORD"), record.last());
    let mut sums = [(0.0, 0); 32];
    for (x, stress) in start.iter().zip(last.points("MP_CAUCHY_STRESS_VECTOR")) {
        if x[1] < size / (points as f64).sqrt() {
            let (sum, count) = &mut sums[(x[0] * 8.0) as usize];
            (*sum, *count) = (*sum + stress[0] / 1e6, *count + 1);
        }
    }
    let exact = |i: usize| SMOOTH.get(i).copied().unwrap_or(0.0);
    let difference: f64 = sums.iter().enumerate().map(|(i, (sum, n))| (sum / f64::from(*n) - exact(i)).abs()).sum();
    difference / SMOOTH.iter().map(|s| s.abs()).sum::<f64>()
}

/// First order: .86 and .98 with the correction, .63 and .77 without, .79 and .89 with RK2 and four points
/// by an independent prototype.
#[test]
fn smooth_solutions_converge_with_first_order() {
    for (points, courant, solver, least) in
        [(1, 1.0, CORRECTED, 0.75), (1, 0.6, "{}", 0.6), (4, 1.0, r#"{"time_integration": "rk2"}"#, 0.75)]
    {
        let errors = [32, 64, 128].map(|cells| smooth_error(cells, points, courant, solver));
        let orders = super::common::orders(&errors);
        assert!(orders[0] > least && orders[1] > orders[0] && orders[1] < 1.3, "{solver}: {errors:?}, {orders:?}");
        assert!(errors[2] < if courant == 1.0 { 0.01 } else { 0.04 }, "{solver}: {errors:?}");
    }
}

/// The two-wave solver is the other one for pressure waves along a row, and smears more in the plane.
#[test]
fn the_two_wave_solver_is_the_worse_one_in_the_plane_alone() {
    let along = |riemann: &str| {
        let record = super::bar::bar(60, 2, 40.0).solver(json!({"riemann_solver": riemann})).run(&[]);
        record.last().points("MP_CAUCHY_STRESS_VECTOR").concat()
    };
    let pairs = along("hll").into_iter().zip(along("linearized"));
    assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-5);
    let error = |riemann: &str| errors([32, 24], 0.4, &json!({"riemann_solver": riemann}), REFERENCE[1])[0];
    let (two_waves, all) = (error("hll"), error("linearized"));
    assert!(all < two_waves && two_waves < 2.0 * all, "{two_waves} and {all}");
}
