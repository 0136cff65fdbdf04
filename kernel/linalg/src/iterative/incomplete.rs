//! Incomplete block factorisations without fill-in.

use super::Preconditioner;
use super::block::{Block, apply, product, subtract_product};
use super::preconditioning::{Definiteness, invert_or_restore};
use crate::matrix::{add_product, blocks_of, with_block_size};
use crate::{BlockMatrix, BlockPattern, LinearError};
use std::ops::Range;
use std::sync::Arc;

/// Factors of either kind, `M = (E + L) E^-1 (E + U)`.
#[derive(Default)]
pub struct Incomplete {
    structure: Option<Structure>,
    inverse_diagonal: Vec<f64>,
    /// ILU(0): `L E^-1` below and `U` above the diagonal, on the pattern of the matrix. Empty for D-ILU, whose `L` and
    /// `U` are those of the matrix.
    factor: Vec<f64>,
}

/// What is derived from a pattern.
struct Structure {
    pattern: Arc<BlockPattern>,
    transposed: Vec<u32>,
}

impl Structure {
    fn lower(&self, row: usize) -> Range<usize> {
        self.pattern.row(row).start..self.pattern.diagonal()[row] as usize
    }

    fn upper(&self, row: usize) -> Range<usize> {
        self.pattern.diagonal()[row] as usize + 1..self.pattern.row(row).end
    }

    fn column(&self, entry: usize) -> usize {
        self.pattern.columns()[entry] as usize
    }
}

impl Incomplete {
    pub fn set_up(
        &mut self,
        a: &BlockMatrix,
        kind: Preconditioner,
        definiteness: Definiteness,
    ) -> Result<(), LinearError> {
        let Self { structure, inverse_diagonal, factor } = self;
        if structure.as_ref().is_some_and(|structure| !Arc::ptr_eq(&structure.pattern, &a.pattern)) {
            *structure = None;
        }
        let structure = structure.get_or_insert_with(|| Structure {
            pattern: Arc::clone(&a.pattern),
            transposed: a.pattern.transposed_positions(),
        });
        let block = a.pattern.block();
        inverse_diagonal.resize(a.pattern.order() * block, 0.0);
        if kind == Preconditioner::Incomplete {
            factor.clone_from(&a.values);
            with_block_size!(block, factorise(structure, a, factor, inverse_diagonal, definiteness))
        } else {
            factor.clear();
            with_block_size!(block, modify_diagonal(structure, a, inverse_diagonal, definiteness))
        }
    }

    /// `z = M^-1 r`; before the first set-up `z` is left alone.
    pub fn apply(&self, a: &BlockMatrix, r: &[f64], z: &mut [f64]) {
        let Some(structure) = &self.structure else { return };
        let block = a.pattern.block();
        let inverse = &self.inverse_diagonal;
        if self.factor.is_empty() {
            with_block_size!(block, sweep_matrix(structure, &a.values, inverse, r, z));
        } else {
            with_block_size!(block, sweep_factor(structure, &self.factor, inverse, r, z));
        }
    }
}

/// D-ILU: `E_i = A_ii - sum_{k < i} A_ik E_k^-1 A_ki`.
fn modify_diagonal<const B: usize>(
    structure: &Structure,
    a: &BlockMatrix,
    inverse: &mut [f64],
    definiteness: Definiteness,
) -> Result<(), LinearError> {
    let blocks = blocks_of::<B>(&a.values, 0..a.pattern.entries());
    let inverse = inverse.as_chunks_mut::<B>().0.as_chunks_mut::<B>().0;
    for row in 0..inverse.len() {
        let original = &blocks[a.pattern.diagonal()[row] as usize];
        let mut diagonal = *original;
        for entry in structure.lower(row) {
            let across = &blocks[structure.transposed[entry] as usize];
            subtract_product(&mut diagonal, &product(&blocks[entry], &inverse[structure.column(entry)]), across);
        }
        inverse[row] = invert_or_restore(&diagonal, original, definiteness, row)?;
    }
    Ok(())
}

