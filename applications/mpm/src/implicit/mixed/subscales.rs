//! Subscales of displacement and pressure, algebraic or orthogonal (Codina 2000; Cervera et al. 2015;
//! Castañar, Baiges and Codina 2020).
//!
//! ũ = τ₁ (ρ b + ∇p − ρ a − Π) and p̃ = τ₂ (U − p/κ) enter as
//! - R_u,ia −= V p̃ ∂_a N_i;
//! - R_p,i += V ũ · ∇N_i + W p̃ N_i/κ.
//!
//! Linear functions leave out the divergence of the deviatoric stress. Π is the projection of ρ b + ∇p
//! onto the grid's functions by [`super::osgs`], zero in ASGS. The part W p̃ N_i/κ is −τ₂/κ times the
//! Galerkin row, and so are its derivatives and that of p̃ by p: [`galerkin_share`]. The tangent is
//! exact.

use super::constants::Constants;
use super::element::{MixedPoint, MixedState};
use crate::implicit::element::add_scaled;
use bia_kernel::solving::CellBuffer;

/// What the subscale of pressure leaves of the Galerkin terms of pressure: 1 − τ₂/κ.
#[inline(always)]
pub fn galerkin_share(constants: &Constants, size: f64) -> f64 {
    1.0 - constants.tau2(size) * constants.moduli.compressibility
}

/// Adds the other terms of one point.
#[inline(always)]
pub fn add<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    state: &MixedState<D, N>,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    add_pressure::<D, N, DOFS>(point, state.size, buffer, with_matrix);
    let at = point.at;
    let tau = point.constants.tau1(state.size);
    let project = |values: &[[f64; D]; N], a: usize| -> f64 { (0..N).map(|i| at.functions[i] * values[i][a]).sum() };
    let inertia = if point.constants.inertia > 0.0 { point.mass } else { 0.0 };
    let mut rest = point.slope;
    let mut residual = point.body;
    for a in 0..D {
        rest[a] -= project(&state.projection, a);
        residual[a] += point.volume * rest[a] - inertia * project(&state.acceleration, a);
    }
    let mut flux = [0.0; N];
    let mut along = [0.0; N];
    for a in 0..D {
        add_scaled(&mut flux, residual[a], &at.gradients[a]);
        add_scaled(&mut along, rest[a], &at.gradients[a]);
    }
    for i in 0..N {
        buffer.vector[i * DOFS + D] += tau * flux[i];
    }
    if !with_matrix {
        return;
    }
    let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
    let (volume, inertia) = (tau * point.volume, tau * inertia * point.constants.inertia);
    for i in 0..N {
        let mut laplacian = [0.0; N];
        for a in 0..D {
            add_scaled(&mut laplacian, at.gradients[a][i], &at.gradients[a]);
        }
        let row = (i * DOFS + D) * DOFS;
        for b in 0..D {
            let sum = &mut rows[row + b];
            add_scaled(sum, -volume * along[i], &at.gradients[b]);
            add_scaled(sum, volume * point.slope[b], &laplacian);
            add_scaled(sum, tau * at.gradients[b][i], &flux);
            add_scaled(sum, inertia * at.gradients[b][i], &at.functions);
        }
        add_scaled(&mut rows[row + D], -volume, &laplacian);
    }
}

/// The forces of p̃, and what they gain with the displacements.
#[inline(always)]
pub fn add_pressure<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    size: f64,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let (at, moduli, tau) = (point.at, &point.constants.moduli, point.constants.tau2(size));
    if tau == 0.0 {
        return;
    }
    let subscale = tau * (moduli.volumetric.change(point.change) - moduli.compressibility * point.pressure);
    for i in 0..N {
        for a in 0..D {
            buffer.vector[i * DOFS + a] -= point.volume * subscale * at.gradients[a][i];
        }
    }
    if !with_matrix {
        return;
    }
    let stiffness = point.volume * (tau * moduli.volumetric.slope(point.jacobian()) + subscale);
    let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
    for i in 0..N {
        for a in 0..D {
            for b in 0..D {
                let sum = &mut rows[(i * DOFS + a) * DOFS + b];
                add_scaled(sum, stiffness * at.gradients[a][i], &at.gradients[b]);
                add_scaled(sum, -point.volume * subscale * at.gradients[b][i], &at.gradients[a]);
            }
        }
    }
}
