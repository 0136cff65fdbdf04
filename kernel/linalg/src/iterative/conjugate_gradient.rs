//! Preconditioned conjugate gradients (Hestenes and Stiefel 1952).

use super::preconditioning::{Definiteness, Preconditioning};
use super::{IterativeSettings, Krylov};
use crate::vector::{add_scaled, dot, norm, position_of_greatest, scale_and_add};
use crate::{BlockMatrix, LinearError, LinearSolver, SolveReport};

/// Solver for symmetric positive definite matrices.
pub struct ConjugateGradient {
    settings: IterativeSettings,
    preconditioning: Preconditioning,
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    image: Vec<f64>,
}

impl ConjugateGradient {
    pub fn new(settings: IterativeSettings) -> Self {
        let preconditioning = Preconditioning::new(settings.preconditioner, Definiteness::Positive);
        let [residual, preconditioned, direction, image] = [const { Vec::new() }; 4];
        Self { settings, preconditioning, residual, preconditioned, direction, image }
    }
}

impl Krylov for ConjugateGradient {
    fn settings(&self) -> &IterativeSettings {
        &self.settings
    }

    fn prepare(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let work = [&mut self.residual, &mut self.preconditioned, &mut self.direction, &mut self.image];
        work.into_iter().for_each(|vector| vector.resize(a.pattern.order(), 0.0));
        self.preconditioning.set_up(a)
    }

    fn residual(&mut self) -> &mut [f64] {
        &mut self.residual
    }

    fn cycle(&mut self, a: &BlockMatrix, x: &mut [f64], target: f64, maximum: usize) -> Result<usize, LinearError> {
        let Self { preconditioning, residual, preconditioned, direction, image, .. } = self;
        let mut previous = 0.0;
        for iteration in 0..maximum {
            if norm(residual) <= target {
                return Ok(iteration);
            }
            preconditioning.apply(a, residual, preconditioned);
            let product = dot(residual, preconditioned);
            if iteration == 0 {
                direction.copy_from_slice(preconditioned);
            } else {
                scale_and_add(direction, product / previous, preconditioned);
            }
            previous = product;
            a.multiply(direction, image);
            let curvature = dot(direction, image);
            if !(curvature > 0.0 && product > 0.0) {
                let parts = direction.iter().zip(image.iter()).map(|(p, q)| -p * q);
                return Err(LinearError::NotPositiveDefinite { dof: position_of_greatest(parts) });
            }
            let step = product / curvature;
            add_scaled(x, step, direction);
            add_scaled(residual, -step, image);
        }
        Ok(maximum)
    }
}

impl LinearSolver for ConjugateGradient {
    fn name(&self) -> String {
        self.settings.describe("conjugate gradients")
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        a.check(rhs, x)?;
        self.run(a, rhs, x)
    }
}
