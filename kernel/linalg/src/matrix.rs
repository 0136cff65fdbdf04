//! Values on a block pattern.

use crate::LinearError;
use crate::pattern::BlockPattern;
use rayon::prelude::*;
use std::sync::Arc;

/// Block rows that one task handles.
const ROWS_PER_TASK: usize = 256;
/// Products with fewer blocks than this stay on the calling thread.
const PARALLEL_ENTRIES: usize = 16_384;

/// Calls a function that is generic in the block size with the run-time block size of a pattern.
macro_rules! with_block_size {
    ($block:expr, $function:ident ( $($argument:expr),* $(,)? )) => {
        match $block {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            3 => $function::<3>($($argument),*),
            _ => $function::<4>($($argument),*),
        }
    };
}
pub(crate) use with_block_size;

/// A square matrix of dense `B x B` blocks.
#[derive(Debug, Clone)]
pub struct BlockMatrix {
    /// Where the blocks stand; solvers keep their analysis as long as this stays the same `Arc`.
    pub pattern: Arc<BlockPattern>,
    /// `entries * B * B` values: block after block in the order of the pattern, row-major inside a block.
    pub values: Vec<f64>,
}

impl BlockMatrix {
    /// The zero matrix on `pattern`.
    pub fn new(pattern: Arc<BlockPattern>) -> Self {
        let values = vec![0.0; pattern.entries() * pattern.block() * pattern.block()];
        Self { pattern, values }
    }

    /// Sets all values to zero.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// `y = A x`, each row summed by one thread in the order of its columns.
    ///
    /// # Panics
    /// If `x` or `y` does not have [`BlockPattern::order`] entries.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        assert!(x.len() == self.pattern.order() && y.len() == x.len(), "vector and matrix differ in size");
        with_block_size!(self.pattern.block(), multiply(&self.pattern, &self.values, x, y));
    }

    /// `y = b - A x`.
    pub(crate) fn residual(&self, b: &[f64], x: &[f64], y: &mut [f64]) {
        self.multiply(x, y);
        for (y, b) in y.iter_mut().zip(b) {
            *y = b - *y;
        }
    }

    /// Holds the constrained unknowns at zero: their rows and columns become zero except for the
    /// diagonal, which becomes the mean magnitude of the free diagonal entries (1 if there is none), and
    /// their entries of the right-hand side become zero. Symmetry is kept.
    ///
    /// # Panics
    /// If `constrained` or `rhs` does not have [`BlockPattern::order`] entries.
    pub fn constrain(&mut self, constrained: &[bool], rhs: &mut [f64]) {
        let (pattern, block) = (Arc::clone(&self.pattern), self.pattern.block());
        assert!(
            constrained.len() == pattern.order() && rhs.len() == constrained.len(),
            "mask and matrix differ in size"
        );
        let diagonal = self.mean_diagonal(|dof| !constrained[dof]);
        let touched: Vec<bool> = constrained.chunks_exact(block).map(|node| node.contains(&true)).collect();
        for row in 0..pattern.rows() {
            for entry in pattern.row(row) {
                let column = pattern.columns()[entry] as usize;
                if !(touched[row] || touched[column]) {
                    continue;
                }
                let values = &mut self.values[entry * block * block..(entry + 1) * block * block];
                for (index, value) in values.iter_mut().enumerate() {
                    let (i, j) = (row * block + index / block, column * block + index % block);
                    if constrained[i] || constrained[j] {
                        *value = if i == j { diagonal } else { 0.0 };
                    }
                }
            }
        }
        for (value, _) in rhs.iter_mut().zip(constrained).filter(|(_, constrained)| **constrained) {
            *value = 0.0;
        }
    }

    /// Multiplies every entry of the diagonal by `factor`.
    pub fn scale_diagonal(&mut self, factor: f64) {
        let block = self.pattern.block();
        for &entry in self.pattern.diagonal() {
            let values = &mut self.values[entry as usize * block * block..][..block * block];
            values.iter_mut().step_by(block + 1).for_each(|value| *value *= factor);
        }
    }

    /// Entry (`dof`, `dof`).
    ///
    /// # Panics
    /// If there is no such dof.
    pub fn diagonal_entry(&self, dof: usize) -> f64 {
        let block = self.pattern.block();
        self.values[self.pattern.diagonal()[dof / block] as usize * block * block + dof % block * (block + 1)]
    }

    fn mean_diagonal(&self, counts: impl Fn(usize) -> bool) -> f64 {
        let (mut sum, mut number) = (0.0, 0usize);
        for dof in (0..self.pattern.order()).filter(|&dof| counts(dof)) {
            sum += self.diagonal_entry(dof).abs();
            number += 1;
        }
        if sum > 0.0 { sum / number as f64 } else { 1.0 }
    }

    /// Rejects vectors of the wrong size and entries that are infinite or not a number.
    pub(crate) fn check(&self, rhs: &[f64], x: &[f64]) -> Result<(), LinearError> {
        let expected = self.pattern.order();
        for found in [rhs.len(), x.len()] {
            if found != expected {
                return Err(LinearError::Size { expected, found });
            }
        }
        if let Some(dof) = rhs.iter().position(|value| !value.is_finite()) {
            return Err(LinearError::NonFinite { dof });
        }
        // Without an early exit the scan vectorises.
        if self.values.iter().fold(true, |finite, value| finite & value.is_finite()) {
            return Ok(());
        }
        let block = self.pattern.block();
        let index = self.values.iter().position(|value| !value.is_finite()).unwrap_or(0);
        let entry = index / (block * block);
        let row = self.pattern.row_start().partition_point(|&start| start as usize <= entry) - 1;
        Err(LinearError::NonFinite { dof: row * block + index % (block * block) / block })
    }
}

