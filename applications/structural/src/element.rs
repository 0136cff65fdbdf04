//! Integrals over one element of the total-Lagrangian displacement formulation.
//!
//! With u the nodal displacements, N and ∂N/∂X in the undeformed element, per integration point:
//!
//! - F_aA = δ_aA + Σ_i u_ia ∂_A N_i;
//! - internal force  f_ia = V₀ Σ_A P_aA ∂_A N_i,  P = J σ F⁻ᵀ (first Piola-Kirchhoff stress);
//! - tangent  K_ia,jb = V₀ Σ_AB ∂_A N_i A_aAbB ∂_B N_j,
//!   A_aAbB = ∂P_aA/∂F_bB = J Σ_cd F⁻¹_Ac (c_acbd + δ_ab σ_cd) F⁻¹_Bd.
//!
//! Axisymmetry adds the component F_θθ = 1 + Σ u_ir N_i/R: a further row N_i/R of the operator that
//! acts on the radial displacement.

use bia_constitutive::{Deformation, Kinematics, Response};
use bia_kernel::geometry::{CellShape, QuadraturePoint, physical_gradients};
use bia_kernel::solving::CellBuffer;
use nalgebra::Matrix3;
use std::f64::consts::TAU;

/// Voigt index of a pair of directions.
const VOIGT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// The components (a, A) of the deformation gradient that vary.
const fn components(kinematics: Kinematics) -> &'static [(usize, usize)] {
    match kinematics {
        Kinematics::UniaxialStrain => &[(0, 0)],
        Kinematics::PlaneStrain | Kinematics::PlaneStress => &[(0, 0), (0, 1), (1, 0), (1, 1)],
        Kinematics::Axisymmetric => &[(0, 0), (0, 1), (1, 0), (1, 1), (2, 2)],
        Kinematics::ThreeDimensional => &[(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)],
    }
}

/// An integration point of an undeformed element.
#[derive(Debug, Clone, Copy)]
pub struct Point<const D: usize, const N: usize> {
    /// Shape functions.
    pub functions: [f64; N],
    /// Row A: ∂N_i/∂X_A (1/m); the third row is N_i/R under axisymmetry.
    operator: [[f64; N]; 3],
    /// Volume that belongs to the point (m³).
    pub volume: f64,
}

impl<const D: usize, const N: usize> Point<D, N> {
    /// The point of a rule in an element with these corners; `extent` is that across the mesh.
    #[inline]
    pub fn new<S: CellShape<D, N>>(
        corners: &[[f64; D]; N],
        point: &QuadraturePoint,
        kinematics: Kinematics,
        extent: f64,
    ) -> Self {
        let xi: [f64; D] = std::array::from_fn(|a| point.xi[a]);
        let functions = S::functions(&xi);
        let (gradients, determinant) = physical_gradients::<S, D, N>(corners, &xi);
        let mut operator = [[0.0; N]; 3];
        for a in 0..D {
            operator[a] = std::array::from_fn(|i| gradients[i][a]);
        }
        let mut volume = point.weight * determinant * extent;
        if kinematics == Kinematics::Axisymmetric {
            let radius: f64 = (0..N).map(|i| functions[i] * corners[i][0]).sum();
            operator[2] = functions.map(|n| n / radius);
            volume *= TAU * radius;
        }
        Self { functions, operator, volume }
    }

    /// The deformation gradient under nodal displacements.
    #[inline]
    pub fn gradient(&self, kinematics: Kinematics, displacements: &[[f64; D]; N]) -> Matrix3<f64> {
        let mut gradient = Matrix3::identity();
        for &(a, b) in components(kinematics) {
            let direction = if a < D { a } else { 0 };
            for i in 0..N {
                gradient[(a, b)] += displacements[i][direction] * self.operator[b][i];
            }
        }
        gradient
    }