/// ILU(0): row by row, products that fall outside the pattern are dropped.
fn factorise<const B: usize>(
    structure: &Structure,
    a: &BlockMatrix,
    factor: &mut [f64],
    inverse: &mut [f64],
    definiteness: Definiteness,
) -> Result<(), LinearError> {
    const ABSENT: u32 = u32::MAX;
    let originals = blocks_of::<B>(&a.values, 0..a.pattern.entries());
    let factor = factor.as_chunks_mut::<B>().0.as_chunks_mut::<B>().0;
    let inverse = inverse.as_chunks_mut::<B>().0.as_chunks_mut::<B>().0;
    let mut entry_of_column = vec![ABSENT; a.pattern.rows()];
    for row in 0..a.pattern.rows() {
        let diagonal = a.pattern.diagonal()[row] as usize;
        for entry in a.pattern.row(row) {
            entry_of_column[structure.column(entry)] = entry as u32;
        }
        for entry in structure.lower(row) {
            let column = structure.column(entry);
            let multiplier: Block<B> = product(&factor[entry], &inverse[column]);
            factor[entry] = multiplier;
            for above in structure.upper(column) {
                let target = entry_of_column[structure.column(above)];
                if target != ABSENT {
                    let above = factor[above];
                    subtract_product(&mut factor[target as usize], &multiplier, &above);
                }
            }
        }
        for entry in a.pattern.row(row) {
            entry_of_column[structure.column(entry)] = ABSENT;
        }
        inverse[row] = invert_or_restore(&factor[diagonal], &originals[diagonal], definiteness, row)?;
    }
    Ok(())
}

/// Solves `(E + L) E^-1 (E + U) z = r`; `L` and `U` are parts of `values`.
fn sweep_matrix<const B: usize>(structure: &Structure, values: &[f64], inverse: &[f64], r: &[f64], z: &mut [f64]) {
    let (r, z) = (r.as_chunks::<B>().0, z.as_chunks_mut::<B>().0);
    let inverse = blocks_of::<B>(inverse, 0..r.len());
    for row in 0..r.len() {
        let sum = lower_product(structure, values, row, z);
        z[row] = apply(&inverse[row], &subtract(&r[row], &sum));
    }
    for row in (0..r.len()).rev() {
        let sum = upper_product(structure, values, row, z);
        z[row] = subtract(&z[row], &apply(&inverse[row], &sum));
    }
}

/// Solves `(I + L E^-1) (E + U) z = r`; `L E^-1` and `U` are stored in `factor`.
fn sweep_factor<const B: usize>(structure: &Structure, factor: &[f64], inverse: &[f64], r: &[f64], z: &mut [f64]) {
    let (r, z) = (r.as_chunks::<B>().0, z.as_chunks_mut::<B>().0);
    let inverse = blocks_of::<B>(inverse, 0..r.len());
    for row in 0..r.len() {
        let sum = lower_product(structure, factor, row, z);
        z[row] = subtract(&r[row], &sum);
    }
    for row in (0..r.len()).rev() {
        let sum = upper_product(structure, factor, row, z);
        z[row] = apply(&inverse[row], &subtract(&z[row], &sum));
    }
}

/// Sum of the blocks below the diagonal times `z`.
///
/// In both sweeps the row computed last comes last, so that the processor need not wait for it before the other
/// products.
#[inline(always)]
fn lower_product<const B: usize>(structure: &Structure, values: &[f64], row: usize, z: &[[f64; B]]) -> [f64; B] {
    let entries = structure.lower(row);
    let columns = &structure.pattern.columns()[entries.clone()];
    let mut sum = [0.0; B];
    for (block, &column) in blocks_of::<B>(values, entries).iter().zip(columns) {
        add_product(&mut sum, block, &z[column as usize]);
    }
    sum
}

/// Sum of the blocks above the diagonal times `z`.
#[inline(always)]
fn upper_product<const B: usize>(structure: &Structure, values: &[f64], row: usize, z: &[[f64; B]]) -> [f64; B] {
    let entries = structure.upper(row);
    let columns = &structure.pattern.columns()[entries.clone()];
    let mut sum = [0.0; B];
    for (block, &column) in blocks_of::<B>(values, entries).iter().zip(columns).rev() {
        add_product(&mut sum, block, &z[column as usize]);
    }
    sum
}

#[inline(always)]
fn subtract<const B: usize>(x: &[f64; B], y: &[f64; B]) -> [f64; B] {
    std::array::from_fn(|i| x[i] - y[i])
}