fn multiply<const B: usize>(pattern: &BlockPattern, values: &[f64], x: &[f64], y: &mut [f64]) {
    let (x, y) = (x.as_chunks::<B>().0, y.as_chunks_mut::<B>().0);
    if pattern.entries() < PARALLEL_ENTRIES {
        return multiply_rows::<B>(pattern, values, x, 0, y);
    }
    y.par_chunks_mut(ROWS_PER_TASK)
        .enumerate()
        .for_each(|(task, y)| multiply_rows::<B>(pattern, values, x, task * ROWS_PER_TASK, y));
}

/// Rows `first..first + y.len()` of the product.
fn multiply_rows<const B: usize>(
    pattern: &BlockPattern,
    values: &[f64],
    x: &[[f64; B]],
    first: usize,
    y: &mut [[f64; B]],
) {
    for (offset, y) in y.iter_mut().enumerate() {
        let entries = pattern.row(first + offset);
        let blocks = blocks_of::<B>(values, entries.clone());
        let mut sum = [0.0; B];
        for (block, &column) in blocks.iter().zip(&pattern.columns()[entries]) {
            add_product(&mut sum, block, &x[column as usize]);
        }
        *y = sum;
    }
}

/// The blocks of a range of entries, as nested arrays.
#[inline(always)]
pub(crate) fn blocks_of<const B: usize>(values: &[f64], entries: std::ops::Range<usize>) -> &[[[f64; B]; B]] {
    values[entries.start * B * B..entries.end * B * B].as_chunks::<B>().0.as_chunks::<B>().0
}

/// `y += block x`.
#[inline(always)]
pub(crate) fn add_product<const B: usize>(y: &mut [f64; B], block: &[[f64; B]; B], x: &[f64; B]) {
    for i in 0..B {
        for j in 0..B {
            y[i] += block[i][j] * x[j];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_systems::{dense, elastic_box, in_pools, random_system, vector};

    #[test]
    fn product_equals_the_dense_one() {
        for block in 1..=4 {
            let matrix = random_system(block, 23, false, 11);
            let x = vector(matrix.pattern.order(), 3);
            let mut y = vec![f64::NAN; x.len()];
            matrix.multiply(&x, &mut y);
            let expected = dense(&matrix) * nalgebra::DVector::from_column_slice(&x);
            for (value, expected) in y.iter().zip(expected.iter()) {
                assert!((value - expected).abs() < 1e-13 * expected.abs().max(1.0));
            }
        }
    }

    #[test]
    fn product_does_not_depend_on_threads() {
        let matrix = elastic_box(12, 4.0);
        assert!(matrix.pattern.entries() > PARALLEL_ENTRIES);
        let x = vector(matrix.pattern.order(), 5);
        let results = in_pools(|| {
            let mut y = vec![0.0; x.len()];
            matrix.multiply(&x, &mut y);
            y.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        });
        assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
    }

    #[test]
    fn constrain_keeps_the_free_system_and_decouples_the_rest() {
        let mut matrix = random_system(3, 15, true, 4);
        let before = dense(&matrix);
        let constrained: Vec<bool> = (0..45).map(|dof| dof % 7 == 0 || dof / 3 == 4).collect();
        let mut rhs = vector(45, 1);
        let rhs_before = rhs.clone();
        matrix.constrain(&constrained, &mut rhs);
        let free = (0..45).filter(|&dof| !constrained[dof]);
        let mean = free.clone().map(|dof| before[(dof, dof)].abs()).sum::<f64>() / free.count() as f64;
        let after = dense(&matrix);
        for i in 0..45 {
            for j in 0..45 {
                let expected = match (constrained[i] || constrained[j], i == j) {
                    (false, _) => before[(i, j)],
                    (true, true) => mean,
                    (true, false) => 0.0,
                };
                assert!((after[(i, j)] - expected).abs() <= 1e-14 * mean);
            }
            assert_eq!(rhs[i], if constrained[i] { 0.0 } else { rhs_before[i] });
        }
    }

    #[test]
    fn constraining_everything_leaves_the_identity() {
        let mut matrix = random_system(2, 3, true, 4);
        matrix.constrain(&[true; 6], &mut [1.0; 6]);
        assert_eq!(dense(&matrix), nalgebra::DMatrix::identity(6, 6));
    }

    #[test]
    fn the_row_of_an_entry_that_is_not_finite_is_named() {
        let mut matrix = random_system(3, 6, true, 9);
        let entry = matrix.pattern.position(4, 4).unwrap() as usize;
        matrix.values[entry * 9 + 3] = f64::NAN;
        assert_eq!(matrix.check(&[0.0; 18], &[0.0; 18]), Err(LinearError::NonFinite { dof: 13 }));
        matrix.values[entry * 9 + 3] = 0.0;
        let mut rhs = [0.0; 18];
        rhs[5] = f64::INFINITY;
        assert_eq!(matrix.check(&rhs, &[0.0; 18]), Err(LinearError::NonFinite { dof: 5 }));
        assert_eq!(matrix.check(&rhs, &[0.0; 3]), Err(LinearError::Size { expected: 18, found: 3 }));
    }
}
