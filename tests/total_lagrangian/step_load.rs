//! Problem B: a bar that a sudden load sets swinging, and its time integration at large steps.

use super::bar::{Bar, CUBIC, Functions, HATS, LINEAR, QUADRATIC, SPLINE, along, energy_drift};
use serde_json::{Value, json};

/// Load per area at x = L, in MPa.
pub const TRACTION: f64 = -1.27;

/// The bar at rest. Units of g, mm and ms, hence MPa.
pub fn bar(cells: usize, functions: Functions, solver: Value) -> Bar {
    Bar {
        cells,
        length: 5.0,
        area: 19.635,
        density: 1.9355e-3,
        young: 250.0,
        poisson: 0.0,
        law: LINEAR,
        functions,
        placement: "even",
        solver,
        processes: Vec::new(),
        end_time: 0.2,
    }
}

/// d'Alembert's displacement at x and t: u = (τ/E)(G(ct − (L − x)) − G(ct − (L + x))), where G rises with slope 1
/// over 2L, rests over 2L, and so on.
pub fn exact(bar: &Bar, x: f64, t: f64) -> f64 {
    let (l, c) = (bar.length, bar.wave_speed());
    let g = |s: f64| if s <= 0.0 { 0.0 } else { 2.0 * l * (s / (4.0 * l)).floor() + (s % (4.0 * l)).min(2.0 * l) };
    TRACTION / bar.young * (g(c * t - (l - x)) - g(c * t - (l + x)))
}

/// Root mean square error of the last point's displacement over the run, relative to the peak 2τL/E.
pub fn error(cells: usize, courant: f64, solver: Value) -> f64 {
    let bar = bar(cells, HATS, solver).pulled(json!(TRACTION * 19.635)).at_courant(courant);
    let record = bar.run(100_000);
    let x = *along(&record.first().points("MP_COORD")).last().unwrap();
    let states = record.states();
    let squares: f64 = states
        .iter()
        .map(|state| {
            let found = *along(&state.points("MP_DISPLACEMENT")).last().unwrap();
            (found - exact(&bar, x, state.time())).powi(2)
        })
        .sum();
    (squares / states.len() as f64).sqrt() / (2.0 * TRACTION * bar.length / bar.young).abs()
}

fn trapezoidal() -> Value {
    json!({"scheme_type": "newmark"})
}

/// Stable and bounded far beyond the limit of explicit schemes. The figures in the comments are those
/// of an independent prototype of the trapezoidal rule with lumped mass and hats, in %.
#[test]
fn large_steps_are_stable() {
    for (courant, most) in [(0.5, 0.0089), (1.0, 0.0125), (10.0, 0.087), (100.0, 0.42)] {
        let found = error(32, courant, trapezoidal()); // .87, 1.2, 8.5, 41
        assert!(found < most, "32 cells, Courant {courant}: {found}");
        assert!(found > 0.9 * most, "32 cells, Courant {courant}: {found}: the bound no longer says anything");
    }
    for (courant, most) in [(10.0, 0.0131), (100.0, 0.121)] {
        let found = error(256, courant, trapezoidal()); // 1.3, 12
        assert!(found < most, "256 cells, Courant {courant}: {found}");
    }
}

/// The trapezoidal rule keeps the energy of a linear system, and the transfer through the consistent
/// mass loses none of it.
#[test]
fn energy_is_kept_at_any_step() {
    for functions in [HATS, QUADRATIC, SPLINE, CUBIC] {
        for courant in [1.0, 10.0, 100.0] {
            let solver = json!({"scheme_type": "newmark", "consistent_mass_matrix": true});
            let record = bar(32, functions, solver).flung("0.1*x").at_courant(courant).run(100_000);
            let drift = energy_drift(&record);
            assert!(drift < 1e-11, "{functions:?}, Courant {courant}: {drift:e}");
        }
    }
}

/// Errors of the displacement at one time against a fine step, on the same grid.
fn differences(solver: &Value) -> Vec<f64> {
    let at = |steps: usize| {
        let mut bar = bar(16, QUADRATIC, solver.clone()).flung("sin(pi*x/10)");
        // A third of the period 4L/c.
        bar.end_time = 4.0 * bar.length / bar.wave_speed() / 3.0;
        let step = bar.end_time / steps as f64;
        bar.solver["time_stepping"] = json!({"time_step": step});
        bar.end_time -= 0.5 * step;
        along(&bar.run(1).last().points("MP_DISPLACEMENT"))
    };
    let reference = at(640);
    let difference = |u: Vec<f64>| u.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    [10, 20, 40].map(|steps| difference(at(steps))).to_vec()
}

#[test]
fn all_schemes_are_of_second_order_in_the_step() {
    let schemes = [
        json!({"scheme_type": "newmark"}),
        json!({"scheme_type": "newmark", "consistent_mass_matrix": true}),
        json!({"scheme_type": "bossak", "damp_factor_m": -0.1}),
        json!({"scheme_type": "energy_conserving"}),
    ];
    for solver in schemes {
        let orders = super::common::orders(&differences(&solver));
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.1), "{solver}: {orders:?}");
    }
}

/// PIC's share dissipates with every projection: more with more steps.
#[test]
fn a_share_of_pic_dissipates() {
    let kept = |fraction: f64, courant: f64| {
        let solver = json!({"scheme_type": "newmark", "flip_fraction": fraction});
        let record = bar(32, HATS, solver).flung("0.1*x").at_courant(courant).run(100_000);
        let energy = |state: super::common::State| state.energy("kinetic") + state.energy("strain");
        energy(record.last()) / energy(record.first())
    };
    let (half, fine, all) = (kept(0.5, 1.0), kept(0.5, 0.5), kept(0.0, 1.0));
    assert!(half < 0.99 && fine < half && all < half, "{half} {fine} {all}");
}
