//! Deformation and stress at the start: a bar that is let go stretched, and a column whose stress holds its weight.
//!
//! The bar of [`super::vibrating_bar`] is at rest with the strain Aβ cos(βx) of its first mode, β = π/2L: its centre
//! of mass then moves with −(2/π) A ω sin(ω t), ω = β √(E/ρ) (d'Alembert, Bernoulli).

use super::common::{Cell, Mesh, Record, Scene, State, fix, gravity, material, orders, process};
use serde_json::{Value, json};
use std::f64::consts::PI;

const LENGTH: f64 = 25.0;
const YOUNG: f64 = 100.0;
const DENSITY: f64 = 1.0;
const BETA: f64 = PI / (2.0 * LENGTH);
const STRAIN: f64 = 1e-4;
/// Steps in a period.
const STEPS: f64 = 800.0;
const NEO_HOOKEAN: &str = "HyperElasticNeoHookeanPlaneStrain2DLaw";
const LINEAR: &str = "LinearElasticIsotropicPlaneStrain2DLaw";
const PROCESS: &str = "assign_initial_deformation_to_material_point_process";

fn omega() -> f64 {
    BETA * (YOUNG / DENSITY).sqrt()
}

fn newmark() -> Value {
    json!({"scheme_type": "newmark", "residual_relative_tolerance": 1e-9, "point_velocity_rule": "scheme"})
}

fn explicit(update: &str) -> Value {
    json!({"time_integration_method": "explicit", "scheme_type": "forward_euler", "stress_update": update})
}

/// One period of the bar on `cells` cells.
fn bar(law: &str, cells: usize, solver: &Value, initial: Value) -> Record {
    let size = LENGTH / cells as f64;
    let mesh = Mesh::block(Cell::Quadrilateral, [cells, 1, 0], [0.0; 3], [LENGTH, size, 0.0]);
    let period = 2.0 * PI / omega();
    let dt = period / STEPS;
    let mut settings = json!({"solver_type": "dynamic", "time_stepping": {"time_step": dt}});
    settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
    let mut parameters = json!({"model_part_name": "MPM_Material"});
    parameters.as_object_mut().unwrap().extend(initial.as_object().unwrap().clone());
    let first = format!("{:?} * sin({BETA:?} * x)", -omega().powi(2) * STRAIN / BETA);
    let acceleration =
        json!({"model_part_name": "MPM_Material", "variable_name": "MP_ACCELERATION", "value": [first, 0, 0]});
    Scene::new(mesh.clone(), mesh, material(law, 4, DENSITY, YOUNG, 0.0), settings, period - 0.5 * dt)
        .part("Wall", |x| x[0] == 0.0)
        .part("All", |_| true)
        .with(fix("Wall", json!([0.0, null, null])))
        .with(fix("All", json!([null, 0.0, null])))
        .with(process(PROCESS, parameters))
        // Implicit schemes start from the acceleration; it is none unless it is given.
        .with(process("assign_initial_field_to_material_point_process", acceleration))
        .run(&["--record-states", "40"])
}

/// Largest error of the centre's velocity over a period, relative to its amplitude.
fn error(record: &Record) -> f64 {
    let amplitude = 2.0 / PI * (STRAIN / BETA) * omega();
    let of = |state: &State| {
        let exact = -(omega() * state.time()).sin();
        (state.total("momentum")[0] / state.mass() / amplitude - exact).abs()
    };
    record.states().iter().map(of).fold(0.0, |most, e| if e.is_nan() { f64::INFINITY } else { most.max(e) })
}

#[test]
fn a_stretched_bar_swings_in_its_first_mode() {
    let stretch = json!({"deformation_gradient":
        [format!("1 + {STRAIN:?} * cos({BETA:?} * x)"), 0, 0, 0, 1, 0, 0, 0, 1]});
    let stress = json!({"cauchy_stress": [format!("{:?} * cos({BETA:?} * x)", YOUNG * STRAIN), 0, 0]});
    for (told, law, solver, initial) in [
        ("F, implicit", NEO_HOOKEAN, newmark(), &stretch),
        ("stress, implicit", NEO_HOOKEAN, newmark(), &stress),
        ("F, explicit", NEO_HOOKEAN, explicit("usf"), &stretch),
        ("stress, updated last", NEO_HOOKEAN, explicit("musl"), &stress),
        ("stress, hypoelastic", LINEAR, explicit("usl"), &stress),
        ("stress, implicit, linear", LINEAR, newmark(), &stress),
    ] {
        let errors = [8, 16, 32].map(|cells| error(&bar(law, cells, &solver, initial.clone())));
        assert!(errors[2] < 3e-3, "{told}: errors {errors:?}");
        assert!(orders(&errors).iter().all(|order| *order > 1.8), "{told}: errors {errors:?}");
    }
}

