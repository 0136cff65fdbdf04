//! Direct solvers: a factorisation of faer between checks of its input and of its result.

mod factors;
mod lu;
mod multifrontal;
mod probe;
mod symmetric;
#[cfg(test)]
mod tests;

pub use lu::Lu as ColumnLu;
pub use multifrontal::Lu;
pub use symmetric::{Cholesky, Ldlt, PivotedLdlt};

use crate::vector::{norm, position_of_greatest};
use crate::{BlockMatrix, BlockPattern, LinearError, LinearSolver, SolveReport};
use factors::Factorisation;
use probe::Probe;
use std::sync::Arc;

/// Relative residual above which one step of iterative refinement is made.
const REFINE_ABOVE: f64 = 1e-12;
/// Relative residual above which a solution is refused.
const REFUSE_ABOVE: f64 = 1e-6;

/// A direct solver around the factorisation `F`.
#[derive(Default)]
pub struct Direct<F> {
    factors: F,
    analysed: Option<Arc<BlockPattern>>,
    work: Vec<f64>,
    residual: Vec<f64>,
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
        let residual = self.refine(a, rhs, x)?;
        Ok(SolveReport { residual, negative_pivots: self.factors.negative_pivots(), ..SolveReport::default() })
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

    /// Computes the true residual and improves `x` once if that is worth it.
    fn refine(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<f64, LinearError> {
        let scale = norm(rhs);
        if scale == 0.0 {
            x.fill(0.0);
            return Ok(0.0);
        }
        self.residual.resize(rhs.len(), 0.0);
        a.residual(rhs, x, &mut self.residual);
        let mut residual = norm(&self.residual) / scale;
        if residual > REFINE_ABOVE {
            self.work.clear();
            self.work.extend_from_slice(&self.residual);
            self.factors.solve(&mut self.work, 1)?;
            for (correction, x) in self.work.iter_mut().zip(x.iter()) {
                *correction += x;
            }
            a.residual(rhs, &self.work, &mut self.residual);
            let refined = norm(&self.residual) / scale;
            if refined < residual {
                x.copy_from_slice(&self.work);
                residual = refined;
            } else {
                a.residual(rhs, x, &mut self.residual);
            }
        }
        if residual <= REFUSE_ABOVE {
            return Ok(residual);
        }
        Err(LinearError::Inaccurate { dof: position_of_greatest(self.residual.iter().map(|r| r.abs())), residual })
    }
}
