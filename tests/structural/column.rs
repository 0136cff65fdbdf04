//! A column that its own weight and a traction on its top compress to 0.41 of its length, in
//! uniaxial strain: P(X) = τ + ρ b (L − X), u = ∫ (F − 1) dX with P(F) = μ (F − 1/F) + λ ln F / F.
//!
//! Source: Nuttall (2025), eq. 69. The integral is done here with Simpson's rule on an inverted P.

use super::body::{Body, assign, fix, load, material};
use super::common::{Cell, Mesh, Record, orders};
use serde_json::json;

const LENGTH: f64 = 0.1;
const AREA: f64 = 1e-4;
const YOUNG: f64 = 5e3;
const POISSON: f64 = 0.3;
const DENSITY: f64 = 10.0;
const GRAVITY: f64 = 9.81;
const TRACTION: f64 = -1e4;

/// The stretch at X.
fn stretch(x: f64) -> f64 {
    let (lambda, mu) = (YOUNG * POISSON / (1.0 + POISSON) / (1.0 - 2.0 * POISSON), 0.5 * YOUNG / (1.0 + POISSON));
    let target = TRACTION - DENSITY * GRAVITY * (LENGTH - x);
    let stress = |f: f64| mu * (f - 1.0 / f) + lambda * f.ln() / f;
    let (mut low, mut high) = (0.1, 1.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if stress(middle) < target { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Displacement at X.
fn exact(x: f64) -> f64 {
    let (count, mut sum) = (200, 0.0);
    for i in 0..=count {
        let weight = if i == 0 || i == count {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        };
        sum += weight * (stretch(x * i as f64 / count as f64) - 1.0);
    }
    sum * x / count as f64 / 3.0
}

fn column(cell: Cell, cells: usize, solver: serde_json::Value) -> Record {
    let size = LENGTH / cells as f64;
    let mesh = Mesh::block(cell, [cells, 1, 1], [0.0; 3], [LENGTH, size, size]);
    let law = cell.law("HyperElasticNeoHookeanPlaneStrain2DLaw", "HyperElasticNeoHookean3DLaw");
    let mut stuff = material(law, DENSITY, YOUNG, POISSON);
    stuff["Variables"]["CROSS_AREA"] = json!(AREA);
    let area = [AREA, size, size * size][cell.dimension() - 1];
    let top: Vec<usize> = mesh.find(|x| x[0] == LENGTH);
    let force = TRACTION * area / top.len() as f64;
    let name = ["PointLoadCondition1D1N", "PointLoadCondition2D1N", "PointLoadCondition3D1N"][cell.dimension() - 1];
    Body::new(mesh, stuff, solver, 1.0)
        .part("Bottom", |x| x[0] == 0.0)
        .part("All", |_| true)
        .with(fix("Bottom", json!([0.0, null, null])))
        .with(fix("All", json!([null, 0.0, 0.0])))
        .with(assign("All", "VOLUME_ACCELERATION", json!([-GRAVITY, 0.0, 0.0]), false))
        .conditions("Top", name, top.into_iter().map(|node| vec![node]).collect())
        .with(load("Top", "POINT_LOAD", json!([format!("{force:?} * t"), 0.0, 0.0])))
        .run(&[])
}

#[test]
fn the_formula_of_this_file_gives_the_published_values() {
    // Independent solution: displacement of the top and of X = L/10, and the stretch of the top.
    assert!((exact(LENGTH) + 0.05862504).abs() < 1e-8 && (exact(0.01) + 5.863488e-3).abs() < 1e-9);
    assert!((stretch(LENGTH) - 0.413859).abs() < 1e-6);
}

#[test]
fn displacements_converge_with_second_order() {
    let steps = json!({"time_stepping": {"time_step": 0.125}});
    for cell in [Cell::Line, Cell::Quadrilateral, Cell::Hexahedron] {
        let errors = [5, 10, 20].map(|cells| {
            let record = column(cell, cells, steps.clone());
            let last = record.last();
            let size = LENGTH / cells as f64;
            // Nodal values of one dimension are better than those between the nodes: take the norm
            // over the column of the interpolated field.
            let per_row = last.nodes("DISPLACEMENT");
            let node = |i: usize| per_row[i][0];
            let mut sum = 0.0;
            for i in 0..cells {
                for share in [0.25, 0.5, 0.75] {
                    let x = (i as f64 + share) * size;
                    sum += ((1.0 - share) * node(i) + share * node(i + 1) - exact(x)).powi(2);
                }
            }
            (sum / (3 * cells) as f64).sqrt()
        });
        assert!(errors[2] < 1e-3 * LENGTH, "{cell:?}: {errors:?}");
        assert!(orders(&errors).iter().all(|order| (1.9..2.1).contains(order)), "{cell:?}: {errors:?}");
    }
}

#[test]
fn stress_and_reaction_carry_load_and_weight() {
    let record = column(Cell::Line, 10, json!({"time_stepping": {"time_step": 0.125}}));
    let last = record.last();
    let held = last.nodes("REACTION")[0][0];
    let expected = -AREA * TRACTION + DENSITY * GRAVITY * LENGTH * AREA;
    assert!((held / expected - 1.0).abs() < 1e-11, "{held} N, not {expected} N");
    // In uniaxial strain the Cauchy stress is P: here that of the middle of each cell.
    for (i, stress) in last.field("elements", "CAUCHY_STRESS_VECTOR").iter().enumerate() {
        let expected = TRACTION - DENSITY * GRAVITY * (LENGTH - (i as f64 + 0.5) * LENGTH / 10.0);
        assert!((stress[0] / expected - 1.0).abs() < 1e-10, "cell {i}: {} Pa, not {expected} Pa", stress[0]);
    }
}
