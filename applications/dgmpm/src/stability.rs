//! The stable Courant number c Δt/h of a layout of points: the largest for which no wave on an endless
//! lattice of equal cells grows (von Neumann), found with the scheme itself.
//!
//! One step from a unit value in one cell of a periodic lattice gives the blocks D_o of the
//! amplification matrix; with the wave vector θ it is Σ_o D_o exp(−i θ·o). Its powers must stay bounded.
//! In one dimension also the largest sum of |D| over a row is known for the waves of either direction:
//! up to 1 no value leaves the range of its neighbours (Renaud, thesis, 2018).

use crate::faces::{CHUNK, Faces};
use crate::kind::{CellKind, Place};
use crate::material::{Hooke, Material};
use crate::riemann::RiemannSolver;
use crate::scheme::{Method, Scheme};
use bia_kernel::geometry::CellShape;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Courant numbers are told to this.
const RESOLUTION: f64 = 0.005;
/// The largest that is looked at, in units of the above.
const LARGEST: usize = 320;
/// Powers are taken to 2 to this: a wave that grows by 1e-4 a step is found.
const SQUARINGS: usize = 16;
/// A power whose norm is above this times the number of unknowns belongs to a growing wave.
const GROWN: f64 = 10.0;

/// What is analysed: equal boxes with a layout of points of one material.
#[derive(Debug, Clone, PartialEq)]
pub struct Lattice<'a, const D: usize> {
    /// Edges of the cells (m).
    pub edges: [f64; D],
    /// Points of a cell.
    pub places: &'a [Place],
    /// Hooke's law.
    pub hooke: Hooke,
    /// Mass per volume (kg/m³).
    pub density: f64,
    /// The scheme.
    pub method: Method,
}

/// Largest Courant numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// No wave grows.
    pub spectral: f64,
    /// No value leaves the range of its neighbours; in one dimension only.
    pub no_overshoot: Option<f64>,
}

/// Blocks of the amplification matrix: the cell's distance in cells, and its response.
type Blocks<const D: usize> = Vec<([f64; D], DMatrix<f64>)>;

/// The limits of a lattice; none if even the smallest step is not stable.
pub fn limits<S: CellShape<D, N>, const D: usize, const N: usize>(lattice: &Lattice<D>) -> Option<Limits> {
    let corners = std::array::from_fn(|node| {
        std::array::from_fn(|a| if S::SHAPE.reference_corners()[node][a] > 0.0 { lattice.edges[a] } else { 0.0 })
    });
    let stages = lattice.method.time_integration.stages();
    let kind = CellKind::new::<S, N>(&corners, lattice.places, (0, lattice.density, 1.0), stages).ok()?;
    let waves = wave_vectors::<D>(unknowns::<D>() * lattice.places.len());
    let largest = |stable: &(dyn Fn(&Blocks<D>) -> bool + Sync)| {
        let (mut low, mut high) = (0, LARGEST + 1);
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            let courant = middle as f64 * RESOLUTION;
            let ok = blocks(lattice, &kind, courant).is_some_and(|blocks| stable(&blocks));
            if ok { low = middle } else { high = middle }
        }
        low as f64 * RESOLUTION
    };
    let bounded = |blocks: &Blocks<D>| waves.par_iter().all(|wave| is_bounded(blocks, wave));
    let no_overshoot = (D == 1).then(|| largest(&|blocks| row_sum(blocks) <= 1.0 + 1e-9));
    Some(Limits { spectral: largest(&bounded), no_overshoot }).filter(|limits| limits.spectral > 0.0)
}

/// Velocities and strains.
const fn unknowns<const D: usize>() -> usize {
    D + D * (D + 1) / 2
}

/// Wave vectors of half the space, coarser for many unknowns.
fn wave_vectors<const D: usize>(unknowns: usize) -> Vec<[f64; D]> {
    let steps: i32 = match (D, unknowns) {
        (1, _) => 32,
        (2, _) => 8,
        (3, ..=9) => 4,
        _ => 2,
    };
    let mut list = vec![[0.0; D]];
    for axis in 0..D {
        let range = if axis == 0 { 0..=steps } else { 1 - steps..=steps };
        list = range
            .flat_map(|k| {
                list.iter().map(move |wave| {
                    let mut wave = *wave;
                    wave[axis] = PI * f64::from(k) / f64::from(steps);
                    wave
                })
            })
            .collect();
    }
    list
}

