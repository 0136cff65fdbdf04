//! Functions of higher order on a regular grid: products of piecewise polynomials of one
//! coordinate each.
//!
//! N_a(x, y, z) = φ_i(x) φ_j(y) φ_k(z), numbered with the first axis fastest, in the whole grid and
//! in each cell. The local coordinates ξ ∈ \[−1, 1\]^D run along the axes, whatever the order of the
//! mesh cell's nodes.

use super::polynomials::AxisBasis;
use super::{CellBasis, PlacedBasis, RegularGrid};
use crate::lanes::{Real, turns};
use std::array::from_fn;

/// Values at a crossing that are rounding only.
const NOTHING: f64 = 1e-12;

/// Kinds of piecewise polynomials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Continuous, interpolating at evenly spaced nodes of each interval.
    Lagrange,
    /// p − 1 times differentiable, positive, with knots at the grid lines.
    BSpline,
}

/// The functions of a regular grid.
#[derive(Debug, Clone)]
pub struct TensorBasis {
    grid: RegularGrid,
    axes: Vec<AxisBasis>,
    family: Family,
    degree: usize,
}

/// The functions of one cell, `P1` = degree + 1 along each of `D` axes, `N` = `P1`^D in all.
#[derive(Debug, Clone, Copy)]
pub struct TensorCell<'a, const D: usize, const N: usize, const P1: usize> {
    tables: [&'a [[f64; P1]; P1]; D],
    center: [f64; D],
    /// Half the size along each axis.
    half: [f64; D],
}

impl TensorBasis {
    /// Functions of a degree of at least 1 on a grid. Degrees above 6 lose digits.
    pub fn new(grid: RegularGrid, family: Family, degree: usize) -> Self {
        let degree = degree.max(1);
        let axes = (0..grid.dimension()).map(|axis| AxisBasis::new(grid.lines(axis), family, degree)).collect();
        Self { grid, axes, family, degree }
    }

    /// The grid.
    pub fn grid(&self) -> &RegularGrid {
        &self.grid
    }

    /// Kind of the polynomials.
    pub fn family(&self) -> Family {
        self.family
    }

    /// Degree along each axis.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of functions, those of holes among them.
    pub fn len(&self) -> usize {
        self.axes.iter().map(AxisBasis::len).product()
    }

    /// Never: a grid has cells.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// Number of functions of a cell.
    pub fn per_cell(&self) -> usize {
        (self.degree + 1).pow(self.axes.len() as u32)
    }

    /// Where a function is anchored in m: its node if it is a Lagrange polynomial, its Greville
    /// abscissae if it is a B-spline; 0 beyond the dimension. With these as coefficients the functions
    /// reproduce the position.
    pub fn anchor(&self, function: usize) -> [f64; 3] {
        let mut rest = function;
        let mut anchor = [0.0; 3];
        for (axis, x) in self.axes.iter().zip(&mut anchor) {
            *x = axis.anchors()[rest % axis.len()];
            rest /= axis.len();
        }
        anchor
    }

    /// The crossings of grid lines around a function's anchor (see [`RegularGrid::crossings`]) with
    /// the weights that interpolate there, products of linear functions: one crossing if the anchor is
    /// on lines of all axes, up to 2^D if it is inside a cell.
    pub fn around_anchor(&self, function: usize, mut visit: impl FnMut(usize, f64)) {
        let (mut rest, counts) = (function, self.grid.line_counts());
        let mut along = [[(0, 1.0), (0, 0.0)]; 3];
        for (axis, pair) in self.axes.iter().zip(&mut along) {
            let (line, share) = axis.between_lines(rest % axis.len());
            *pair = [(line, 1.0 - share), (line + 1, share)];
            rest /= axis.len();
        }
        for (k, z) in along[2] {
            for (j, y) in along[1] {
                for (i, x) in along[0] {
                    if x * y * z > 0.0 {
                        visit(i + counts[0] * (j + counts[1] * k), x * y * z);
                    }
                }
            }
        }
    }

