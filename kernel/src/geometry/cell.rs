//! Shapes as types: functions and gradients on the stack, of a size known to the compiler.

use super::Shape;
use std::array::from_fn;

/// A shape with `D` local coordinates and `N` nodes.
pub trait CellShape<const D: usize, const N: usize>: Copy + Send + Sync + 'static {
    /// The same shape as a value.
    const SHAPE: Shape;
    /// Shape functions N_a(ξ).
    fn functions(xi: &[f64; D]) -> [f64; N];
    /// Local gradients ∂N_a/∂ξ_j as `[a][j]`.
    fn gradients(xi: &[f64; D]) -> [[f64; D]; N];
}

/// Line of two nodes.
#[derive(Debug, Clone, Copy)]
pub struct Line2;

/// Triangle of three nodes.
#[derive(Debug, Clone, Copy)]
pub struct Triangle3;

/// Bilinear quadrilateral of four nodes.
#[derive(Debug, Clone, Copy)]
pub struct Quadrilateral4;

/// Tetrahedron of four nodes.
#[derive(Debug, Clone, Copy)]
pub struct Tetrahedron4;

/// Trilinear hexahedron of eight nodes.
#[derive(Debug, Clone, Copy)]
pub struct Hexahedron8;

/// Evaluates an expression with the type of a solid cell's shape, its dimension and its number of
/// nodes as names: `with_shape!(shape, |S, D, N| expression, else other)`. A point yields `other`.
#[macro_export]
macro_rules! with_shape {
    ($shape:expr, |$S:ident, $D:ident, $N:ident| $body:expr, else $other:expr) => {
        $crate::with_shape!(@ $shape, |$S, $D, $N| $body, else $other,
            Line2 1 2, Triangle3 2 3, Quadrilateral4 2 4, Tetrahedron4 3 4, Hexahedron8 3 8)
    };
    (@ $shape:expr, |$S:ident, $D:ident, $N:ident| $body:expr, else $other:expr,
        $($name:ident $dimension:literal $nodes:literal),*) => {
        match $shape {
            $($crate::geometry::Shape::$name => {
                type $S = $crate::geometry::$name;
                const $D: usize = $dimension;
                const $N: usize = $nodes;
                $body
            })*
            $crate::geometry::Shape::Point1 => $other,
        }
    };
}

impl CellShape<1, 2> for Line2 {
    const SHAPE: Shape = Shape::Line2;

    #[inline]
    fn functions(&[x]: &[f64; 1]) -> [f64; 2] {
        [0.5 * (1.0 - x), 0.5 * (1.0 + x)]
    }

    #[inline]
    fn gradients(_: &[f64; 1]) -> [[f64; 1]; 2] {
        [[-0.5], [0.5]]
    }
}

impl CellShape<2, 3> for Triangle3 {
    const SHAPE: Shape = Shape::Triangle3;

    #[inline]
    fn functions(&[x, y]: &[f64; 2]) -> [f64; 3] {
        [1.0 - x - y, x, y]
    }

    #[inline]
    fn gradients(_: &[f64; 2]) -> [[f64; 2]; 3] {
        [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]
    }
}

impl CellShape<2, 4> for Quadrilateral4 {
    const SHAPE: Shape = Shape::Quadrilateral4;

    #[inline]
    fn functions(&[x, y]: &[f64; 2]) -> [f64; 4] {
        let ([x0, x1], [y0, y1]) = (Line2::functions(&[x]), Line2::functions(&[y]));
        [x0 * y0, x1 * y0, x1 * y1, x0 * y1]
    }

    #[inline]
    fn gradients(&[x, y]: &[f64; 2]) -> [[f64; 2]; 4] {
        let (x, y) = (Line2::functions(&[x]).map(|n| 0.5 * n), Line2::functions(&[y]).map(|n| 0.5 * n));
        [[-y[0], -x[0]], [y[0], -x[1]], [y[1], x[1]], [-y[1], x[0]]]
    }
}

impl CellShape<3, 4> for Tetrahedron4 {
    const SHAPE: Shape = Shape::Tetrahedron4;

    #[inline]
    fn functions(&[x, y, z]: &[f64; 3]) -> [f64; 4] {
        [1.0 - x - y - z, x, y, z]
    }

    #[inline]
    fn gradients(_: &[f64; 3]) -> [[f64; 3]; 4] {
        [[-1.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    }
}

impl CellShape<3, 8> for Hexahedron8 {
    const SHAPE: Shape = Shape::Hexahedron8;

    #[inline]
    fn functions(&[x, y, z]: &[f64; 3]) -> [f64; 8] {
        let (base, z) = (Quadrilateral4::functions(&[x, y]), Line2::functions(&[z]));
        from_fn(|a| base[a % 4] * z[a / 4])
    }

    #[inline]
    fn gradients(&[x, y, z]: &[f64; 3]) -> [[f64; 3]; 8] {
        let (base, slope) = (Quadrilateral4::functions(&[x, y]), Quadrilateral4::gradients(&[x, y]));
        let (z, dz) = (Line2::functions(&[z]), [-0.5, 0.5]);
        from_fn(|a| {
            let (b, layer) = (a % 4, a / 4);
            [slope[b][0] * z[layer], slope[b][1] * z[layer], base[b] * dz[layer]]
        })
    }
}

/// Physical gradients ∂N_a/∂x_i as `[a][i]` (1/m) at ξ for a cell with these corners, and det J.
/// The gradients are not finite where det J is 0.
#[inline]
pub fn physical_gradients<S: CellShape<D, N>, const D: usize, const N: usize>(
    corners: &[[f64; D]; N],
    xi: &[f64; D],
) -> ([[f64; D]; N], f64) {
    let local = S::gradients(xi);
    let (adjugate, determinant) = adjugate(&jacobian(corners, &local));
    let mut gradients = [[0.0; D]; N];
    for a in 0..N {
        for i in 0..D {
            let mut sum = 0.0;
            for j in 0..D {
                sum += local[a][j] * adjugate[j][i];
            }
            gradients[a][i] = sum / determinant;
        }
    }
    (gradients, determinant)
}

/// J\[i\]\[j\] = Σ_a X_a\[i\] ∂N_a/∂ξ_j.
#[inline]
pub(super) fn jacobian<const D: usize, const N: usize>(
    corners: &[[f64; D]; N],
    gradients: &[[f64; D]; N],
) -> [[f64; D]; D] {
    let mut jacobian = [[0.0; D]; D];
    for a in 0..N {
        for i in 0..D {
            for j in 0..D {
                jacobian[i][j] += corners[a][i] * gradients[a][j];
            }
        }
    }
    jacobian
}

/// Adjugate and determinant of a matrix of at most 3 × 3: m · adj m = det m · 1.
#[inline]
pub(super) fn adjugate<const D: usize>(m: &[[f64; D]; D]) -> ([[f64; D]; D], f64) {
    const { assert!(D >= 1 && D <= 3) };
    let mut adjugate = [[1.0; D]; D];
    if D == 2 {
        adjugate[0] = from_fn(|j| [m[1][1], -m[0][1]][j]);
        adjugate[1] = from_fn(|j| [-m[1][0], m[0][0]][j]);
    } else if D == 3 {
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                adjugate[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
            }
        }
    }
    let mut determinant = 0.0;
    for j in 0..D {
        determinant += m[0][j] * adjugate[j][0];
    }
    (adjugate, determinant)
}

#[cfg(test)]
mod tests;
