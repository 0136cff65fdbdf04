//! Vector operations whose sums have one order, whatever the number of threads.

use rayon::prelude::*;

/// Entries summed in one go; partial sums of chunks are added in ascending order.
const CHUNK: usize = 4096;
/// Vectors shorter than this are not worth a fork.
const PARALLEL: usize = 16 * CHUNK;
/// Independent running sums inside a chunk, so that additions overlap and vectorise.
const LANES: usize = 8;

/// `x . y`.
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    if x.len() < PARALLEL {
        return x.chunks(CHUNK).zip(y.chunks(CHUNK)).map(|(x, y)| chunk_dot(x, y)).sum();
    }
    let partial: Vec<f64> = x.par_chunks(CHUNK).zip(y.par_chunks(CHUNK)).map(|(x, y)| chunk_dot(x, y)).collect();
    partial.into_iter().sum()
}

fn chunk_dot(x: &[f64], y: &[f64]) -> f64 {
    let mut lanes = [0.0; LANES];
    let (x_groups, x_rest) = x.as_chunks::<LANES>();
    let (y_groups, y_rest) = y.as_chunks::<LANES>();
    for (x, y) in x_groups.iter().zip(y_groups) {
        for lane in 0..LANES {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(x, y)| x * y).sum();
    lanes.iter().sum::<f64>() + rest
}

/// Euclidean norm.
pub fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// `y += factor * x`.
pub fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += factor * x;
    }
}

/// `y = x + factor * y`.
pub fn scale_and_add(y: &mut [f64], factor: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = x + factor * *y;
    }
}

/// Index of the greatest value, the first one among equals; 0 for an empty sequence.
pub fn position_of_greatest(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, value) in values.enumerate() {
        if value > best.1 {
            best = (index, value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dot_equals_the_exact_sum_of_integers() {
        // Sums of integers below 2^53 are exact in any order.
        for length in [0, 1, 7, 8, 4095, 4097, PARALLEL + 3] {
            let x: Vec<f64> = (0..length).map(|i| (i % 97) as f64).collect();
            let exact: usize = (0..length).map(|i| (i % 97) * (i % 97)).sum();
            assert_eq!(dot(&x, &x), exact as f64);
        }
    }

    #[test]
    fn dot_does_not_depend_on_threads() {
        let x: Vec<f64> = (0..PARALLEL + 1234).map(|i| (i as f64 * 0.7).sin()).collect();
        let results = crate::test_systems::in_pools(|| dot(&x, &x).to_bits());
        assert!(results.windows(2).all(|pair| pair[0] == pair[1]));
    }

    #[test]
    fn greatest_is_the_first_among_equals() {
        assert_eq!(position_of_greatest([1.0, 3.0, 3.0, 2.0].into_iter()), 1);
    }
}
