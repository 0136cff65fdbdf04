//! Krylov methods on block matrices.

mod bicgstab;
mod block;
mod conjugate_gradient;
mod gmres;
mod incomplete;
mod preconditioning;
mod saddle;
#[cfg(test)]
mod tests;

pub use bicgstab::BiCgStab;
pub use conjugate_gradient::ConjugateGradient;
pub use gmres::Gmres;

use crate::{LinearError, SolveReport};

/// Settings of an iterative method.
#[derive(Debug, Clone, PartialEq)]
pub struct IterativeSettings {
    /// Relative residual `||b - A x|| / ||b||` to reach; checked with the true residual at the end.
    pub tolerance: f64,
    /// Iterations after which the method gives up.
    pub maximum_iterations: usize,
    /// What makes it converge faster.
    pub preconditioner: Preconditioner,
    /// Start from the `x` passed in instead of zero.
    pub warm_start: bool,
}

impl IterativeSettings {
    /// At most 1000 iterations from zero with the block diagonal as preconditioner.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, maximum_iterations: 1000, preconditioner: Preconditioner::BlockJacobi, warm_start: false }
    }

    fn describe(&self, method: &str) -> String {
        let preconditioner = match self.preconditioner {
            Preconditioner::BlockJacobi => "block Jacobi",
            Preconditioner::DiagonalIncomplete => "diagonal incomplete factorisation (D-ILU)",
            Preconditioner::Incomplete => "incomplete factorisation ILU(0)",
            Preconditioner::BlockTriangular => "block triangle with an approximate Schur complement",
        };
        format!("{method}, {preconditioner}, tolerance {:.1e}", self.tolerance)
    }

    /// Sets the first guess for a right-hand side of norm `scale`.
    fn start(&self, scale: f64, x: &mut [f64]) {
        if !self.warm_start || scale == 0.0 || !x.iter().all(|value| value.is_finite()) {
            x.fill(0.0);
        }
    }

    /// Result for the true relative `residual` after `iterations`, the last `done` of them since the last restart;
    /// `None` if another restart is worthwhile.
    fn judge(&self, residual: f64, iterations: usize, done: usize) -> Option<Result<SolveReport, LinearError>> {
        if residual <= self.tolerance {
            return Some(Ok(SolveReport { iterations: Some(iterations), residual, ..SolveReport::default() }));
        }
        let hopeless = done == 0 || iterations >= self.maximum_iterations || !residual.is_finite();
        hopeless.then_some(Err(LinearError::NotConverged { iterations, residual, tolerance: self.tolerance }))
    }
}

/// Approximate inverses `M^-1` of a matrix `A = L + D + U` of blocks.
///
/// The block diagonal is applied by all threads; the sweeps of the incomplete factorisations are sequential.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Preconditioner {
    /// `M = D`: the diagonal blocks. No set-up to speak of and parallel; as fast as the others on mass-dominated
    /// matrices even on one thread.
    BlockJacobi,
    /// `M = (E + L) E^-1 (E + U)` where the diagonal blocks `E` are such that `M` and `A` have the same
    /// diagonal blocks (D-ILU; Barrett et al., *Templates for the Solution of Linear Systems*, 1994,
    /// section 3.4.2). Costs as much as a product with `A` and needs next to no set-up.
    DiagonalIncomplete,
    /// Incomplete factorisation on the pattern of `A`, ILU(0) in blocks: fewer iterations, dear set-up.
    Incomplete,
    /// For displacements and, last on each node, a pressure, `A = [K B^T; B' -C]`: the block triangle
    /// `M = [K B^T; 0 -S]`, where `K` and the approximate Schur complement `S` are factorised incompletely.
    BlockTriangular,
}
