//! Newtonian fluid for mixed displacement-pressure elements, of finite or infinite bulk modulus.
//!
//! σ = p I + 2 μ dev d with the nodal pressure p; d and the tangent as in the displacement form, whose
//! δ_ab δ_cd has p in the place of K.

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LawEntry, LawError, Material, MaterialVariable,
    MixedModuli, Shear, Tangent, Voigt, VolumetricLaw, mixed_pressure,
    newtonian::{BULK_MODULUS, DYNAMIC_VISCOSITY, stress_in_flow, tangent_in_flow},
    tensor::{almansi_strain, strain_to_voigt, stress_to_voigt, volume_ratio},
};

/// The fluid of this file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NewtonianFluidMixed {
    viscosity: f64,
    compressibility: f64,
    volumetric: VolumetricLaw,
}

impl NewtonianFluidMixed {
    /// From dynamic viscosity (Pa s) and 1/κ (1/Pa).
    pub fn from_moduli(viscosity: f64, compressibility: f64, volumetric: VolumetricLaw) -> Self {
        Self { viscosity, compressibility, volumetric }
    }
}

impl ConstitutiveLaw for NewtonianFluidMixed {
    const NAME: &'static str = "Newtonian fluid with nodal pressure";
    const HELP: &'static str = "Newtonian fluid for mixed elements, σ = p I + 2 μ dev d; incompressible without \
                                BULK_MODULUS";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, DYNAMIC_VISCOSITY];
    const OPTIONAL: &'static [MaterialVariable] = &[BULK_MODULUS];
    const MIXED: bool = true;
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        let compressibility = material.given(BULK_MODULUS).map_or(0.0, f64::recip);
        let volumetric = material.options().mixed.unwrap_or_default();
        Ok(Self::from_moduli(material.get(DYNAMIC_VISCOSITY)?, compressibility, volumetric))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        volume_ratio(&deformation.gradient)?;
        let pressure = mixed_pressure(deformation)?;
        Ok(stress_to_voigt(&stress_in_flow(deformation, self.viscosity, pressure)?.0))
    }

    fn stress_and_tangent(&self, deformation: &Deformation, _: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        volume_ratio(&deformation.gradient)?;
        let pressure = mixed_pressure(deformation)?;
        let (stress, step) = stress_in_flow(deformation, self.viscosity, pressure)?;
        let tangent = tangent_in_flow(pressure, pressure, self.viscosity / deformation.time_step, &step)?;
        Ok((stress_to_voigt(&stress), tangent))
    }

    /// Almansi strain.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        strain_to_voigt(&almansi_strain(&deformation.gradient))
    }

    /// Speed of sound √(κ/ρ), infinite where the fluid is incompressible.
    fn wave_speed(&self, density: f64) -> f64 {
        (self.compressibility * density).sqrt().recip()
    }

    /// What the change of volume stores; viscosity stores nothing.
    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        let jacobian = volume_ratio(&deformation.gradient).ok()?;
        let p = deformation.pressure.unwrap_or(0.0);
        Some(p * (jacobian - 1.0) - self.volumetric.complementary_energy(p, self.compressibility))
    }

    fn is_symmetric(&self) -> bool {
        false
    }

    fn mixed(&self) -> Option<MixedModuli> {
        let Self { viscosity, compressibility, volumetric } = *self;
        Some(MixedModuli { compressibility, shear: Shear::Viscous(viscosity), volumetric })
    }
}

/// The names under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    use Kinematics::{PlaneStrain, ThreeDimensional};
    vec![
        LawEntry::of::<NewtonianFluidMixed>("DispNewtonianFluidUP3DLaw", &[ThreeDimensional]),
        LawEntry::of::<NewtonianFluidMixed>("DispNewtonianFluidPlaneStrainUP2DLaw", &[PlaneStrain]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::tangent_from_stress;
    use nalgebra::Matrix3;

    #[test]
    fn the_tangent_is_the_derivative_and_the_mean_stress_is_the_pressure() {
        let law = NewtonianFluidMixed::from_moduli(2.0, 0.0, VolumetricLaw::Linear);
        let previous = Matrix3::new(1.1, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.05);
        let step = Matrix3::new(1.05, 0.1, 0.0, -0.1, 0.93, 0.05, 0.02, 0.0, 0.97);
        let of_step = Deformation::from_gradient(step * previous);
        let deformation = Deformation { previous, time_step: 0.01, pressure: Some(-40.0), ..of_step };
        let (stress, tangent) = law.stress_and_tangent(&deformation, &mut ()).unwrap();
        assert!((stress[0] + stress[1] + stress[2] + 120.0).abs() < 1e-11);
        let reference = tangent_from_stress(&law, &deformation, &(), &[0, 1, 2, 3, 4, 5]).unwrap();
        let scale = tangent.iter().flatten().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        for (c, r) in tangent.iter().flatten().zip(reference.iter().flatten()) {
            assert!((c - r).abs() < 2e-9 * scale, "{c} {r}");
        }
        assert!(ConstitutiveLaw::wave_speed(&law, 1000.0).is_infinite());
    }
}
