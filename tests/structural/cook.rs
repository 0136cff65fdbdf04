//! Cook's membrane under a small dead load: plane strain, left side clamped, a shear traction on the
//! right one.
//!
//! Reference: u_y(48, 60) / 48 per τ/μ for ν = 0.33 by elements of order 5 on a mesh graded to the
//! corners: 2.8208 at τ/μ = 0.002375 and 2.8007 at 0.005, so 2.8390 for small loads, where the law does
//! not matter.

use super::body::{Body, fix, load, material};
use super::common::{Cell, Mesh, orders};
use serde_json::json;

#[test]
fn the_corner_rises_as_in_the_reference() {
    let (young, poisson) = (70.0, 0.33);
    let traction = 1e-5 * young / 2.0 / (1.0 + poisson);
    for (cell, bound) in [(Cell::Quadrilateral, 0.02), (Cell::Triangle, 0.05)] {
        let errors = [8, 16, 32].map(|cells| {
            let mesh = Mesh::block(cell, [cells, cells, 1], [0.0; 3], [1.0, 1.0, 0.0]);
            let mesh = mesh.map(|[x, y, _]| [48.0 * x, 44.0 * x + y * (44.0 - 28.0 * x), 0.0]);
            let row = cells + 1;
            let side = (0..cells).map(|j| vec![j * row + cells, (j + 1) * row + cells]).collect();
            let record = Body::new(
                mesh,
                material("HyperElasticNeoHookeanPlaneStrain2DLaw", 1.0, young, poisson),
                json!({"residual_relative_tolerance": 1e-8}),
                1.0,
            )
            .part("Clamp", |x| x[0] == 0.0)
            .with(fix("Clamp", json!([0.0, 0.0, 0.0])))
            .conditions("Side", "LineLoadCondition2D2N", side)
            .with(load("Side", "LINE_LOAD", json!([0.0, traction, 0.0])))
            .run(&[]);
            let rise = record.last().nodes("DISPLACEMENT")[row * row - 1][1];
            let held: f64 = record.last().nodes("REACTION").iter().map(|r| r[1]).sum();
            assert!((held / (16.0 * traction) + 1.0).abs() < 1e-7, "{held} N hold {} N", 16.0 * traction);
            (rise / 48.0 / 1e-5 / 2.8390 - 1.0).abs()
        });
        // The clamped corner, where the stress is singular, limits the order.
        assert!(errors[2] < bound && orders(&errors).iter().all(|order| *order > 1.2), "{cell:?}: {errors:?}");
    }
}
