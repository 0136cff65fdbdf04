//! A cell as the kernels see it: its functions, and the map between its local coordinates and space.

use super::modes::{Modes, Monomials};
use crate::space::{Functions, Space};
use bia_kernel::geometry::{CellShape, MeshCell, PlacedBasis, Shape, TensorCell, adjugate, jacobian};
use bia_kernel::lanes::{Lanes, Real, WIDTH};

/// How local coordinates are had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mapping {
    /// All cells have parallel sides, so that J is the same all over a cell.
    pub affine: bool,
    /// Points keep their local coordinates; else they follow from positions wherever wanted.
    pub stored: bool,
}

/// The map x = x₀ + J ξ of a cell with parallel sides.
#[derive(Debug, Clone, Copy)]
pub struct AffineMap<const D: usize> {
    /// x₀, the place of ξ = 0.
    origin: [f64; D],
    /// J⁻¹.
    inverse: [[f64; D]; D],
    /// The cell is a triangle or tetrahedron.
    simplex: bool,
    /// J is diagonal.
    diagonal: bool,
}

/// Functions of the cells of a space, by type.
pub trait CellOf<'a, const D: usize, const N: usize>: PlacedBasis<D, N> + Modes<D, N> {
    /// Functions of a mesh's own cells: Kratos has no others, and no faults with them.
    const OF_MESH: bool;

    /// Those of one cell; none if it has another type. Without its place they know values and local
    /// gradients only.
    fn of(space: &'a Space, cell: usize, placed: bool) -> Option<Self>;

    /// The map of a cell with parallel sides; none if it has another type.
    fn map(space: &'a Space, cell: usize) -> Option<AffineMap<D>>;

    /// J⁻¹ at ξ, `[local][space]`.
    fn inverse_jacobian<R: Real>(&self, xi: &[R; D]) -> [[R; D]; D];
}

/// One cell.
pub struct Cell<B, const D: usize, const N: usize> {
    /// Functions.
    pub basis: B,
    map: Option<AffineMap<D>>,
    stored: bool,
}

impl<'a, S: Monomials<D, N>, const D: usize, const N: usize> CellOf<'a, D, N> for MeshCell<S, D, N> {
    const OF_MESH: bool = true;

    #[inline(always)]
    fn of(space: &'a Space, cell: usize, placed: bool) -> Option<Self> {
        Some(Self::new(if placed { space.corners(cell) } else { [[0.0; D]; N] }))
    }

    #[inline(always)]
    fn map(space: &'a Space, cell: usize) -> Option<AffineMap<D>> {
        let nodes = space.nodes_of(cell);
        Some(affine_map::<S, D, N>(|corner| space.coordinates(nodes[corner])))
    }

    #[inline(always)]
    fn inverse_jacobian<R: Real>(&self, xi: &[R; D]) -> [[R; D]; D] {
        let gradients = <S as CellShape<D, N>>::gradients(xi);
        let (mut inverse, determinant) = adjugate(&jacobian(&self.corners, &gradients));
        let scale = determinant.constant(1.0) / determinant;
        for c in 0..D {
            for a in 0..D {
                inverse[c][a] *= scale;
            }
        }
        inverse
    }
}

impl<'a, const D: usize, const N: usize, const P1: usize> CellOf<'a, D, N> for TensorCell<'a, D, N, P1> {
    const OF_MESH: bool = false;

    #[inline(always)]
    fn of(space: &'a Space, cell: usize, _: bool) -> Option<Self> {
        match space.functions() {
            Functions::Tensor(tensor) => tensor.basis.cell(cell),
            Functions::Mesh(_) => None,
        }
    }

    #[inline(always)]
    fn map(space: &'a Space, cell: usize) -> Option<AffineMap<D>> {
        Some(<Self as CellOf<'a, D, N>>::of(space, cell, true)?.affine_map())
    }

    #[inline(always)]
    fn inverse_jacobian<R: Real>(&self, xi: &[R; D]) -> [[R; D]; D] {
        self.affine_map().inverse_at(xi[0])
    }
}

/// Boxes of regular grids.
trait BoxMap<const D: usize> {
    fn affine_map(&self) -> AffineMap<D>;
}

impl<const D: usize, const N: usize, const P1: usize> BoxMap<D> for TensorCell<'_, D, N, P1> {
    #[inline(always)]
    fn affine_map(&self) -> AffineMap<D> {
        let mut inverse = [[0.0; D]; D];
        for a in 0..D {
            inverse[a][a] = 1.0 / self.half()[a];
        }
        AffineMap { origin: *self.center(), inverse, simplex: false, diagonal: true }
    }
}

