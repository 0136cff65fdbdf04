//! What can go wrong when a law answers at one point.

use thiserror::Error;

/// Why a law has no answer at a point. The caller adds step, time, point and position.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum LawError {
    /// The determinant of the deformation gradient is zero or negative: the material is inverted.
    #[error(
        "the determinant of the deformation gradient is {jacobian:e}, and it must be positive: the material is \
         inverted; take a smaller time step or more load steps, and look for too large loads or too soft a material"
    )]
    NonPositiveJacobian {
        /// det F.
        jacobian: f64,
    },
    /// The deformation gradient or the stress is infinite or not a number.
    #[error(
        "the deformation gradient or the stress is not finite: the solution has diverged before; take a smaller time \
         step, and look at the boundary conditions and at the last state that was written"
    )]
    NonFinite,
    /// A local iteration of the law ran out of iterations.
    #[error(
        "{what} did not converge in {iterations} iterations (last correction {correction:e}); take a smaller time \
         step, so that the deformation of one step is smaller"
    )]
    NoConvergence {
        /// The local problem, such as `the thickness stretch of plane stress`.
        what: &'static str,
        /// Iterations done.
        iterations: usize,
        /// Size of the last correction, in the unit of the unknown.
        correction: f64,
    },
    /// The formulation does not give what the law needs, or asks for what the law does not have.
    #[error("the law {problem}; {advice}")]
    Unsuitable {
        /// What is missing, such as `needs the nodal pressure`.
        problem: &'static str,
        /// What to do about it.
        advice: &'static str,
    },
}
