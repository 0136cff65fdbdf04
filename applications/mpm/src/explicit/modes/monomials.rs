//! The monomials of the mesh's own cells.

use bia_kernel::geometry::{CellShape, Hexahedron8, Line2, Quadrilateral4, Tetrahedron4, Triangle3};
use bia_kernel::lanes::Real;

/// Monomials of a shape; see [`super::Modes`].
pub trait Monomials<const D: usize, const N: usize>: CellShape<D, N> {
    /// s.
    const SCALE: f64;
    /// See [`super::Modes::at`].
    fn at<R: Real>(xi: &[R; D]) -> [R; N];
    /// See [`super::Modes::expand`].
    fn expand<R: Real>(nodal: &mut [R; N]);
    /// See [`super::Modes::collect`].
    fn collect<R: Real>(sums: &mut [R; N]);
    /// The field with coefficients `c`.
    fn value<R: Real>(at: &[R; N], c: &[R; N]) -> R;
    /// Its gradient by ξ.
    fn gradient<R: Real>(at: &[R; N], c: &[R; N]) -> [R; D];
    /// q μ_k − p · ∂μ_k/∂ξ.
    fn pull<R: Real>(at: &[R; N], q: R, p: &[R; D]) -> [R; N];
}

/// Sum and difference: the step from the two ends of an edge to 1 and ξ, over ½.
#[inline(always)]
fn ends_to_modes<R: Real, const N: usize>(values: &mut [R; N], low: usize, high: usize) {
    (values[low], values[high]) = (values[low] + values[high], values[high] - values[low]);
}

/// The transpose of [`ends_to_modes`].
#[inline(always)]
fn modes_to_ends<R: Real, const N: usize>(sums: &mut [R; N], low: usize, high: usize) {
    (sums[low], sums[high]) = (sums[low] - sums[high], sums[low] + sums[high]);
}

impl Monomials<1, 2> for Line2 {
    const SCALE: f64 = 0.5;

    #[inline(always)]
    fn at<R: Real>(&[x]: &[R; 1]) -> [R; 2] {
        [x.constant(1.0), x]
    }

    #[inline(always)]
    fn expand<R: Real>(nodal: &mut [R; 2]) {
        ends_to_modes(nodal, 0, 1);
    }

    #[inline(always)]
    fn collect<R: Real>(sums: &mut [R; 2]) {
        modes_to_ends(sums, 0, 1);
    }

    #[inline(always)]
    fn value<R: Real>(&[_, x]: &[R; 2], c: &[R; 2]) -> R {
        c[0] + c[1] * x
    }

    #[inline(always)]
    fn gradient<R: Real>(_: &[R; 2], c: &[R; 2]) -> [R; 1] {
        [c[1]]
    }

    #[inline(always)]
    fn pull<R: Real>(&[_, x]: &[R; 2], q: R, p: &[R; 1]) -> [R; 2] {
        [q, q * x - p[0]]
    }
}

impl Monomials<2, 4> for Quadrilateral4 {
    const SCALE: f64 = 0.25;

    /// 1, x, xy, y, each at the node where all its factors are positive.
    #[inline(always)]
    fn at<R: Real>(&[x, y]: &[R; 2]) -> [R; 4] {
        [x.constant(1.0), x, x * y, y]
    }

    #[inline(always)]
    fn expand<R: Real>(nodal: &mut [R; 4]) {
        ends_to_modes(nodal, 0, 1);
        ends_to_modes(nodal, 3, 2);
        ends_to_modes(nodal, 0, 3);
        ends_to_modes(nodal, 1, 2);
    }

    #[inline(always)]
    fn collect<R: Real>(sums: &mut [R; 4]) {
        modes_to_ends(sums, 0, 1);
        modes_to_ends(sums, 3, 2);
        modes_to_ends(sums, 0, 3);
        modes_to_ends(sums, 1, 2);
    }

    #[inline(always)]
    fn value<R: Real>(&[_, x, _, y]: &[R; 4], c: &[R; 4]) -> R {
        (c[0] + c[1] * x) + (c[3] + c[2] * x) * y
    }

    #[inline(always)]
    fn gradient<R: Real>(&[_, x, _, y]: &[R; 4], c: &[R; 4]) -> [R; 2] {
        [c[1] + c[2] * y, c[3] + c[2] * x]
    }