/// The map of a cell with parallel sides, from one corner and its neighbours along the local axes.
#[inline(always)]
fn affine_map<S: CellShape<D, N>, const D: usize, const N: usize>(corner: impl Fn(usize) -> [f64; D]) -> AffineMap<D> {
    let simplex = is_simplex(S::SHAPE);
    // Neighbours of the first corner along the local axes.
    let neighbours = if simplex { [1, 2, 3] } else { [1, 3, 4] };
    let (least, length) = if simplex { (0.0, 1.0) } else { (-1.0, 2.0) };
    let mut origin = corner(0);
    let first = origin;
    let mut jacobian = [[0.0; D]; D];
    for c in 0..D {
        let next = corner(neighbours[c]);
        for a in 0..D {
            jacobian[a][c] = (next[a] - first[a]) * (1.0 / length);
            origin[a] -= jacobian[a][c] * least;
        }
    }
    let mut diagonal = true;
    for a in 0..D {
        for c in 0..D {
            diagonal &= a == c || jacobian[a][c] == 0.0;
        }
    }
    let mut inverse = [[0.0; D]; D];
    if diagonal {
        for c in 0..D {
            inverse[c][c] = 1.0 / jacobian[c][c];
        }
        return AffineMap { origin, inverse, simplex, diagonal };
    }
    let (adjugate, determinant) = adjugate(&jacobian);
    let scale = 1.0 / determinant;
    for c in 0..D {
        for a in 0..D {
            inverse[c][a] = adjugate[c][a] * scale;
        }
    }
    AffineMap { origin, inverse, simplex, diagonal }
}

const fn is_simplex(shape: Shape) -> bool {
    matches!(shape, Shape::Triangle3 | Shape::Tetrahedron4)
}

impl<const D: usize> AffineMap<D> {
    #[inline(always)]
    fn local<R: Real>(&self, x: &[R; D]) -> [R; D] {
        let mut xi = *x;
        for a in 0..D {
            xi[a] = x[a] - self.origin[a];
        }
        if self.diagonal {
            for a in 0..D {
                xi[a] = xi[a] * self.inverse[a][a];
            }
            return xi;
        }
        let offset = xi;
        for c in 0..D {
            xi[c] = offset[0] * self.inverse[c][0];
            for a in 1..D {
                xi[c] += offset[a] * self.inverse[c][a];
            }
        }
        xi
    }

    /// Whether all positions lie in the cell.
    #[inline(always)]
    pub fn holds_all<S: pulp::Simd>(&self, x: &[Lanes<S>; D]) -> bool {
        let xi = self.local(x);
        let (mut low, mut high) = (xi[0], xi[0]);
        for a in 1..D {
            low = low.min(xi[a]);
            high = if self.simplex { high + xi[a] } else { high.max(xi[a]) };
        }
        let least = if self.simplex { 0.0 } else { -1.0 };
        low.all_within(least, f64::MAX) && high.all_within(-f64::MAX, 1.0)
    }

    /// Which positions lie in the cell.
    #[inline(always)]
    pub fn holds<S: pulp::Simd>(&self, x: &[Lanes<S>; D]) -> [bool; WIDTH] {
        let xi = self.local(x);
        let (mut low, mut high) = (xi[0], xi[0]);
        for a in 1..D {
            low = low.min(xi[a]);
            high = if self.simplex { high + xi[a] } else { high.max(xi[a]) };
        }
        let (low, high) = (low.pack(), high.pack());
        let least = if self.simplex { 0.0 } else { -1.0 };
        let mut inside = [false; WIDTH];
        for l in 0..WIDTH {
            inside[l] = low.0[l] >= least && high.0[l] <= 1.0;
        }
        inside
    }