    /// Subtracts the internal force from the vector, and adds the tangent to the matrix if wanted.
    #[inline]
    pub fn add_stress(
        &self,
        kinematics: Kinematics,
        deformation: &Deformation,
        response: &Response,
        buffer: &mut CellBuffer,
        with_matrix: bool,
    ) {
        let gradient = &deformation.gradient;
        // The caller has refused what cannot be inverted.
        let inverse = gradient.try_inverse().unwrap_or_else(|| Matrix3::repeat(f64::NAN));
        let scale = self.volume * gradient.determinant();
        let pairs = components(kinematics);
        for &(a, b) in pairs {
            let stress: f64 = (0..3).map(|c| response.stress[VOIGT[a][c]] * inverse[(b, c)]).sum();
            let direction = if a < D { a } else { 0 };
            for i in 0..N {
                buffer.vector[i * D + direction] -= scale * stress * self.operator[b][i];
            }
        }
        if with_matrix {
            let moduli = moduli(pairs, &inverse, scale, response);
            self.add_tangent(pairs, &moduli, &mut buffer.matrix);
        }
    }

    /// All inner loops run over the nodes of the element: they are the lanes of the vectors.
    #[inline]
    fn add_tangent(&self, pairs: &[(usize, usize)], moduli: &[[f64; 9]; 9], matrix: &mut [f64]) {
        let (rows, _) = matrix.as_chunks_mut::<N>();
        for (k, &(a, row)) in pairs.iter().enumerate() {
            let direction = if a < D { a } else { 0 };
            let mut products = [[0.0; N]; D];
            for (l, &(b, column)) in pairs.iter().enumerate() {
                add_scaled(&mut products[if b < D { b } else { 0 }], moduli[k][l], &self.operator[column]);
            }
            for i in 0..N {
                for b in 0..D {
                    add_scaled(&mut rows[(i * D + direction) * D + b], self.operator[row][i], &products[b]);
                }
            }
        }
    }

    /// Subtracts the inertia of nodal accelerations with the consistent mass from the vector, and adds
    /// `factor` times that mass to the matrix if wanted.
    pub fn add_inertia(
        &self,
        density: f64,
        accelerations: &[[f64; D]; N],
        factor: Option<f64>,
        buffer: &mut CellBuffer,
    ) {
        let mass = density * self.volume;
        let acceleration: [f64; D] =
            std::array::from_fn(|a| (0..N).map(|i| self.functions[i] * accelerations[i][a]).sum());
        for i in 0..N {
            for a in 0..D {
                buffer.vector[i * D + a] -= mass * self.functions[i] * acceleration[a];
            }
        }
        if let Some(factor) = factor {
            let (rows, _) = buffer.matrix.as_chunks_mut::<N>();
            for i in 0..N {
                for a in 0..D {
                    add_scaled(&mut rows[(i * D + a) * D + a], factor * mass * self.functions[i], &self.functions);
                }
            }
        }
    }
}

#[inline]
fn add_scaled<const N: usize>(sum: &mut [f64; N], factor: f64, other: &[f64; N]) {
    for j in 0..N {
        sum[j] += factor * other[j];
    }
}

/// A_aAbB times `scale` / J, see the head of the file.
#[inline]
fn moduli(pairs: &[(usize, usize)], inverse: &Matrix3<f64>, scale: f64, response: &Response) -> [[f64; 9]; 9] {
    let mut moduli = [[0.0; 9]; 9];
    for (k, &(a, row)) in pairs.iter().enumerate() {
        for (l, &(b, column)) in pairs.iter().enumerate() {
            let mut sum = 0.0;
            for c in 0..3 {
                for d in 0..3 {
                    let geometric = if a == b { response.stress[VOIGT[c][d]] } else { 0.0 };
                    let material = response.tangent[VOIGT[a][c]][VOIGT[b][d]];
                    sum += inverse[(row, c)] * (material + geometric) * inverse[(column, d)];
                }
            }
            moduli[k][l] = scale * sum;
        }
    }
    moduli
}

#[cfg(test)]
mod tests;
