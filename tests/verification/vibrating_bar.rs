//! Axial vibration of a bar that is fixed at one end, in its first mode: with v(x, 0) = v0 sin(βx),
//! β = π/2L, the centre of mass has the velocity (2/π) v0 cos(ω t), ω = β √(E/ρ).
//!
//! Source: Bardenhagen and Kober, The generalized interpolation material point method, CMES 5
//! (2004) 477-495; L = 25 m, E = 100 Pa, ρ = 1 kg/m³, ν = 0. The speed is small here, v0 = 1 mm/s, so that
//! points stay in their cells and the strain, 1e-4, hardly changes the stiffness.

use super::common::{Cell, Mesh, Record, Scene, fix, material, orders, process};
use serde_json::json;
use std::f64::consts::PI;

const LENGTH: f64 = 25.0;
const YOUNG: f64 = 100.0;
const DENSITY: f64 = 1.0;
const SPEED: f64 = 1e-3;

fn frequency() -> f64 {
    PI / (2.0 * LENGTH) * (YOUNG / DENSITY).sqrt()
}

/// One period of the bar on `cells` cells, in `steps` steps.
fn bar(cell: Cell, points: usize, cells: usize, steps: usize, scheme: &str) -> Record {
    let size = LENGTH / cells as f64;
    let mesh = Mesh::block(cell, [cells, 1, 1], [0.0; 3], [LENGTH, size, size]);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    let period = 2.0 * PI / frequency();
    let dt = period / steps as f64;
    let solver = json!({"solver_type": "dynamic", "scheme_type": scheme, "time_stepping": {"time_step": dt},
                        "residual_relative_tolerance": 1e-9, "point_velocity_rule": "scheme"});
    let velocity = json!({
        "model_part_name": "MPM_Material",
        "value": [format!("{SPEED:?} * sin(pi * x / {:?})", 2.0 * LENGTH), 0.0, 0.0]
    });
    Scene::new(mesh.clone(), mesh, material(law, points, DENSITY, YOUNG, 0.0), solver, period - 0.5 * dt)
        .part("Wall", |x| x[0] == 0.0)
        .part("All", |_| true)
        .with(fix("Wall", json!([0.0, null, null])))
        .with(fix("All", json!([null, 0.0, 0.0])))
        .with(process("assign_initial_field_to_material_point_process", velocity))
        .run(&["--record-states", "40"])
}

/// Largest error of the centre's velocity over a period, relative to its amplitude.
fn error(record: &Record) -> f64 {
    let states = record.states();
    assert!(states.len() >= 20, "{} states", states.len());
    let of = |state: &super::common::State| {
        let exact = (frequency() * state.time()).cos();
        (state.total("momentum")[0] / state.mass() / (2.0 / PI * SPEED) - exact).abs()
    };
    states.iter().map(of).fold(0.0, |most, e| if e.is_nan() { f64::INFINITY } else { most.max(e) })
}

#[test]
fn velocity_of_the_centre_converges_with_second_order() {
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Triangle, 3), (Cell::Hexahedron, 8)] {
        let errors = [8, 16, 32].map(|cells| error(&bar(cell, points, cells, 800, "newmark")));
        assert!(errors[2] < 3e-3, "{cell:?}: errors {errors:?}");
        assert!(orders(&errors).iter().all(|order| *order > 1.8), "{cell:?}: errors {errors:?}");
    }
}

/// On a fine grid the time scheme decides: both are of second order.
#[test]
fn both_schemes_are_of_second_order_in_time() {
    for scheme in ["newmark", "bossak"] {
        let errors = [20, 40, 80].map(|steps| error(&bar(Cell::Quadrilateral, 4, 64, steps, scheme)));
        assert!(orders(&errors).iter().all(|order| *order > 1.8), "{scheme}: errors {errors:?}");
    }
}
