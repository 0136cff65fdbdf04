//! A cell as the kernels see it: its functions, and the map between its local coordinates and space.

use bia_constitutive::tensor::adjugate;
use bia_kernel::geometry::CellBasis;
use bia_kernel::lanes::Real;

/// The map x = x₀ + J ξ of a cell with parallel sides.
#[derive(Debug, Clone, Copy)]
pub struct AffineMap<const D: usize> {
    /// x₀, the place of ξ = 0.
    origin: [f64; D],
    /// J⁻¹.
    inverse: [[f64; D]; D],
}

/// How local coordinates are had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mapping {
    /// All cells have parallel sides, so that J is the same all over a cell.
    pub affine: bool,
    /// Points keep their local coordinates; else they follow from positions wherever wanted.
    pub stored: bool,
}

/// One cell.
pub struct Cell<B, const D: usize, const N: usize> {
    /// Functions.
    pub basis: B,
    /// Places of its nodes.
    pub nodes: [[f64; D]; N],
    map: Option<AffineMap<D>>,
    stored: bool,
}

impl<const D: usize> AffineMap<D> {
    #[inline(always)]
    fn of<B: CellBasis<D, N>, const N: usize>(basis: &B, nodes: &[[f64; D]; N]) -> Self {
        let (functions, gradients) = (basis.functions(&[0.0; D]), basis.gradients(&[0.0; D]));
        let mut origin = [0.0; D];
        for i in 0..N {
            for a in 0..D {
                origin[a] += functions[i] * nodes[i][a];
            }
        }
        Self { origin, inverse: inverse(&jacobian(nodes, &gradients)) }
    }

    #[inline(always)]
    fn local<R: Real>(&self, x: &[R; D]) -> [R; D] {
        let mut xi = [R::splat(0.0); D];
        for a in 0..D {
            let offset = x[a] - R::splat(self.origin[a]);
            for c in 0..D {
                xi[c] += offset * self.inverse[c][a];
            }
        }
        xi
    }
}

impl<B: CellBasis<D, N>, const D: usize, const N: usize> Cell<B, D, N> {
    /// A cell with these functions and nodes.
    #[inline(always)]
    pub fn new(basis: B, nodes: [[f64; D]; N], mapping: Mapping) -> Self {
        let map = if mapping.affine { Some(AffineMap::of(&basis, &nodes)) } else { None };
        Self { basis, nodes, map, stored: mapping.stored }
    }

    /// Local coordinates of positions, or those stored.
    #[inline(always)]
    pub fn local<R: Real>(&self, x: &[R; D], stored: impl FnOnce() -> [R; D]) -> [R; D] {
        match &self.map {
            Some(map) if !self.stored => map.local(x),
            _ => stored(),
        }
    }

    /// Distance from the axis of axisymmetric scenes, where the functions have these values.
    #[inline(always)]
    pub fn radius<R: Real>(&self, functions: &[R; N]) -> R {
        let mut radius = R::splat(0.0);
        for i in 0..N {
            radius += functions[i] * self.nodes[i][0];
        }
        radius
    }

    /// J⁻¹, `[local][space]`, where the functions have these local gradients.
    #[inline(always)]
    pub fn inverse_jacobian<R: Real>(&self, gradients: &[[R; D]; N]) -> [[R; D]; D] {
        match &self.map {
            Some(map) => {
                let mut inverse = [[R::splat(0.0); D]; D];
                for c in 0..D {
                    for a in 0..D {
                        inverse[c][a] = R::splat(map.inverse[c][a]);
                    }
                }
                inverse
            }
            None => inverse(&jacobian(&self.nodes, gradients)),
        }
    }
}

/// Whether a cell's map is affine but for round-off of its corners' coordinates.
pub fn is_affine<B: CellBasis<D, N>, const D: usize, const N: usize>(
    basis: &B,
    nodes: &[[f64; D]; N],
    references: &[[f64; D]; N],
) -> bool {
    let map = AffineMap::of(basis, nodes);
    let size = nodes.iter().flatten().fold(0.0f64, |size, x| size.max(x.abs()));
    let step = inverse(&map.inverse).iter().flatten().fold(0.0f64, |step, j| step.max(j.abs()));
    // One unit of rounding in a coordinate is so many local units.
    let tolerance = 1e-13 + 16.0 * f64::EPSILON * size / step;
    let near = |(node, reference): (&[f64; D], &[f64; D])| {
        map.local(node).iter().zip(reference).all(|(xi, expected)| (xi - expected).abs() <= tolerance)
    };
    nodes.iter().zip(references).all(near)
}

#[inline(always)]
fn jacobian<R: Real, const D: usize, const N: usize>(nodes: &[[f64; D]; N], gradients: &[[R; D]; N]) -> [[R; D]; D] {
    let mut sum = [[R::splat(0.0); D]; D];
    for i in 0..N {
        for a in 0..D {
            for c in 0..D {
                sum[a][c] += gradients[i][c] * nodes[i][a];
            }
        }
    }
    sum
}

/// Inverse of a matrix of at most 3 × 3; not finite if it has none.
#[inline(always)]
fn inverse<R: Real, const D: usize>(m: &[[R; D]; D]) -> [[R; D]; D] {
    let one = R::splat(1.0);
    let mut out = *m;
    match D {
        1 => out[0][0] = one / m[0][0],
        2 => {
            let scale = one / (m[0][0] * m[1][1] - m[0][1] * m[1][0]);
            (out[0][0], out[0][1]) = (m[1][1] * scale, -m[0][1] * scale);
            (out[1][0], out[1][1]) = (-m[1][0] * scale, m[0][0] * scale);
        }
        _ => {
            let mut full = [[one; 3]; 3];
            for i in 0..D {
                full[i][..D].copy_from_slice(&m[i]);
            }
            let (adjugate, determinant) = adjugate(&full);
            let scale = one / determinant;
            for i in 0..D {
                for j in 0..D {
                    out[i][j] = adjugate[i][j] * scale;
                }
            }
        }
    }
    out
}
