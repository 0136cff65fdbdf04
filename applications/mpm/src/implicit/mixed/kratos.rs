//! Stabilisations as Kratos has them, so that its results can be compared: the pressure projection of
//! 10.4.4, whose matrix is that of triangles on quadrilaterals, too, where it resists constant pressure;
//! and the subscales of its development branch (spec 06 §4), the tangent of which is not the derivative
//! of the residual.

use super::element::{MixedPoint, MixedState};
use crate::implicit::element::add_scaled;
use bia_kernel::solving::CellBuffer;

/// Voigt index of a pair of directions.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// P = α/36 (3 I − 1 1ᵀ) in the plane and α/80 (4 I − 1 1ᵀ) in space, over the reference volume.
#[inline(always)]
pub fn add_projected<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    state: &MixedState<D, N>,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let (corners, sum) = if D == 3 { (4.0, 80.0) } else { (3.0, 36.0) };
    let weight = point.reference * point.constants.kratos_projection::<D>() / sum;
    let total: f64 = state.pressures.iter().sum();
    for i in 0..N {
        buffer.vector[i * DOFS + D] += weight * (corners * state.pressures[i] - total);
        if with_matrix {
            let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
            let row = &mut rows[(i * DOFS + D) * DOFS + D];
            for j in 0..N {
                row[j] -= weight * if i == j { corners - 1.0 } else { -1.0 };
            }
        }
    }
}

/// The adjoint's part A_i + D_ia at `[a][i]`: ∇N_i · ∇p and Bᵀ T of half-sums of ∇p.
#[inline(always)]
fn adjoint<const D: usize, const N: usize>(point: &MixedPoint<D, N>) -> [[f64; N]; D] {
    let (g, gradients) = (&point.slope, &point.at.gradients);
    let sum: f64 = g.iter().sum();
    let mut tensor = [0.0; 6];
    for a in 0..D {
        tensor[a] = sum - 2.0 * g[a];
        for b in 0..a {
            tensor[VOIGT[a][b]] = -0.5 * (g[a] + g[b]);
        }
    }
    let mut along = [0.0; N];
    (0..D).for_each(|k| add_scaled(&mut along, g[k], &gradients[k]));
    let mut adjoint = [along; D];
    for a in 0..D {
        for b in 0..D {
            add_scaled(&mut adjoint[a], tensor[VOIGT[a][b]], &gradients[b]);
        }
    }
    adjoint
}

/// Subscales with τ₁ = c₁ h²/(2 μ) and τ₂ = 2 c₂ μ, without inertia.
#[inline(always)]
pub fn add_subscales<const D: usize, const N: usize, const DOFS: usize>(
    point: &MixedPoint<D, N>,
    state: &MixedState<D, N>,
    buffer: &mut CellBuffer,
    with_matrix: bool,
) {
    let (gradients, functions) = (&point.at.gradients, &point.at.functions);
    let compressibility = point.constants.moduli.compressibility;
    let (tau1, tau2) = (point.constants.kratos_tau1(state.size), point.constants.kratos_tau2());
    let volume = point.volume;
    let adjoint = adjoint(point);
    let residual: [f64; D] = std::array::from_fn(|a| -point.body[a] / volume - point.slope[a]);
    let defect = compressibility * point.pressure - point.change / point.jacobian();
    for i in 0..N {
        let mut flux = 0.0;
        for a in 0..D {
            let force = -tau1 * residual[a] * adjoint[a][i] + tau2 * defect * gradients[a][i];
            buffer.vector[i * DOFS + a] += volume * force;
            flux += gradients[a][i] * residual[a];
        }
        buffer.vector[i * DOFS + D] -= volume * (tau1 * flux + tau2 * defect * functions[i] * compressibility);
    }
    if !with_matrix {
        return;
    }
    let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
    for i in 0..N {
        let mixed = volume * tau2 * compressibility;
        let row = (i * DOFS + D) * DOFS;
        for a in 0..D {
            for b in 0..D {
                let sum = &mut rows[(i * DOFS + a) * DOFS + b];
                add_scaled(sum, -volume * tau1 * adjoint[a][i], &adjoint[b]);
                add_scaled(sum, volume * tau2 * gradients[a][i], &gradients[b]);
            }
            let sum = &mut rows[(i * DOFS + a) * DOFS + D];
            add_scaled(sum, -volume * tau1 * gradients[a][i], &adjoint[a]);
            add_scaled(sum, -mixed * gradients[a][i], functions);
            let sum = &mut rows[row + a];
            add_scaled(sum, -volume * tau1 * gradients[a][i], &adjoint[a]);
            add_scaled(sum, -mixed * functions[i], &gradients[a]);
            add_scaled(&mut rows[row + D], -volume * tau1 * gradients[a][i], &gradients[a]);
        }
        add_scaled(&mut rows[row + D], mixed * compressibility * functions[i], functions);
    }
}
