//! Vectors and matrices of the dimension of space.

use nalgebra::Matrix3;

/// A vector of space.
pub type Vector<const D: usize> = [f64; D];
/// A tensor, row by row: entry `[i][a]` of a two-point tensor has the present axis i, the reference axis a.
pub type Matrix<const D: usize> = [[f64; D]; D];

/// a · b.
#[inline(always)]
pub fn dot<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> f64 {
    let mut sum = 0.0;
    for i in 0..D {
        sum += a[i] * b[i];
    }
    sum
}

/// m v.
#[inline(always)]
pub fn times<const D: usize>(m: &Matrix<D>, v: &Vector<D>) -> Vector<D> {
    let mut out = [0.0; D];
    for i in 0..D {
        out[i] = dot(&m[i], v);
    }
    out
}

/// a − b.
#[inline(always)]
pub fn minus<const D: usize>(a: &Vector<D>, b: &Vector<D>) -> Vector<D> {
    let mut out = *a;
    for i in 0..D {
        out[i] -= b[i];
    }
    out
}

/// The inverse; not finite where there is none.
#[inline]
pub fn inverse<const D: usize>(m: &Matrix<D>) -> Matrix<D> {
    let (mut adjugate, determinant) = bia_kernel::geometry::adjugate(m);
    for entry in adjugate.as_flattened_mut() {
        *entry /= determinant;
    }
    adjugate
}

/// The square root of a symmetric positive definite matrix and its largest eigenvalue; none if the
/// matrix is not positive definite.
#[inline]
pub fn square_root<const D: usize>(m: &Matrix<D>) -> Option<(Matrix<D>, f64)> {
    let mut root = *m;
    match D {
        1 => {
            root[0][0] = (m[0][0] > 0.0).then(|| m[0][0].sqrt())?;
            Some((root, m[0][0]))
        }
        2 => {
            // (m + √det 1)/√(tr + 2 √det), by the theorem of Cayley and Hamilton.
            let (trace, determinant) = (m[0][0] + m[1][1], m[0][0] * m[1][1] - m[0][1] * m[1][0]);
            if !(determinant > 0.0 && trace > 0.0) {
                return None;
            }
            let area = determinant.sqrt();
            let scale = 1.0 / (trace + 2.0 * area).sqrt();
            for i in 0..2 {
                root[i][i] += area;
                for j in 0..2 {
                    root[i][j] *= scale;
                }
            }
            let half_difference = 0.5 * (m[0][0] - m[1][1]);
            Some((root, 0.5 * trace + half_difference.hypot(m[0][1])))
        }
        _ => {
            let eigen = Matrix3::from_fn(|i, j| m[i][j]).symmetric_eigen();
            if eigen.eigenvalues.min().is_nan() || eigen.eigenvalues.min() <= 0.0 {
                return None;
            }
            let roots = eigen.eigenvalues.map(f64::sqrt);
            for i in 0..D {
                for j in 0..D {
                    root[i][j] =
                        (0..3).map(|k| eigen.eigenvectors[(i, k)] * roots[k] * eigen.eigenvectors[(j, k)]).sum();
                }
            }
            Some((root, eigen.eigenvalues.max()))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const D: usize>(m: Matrix<D>, largest: f64) {
        let (root, found) = square_root(&m).unwrap();
        assert!((found - largest).abs() < 1e-13 * largest, "{found}");
        let back = inverse(&inverse(&root));
        for i in 0..D {
            for j in 0..D {
                let square: f64 = (0..D).map(|k| root[i][k] * back[k][j]).sum();
                assert!((square - m[i][j]).abs() < 1e-13 * largest, "{i}{j}: {square} and {}", m[i][j]);
            }
        }
    }

    #[test]
    fn roots_square_to_the_matrix() {
        check([[4.0]], 4.0);
        check([[2.0, 1.0], [1.0, 2.0]], 3.0);
        check([[3.0, 0.0], [0.0, 7.0]], 7.0);
        check([[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 5.0]], 5.0);
        assert!(square_root(&[[1.0, 2.0], [2.0, 1.0]]).is_none() && square_root(&[[-1.0]]).is_none());
    }
}
