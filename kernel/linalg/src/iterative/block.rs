//! Dense blocks of `B x B`.

/// Pivots below this part of the diagonal entry they came from count as zero.
const SINGULAR: f64 = 1e-12;

/// A dense block, row by row.
pub type Block<const B: usize> = [[f64; B]; B];

/// Inverse of a symmetric positive definite block by Gauss-Jordan elimination.
///
/// # Errors
/// The component whose pivot is not positive.
pub fn invert_positive<const B: usize>(block: &Block<B>) -> Result<Block<B>, usize> {
    let mut inverse = *block;
    for k in 0..B {
        let pivot = inverse[k][k];
        if pivot.is_nan() || pivot <= SINGULAR * block[k][k] {
            return Err(k);
        }
        sweep(&mut inverse, k, pivot);
    }
    Ok(inverse)
}

/// Inverse of any regular block by Gauss-Jordan elimination with row exchanges; `None` if it is singular.
pub fn invert<const B: usize>(block: &Block<B>) -> Option<Block<B>> {
    let scale = block.iter().flatten().fold(0.0, |scale: f64, value| scale.max(value.abs()));
    let mut inverse = *block;
    let mut exchanged = [0; B];
    for k in 0..B {
        let row = (k..B).fold(k, |best, i| if inverse[i][k].abs() > inverse[best][k].abs() { i } else { best });
        inverse.swap(k, row);
        exchanged[k] = row;
        let pivot = inverse[k][k];
        if pivot.is_nan() || pivot.abs() <= SINGULAR * scale {
            return None;
        }
        sweep(&mut inverse, k, pivot);
    }
    for k in (0..B).rev() {
        inverse.iter_mut().for_each(|row| row.swap(k, exchanged[k]));
    }
    Some(inverse)
}

/// Exchanges the roles of unknown `k` and right-hand side `k`.
fn sweep<const B: usize>(block: &mut Block<B>, k: usize, pivot: f64) {
    block[k][k] = 1.0;
    for j in 0..B {
        block[k][j] /= pivot;
    }
    for i in (0..B).filter(|&i| i != k) {
        let factor = block[i][k];
        block[i][k] = 0.0;
        for j in 0..B {
            block[i][j] -= factor * block[k][j];
        }
    }
}

/// `a b`.
#[inline(always)]
pub fn product<const B: usize>(a: &Block<B>, b: &Block<B>) -> Block<B> {
    let mut c = [[0.0; B]; B];
    for i in 0..B {
        for k in 0..B {
            for j in 0..B {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// `c -= a b`.
#[inline(always)]
pub fn subtract_product<const B: usize>(c: &mut Block<B>, a: &Block<B>, b: &Block<B>) {
    for i in 0..B {
        for k in 0..B {
            for j in 0..B {
                c[i][j] -= a[i][k] * b[k][j];
            }
        }
    }
}

/// `a x`.
#[inline(always)]
pub fn apply<const B: usize>(a: &Block<B>, x: &[f64; B]) -> [f64; B] {
    let mut y = [0.0; B];
    crate::matrix::add_product(&mut y, a, x);
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_identity<const B: usize>(a: &Block<B>, b: &Block<B>) {
        let c = product(a, b);
        for i in 0..B {
            for j in 0..B {
                assert!((c[i][j] - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn inverses_are_inverses() {
        let positive = [[4.0, 1.0, -1.0], [1.0, 3.0, 0.5], [-1.0, 0.5, 2.0]];
        assert_identity(&invert_positive(&positive).unwrap(), &positive);
        // Needs two exchanges that do not commute: a cyclic permutation.
        let cyclic = [[0.0, 2.0, 0.0], [0.0, 0.0, 3.0], [5.0, 0.0, 0.0]];
        assert_identity(&invert(&cyclic).unwrap(), &cyclic);
        let general = [[1.0, 2.0, 3.0, 4.0], [2.0, 4.0, 1.0, 0.0], [0.0, 1.0, 1.0, 5.0], [7.0, 0.0, 2.0, 1.0]];
        assert_identity(&invert(&general).unwrap(), &general);
    }

    #[test]
    fn failed_pivots_are_named() {
        assert_eq!(invert_positive(&[[1.0, 2.0], [2.0, 1.0]]), Err(1));
        assert_eq!(invert_positive(&[[0.0]]), Err(0));
        assert_eq!(invert(&[[1.0, 2.0], [2.0, 4.0]]), None);
    }
}
