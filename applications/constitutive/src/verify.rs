//! Reference stresses and tangents by central differences, for the tests of any law.

use nalgebra::Matrix3;

use crate::tensor::{VOIGT_PAIRS, stress_from_voigt, stress_to_voigt};
use crate::{ConstitutiveLaw, Deformation, LawError, Tangent, Voigt};

/// Change of the deformation: the error of central differences is about its square.
const STEP: f64 = 1e-5;

/// The unit rate of deformation of one Voigt component (shear: γ = 1, no spin).
fn unit_rate(component: usize) -> Matrix3<f64> {
    let (a, b) = VOIGT_PAIRS[component];
    let mut rate = Matrix3::zeros();
    rate[(a, b)] += 0.5;
    rate[(b, a)] += 0.5;
    rate
}

/// `deformation` with F replaced by (I + size · rate) F.
fn perturbed(deformation: &Deformation, rate: &Matrix3<f64>, size: f64) -> Deformation {
    Deformation { gradient: deformation.gradient + size * rate * deformation.gradient, ..*deformation }
}

/// Cauchy stress from the energy: τ : d = Ẇ, so τ_I is the slope of W along the rate of component I.
/// Relative error about 1e-9 of the moduli. None for a law without energy.
///
/// Components outside `components` (see [`crate::Kinematics::voigt`]) are left 0.
pub fn stress_from_energy<L: ConstitutiveLaw>(
    law: &L,
    deformation: &Deformation,
    components: &[usize],
) -> Option<Voigt> {
    let jacobian = deformation.gradient.determinant();
    let mut stress = [0.0; 6];
    for &component in components {
        let rate = unit_rate(component);
        let energy = |size| law.energy(&perturbed(deformation, &rate, size));
        stress[component] = (energy(STEP)? - energy(-STEP)?) / (2.0 * STEP * jacobian);
    }
    Some(stress)
}

/// Tangent from the stress: column I of c is (τ̇ − l τ − τ lᵀ)/J along the rate l of component I.
/// Relative error about 1e-9 of the moduli. Every stress starts from the same `state`.
///
/// Columns outside `components` are left 0; rows outside have no meaning where the law ignores them.
///
/// # Errors
/// The law has no answer at `deformation` or near it.
pub fn tangent_from_stress<L: ConstitutiveLaw>(
    law: &L,
    deformation: &Deformation,
    state: &L::State,
    components: &[usize],
) -> Result<Tangent, LawError> {
    let kirchhoff = |deformation: &Deformation| -> Result<Matrix3<f64>, LawError> {
        let stress = law.stress(deformation, &mut state.clone())?;
        Ok(stress_from_voigt(&stress) * deformation.gradient.determinant())
    };
    let tau = kirchhoff(deformation)?;
    let jacobian = deformation.gradient.determinant();
    let mut tangent = [[0.0; 6]; 6];
    for &component in components {
        let rate = unit_rate(component);
        let forward = kirchhoff(&perturbed(deformation, &rate, STEP))?;
        let backward = kirchhoff(&perturbed(deformation, &rate, -STEP))?;
        let slope = (forward - backward) / (2.0 * STEP);
        let column = stress_to_voigt(&((slope - rate * tau - tau * rate.transpose()) / jacobian));
        for row in 0..6 {
            tangent[row][component] = column[row];
        }
    }
    Ok(tangent)
}
