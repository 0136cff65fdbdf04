//! Tells whether a matrix is singular to working precision, and which unknown is loose.

use super::Lu;
use super::factors::Factorisation;
use crate::vector::position_of_greatest;
use crate::{BlockMatrix, LinearError};

/// Growth above which a matrix counts as singular: fewer than about three digits of a solution are right.
const SINGULAR_GROWTH: f64 = 1e13;
/// Relative shift of the diagonal that makes an exactly singular matrix regular.
const SHIFT: f64 = 1e-10;

/// A second right-hand side, solved along with the user's, whose solution shows a null vector.
///
/// `e_i = s_i sum_j |a_ij|` with scattered `1/2 <= |s_i| <= 1` excites every null vector, accidents excepted. With
/// `z = A^-1 e`, the growth `max_i (|A| |z|)_i / sum_j |a_ij|` is a lower bound of Skeel's condition number
/// `|| |A| |A^-1| ||` of the row-scaled matrix (1979), which does not depend on the scaling (the units) of rows and
/// columns. A singular system whose own right-hand side happens to be consistent is found out just as well.
pub struct Probe {
    row_sums: Vec<f64>,
}

impl Probe {
    /// Sums the rows of `a`; an empty row is an error here already.
    pub fn new(a: &BlockMatrix) -> Result<Self, LinearError> {
        let mut row_sums = vec![0.0; a.pattern.order()];
        for_each_entry(a, |row, _, value| row_sums[row] += value.abs());
        match row_sums.iter().position(|&sum| sum == 0.0) {
            Some(dof) => Err(LinearError::Singular { dof }),
            None => Ok(Self { row_sums }),
        }
    }

    /// Appends the right-hand side to `work`.
    pub fn append_to(&self, work: &mut Vec<f64>) {
        // A multiplicative hash gives factors without a pattern that a mesh might share: equal ones would miss, say,
        // the null vector (1, -1).
        let factor = |row: usize| {
            let hash = (row as u32 + 1).wrapping_mul(2_654_435_769);
            let magnitude = 0.5 + 0.5 * f64::from(hash << 1) / f64::from(u32::MAX);
            if hash >> 31 == 0 { magnitude } else { -magnitude }
        };
        work.extend(self.row_sums.iter().enumerate().map(|(row, sum)| factor(row) * sum));
    }

    /// Judges `solution`, which belongs to the right-hand side of [`Self::append_to`].
    pub fn judge(&self, a: &BlockMatrix, solution: &[f64]) -> Result<(), LinearError> {
        if solution.iter().all(|value| value.is_finite()) {
            let mut growth = vec![0.0; solution.len()];
            for_each_entry(a, |row, column, value| growth[row] += (value * solution[column]).abs());
            let greatest = growth.iter().zip(&self.row_sums).map(|(growth, sum)| growth / sum).fold(0.0, f64::max);
            if greatest <= SINGULAR_GROWTH {
                return Ok(());
            }
            return Err(LinearError::Singular { dof: self.loosest(a, solution) });
        }
        Err(LinearError::Singular { dof: self.loosest(a, &self.shifted_solution(a)?) })
    }

    /// The unknown with the greatest part in `null_vector`, measured in the scale of its column.
    fn loosest(&self, a: &BlockMatrix, null_vector: &[f64]) -> usize {
        let mut scale = vec![0.0; null_vector.len()];
        for_each_entry(a, |row, column, value| scale[column] += value.abs() / self.row_sums[row]);
        position_of_greatest(null_vector.iter().zip(&scale).map(|(value, scale)| value.abs() * scale))
    }

    /// A zero pivot spoils every entry of a solution. One step of inverse iteration with a slightly shifted matrix
    /// still shows the null vector.
    fn shifted_solution(&self, a: &BlockMatrix) -> Result<Vec<f64>, LinearError> {
        let mut shifted = a.clone();
        let block = a.pattern.block();
        for (dof, sum) in self.row_sums.iter().enumerate() {
            let diagonal = a.pattern.diagonal()[dof / block] as usize * block * block;
            shifted.values[diagonal + dof % block * (block + 1)] += SHIFT * sum;
        }
        let mut factors = Lu::default();
        factors.analyse(&a.pattern)?;
        factors.factorise(&shifted)?;
        let mut solution = Vec::new();
        self.append_to(&mut solution);
        factors.solve(&mut solution, 1)?;
        Ok(solution)
    }
}

fn for_each_entry(a: &BlockMatrix, mut visit: impl FnMut(usize, usize, f64)) {
    let block = a.pattern.block();
    for row in 0..a.pattern.rows() {
        for entry in a.pattern.row(row) {
            let column = a.pattern.columns()[entry] as usize;
            let values = &a.values[entry * block * block..(entry + 1) * block * block];
            for (i, values) in values.chunks_exact(block).enumerate() {
                for (j, &value) in values.iter().enumerate() {
                    visit(row * block + i, column * block + j, value);
                }
            }
        }
    }
}
