//! Problem A: a column pressed to two fifths of its length in uniaxial strain, with its weight.
//!
//! Equilibrium: P(X) = τ + ρ₀ b (L − X), P = μ (F − 1/F) + λ ln F/F, u = ∫ (F − 1) dX. The exact
//! u(L) = −0.05862504 m and F(L) = 0.413859 are found here by inversion and quadrature.

use super::bar::{Bar, Functions, HATS, NEO_HOOKEAN, QUADRATIC, SPLINE, along};
use super::common::Record;
use serde_json::{Value, json};

pub const LENGTH: f64 = 0.1;
pub const DENSITY: f64 = 10.0;
const GRAVITY: f64 = -9.81;
const PRESSURE: f64 = 1e4;
pub const YOUNG: f64 = 5e3;
const POISSON: f64 = 0.3;

/// The column at rest, with its weight and the load that rises to its full size in 1 s.
pub fn column(functions: Functions, placement: &'static str, solver: Value) -> Bar {
    let weight = json!({"python_module": "assign_gravity_to_material_point_process",
        "Parameters": {"model_part_name": "MPM_Material", "modulus": -GRAVITY, "direction": [-1, 0, 0]}});
    let area = 1e-4;
    Bar {
        cells: 10,
        length: LENGTH,
        area,
        density: DENSITY,
        young: YOUNG,
        poisson: POISSON,
        law: NEO_HOOKEAN,
        functions,
        placement,
        solver,
        processes: vec![weight],
        end_time: 1.0,
    }
    .pulled(json!(format!("{}*min(t, 1)", -PRESSURE * area)))
}

fn nominal_stress(x: f64) -> f64 {
    -PRESSURE + DENSITY * GRAVITY * (LENGTH - x)
}

/// F for which the law gives P, by Newton's method.
fn stretch(stress: f64) -> f64 {
    let (lambda, mu) = (YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON), YOUNG / 2.0 / (1.0 + POISSON));
    let mut f: f64 = 0.6;
    for _ in 0..50 {
        let value = mu * (f - 1.0 / f) + lambda * f.ln() / f - stress;
        f -= value / (mu * (1.0 + 1.0 / (f * f)) + lambda * (1.0 - f.ln()) / (f * f));
    }
    f
}

/// u(X) by the midpoint rule, error below 1e-12 m.
fn displacement(x: f64) -> f64 {
    let h = x / 1000.0;
    (0..1000).map(|i| (stretch(nominal_stress((f64::from(i) + 0.5) * h)) - 1.0) * h).sum()
}

/// Largest errors of u relative to u(L), of F, and of P relative to the pressure.
pub fn errors(bar: &Bar) -> [f64; 3] {
    errors_of(&bar.run(1))
}

/// The same of a record.
pub fn errors_of(record: &Record) -> [f64; 3] {
    let (first, last) = (record.first(), record.last());
    let places = along(&first.points("MP_COORD"));
    let stretches: Vec<f64> =
        last.scalars("MP_VOLUME").iter().zip(first.scalars("MP_VOLUME")).map(|(v, v0)| v / v0).collect();
    let largest = |found: &[f64], exact: &dyn Fn(f64) -> f64| {
        found.iter().zip(&places).map(|(f, &x)| (f - exact(x)).abs()).fold(0.0, f64::max)
    };
    [
        largest(&along(&last.points("MP_DISPLACEMENT")), &displacement) / displacement(LENGTH).abs(),
        largest(&stretches, &|x| stretch(nominal_stress(x))),
        largest(&along(&last.points("MP_CAUCHY_STRESS_VECTOR")), &nominal_stress) / PRESSURE,
    ]
}

fn in_steps(kind: &str, count: usize, functions: Functions, placement: &'static str) -> Bar {
    let step = 1.0 / count as f64;
    let solver = json!({"solver_type": kind, "time_stepping": {"time_step": step}});
    Bar { end_time: 1.0 - 0.5 * step, ..column(functions, placement, solver) }
}

#[test]
fn the_reference_is_that_of_the_tables() {
    assert!((stretch(-PRESSURE) - 0.413_858_88).abs() < 1e-8);
    assert!((displacement(LENGTH) + 0.058_625_04).abs() < 1e-8);
    assert!((displacement(0.01) + 5.863_488e-3).abs() < 1e-9);
}

/// Evenly placed points and hats are exact but for the weight within a cell; Gauss points with
/// functions of order 2 are exact but for the quadrature of the curved u.
#[test]
fn the_column_finds_its_equilibrium_in_five_steps() {
    for kind in ["static", "quasi_static"] {
        let [u, f, p] = errors(&in_steps(kind, 5, HATS, "even"));
        assert!(u < 5e-7 && f < 1e-5 && p < 5e-5, "{kind}: {u:e} {f:e} {p:e}");
        for functions in [QUADRATIC, SPLINE] {
            let [u, f, p] = errors(&in_steps(kind, 5, functions, "gauss"));
            assert!(u < 1e-10 && f < 1e-9 && p < 1e-8, "{kind}, {functions:?}: {u:e} {f:e} {p:e}");
        }
    }
}

/// The points keep F and forget the steps by which they came to it.
#[test]
fn equilibrium_does_not_depend_on_the_steps() {
    let [few, many] = [5, 40].map(|count| in_steps("quasi_static", count, HATS, "even"));
    let positions = |bar: &Bar| along(&bar.run(1).last().points("MP_COORD"));
    let difference = positions(&few).iter().zip(positions(&many)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-11, "{difference:e}");
}
