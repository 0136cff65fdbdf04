//! Scalings that bring rows and columns of different units to the same size.

use crate::BlockMatrix;
use crate::matrix::with_block_size;

/// Sweeps over the matrix at most: each halves the logarithm of what is left to even out.
const SWEEPS: usize = 8;

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
            let mut even = true;
            for (scales, greatest) in [&mut self.rows, &mut self.columns].into_iter().zip(&self.greatest) {
                for (scale, greatest) in scales.iter_mut().zip(greatest) {
                    let factor = inverse_root(*greatest);
                    even &= factor == 1.0;
                    *scale *= factor;
                }
            }
            if even {
                break;
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

/// Power of two near `1 / sqrt(value)`; 1 for zero and for numbers below the normal ones.
fn inverse_root(value: f64) -> f64 {
    const BIAS: i64 = 1023;
    const FRACTION: u32 = f64::MANTISSA_DIGITS - 1;
    if !value.is_normal() {
        return 1.0;
    }
    let exponent = (value.to_bits() >> FRACTION) as i64 - BIAS;
    f64::from_bits(((BIAS - exponent / 2) as u64) << FRACTION)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_systems::{MixedBox, dense};

    #[test]
    fn rows_and_columns_become_alike_and_nothing_is_rounded() {
        let (a, _) = MixedBox { shear: 1e9, cut: 1e-6, skew: 0.1, ..MixedBox::new(2, 6) }.system();
        let mut scaling = Equilibration::default();
        scaling.set_up(&a);
        let mut scaled = a.clone();
        scaling.apply(&a, &mut scaled);
        let (before, after) = (dense(&a), dense(&scaled));
        for i in 0..before.nrows() {
            for greatest in [after.row(i).abs().max(), after.column(i).abs().max()] {
                assert!((0.25..4.0).contains(&greatest), "{greatest}");
            }
            for j in 0..before.ncols() {
                assert_eq!(after[(i, j)] / scaling.rows[i] / scaling.columns[j], before[(i, j)]);
            }
        }
    }

    #[test]
    fn powers_of_two_are_near_the_inverse_roots() {
        for value in [1e-300, 3e-20, 0.3, 1.0, 1.9, 7.0, 1e9, 1e300] {
            let product = inverse_root(value) * inverse_root(value) * value;
            assert!((0.5..4.0).contains(&product), "{value}: {product}");
        }
        assert_eq!((inverse_root(0.0), inverse_root(4.0)), (1.0, 0.5));
    }
}