/// One step from each unit value.
fn blocks<const D: usize>(lattice: &Lattice<D>, kind: &CellKind<D>, courant: f64) -> Option<Blocks<D>> {
    let reach = lattice.method.time_integration.stages().len();
    let (count, points) = (2 * reach + 1, lattice.places.len());
    let (cells, size) = (count.pow(D as u32), unknowns::<D>() * points);
    let material =
        Material { id: 0, name: String::new(), density: lattice.density, extent: 1.0, hooke: lattice.hooke, law: None };
    let speed = material.wave_speed();
    let step = courant * lattice.edges.iter().fold(f64::INFINITY, |least, &edge| least.min(edge)) / speed;
    // Exact and linearised solvers are the same for a linear law.
    let riemann = match lattice.method.riemann {
        RiemannSolver::Exact => RiemannSolver::Linearized,
        other => other,
    };
    let method = Method { riemann, ..lattice.method };
    let mut scheme =
        Scheme::new(method, vec![material], vec![kind.clone()], &[vec![0; cells]], Faces::lattice(&[count; D]));
    let distance = |cell: usize| {
        std::array::from_fn(|axis| {
            let place = cell / count.pow(axis as u32) % count;
            place as f64 - if place > reach { count as f64 } else { 0.0 }
        })
    };
    let mut blocks: Blocks<D> = (0..cells).map(|cell| (distance(cell), DMatrix::zeros(size, size))).collect();
    for column in 0..size {
        for chunk in &mut scheme.chunks {
            chunk.points.velocity.fill([0.0; D]);
            chunk.points.gradient.fill([[0.0; D]; D]);
        }
        write(&mut scheme, column, 1.0 / speed);
        scheme.start().ok()?;
        scheme.step(step).ok()?;
        for (cell, (_, block)) in blocks.iter_mut().enumerate() {
            for row in 0..size {
                block[(row, column)] = read(&scheme, cell, row, speed);
            }
        }
    }
    Some(blocks)
}

/// Point, and component of the velocity or pair of axes of the strain, of an unknown.
fn unknown<const D: usize>(index: usize) -> (usize, Result<usize, (usize, usize)>) {
    let (point, k) = (index / unknowns::<D>(), index % unknowns::<D>());
    if k < D {
        return (point, Ok(k));
    }
    let mut pairs = (0..D).flat_map(|i| (i..D).map(move |a| (i, a)));
    (point, Err(pairs.nth(k - D).unwrap_or((0, 0))))
}

fn write<const D: usize>(scheme: &mut Scheme<D>, index: usize, strain: f64) {
    match unknown::<D>(index) {
        (point, Ok(i)) => scheme.chunks[0].points.velocity[point][i] = 1.0,
        (point, Err((i, a))) => {
            scheme.chunks[0].points.gradient[point][i][a] += 0.5 * strain;
            scheme.chunks[0].points.gradient[point][a][i] += 0.5 * strain;
        }
    }
}

fn read<const D: usize>(scheme: &Scheme<D>, cell: usize, index: usize, speed: f64) -> f64 {
    let (point, what) = unknown::<D>(index);
    let chunk = &scheme.chunks[cell / CHUNK];
    let place = cell % CHUNK * chunk.points_per_cell + point;
    match what {
        Ok(i) => chunk.points.velocity[place][i],
        Err((i, a)) => 0.5 * speed * (chunk.points.gradient[place][i][a] + chunk.points.gradient[place][a][i]),
    }
}

/// Whether the powers of the amplification matrix stay bounded.
fn is_bounded<const D: usize>(blocks: &Blocks<D>, wave: &[f64; D]) -> bool {
    let size = blocks[0].1.nrows();
    let mut matrix = DMatrix::from_element(size, size, Complex::new(0.0, 0.0));
    for (distance, block) in blocks {
        let phase: f64 = distance.iter().zip(wave).map(|(d, w)| d * w).sum();
        let factor = Complex::from_polar(1.0, -phase);
        matrix.zip_apply(block, |entry, b| *entry += factor * b);
    }
    for _ in 0..SQUARINGS {
        matrix = &matrix * &matrix;
        let norm = matrix.iter().map(|entry| entry.norm_sqr()).sum::<f64>().sqrt();
        if norm.is_nan() || norm > GROWN * size as f64 {
            return false;
        }
    }
    true
}

/// Largest sum of |D| over the rows of the waves v ∓ c H of either direction; one dimension only.
fn row_sum<const D: usize>(blocks: &Blocks<D>) -> f64 {
    let points = blocks[0].1.nrows() / 2;
    let mut largest = 0.0_f64;
    for sign in [-1.0, 1.0] {
        for row in 0..points {
            let mut sum = 0.0;
            for (_, d) in blocks {
                for column in 0..points {
                    let (r, c) = (2 * row, 2 * column);
                    // A wave v = −sign c H of unit size moves v and c H by half of it each.
                    let of_velocity = 0.5 * (d[(r, c)] + sign * d[(r, c + 1)]);
                    let of_strain = 0.5 * (d[(r + 1, c)] + sign * d[(r + 1, c + 1)]);
                    sum += (of_velocity + sign * of_strain).abs();
                }
            }
            largest = largest.max(sum);
        }
    }
    largest
}

#[cfg(test)]
mod tests;
