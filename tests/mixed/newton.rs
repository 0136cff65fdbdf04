//! Newton's method with the exact tangent: quadratic, and the same for every Poisson's ratio.

use super::common::Cell;
use super::membrane::{Membrane, iterations};
use serde_json::json;

const STABILIZATIONS: [&str; 3] = ["ppp", "asgs", "osgs"];

/// At quadratic convergence the last six digits cost one iteration; at the rate of 0.03 that an inexact
/// tangent has, they cost four.
#[test]
fn the_last_digits_cost_one_iteration() {
    for cell in [Cell::Triangle, Cell::Quadrilateral] {
        for stabilization in STABILIZATIONS {
            for law in ["kratos", "miehe"] {
                let count = |tolerance: f64| {
                    let settings = json!({"stabilization": stabilization, "volumetric_law": law,
                                          "residual_relative_tolerance": tolerance});
                    iterations(&Membrane::new(cell, 8, 0.4, 6.25).with(settings).run())
                };
                let counts = [1e-2, 1e-5, 1e-11].map(count);
                let told = format!("{cell:?} {stabilization} {law}: {counts:?}");
                assert!(counts[2] - counts[1] <= 1 && counts[2] <= 6, "{told}");
            }
        }
    }
}

#[test]
fn iterations_do_not_depend_on_poissons_ratio() {
    for stabilization in STABILIZATIONS {
        for (load, most) in [(0.0625, 3), (6.25, 6)] {
            for poisson in [0.3, 0.49, 0.4999, 0.499999, 0.5] {
                let settings = json!({"stabilization": stabilization, "residual_relative_tolerance": 1e-9});
                let count = iterations(&Membrane::new(Cell::Quadrilateral, 8, poisson, load).with(settings).run());
                assert!(count <= most, "{stabilization} ν = {poisson}, {load} N/m: {count}");
            }
        }
    }
}