    /// The functions that do not vanish at a crossing of grid lines, with their values.
    pub fn at_crossing(&self, crossing: usize, mut visit: impl FnMut(u32, f64)) {
        let (mut rest, counts) = (crossing, self.grid.line_counts());
        let mut along: [(usize, Vec<f64>); 3] = from_fn(|_| (0, vec![1.0]));
        for (d, axis) in self.axes.iter().enumerate() {
            let line = rest % counts[d];
            rest /= counts[d];
            let interval = line.saturating_sub(1);
            along[d] = (axis.first(interval), axis.values(interval, if line == 0 { -1.0 } else { 1.0 }));
        }
        let lengths: [usize; 3] = from_fn(|d| self.axes.get(d).map_or(1, AxisBasis::len));
        for (k, z) in along[2].1.iter().enumerate() {
            for (j, y) in along[1].1.iter().enumerate() {
                for (i, x) in along[0].1.iter().enumerate() {
                    let [i, j, k] = [along[0].0 + i, along[1].0 + j, along[2].0 + k];
                    if (x * y * z).abs() > NOTHING {
                        visit((i + lengths[0] * (j + lengths[1] * k)) as u32, x * y * z);
                    }
                }
            }
        }
    }

    /// The functions of a cell, in their local order.
    pub fn functions_of(&self, cell: usize) -> impl Iterator<Item = u32> {
        let (place, count) = (self.grid.place(cell), self.degree + 1);
        let lengths: [usize; 3] = from_fn(|d| self.axes.get(d).map_or(1, AxisBasis::len));
        let first: [usize; 3] = from_fn(|d| self.axes.get(d).map_or(0, |axis| axis.first(place[d])));
        (0..self.per_cell()).map(move |a| {
            let local = [a % count, a / count % count, a / (count * count)];
            let [i, j, k]: [usize; 3] = from_fn(|d| first[d] + local[d]);
            (i + lengths[0] * (j + lengths[1] * k)) as u32
        })
    }

    /// Local coordinates of a position in a cell, also outside of it; 0 beyond the dimension.
    #[inline]
    pub fn local(&self, cell: usize, x: [f64; 3]) -> [f64; 3] {
        let place = self.grid.place(cell);
        from_fn(|d| match self.axes.get(d) {
            Some(_) => {
                let lines = self.grid.lines(d);
                let (low, high) = (lines[place[d]], lines[place[d] + 1]);
                ((x[d] - low) + (x[d] - high)) / (high - low)
            }
            None => 0.0,
        })
    }

    /// The functions of a cell by type; none if dimension or degree do not fit.
    #[inline]
    pub fn cell<const D: usize, const N: usize, const P1: usize>(
        &self,
        cell: usize,
    ) -> Option<TensorCell<'_, D, N, P1>> {
        let place = self.grid.place(cell);
        let (mut tables, mut center, mut half) = ([&[[0.0; P1]; P1]; D], [0.0; D], [0.0; D]);
        if self.axes.len() != D {
            return None;
        }
        for (d, axis) in self.axes.iter().enumerate() {
            let lines = self.grid.lines(d);
            let (low, high) = (lines[place[d]], lines[place[d] + 1]);
            tables[d] = axis.table(place[d]).filter(|_| P1 == self.degree + 1)?;
            (center[d], half[d]) = (0.5 * (low + high), 0.5 * (high - low));
        }
        Some(TensorCell { tables, center, half })
    }

    /// The functions of a cell at ξ into the first entries of `values`, for set-up and output.
    pub fn evaluate(&self, cell: usize, xi: [f64; 3], values: &mut Vec<f64>) {
        let (place, count) = (self.grid.place(cell), self.degree + 1);
        values.clear();
        values.push(1.0);
        for (d, axis) in self.axes.iter().enumerate() {
            let of_axis = axis.values(place[d], xi[d]);
            let before = std::mem::take(values);
            values.reserve(before.len() * count);
            of_axis.iter().for_each(|factor| values.extend(before.iter().map(|value| value * factor)));
        }
    }
}

