//! Weakly compressible Newtonian fluid with the displacement as unknown.
//!
//! With the deformation of the step, f = F Fₙ⁻¹ and B = (f fᵀ)⁻¹, the rate of deformation is the
//! Almansi strain of the step over its length, d = (I − B)/(2 Δt), and
//! - p = K (1 − 1/J), the mean stress, tension positive; σ = p I + 2 μ dev d;
//! - c_abcd = K δ_ab δ_cd − 2 p I_abcd + μ/Δt (δ_ac B_bd + δ_ad B_bc + δ_bd B_ac + δ_bc B_ad
//!   − δ_cd B_ab − ⅔ δ_ab B_cd − ⅔ tr B I_abcd + ⅓ tr B δ_ab δ_cd), I_abcd = ½(δ_ac δ_bd + δ_ad δ_bc).
//!
//! Not symmetric. Fₙ comes with the deformation; the fluid has no history of its own.
//!
//! Source: Kratos, DispNewtonianFluid laws; the tangent is the derivative, which a test confirms.

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LawEntry, LawError, Material, MaterialVariable, Range,
    Tangent, Voigt,
    tensor::{VOIGT_PAIRS, almansi_strain, strain_to_voigt, stress_to_voigt, volume_ratio},
};
use nalgebra::Matrix3;

/// Resistance to change of volume.
pub const BULK_MODULUS: MaterialVariable =
    MaterialVariable { name: "BULK_MODULUS", unit: "Pa", help: "bulk modulus", range: Range::Above(0.0) };
/// Resistance to shearing.
pub const DYNAMIC_VISCOSITY: MaterialVariable =
    MaterialVariable { name: "DYNAMIC_VISCOSITY", unit: "Pa s", help: "dynamic viscosity", range: Range::AtLeast(0.0) };

/// The fluid of this file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonianFluid {
    bulk_modulus: f64,
    viscosity: f64,
}

impl NewtonianFluid {
    /// From bulk modulus (Pa) and dynamic viscosity (Pa s).
    pub fn from_moduli(bulk_modulus: f64, viscosity: f64) -> Self {
        Self { bulk_modulus, viscosity }
    }

    /// Stress, mean stress, deformation of the step.
    fn evaluate(&self, deformation: &Deformation) -> Result<(Matrix3<f64>, f64, Matrix3<f64>), LawError> {
        let jacobian = volume_ratio(&deformation.gradient)?;
        let mean = self.bulk_modulus * (1.0 - 1.0 / jacobian);
        let (stress, step) = stress_in_flow(deformation, self.viscosity, mean)?;
        Ok((stress, mean, step))
    }
}

/// p I + 2 μ dev d for the mean stress `mean`, and the deformation of the step.
///
/// # Errors
/// The step has no duration, or started inside out.
pub(crate) fn stress_in_flow(
    deformation: &Deformation,
    viscosity: f64,
    mean: f64,
) -> Result<(Matrix3<f64>, Matrix3<f64>), LawError> {
    let Some(back) = deformation.previous.try_inverse() else { return Err(LawError::NonFinite) };
    if deformation.time_step <= 0.0 {
        let advice = "use a dynamic or quasi-static solver";
        return Err(LawError::Unsuitable { problem: "needs a time step, as viscosity resists rates", advice });
    }
    let step = deformation.gradient * back;
    let rate = almansi_strain(&step) / deformation.time_step;
    let mut stress = 2.0 * viscosity * rate;
    let isotropic = mean - 2.0 / 3.0 * viscosity * rate.trace();
    (0..3).for_each(|a| stress[(a, a)] += isotropic);
    Ok((stress, step))
}

/// The tangent at mean stress `mean` for the deformation of the step and ν = μ/Δt; `volumetric` stands
/// before δ_ab δ_cd: K, or p where pressure is an unknown of its own.
///
/// # Errors
/// The step is singular.
pub(crate) fn tangent_in_flow(volumetric: f64, mean: f64, nu: f64, step: &Matrix3<f64>) -> Result<Tangent, LawError> {
    let Some(b) = (step * step.transpose()).try_inverse() else { return Err(LawError::NonFinite) };
    let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let mut tangent = [[0.0; 6]; 6];
    for (row, (a, c)) in VOIGT_PAIRS.into_iter().enumerate() {
        for (column, (d, e)) in VOIGT_PAIRS.into_iter().enumerate() {
            let symmetric = 0.5 * (one(a, d) * one(c, e) + one(a, e) * one(c, d));
            let traces = one(a, c) * one(d, e);
            let four = one(a, d) * b[(c, e)] + one(a, e) * b[(c, d)] + one(c, e) * b[(a, d)] + one(c, d) * b[(a, e)];
            let viscous = four - one(d, e) * b[(a, c)] - 2.0 / 3.0 * one(a, c) * b[(d, e)]
                + b.trace() * (traces / 3.0 - 2.0 / 3.0 * symmetric);
            tangent[row][column] = volumetric * traces - 2.0 * mean * symmetric + nu * viscous;
        }
    }
    Ok(tangent)
}

