//! Scenes for the tests: meshes, projects, runs of the built program, and the records they leave.
#![allow(dead_code)] // each test program uses a part of it

mod mesh;
mod record;
mod scene;
mod table;

#[allow(unused_imports)]
pub use mesh::{Cell, Mesh};
#[allow(unused_imports)]
pub use record::{Record, State};
#[allow(unused_imports)]
pub use scene::{Body, Scene, fix, gravity, material, process, run_project};
#[allow(unused_imports)]
pub use table::Table;

/// Order of convergence of errors on meshes (or steps) that are halved from one to the next.
pub fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

/// Largest difference of two lists of vectors; infinite if any is not a number.
pub fn largest_difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len(), "lists of different length are compared");
    let pairs = a.iter().zip(b).flat_map(|(a, b)| {
        assert_eq!(a.len(), b.len(), "vectors of different length are compared");
        a.iter().zip(b)
    });
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, |most, d| if d.is_nan() { f64::INFINITY } else { most.max(d) })
}
