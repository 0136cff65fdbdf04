//! Strain and deformation of one step, for one point or for points in step.

use super::kratos_faults::KratosFaults;
use crate::settings::Frame;
use bia_constitutive::tensor::{Tensor, adjugate, identity, product, transpose};
use bia_kernel::lanes::Real;

/// What the grid does to a point in one step.
#[derive(Debug, Clone, Copy)]
pub struct Motion<R> {
    /// Deformation gradient at the end.
    pub gradient: Tensor<R>,
    /// Δt ∂v/∂x, with respect to the positions at the start of the step.
    pub step: Tensor<R>,
}

/// The motion of a point with deformation gradient F where Δt times the gradient of the grid's
/// velocity is G. Updated frame: F ← (I + G) F. Total frame, where G is taken with respect to the
/// first positions: F ← F + G.
#[inline(always)]
pub fn deform<R: Real>(before: &Tensor<R>, step: &Tensor<R>, frame: Frame, faults: KratosFaults) -> Motion<R> {
    match frame {
        Frame::Updated => {
            let increment = if let Some(increment) = faults.increment(step) { increment } else { *step };
            Motion { gradient: sum(before, &product(&increment, before)), step: *step }
        }
        Frame::Total => Motion { gradient: sum(before, step), step: product(step, &inverse(before)) },
    }
}

/// What one step adds to a strain in axes that turn with the material: ε ← Q ε Qᵀ + sym G with
/// G = Δt L (I + Δt L/2)⁻¹ and Q = (I − W/2)⁻¹ (I + W/2), W = skew G. Rotations, small or large, leave
/// it alone (Hughes & Winget 1980). Shear is doubled.
#[inline(always)]
pub fn strain<R: Real>(strain: &[R; 6], step: &Tensor<R>, faults: KratosFaults) -> [R; 6] {
    if let Some(increment) = faults.increment(step) {
        return accumulate(strain, &increment);
    }
    let change = product(step, &inverse(&sum(&identity(step[0][0]), &scaled(step, 0.5))));
    let spin = scaled(&sum(&change, &scaled(&transpose(&change), -1.0)), 0.25);
    let turn = inverse(&sum(&identity(step[0][0]), &scaled(&spin, -1.0)));
    let turn = product(&turn, &sum(&identity(step[0][0]), &spin));
    let (xy, yz, xz) = (strain[3] * 0.5, strain[4] * 0.5, strain[5] * 0.5);
    let before = [[strain[0], xy, xz], [xy, strain[1], yz], [xz, yz, strain[2]]];
    let turned = product(&product(&turn, &before), &transpose(&turn));
    let added = scaled(&sum(&change, &transpose(&change)), 0.5);
    accumulate(&[strain[0].constant(0.0); 6], &sum(&turned, &added))
}

/// Adds a strain tensor to Voigt components, shear doubled.
#[inline(always)]
fn accumulate<R: Real>(strain: &[R; 6], increment: &Tensor<R>) -> [R; 6] {
    let e = increment;
    let added = [e[0][0], e[1][1], e[2][2], e[0][1] * 2.0, e[1][2] * 2.0, e[0][2] * 2.0];
    let mut out = *strain;
    for k in 0..6 {
        out[k] += added[k];
    }
    out
}

/// a⁻¹; not finite without one.
#[inline(always)]
pub fn inverse<R: Real>(a: &Tensor<R>) -> Tensor<R> {
    let (mut out, determinant) = adjugate(a);
    let scale = determinant.constant(1.0) / determinant;
    for row in &mut out {
        for entry in row {
            *entry *= scale;
        }
    }
    out
}

#[inline(always)]
fn sum<R: Real>(a: &Tensor<R>, b: &Tensor<R>) -> Tensor<R> {
    let mut out = *a;
    for i in 0..3 {
        for j in 0..3 {
            out[i][j] += b[i][j];
        }
    }
    out
}

#[inline(always)]
fn scaled<R: Real>(a: &Tensor<R>, factor: f64) -> Tensor<R> {
    let mut out = *a;
    for row in &mut out {
        for entry in row {
            *entry = *entry * factor;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use bia_constitutive::tensor::{strain_to_voigt, tensor_of};
    use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

    const PHYSICS: KratosFaults = KratosFaults(false);

    #[test]
    fn a_large_rotation_turns_strain_and_deformation_and_changes_neither() {
        let turn = *Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::new(1.0, -2.0, 0.5)), 0.9).matrix();
        let step = tensor_of(&(turn - Matrix3::identity()));
        let before = Matrix3::new(0.02, 0.01, -0.03, 0.01, -0.05, 0.004, -0.03, 0.004, 0.01);
        let after = strain(&strain_to_voigt(&before), &step, PHYSICS);
        let expected = strain_to_voigt(&(turn * before * turn.transpose()));
        assert!(after.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{after:?} {expected:?}");
        for frame in [Frame::Updated, Frame::Total] {
            let motion = deform(&identity(0.0), &step, frame, PHYSICS);
            assert_eq!((motion.gradient, motion.step), (tensor_of(&turn), step));
        }
        // Kratos strains the body, to second order in the angle.
        let kratos = strain(&[0.0; 6], &step, KratosFaults(true));
        assert!(kratos.iter().any(|e| e.abs() > 0.01), "{kratos:?}");
    }

    /// The same motion seen from the first and from the present positions.
    #[test]
    fn both_frames_agree() {
        let before = tensor_of(&Matrix3::new(1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05));
        let spatial = tensor_of(&Matrix3::new(0.01, 0.02, 0.0, -0.03, 0.02, 0.01, 0.0, 0.04, -0.02));
        let updated = deform(&before, &spatial, Frame::Updated, PHYSICS);
        let total = deform(&before, &product(&spatial, &before), Frame::Total, PHYSICS);
        for i in 0..3 {
            for j in 0..3 {
                assert!((updated.gradient[i][j] - total.gradient[i][j]).abs() < 1e-15);
                assert!((updated.step[i][j] - total.step[i][j]).abs() < 1e-15);
            }
        }
    }

    /// Stretching to λ in n steps: ε tends to ln λ as n⁻², and F is λ.
    #[test]
    fn stretching_accumulates_the_logarithmic_strain() {
        let stretch = 1.5f64;
        let error = |steps: usize| {
            let (mut accumulated, mut gradient) = ([0.0; 6], identity(0.0));
            let mut length = 1.0;
            let added = (stretch - 1.0) / steps as f64;
            for _ in 0..steps {
                let mut step = [[0.0; 3]; 3];
                step[0][0] = added / length;
                accumulated = strain(&accumulated, &step, PHYSICS);
                gradient = deform(&gradient, &step, Frame::Updated, PHYSICS).gradient;
                length += added;
            }
            assert!((gradient[0][0] - stretch).abs() < 1e-14);
            accumulated[0] - stretch.ln()
        };
        let order = (error(10) / error(20)).log2();
        assert!((order - 2.0).abs() < 0.05 && error(20).abs() < 1e-3, "order {order}");
    }
}
