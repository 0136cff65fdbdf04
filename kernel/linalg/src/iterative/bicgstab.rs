//! Preconditioned BiCGSTAB (van der Vorst 1992).

use super::preconditioning::{Definiteness, Preconditioning};
use super::{IterativeSettings, Krylov};
use crate::vector::{add_scaled, dot, norm};
use crate::{BlockMatrix, LinearError, LinearSolver, SolveReport};

/// Cosines of angles below this count as a breakdown of the recurrence.
const BREAKDOWN: f64 = 1e-12;

/// Solver for any regular matrix.
pub struct BiCgStab {
    settings: IterativeSettings,
    preconditioning: Preconditioning,
    work: Work,
}

#[derive(Default)]
struct Work {
    residual: Vec<f64>,
    shadow: Vec<f64>,
    direction: Vec<f64>,
    /// `A M^-1 direction`
    image: Vec<f64>,
    preconditioned: Vec<f64>,
    /// `A M^-1 residual`
    stabiliser: Vec<f64>,
}

impl BiCgStab {
    pub fn new(settings: IterativeSettings) -> Self {
        let preconditioning = Preconditioning::new(settings.preconditioner, Definiteness::Unknown);
        Self { settings, preconditioning, work: Work::default() }
    }
}

impl Krylov for BiCgStab {
    fn settings(&self) -> &IterativeSettings {
        &self.settings
    }

    fn prepare(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Work { residual, shadow, direction, image, preconditioned, stabiliser } = &mut self.work;
        let work = [residual, shadow, direction, image, preconditioned, stabiliser];
        work.into_iter().for_each(|vector| vector.resize(a.pattern.order(), 0.0));
        self.preconditioning.set_up(a)
    }

    fn residual(&mut self) -> &mut [f64] {
        &mut self.work.residual
    }

    fn cycle(&mut self, a: &BlockMatrix, x: &mut [f64], target: f64, maximum: usize) -> Result<usize, LinearError> {
        let Work { residual, shadow, direction, image, preconditioned, stabiliser } = &mut self.work;
        shadow.copy_from_slice(residual);
        direction.copy_from_slice(residual);
        let shadow_norm = norm(shadow);
        let mut product = dot(shadow, residual);
        for iteration in 0..maximum {
            if norm(residual) <= target {
                return Ok(iteration);
            }
            self.preconditioning.apply(a, direction, preconditioned);
            a.multiply(preconditioned, image);
            let overlap = dot(shadow, image);
            if vanishes(overlap, shadow_norm * norm(image)) {
                return Ok(iteration);
            }
            let step = product / overlap;
            add_scaled(x, step, preconditioned);
            add_scaled(residual, -step, image);
            if norm(residual) <= target {
                return Ok(iteration + 1);
            }
            self.preconditioning.apply(a, residual, preconditioned);
            a.multiply(preconditioned, stabiliser);
            let (length, descent) = (dot(stabiliser, stabiliser), dot(stabiliser, residual));
            if vanishes(descent, length.sqrt() * norm(residual)) {
                return Ok(iteration + 1);
            }
            let damping = descent / length;
            add_scaled(x, damping, preconditioned);
            add_scaled(residual, -damping, stabiliser);
            let next = dot(shadow, residual);
            if vanishes(next, shadow_norm * norm(residual)) {
                return Ok(iteration + 1);
            }
            let factor = next / product * (step / damping);
            product = next;
            for ((p, r), v) in direction.iter_mut().zip(residual.iter()).zip(image.iter()) {
                *p = r + factor * (*p - damping * v);
            }
        }
        Ok(maximum)
    }
}

/// Whether vectors with this `product`, whose lengths multiply to `lengths`, are as good as orthogonal.
fn vanishes(product: f64, lengths: f64) -> bool {
    product.is_nan() || product.abs() <= BREAKDOWN * lengths
}

impl LinearSolver for BiCgStab {
    fn name(&self) -> String {
        self.settings.describe("BiCGSTAB")
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        a.check(rhs, x)?;
        self.run(a, rhs, x)
    }
}
