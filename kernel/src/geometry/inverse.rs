//! The inverse map: from physical to local coordinates.

use super::cell::{adjugate, jacobian};
use super::shape::{cross, dot};
use super::{CellShape, Hexahedron8, Quadrilateral4, Shape, Tetrahedron4, Triangle3};
use std::array::from_fn;

/// Newton's steps at most. Quadratic convergence takes four to seven; the rest is for points near
/// a corner where det J vanishes, where each step only halves the error.
const STEPS: usize = 60;

/// Newton's method ends when the next step is expected to be below this.
const ROUNDING: f64 = 1e-17;

/// Steps below this that no longer shrink are the end too: where det J vanishes, rounding leaves
/// the local coordinates no more digits.
const SINGULAR: f64 = 1e-6;

/// Local coordinates of `x` in the cell with these corners, to machine precision: one linear solve
/// for simplices, Newton's method from ξ = 0 for the others.
///
/// None if det J vanishes or Newton's method does not converge (`x` far outside).
#[inline]
pub fn inverse_map<S: CellShape<D, N>, const D: usize, const N: usize>(
    corners: &[[f64; D]; N],
    x: &[f64; D],
) -> Option<[f64; D]> {
    // Measured from x, so that the residual is as exact far from the origin as near it.
    let relative: [[f64; D]; N] = from_fn(|a| from_fn(|i| corners[a][i] - x[i]));
    let mut xi = [0.0; D];
    let mut previous = f64::INFINITY;
    for _ in 0..STEPS {
        let functions = S::functions(&xi);
        let mut residual = [0.0; D];
        for a in 0..N {
            for i in 0..D {
                residual[i] += functions[a] * relative[a][i];
            }
        }
        let (adjugate, determinant) = adjugate(&jacobian(&relative, &S::gradients(&xi)));
        let delta: [f64; D] = from_fn(|j| (0..D).map(|i| adjugate[j][i] * residual[i]).sum::<f64>() / determinant);
        let step = (0..D).fold(0.0, |step, j| (delta[j].abs() / xi[j].abs().max(1.0)).max(step));
        let finite = delta.iter().all(|d| d.is_finite());
        if previous <= SINGULAR && !(finite && step < previous) {
            return Some(xi);
        }
        if !finite {
            return None;
        }
        (0..D).for_each(|j| xi[j] -= delta[j]);
        // Errors go as C e², and C shows in the last two steps; it is about 1 in usual cells.
        let constant = (step / (previous * previous)).max(1.0);
        if S::SHAPE.is_affine() || constant * step * step <= ROUNDING {
            return Some(xi);
        }
        previous = step;
    }
    None
}

/// Local coordinates of `x` in the cell with these corners (one for each node); those beyond the
/// cell's dimension are 0. In space, lines take the foot of `x`; triangles and quadrilaterals take
/// its projection along their mean normal.
///
/// None if the cell is degenerate, if Newton's method does not converge, if the number of corners
/// is not the shape's, and for a point, which has no local coordinates.
pub fn local_coordinates(shape: Shape, corners: &[[f64; 3]], x: [f64; 3]) -> Option<[f64; 3]> {
    match shape {
        Shape::Point1 => None,
        Shape::Line2 => line(corners, x),
        Shape::Triangle3 => surface::<Triangle3, 3>(corners, x),
        Shape::Quadrilateral4 => surface::<Quadrilateral4, 4>(corners, x),
        Shape::Tetrahedron4 => inverse_map::<Tetrahedron4, 3, 4>(corners.try_into().ok()?, &x),
        Shape::Hexahedron8 => inverse_map::<Hexahedron8, 3, 8>(corners.try_into().ok()?, &x),
    }
}

fn line(corners: &[[f64; 3]], x: [f64; 3]) -> Option<[f64; 3]> {
    let &[a, b] = corners else { return None };
    let along = difference(b, a);
    let xi = (dot(difference(x, a), along) + dot(difference(x, b), along)) / dot(along, along);
    xi.is_finite().then_some([xi, 0.0, 0.0])
}

fn surface<S: CellShape<2, N>, const N: usize>(corners: &[[f64; 3]], x: [f64; 3]) -> Option<[f64; 3]> {
    let corners: &[[f64; 3]; N] = corners.try_into().ok()?;
    let xi = if corners.iter().all(|corner| corner[2] == 0.0) {
        inverse_map::<S, 2, N>(&corners.map(|[x, y, _]| [x, y]), &[x[0], x[1]])?
    } else {
        let frame = surface_frame(corners)?;
        let project = |p: [f64; 3]| frame.map(|axis| dot(difference(p, corners[0]), axis));
        inverse_map::<S, 2, N>(&corners.map(project), &project(x))?
    };
    Some([xi[0], xi[1], 0.0])
}

/// Two orthonormal vectors in the mean plane of a triangle or quadrilateral.
fn surface_frame(corners: &[[f64; 3]]) -> Option<[[f64; 3]; 2]> {
    let along = difference(corners[1], corners[0]);
    // The mean normal: of the two edges at node 0, or of the two diagonals.
    let normal = match corners {
        [a, _, c] => cross(along, difference(*c, *a)),
        [a, b, c, d] => cross(difference(*c, *a), difference(*d, *b)),
        _ => return None,
    };
    let second = cross(normal, along);
    let first = cross(second, normal);
    let unit = |v: [f64; 3]| {
        let length = dot(v, v).sqrt();
        (length > 0.0).then(|| v.map(|c| c / length))
    };
    Some([unit(first)?, unit(second)?])
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[cfg(test)]
mod tests;
