//! Choice of a method by size, and fall-backs.

use crate::direct::{Cholesky, Direct, Ldlt, Lu};
use crate::iterative::{BiCgStab, ConjugateGradient, Gmres, IterativeSettings, Preconditioner};
use crate::{BlockMatrix, LinearError, LinearSolver, Nature, SolveReport};

/// Scalar unknowns in 3 dimensions from which on a Krylov method with the block diagonal is faster than a new
/// factorisation. Measured on trilinear elastic hexahedra (module `measure`): at 1029 unknowns 0.3 ms (mass-dominated)
/// to 1.5 ms (static) against 1.7 ms for Cholesky and 5 ms for LU; at 14,739 unknowns 6 to 50 ms against 205 ms.
const ITERATIVE_FROM: usize = 1_000;
/// The same for displacement-pressure systems, where GMRES with ILU(0) is faster: at 2916 unknowns 4 to 15 ms against 12
/// ms for `L D L^T` and 25 ms for LU, at 19,652 unknowns 80 to 500 ms against 430 ms and 1 s.
const MIXED_ITERATIVE_FROM: usize = 3_000;
/// Iterations after which a direct method is tried instead.
const PATIENCE: usize = 500;

/// Tries solvers in turn until one succeeds.
///
/// Every solve starts with the first one, so that it depends on its own input only.
pub struct Chain {
    attempts: Vec<Attempt>,
    last: Box<dyn LinearSolver>,
}

struct Attempt {
    solver: Box<dyn LinearSolver>,
    /// Whether the word of this solver that a matrix is singular is to be believed.
    knows_singular: bool,
}

impl Chain {
    /// LU alone, to put other solvers before.
    fn general() -> Self {
        Self { attempts: Vec::new(), last: Box::new(Direct::<Lu>::default()) }
    }

    /// `L D L^T` without pivoting, then LU.
    pub fn indefinite() -> Self {
        Self::general().after(Direct::<Ldlt>::default(), false)
    }

    /// Cholesky, then as [`Chain::indefinite`].
    pub fn symmetric() -> Self {
        Self::indefinite().after(Direct::<Cholesky>::default(), true)
    }

    /// Tries `solver` before all others.
    fn after(mut self, solver: impl LinearSolver + 'static, knows_singular: bool) -> Self {
        self.attempts.insert(0, Attempt { solver: Box::new(solver), knows_singular });
        self
    }

    fn first(&self) -> &dyn LinearSolver {
        self.attempts.first().map_or(&*self.last, |attempt| &*attempt.solver)
    }
}

impl LinearSolver for Chain {
    fn name(&self) -> String {
        self.first().name()
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        let mut failures: Vec<String> = Vec::new();
        for Attempt { solver, knows_singular } in &mut self.attempts {
            match solver.solve(a, rhs, x) {
                Ok(report) => return Ok(annotated(report, &failures, &**solver)),
                Err(error) if is_final(&error, *knows_singular) => return Err(error),
                Err(error) => failures.push(format!("{} failed: {error}", solver.name())),
            }
        }
        let report = self.last.solve(a, rhs, x)?;
        Ok(annotated(report, &failures, &*self.last))
    }
}

fn annotated(report: SolveReport, failures: &[String], solver: &dyn LinearSolver) -> SolveReport {
    if failures.is_empty() {
        return report;
    }
    SolveReport { note: Some(format!("{}; solved by {} instead", failures.join("; "), solver.name())), ..report }
}

/// Whether no other method can help.
fn is_final(error: &LinearError, knows_singular: bool) -> bool {
    match error {
        LinearError::NonFinite { .. } | LinearError::Size { .. } => true,
        LinearError::Singular { .. } => knows_singular,
        _ => false,
    }
}

/// Chooses a chain when it sees the size of the matrix.
pub struct Automatic {
    nature: Nature,
    tolerance: f64,
    chosen: Option<(bool, Chain)>,
}

impl Automatic {
    pub fn new(nature: Nature, tolerance: f64) -> Self {
        Self { nature, tolerance, chosen: None }
    }

    fn chain(&self, iterative: bool) -> Chain {
        let settings = IterativeSettings { maximum_iterations: PATIENCE, ..IterativeSettings::new(self.tolerance) };
        let Nature { symmetric, definite, .. } = self.nature;
        let direct = match (symmetric, definite) {
            (true, true) => Chain::symmetric(),
            (true, false) => Chain::indefinite(),
            (false, _) => Chain::general(),
        };
        match (iterative, definite, symmetric) {
            (false, ..) => direct,
            (true, false, _) => {
                let preconditioner = Preconditioner::Incomplete;
                direct.after(Gmres::new(IterativeSettings { preconditioner, ..settings }), false)
            }
            (true, true, true) => direct.after(ConjugateGradient::new(settings), false),
            (true, true, false) => direct.after(BiCgStab::new(settings), false),
        }
    }
}

impl LinearSolver for Automatic {
    fn name(&self) -> String {
        match &self.chosen {
            Some((_, chain)) => format!("{} (chosen automatically)", chain.name()),
            None => "to be chosen automatically".into(),
        }
    }

    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError> {
        let from = if self.nature.definite { ITERATIVE_FROM } else { MIXED_ITERATIVE_FROM };
        let iterative = self.nature.dimension == 3 && a.pattern.order() >= from;
        let chosen = self.chosen.take().filter(|(kind, _)| *kind == iterative);
        let (_, chain) = self.chosen.insert(chosen.unwrap_or_else(|| (iterative, self.chain(iterative))));
        chain.solve(a, rhs, x)
    }
}

#[cfg(test)]
mod tests {
    use crate::test_systems::{elastic_box, random_system, set, vector};
    use crate::{Method, Nature, solver};

    fn automatic(symmetric: bool, dimension: usize) -> Method {
        Method::Automatic { nature: Nature { symmetric, definite: true, dimension }, tolerance: 1e-9 }
    }

    #[test]
    fn the_choice_follows_size_dimension_and_symmetry() {
        let (small, large) = (elastic_box(3, 1.0), elastic_box(9, 1.0));
        for (a, symmetric, dimension, expected) in [
            (&small, true, 3, "Cholesky"),
            (&large, true, 2, "Cholesky"),
            (&large, true, 3, "conjugate gradients"),
            (&small, false, 3, "LU"),
            (&large, false, 3, "BiCGSTAB"),
        ] {
            let mut solver = solver(automatic(symmetric, dimension));
            let b = vector(a.pattern.order(), 1);
            let report = solver.solve(a, &b, &mut vec![0.0; b.len()]).unwrap();
            assert!(report.residual <= 1e-9 && report.note.is_none());
            assert!(solver.name().contains(expected), "{}", solver.name());
        }
    }

    #[test]
    fn fall_backs_are_reported() {
        let mut large = elastic_box(9, 1.0);
        let mut small = random_system(2, 20, true, 1);
        for (a, failed) in [(&mut large, "conjugate gradients"), (&mut small, "Cholesky")] {
            set(a, 7, 7, -5.0);
            let b = vector(a.pattern.order(), 1);
            let report = solver(automatic(true, 3)).solve(a, &b, &mut vec![0.0; b.len()]).unwrap();
            let note = report.note.unwrap();
            assert!(note.contains(failed) && note.contains("solved by sparse L D L^T"), "{note}");
            assert!(note.contains("degree of freedom 7"), "{note}");
            assert!(report.residual < 1e-12);
            assert_eq!(report.negative_pivots, Some(1));
        }
    }
}
