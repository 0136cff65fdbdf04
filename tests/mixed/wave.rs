//! A standing shear wave of finite amplitude in an incompressible neo-Hookean solid, an exact solution:
//! u = A sin(kY) sin(ωt) along x with ω = k √(μ/ρ), of constant volume, needs no force where p = μ γ²/3,
//! γ = A k cos(kY) sin(ωt). The grid is not reset, so that points stay where they integrate best.
//! Bossak's scheme, as Newmark's leaves pressures that alternate from step to step.

use super::common::{Cell, Mesh, Scene, fix, material, orders, process};
use serde_json::json;
use std::f64::consts::FRAC_PI_2;

const AMPLITUDE: f64 = 0.3;
/// Shear modulus over density is 1, and k = ω = π/2: clamped at y = 0, free at y = 1.
const MODULUS: f64 = 1.0;
const END: f64 = 0.5;

/// Root mean squares of the errors of displacement and pressure on the nodes, over the largest values.
fn errors(cell: Cell, stabilization: &str, count: usize) -> [f64; 2] {
    let mesh = Mesh::block(cell, [count, count, 1], [0.0; 3], [1.0; 3]);
    let points = if cell == Cell::Triangle { 3 } else { 4 };
    let step = END / (2 * count) as f64;
    let motion = format!("{AMPLITUDE}*sin({FRAC_PI_2}*Y)*(sin({FRAC_PI_2}*t)-sin({FRAC_PI_2}*(t-{step:?})))");
    let swing = format!("{AMPLITUDE}*{FRAC_PI_2}*sin({FRAC_PI_2}*y)");
    let velocity = json!({"model_part_name": "MPM_Material", "value": [swing, 0.0, 0.0]});
    let solver = json!({"pressure_dofs": true, "stabilization": stabilization, "grid_reset": "never",
        "solver_type": "dynamic", "scheme_type": "bossak", "time_stepping": {"time_step": step},
        "residual_relative_tolerance": 1e-8, "consistent_mass_matrix": true});
    let law = "HyperElasticNeoHookeanPlaneStrainUP2DLaw";
    let material = material(law, points, 1.0, 3.0 * MODULUS, 0.5);
    let scene = Scene::new(mesh.clone(), mesh, material, solver, END - 0.5 * step)
        .part("Floor", |x| x[1] == 0.0)
        .part("Sides", |x| x[0] == 0.0 || x[0] == 1.0)
        .with(process("assign_initial_field_to_material_point_process", velocity))
        .with(fix("Sides", json!([motion, 0.0, null])))
        .with(fix("Floor", json!([0.0, 0.0, null])));
    let record = scene.run(&["--record-states", "1"]);
    let last = record.last();
    let phase = (FRAC_PI_2 * last.time()).sin();
    let start = record.first().points("MP_COORD");
    let exact = |y: f64| AMPLITUDE * (FRAC_PI_2 * y).sin() * phase;
    let off =
        last.points("MP_DISPLACEMENT").iter().zip(&start).map(|(u, x)| (u[0] - exact(x[1])).hypot(u[1])).collect();
    let strain = |y: f64| AMPLITUDE * FRAC_PI_2 * (FRAC_PI_2 * y).cos() * phase;
    let pressures = last.scalars("MP_PRESSURE");
    let off_pressure = pressures.iter().zip(&start).map(|(p, x)| p - MODULUS * strain(x[1]).powi(2) / 3.0).collect();
    let root = |list: Vec<f64>| (list.iter().map(|e| e * e).sum::<f64>() / list.len() as f64).sqrt();
    [root(off) / exact(1.0), root(off_pressure) / (MODULUS * strain(0.0).powi(2) / 3.0)]
}

#[test]
fn a_shear_wave_converges_at_second_order() {
    for cell in [Cell::Triangle, Cell::Quadrilateral] {
        for stabilization in ["ppp", "asgs", "osgs"] {
            let all = [8, 16, 32].map(|count| errors(cell, stabilization, count));
            let [of_motion, of_pressure] = [0, 1].map(|kind| orders(&all.map(|errors| errors[kind])));
            let told = format!("{cell:?} {stabilization}: {all:?}, orders {of_motion:?}, {of_pressure:?}");
            assert!(of_motion[1] > 1.8 && of_pressure[1] > 1.0, "{told}");
        }
    }
}
