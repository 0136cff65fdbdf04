//! Krylov methods on block matrices.

mod bicgstab;
mod block;
mod conjugate_gradient;
mod gmres;
mod incomplete;
mod preconditioning;
#[cfg(test)]
mod tests;

pub use bicgstab::BiCgStab;
pub use conjugate_gradient::ConjugateGradient;
pub use gmres::Gmres;

use crate::vector::norm;
use crate::{BlockMatrix, LinearError, SolveReport};

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
        };
        format!("{method}, {preconditioner}, tolerance {:.1e}", self.tolerance)
    }

    /// Sets the first guess for a right-hand side of norm `scale`.
    fn start(&self, scale: f64, x: &mut [f64]) {
        if !self.warm_start || scale == 0.0 || !x.iter().all(|value| value.is_finite()) {
            x.fill(0.0);
        }
    }

    /// Result for the true relative `residual` after `iterations`; `None` if another cycle is `worthwhile`.
    fn judge(&self, residual: f64, iterations: usize, worthwhile: bool) -> Option<Result<SolveReport, LinearError>> {
        if residual <= self.tolerance {
            return Some(Ok(SolveReport { iterations: Some(iterations), residual, ..SolveReport::default() }));
        }
        let hopeless = !worthwhile || iterations >= self.maximum_iterations || !residual.is_finite();
        hopeless.then_some(Err(LinearError::NotConverged { iterations, residual, tolerance: self.tolerance }))
    }
}

/// An iteration that can be started anew from the true residual.
trait Krylov {
    fn settings(&self) -> &IterativeSettings;

    /// Allocates vectors and sets up the preconditioner.
    fn prepare(&mut self, a: &BlockMatrix) -> Result<(), LinearError>;

    /// Where [`Self::cycle`] finds the residual of `x`.
    fn residual(&mut self) -> &mut [f64];

    /// Improves `x` until the recurrence says that the residual is below `target`, or no further; returns the
    /// iterations done.
    fn cycle(&mut self, a: &BlockMatrix, x: &mut [f64], target: f64, maximum: usize) -> Result<usize, LinearError>;

    /// Whether a cycle that left this part of the residual shows that more of them are in vain.
    fn gives_up(&self, _reduction: f64) -> bool {
        false
    }

    /// Solves `a x = rhs`, whose sizes have been checked.
    ///
    /// A breakdown of the recurrence and its drift from the true residual are both cured by a new cycle.
    fn run(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        let (scale, settings) = (norm(rhs), self.settings().clone());
        settings.start(scale, x);
        if scale == 0.0 {
            return Ok(SolveReport { iterations: Some(0), ..SolveReport::default() });
        }
        self.prepare(a)?;
        let mut iterations = 0;
        a.residual(rhs, x, self.residual());
        let mut before = norm(self.residual()) / scale;
        loop {
            let left = settings.maximum_iterations - iterations;
            let done = self.cycle(a, x, settings.tolerance * scale, left)?;
            iterations += done;
            a.residual(rhs, x, self.residual());
            let residual = norm(self.residual()) / scale;
            let worthwhile = done > 0 && !self.gives_up(residual / before);
            if let Some(result) = settings.judge(residual, iterations, worthwhile) {
                return result;
            }
            before = residual;
        }
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
    /// Incomplete factorisation on the pattern of `A`, ILU(0) in blocks: fewer iterations, dear set-up. Copes with
    /// stabilised displacement-pressure systems, as the pivots are whole nodes.
    Incomplete,
}
