//! An element: what one cell adds to the system of heat conduction, c ∂T/∂t = ∇·(k ∇T).
//!
//! Weak form with the functions N_a of the cell: Σ_b ∫ (N_a N_b c/Δt + ∇N_a·∇N_b k) dV T_b = Σ_b ∫ N_a N_b c/Δt dV T⁰_b.

// [element]
use bia_kernel::geometry::{QuadraturePoint, Shape};
use bia_kernel::solving::CellBuffer;
use nalgebra::{Matrix3, Vector3};

/// Conduction in a solid: capacity per volume and time step c/Δt [W/(m³ K)], and conductivity k [W/(m K)].
#[derive(Debug, Clone, Copy)]
pub struct HeatElement {
    /// c/Δt; 0 without inertia.
    pub capacity_rate: f64,
    /// k.
    pub conductivity: f64,
}

impl HeatElement {
    /// Adds the matrix ∂r/∂T of a cell and its residual r = C (T⁰ − T)/Δt − K T, from the temperatures [K] now and at
    /// the start of the step; none for a cell that is flat or inside out.
    pub fn add(
        &self,
        shape: Shape,
        corners: &[[f64; 3]],
        rule: &[QuadraturePoint],
        [now, start]: [&[f64]; 2],
        cell: &mut CellBuffer,
    ) -> Option<()> {
        let (count, dimension) = (corners.len(), shape.dimension());
        for point in rule {
            let (mut n, mut local) = ([0.0; 8], [[0.0; 3]; 8]);
            shape.functions(point.xi, &mut n);
            shape.gradients(point.xi, &mut local);
            // The axes beyond the cell's dimension are those of space.
            let rows = shape.jacobian(corners, point.xi);
            let jacobian =
                Matrix3::from_fn(|i, j| if j < dimension { rows[i][j] } else { f64::from(u8::from(i == j)) });
            let volume = Some(jacobian.determinant() * point.weight).filter(|volume| *volume > 0.0)?;
            let inverse = jacobian.try_inverse()?;
            let gradients: Vec<Vector3<f64>> =
                local[..count].iter().map(|dn| inverse.transpose() * Vector3::from(*dn)).collect();
            for a in 0..count {
                for b in 0..count {
                    let stored = volume * self.capacity_rate * n[a] * n[b];
                    let conducted = volume * self.conductivity * gradients[a].dot(&gradients[b]);
                    cell.matrix[a * count + b] += stored + conducted;
                    cell.vector[a] += stored * (start[b] - now[b]) - conducted * now[b];
                }
            }
        }
        Some(())
    }
}
// [/element]
