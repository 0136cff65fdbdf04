//! Functions of a cell as sums of simpler ones, its modes: the kernels sum over modes at the points,
//! where they are cheap, and go from modes to nodes once for all points of a cell.
//!
//! The modes of a mesh cell are the monomials of its local coordinates, N_i = s Σ_k H_ik μ_k with a
//! scale s: a field is Σ_k c_k μ_k with c = s Hᵀ v, and sums over points go to the nodes as s H M. The
//! modes of the functions of a regular grid are these functions themselves.

use bia_kernel::geometry::{
    CellBasis, CellShape, Hexahedron8, Line2, MeshCell, Quadrilateral4, TensorCell, Tetrahedron4, Triangle3,
};
use bia_kernel::lanes::{Pack, Real, turns};

/// Modes of a cell with `N` nodes in `D` dimensions.
pub trait Modes<const D: usize, const N: usize>: Copy {
    /// Modes at a point, or at points in step.
    type At<R: Real>: Copy;
    /// s.
    const SCALE: f64;

    /// The modes at ξ, `sloped` if gradients or pulls are to follow.
    fn at<R: Real>(&self, xi: &[R; D], sloped: bool) -> Self::At<R>;

    /// c/s from the values at the nodes.
    fn expand<R: Real>(nodal: &mut [R; N]);

    /// The sums at the nodes over s from those of the modes.
    fn collect<R: Real>(sums: &mut [R; N]);

    /// The field whose coefficients are the entries `entry` of the packs.
    fn value<R: Real>(at: &Self::At<R>, coefficients: &[Pack; N], entry: usize) -> R;

    /// Its gradient by ξ.
    fn gradient<R: Real>(at: &Self::At<R>, coefficients: &[Pack; N], entry: usize) -> [R; D];

    /// q μ_k.
    fn weigh<R: Real>(at: &Self::At<R>, q: R) -> [R; N];

    /// q μ_k − p · ∂μ_k/∂ξ.
    fn pull<R: Real>(at: &Self::At<R>, q: R, p: &[R; D]) -> [R; N];
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

/// Monomials of a shape; see [`Modes`].
pub trait Monomials<const D: usize, const N: usize>: CellShape<D, N> {
    /// s.
    const SCALE: f64;
    /// See [`Modes::at`].
    fn at<R: Real>(xi: &[R; D]) -> [R; N];
    /// See [`Modes::expand`].
    fn expand<R: Real>(nodal: &mut [R; N]);
    /// See [`Modes::collect`].
    fn collect<R: Real>(sums: &mut [R; N]);
    /// See [`Modes::value`].
    fn value<R: Real>(at: &[R; N], c: &[R; N]) -> R;
    /// See [`Modes::gradient`].
    fn gradient<R: Real>(at: &[R; N], c: &[R; N]) -> [R; D];
    /// See [`Modes::pull`].
    fn pull<R: Real>(at: &[R; N], q: R, p: &[R; D]) -> [R; N];
}

impl<S: Monomials<D, N>, const D: usize, const N: usize> Modes<D, N> for MeshCell<S, D, N> {
    type At<R: Real> = [R; N];
    const SCALE: f64 = S::SCALE;

