//! Direct solvers: a factorisation of faer between checks of its input and of its result.

mod backward_error;
mod factors;
mod multifrontal;
mod probe;
mod symmetric;
#[cfg(test)]
mod tests;

pub use multifrontal::Lu;

/// Sparse `L L^T`.
pub type Cholesky = symmetric::Symmetric<symmetric::Cholesky>;
/// Sparse `L D L^T`.
pub type Ldlt = symmetric::Symmetric<symmetric::Ldlt>;

use crate::vector::norm;
use crate::{BlockMatrix, BlockPattern, LinearError, LinearSolver, SolveReport};
use backward_error::{BackwardError, Magnitudes};
use factors::Factorisation;
use probe::Probe;
use std::sync::Arc;

/// Backward error above which a solution is refined.
const REFINE_ABOVE: f64 = 1e-13;
/// Steps of iterative refinement at most.
const REFINEMENTS: usize = 5;
/// Backward error above which a solution is refused.
const REFUSE_ABOVE: f64 = 1e-10;

/// A direct solver around the factorisation `F`.
#[derive(Default)]
pub struct Direct<F> {
    factors: F,
    analysed: Option<Arc<BlockPattern>>,
    work: Vec<f64>,
    residual: Vec<f64>,
    magnitudes: Magnitudes,
}

impl<F: Factorisation> LinearSolver for Direct<F> {
    fn name(&self) -> String {
        F::NAME.into()
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        a.check(rhs, x)?;
        let probe = Probe::new(a)?;
        self.factorise(a)?;
        let order = rhs.len();
        self.work.clear();
        self.work.extend_from_slice(rhs);
        probe.append_to(&mut self.work);
        self.factors.solve(&mut self.work, 2)?;
        let (solution, probed) = self.work.split_at(order);
        probe.judge(a, probed)?;
        x.copy_from_slice(solution);
        let backward_error = self.refine(a, rhs, x)?;
        let scale = norm(rhs);
        let residual = if scale > 0.0 { norm(&self.residual) / scale } else { 0.0 };
        let negative_pivots = self.factors.negative_pivots();
        Ok(SolveReport { residual, backward_error: Some(backward_error), negative_pivots, ..SolveReport::default() })
    }
}

impl<F: Factorisation> Direct<F> {
    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        if !self.analysed.as_ref().is_some_and(|pattern| Arc::ptr_eq(pattern, &a.pattern)) {
            self.analysed = None;
            self.factors.analyse(&a.pattern)?;
            self.analysed = Some(Arc::clone(&a.pattern));
        }
        self.factors.factorise(a)
    }

    /// Computes the true residual and improves `x` as long as that is worth it; returns the backward error.
    fn refine(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<f64, LinearError> {
        let Self { factors, work, residual, magnitudes, .. } = self;
        residual.resize(rhs.len(), 0.0);
        a.residual(rhs, x, residual);
        let mut error = magnitudes.backward_error(a, rhs, x, residual);
        for _ in 0..REFINEMENTS {
            if error.value <= REFINE_ABOVE {
                break;
            }
            work.clone_from(residual);
            factors.solve(work, 1)?;
            for (correction, x) in work.iter_mut().zip(x.iter()) {
                *correction += x;
            }
            a.residual(rhs, work, residual);
            let refined = magnitudes.backward_error(a, rhs, work, residual);
            let BackwardError { value, .. } = std::mem::replace(&mut error, refined);
            if refined.value < value {
                x.copy_from_slice(work);
            }
            if refined.value > 0.5 * value {
                if refined.value >= value {
                    a.residual(rhs, x, residual);
                    error = magnitudes.backward_error(a, rhs, x, residual);
                }
                break;
            }
        }
        if error.value <= REFUSE_ABOVE {
            return Ok(error.value);
        }
        Err(LinearError::Inaccurate { dof: error.dof, backward_error: error.value })
    }
}
