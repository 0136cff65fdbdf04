//! Functions of a cell together with its place in space: what loops over cells ask for.

use super::cell::transformed;
use super::{CellBasis, CellShape};
use crate::lanes::Real;
use std::marker::PhantomData;

/// Functions of a cell that stands in space.
pub trait PlacedBasis<const D: usize, const N: usize>: CellBasis<D, N> {
    /// Physical gradients ∂N_a/∂x_i at ξ as `[a][i]` in 1/m. Not finite in a flat cell.
    fn physical_gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N];

    /// The position x(ξ) in m, given the functions there.
    fn position<R: Real>(&self, xi: &[R; D], functions: &[R; N]) -> [R; D];
}

/// A cell of a mesh with its own shape functions (isoparametric).
#[derive(Debug, Clone, Copy)]
pub struct MeshCell<S, const D: usize, const N: usize> {
    /// Coordinates of the nodes in m.
    pub corners: [[f64; D]; N],
    shape: PhantomData<S>,
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> MeshCell<S, D, N> {
    /// The cell with these corners.
    #[inline(always)]
    pub fn new(corners: [[f64; D]; N]) -> Self {
        Self { corners, shape: PhantomData }
    }
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> CellBasis<D, N> for MeshCell<S, D, N> {
    #[inline(always)]
    fn functions<R: Real>(&self, xi: &[R; D]) -> [R; N] {
        <S as CellShape<D, N>>::functions(xi)
    }

    #[inline(always)]
    fn gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N] {
        <S as CellShape<D, N>>::gradients(xi)
    }
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> PlacedBasis<D, N> for MeshCell<S, D, N> {
    #[inline(always)]
    fn physical_gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N] {
        transformed(&self.corners, &<S as CellShape<D, N>>::gradients(xi)).0
    }

    #[inline(always)]
    fn position<R: Real>(&self, _: &[R; D], functions: &[R; N]) -> [R; D] {
        let mut x = [functions[0].constant(0.0); D];
        for a in 0..N {
            for i in 0..D {
                x[i] += functions[a] * self.corners[a][i];
            }
        }
        x
    }
}
