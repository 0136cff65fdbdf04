//! Functions of a regular grid by the polynomials of each axis.

use super::Modes;
use crate::explicit::to_grid::{Load, Wanted};
use bia_kernel::geometry::TensorCell;
use bia_kernel::lanes::{Lanes, Pack, Real, WIDTH, turns};
use pulp::Simd;

/// Values and slopes of the polynomials of each axis at a point. The functions, products of them, are
/// formed along the first axis, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Axes<R, const D: usize, const P1: usize> {
    values: [[R; P1]; D],
    slopes: [[R; P1]; D],
}

impl<R: Real, const D: usize, const P1: usize> Axes<R, D, P1> {
    /// What the other axes' factors in a row of functions make of the value along the first axis: the
    /// value of the function, and its slopes along each other axis.
    #[inline(always)]
    fn row(&self, row: usize) -> [R; D] {
        let mut factors = [self.values[0][0].constant(1.0); D];
        let mut rest = row;
        for d in 1..D {
            let (value, slope) = (self.values[d][rest % P1], self.slopes[d][rest % P1]);
            rest /= P1;
            for c in 0..D {
                factors[c] *= if c == d { slope } else { value };
            }
        }
        factors
    }
}

impl<const D: usize, const N: usize, const P1: usize> Modes<D, N> for TensorCell<'_, D, N, P1> {
    type At<R: Real> = Axes<R, D, P1>;
    const SCALE: f64 = 1.0;

    #[inline(always)]
    fn at<R: Real>(&self, xi: &[R; D]) -> Self::At<R> {
        let mut at = Axes { values: [[xi[0]; P1]; D], slopes: [[xi[0]; P1]; D] };
        for d in 0..D {
            (at.values[d], at.slopes[d]) = self.along(d, xi[d]);
        }
        at
    }

    #[inline(always)]
    fn expand<R: Real>(_: &mut [R; N]) {}

    #[inline(always)]
    fn collect<R: Real>(_: &mut [R; N]) {}

    #[inline(always)]
    fn vector<R: Real>(at: &Self::At<R>, coefficients: &[Pack; N], first: usize) -> [R; D] {
        let mut sum = [at.values[0][0].constant(0.0); D];
        for row in 0..turns::<N>() / P1 {
            let factor = at.row(row)[0];
            for i in 0..P1 {
                let function = at.values[0][i] * factor;
                for a in 0..D {
                    sum[a] += function * coefficients[row * P1 + i].0[first + a];
                }
            }
        }
        sum
    }

    #[inline(always)]
    fn gradient<R: Real>(at: &Self::At<R>, coefficients: &[Pack; N], first: usize) -> [[R; D]; D] {
        let zero = at.values[0][0].constant(0.0);
        let mut sum = [[zero; D]; D];
        for row in 0..turns::<N>() / P1 {
            let factors = at.row(row);
            for a in 0..D {
                let (mut value, mut slope) = (zero, zero);
                for i in 0..P1 {
                    let coefficient = coefficients[row * P1 + i].0[first + a];
                    value += at.values[0][i] * coefficient;
                    slope += at.slopes[0][i] * coefficient;
                }
                sum[a][0] += slope * factors[0];
                for c in 1..D {
                    sum[a][c] += value * factors[c];
                }
            }
        }
        sum
    }

    #[inline(always)]
    fn sums<S: Simd>(simd: S, at: &Self::At<Lanes<S>>, load: &Load<Lanes<S>, D>, wanted: Wanted) -> [Pack; N] {
        let zero = Lanes::splat(simd, 0.0);
        let mut sums = [Pack([0.0; WIDTH]); N];
        for row in 0..turns::<N>() / P1 {
            let factors = at.row(row);
            // What is to be multiplied by the values along the first axis, and by the slopes.
            let (mut by_value, mut by_slope) = ([zero; WIDTH], [zero; D]);
            if wanted.momentum() {
                by_value[0] = if wanted == Wanted::MovedMomentum { zero } else { factors[0] * load.mass };
                for a in 0..D {
                    by_value[1 + a] = factors[0] * load.momentum[a];
                }
            }
            if wanted.force() {
                for a in 0..D {
                    by_value[1 + D + a] = factors[0] * load.weight[a];
                    for c in 1..D {
                        by_value[1 + D + a] -= factors[c] * load.pull[a][c];
                    }
                    by_slope[a] = factors[0] * load.pull[a][0];
                }
            }
            for i in 0..P1 {
                let (value, slope) = (at.values[0][i], at.slopes[0][i]);
                let mut record = [zero; WIDTH];
                for k in 0..1 + 2 * D {
                    record[k] = value * by_value[k];
                }
                for a in 0..D {
                    record[1 + D + a] -= slope * by_slope[a];
                }
                sums[row * P1 + i] = Lanes::sums(&record);
            }
        }
        sums
    }
}
