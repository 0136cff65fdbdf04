//! Functions of a cell as sums of simpler ones, its modes: the kernels sum over modes at the points,
//! where they are cheap, and go from modes to nodes once for all points of a cell.
//!
//! The modes of a mesh cell are the monomials of its local coordinates, N_i = s Σ_k H_ik μ_k with a
//! scale s: a field is Σ_k c_k μ_k with c = s Hᵀ v, and sums over points go to the nodes as s H M. The
//! modes of the functions of a regular grid are these functions themselves.

mod axes;
mod monomials;
#[cfg(test)]
mod tests;

pub use monomials::Monomials;

use super::to_grid::{Load, Wanted};
use bia_kernel::geometry::MeshCell;
use bia_kernel::lanes::{Lanes, Pack, Real, WIDTH};
use pulp::Simd;

/// Modes of a cell with `N` nodes in `D` dimensions.
pub trait Modes<const D: usize, const N: usize>: Copy {
    /// Modes at a point, or at points in step.
    type At<R: Real>: Copy;
    /// s.
    const SCALE: f64;

    /// The modes at ξ.
    fn at<R: Real>(&self, xi: &[R; D]) -> Self::At<R>;

    /// c/s from the values at the nodes.
    fn expand<R: Real>(nodal: &mut [R; N]);

    /// The sums at the nodes over s from those of the modes.
    fn collect<R: Real>(sums: &mut [R; N]);

    /// The vector whose components have the packs' entries from `first` on as coefficients.
    fn vector<R: Real>(at: &Self::At<R>, coefficients: &[Pack; N], first: usize) -> [R; D];

    /// Its gradient by ξ, `[component][local]`.
    fn gradient<R: Real>(at: &Self::At<R>, coefficients: &[Pack; N], first: usize) -> [[R; D]; D];

    /// Sums over the lanes for each mode, as records of nodes: Σ m μ_k, Σ m v μ_k, and for the forces
    /// Σ (w μ_k − pull · ∂μ_k/∂ξ).
    fn sums<S: Simd>(simd: S, at: &Self::At<Lanes<S>>, load: &Load<Lanes<S>, D>, wanted: Wanted) -> [Pack; N];
}

impl<S: Monomials<D, N>, const D: usize, const N: usize> Modes<D, N> for MeshCell<S, D, N> {
    type At<R: Real> = [R; N];
    const SCALE: f64 = S::SCALE;

    #[inline(always)]
    fn at<R: Real>(&self, xi: &[R; D]) -> [R; N] {
        <S as Monomials<D, N>>::at(xi)
    }

    #[inline(always)]
    fn expand<R: Real>(nodal: &mut [R; N]) {
        <S as Monomials<D, N>>::expand(nodal);
    }

    #[inline(always)]
    fn collect<R: Real>(sums: &mut [R; N]) {
        <S as Monomials<D, N>>::collect(sums);
    }

    #[inline(always)]
    fn vector<R: Real>(at: &[R; N], coefficients: &[Pack; N], first: usize) -> [R; D] {
        let mut vector = [at[0]; D];
        for a in 0..D {
            vector[a] = <S as Monomials<D, N>>::value(at, &spread(at[0], coefficients, first + a));
        }
        vector
    }

    #[inline(always)]
    fn gradient<R: Real>(at: &[R; N], coefficients: &[Pack; N], first: usize) -> [[R; D]; D] {
        let mut gradient = [[at[0]; D]; D];
        for a in 0..D {
            gradient[a] = <S as Monomials<D, N>>::gradient(at, &spread(at[0], coefficients, first + a));
        }
        gradient
    }

    /// Quantity by quantity, so that few numbers are on their way at a time.
    #[inline(always)]
    fn sums<L: Simd>(simd: L, at: &[Lanes<L>; N], load: &Load<Lanes<L>, D>, wanted: Wanted) -> [Pack; N] {
        const { assert!(N <= WIDTH, "a mesh cell has at most eight nodes") };
        let mut sums = [Pack([0.0; WIDTH]); WIDTH];
        if wanted.momentum() {
            if wanted != Wanted::MovedMomentum {
                sums[0] = over_lanes(&weigh(at, load.mass));
            }
            for a in 0..D {
                sums[1 + a] = over_lanes(&weigh(at, load.momentum[a]));
            }
        }
        if wanted.force() {
            for a in 0..D {
                let of_modes = <S as Monomials<D, N>>::pull(at, load.weight[a], &load.pull[a]);
                sums[1 + D + a] = over_lanes(&of_modes);
            }
        }
        let mut records = [Pack([0.0; WIDTH]); N];
        records.copy_from_slice(&Lanes::transposed(simd, &sums)[..N]);
        records
    }
}

/// q μ_k.
#[inline(always)]
fn weigh<R: Real, const N: usize>(at: &[R; N], q: R) -> [R; N] {
    let mut out = [q; N];
    for k in 1..N {
        out[k] = q * at[k];
    }
    out
}

/// Sums over the lanes, mode by mode.
#[inline(always)]
fn over_lanes<S: Simd, const N: usize>(values: &[Lanes<S>; N]) -> Pack {
    let mut eight = [values[0].constant(0.0); WIDTH];
    eight[..N].copy_from_slice(values);
    Lanes::sums(&eight)
}

/// Coefficients in all lanes.
#[inline(always)]
fn spread<R: Real, const N: usize>(of: R, coefficients: &[Pack; N], entry: usize) -> [R; N] {
    let mut out = [of; N];
    for k in 0..N {
        out[k] = of.constant(coefficients[k].0[entry]);
    }
    out
}
