//! Partial elimination of a dense matrix, with threshold pivoting.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::ops::Range;

/// A pivot is at least this part of the greatest entry of its column.
const THRESHOLD: f64 = 0.1;
/// Columns eliminated before all others are brought up to date.
const BLOCK: usize = 128;
/// Columns eliminated before the others of their block are brought up to date.
const PANEL: usize = 16;
/// Columns brought up to date by one task.
const COLUMNS_PER_TASK: usize = 128;
/// Updates of fewer entries stay on the calling thread.
const PARALLEL_ENTRIES: usize = 1 << 16;
/// Magnitudes up to this count as zero (entries are about 1 after equilibration).
const ZERO: f64 = 1e-100;
/// What takes the place of a pivot where the rest of the matrix is zero: solutions then show the null vector.
const SUBSTITUTE: f64 = 1e-40;

/// A square matrix, column after column, whose first `summed` rows and columns will not receive further
/// contributions.
#[derive(Default)]
pub struct Front {
    pub values: Vec<f64>,
    /// Variable of each row.
    pub rows: Vec<u32>,
    /// Variable of each column.
    pub columns: Vec<u32>,
    pub summed: usize,
}

impl Front {
    pub fn size(&self) -> usize {
        self.rows.len()
    }

    /// Eliminates as many of the fully summed variables as have acceptable pivots and returns their number `k`.
    ///
    /// Rows and columns are exchanged so that the pivots come first. Then the first `k` columns hold `L` (its diagonal
    /// is 1) below and `U` on and above the diagonal, the first `k` rows the rest of `U`, and the other entries the
    /// Schur complement.
    pub fn eliminate(&mut self) -> usize {
        let (size, summed) = (self.size(), self.summed);
        let (mut done, mut tail, mut before) = (0, summed, 0);
        while done < tail {
            let end = tail.min(done + BLOCK);
            let (last, exchanges) = self.block(done, end);
            self.exchange_rows(0..done, done, &exchanges);
            self.update(done..last, end..size, &exchanges);
            tail = self.put_off(last..end, tail);
            done = last;
            if done == tail && done > before {
                // Later pivots may have made the refused columns acceptable.
                (before, tail) = (done, summed);
            }
        }
        if size == summed {
            for pivot in done..size {
                self.values[pivot * size + pivot] = SUBSTITUTE;
            }
            done = size;
        }
        done
    }

    /// Eliminates within columns `begin..end`; returns the end of the accepted ones, which come first, and for each the
    /// row exchanged with it, in these columns only.
    fn block(&mut self, begin: usize, end: usize) -> (usize, Vec<usize>) {
        let (mut done, mut tail) = (begin, end);
        let mut exchanges = Vec::with_capacity(end - begin);
        while done < tail {
            let panel_end = tail.min(done + PANEL);
            let known = exchanges.len();
            let last = self.panel(done, panel_end, &mut exchanges);
            self.exchange_rows(begin..done, done, &exchanges[known..]);
            self.update(done..last, panel_end..end, &exchanges[known..]);
            tail = self.put_off(last..panel_end, tail);
            done = last;
        }
        (done, exchanges)
    }

    /// Exchanges refused columns with the last candidates before `tail`; returns the new end of the candidates.
    fn put_off(&mut self, refused: Range<usize>, mut tail: usize) -> usize {
        for column in refused.rev() {
            tail -= 1;
            self.exchange_columns(column, tail);
        }
        tail
    }

