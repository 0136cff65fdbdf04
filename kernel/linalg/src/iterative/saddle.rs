//! A block-triangular preconditioner of displacement-pressure systems.

use super::Preconditioner;
use super::incomplete::Incomplete;
use super::preconditioning::Definiteness;
use crate::matrix::with_block_size;
use crate::{BlockMatrix, BlockPattern, LinearError};
use std::sync::Arc;

/// `M = [K B^T; 0 -S]` with incomplete factors of `K` and `S`.
#[derive(Default)]
pub struct BlockTriangle {
    parts: Option<Parts>,
}

struct Parts {
    pattern: Arc<BlockPattern>,
    transposed: Vec<u32>,
    stiffness: BlockMatrix,
    stiffness_factors: Incomplete,
    schur: BlockMatrix,
    schur_factors: Incomplete,
    /// Entries of `B^T`, `dimension` for each entry of the pattern.
    gradient: Vec<f64>,
    /// Entries of `B'`, likewise.
    divergence: Vec<f64>,
    right: [Vec<f64>; 2],
    left: [Vec<f64>; 2],
}

impl Parts {
    fn new(pattern: &Arc<BlockPattern>) -> Self {
        let dimension = pattern.block() - 1;
        let part = |block| BlockMatrix::new(Arc::new(pattern.with_block(block)));
        let (stiffness, schur) = (part(dimension), part(1));
        let vectors = || [vec![0.0; stiffness.pattern.order()], vec![0.0; schur.pattern.order()]];
        let (right, left) = (vectors(), vectors());
        let coupling = vec![0.0; pattern.entries() * dimension];
        Self {
            pattern: Arc::clone(pattern),
            transposed: pattern.transposed_positions(),
            stiffness,
            stiffness_factors: Incomplete::default(),
            schur,
            schur_factors: Incomplete::default(),
            gradient: coupling.clone(),
            divergence: coupling,
            right,
            left,
        }
    }
}

impl BlockTriangle {
    pub fn set_up(&mut self, a: &BlockMatrix) -> Result<(), LinearError> {
        let kept = self.parts.take().filter(|parts| Arc::ptr_eq(&parts.pattern, &a.pattern));
        let parts = self.parts.insert(kept.unwrap_or_else(|| Parts::new(&a.pattern)));
        parts.split(a);
        parts.add_schur();
        let kind = std::env::var("K_KIND").map_or(Preconditioner::Incomplete, |_| Preconditioner::DiagonalIncomplete);
        parts.stiffness_factors.set_up(&parts.stiffness, kind, Definiteness::Unknown)?;
        parts.schur_factors.set_up(&parts.schur, Preconditioner::Incomplete, Definiteness::Unknown)
    }

    /// `z = M^-1 r`; before the first set-up `z` is left alone.
    pub fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let Some(parts) = &mut self.parts else { return };
        let block = parts.pattern.block();
        let dimension = block - 1;
        let ([right_u, right_p], [left_u, left_p]) = (&mut parts.right, &mut parts.left);
        for ((r, u), p) in r.chunks_exact(block).zip(right_u.chunks_exact_mut(dimension)).zip(right_p.iter_mut()) {
            u.copy_from_slice(&r[..dimension]);
            *p = -r[dimension];
        }
        parts.schur_factors.apply(&parts.schur, right_p, left_p);
        for row in 0..parts.pattern.rows() {
            for entry in parts.pattern.row(row) {
                let pressure = left_p[parts.pattern.columns()[entry] as usize];
                let gradient = &parts.gradient[entry * dimension..(entry + 1) * dimension];
                for (u, gradient) in right_u[row * dimension..].iter_mut().zip(gradient) {
                    *u -= gradient * pressure;
                }
            }
        }
        parts.stiffness_factors.apply(&parts.stiffness, right_u, left_u);
        for ((z, u), p) in z.chunks_exact_mut(block).zip(left_u.chunks_exact(dimension)).zip(left_p.iter()) {
            z[..dimension].copy_from_slice(u);
            z[dimension] = *p;
        }
    }
}

impl Parts {
    /// Takes the blocks of `a` apart.
    fn split(&mut self, a: &BlockMatrix) {
        let block = self.pattern.block();
        let d = block - 1;
        for (entry, values) in a.values.chunks_exact(block * block).enumerate() {
            for i in 0..d {
                let row = &values[i * block..(i + 1) * block];
                self.stiffness.values[(entry * d + i) * d..(entry * d + i + 1) * d].copy_from_slice(&row[..d]);
                self.gradient[entry * d + i] = row[d];
            }
            self.divergence[entry * d..(entry + 1) * d].copy_from_slice(&values[d * block..d * block + d]);
            self.schur.values[entry] = -values[block * block - 1];
        }
    }

    /// Adds `B' diag(K)^-1 B^T`.
    fn add_schur(&mut self) {
        let d = self.pattern.block() - 1;
        let mode = std::env::var("S_MODE").unwrap_or("full".into());
        const ABSENT: u32 = u32::MAX;
        let mut entry_of_column = vec![ABSENT; self.pattern.rows()];
        for row in 0..self.pattern.rows() {
            for entry in self.pattern.row(row) {
                entry_of_column[self.pattern.columns()[entry] as usize] = entry as u32;
            }
            let own = self.pattern.diagonal()[row] as usize;
            for entry in self.pattern.row(row) {
                let middle = self.pattern.columns()[entry] as usize;
                let diagonal = self.pattern.diagonal()[middle] as usize;
                let weighted: Vec<f64> = (0..d)
                    .map(|i| self.divergence[entry * d + i] / self.stiffness.values[(diagonal * d + i) * d + i])
                    .collect();
                for other in self.pattern.row(middle) {
                    let column = self.pattern.columns()[other] as usize;
                    let value: f64 = (0..d).map(|i| weighted[i] * self.gradient[other * d + i]).sum();
                    let target = entry_of_column[column];
                    match &*mode {
                        "full" if target != ABSENT => self.schur.values[target as usize] += value,
                        "lump" => self.schur.values[if target != ABSENT { target as usize } else { own }] += value,
                        "diag" if column == row => self.schur.values[own] += value,
                        "abs" => self.schur.values[own] += value.abs(),
                        _ => {}
                    }
                }
            }
            for entry in self.pattern.row(row) {
                entry_of_column[self.pattern.columns()[entry] as usize] = ABSENT;
            }
        }
        let _ = &self.transposed;
    }
}
