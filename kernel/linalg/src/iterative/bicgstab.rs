//! Preconditioned BiCGSTAB (van der Vorst 1992).

use super::IterativeSettings;
use super::preconditioning::{Definiteness, Preconditioning};
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

    /// Iterates until the recurrence says that the residual is below `target`, or breaks down; returns the iterations
    /// done.
    fn iterate(&mut self, a: &BlockMatrix, x: &mut [f64], target: f64, maximum: usize) -> usize {
        let Work { residual, shadow, direction, image, preconditioned, stabiliser } = &mut self.work;
        shadow.copy_from_slice(residual);
        direction.copy_from_slice(residual);
        let shadow_norm = norm(shadow);
        let mut product = dot(shadow, residual);
        for iteration in 0..maximum {
            if norm(residual) <= target {
                return iteration;
            }
            self.preconditioning.apply(a, direction, preconditioned);
            a.multiply(preconditioned, image);
            let overlap = dot(shadow, image);
            if vanishes(overlap, shadow_norm * norm(image)) {
                return iteration;
            }
            let step = product / overlap;
            add_scaled(x, step, preconditioned);
            add_scaled(residual, -step, image);
            if norm(residual) <= target {
                return iteration + 1;
            }
            self.preconditioning.apply(a, residual, preconditioned);
            a.multiply(preconditioned, stabiliser);
            let (length, descent) = (dot(stabiliser, stabiliser), dot(stabiliser, residual));
            if vanishes(descent, length.sqrt() * norm(residual)) {
                return iteration + 1;
            }
            let damping = descent / length;
            add_scaled(x, damping, preconditioned);
            add_scaled(residual, -damping, stabiliser);
            let next = dot(shadow, residual);
            if vanishes(next, shadow_norm * norm(residual)) {
                return iteration + 1;
            }
            let factor = next / product * (step / damping);
            product = next;
            for ((p, r), v) in direction.iter_mut().zip(residual.iter()).zip(image.iter()) {
                *p = r + factor * (*p - damping * v);
            }
        }
        maximum
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
        let Work { residual, shadow, direction, image, preconditioned, stabiliser } = &mut self.work;
        let work = [residual, shadow, direction, image, preconditioned, stabiliser];
        work.into_iter().for_each(|vector| vector.resize(rhs.len(), 0.0));
        let scale = norm(rhs);
        let settings = self.settings.clone();
        settings.start(scale, x);
        if scale == 0.0 {
            return Ok(SolveReport { iterations: Some(0), ..SolveReport::default() });
        }
        self.preconditioning.set_up(a)?;
        let mut iterations = 0;
        a.residual(rhs, x, &mut self.work.residual);
        // A breakdown and a drift of the recurrence are both cured by a new shadow vector.
        loop {
            let left = settings.maximum_iterations - iterations;
            let done = self.iterate(a, x, settings.tolerance * scale, left);
            iterations += done;
            a.residual(rhs, x, &mut self.work.residual);
            if let Some(result) = settings.judge(norm(&self.work.residual) / scale, iterations, done) {
                return result;
            }
        }
    }
}
