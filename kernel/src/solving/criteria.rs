//! When Newton's method has converged.

use super::ActiveDofs;

/// Relative and absolute bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Bound of the norm relative to its reference.
    pub relative: f64,
    /// Bound of the scaled norm itself.
    pub absolute: f64,
}

impl Tolerances {
    fn met(&self, ratio: f64, absolute: f64) -> bool {
        ratio <= self.relative || absolute < self.absolute
    }
}

/// A convergence criterion, with Kratos's formulas (spec 03 §6).
#[derive(Debug, Clone, PartialEq)]
pub enum Criterion {
    /// The residual after the correction, relative to the one at the start of the step; its
    /// absolute form is divided by the number of free dofs.
    Residual(Tolerances),
    /// The correction relative to the unknowns; its absolute form is divided by the square root
    /// of the number of free dofs.
    Displacement(Tolerances),
    /// Both.
    And(Tolerances, Tolerances),
    /// One of both (displacement, residual).
    Or(Tolerances, Tolerances),
}

impl Criterion {
    /// Whether the residual must be built again after each correction.
    pub fn needs_residual(&self) -> bool {
        !matches!(self, Criterion::Displacement(_))
    }

    /// Judges one iteration. `initial` is the norm of the residual at the start of the step.
    pub fn met(&self, dofs: &ActiveDofs, initial: f64, residual: &[f64], correction: &[f64], values: &[f64]) -> bool {
        let by_residual = |tolerances: &Tolerances| {
            let now = free_norm(dofs, residual);
            let ratio = if initial < f64::EPSILON { 0.0 } else { now / initial };
            tolerances.met(ratio, now / dofs.free().max(1) as f64)
        };
        let by_displacement = |tolerances: &Tolerances| {
            let step = free_norm(dofs, correction);
            let size = free_norm(dofs, values);
            let ratio = if step == 0.0 { 0.0 } else { step / if size < f64::EPSILON { step } else { size } };
            tolerances.met(ratio, step / (dofs.free().max(1) as f64).sqrt())
        };
        match self {
            Criterion::Residual(r) => by_residual(r),
            Criterion::Displacement(d) => by_displacement(d),
            Criterion::And(d, r) => by_displacement(d) && by_residual(r),
            Criterion::Or(d, r) => by_displacement(d) || by_residual(r),
        }
    }
}

/// Euclidean norm over the free dofs.
pub fn free_norm(dofs: &ActiveDofs, vector: &[f64]) -> f64 {
    vector.iter().zip(dofs.fixed()).filter(|(_, fixed)| !**fixed).map(|(x, _)| x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_of_both_criteria() {
        let mut dofs = ActiveDofs::new(1, &[true; 5]);
        dofs.fixed_mut()[4] = true;
        let t = |relative, absolute| Tolerances { relative, absolute };
        let (r, dx, x) = ([3.0, 4.0, 0.0, 0.0, 99.0], [0.3, 0.4, 0.0, 0.0, 99.0], [3.0, 4.0, 0.0, 0.0, 99.0]);
        // |r| = 5, 4 free dofs: ratio 5/50, absolute 5/4.
        assert!(Criterion::Residual(t(0.1, 0.0)).met(&dofs, 50.0, &r, &dx, &x));
        assert!(!Criterion::Residual(t(0.0999, 1.25)).met(&dofs, 50.0, &r, &dx, &x));
        assert!(Criterion::Residual(t(0.0, 1.2501)).met(&dofs, 50.0, &r, &dx, &x));
        // |dx| = 0.5, |x| = 5: ratio 0.1, absolute 0.5/2.
        assert!(Criterion::Displacement(t(0.1 + 1e-15, 0.0)).met(&dofs, 50.0, &r, &dx, &x));
        assert!(!Criterion::Displacement(t(0.09, 0.25)).met(&dofs, 50.0, &r, &dx, &x));
        assert!(!Criterion::And(t(0.2, 0.0), t(0.01, 0.0)).met(&dofs, 50.0, &r, &dx, &x));
        assert!(Criterion::Or(t(0.2, 0.0), t(0.01, 0.0)).met(&dofs, 50.0, &r, &dx, &x));
    }
}
