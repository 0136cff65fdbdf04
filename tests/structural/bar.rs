//! Axial vibration of a bar that is fixed at one end, in its first mode: v(x, 0) = v0 sin(βx),
//! β = π/2L, gives v = v0 sin(βx) cos(ωt), ω = β √(E/ρ).
//!
//! L = 25 m, E = 100 Pa, ρ = 1 kg/m³, ν = 0 after Bardenhagen and Kober, CMES 5 (2004) 477-495; the
//! speed is small, so that the strain hardly changes the stiffness.
//!
//! On even cells the nodal values of the mode are an eigenvector of the mesh, so that frequency and
//! motion of each scheme are known in closed form (Hughes, The Finite Element Method, §7.3.2, §9.1).

use super::body::{Body, fix, material};
use super::common::{Cell, Mesh, Record, orders, process};
use serde_json::{Value, json};
use std::f64::consts::PI;

const LENGTH: f64 = 25.0;
const YOUNG: f64 = 100.0;
const DENSITY: f64 = 1.0;
const PERIOD: f64 = 10.0;

fn wave_number() -> f64 {
    PI / (2.0 * LENGTH)
}

fn bar(cell: Cell, cells: usize, speed: f64, solver: Value, end: f64, states: &str) -> Record {
    let size = LENGTH / cells as f64;
    let mesh = Mesh::block(cell, [cells, 1, 1], [0.0; 3], [LENGTH, size, size]);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    let start = json!({"model_part_name": "Structure.All", "variable_name": "VELOCITY", "interval": [0.0, 0.0],
                       "constrained": false, "value": [format!("{speed:?} * sin(pi * X / {:?})", 2.0 * LENGTH), 0.0, 0.0]});
    let mut settings = json!({"solver_type": "structural_dynamic", "residual_relative_tolerance": 1e-8});
    settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
    Body::new(mesh, material(law, DENSITY, YOUNG, 0.0), settings, end)
        .part("Wall", |x| x[0] == 0.0)
        .part("All", |_| true)
        .with(fix("Wall", json!([0.0, null, null])))
        .with(fix("All", json!([null, 0.0, 0.0])))
        .with(process("assign_vector_variable_process", start))
        .run(&["--record-states", states])
}

const SLOW: f64 = 1e-6;

fn newmark(dt: f64, consistent: bool) -> Value {
    json!({"scheme_type": "newmark", "consistent_mass_matrix": consistent, "time_stepping": {"time_step": dt}})
}

fn explicit(dt: f64) -> Value {
    json!({"time_integration_method": "explicit", "time_stepping": {"time_step": dt}})
}

/// Frequency of the first mode on the mesh.
fn frequency(cells: usize, consistent: bool) -> f64 {
    let (size, speed) = (LENGTH / cells as f64, (YOUNG / DENSITY).sqrt());
    let phase = wave_number() * size;
    match consistent {
        true => speed / size * (6.0 * (1.0 - phase.cos()) / (2.0 + phase.cos())).sqrt(),
        false => 2.0 * speed / size * (0.5 * phase).sin(),
    }
}

/// Largest difference between the speed of the free end and v0 cos(ωt) over the states, relative.
fn error(record: &Record, frequency: f64) -> f64 {
    let states = record.states();
    assert!(states.len() >= 20, "{} states", states.len());
    let of = |state: &super::common::State| {
        let tip =
            state.nodes("VELOCITY").iter().fold(0.0, |most: f64, v| if v[0].abs() > most.abs() { v[0] } else { most });
        (tip / SLOW - (frequency * state.time()).cos()).abs()
    };
    states.iter().map(of).fold(0.0, |most, e| if e.is_nan() { f64::INFINITY } else { most.max(e) })
}

/// Trapezoidal rule: tan(ω̃ dt/2) = ω dt/2. Central differences: sin(ω̃ dt/2) = ω dt/2.
#[test]
fn both_schemes_move_as_their_theory_says() {
    let (cells, dt) = (8, 0.25);
    for cell in [Cell::Line, Cell::Quadrilateral, Cell::Hexahedron] {
        for consistent in [true, false] {
            let record = bar(cell, cells, SLOW, newmark(dt, consistent), PERIOD, "40");
            let numerical = 2.0 / dt * (0.5 * dt * frequency(cells, consistent)).atan();
            let error = error(&record, numerical);
            assert!(error < 1e-6, "{cell:?}, Newmark, consistent {consistent}: {error:e}");
        }
        let record = bar(cell, cells, SLOW, explicit(dt), PERIOD, "40");
        let numerical = 2.0 / dt * (0.5 * dt * frequency(cells, false)).asin();
        let error = error(&record, numerical);
        assert!(error < 1e-6, "{cell:?}, central differences: {error:e}");
    }
}