    #[inline(always)]
    fn pull<R: Real>(&[_, x, xy, y]: &[R; 4], q: R, p: &[R; 2]) -> [R; 4] {
        [q, q * x - p[0], q * xy - p[0] * y - p[1] * x, q * y - p[1]]
    }
}

/// Edges of a hexahedron, axis by axis.
const EDGES: [(usize, usize); 12] =
    [(0, 1), (3, 2), (4, 5), (7, 6), (0, 3), (1, 2), (4, 7), (5, 6), (0, 4), (1, 5), (2, 6), (3, 7)];

impl Monomials<3, 8> for Hexahedron8 {
    const SCALE: f64 = 0.125;

    /// 1, x, xy, y, z, xz, xyz, yz, each at the node where all its factors are positive.
    #[inline(always)]
    fn at<R: Real>(&[x, y, z]: &[R; 3]) -> [R; 8] {
        let xy = x * y;
        [x.constant(1.0), x, xy, y, z, x * z, xy * z, y * z]
    }

    #[inline(always)]
    fn expand<R: Real>(nodal: &mut [R; 8]) {
        for k in 0..EDGES.len() {
            ends_to_modes(nodal, EDGES[k].0, EDGES[k].1);
        }
    }

    #[inline(always)]
    fn collect<R: Real>(sums: &mut [R; 8]) {
        for k in 0..EDGES.len() {
            modes_to_ends(sums, EDGES[k].0, EDGES[k].1);
        }
    }

    #[inline(always)]
    fn value<R: Real>(&[_, x, _, y, z, ..]: &[R; 8], c: &[R; 8]) -> R {
        (c[0] + c[1] * x) + (c[3] + c[2] * x) * y + ((c[4] + c[5] * x) + (c[7] + c[6] * x) * y) * z
    }

    #[inline(always)]
    fn gradient<R: Real>(&[_, x, _, y, z, ..]: &[R; 8], c: &[R; 8]) -> [R; 3] {
        let (of_y, of_z, of_yz) = (c[3] + c[2] * x, c[4] + c[5] * x, c[7] + c[6] * x);
        [(c[1] + c[2] * y) + (c[5] + c[6] * y) * z, of_y + of_yz * z, of_z + of_yz * y]
    }

    #[inline(always)]
    fn pull<R: Real>(&[_, x, xy, y, z, xz, xyz, yz]: &[R; 8], q: R, p: &[R; 3]) -> [R; 8] {
        [
            q,
            q * x - p[0],
            q * xy - p[0] * y - p[1] * x,
            q * y - p[1],
            q * z - p[2],
            q * xz - p[0] * z - p[2] * x,
            q * xyz - p[0] * yz - p[1] * xz - p[2] * xy,
            q * yz - p[1] * z - p[2] * y,
        ]
    }
}

/// Triangles and tetrahedra: 1 and the local coordinates.
macro_rules! simplex {
    ($shape:ident, $d:literal, $n:literal) => {
        impl Monomials<$d, $n> for $shape {
            const SCALE: f64 = 1.0;

            #[inline(always)]
            fn at<R: Real>(xi: &[R; $d]) -> [R; $n] {
                let mut at = [xi[0].constant(1.0); $n];
                at[1..].copy_from_slice(xi);
                at
            }

            #[inline(always)]
            fn expand<R: Real>(nodal: &mut [R; $n]) {
                let first = nodal[0];
                for k in 1..$n {
                    nodal[k] -= first;
                }
            }

            #[inline(always)]
            fn collect<R: Real>(sums: &mut [R; $n]) {
                for k in 1..$n {
                    let sum = sums[k];
                    sums[0] -= sum;
                }
            }

            #[inline(always)]
            fn value<R: Real>(at: &[R; $n], c: &[R; $n]) -> R {
                let mut value = c[0];
                for k in 1..$n {
                    value += c[k] * at[k];
                }
                value
            }

            #[inline(always)]
            fn gradient<R: Real>(_: &[R; $n], c: &[R; $n]) -> [R; $d] {
                let mut gradient = [c[0]; $d];
                gradient.copy_from_slice(&c[1..]);
                gradient
            }

            #[inline(always)]
            fn pull<R: Real>(at: &[R; $n], q: R, p: &[R; $d]) -> [R; $n] {
                let mut out = [q; $n];
                for k in 1..$n {
                    out[k] = q * at[k] - p[k - 1];
                }
                out
            }
        }
    };
}

simplex!(Triangle3, 2, 3);
simplex!(Tetrahedron4, 3, 4);
