//! The interface of all linear solvers and the choice among them.

use crate::automatic::{Automatic, Chain};
use crate::direct::{Cholesky, Direct, Lu};
use crate::iterative::{BiCgStab, ConjugateGradient, Gmres, IterativeSettings};
use crate::{BlockMatrix, LinearError};

/// What a solve did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SolveReport {
    /// Iterations of an iterative method, `None` for a direct one.
    pub iterations: Option<usize>,
    /// Relative residual `||b - A x|| / ||b||`, computed anew from the returned solution (0 if `b = 0`).
    pub residual: f64,
    /// Componentwise backward error `max_i |b - A x|_i / (|A| |x| + |b|)_i` of a direct method: independent of the
    /// units of rows and columns, about 1e-16 to 1e-13 where all is well.
    pub backward_error: Option<f64>,
    /// Number of negative pivots, i.e. of negative eigenvalues (Sylvester's law of inertia), where an
    /// `L D L^T` factorisation gives it. Not 0 at an unstable equilibrium.
    pub negative_pivots: Option<usize>,
    /// Something the user should read in the log, such as a fall-back to another method.
    pub note: Option<String>,
}

/// Solves `A x = b`; keeps its analysis and memory between calls as long as the pattern is the same `Arc`.
pub trait LinearSolver: Send {
    /// The method in words, for the log.
    fn name(&self) -> String;

    /// Solves `a x = rhs`.
    ///
    /// `x` is overwritten; it is read only by iterative methods with a warm start.
    ///
    /// # Errors
    /// See [`LinearError`]. `x` is then unspecified.
    fn solve(&mut self, a: &BlockMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport, LinearError>;
}

/// What a system is like, so that a fitting method is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Nature {
    /// The matrix is symmetric.
    pub symmetric: bool,
    /// The matrix is positive definite at stable states; not that of a saddle point, such as displacements with, last on
    /// each node, the pressure that constrains them, whose rows have another unit.
    pub definite: bool,
    /// Dimension of the mesh: direct methods stay cheap much longer in 2 dimensions than in 3.
    pub dimension: usize,
}

/// Which linear solver.
#[derive(Debug, Clone, PartialEq)]
pub enum Method {
    /// Sparse `L L^T`, for symmetric positive definite matrices.
    Cholesky,
    /// Sparse `L D L^T`, for symmetric matrices; falls back to [`Method::Lu`] where a pivot is zero or the result
    /// inaccurate.
    Ldlt,
    /// Cholesky, and if the matrix is not positive definite [`Method::Ldlt`]: for matrices that are
    /// definite at stable states only.
    Symmetric,
    /// Sparse LU with threshold pivoting, for any regular matrix, saddle points with a vanishing block among them.
    Lu,
    /// Preconditioned conjugate gradients, for symmetric positive definite matrices.
    ConjugateGradient(IterativeSettings),
    /// Preconditioned BiCGSTAB, for any regular matrix.
    BiCgStab(IterativeSettings),
    /// Preconditioned GMRES on the equilibrated matrix, for any regular matrix; tolerance and reported residual are those
    /// of the equilibrated system.
    Gmres(IterativeSettings),
    /// Chooses by the nature of the system and by its size, and falls back to a direct method on failure.
    Automatic {
        /// What the matrices will be like.
        nature: Nature,
        /// Relative residual asked of iterative methods.
        tolerance: f64,
    },
}

/// Builds the solver for a method.
pub fn solver(method: Method) -> Box<dyn LinearSolver> {
    match method {
        Method::Cholesky => Box::new(Direct::<Cholesky>::default()),
        Method::Ldlt => Box::new(Chain::indefinite()),
        Method::Symmetric => Box::new(Chain::symmetric()),
        Method::Lu => Box::new(Direct::<Lu>::default()),
        Method::ConjugateGradient(settings) => Box::new(ConjugateGradient::new(settings)),
        Method::BiCgStab(settings) => Box::new(BiCgStab::new(settings)),
        Method::Gmres(settings) => Box::new(Gmres::new(settings)),
        Method::Automatic { nature, tolerance } => Box::new(Automatic::new(nature, tolerance)),
    }
}
