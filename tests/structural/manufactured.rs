//! Manufactured solution with axis-aligned displacements on the unit square, between sliding walls:
//! u = A sin(2πX) s(t), v = −A sin(2πY) s(t), for the neo-Hookean law P = μ(F − F⁻ᵀ) + λ ln J F⁻ᵀ.
//!
//! Source: Wallstedt and Guilkey, J. Comput. Phys. 227 (2008) 9628-9642, §5. The body acceleration
//! follows from ρ b = ρ ü − Div P. Being total-Lagrangian, the elements must keep their order at any
//! amplitude; here the displacement gradient reaches 0.25.

use super::body::{Body, assign, fix, material};
use super::common::{Cell, Mesh, Record, orders, process};
use serde_json::{Value, json};
use std::f64::consts::PI;

const YOUNG: f64 = 1e7;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 1000.0;
const AMPLITUDE: f64 = 0.04;

fn speed() -> f64 {
    (YOUNG / DENSITY).sqrt()
}

/// Components of the body acceleration as functions of X, Y and t.
fn body_acceleration(in_time: &str, with_inertia: bool) -> Value {
    let lambda = YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON);
    let mu = YOUNG / 2.0 / (1.0 + POISSON);
    let inertia = if with_inertia { speed().powi(2) * DENSITY } else { 0.0 };
    let fx = format!("(1 + 2*pi*{AMPLITUDE:?}*cos(2*pi*X)*{in_time})");
    let fy = format!("(1 - 2*pi*{AMPLITUDE:?}*cos(2*pi*Y)*{in_time})");
    let along = |displacement: String, f: &str| {
        format!(
            "pi**2*{displacement}/{DENSITY:?} * \
             (4*{mu:?} - {inertia:?} - 4*({lambda:?}*(log({fx}*{fy}) - 1) - {mu:?})/{f}**2)"
        )
    };
    json!([
        along(format!("{AMPLITUDE:?}*sin(2*pi*X)*{in_time}"), &fx),
        along(format!("(-{AMPLITUDE:?})*sin(2*pi*Y)*{in_time}"), &fy),
        0.0
    ])
}

/// Relative error of the displacement in the L2 norm over the nodes.
fn error(cell: Cell, cells: usize, force: Value, start: Value, solver: Value, (end, size): (f64, f64)) -> f64 {
    let mesh = Mesh::block(cell, [cells, cells, 1], [0.0; 3], [1.0, 1.0, 0.0]);
    let velocity = json!({"model_part_name": "Structure.All", "variable_name": "VELOCITY", "interval": [0.0, 0.0],
                          "constrained": false, "value": start});
    let stuff = material("HyperElasticNeoHookeanPlaneStrain2DLaw", DENSITY, YOUNG, POISSON);
    let body = Body::new(mesh, stuff, solver, end)
        .part("Sides", |x| x[0] == 0.0 || x[0] == 1.0)
        .part("Ends", |x| x[1] == 0.0 || x[1] == 1.0)
        .part("All", |_| true)
        .with(fix("Sides", json!([0.0, null, null])))
        .with(fix("Ends", json!([null, 0.0, null])))
        .with(assign("All", "VOLUME_ACCELERATION", force, false))
        .with(process("assign_vector_variable_process", velocity));
    let record: Record = body.run(&[]);
    let (mut difference, mut total) = (0.0, 0.0);
    for (x, u) in body.mesh.nodes.iter().zip(record.last().nodes("DISPLACEMENT")) {
        let exact = [size * (2.0 * PI * x[0]).sin(), -size * (2.0 * PI * x[1]).sin()];
        difference += (u[0] - exact[0]).powi(2) + (u[1] - exact[1]).powi(2);
        total += exact[0].powi(2) + exact[1].powi(2);
    }
    (difference / total).sqrt()
}

fn assert_second_order(cell: Cell, method: &str, errors: [f64; 3]) {
    assert!(errors[2] < 1e-2, "{cell:?}, {method}: errors {errors:?}");
    assert!(orders(&errors).iter().all(|order| *order > 1.85), "{cell:?}, {method}: errors {errors:?}");
}

#[test]
fn statics() {
    for cell in [Cell::Quadrilateral, Cell::Triangle] {
        let still = json!([0.0, 0.0, 0.0]);
        let errors = [8, 16, 32]
            .map(|cells| error(cell, cells, body_acceleration("1", false), still.clone(), json!({}), (1.0, AMPLITUDE)));
        assert_second_order(cell, "static", errors);
    }
}

/// Three eighths of the period, time steps that shrink with the cells.
#[test]
fn dynamics() {
    let s = format!("sin({:?}*pi*t)", speed());
    let v = AMPLITUDE * speed() * PI;
    let start = json!([format!("{v:?}*sin(2*pi*X)"), format!("-{v:?}*sin(2*pi*Y)"), 0.0]);
    let end = 0.75 / speed();
    for cell in [Cell::Quadrilateral, Cell::Triangle] {
        for explicit in [false, true] {
            let errors = [8, 16, 32].map(|cells| {
                let dt = end / (15.0 * cells as f64);
                let mut solver = json!({"solver_type": "structural_dynamic", "time_stepping": {"time_step": dt},
                                        "residual_relative_tolerance": 1e-8});
                match explicit {
                    true => solver["time_integration_method"] = json!("explicit"),
                    false => solver["scheme_type"] = json!("newmark"),
                }
                let size = AMPLITUDE * (0.75 * PI).sin();
                error(cell, cells, body_acceleration(&s, true), start.clone(), solver, (end - 0.5 * dt, size))
            });
            assert_second_order(cell, if explicit { "central differences" } else { "newmark" }, errors);
        }
    }
}
