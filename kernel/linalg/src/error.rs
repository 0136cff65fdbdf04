//! What can go wrong in a linear solve.

/// Why a linear system was not solved.
///
/// `dof` is the scalar row in the numbering of the matrix: `dof / block` is the node, `dof % block` the
/// component.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LinearError {
    /// The matrix is singular to working precision.
    #[error(
        "the matrix is singular: degree of freedom {dof} is not held (missing support, or a node without stiffness?)"
    )]
    Singular {
        /// The degree of freedom that takes the greatest part in the null vector found.
        dof: usize,
    },
    /// A method for positive definite matrices met a pivot or a curvature that is not positive.
    #[error("the matrix is not positive definite at degree of freedom {dof}")]
    NotPositiveDefinite {
        /// Row of the pivot, or the row that gives the curvature its most negative part.
        dof: usize,
    },
    /// The iteration stopped above its tolerance.
    #[error("{iterations} iterations left a relative residual of {residual:.3e}; {tolerance:.3e} was asked for")]
    NotConverged {
        /// Iterations done.
        iterations: usize,
        /// True relative residual `||b - A x|| / ||b||` reached.
        residual: f64,
        /// Relative residual asked for.
        tolerance: f64,
    },
    /// A factorisation went through but its solution does not satisfy the system: the matrix is too ill
    /// conditioned, or not symmetric though a symmetric method was asked for.
    #[error("the factorisation left a backward error of {backward_error:.3e}, at degree of freedom {dof}")]
    Inaccurate {
        /// Row with the greatest part in the error.
        dof: usize,
        /// Componentwise backward error `max_i |b - A x|_i / (|A| |x| + |b|)_i` after refinement.
        backward_error: f64,
    },
    /// An entry of the matrix or of the right-hand side is infinite or not a number.
    #[error("an entry in the row of degree of freedom {dof} is not finite")]
    NonFinite {
        /// Row of the first such entry.
        dof: usize,
    },
    /// A vector does not have as many entries as the matrix has scalar rows.
    #[error("a vector has {found} entries where the matrix has {expected} rows")]
    Size {
        /// Scalar rows of the matrix.
        expected: usize,
        /// Entries of the vector.
        found: usize,
    },
    /// The factors do not fit into memory or into 32-bit indices.
    #[error("the factors of the matrix do not fit into memory")]
    OutOfMemory,
}

impl LinearError {
    /// The scalar row that the error is about, if it is about one.
    pub fn dof(&self) -> Option<usize> {
        match self {
            LinearError::Singular { dof }
            | LinearError::NotPositiveDefinite { dof }
            | LinearError::Inaccurate { dof, .. }
            | LinearError::NonFinite { dof } => Some(*dof),
            _ => None,
        }
    }
}