impl ConstitutiveLaw for NewtonianFluid {
    const NAME: &'static str = "Newtonian fluid";
    const HELP: &'static str = "Weakly compressible Newtonian fluid, σ = K (1 − 1/J) I + 2 μ dev d";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, BULK_MODULUS, DYNAMIC_VISCOSITY];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self::from_moduli(material.get(BULK_MODULUS)?, material.get(DYNAMIC_VISCOSITY)?))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        Ok(stress_to_voigt(&self.evaluate(deformation)?.0))
    }

    fn stress_and_tangent(&self, deformation: &Deformation, _: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let (stress, mean, step) = self.evaluate(deformation)?;
        let tangent = tangent_in_flow(self.bulk_modulus, mean, self.viscosity / deformation.time_step, &step)?;
        Ok((stress_to_voigt(&stress), tangent))
    }

    /// Almansi strain.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        strain_to_voigt(&almansi_strain(&deformation.gradient))
    }

    /// Speed of sound √(K/ρ).
    fn wave_speed(&self, density: f64) -> f64 {
        (self.bulk_modulus / density).sqrt()
    }

    fn is_symmetric(&self) -> bool {
        false
    }
}

/// The names under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    use Kinematics::{Axisymmetric, PlaneStrain, ThreeDimensional};
    vec![
        LawEntry::of::<NewtonianFluid>("DispNewtonianFluid3DLaw", &[ThreeDimensional]),
        LawEntry::of::<NewtonianFluid>("DispNewtonianFluidPlaneStrain2DLaw", &[PlaneStrain]),
        LawEntry::of::<NewtonianFluid>("DispNewtonianFluidAxisym2DLaw", &[Axisymmetric]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::tangent_from_stress;

    const ALL: &[usize] = &[0, 1, 2, 3, 4, 5];

    fn moved() -> Deformation {
        let previous = Matrix3::new(1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05);
        let step = Matrix3::new(1.05, 0.1, 0.0, -0.1, 0.93, 0.05, 0.02, 0.0, 0.97);
        Deformation { previous, time_step: 0.01, ..Deformation::from_gradient(step * previous) }
    }

    #[test]
    fn the_tangent_is_the_derivative() {
        let law = NewtonianFluid::from_moduli(3e3, 2.0);
        let (_, tangent) = law.stress_and_tangent(&moved(), &mut ()).unwrap();
        let reference = tangent_from_stress(&law, &moved(), &(), ALL).unwrap();
        let scale = tangent.iter().flatten().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        for (row, expected) in tangent.iter().zip(reference) {
            for (c, r) in row.iter().zip(expected) {
                assert!((c - r).abs() < 2e-9 * scale, "{c} {r}");
            }
        }
        assert!((tangent[0][1] - tangent[1][0]).abs() > 1e-6 * scale, "this state shows that it is not symmetric");
    }

    /// Simple shearing at a rate g: τ = μ g; no shear stress without motion, whatever the shape.
    #[test]
    fn shearing_meets_newtons_law_of_viscosity() {
        let law = NewtonianFluid::from_moduli(1e3, 0.7);
        let shear = |s: f64| Matrix3::new(1.0, s, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let (g, time_step) = (3.0, 1e-6);
        let at = |from: f64, to: f64| Deformation {
            previous: shear(from),
            time_step,
            ..Deformation::from_gradient(shear(to))
        };
        let stress = law.stress(&at(2.0, 2.0 + g * time_step), &mut ()).unwrap();
        assert!((stress[3] - 0.7 * g).abs() < 1e-8, "{stress:?}");
        let stress = law.stress(&at(2.0, 2.0), &mut ()).unwrap();
        assert!(stress.iter().all(|s| s.abs() < 1e-9), "{stress:?}");
    }

    #[test]
    fn compression_gives_pressure_alone_and_statics_is_refused() {
        let law = NewtonianFluid::from_moduli(100.0, 5.0);
        let mut deformation = Deformation::from_gradient(0.5 * Matrix3::identity());
        assert!(matches!(law.stress(&deformation, &mut ()), Err(LawError::Unsuitable { .. })));
        deformation.time_step = 1.0;
        deformation.previous = deformation.gradient;
        let stress = law.stress(&deformation, &mut ()).unwrap();
        assert!((stress[0] + 700.0).abs() < 1e-11 && stress[0] == stress[2] && stress[3] == 0.0, "{stress:?}");
        assert!((ConstitutiveLaw::wave_speed(&law, 4.0) - 5.0).abs() < 1e-15);
    }
}
