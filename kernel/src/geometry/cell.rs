//! Shapes as types: functions and gradients on the stack, of a size known to the compiler.

use super::Shape;
use crate::lanes::Real;

/// A shape with `D` local coordinates and `N` nodes.
pub trait CellShape<const D: usize, const N: usize>: Copy + Send + Sync + 'static {
    /// The same shape as a value.
    const SHAPE: Shape;
    /// Shape functions N_a(ξ).
    fn functions<R: Real>(xi: &[R; D]) -> [R; N];
    /// Local gradients ∂N_a/∂ξ_j as `[a][j]`.
    fn gradients<R: Real>(xi: &[R; D]) -> [[R; D]; N];
}

/// Functions of one cell: those of its shape, or others that may differ from cell to cell.
pub trait CellBasis<const D: usize, const N: usize>: Copy + Send + Sync {
    /// Functions N_a(ξ).
    fn functions<R: Real>(&self, xi: &[R; D]) -> [R; N];
    /// Local gradients ∂N_a/∂ξ_j as `[a][j]`.
    fn gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N];
}

impl<S: CellShape<D, N>, const D: usize, const N: usize> CellBasis<D, N> for S {
    #[inline(always)]
    fn functions<R: Real>(&self, xi: &[R; D]) -> [R; N] {
        <S as CellShape<D, N>>::functions(xi)
    }

    #[inline(always)]
    fn gradients<R: Real>(&self, xi: &[R; D]) -> [[R; D]; N] {
        <S as CellShape<D, N>>::gradients(xi)
    }
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

    #[inline(always)]
    fn functions<R: Real>(&[x]: &[R; 1]) -> [R; 2] {
        [(x.constant(1.0) - x) * 0.5, (x + 1.0) * 0.5]
    }

    #[inline(always)]
    fn gradients<R: Real>(&[x]: &[R; 1]) -> [[R; 1]; 2] {
        [[x.constant(-0.5)], [x.constant(0.5)]]
    }
}

impl CellShape<2, 3> for Triangle3 {
    const SHAPE: Shape = Shape::Triangle3;

    #[inline(always)]
    fn functions<R: Real>(&[x, y]: &[R; 2]) -> [R; 3] {
        [x.constant(1.0) - x - y, x, y]
    }

    #[inline(always)]
    fn gradients<R: Real>(&[x, _]: &[R; 2]) -> [[R; 2]; 3] {
        let (one, zero) = (x.constant(1.0), x.constant(0.0));
        [[-one, -one], [one, zero], [zero, one]]
    }
}

impl CellShape<2, 4> for Quadrilateral4 {
    const SHAPE: Shape = Shape::Quadrilateral4;

    #[inline(always)]
    fn functions<R: Real>(&[x, y]: &[R; 2]) -> [R; 4] {
        let ([x0, x1], [y0, y1]) = (line(x), line(y));
        [x0 * y0, x1 * y0, x1 * y1, x0 * y1]
    }

    #[inline(always)]
    fn gradients<R: Real>(&[x, y]: &[R; 2]) -> [[R; 2]; 4] {
        let ([x0, x1], [y0, y1]) = (line(x), line(y));
        let (x0, x1, y0, y1) = (x0 * 0.5, x1 * 0.5, y0 * 0.5, y1 * 0.5);
        [[-y0, -x0], [y0, -x1], [y1, x1], [-y1, x0]]
    }
}

impl CellShape<3, 4> for Tetrahedron4 {
    const SHAPE: Shape = Shape::Tetrahedron4;

    #[inline(always)]
    fn functions<R: Real>(&[x, y, z]: &[R; 3]) -> [R; 4] {
        [x.constant(1.0) - x - y - z, x, y, z]
    }

    #[inline(always)]
    fn gradients<R: Real>(&[x, ..]: &[R; 3]) -> [[R; 3]; 4] {
        let (one, zero) = (x.constant(1.0), x.constant(0.0));
        [[-one; 3], [one, zero, zero], [zero, one, zero], [zero, zero, one]]
    }
}

