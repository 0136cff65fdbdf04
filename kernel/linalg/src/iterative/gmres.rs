//! Restarted GMRES (Saad and Schultz 1986), preconditioned from the right, on the equilibrated matrix.

use super::preconditioning::{Definiteness, Preconditioning};
use super::{IterativeSettings, Krylov};
use crate::equilibration::Equilibration;
use crate::vector::{add_scaled, dot, norm};
use crate::{BlockMatrix, LinearError, LinearSolver, SolveReport};

/// Directions kept before a restart.
const RESTART: usize = 100;
/// A cycle that leaves more than this part of the residual is the last one.
const STAGNATION: f64 = 0.1;

/// Solver for any regular matrix, saddle points with rows of different units among them.
///
/// The residual that it reduces, and that it reports, is that of the equilibrated system `R A C`: all rows count alike,
/// whatever their units.
pub struct Gmres {
    settings: IterativeSettings,
    preconditioning: Preconditioning,
    scaling: Equilibration,
    scaled: Option<BlockMatrix>,
    work: Work,
}

#[derive(Default)]
struct Work {
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    /// Orthonormal directions.
    basis: Vec<Vec<f64>>,
    /// Columns of the Hessenberg matrix, made triangular by the rotations.
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    /// The residual in the basis.
    projected: Vec<f64>,
}

impl Gmres {
    pub fn new(settings: IterativeSettings) -> Self {
        let preconditioning = Preconditioning::new(settings.preconditioner, Definiteness::Unknown);
        let scaling = Equilibration::default();
        Self { settings, preconditioning, scaling, scaled: None, work: Work::default() }
    }
}

impl Krylov for Gmres {
    fn settings(&self) -> &IterativeSettings {
        &self.settings
    }

    fn prepare(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let Work { residual, preconditioned, .. } = &mut self.work;
        [residual, preconditioned].into_iter().for_each(|vector| vector.resize(a.pattern.order(), 0.0));
        self.preconditioning.set_up(a)
    }

    fn residual(&mut self) -> &mut [f64] {
        &mut self.work.residual
    }

    fn gives_up(&self, reduction: f64) -> bool {
        reduction.is_nan() || reduction > STAGNATION
    }

    fn cycle(&mut self, a: &BlockMatrix, x: &mut [f64], target: f64, maximum: usize) -> Result<usize, LinearError> {
        let Work { residual, preconditioned, basis, columns, rotations, projected, .. } = &mut self.work;
        let length = norm(residual);
        if length <= target {
            return Ok(0);
        }
        columns.clear();
        rotations.clear();
        projected.clear();
        projected.push(length);
        store(basis, 0, residual, 1.0 / length);
        let mut done = 0;
        while done < maximum.min(RESTART) && projected[done].abs() > target {
            self.preconditioning.apply(a, &basis[done], preconditioned);
            a.multiply(preconditioned, residual);
            let mut column = Vec::with_capacity(done + 2);
            for direction in &basis[..=done] {
                let overlap = dot(direction, residual);
                add_scaled(residual, -overlap, direction);
                column.push(overlap);
            }
            let length = norm(residual);
            for (k, &(cosine, sine)) in rotations.iter().enumerate() {
                let (upper, lower) = (column[k], column[k + 1]);
                (column[k], column[k + 1]) = (cosine * upper + sine * lower, cosine * lower - sine * upper);
            }
            let radius = column[done].hypot(length);
            if !(radius > 0.0 && radius.is_finite()) {
                break;
            }
            let (cosine, sine) = (column[done] / radius, length / radius);
            column[done] = radius;
            rotations.push((cosine, sine));
            columns.push(column);
            projected.push(-sine * projected[done]);
            projected[done] *= cosine;
            done += 1;
            if length == 0.0 {
                break;
            }
            store(basis, done, residual, 1.0 / length);
        }
        // Back substitution, and the combination of the directions.
        for k in (0..done).rev() {
            for j in k + 1..done {
                projected[k] -= columns[j][k] * projected[j];
            }
            projected[k] /= columns[k][k];
        }
        residual.fill(0.0);
        for (direction, &factor) in basis.iter().zip(&projected[..done]) {
            add_scaled(residual, factor, direction);
        }
        self.preconditioning.apply(a, residual, preconditioned);
        add_scaled(x, 1.0, preconditioned);
        Ok(done)
    }
}

/// Puts `factor * vector` in place `index` of a list that holds at least `index` vectors.
fn store(basis: &mut Vec<Vec<f64>>, index: usize, vector: &[f64], factor: f64) {
    if basis.len() == index {
        basis.push(Vec::new());
    }
    basis[index].clear();
    basis[index].extend(vector.iter().map(|value| factor * value));
}

impl LinearSolver for Gmres {
    fn name(&self) -> String {
        self.settings.describe("GMRES")
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        a.check(rhs, x)?;
        self.scaling.set_up(a);
        let mut scaled = self.scaled.take().unwrap_or_else(|| a.clone());
        self.scaling.apply(a, &mut scaled);
        let load: Vec<f64> = rhs.iter().zip(&self.scaling.rows).map(|(value, scale)| value * scale).collect();
        x.iter_mut().zip(&self.scaling.columns).for_each(|(x, scale)| *x /= scale);
        let result = self.run(&scaled, &load, x);
        x.iter_mut().zip(&self.scaling.columns).for_each(|(x, scale)| *x *= scale);
        self.scaled = Some(scaled);
        result
    }
}
