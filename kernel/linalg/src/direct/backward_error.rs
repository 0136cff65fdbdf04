//! How far a solution is from the solution of a system with slightly other entries.

use crate::BlockMatrix;
use crate::matrix::{blocks_of, with_block_size};

/// Part of the greatest magnitude of a component that each of its unknowns is taken to have at least.
const FLOOR: f64 = 1e-3;

/// A backward error and the row that has it.
#[derive(Debug, Clone, Copy)]
pub struct BackwardError {
    pub value: f64,
    pub dof: usize,
}

/// Memory for magnitudes of a solution.
#[derive(Default)]
pub struct Magnitudes(Vec<f64>);

impl Magnitudes {
    /// `max_i |r_i| / (|A| |x| + |b|)_i`, the componentwise backward error (Oettli and Prager 1964), which does not
    /// depend on the scaling (the units) of rows and columns.
    ///
    /// Entries of `|x|` far below the greatest of their component (displacement, pressure) are raised, so that parts of
    /// a body that are at rest but for rounding are not taken at their word.
    pub fn backward_error(&mut self, a: &BlockMatrix, b: &[f64], x: &[f64], residual: &[f64]) -> BackwardError {
        let block = a.pattern.block();
        let mut greatest = [0.0f64; 4];
        for node in x.chunks_exact(block) {
            for (greatest, value) in greatest.iter_mut().zip(node) {
                *greatest = greatest.max(value.abs());
            }
        }
        self.0.clear();
        self.0.extend(x.iter().enumerate().map(|(dof, value)| value.abs().max(FLOOR * greatest[dof % block])));
        with_block_size!(block, greatest_ratio(a, b, &self.0, residual))
    }
}

fn greatest_ratio<const B: usize>(a: &BlockMatrix, b: &[f64], magnitudes: &[f64], residual: &[f64]) -> BackwardError {
    let magnitudes = magnitudes.as_chunks::<B>().0;
    let mut worst = BackwardError { value: 0.0, dof: 0 };
    for row in 0..a.pattern.rows() {
        let entries = a.pattern.row(row);
        let mut sum: [f64; B] = std::array::from_fn(|i| b[row * B + i].abs());
        for (block, &column) in blocks_of::<B>(&a.values, entries.clone()).iter().zip(&a.pattern.columns()[entries]) {
            for (sum, values) in sum.iter_mut().zip(block) {
                for (value, magnitude) in values.iter().zip(&magnitudes[column as usize]) {
                    *sum += value.abs() * magnitude;
                }
            }
        }
        for (i, &sum) in sum.iter().enumerate() {
            let residual = residual[row * B + i].abs();
            // A residual that is not a number is the worst of all.
            if residual > worst.value * sum || residual.is_nan() {
                let value = residual / sum;
                worst = BackwardError { value: if value.is_nan() { f64::INFINITY } else { value }, dof: row * B + i };
            }
        }
    }
    worst
}
