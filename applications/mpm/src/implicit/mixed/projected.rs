//! Polynomial pressure projection (Dohrmann and Bochev 2004): what the pressure has beyond its mean over
//! the nodes is resisted, −½ α V₀ ⟨(Σ (N_i − 1/n) p_i)²⟩ in the energy, where ⟨⟩ is the mean over the parent
//! cell.
//!
//! The mean is over the cell and not over its points: in a cell that a body hardly enters, a point near
//! the centre would resist nothing, and the pressures of its nodes tear the point off. In a full
//! cell both are the same.
//!
//! On triangles and tetrahedra the matrix is Kratos's; on quadrilaterals and hexahedra Kratos's does not
//! leave constant pressures alone, this does.

use super::element::{MixedPoint, MixedState};
use crate::implicit::element::add_scaled;
use bia_kernel::solving::CellBuffer;

/// ⟨(N_i − 1/n)(N_j − 1/n)⟩ of linear functions: ⟨N_i N_j⟩ is (1 + δ_ij)/((D + 1)(D + 2)) on simplices,
/// and a product of 1/3 for each coordinate that the two corners share and 1/6 for each other on boxes.
const fn means<const D: usize, const N: usize>() -> [[f64; N]; N] {
    let mut means = [[0.0; N]; N];
    let mut i = 0;
    while i < N {
        let mut j = 0;
        while j < N {
            let mut product = 1.0;
            if N == D + 1 {
                product = if i == j { 2.0 } else { 1.0 } / ((D + 1) * (D + 2)) as f64;
            } else {
                let apart = corner(i) ^ corner(j);
                let mut axis = 0;
                while axis < D {
                    product /= if apart >> axis & 1 == 0 { 3.0 } else { 6.0 };
                    axis += 1;
                }
            }
            means[i][j] = product - 1.0 / (N * N) as f64;
            j += 1;
        }
        i += 1;
    }
    means
}

/// The side of each axis that a corner of a quadrilateral or hexahedron is on, one bit an axis.
const fn corner(node: usize) -> usize {
    node ^ (node >> 1 & 1)
}

/// Adds the terms of one point.
#[inline(always)]
pub fn add<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    state: &MixedState<D, N>,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let means = const { means::<D, N>() };
    let weight = point.reference * point.constants.projection::<D>(state.size);
    for i in 0..N {
        let resisted: f64 = means[i].iter().zip(&state.pressures).map(|(mean, p)| mean * p).sum();
        buffer.vector[i * DOFS + D] += weight * resisted;
    }
    if with_matrix {
        let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
        for i in 0..N {
            add_scaled(&mut rows[(i * DOFS + D) * DOFS + D], -weight, &means[i]);
        }
    }
}