    #[inline(always)]
    fn inverse_at<R: Real>(&self, of: R) -> [[R; D]; D] {
        let mut inverse = [[of; D]; D];
        for c in 0..D {
            for a in 0..D {
                inverse[c][a] = of.constant(self.inverse[c][a]);
            }
        }
        inverse
    }
}

impl<'a, B: CellOf<'a, D, N>, const D: usize, const N: usize> Cell<B, D, N> {
    /// A cell of a space, `placed` if its basis is asked for positions; none if it has another type.
    #[inline(always)]
    pub fn of(space: &'a Space, cell: usize, mapping: Mapping, placed: bool) -> Option<Self> {
        let map = if mapping.affine { Some(B::map(space, cell)?) } else { None };
        Some(Self { basis: B::of(space, cell, placed || !mapping.affine)?, map, stored: mapping.stored })
    }

    /// Whether local coordinates are stored.
    #[inline(always)]
    pub fn is_stored(&self) -> bool {
        self.stored || self.map.is_none()
    }

    /// Local coordinates of positions, unless they are stored.
    #[inline(always)]
    pub fn local<R: Real>(&self, x: &[R; D]) -> [R; D] {
        match &self.map {
            Some(map) => map.local(x),
            None => *x,
        }
    }

    /// J⁻¹ at ξ, `[local][space]`.
    #[inline(always)]
    pub fn inverse_jacobian<R: Real>(&self, xi: &[R; D]) -> [[R; D]; D] {
        match &self.map {
            Some(map) => map.inverse_at(xi[0]),
            None => self.basis.inverse_jacobian(xi),
        }
    }

    /// m J⁻¹ at ξ, or m J⁻ᵀ.
    #[inline(always)]
    pub fn times_inverse<R: Real>(&self, m: &[[R; D]; D], xi: &[R; D], transposed: bool) -> [[R; D]; D] {
        let mut out = *m;
        if let Some(map) = &self.map
            && map.diagonal
        {
            for a in 0..D {
                for c in 0..D {
                    out[a][c] = m[a][c] * map.inverse[c][c];
                }
            }
            return out;
        }
        let inverse = self.inverse_jacobian(xi);
        let mut factor = inverse;
        if transposed {
            for b in 0..D {
                for c in 0..D {
                    factor[b][c] = inverse[c][b];
                }
            }
        }
        for a in 0..D {
            for c in 0..D {
                out[a][c] = m[a][0] * factor[0][c];
                for b in 1..D {
                    out[a][c] += m[a][b] * factor[b][c];
                }
            }
        }
        out
    }

    /// Distance of ξ from the axis of axisymmetric scenes.
    #[inline(always)]
    pub fn radius<R: Real>(&self, xi: &[R; D]) -> R {
        self.basis.position(xi, &self.basis.functions(xi))[0]
    }

    /// The map, if it tells which positions the cell holds; ones beyond the dimension.
    #[inline(always)]
    pub fn place(&self) -> Option<AffineMap<3>> {
        let (Some(map), false) = (&self.map, self.stored) else { return None };
        let mut place =
            AffineMap { origin: [0.0; 3], inverse: [[0.0; 3]; 3], simplex: map.simplex, diagonal: map.diagonal };
        for a in 0..D {
            place.origin[a] = map.origin[a];
            for c in 0..D {
                place.inverse[c][a] = map.inverse[c][a];
            }
        }
        Some(place)
    }
}

/// Whether a cell's map is affine but for round-off of its corners' coordinates.
pub fn is_affine<S: CellShape<D, N>, const D: usize, const N: usize>(corners: &[[f64; D]; N]) -> bool {
    let map = affine_map::<S, D, N>(|corner| corners[corner]);
    let size = corners.iter().flatten().fold(0.0f64, |size, x| size.max(x.abs()));
    let per_length = map.inverse.iter().flatten().fold(0.0f64, |most, j| most.max(j.abs()));
    // Rounding of a coordinate is so much of a local unit.
    let tolerance = 1e-13 + 16.0 * f64::EPSILON * size * per_length;
    corners.iter().zip(S::SHAPE.reference_corners()).all(|(corner, reference)| {
        map.local(corner).iter().zip(reference).all(|(xi, expected)| (xi - expected).abs() <= tolerance)
    })
}