impl CellShape<3, 8> for Hexahedron8 {
    const SHAPE: Shape = Shape::Hexahedron8;

    #[inline(always)]
    fn functions<R: Real>(&[x, y, z]: &[R; 3]) -> [R; 8] {
        let base = <Quadrilateral4 as CellShape<2, 4>>::functions(&[x, y]);
        let z = line(z);
        let mut functions = [x; 8];
        for a in 0..8 {
            functions[a] = base[a % 4] * z[a / 4];
        }
        functions
    }

    #[inline(always)]
    fn gradients<R: Real>(&[x, y, z]: &[R; 3]) -> [[R; 3]; 8] {
        let base = <Quadrilateral4 as CellShape<2, 4>>::functions(&[x, y]);
        let slope = <Quadrilateral4 as CellShape<2, 4>>::gradients(&[x, y]);
        let (z, dz) = (line(z), [-0.5, 0.5]);
        let mut gradients = [[x; 3]; 8];
        for a in 0..8 {
            let (b, layer) = (a % 4, a / 4);
            gradients[a] = [slope[b][0] * z[layer], slope[b][1] * z[layer], base[b] * dz[layer]];
        }
        gradients
    }
}

#[inline(always)]
fn line<R: Real>(x: R) -> [R; 2] {
    <Line2 as CellShape<1, 2>>::functions(&[x])
}

/// Physical gradients ∂N_a/∂x_i as `[a][i]` (1/m) at ξ for a cell with these corners, and det J.
/// The gradients are not finite where det J is 0.
#[inline]
pub fn physical_gradients<S: CellShape<D, N>, const D: usize, const N: usize>(
    corners: &[[f64; D]; N],
    xi: &[f64; D],
) -> ([[f64; D]; N], f64) {
    transformed(corners, &<S as CellShape<D, N>>::gradients(xi))
}

/// The same from the local gradients.
#[inline(always)]
pub(super) fn transformed<R: Real, const D: usize, const N: usize>(
    corners: &[[f64; D]; N],
    local: &[[R; D]; N],
) -> ([[R; D]; N], R) {
    let (adjugate, determinant) = adjugate(&jacobian(corners, local));
    let mut gradients = *local;
    for a in 0..N {
        for i in 0..D {
            let mut sum = local[a][0] * adjugate[0][i];
            for j in 1..D {
                sum += local[a][j] * adjugate[j][i];
            }
            gradients[a][i] = sum / determinant;
        }
    }
    (gradients, determinant)
}

/// J\[i\]\[j\] = Σ_a X_a\[i\] ∂N_a/∂ξ_j.
#[inline(always)]
pub fn jacobian<R: Real, const D: usize, const N: usize>(
    corners: &[[f64; D]; N],
    gradients: &[[R; D]; N],
) -> [[R; D]; D] {
    let mut jacobian = [[gradients[0][0].constant(0.0); D]; D];
    for a in 0..N {
        for i in 0..D {
            for j in 0..D {
                jacobian[i][j] += gradients[a][j] * corners[a][i];
            }
        }
    }
    jacobian
}

/// Adjugate and determinant of a matrix of at most 3 × 3: m · adj m = det m · 1.
#[inline(always)]
pub fn adjugate<R: Real, const D: usize>(m: &[[R; D]; D]) -> ([[R; D]; D], R) {
    const { assert!(D >= 1 && D <= 3) };
    let mut adjugate = [[m[0][0].constant(1.0); D]; D];
    if D == 2 {
        adjugate[0].copy_from_slice(&[m[1][1], -m[0][1]]);
        adjugate[1].copy_from_slice(&[-m[1][0], m[0][0]]);
    } else if D == 3 {
        for i in 0..3 {
            let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
            for j in 0..3 {
                let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
                adjugate[j][i] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
            }
        }
    }
    let mut determinant = m[0][0] * adjugate[0][0];
    for j in 1..D {
        determinant += m[0][j] * adjugate[j][0];
    }
    (adjugate, determinant)
}

#[cfg(test)]
mod tests;
