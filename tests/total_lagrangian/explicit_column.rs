//! Problem A with explicit steps: the load rises slowly, and the scheme's own dissipation brings the
//! column to rest.

use super::bar::{Functions, HATS, QUADRATIC, SPLINE, explicit};
use super::static_column::{DENSITY, LENGTH, YOUNG, column, errors, errors_of};
use serde_json::{Value, json};

/// Errors of u relative to u(L), of F, and of P relative to the pressure, at 1.2 s. The step is the
/// document's, a tenth of what √(E/ρ) needs for a cell.
fn at_rest(functions: Functions, members: Value) -> [f64; 3] {
    let step = 0.1 * LENGTH / 10.0 / (YOUNG / DENSITY).sqrt();
    let mut solver = explicit(members);
    solver["time_stepping"] = json!({"time_step": step});
    let mut bar = column(functions, "even", solver);
    bar.end_time = 1.2 - 0.5 * step;
    errors(&bar)
}

/// Points that move with the very velocity that deforms them are where the exact solution has them.
#[test]
fn the_column_comes_to_its_equilibrium() {
    for functions in [HATS, Functions { points: 2, ..SPLINE }, SPLINE] {
        let [u, f, p] = at_rest(functions, json!({"flip_fraction": 0.5}));
        assert!(u < 7e-7 && f < 1e-5 && p < 5e-5, "{functions:?}: {u:e} {f:e} {p:e}");
    }
}

/// The document moves points with their own velocity, which is not the one that makes F: the
/// displacement is wrong by 5 % of u(L), 3.3 % with quadratic splines, while F is right.
#[test]
fn points_that_move_with_their_own_velocity_miss_it() {
    for (functions, wrong) in [(HATS, 0.0500), (Functions { points: 2, ..SPLINE }, 0.0335)] {
        let [u, f, _] = at_rest(functions, json!({"flip_fraction": 0.5, "position_update": "point"}));
        assert!((u / wrong - 1.0).abs() < 0.02 && f < 1e-5, "{functions:?}: {u:e} {f:e}");
    }
}

/// The midpoint rule of even points is not exact for polynomials of degree 2, where points that fill
/// the space of functions have nothing to smooth.
#[test]
fn quadratic_polynomials_need_more_points() {
    for (points, [lowest, highest]) in [(2, [1e-3, 3e-3]), (3, [1e-4, 1e-3])] {
        let [u, f, _] = at_rest(Functions { points, ..QUADRATIC }, json!({"flip_fraction": 0.5}));
        assert!(lowest < u && u < highest && f < highest, "{points} points: {u:e} {f:e}");
    }
}

/// FLIP alone has nothing that damps: the swing that the sudden weight starts goes on.
#[test]
fn without_a_share_of_pic_the_column_swings() {
    let [_, f, p] = at_rest(HATS, json!({}));
    assert!((1e-4..2e-3).contains(&f) && p < 1e-2, "{f:e} {p:e}");
}

/// At F = 0.41 waves cross the undeformed cells 2.6 times as fast as at the start. A step that does not
/// know is unstable at half of the load.
#[test]
fn the_automatic_step_follows_the_compression() {
    let mut bar = column(HATS, "even", explicit(json!({"time_stepping": {"time_step": "auto"}, "flip_fraction": 0.5})));
    bar.end_time = 1.2;
    let record = bar.run(1);
    let [u, f, p] = errors_of(&record);
    assert!(u < 1e-4 && f < 1e-4 && p < 5e-4, "{u:e} {f:e} {p:e}");
    let steps = record.json["steps"].as_f64().unwrap();
    let at_start = bar.end_time * bar.wave_speed() * bar.cells as f64 / bar.length;
    assert!(steps > 1.2 * at_start / 1.6 && steps < 3.0 * at_start, "{steps} steps");
}
