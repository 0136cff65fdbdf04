//! Block-sparse linear algebra: a fixed pattern, its values, and linear solvers behind one trait.
//!
//! A nodal unknown of `B` components (2 displacements, 3 displacements and a pressure, ...) makes
//! every coupling a dense `B x B` block, `B` in 1..=4. [`BlockPattern`] holds which nodes are coupled,
//! [`BlockMatrix`] the values, and [`solver`] builds a [`LinearSolver`] from a [`Method`]. Symmetric
//! factorisations and the dense kernels of the multifrontal LU come from `faer`, whose types are named in this crate
//! and nowhere else.
//!
//! Results are bit-identical for any number of threads: rows are computed whole by one thread, sums
//! over vectors follow a fixed order, and factorisations are cut into tasks that do not depend on the threads.

mod automatic;
mod direct;
mod equilibration;
mod error;
mod iterative;
mod matrix;
#[cfg(test)]
mod measure;
mod pattern;
#[cfg(test)]
mod saddle_tests;
mod solver;
#[cfg(test)]
mod test_systems;
mod vector;

pub use error::LinearError;
pub use iterative::{IterativeSettings, Preconditioner};
pub use matrix::BlockMatrix;
pub use pattern::BlockPattern;
pub use solver::{LinearSolver, Method, Nature, SolveReport, solver};