#[test]
fn second_order_in_space_and_in_time() {
    let exact = wave_number() * (YOUNG / DENSITY).sqrt();
    for cell in [Cell::Triangle, Cell::Quadrilateral, Cell::Hexahedron] {
        for solver in [newmark(PERIOD / 800.0, true), explicit(PERIOD / 800.0)] {
            let errors = [8, 16, 32].map(|cells| error(&bar(cell, cells, SLOW, solver.clone(), PERIOD, "40"), exact));
            assert!(errors[2] < 3e-3, "{cell:?}, {solver}: {errors:?}");
            assert!(orders(&errors).iter().all(|order| *order > 1.8), "{cell:?}, {solver}: {errors:?}");
        }
    }
    let bossak = |dt: f64| json!({"scheme_type": "bossak", "damp_factor_m": -0.3, "time_stepping": {"time_step": dt}});
    for (scheme, consistent) in
        [(&bossak as &dyn Fn(f64) -> Value, true), (&|dt| newmark(dt, true), true), (&explicit, false)]
    {
        let errors = [40.0, 80.0, 160.0].map(|steps| {
            let record = bar(Cell::Line, 8, SLOW, scheme(PERIOD / steps), PERIOD, "40");
            error(&record, frequency(8, consistent))
        });
        assert!(orders(&errors).iter().all(|order| *order > 1.8), "{}: {errors:?}", scheme(1.0));
    }
}

/// At a tenth of the wave speed the bar is far from linear; central differences keep its energy over
/// twenty periods but for an oscillation of second order.
#[test]
fn central_differences_keep_the_energy_of_large_vibrations() {
    let drifts = [0.08, 0.04].map(|dt| {
        let record = bar(Cell::Quadrilateral, 16, 1.0, explicit(dt), 20.0 * PERIOD, "200");
        let total = |state: &super::common::State| state.energy("total");
        let first = total(&record.first());
        assert!((first / (0.25 * DENSITY * LENGTH * LENGTH / 16.0) - 1.0).abs() < 1e-2, "{first} J at the start");
        record.states().iter().map(|state| (total(state) / first - 1.0).abs()).fold(0.0, f64::max)
    });
    assert!(drifts[0] < 3e-3 && orders(&drifts)[0] > 1.8, "{drifts:?}");
}

/// A free block that spins, stretches and flies: nothing acts on it.
#[test]
fn momentum_and_angular_momentum_are_kept() {
    let mesh = Mesh::block(Cell::Quadrilateral, [4, 4, 1], [0.0; 3], [1.0, 1.0, 0.0]);
    let share = |x: f64| if x == 0.0 || x == 1.0 { 0.5 } else { 1.0 };
    let masses: Vec<f64> = mesh.nodes.iter().map(|x| share(x[0]) * share(x[1]) * 1000.0 / 16.0).collect();
    let start = json!({"model_part_name": "Structure.All", "variable_name": "VELOCITY", "interval": [0.0, 0.0],
                       "constrained": false, "value": ["3.0 - 2.0*(Y - 0.5) + 1.5*(X - 0.5)", "2.0*(X - 0.5) - X*Y", 0.0]});
    for solver in [
        json!({"time_integration_method": "explicit", "time_stepping": {"time_step": "auto"}}),
        json!({"scheme_type": "newmark", "consistent_mass_matrix": false, "time_stepping": {"time_step": 0.01}}),
    ] {
        let is_explicit = solver.get("time_integration_method").is_some();
        let mut settings = json!({"solver_type": "structural_dynamic", "residual_relative_tolerance": 1e-10});
        settings.as_object_mut().unwrap().extend(solver.as_object().unwrap().clone());
        let stuff = material("HyperElasticNeoHookeanPlaneStrain2DLaw", 1000.0, 1e5, 0.3);
        let record = Body::new(mesh.clone(), stuff, settings, 1.0)
            .part("All", |_| true)
            .with(process("assign_vector_variable_process", start.clone()))
            .run(&["--record-states", "10"]);
        let sums = |state: &super::common::State| {
            let (u, v) = (state.nodes("DISPLACEMENT"), state.nodes("VELOCITY"));
            let mut sums = [0.0; 3];
            for (i, x) in mesh.nodes.iter().enumerate() {
                let (x, y) = (x[0] + u[i][0], x[1] + u[i][1]);
                let p = [masses[i] * v[i][0], masses[i] * v[i][1]];
                (sums[0], sums[1], sums[2]) = (sums[0] + p[0], sums[1] + p[1], sums[2] + x * p[1] - y * p[0]);
            }
            sums
        };
        let first = sums(&record.first());
        let told = record.first().total("momentum");
        assert!((told[0] / first[0] - 1.0).abs() < 1e-12 && (record.first().mass() / 1000.0 - 1.0).abs() < 1e-12);
        for state in &record.states()[1..] {
            let now = sums(state);
            let changes: [f64; 3] = std::array::from_fn(|a| (now[a] - first[a]).abs() / first[0].abs());
            // Newton's method stops before round-off, and the trapezoidal rule keeps linear momentum alone.
            let bounds = if is_explicit { [1e-12; 3] } else { [1e-9, 1e-9, f64::INFINITY] };
            assert!(changes.iter().zip(bounds).all(|(c, bound)| *c < bound), "{solver}: {changes:?}");
        }
    }
}
