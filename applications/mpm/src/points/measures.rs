//! Strains and stresses of a point in every measure, from its deformation gradient F and its stored
//! Cauchy stress σ: computed where they are shown, so that no column holds them.

use super::block::{Block, expand};
use bia_constitutive::tensor::{displacement_gradient, stress_from_voigt, stress_to_voigt};
use bia_constitutive::{Deformation, Kinematics, Law, Voigt};
use nalgebra::Matrix3;

/// Hencky strain ln √b, b = F Fᵀ; not a number where F is singular.
///
/// From the eigenvalues β of b − I, as ½ Σ ln(1 + β) n ⊗ n, which keeps its digits at small strain.
pub fn hencky_strain(f: &Matrix3<f64>) -> Matrix3<f64> {
    let h = displacement_gradient(f);
    let eigen = (h + h.transpose() + h * h.transpose()).symmetric_eigen();
    let logarithms = eigen.eigenvalues.map(|beta| 0.5 * beta.ln_1p());
    eigen.eigenvectors * Matrix3::from_diagonal(&logarithms) * eigen.eigenvectors.transpose()
}

/// First Piola–Kirchhoff stress P = J σ F⁻ᵀ, force per area before deformation; not a number where F
/// is singular.
pub fn first_piola_kirchhoff(stress: &Matrix3<f64>, f: &Matrix3<f64>) -> Matrix3<f64> {
    let inverse = f.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
    f.determinant() * stress * inverse.transpose()
}

/// Second Piola–Kirchhoff stress S = F⁻¹ P, symmetric.
pub fn second_piola_kirchhoff(stress: &Matrix3<f64>, f: &Matrix3<f64>) -> Matrix3<f64> {
    let inverse = f.try_inverse().unwrap_or(Matrix3::repeat(f64::NAN));
    inverse * first_piola_kirchhoff(stress, f)
}

/// Von Mises stress √(3/2 dev σ : dev σ).
pub fn von_mises(stress: &Matrix3<f64>) -> f64 {
    let deviator = stress - Matrix3::from_diagonal_element(stress.trace() / 3.0);
    (1.5 * deviator.dot(&deviator)).sqrt()
}

/// The Cauchy stress of a point in full, in Pa.
///
/// The columns of plane strain and of one dimension do not hold the normal stress across. It is that
/// of the law at the same deformation at rest, hence without the viscous part in a fluid.
pub fn cauchy_stress(block: &Block, point: usize) -> Matrix3<f64> {
    let mut voigt = match block.kinematics {
        Kinematics::PlaneStrain | Kinematics::UniaxialStrain => stress_at_rest(block, point),
        _ => [0.0; 6],
    };
    place(block, block.stress.row(point), &mut voigt);
    stress_from_voigt(&voigt)
}