/// The mesh is the deformed body: its volume is that of the points, its mass that of the material that was
/// there before it was compressed to F = 0.8.
#[test]
fn mass_is_that_of_the_undeformed_material() {
    let initial = json!({"deformation_gradient": [0.8, 0, 0, 0, 1, 0, 0, 0, 1]});
    let record = bar(NEO_HOOKEAN, 8, &explicit("usf"), initial);
    let size = LENGTH / 8.0;
    assert!((record.first().mass() - DENSITY * LENGTH * size / 0.8).abs() < 1e-9, "{}", record.first().mass());
}

/// Vertical stress ρ g (y − h) holds the column up; the stress across it is any. Without it the top would sink by
/// ρ g h²/(2 M). The weight that is held is that of the present density, which differs by the strain.
#[test]
fn a_column_in_equilibrium_stays_where_it_is() {
    let (height, weight, young) = (10.0, 2000.0 * 9.81, 1e9);
    let side = height / 10.0;
    for (law, solver, bound) in [
        (NEO_HOOKEAN, newmark(), 1e-3),
        (NEO_HOOKEAN, explicit("musl"), 1e-3),
        // The linear law of explicit runs keeps its strain apart, so that the density is the present one.
        (LINEAR, explicit("usf"), 1e-9),
    ] {
        let body = Mesh::block(Cell::Quadrilateral, [2, 10, 0], [0.0; 3], [2.0 * side, height, 0.0]);
        let grid = Mesh::block(Cell::Quadrilateral, [2, 12, 0], [0.0; 3], [2.0 * side, height + 2.0 * side, 0.0]);
        let mut settings = json!({"solver_type": "dynamic", "time_stepping": {"time_step": 2e-4}});
        settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
        let vertical = format!("{weight:?} * (y - {height:?})");
        let stress = json!({"model_part_name": "MPM_Material",
                            "cauchy_stress": [format!("0.6 * {vertical}"), vertical, 0]});
        let record = Scene::new(grid, body, material(law, 4, 2000.0, young, 0.25), settings, 0.0999)
            .part("Floor", |x| x[1] == 0.0)
            .part("Sides", |x| x[0] == 0.0 || x[0] == 2.0)
            .with(fix("Floor", json!([null, 0.0, null])))
            .with(fix("Sides", json!([0.0, null, null])))
            .with(process(PROCESS, stress))
            // After the stress, which keeps gravity from being the acceleration at the start.
            .with(gravity([0.0, -9.81, 0.0]))
            .run(&["--record-states", "20"]);
        let modulus = young * 0.75 / (1.25 * 0.5);
        let settlement = weight * height * height / (2.0 * modulus);
        let moved = |state: &State| {
            let values = state.points("MP_DISPLACEMENT").into_iter().flatten();
            values.fold(0.0, |most: f64, u| most.max(u.abs()))
        };
        let most = record.states().iter().map(moved).fold(0.0, f64::max);
        assert!(most < bound * settlement, "{law} {solver}: {most:e} m of {settlement:e} m");
    }
}

/// Half of a rubber's stretches is far from linear: the stress is that which was asked for.
#[test]
fn large_stresses_are_found() {
    let record = bar(NEO_HOOKEAN, 8, &newmark(), json!({"cauchy_stress": [-60.0, 35.0, 20.0]}));
    let first = record.first().points("MP_CAUCHY_STRESS_VECTOR");
    for stress in first {
        for (found, wanted) in stress.iter().zip([-60.0, 35.0, 20.0]) {
            assert!((found - wanted).abs() < 1e-9, "{stress:?}");
        }
    }
}
