//! A plate of 4 m by 3 m on a roller, hit at 5 m/s over the lowest metre of its left side: plane strain,
//! steel. A plane wave of −ρ c_p v = −229.13 MPa runs ahead, release waves follow from the edge.
//!
//! Source: Renaud and Heuzé (2017), §5.2. Reference: finite volumes of order 2 with 1600 × 1200 cells,
//! as means of the bottom row of 32 cells; an independent finite-element code with these elements at
//! Courant 0.9 has errors of 9.0, 11.0 and 9.8 % in the L1 norm, this one 7.8, 7.1 and 7.9 %.

use super::body::{Body, assign, fix, material};
use super::common::{Cell, Mesh};
use serde_json::json;

/// σ_xx in MPa at 0.2, 0.4 and 0.55 ms; cells ahead of the wave are left out.
const REFERENCE: [(f64, &[f64]); 3] = [
    (0.2e-3, &[-219.786, -219.258, -218.178, -217.243, -220.544, -229.095, -229.129, -229.129, -229.129, -91.723]),
    (
        0.4e-3,
        &[
            -214.229, -217.297, -222.482, -228.444, -234.484, -242.327, -253.215, -241.907, -226.913, -211.067,
            -195.840, -182.337, -171.177, -163.087, -159.078, -161.747, -182.828, -228.751, -183.303,
        ],
    ),
    (
        0.55e-3,
        &[
            -236.013, -239.243, -244.461, -249.795, -253.689, -255.220, -254.371, -251.536, -247.475, -243.343,
            -241.643, -247.526, -228.565, -208.367, -190.415, -174.856, -161.522, -150.399, -141.360, -134.501,
            -130.007, -128.538, -131.721, -144.837, -199.970, -192.505,
        ],
    ),
];

/// Relative L1 error of σ_xx along the bottom row.
fn error(cells: usize, time: f64, reference: &[f64]) -> f64 {
    let (wave_speed, size) = (5875.097, 4.0 / cells as f64);
    let steps = (time * wave_speed / (0.9 * size)).ceil();
    let dt = time / steps;
    let mesh = Mesh::block(Cell::Quadrilateral, [cells, cells * 3 / 4, 1], [0.0; 3], [4.0, 3.0, 0.0]);
    let solver = json!({"solver_type": "structural_dynamic", "time_integration_method": "explicit",
                        "time_stepping": {"time_step": dt}});
    let record =
        Body::new(mesh, material("LinearElasticIsotropicPlaneStrain2DLaw", 7800.0, 2e11, 0.3), solver, time - 0.5 * dt)
            .part("Hit", |x| x[0] == 0.0 && x[1] <= 1.0)
            .part("Floor", |x| x[1] == 0.0)
            .part("Right", |x| x[0] == 4.0)
            .with(assign("Hit", "VELOCITY", json!([5.0, null, null]), true))
            .with(fix("Floor", json!([null, 0.0, null])))
            .with(fix("Right", json!([0.0, null, null])))
            .run(&[]);
    let stress = record.last().field("elements", "CAUCHY_STRESS_VECTOR");
    let fine = cells / 32;
    let mean = |i: usize| (0..fine).map(|k| stress[i * fine + k][0]).sum::<f64>() / fine as f64 / 1e6;
    let exact = |i: usize| reference.get(i).copied().unwrap_or(0.0);
    let difference: f64 = (0..32).map(|i| (mean(i) - exact(i)).abs()).sum();
    difference / (0..32).map(|i| exact(i).abs()).sum::<f64>()
}

#[test]
fn stress_of_the_impact_agrees_with_finite_volumes() {
    for (time, reference) in REFERENCE {
        let coarse = error(32, time, reference);
        assert!(coarse < 0.09, "t = {time} s: {coarse}");
        let fine = error(64, time, reference);
        assert!(fine < 0.65 * coarse, "t = {time} s: {coarse}, then {fine} on cells half as wide");
    }
}
