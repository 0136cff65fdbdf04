//! Scalings that bring rows and columns of different units to the same size.

use crate::BlockMatrix;
use crate::matrix::with_block_size;

/// Sweeps over the matrix: each halves the logarithm of what is left to even out.
const SWEEPS: usize = 4;

/// Powers of two `R` and `C` such that rows and columns of `R A C` have greatest entries near 1 (Ruiz 2001); powers of
/// two round nothing.
#[derive(Default)]
pub struct Equilibration {
    pub rows: Vec<f64>,
    pub columns: Vec<f64>,
    greatest: [Vec<f64>; 2],
}

impl Equilibration {
    /// Finds the scalings of `a`.
    pub fn set_up(&mut self, a: &BlockMatrix) {
        let order = a.pattern.order();
        for scales in [&mut self.rows, &mut self.columns] {
            scales.clear();
            scales.resize(order, 1.0);
        }
        for _ in 0..SWEEPS {
            self.greatest.iter_mut().for_each(|greatest| {
                greatest.clear();
                greatest.resize(order, 0.0);
            });
            with_block_size!(a.pattern.block(), find_greatest(a, self));
            for (scales, greatest) in [&mut self.rows, &mut self.columns].into_iter().zip(&self.greatest) {
                for (scale, greatest) in scales.iter_mut().zip(greatest) {
                    *scale *= inverse_root(*greatest);
                }
            }
        }
    }
}

impl Equilibration {
    /// `scaled = R A C`.
    pub fn apply(&self, a: &BlockMatrix, scaled: &mut BlockMatrix) {
        scaled.clone_from(a);
        let block = a.pattern.block();
        for row in 0..a.pattern.rows() {
            for entry in a.pattern.row(row) {
                let column = a.pattern.columns()[entry] as usize;
                let columns = &self.columns[column * block..(column + 1) * block];
                let values = &mut scaled.values[entry * block * block..(entry + 1) * block * block];
                for (values, scale) in values.chunks_exact_mut(block).zip(&self.rows[row * block..]) {
                    for (value, column) in values.iter_mut().zip(columns) {
                        *value *= scale * column;
                    }
                }
            }
        }
    }
}

/// Power of two near `1 / sqrt(value)`; 1 for zero.
fn inverse_root(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() { (-0.5 * value.log2()).round().exp2() } else { 1.0 }
}

/// Greatest magnitude in each row and column of `R A C`.
fn find_greatest<const B: usize>(a: &BlockMatrix, scaling: &mut Equilibration) {
    let Equilibration { rows, columns, greatest: [row_greatest, column_greatest] } = scaling;
    let rows = rows.as_chunks::<B>().0;
    let columns = columns.as_chunks::<B>().0;
    let row_greatest = row_greatest.as_chunks_mut::<B>().0;
    let column_greatest = column_greatest.as_chunks_mut::<B>().0;
    for (row, row_greatest) in row_greatest.iter_mut().enumerate() {
        let entries = a.pattern.row(row);
        let blocks = crate::matrix::blocks_of::<B>(&a.values, entries.clone());
        for (block, &column) in blocks.iter().zip(&a.pattern.columns()[entries]) {
            let column = column as usize;
            for i in 0..B {
                for j in 0..B {
                    let value = (block[i][j] * rows[row][i] * columns[column][j]).abs();
                    row_greatest[i] = row_greatest[i].max(value);
                    column_greatest[column][j] = column_greatest[column][j].max(value);
                }
            }
        }
    }
}
