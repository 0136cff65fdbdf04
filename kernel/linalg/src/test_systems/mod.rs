//! Systems that several test modules solve.

mod mixed;

pub use mixed::{MixedBox, Pressure};

use crate::{BlockMatrix, BlockPattern};
use nalgebra::{DMatrix, SMatrix, Vector3};
use std::sync::Arc;

/// Marsaglia's xorshift64: enough to make entries that have no structure.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }

    /// Uniform in -1..1.
    pub fn signed(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

pub fn vector(length: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..length).map(|_| random.signed()).collect()
}

/// Runs `work` in pools of 1, 2 and 8 threads.
pub fn in_pools<T: Send>(work: impl Fn() -> T + Sync) -> Vec<T> {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    [1, 2, 8].map(|threads| pool(threads).install(&work)).into()
}

pub fn dense(matrix: &BlockMatrix) -> DMatrix<f64> {
    let block = matrix.pattern.block();
    DMatrix::from_fn(matrix.pattern.order(), matrix.pattern.order(), |i, j| {
        matrix
            .pattern
            .position(i / block, j / block)
            .map_or(0.0, |entry| matrix.values[entry as usize * block * block + i % block * block + j % block])
    })
}

/// Writes scalar entry (`i`, `j`), which must be in the pattern.
pub fn set(matrix: &mut BlockMatrix, i: usize, j: usize, value: f64) {
    let block = matrix.pattern.block();
    let entry = matrix.pattern.position(i / block, j / block).unwrap() as usize;
    matrix.values[entry * block * block + i % block * block + j % block] = value;
}

/// A ring of `n` nodes with random chords; random entries, strictly diagonally dominant (hence positive
/// definite if symmetric).
pub fn random_system(block: usize, n: usize, symmetric: bool, seed: u64) -> BlockMatrix {
    let mut random = Random::new(seed);
    let cliques: Vec<[u32; 3]> = (0..n).map(|i| [i as u32, ((i + 1) % n) as u32, random.below(n) as u32]).collect();
    let pattern = Arc::new(BlockPattern::from_cliques(block, n, cliques.iter().map(|clique| &clique[..])));
    let mut matrix = BlockMatrix::new(pattern);
    matrix.values.fill_with(|| random.signed());
    let mut full = dense(&matrix);
    if symmetric {
        full = (&full + full.transpose()) * 0.5;
    }
    for i in 0..full.nrows() {
        full[(i, i)] = 0.1 + full.row(i).abs().sum();
        for j in 0..full.ncols() {
            if matrix.pattern.position(i / block, j / block).is_some() {
                set(&mut matrix, i, j, full[(i, j)]);
            }
        }
    }
    matrix
}

/// Second differences on `n` interior points: tridiagonal -1, 2, -1, with `n` distinct eigenvalues.
pub fn laplacian(n: usize) -> BlockMatrix {
    let cells: Vec<[u32; 2]> = (1..n as u32).map(|i| [i - 1, i]).collect();
    let pattern = Arc::new(BlockPattern::from_cliques(1, n, cells.iter().map(|cell| &cell[..])));
    let mut matrix = BlockMatrix::new(pattern);
    for i in 0..n {
        set(&mut matrix, i, i, 2.0);
        if i > 0 {
            set(&mut matrix, i, i - 1, -1.0);
            set(&mut matrix, i - 1, i, -1.0);
        }
    }
    matrix
}

/// `K + 4 M / dt^2` of a cube of trilinear hexahedra with `nodes` nodes along each edge, unit cell size,
/// density and Young's modulus, Poisson's ratio 0.3, lumped mass; `courant` is `dt sqrt(E / rho) / h`.
/// Infinite `courant` gives the stiffness of the free body.
pub fn elastic_box(nodes: usize, courant: f64) -> BlockMatrix {
    let node = |i: usize, j: usize, k: usize| ((i * nodes + j) * nodes + k) as u32;
    let mut cells = Vec::new();
    for (i, j, k) in
        (0..(nodes - 1).pow(3)).map(|c| (c / (nodes - 1).pow(2), c / (nodes - 1) % (nodes - 1), c % (nodes - 1)))
    {
        cells.push(
            [0, 1, 2, 3, 4, 5, 6, 7].map(|corner| node(i + (corner >> 2), j + (corner >> 1 & 1), k + (corner & 1))),
        );
    }
    let pattern = Arc::new(BlockPattern::from_cliques(3, nodes.pow(3), cells.iter().map(|cell| &cell[..])));
    let mut matrix = BlockMatrix::new(pattern);
    let element = hexahedron(4.0 / (8.0 * courant * courant));
    for cell in &cells {
        for (a, &row) in cell.iter().enumerate() {
            for (b, &column) in cell.iter().enumerate() {
                let entry = matrix.pattern.position(row as usize, column as usize).unwrap() as usize;
                for component in 0..9 {
                    matrix.values[entry * 9 + component] += element[(3 * a + component / 3, 3 * b + component % 3)];
                }
            }
        }
    }
    matrix
}

/// Stiffness of the unit hexahedron (2 x 2 x 2 Gauss points) plus `mass` on the diagonal.
fn hexahedron(mass: f64) -> SMatrix<f64, 24, 24> {
    let (lame, shear) = (0.3 / (1.3 * 0.4), 1.0 / 2.6);
    let mut element = SMatrix::<f64, 24, 24>::identity() * mass;
    for point in 0..8usize {
        let x = [2, 1, 0].map(|bit| 0.5 + (if point >> bit & 1 == 1 { 0.5 } else { -0.5 }) / 3f64.sqrt());
        let gradients: Vec<Vector3<f64>> = (0..8usize).map(|corner| corner_gradient(corner, x)).collect();
        for (a, p) in gradients.iter().enumerate() {
            for (b, q) in gradients.iter().enumerate() {
                // Isotropic elasticity: lambda p q^T + mu (q p^T + (p . q) I).
                let block = p * q.transpose() * lame
                    + q * p.transpose() * shear
                    + nalgebra::Matrix3::identity() * (shear * p.dot(q));
                let mut target = element.fixed_view_mut::<3, 3>(3 * a, 3 * b);
                target += block * 0.125;
            }
        }
    }
    element
}

fn corner_gradient(corner: usize, x: [f64; 3]) -> Vector3<f64> {
    let high = [2, 1, 0].map(|bit| corner >> bit & 1 == 1);
    let value = |axis: usize| if high[axis] { x[axis] } else { 1.0 - x[axis] };
    let slope = |axis: usize| if high[axis] { 1.0 } else { -1.0 };
    Vector3::new(slope(0) * value(1) * value(2), value(0) * slope(1) * value(2), value(0) * value(1) * slope(2))
}
