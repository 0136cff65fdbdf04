//! Vectors and matrices of the dimension of space.

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
            let eigenvalues = eigenvalues(m);
            if eigenvalues.iter().any(|value| value.is_nan() || *value <= 0.0) {
                return None;
            }
            // The invariants of the root, then (i iii 1 + (i² − ii) m − m²)/(i ii − iii): Hoger and Carlson,
            // Quart. Appl. Math. 42 (1984) 113-117.
            let [a, b, c] = eigenvalues.map(f64::sqrt);
            let (first, second, third) = (a + b + c, a * b + b * c + c * a, a * b * c);
            let scale = 1.0 / (first * second - third);
            for i in 0..D {
                for j in 0..D {
                    let square: f64 = (0..D).map(|k| m[i][k] * m[k][j]).sum();
                    let unit = if i == j { first * third } else { 0.0 };
                    root[i][j] = scale * (unit + (first * first - second) * m[i][j] - square);
                }
            }
            Some((root, eigenvalues[0]))
        }
    }
}

/// Eigenvalues of a symmetric matrix of 3 × 3 by Cardano's formula; of nearly equal ones the symmetric
/// functions are exact to round-off, each to its square root.
#[inline]
fn eigenvalues<const D: usize>(m: &Matrix<D>) -> [f64; 3] {
    let mean = (m[0][0] + m[1][1] + m[2][2]) / 3.0;
    let mut deviator = *m;
    (0..D).for_each(|i| deviator[i][i] -= mean);
    let size = (deviator.as_flattened().iter().map(|entry| entry * entry).sum::<f64>() / 6.0).sqrt();
    if size <= f64::EPSILON * mean.abs() {
        return [mean; 3];
    }
    deviator.as_flattened_mut().iter_mut().for_each(|entry| *entry /= size);
    let (_, determinant) = bia_kernel::geometry::adjugate(&deviator);
    let angle = (0.5 * determinant).clamp(-1.0, 1.0).acos() / 3.0;
    let largest = mean + 2.0 * size * angle.cos();
    let smallest = mean + 2.0 * size * (angle + std::f64::consts::TAU / 3.0).cos();
    [largest, smallest, 3.0 * mean - largest - smallest]
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
        check([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], 2.0);
        check([[2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]], 4.0);
        assert!(square_root(&[[1.0, 2.0], [2.0, 1.0]]).is_none() && square_root(&[[-1.0]]).is_none());
    }
}
