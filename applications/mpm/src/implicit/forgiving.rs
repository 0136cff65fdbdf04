//! Kratos's direct solvers answer a consistent system whose matrix is singular up to round-off (a
//! body that is free to slide, say) with an arbitrary undetermined part. Bia stops there and names
//! the dof; only `kratos_exact` goes on as Kratos does, with the undetermined part left at zero.

use bia_kernel::linalg::{BlockMatrix, IterativeSettings, LinearError, LinearSolver, Method, SolveReport, solver};

/// A solver that falls back to conjugate gradients where its matrix is singular.
pub struct Forgiving {
    inner: Box<dyn LinearSolver>,
    gradients: Box<dyn LinearSolver>,
}

impl Forgiving {
    /// Wraps a solver for symmetric matrices.
    pub fn new(inner: Box<dyn LinearSolver>) -> Self {
        let settings = IterativeSettings { maximum_iterations: 10_000, ..IterativeSettings::new(1e-13) };
        Self { inner, gradients: solver(Method::ConjugateGradient(settings)) }
    }
}

impl LinearSolver for Forgiving {
    fn name(&self) -> String {
        self.inner.name()
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        match self.inner.solve(a, rhs, x) {
            Err(LinearError::Singular { dof }) => {
                // Conjugate gradients started from zero never leave the range of the matrix.
                x.fill(0.0);
                let report = self.gradients.solve(a, rhs, x)?;
                let note = format!("the matrix is singular at degree of freedom {dof}; solved as Kratos does");
                Ok(SolveReport { note: Some(note), ..report })
            }
            other => other,
        }
    }
}
