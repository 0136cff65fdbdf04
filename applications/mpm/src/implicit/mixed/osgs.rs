//! Orthogonal subgrid scales: the projection Π of the residual r = ρ b + ∇p onto the grid's functions,
//! with the lumped L² product of the points, M_k Π_k = Σ V N_k r, M_k = Σ V N_k; and its part in the
//! tangent.
//!
//! Π depends on the unknowns around its node. The tangent gets −D M⁻¹ C with C_ka,· the derivative of
//! Σ V N_k r_a − Π_ka M_k and D_i,ka = −τ₁ V N_k ∂_a N_i that of R_p,i by Π_ka: Π is condensed exactly, at
//! the price of couplings with second neighbours, instead of being a fixed point of slow iterations
//! (spec 06 §5). Inertia lies in the space of the functions and is left out of r.

use super::element::{MixedIntegrator, MixedPoint, MixedState};
use crate::implicit::element::{PointKinematics, add_scaled};
use bia_kernel::error::Failure;
use bia_kernel::geometry::PlacedBasis;
use bia_kernel::solving::{CellBuffer, System};

/// The projection on the active nodes.
#[derive(Default)]
pub struct Projection {
    /// Π, entry `number * D + component` (N/m³).
    pub residual: Vec<f64>,
    /// M_k (m³).
    volume: Vec<f64>,
}

impl Projection {
    /// Divides what the cells have gathered in the right-hand side of `couplings`: D components of
    /// Σ V N_k r, and M_k.
    pub fn divide(&mut self, couplings: &System) {
        let block = couplings.matrix.pattern.block();
        self.residual.clear();
        self.volume.clear();
        for sums in couplings.rhs.chunks_exact(block) {
            let volume = sums[block - 1];
            let inverse = if volume > 0.0 { 1.0 / volume } else { 0.0 };
            self.residual.extend(sums[..block - 1].iter().map(|sum| sum * inverse));
            self.volume.push(volume);
        }
    }

    /// Subtracts D M⁻¹ C, which the cells have gathered in the matrix of `couplings`, from the rows of
    /// pressure of a system that couples second neighbours.
    pub fn condense<const D: usize>(&self, couplings: &System, system: &mut System) {
        let block = D + 1;
        let (pattern, target) = (&couplings.matrix.pattern, system.matrix.pattern.clone());
        let (starts, columns) = (pattern.row_start(), pattern.columns());
        let (target_starts, target_columns) = (target.row_start(), target.columns());
        let values = |entry: usize| &couplings.matrix.values[entry * block * block..(entry + 1) * block * block];
        for (k, volume) in self.volume.iter().enumerate().filter(|(_, volume)| **volume > 0.0) {
            let row = starts[k] as usize..starts[k + 1] as usize;
            for to in row.clone() {
                let weights: [f64; D] = std::array::from_fn(|a| values(to)[D * block + a] / volume);
                if weights == [0.0; D] {
                    continue;
                }
                let i = columns[to] as usize;
                let mut place = target_starts[i] as usize;
                let end = target_starts[i + 1] as usize;
                for from in row.clone() {
                    // Both lists of columns ascend.
                    while place < end && target_columns[place] < columns[from] {
                        place += 1;
                    }
                    if place == end || target_columns[place] != columns[from] {
                        continue;
                    }
                    let of_pressure = &mut system.matrix.values[place * block * block + D * block..][..block];
                    for a in 0..D {
                        let gathered = &values(from)[a * block..(a + 1) * block];
                        for (sum, c) in of_pressure.iter_mut().zip(gathered) {
                            *sum -= weights[a] * c;
                        }
                    }
                }
            }
        }
    }
}

/// The work on one cell, for the widest vectors that the machine has.
pub struct GatherTask<'a, B, const D: usize, const N: usize, const DOFS: usize> {
    /// What all cells share.
    pub integrator: &'a MixedIntegrator<'a>,
    /// Nodal values; the projection counts with the matrix.
    pub state: &'a MixedState<D, N>,
    /// Points: (block, point).
    pub points: &'a [(u32, u32)],
    /// Where the cell's sums go.
    pub buffer: &'a mut CellBuffer,
    /// Whether the couplings are wanted.
    pub with_matrix: bool,
    /// The functions.
    pub basis: B,
}

impl<B: PlacedBasis<D, N>, const D: usize, const N: usize, const DOFS: usize> pulp::WithSimd
    for GatherTask<'_, B, D, N, DOFS>
{
    type Output = Result<(), Failure>;

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) -> Self::Output {
        let Self { integrator, basis, state, points, buffer, with_matrix } = self;
        for &(index, point) in points {
            let block = &integrator.base.blocks[index as usize];
            let of_scene = (integrator.base.kinematics, integrator.base.frame);
            let at = PointKinematics::<D, N>::new(&basis, block, point as usize, of_scene, &state.motion.increments)?;
            let body = block.body_acceleration_of::<D>(point as usize);
            let mass = block.mass.get::<1>(point as usize)[0];
            let constants = &integrator.constants[index as usize];
            let point = MixedPoint::new(&at, constants, (mass, block.density), body, &state.pressures);
            gather::<D, N, DOFS>(&point, state, buffer, with_matrix);
        }
        Ok(())
    }
}

/// Σ V N_k r and M_k in the vector; in the matrix C in the rows of displacement, Dᵀ in those of pressure.
#[inline(always)]
fn gather<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    state: &MixedState<D, N>,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let (at, volume) = (point.at, point.volume);
    if !with_matrix {
        for k in 0..N {
            for a in 0..D {
                buffer.vector[k * DOFS + a] += at.functions[k] * (point.body[a] + volume * point.slope[a]);
            }
            buffer.vector[k * DOFS + D] += at.functions[k] * volume;
        }
        return;
    }
    let tau = point.constants.tau1(state.size);
    let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
    for k in 0..N {
        let share = volume * at.functions[k];
        for a in 0..D {
            let row = (k * DOFS + a) * DOFS;
            let excess = point.slope[a] - state.projection[k][a];
            for b in 0..D {
                add_scaled(&mut rows[row + b], share * excess, &at.gradients[b]);
                add_scaled(&mut rows[row + b], -share * point.slope[b], &at.gradients[a]);
            }
            add_scaled(&mut rows[row + D], share, &at.gradients[a]);
            add_scaled(&mut rows[(k * DOFS + D) * DOFS + a], -tau * share, &at.gradients[a]);
        }
    }
}