    #[inline(always)]
    fn at<R: Real>(&self, xi: &[R; D], _: bool) -> [R; N] {
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
    fn value<R: Real>(at: &[R; N], coefficients: &[Pack; N], entry: usize) -> R {
        <S as Monomials<D, N>>::value(at, &spread(at[0], coefficients, entry))
    }

    #[inline(always)]
    fn gradient<R: Real>(at: &[R; N], coefficients: &[Pack; N], entry: usize) -> [R; D] {
        <S as Monomials<D, N>>::gradient(at, &spread(at[0], coefficients, entry))
    }

    #[inline(always)]
    fn weigh<R: Real>(at: &[R; N], q: R) -> [R; N] {
        let mut out = [q; N];
        for k in 1..N {
            out[k] = q * at[k];
        }
        out
    }

    #[inline(always)]
    fn pull<R: Real>(at: &[R; N], q: R, p: &[R; D]) -> [R; N] {
        <S as Monomials<D, N>>::pull(at, q, p)
    }
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

impl<const D: usize, const N: usize, const P1: usize> Modes<D, N> for TensorCell<'_, D, N, P1> {
    /// Functions and their gradients.
    type At<R: Real> = ([R; N], [[R; D]; N]);
    const SCALE: f64 = 1.0;

    #[inline(always)]
    fn at<R: Real>(&self, xi: &[R; D], sloped: bool) -> Self::At<R> {
        let gradients = if sloped { self.gradients(xi) } else { [[xi[0]; D]; N] };
        (self.functions(xi), gradients)
    }

    #[inline(always)]
    fn expand<R: Real>(_: &mut [R; N]) {}

    #[inline(always)]
    fn collect<R: Real>(_: &mut [R; N]) {}

    #[inline(always)]
    fn value<R: Real>((functions, _): &Self::At<R>, coefficients: &[Pack; N], entry: usize) -> R {
        let mut sum = functions[0] * coefficients[0].0[entry];
        for i in 1..turns::<N>() {
            sum += functions[i] * coefficients[i].0[entry];
        }
        sum
    }

    #[inline(always)]
    fn gradient<R: Real>((_, gradients): &Self::At<R>, coefficients: &[Pack; N], entry: usize) -> [R; D] {
        let mut sum = gradients[0];
        for c in 0..D {
            sum[c] = sum[c] * coefficients[0].0[entry];
        }
        for i in 1..turns::<N>() {
            for c in 0..D {
                sum[c] += gradients[i][c] * coefficients[i].0[entry];
            }
        }
        sum
    }

    #[inline(always)]
    fn weigh<R: Real>((functions, _): &Self::At<R>, q: R) -> [R; N] {
        let mut out = *functions;
        for i in 0..turns::<N>() {
            out[i] *= q;
        }
        out
    }

    #[inline(always)]
    fn pull<R: Real>((functions, gradients): &Self::At<R>, q: R, p: &[R; D]) -> [R; N] {
        let mut out = *functions;
        for i in 0..turns::<N>() {
            out[i] *= q;
            for c in 0..D {
                out[i] -= gradients[i][c] * p[c];
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Modes at points of a cell against its functions and gradients.
    fn modes_are_functions<B: CellBasis<D, N> + Modes<D, N>, const D: usize, const N: usize>(basis: &B) {
        let field: [f64; N] = std::array::from_fn(|i| 1.0 + (3.7 * i as f64).sin());
        for seed in 0..5 {
            let xi: [f64; D] = std::array::from_fn(|d| (0.9 + 1.3 * seed as f64 + 2.1 * d as f64).cos());
            let (functions, gradients) = (basis.functions(&xi), basis.gradients(&xi));
            let at = basis.at(&xi, true);
            let mut coefficients = field;
            B::expand(&mut coefficients);
            let packs = coefficients.map(|c| {
                let mut pack = Pack([0.0; 8]);
                pack.0[2] = c * B::SCALE;
                pack
            });
            let value: f64 = (0..N).map(|i| functions[i] * field[i]).sum();
            assert!((B::value(&at, &packs, 2) - value).abs() < 1e-14);
            for (c, slope) in B::gradient(&at, &packs, 2).into_iter().enumerate() {
                let expected: f64 = (0..N).map(|i| gradients[i][c] * field[i]).sum();
                assert!((slope - expected).abs() < 1e-14, "{slope} {expected}");
            }
            let (q, p): (f64, [f64; D]) = (0.7, std::array::from_fn(|c| 0.3 - c as f64));
            let (mut weighed, mut pulled) = (B::weigh(&at, q), B::pull(&at, q, &p));
            B::collect(&mut weighed);
            B::collect(&mut pulled);
            for i in 0..N {
                let pull: f64 = (0..D).map(|c| p[c] * gradients[i][c]).sum();
                assert!((weighed[i] * B::SCALE - q * functions[i]).abs() < 1e-14);
                assert!((pulled[i] * B::SCALE - (q * functions[i] - pull)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn modes_of_mesh_cells_are_their_functions() {
        modes_are_functions(&MeshCell::<Line2, 1, 2>::new([[0.0; 1]; 2]));
        modes_are_functions(&MeshCell::<Triangle3, 2, 3>::new([[0.0; 2]; 3]));
        modes_are_functions(&MeshCell::<Quadrilateral4, 2, 4>::new([[0.0; 2]; 4]));
        modes_are_functions(&MeshCell::<Tetrahedron4, 3, 4>::new([[0.0; 3]; 4]));
        modes_are_functions(&MeshCell::<Hexahedron8, 3, 8>::new([[0.0; 3]; 8]));
    }
}