/// Whether the law's stress depends on how fast the material is sheared, as that of fluids does.
pub fn resists_rates(law: &dyn Law) -> bool {
    const SHEAR: f64 = 1e-3;
    let stress = |time_step: f64| {
        let gradient = Matrix3::new(1.0, SHEAR, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let strain = law.uses_strain().then_some([0.0, 0.0, 0.0, SHEAR, 0.0, 0.0]);
        let deformation =
            Deformation { time_step, pressure: Some(0.0), strain, ..Deformation::from_gradient(gradient) };
        let (mut state, mut out) = (vec![0.0; law.state_len()], [[0.0; 6]]);
        law.initial_state(&mut state);
        law.stresses(&[deformation], &mut state, &mut out).map(|()| out).ok()
    };
    stress(1.0) != stress(2.0)
}

/// What the law answers for the present deformation; not a number if it has no answer.
fn stress_at_rest(block: &Block, point: usize) -> Voigt {
    stress_of(block, point, block.gradient.row(point), block.strain.row(point))
}

/// What the law answers for a point with these rows of deformation gradient and strain, at rest and with the
/// point's history; not a number if it has no answer.
pub fn stress_of(block: &Block, point: usize, gradient: &[f64], strain: &[f64]) -> Voigt {
    let gradient = expand(gradient);
    let strain = block.law.uses_strain().then(|| {
        let mut all = [0.0; 6];
        place(block, strain, &mut all);
        all
    });
    let pressure = block.pressure_of(point);
    // An infinite step: all rates are zero.
    let at_rest = Deformation { gradient, previous: gradient, time_step: f64::INFINITY, pressure, strain };
    let mut state = block.state.row(point).to_vec();
    let mut stress = [[f64::NAN; 6]];
    match block.law.stresses(&[at_rest], &mut state, &mut stress) {
        Ok(()) => stress[0],
        Err(_) => [f64::NAN; 6],
    }
}

/// Puts the stored components where they stand in space.
fn place(block: &Block, row: &[f64], voigt: &mut Voigt) {
    block.kinematics.voigt().iter().zip(row).for_each(|(&component, &value)| voigt[component] = value);
}

/// The components that the kinematics has, of a symmetric tensor in stress-like form.
pub fn symmetric(block: &Block, tensor: &Matrix3<f64>, out: &mut Vec<f64>) {
    append_voigt(block, &stress_to_voigt(tensor), out);
}

/// The components that the kinematics has.
pub fn append_voigt(block: &Block, voigt: &Voigt, out: &mut Vec<f64>) {
    out.extend(block.kinematics.voigt().iter().map(|&component| voigt[component]));
}

/// All nine components, row by row.
pub fn full(tensor: &Matrix3<f64>, out: &mut Vec<f64>) {
    out.extend(tensor.transpose().iter());
}

#[cfg(test)]
mod tests {
    use super::*;
    use bia_constitutive::tensor::{almansi_strain, green_lagrange_strain};
    use nalgebra::{Rotation3, Vector3};

    /// A rotation after stretches along the axes turned by another rotation.
    fn polar() -> (Matrix3<f64>, Matrix3<f64>, [f64; 3]) {
        let turn = *Rotation3::from_axis_angle(&Vector3::y_axis(), 0.7).matrix();
        let axes = *Rotation3::from_euler_angles(0.3, -0.8, 1.1).matrix();
        let stretches = [1.5, 0.6, 1.2];
        let f = turn * axes * Matrix3::from_diagonal(&stretches.into()) * axes.transpose();
        (f, turn * axes, stretches)
    }

    /// In principal axes each measure is a function of the stretch alone: e = ½(1 − λ⁻²), ln λ, and
    /// E = ½(λ² − 1) in the axes before the turn.
    #[test]
    fn strains_are_functions_of_the_stretches() {
        let (f, axes, stretches) = polar();
        let spatial =
            |value: fn(f64) -> f64| axes * Matrix3::from_diagonal(&stretches.map(value).into()) * axes.transpose();
        assert!((hencky_strain(&f) - spatial(f64::ln)).norm() < 1e-14);
        assert!((almansi_strain(&f) - spatial(|s| 0.5 * (1.0 - s.powi(-2)))).norm() < 1e-14);
        let turn = *Rotation3::from_axis_angle(&Vector3::y_axis(), 0.7).matrix();
        let back = turn.transpose() * spatial(|s| 0.5 * (s * s - 1.0)) * turn;
        assert!((green_lagrange_strain(&f) - back).norm() < 1e-14);
    }

    /// At a strain of 1e-9 all measures agree with the linear one to the first order, 1e-18.
    #[test]
    fn small_strains_keep_their_digits() {
        let linear = 1e-9 * Matrix3::new(1.0, 0.2, -0.3, 0.2, -2.0, 0.5, -0.3, 0.5, 0.7);
        let f = Matrix3::identity() + linear;
        // What the entries 1 + 1e-9 hold of the strain.
        let held = displacement_gradient(&f);
        assert!((hencky_strain(&f) - held).norm() < 3e-17);
        assert!(held.norm() > 2e-9);
    }

    /// Stress power in the three pairs of measures is the same: J σ : d = P : Ḟ = S : Ė.
    #[test]
    fn stresses_are_conjugate_to_their_rates() {
        let (f, _, _) = polar();
        let stress = Matrix3::new(3.0, 1.0, -2.0, 1.0, -4.0, 0.5, -2.0, 0.5, 1.0);
        let rate = Matrix3::new(0.3, -0.7, 0.2, 0.9, 0.1, -0.4, 0.6, -0.2, 0.8);
        let velocity_gradient = rate * f.try_inverse().unwrap();
        let power = f.determinant() * stress.dot(&velocity_gradient);
        let p = first_piola_kirchhoff(&stress, &f);
        assert!((p.dot(&rate) / power - 1.0).abs() < 1e-14);
        let strain_rate = 0.5 * (rate.transpose() * f + f.transpose() * rate);
        let s = second_piola_kirchhoff(&stress, &f);
        assert!((s.dot(&strain_rate) / power - 1.0).abs() < 1e-14);
        assert!((s - s.transpose()).norm() < 1e-14);
    }

    #[test]
    fn von_mises_of_known_states() {
        assert!(von_mises(&Matrix3::from_diagonal_element(-7.0)) < 1e-14);
        assert!((von_mises(&Matrix3::from_diagonal(&[5.0, 0.0, 0.0].into())) - 5.0).abs() < 1e-14);
        let shear = Matrix3::new(0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        assert!((von_mises(&shear) - 2.0 * 3f64.sqrt()).abs() < 1e-14);
    }
}