    /// The same column by column.
    fn panel(&mut self, begin: usize, end: usize, exchanges: &mut Vec<usize>) -> usize {
        let (size, summed) = (self.size(), self.summed);
        let (mut column, mut last) = (begin, end);
        while column < last {
            let values = &self.values[column * size..(column + 1) * size];
            let (row, pivot) = greatest(&values[column..summed]);
            let bound = values[summed..].iter().fold(0.0, |bound: f64, value| bound.max(value.abs()));
            if pivot.is_nan() || pivot <= ZERO || pivot < THRESHOLD * bound {
                last -= 1;
                self.exchange_columns(column, last);
                continue;
            }
            let row = column + row;
            exchanges.push(row);
            self.rows.swap(column, row);
            if row != column {
                for values in self.values[begin * size..end * size].chunks_exact_mut(size) {
                    values.swap(column, row);
                }
            }
            let (left, right) = self.values[..end * size].split_at_mut((column + 1) * size);
            let factor = &mut left[column * size + column..];
            let reciprocal = 1.0 / factor[0];
            pulp::Arch::new().dispatch(|| eliminate_column(&mut factor[1..], reciprocal, right, size, column));
            column += 1;
        }
        last
    }

    fn exchange_columns(&mut self, i: usize, j: usize) {
        if i == j {
            return;
        }
        let size = self.size();
        let (left, right) = self.values.split_at_mut(i.max(j) * size);
        left[i.min(j) * size..][..size].swap_with_slice(&mut right[..size]);
        self.columns.swap(i, j);
    }

    fn exchange_rows(&mut self, columns: Range<usize>, first: usize, exchanges: &[usize]) {
        let size = self.size();
        for column in self.values[columns.start * size..columns.end * size].chunks_exact_mut(size) {
            exchange(column, first, exchanges);
        }
    }

    /// Brings `columns` up to date after `pivots` to the left of them were found.
    fn update(&mut self, pivots: Range<usize>, columns: Range<usize>, exchanges: &[usize]) {
        let size = self.size();
        if pivots.is_empty() || columns.is_empty() {
            return;
        }
        let (left, right) = self.values[..columns.end * size].split_at_mut(columns.start * size);
        let factors =
            MatRef::from_column_major_slice(&left[pivots.start * size..pivots.end * size], size, pivots.len());
        let (square, below) = factors.subrows(pivots.start, size - pivots.start).split_at_row(pivots.len());
        let work = |columns: &mut [f64]| {
            columns.chunks_exact_mut(size).for_each(|column| exchange(column, pivots.start, exchanges));
            let count = columns.len() / size;
            let columns = MatMut::from_column_major_slice_mut(columns, size, count);
            let (mut across, rest) =
                columns.subrows_mut(pivots.start, size - pivots.start).split_at_row_mut(pivots.len());
            solve_unit_lower_triangular_in_place(square, across.rb_mut(), Par::Seq);
            matmul(rest, Accum::Add, below, across.rb(), -1.0, Par::Seq);
        };
        // The cut is the same for any number of threads.
        let length = COLUMNS_PER_TASK * size;
        if right.len() < PARALLEL_ENTRIES {
            right.chunks_mut(length).for_each(work);
        } else {
            right.par_chunks_mut(length).for_each(work);
        }
    }
}

fn exchange(column: &mut [f64], first: usize, exchanges: &[usize]) {
    for (offset, &row) in exchanges.iter().enumerate() {
        column.swap(first + offset, row);
    }
}

/// Place and magnitude of the greatest magnitude, the first among equals.
fn greatest(values: &[f64]) -> (usize, f64) {
    let mut best = (0, 0.0);
    for (index, value) in values.iter().enumerate() {
        if value.abs() > best.1 {
            best = (index, value.abs());
        }
    }
    best
}

/// Divides the column below a pivot and subtracts its products from the columns to the right.
#[inline(always)]
fn eliminate_column(factor: &mut [f64], reciprocal: f64, right: &mut [f64], size: usize, pivot: usize) {
    for value in factor.iter_mut() {
        *value *= reciprocal;
    }
    for column in right.chunks_exact_mut(size) {
        let across = column[pivot];
        if across != 0.0 {
            for (value, factor) in column[pivot + 1..].iter_mut().zip(factor.iter()) {
                *value -= factor * across;
            }
        }
    }
}
