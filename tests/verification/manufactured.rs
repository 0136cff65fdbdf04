//! Manufactured solution with axis-aligned displacements on the unit square, between sliding walls:
//! u = A sin(2πX) s(t), v = −A sin(2πY) s(t), for the neo-Hookean law P = μ(F − F⁻ᵀ) + λ ln J F⁻ᵀ.
//!
//! Source: Wallstedt and Guilkey, An evaluation of explicit time integration schemes for use with
//! the generalized interpolation material point method, J. Comput. Phys. 227 (2008) 9628-9642, §5.
//! The body acceleration follows from ρ b = ρ ü − Div P:
//! b_X = π² u/ρ (4μ − c² ρ − 4 (λ (ln J − 1) − μ)/F_xx²) with s = sin(cπt), and without c² in statics.

use super::common::{Cell, Mesh, Record, Scene, fix, material, orders, process};
use serde_json::{Value, json};
use std::f64::consts::PI;

const YOUNG: f64 = 1e7;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 1000.0;

fn speed() -> f64 {
    (YOUNG / DENSITY).sqrt()
}

/// Components of the body acceleration as functions of X, Y and t.
fn body_acceleration(amplitude: f64, in_time: &str, with_inertia: bool) -> Value {
    let lambda = YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON);
    let mu = YOUNG / 2.0 / (1.0 + POISSON);
    let (a, rho) = (amplitude, DENSITY);
    let inertia = if with_inertia { speed().powi(2) * rho } else { 0.0 };
    let fx = format!("(1 + 2*pi*{a:?}*cos(2*pi*X)*{in_time})");
    let fy = format!("(1 - 2*pi*{a:?}*cos(2*pi*Y)*{in_time})");
    let along = |displacement: String, f: &str| {
        format!(
            "pi**2*{displacement}/{rho:?} * \
             (4*{mu:?} - {inertia:?} - 4*({lambda:?}*(log({fx}*{fy}) - 1) - {mu:?})/{f}**2)"
        )
    };
    json!([
        along(format!("{a:?}*sin(2*pi*X)*{in_time}"), &fx),
        along(format!("(-{a:?})*sin(2*pi*Y)*{in_time}"), &fy),
        0.0
    ])
}

fn run(cell: Cell, points: usize, cells: usize, body_force: Value, velocity: Value, solver: Value, end: f64) -> Record {
    let mesh = Mesh::block(cell, [cells, cells, 1], [0.0; 3], [1.0, 1.0, 0.0]);
    let law = "HyperElasticNeoHookeanPlaneStrain2DLaw";
    let on_body = |value: Value| json!({"model_part_name": "MPM_Material", "value": value});
    Scene::new(mesh.clone(), mesh, material(law, points, DENSITY, YOUNG, POISSON), solver, end)
        .part("Sides", |x| x[0] == 0.0 || x[0] == 1.0)
        .part("Ends", |x| x[1] == 0.0 || x[1] == 1.0)
        .with(fix("Sides", json!([0.0, null, null])))
        .with(fix("Ends", json!([null, 0.0, null])))
        .with(process("assign_body_acceleration_to_material_point_process", on_body(body_force)))
        .with(process("assign_initial_field_to_material_point_process", on_body(velocity)))
        .run(&["--record-states", "1"])
}

/// Error of the points' displacement in the L2 norm (weighted with their volumes), relative to the
/// exact displacement with amplitude `size`.
fn error(record: &Record, size: f64) -> f64 {
    let (start, last) = (record.first(), record.last());
    let (places, volumes) = (start.points("MP_COORD"), start.scalars("MP_VOLUME"));
    let (mut difference, mut total) = (0.0, 0.0);
    for ((x, u), volume) in places.iter().zip(last.points("MP_DISPLACEMENT")).zip(volumes) {
        let exact = [size * (2.0 * PI * x[0]).sin(), -size * (2.0 * PI * x[1]).sin()];
        difference += volume * ((u[0] - exact[0]).powi(2) + (u[1] - exact[1]).powi(2));
        total += volume * (exact[0].powi(2) + exact[1].powi(2));
    }
    (difference / total).sqrt()
}

/// One static step with a displacement gradient of 0.25: finite deformation.
#[test]
fn static_displacement_converges_with_second_order() {
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Triangle, 3)] {
        let amplitude = 0.04;
        let errors = [8, 16, 32].map(|cells| {
            let force = body_acceleration(amplitude, "1", false);
            let record = run(cell, points, cells, force, json!([0, 0, 0]), json!({}), 1.0);
            error(&record, amplitude)
        });
        assert!(errors[2] < 7e-3, "{cell:?}: errors {errors:?}");
        assert!(orders(&errors).iter().all(|order| *order > 1.8), "{cell:?}: errors {errors:?}");
    }
}

/// An eighth of the period c t = 2 in 50 Newmark steps. The amplitude is a hundredth of a millimetre:
/// as soon as points move by a distance d from where they are integration points, linear functions
/// take Div P from the middle of the cell they came from, an error of 2π d whatever the cell size
/// (measured here: 3e-3 of the displacement for A = 1 mm).
fn dynamic(cell: Cell, points: usize, cells: usize) -> f64 {
    let (amplitude, end) = (1e-5, 0.25 / speed());
    let dt = end / 50.0;
    let s = format!("sin({:?}*pi*t)", speed());
    let solver = json!({"solver_type": "dynamic", "scheme_type": "newmark", "time_stepping": {"time_step": dt},
                        "residual_relative_tolerance": 1e-8});
    let v = amplitude * speed() * PI;
    let velocity = json!([format!("{v:?}*sin(2*pi*X)"), format!("-{v:?}*sin(2*pi*Y)"), 0.0]);
    let force = body_acceleration(amplitude, &s, true);
    let record = run(cell, points, cells, force, velocity, solver, end - 0.5 * dt);
    error(&record, amplitude * (PI * 0.25).sin())
}

#[test]
fn dynamic_displacement_converges_with_second_order_in_space() {
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Quadrilateral, 9), (Cell::Triangle, 3)] {
        let errors = [8, 16, 32].map(|cells| dynamic(cell, points, cells));
        assert!(errors[2] < 1e-2, "{cell:?}: errors {errors:?}");
        assert!(orders(&errors).iter().all(|order| *order > 1.8), "{cell:?}, {points} points: errors {errors:?}");
    }
}
