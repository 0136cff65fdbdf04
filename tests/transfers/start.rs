//! Velocities with an affine part (APIC, TPIC) from the first step on.

use super::common::Record;
use super::{Frame, Functions, HATS, SPLINE, explicit, turning_block};
use serde_json::json;

/// A block that turns and swings through one tiny step: its points keep their velocities.
fn one_step(frame: Frame, functions: Functions, transfer: &str) -> Record {
    let solver = explicit(frame, functions, 1e-9, &json!({"transfer": transfer, "stress_update": "usl"}));
    let mut scene = turning_block(frame, functions, solver, 0.5e-9);
    scene.processes[0] = super::initial_velocity("MPM_Material", ["1 - 10*y + 2*x", "10*x - y", "0"]);
    scene.run(&["--record-states", "1"])
}

/// A linear velocity returns from the grid as it was, where points carry its gradient there. Without one at the start,
/// a body that turns would turn slower from the first step on: it keeps its angular momentum, and the affine parts have
/// some of the inertia.
#[test]
fn a_linear_velocity_is_kept_from_the_first_step_on() {
    for (frame, functions) in
        [(Frame::Updated, HATS), (Frame::Updated, SPLINE), (Frame::Total, HATS), (Frame::Total, SPLINE)]
    {
        for transfer in ["apic", "tpic"] {
            let record = one_step(frame, functions, transfer);
            for (x, v) in record.last().points("MP_COORD").iter().zip(record.last().points("MP_VELOCITY")) {
                let exact = [1.0 - 10.0 * x[1] + 2.0 * x[0], 10.0 * x[0] - x[1]];
                let off = (v[0] - exact[0]).abs().max((v[1] - exact[1]).abs());
                assert!(off < 1e-6, "{frame:?} {functions:?} {transfer}: {v:?} for {exact:?} at {x:?}");
            }
        }
    }
}

/// The kinetic energy of points with an affine part is that of the grid's nodes with the same linear velocity,
/// ½ Σ m_i |v_i|²: with four Gauss points in each cell, each gives its corners a quarter of its mass.
#[test]
fn energy_of_the_affine_part_is_that_of_the_nodes() {
    let mut exact = 0.0;
    for cell in 0..16 {
        for corner in 0..4 {
            let at = |a: usize| -0.5 + 0.25 * (a as f64);
            let (x, y) = (at(cell % 4 + corner % 2), at(cell / 4 + corner / 2));
            let v = [1.0 - 10.0 * y + 2.0 * x, 10.0 * x - y];
            exact += 0.5 * 1000.0 * 0.25 * 0.25 / 4.0 * (v[0] * v[0] + v[1] * v[1]);
        }
    }
    for frame in [Frame::Updated, Frame::Total] {
        for transfer in ["apic", "tpic"] {
            let record = one_step(frame, HATS, transfer);
            for state in record.states() {
                let found = state.energy("kinetic");
                assert!((found / exact - 1.0).abs() < 1e-6, "{frame:?} {transfer}: {found} for {exact}");
            }
        }
    }
}
