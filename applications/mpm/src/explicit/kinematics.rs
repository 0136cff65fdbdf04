//! Shape functions at a point, and the strain and deformation of one step there.

use super::kratos_faults::{KratosFaults, accumulate};
use bia_constitutive::Voigt;
use bia_constitutive::tensor::stress_from_voigt;
use bia_kernel::geometry::{CellShape, physical_gradients};
use nalgebra::Matrix3;

/// Shape functions and gradients at a point.
pub struct ShapeAt<const D: usize, const N: usize> {
    /// All functions: they carry mass, momentum and body forces to the grid.
    pub all: [f64; N],
    /// Functions for everything else; they differ from `all` by a fault of Kratos alone.
    pub functions: [f64; N],
    /// Gradients in 1/m at `[node][axis]`.
    pub gradients: [[f64; D]; N],
}

impl<const D: usize, const N: usize> ShapeAt<D, N> {
    /// Functions and gradients.
    #[inline(always)]
    pub fn new<S: CellShape<D, N>>(corners: &[[f64; D]; N], xi: &[f64; D], faults: KratosFaults) -> Self {
        let all = S::functions(xi);
        let (mut functions, (mut gradients, _)) = (all, physical_gradients::<S, D, N>(corners, xi));
        faults.misalign(&mut functions, &mut gradients);
        Self { all, functions, gradients }
    }

    /// Functions alone.
    #[inline(always)]
    pub fn functions<S: CellShape<D, N>>(xi: &[f64; D], faults: KratosFaults) -> Self {
        let all = S::functions(xi);
        let (mut functions, mut gradients) = (all, [[0.0; D]; N]);
        faults.misalign(&mut functions, &mut gradients);
        Self { all, functions, gradients }
    }

    /// Distance from the axis, for axisymmetric scenes.
    #[inline(always)]
    pub fn radius(&self, corners: &[[f64; D]; N]) -> f64 {
        (0..N).map(|i| self.all[i] * corners[i][0]).sum()
    }

    /// The gradient of a nodal velocity, with the hoop rate if axisymmetric.
    #[inline(always)]
    pub fn velocity_gradient(
        &self,
        corners: &[[f64; D]; N],
        velocity: &[[f64; D]; N],
        axisymmetric: bool,
    ) -> Matrix3<f64> {
        let mut sum = [[0.0; D]; D];
        for i in 0..N {
            for a in 0..D {
                for b in 0..D {
                    sum[a][b] += velocity[i][a] * self.gradients[i][b];
                }
            }
        }
        let mut gradient = Matrix3::zeros();
        for a in 0..D {
            for b in 0..D {
                gradient[(a, b)] = sum[a][b];
            }
        }
        if axisymmetric {
            let radial: f64 = (0..N).map(|i| self.functions[i] * velocity[i][0]).sum();
            gradient[(2, 2)] = radial / self.radius(corners);
        }
        gradient
    }
}

/// What one step does to a point's deformation gradient: F ← (I + Δt L) F, as the grid moves.
#[inline(always)]
pub fn deform(
    gradient: &Matrix3<f64>,
    velocity_gradient: &Matrix3<f64>,
    time_step: f64,
    faults: KratosFaults,
) -> Matrix3<f64> {
    let increment = faults.increment(velocity_gradient, time_step).unwrap_or_else(|| time_step * velocity_gradient);
    gradient + increment * gradient
}

/// What one step adds to a strain in axes that turn with the material: ε ← Q ε Qᵀ + sym G with
/// G = Δt L (I + Δt L/2)⁻¹ and Q = (I − W/2)⁻¹ (I + W/2), W = skew G. Rotations, small or large, leave
/// it alone (Hughes & Winget 1980).
#[inline(always)]
pub fn strain(strain: &Voigt, velocity_gradient: &Matrix3<f64>, time_step: f64, faults: KratosFaults) -> Voigt {
    if let Some(increment) = faults.increment(velocity_gradient, time_step) {
        return accumulate(strain, &increment);
    }
    let step = time_step * velocity_gradient;
    let middle = Matrix3::identity() + 0.5 * step;
    let Some(back) = middle.try_inverse() else { return [f64::NAN; 6] };
    let change = step * back;
    let spin = 0.25 * (change - change.transpose());
    let Some(turn) = (Matrix3::identity() - spin).try_inverse() else { return [f64::NAN; 6] };
    let turn = turn * (Matrix3::identity() + spin);
    let halved = std::array::from_fn(|i| if i < 3 { strain[i] } else { 0.5 * strain[i] });
    let turned = turn * stress_from_voigt(&halved) * turn.transpose();
    accumulate(&[0.0; 6], &(turned + 0.5 * (change + change.transpose())))
}

/// det F of a stored deformation gradient (see [`crate::points::expand`]).
#[inline(always)]
pub fn jacobian(row: &[f64]) -> f64 {
    match *row {
        [a] => a,
        [a, b, c, d] => a * d - b * c,
        [a, b, c, d, e] => (a * d - b * c) * e,
        [a, b, c, d, e, f, g, h, i] => a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bia_constitutive::tensor::strain_to_voigt;
    use nalgebra::{Rotation3, Unit, Vector3};

    const PHYSICS: KratosFaults = KratosFaults(false);

    #[test]
    fn a_large_rotation_turns_strain_and_deformation_and_changes_neither() {
        let turn = *Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5)), 0.9).matrix();
        let time_step = 0.1;
        let rate = (turn - Matrix3::identity()) / time_step;
        let before = Matrix3::new(0.02, 0.01, -0.03, 0.01, -0.05, 0.004, -0.03, 0.004, 0.01);
        let after = strain(&strain_to_voigt(&before), &rate, time_step, PHYSICS);
        let expected = strain_to_voigt(&(turn * before * turn.transpose()));
        assert!(after.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{after:?} {expected:?}");
        let deformed = deform(&Matrix3::identity(), &rate, time_step, PHYSICS);
        assert!((deformed - turn).norm() < 1e-15);
        // Kratos strains the body, to second order in the angle.
        let kratos = strain(&[0.0; 6], &rate, time_step, KratosFaults(true));
        assert!(kratos.iter().any(|e| e.abs() > 0.1), "{kratos:?}");
    }

    /// Stretching to λ in n steps: ε tends to ln λ as n⁻², and F is λ.
    #[test]
    fn stretching_accumulates_the_logarithmic_strain() {
        let stretch = 1.5f64;
        let error = |steps: usize| {
            let (mut accumulated, mut gradient) = ([0.0; 6], Matrix3::identity());
            let mut length = 1.0;
            let added = (stretch - 1.0) / steps as f64;
            for _ in 0..steps {
                let mut rate = Matrix3::zeros();
                rate[(0, 0)] = added / length;
                accumulated = strain(&accumulated, &rate, 1.0, PHYSICS);
                gradient = deform(&gradient, &rate, 1.0, PHYSICS);
                length += added;
            }
            assert!((gradient[(0, 0)] - stretch).abs() < 1e-14);
            accumulated[0] - stretch.ln()
        };
        let order = (error(10) / error(20)).log2();
        assert!((order - 2.0).abs() < 0.05 && error(20).abs() < 1e-3, "order {order}");
    }

    #[test]
    fn the_determinant_of_stored_gradients() {
        let full = Matrix3::new(1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05);
        let mut row = [0.0; 9];
        crate::points::compress(&full, &mut row);
        assert!((jacobian(&row) - full.determinant()).abs() < 1e-15);
        assert_eq!(jacobian(&[2.0, 1.0, 0.5, 3.0, 2.0]), 11.0);
    }
}
