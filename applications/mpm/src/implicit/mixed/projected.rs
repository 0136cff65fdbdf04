//! Polynomial pressure projection (Dohrmann and Bochev 2004): what the pressure has beyond its mean over
//! the nodes is resisted, −½ α V₀ (Σ (N_i − 1/n) p_i)² in the energy.
//!
//! On triangles and tetrahedra the integral of (N_i − 1/n)(N_j − 1/n) is the matrix that Kratos takes;
//! on quadrilaterals and hexahedra Kratos's does not leave constant pressures alone, this does.

use super::element::{MixedPoint, MixedState};
use crate::implicit::element::add_scaled;
use bia_kernel::solving::CellBuffer;

/// Adds the terms of one point.
#[inline(always)]
pub fn add<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    state: &MixedState<D, N>,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let weight = point.reference * point.constants.projection::<D>(state.size);
    let beyond = point.at.functions.map(|n| n - 1.0 / N as f64);
    let pressure: f64 = beyond.iter().zip(&state.pressures).map(|(n, p)| n * p).sum();
    for i in 0..N {
        buffer.vector[i * DOFS + D] += weight * beyond[i] * pressure;
    }
    if with_matrix {
        let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
        for i in 0..N {
            add_scaled(&mut rows[(i * DOFS + D) * DOFS + D], -weight * beyond[i], &beyond);
        }
    }
}
