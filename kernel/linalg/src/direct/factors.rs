//! What the three kinds of factors have in common.

use crate::{BlockMatrix, BlockPattern, LinearError};
use faer::dyn_stack::{MemBuffer, StackReq};
use faer::sparse::FaerError;

/// Factors of a matrix, with memory and analysis to be used again.
pub trait Factorisation: Default + Send {
    /// The method in words, for the log.
    const NAME: &'static str;

    /// Chooses an elimination order and finds the structure of the factors.
    fn analyse(&mut self, pattern: &BlockPattern) -> Result<(), LinearError>;

    /// Computes the factors of a matrix on the analysed pattern.
    fn factorise(&mut self, a: &BlockMatrix) -> Result<(), LinearError>;

    /// Solves in place for `columns` right-hand sides that stand one after the other. Nothing happens
    /// before the first [`Self::factorise`].
    fn solve(&mut self, rhs: &mut [f64], columns: usize) -> Result<(), LinearError>;

    /// Number of negative pivots of the last factorisation, where it says something.
    fn negative_pivots(&self) -> Option<usize> {
        None
    }
}

/// Right-hand sides that are solved together at most: the user's and the probe.
pub const COLUMNS: usize = 2;

/// Compressed sparse columns of scalars.
#[derive(Default)]
pub struct ScalarColumns {
    pub start: Vec<u32>,
    pub rows: Vec<u32>,
    pub values: Vec<f64>,
}

pub fn allocate(request: StackReq) -> Result<MemBuffer, LinearError> {
    MemBuffer::try_new(request).map_err(|_| LinearError::OutOfMemory)
}

/// A vector of zeros.
pub fn zeros(length: usize) -> Result<Vec<f64>, LinearError> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(length).map_err(|_| LinearError::OutOfMemory)?;
    vector.resize(length, 0.0);
    Ok(vector)
}

pub fn out_of_memory(_: FaerError) -> LinearError {
    // The other case, an index overflow, means factors with more than 2^31 entries.
    LinearError::OutOfMemory
}

/// Entries of the scalar columns must be numbered by `u32` with its sign bit free, as faer wants.
pub fn check_size(entries: usize) -> Result<(), LinearError> {
    if entries > i32::MAX as usize { Err(LinearError::OutOfMemory) } else { Ok(()) }
}
