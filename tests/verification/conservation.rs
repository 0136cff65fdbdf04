//! Linear momentum and energy.

use super::common::{Cell, Mesh, Record, Scene, material, process};
use serde_json::{Value, json};

fn dynamic(scheme: &str, step: f64) -> Value {
    json!({"solver_type": "dynamic", "scheme_type": scheme, "time_stepping": {"time_step": step}})
}

fn velocity(functions: [String; 3]) -> Value {
    let parameters = json!({"model_part_name": "MPM_Material", "value": functions});
    process("assign_initial_field_to_material_point_process", parameters)
}

/// A body that flies, turns and deforms freely across the cells of a grid.
fn flying(cell: Cell, points: usize, scheme: &str) -> Record {
    let grid = Mesh::block(cell, [8, 8, 8], [0.0; 3], [4.0; 3]);
    let body = Mesh::block(cell, [4, 3, 3], [1.0, 1.2, 1.1], [2.6, 2.3, 2.2]);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    Scene::new(grid, body, material(law, points, 1000.0, 1e6, 0.3), dynamic(scheme, 0.01), 0.2 - 1e-6)
        .with(velocity(["2 + 2*sin(3*x)*y".into(), "1 + 2*cos(2*y + x)".into(), "-0.5 + 2*x*z".into()]))
        .run(&["--record-states", "20"])
}

/// Internal forces of a cell sum to zero, so no scheme may change the momentum of a free body.
#[test]
fn a_free_body_keeps_its_momentum() {
    for (cell, points) in [(Cell::Quadrilateral, 4), (Cell::Triangle, 6), (Cell::Hexahedron, 8), (Cell::Tetrahedron, 4)]
    {
        for scheme in ["newmark", "bossak"] {
            let record = flying(cell, points, scheme);
            let start = record.first().total("momentum");
            let size = start.iter().map(|p| p * p).sum::<f64>().sqrt();
            for state in record.states() {
                let now = state.total("momentum");
                let drift = (0..3).map(|a| (now[a] - start[a]).abs()).sum::<f64>() / size;
                assert!(drift < 1e-12, "{cell:?}, {scheme}: momentum drifts by {drift:e} at t = {}", state.time());
            }
            let strain = record.last().energy("strain");
            assert!(strain > 0.0, "{cell:?}: the body must deform for the test to mean anything");
        }
    }
}

/// Kinetic and strain energy, relative to the start, of a free block that swings in its cells: all
/// its points stay in them, so that nothing but the time scheme and the transfer acts. The
/// recorded strain energy ½ V σ:ε is exact to the strain, about 1e-5.
fn swinging(scheme: &str, cells: usize, step: f64, rule: &str) -> Vec<f64> {
    let mesh = Mesh::block(Cell::Quadrilateral, [cells, cells, 1], [0.0; 3], [1.0; 3]);
    let material = material("LinearElasticIsotropicPlaneStrain2DLaw", 4, 1000.0, 1e6, 0.3);
    // c = 37 m/s: the slowest mode takes about 0.06 s.
    let mut solver = dynamic(scheme, step);
    solver["residual_relative_tolerance"] = json!(1e-8);
    solver["point_velocity_rule"] = json!(rule);
    let record = Scene::new(mesh.clone(), mesh, material, solver, 0.2 - 0.5 * step)
        .with(velocity(["5e-4*cos(pi*x)".into(), "-5e-4*cos(pi*y)".into(), "0".into()]))
        .run(&["--record-states", "40"]);
    let total = |state: &super::common::State| state.energy("kinetic") + state.energy("strain");
    let start = total(&record.first());
    record.states().iter().map(|state| total(state) / start).collect()
}
/// Newmark's rule with β = 1/4, γ = 1/2 conserves the energy of a linear system; what is lost is lost
/// in the transfer from points to grid and back, and goes with the time step and the square of the
/// cell size.
#[test]
fn newmark_loses_energy_to_the_transfer_alone() {
    let coarse = swinging("newmark", 8, 1e-3, "trapezoidal");
    let fine = swinging("newmark", 16, 1e-3, "trapezoidal");
    let short = swinging("newmark", 16, 5e-4, "trapezoidal");
    let lost = |energies: &[f64]| 1.0 - energies.last().unwrap();
    for energies in [&coarse, &fine, &short] {
        assert!(energies.is_sorted_by(|a, b| *b < a + 1e-6), "the energy grows: {energies:?}");
    }
    let losses = [lost(&coarse), lost(&fine), lost(&short)];
    assert!(losses[2] < 8e-3, "losses {losses:?} in three periods");
    assert!(losses[0] / losses[1] > 3.2, "the loss must go with the square of the cell: {losses:?}");
    assert!(losses[1] / losses[2] > 1.6, "the loss must go with the step: {losses:?}");
}

/// Bossak's rule with α = −0.3 dissipates (Wood, Bossak and Zienkiewicz 1980) if the points follow
/// its own γ = 1/2 − α. Kratos's convention, γ = 1/2 for the points, is the default: slow modes then
/// gain energy at the rate −α ω² dt.
#[test]
fn bossak_dissipates_with_its_own_velocity_rule() {
    let newmark = swinging("newmark", 16, 2e-3, "scheme");
    let bossak = swinging("bossak", 16, 2e-3, "scheme");
    let convention = swinging("bossak", 16, 2e-3, "trapezoidal");
    assert!(bossak.iter().all(|energy| *energy < 1.0 + 1e-12), "Bossak gains energy: {bossak:?}");
    assert!(bossak.last() < newmark.last(), "{:?}, Newmark {:?}", bossak.last(), newmark.last());
    assert!(convention.last() > Some(&1.05), "Kratos's convention gains energy: {convention:?}");
}
