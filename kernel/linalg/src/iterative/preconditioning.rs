//! Set-up and use of preconditioners.

use super::Preconditioner;
use super::block::{self, Block};
use super::incomplete::Incomplete;
use crate::matrix::{blocks_of, with_block_size};
use crate::{BlockMatrix, LinearError};
use rayon::prelude::*;

/// Block rows that one task handles.
const ROWS_PER_TASK: usize = 1024;

/// What is known of the matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Definiteness {
    /// Symmetric positive definite; the preconditioner must be so too.
    Positive,
    /// Nothing.
    Unknown,
}

/// A preconditioner with its memory.
pub struct Preconditioning {
    kind: Preconditioner,
    definiteness: Definiteness,
    inverse_diagonal: Vec<f64>,
    incomplete: Incomplete,
}

impl Preconditioning {
    pub fn new(kind: Preconditioner, definiteness: Definiteness) -> Self {
        Self { kind, definiteness, inverse_diagonal: Vec::new(), incomplete: Incomplete::default() }
    }

    /// Prepares `M^-1` for `a`.
    ///
    /// # Errors
    /// [`LinearError::NotPositiveDefinite`] if a diagonal block shows that `a` is not, though it should be.
    pub fn set_up(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        match self.kind {
            Preconditioner::BlockJacobi => {
                let block = a.pattern.block();
                self.inverse_diagonal.resize(a.pattern.order() * block, 0.0);
                with_block_size!(block, invert_diagonal(a, self.definiteness, &mut self.inverse_diagonal))
            }
            kind => self.incomplete.set_up(a, kind, self.definiteness),
        }
    }

    /// `z = M^-1 r`.
    pub fn apply(&self, a: &BlockMatrix, r: &[f64], z: &mut [f64]) {
        match self.kind {
            Preconditioner::BlockJacobi => {
                with_block_size!(a.pattern.block(), apply_diagonal(&self.inverse_diagonal, r, z));
            }
            _ => self.incomplete.apply(a, r, z),
        }
    }
}

/// Inverse of a diagonal block that may have been modified by an incomplete elimination.
///
/// Where the elimination spoilt the block, its original takes its place: any (positive) block gives a valid
/// preconditioner. A singular original of a matrix that need not be positive is left unpreconditioned.
pub fn invert_or_restore<const B: usize>(
    modified: &Block<B>,
    original: &Block<B>,
    definiteness: Definiteness,
    row: usize,
) -> Result<Block<B>, LinearError> {
    match definiteness {
        Definiteness::Positive => block::invert_positive(modified)
            .or_else(|_| block::invert_positive(original))
            .map_err(|component| LinearError::NotPositiveDefinite { dof: row * B + component }),
        Definiteness::Unknown => {
            Ok(block::invert(modified).or_else(|| block::invert(original)).unwrap_or_else(identity))
        }
    }
}

fn identity<const B: usize>() -> Block<B> {
    let mut block = [[0.0; B]; B];
    (0..B).for_each(|i| block[i][i] = 1.0);
    block
}

fn invert_diagonal<const B: usize>(
    a: &BlockMatrix,
    definiteness: Definiteness,
    inverse: &mut [f64],
) -> Result<(), LinearError> {
    let blocks = blocks_of::<B>(&a.values, 0..a.pattern.entries());
    let inverse = inverse.as_chunks_mut::<B>().0.as_chunks_mut::<B>().0;
    for (row, inverse) in inverse.iter_mut().enumerate() {
        let original = &blocks[a.pattern.diagonal()[row] as usize];
        *inverse = invert_or_restore(original, original, definiteness, row)?;
    }
    Ok(())
}

fn apply_diagonal<const B: usize>(inverse: &[f64], r: &[f64], z: &mut [f64]) {
    let (r, z) = (r.as_chunks::<B>().0, z.as_chunks_mut::<B>().0);
    let inverse = blocks_of::<B>(inverse, 0..r.len());
    let rows = |inverse: &[Block<B>], r: &[[f64; B]], z: &mut [[f64; B]]| {
        for ((inverse, r), z) in inverse.iter().zip(r).zip(z) {
            *z = block::apply(inverse, r);
        }
    };
    if r.len() < 16 * ROWS_PER_TASK {
        return rows(inverse, r, z);
    }
    z.par_chunks_mut(ROWS_PER_TASK)
        .zip(r.par_chunks(ROWS_PER_TASK))
        .zip(inverse.par_chunks(ROWS_PER_TASK))
        .for_each(|((z, r), inverse)| rows(inverse, r, z));
}