impl<const D: usize, const N: usize, const P1: usize> TensorCell<'_, D, N, P1> {
    const SIZES_MATCH: () = assert!(N == P1.pow(D as u32), "a cell has (degree + 1)^D functions");

    /// Centre of the cell in m.
    #[inline(always)]
    pub fn center(&self) -> &[f64; D] {
        &self.center
    }

    /// Half of the cell's edges in m.
    #[inline(always)]
    pub fn half(&self) -> &[f64; D] {
        &self.half
    }

    /// Values and slopes by ξ_d of the polynomials of one axis.
    #[inline(always)]
    pub fn along<R: Real>(&self, d: usize, xi: R) -> ([R; P1], [R; P1]) {
        let (mut values, mut slopes) = ([xi; P1], [xi.constant(0.0); P1]);
        for a in 0..P1 {
            values[a] = xi.constant(self.tables[d][P1 - 1][a]);
        }
        for k in (0..P1 - 1).rev() {
            for a in 0..P1 {
                slopes[a] = slopes[a] * xi + values[a];
                values[a] = values[a] * xi + self.tables[d][k][a];
            }
        }
        (values, slopes)
    }

    /// Gradients with the slopes along each axis times a factor.
    #[inline(always)]
    fn scaled_gradients<R: Real>(&self, xi: &[R; D], factors: &[f64; D]) -> [[R; D]; N] {
        let (mut values, mut slopes) = ([[xi[0]; P1]; D], [[xi[0]; P1]; D]);
        for d in 0..D {
            (values[d], slopes[d]) = self.along(d, xi[d]);
            for slope in &mut slopes[d] {
                *slope = *slope * factors[d];
            }
        }
        let mut gradients = [[xi[0]; D]; N];
        for j in 0..D {
            let mut of_axis = values;
            of_axis[j] = slopes[j];
            let column = Self::product(&of_axis);
            for a in 0..turns::<N>() {
                gradients[a][j] = column[a];
            }
        }
        gradients
    }

    /// Π_d f_d with the factors of each function.
    #[inline(always)]
    fn product<R: Real>(factors: &[[R; P1]; D]) -> [R; N] {
        let () = Self::SIZES_MATCH;
        let mut product = [factors[0][0]; N];
        // Axis by axis, so that each plane's products are formed once.
        product[..P1].copy_from_slice(&factors[0]);
        let mut filled = if N > 8 { std::hint::black_box(P1).min(P1) } else { P1 };
        for of_axis in &factors[1..] {
            for b in (0..P1).rev() {
                for a in 0..filled {
                    product[b * filled + a] = product[a] * of_axis[b];
                }
            }
            filled *= P1;
        }
        product
    }
}

impl<const D: usize, const N: usize, const P1: usize> CellBasis<D, N> for TensorCell<'_, D, N, P1> {
    #[inline(always)]
    fn functions<R: Real>(&self, xi: &[R; D]) -> [R; N] {
        let mut factors = [[xi[0]; P1]; D];
        for d in 0..D {
            factors[d] = self.along(d, xi[d]).0;
        }
        Self::product(&factors)
    }

    #[inline(always)]
    fn gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N] {
        self.scaled_gradients(xi, &[1.0; D])
    }
}

impl<const D: usize, const N: usize, const P1: usize> PlacedBasis<D, N> for TensorCell<'_, D, N, P1> {
    #[inline(always)]
    fn physical_gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N] {
        let mut per_length = self.half;
        for d in 0..D {
            per_length[d] = 1.0 / self.half[d];
        }
        self.scaled_gradients(xi, &per_length)
    }

    #[inline(always)]
    fn position<R: Real>(&self, xi: &[R; D], _: &[R; N]) -> [R; D] {
        let mut x = *xi;
        for d in 0..D {
            x[d] = xi[d] * self.half[d] + self.center[d];
        }
        x
    }
}

#[cfg(test)]
mod tests;
