//! Problem C and bodies in free motion: what the energy-conserving rule keeps.

use super::bar::{Bar, CUBIC, Functions, HATS, NEO_HOOKEAN, QUADRATIC, SPLINE, energy_drift};
use super::common::{Cell, Mesh, Record, Scene, material, process};
use serde_json::json;

/// A bar of 0.1 m that starts with 1 m/s all over, held at one end: strains of some 5 % and shocks.
fn problem_c(functions: Functions, courant: f64, solver: serde_json::Value) -> Record {
    Bar {
        cells: 32,
        length: 0.1,
        area: 1e-4,
        density: 10.0,
        young: 5e3,
        poisson: 0.3,
        law: NEO_HOOKEAN,
        functions,
        placement: "even",
        solver,
        processes: Vec::new(),
        end_time: 0.05,
    }
    .flung("1")
    .at_courant(courant)
    .run(100_000)
}

fn conserving() -> serde_json::Value {
    // The scheme's own tolerances instead of the bar's.
    json!({"scheme_type": "energy_conserving", "residual_relative_tolerance": 1e-11})
}

#[test]
fn problem_c_keeps_its_energy() {
    for functions in [HATS, Functions { points: 3, ..QUADRATIC }, SPLINE, CUBIC] {
        for courant in [0.2, 1.0, 5.0] {
            let record = problem_c(functions, courant, conserving());
            let start = record.first().energy("kinetic");
            assert!((start / 5e-5 - 1.0).abs() < 1e-12, "{start}");
            let drift = energy_drift(&record);
            assert!(drift < 1e-10, "{functions:?}, Courant {courant}: {drift:e}");
            let strain = record.states().iter().map(|s| s.energy("strain")).fold(0.0, f64::max);
            assert!(strain > 0.9 * start, "{functions:?}: the energy must change its form: {strain:e}");
        }
    }
}

/// What the rule is for: the trapezoidal one on the same nonlinear bar does not keep the energy.
#[test]
fn the_trapezoidal_rule_does_not() {
    let solver = json!({"scheme_type": "newmark", "consistent_mass_matrix": true});
    let drift = energy_drift(&problem_c(QUADRATIC, 1.0, solver));
    assert!(drift > 1e-4, "{drift:e}");
}

fn cross(a: &[f64], b: &[f64]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Σ m v and Σ m x × v.
fn momenta(state: &super::common::State) -> [[f64; 3]; 2] {
    let (x, v, m) = (state.points("MP_COORD"), state.points("MP_VELOCITY"), state.scalars("MP_MASS"));
    let mut sums = [[0.0; 3]; 2];
    for ((x, v), m) in x.iter().zip(&v).zip(m) {
        let moment = cross(x, v);
        for a in 0..3 {
            sums[0][a] += m * v[a];
            sums[1][a] += m * moment[a];
        }
    }
    sums
}

/// A block that turns by many degrees a step and swings: energy and both momenta stay.
#[test]
fn a_turning_block_keeps_energy_and_momenta() {
    let bases = [("mesh", 1, 8), ("lagrange", 2, 27), ("b_spline", 2, 27)];
    for (cell, law) in [
        (Cell::Quadrilateral, "HyperElasticNeoHookeanPlaneStrain2DLaw"),
        (Cell::Hexahedron, "HyperElasticNeoHookean3DLaw"),
    ] {
        for (basis, order, points) in bases {
            let points = if cell == Cell::Quadrilateral { if points == 8 { 4 } else { 9 } } else { points };
            let block = Mesh::block(cell, [2, 2, 2], [-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]);
            let solver = json!({"solver_type": "dynamic", "scheme_type": "energy_conserving",
                "frame": "total_lagrangian", "basis": basis, "basis_order": order, "max_iteration": 40,
                "residual_relative_tolerance": 1e-13, "time_stepping": {"time_step": 0.01}});
            let velocity = json!({"model_part_name": "MPM_Material",
                "value": ["1 - 20*y + 2*x", "20*x - 3*y + 2*z", "4*x - 2*z"]});
            let record = Scene::new(block.clone(), block, material(law, points, 1000.0, 1e6, 0.3), solver, 0.195)
                .with(process("assign_initial_field_to_material_point_process", velocity))
                .run(&["--record-states", "20"]);
            let drift = energy_drift(&record);
            assert!(drift < 1e-10, "{cell:?} {basis}: energy drifts by {drift:e}");
            let start = momenta(&record.first());
            for state in record.states() {
                for (now, start) in momenta(&state).iter().zip(&start) {
                    let size = start.iter().map(|p| p * p).sum::<f64>().sqrt();
                    let change = (0..3).map(|a| (now[a] - start[a]).abs()).fold(0.0, f64::max) / size;
                    assert!(change < 1e-10, "{cell:?} {basis}: a momentum changes by {change:e} at {}", state.time());
                }
            }
            assert!(record.last().energy("strain") > 1.0, "the block must swing");
        }
    }
}
