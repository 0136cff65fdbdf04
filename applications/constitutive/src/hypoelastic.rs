//! Hypoelastic solid: Hooke's law between Cauchy stress and a strain that the element accumulates,
//! the form that Kratos's linear elastic laws take in explicit runs.
//!
//! σ = (λ tr ε I + 2 μ ε)/J, where ε is the integral of the rate of deformation in axes that turn
//! with the material (Jaumann rate, [`Deformation::strain`]).
//!
//! Plane stress: λ* = 2λμ/(λ + 2μ) for λ. No energy: in large closed cycles of strain a hypoelastic
//! solid does work. Source: Simo and Hughes, Computational Inelasticity, §7.1-7.3.

use bia_kernel::lanes::Real;

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, LameParameters, LawError, Material, MaterialVariable, POISSON_RATIO,
    Tangent, Voigt, YOUNG_MODULUS,
    tensor::{Tensor, adjugate, volume_ratio},
};

/// The solid of this file. With `PLANE_STRESS`, no strain across the plane is handed over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypoelastic<const PLANE_STRESS: bool> {
    /// λ (or λ* in plane stress) and μ.
    lame: LameParameters,
}

impl<const PLANE_STRESS: bool> Hypoelastic<PLANE_STRESS> {
    /// From the Lamé parameters of the three-dimensional solid.
    pub fn from_lame(lame: LameParameters) -> Self {
        Self { lame: if PLANE_STRESS { lame.of_plane_stress() } else { lame } }
    }

    /// Hooke's law times `factor`.
    #[inline(always)]
    fn hooke<R: Real>(&self, strain: &[R; 6], factor: R) -> [R; 6] {
        let LameParameters { lambda, mu } = self.lame;
        let volumetric = (strain[0] + strain[1] + strain[2]) * lambda;
        let mut stress = *strain;
        for i in 0..3 {
            stress[i] = (volumetric + strain[i] * (2.0 * mu)) * factor;
            stress[i + 3] = strain[i + 3] * mu * factor;
        }
        if PLANE_STRESS {
            stress[2] = factor.constant(0.0);
        }
        stress
    }
}

impl<const PLANE_STRESS: bool> ConstitutiveLaw for Hypoelastic<PLANE_STRESS> {
    const NAME: &'static str = "linear elastic";
    const HELP: &'static str = "Hooke's law with an accumulated strain (Jaumann rate), for explicit solvers";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS, POISSON_RATIO];
    const USES_STRAIN: bool = true;
    const IN_STEP: bool = true;
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self::from_lame(LameParameters::of(material)?))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        let Some(strain) = deformation.strain else {
            return Err(LawError::Unsuitable { problem: "needs an accumulated strain", advice: "run it explicitly" });
        };
        Ok(self.hooke(&strain, 1.0 / volume_ratio(&deformation.gradient)?))
    }

    #[inline(always)]
    fn stress_in_step<R: Real>(&self, gradient: &Tensor<R>, strain: &[R; 6]) -> [R; 6] {
        let (_, jacobian) = adjugate(gradient);
        self.hooke(strain, jacobian.constant(1.0) / jacobian)
    }

    fn stress_and_tangent(&self, _: &Deformation, _: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        Err(LawError::Unsuitable { problem: "has no tangent", advice: "run it explicitly" })
    }

    /// The accumulated strain; not a number without one.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        deformation.strain.unwrap_or([f64::NAN; 6])
    }

    fn wave_speed(&self, density: f64) -> f64 {
        self.lame.pressure_wave_speed(density)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LinearElastic, LinearElasticPlaneStress};
    use nalgebra::Matrix3;

    /// At small strain ε = sym(F − I), and both forms of the elastic laws are Hooke's law.
    #[test]
    fn small_strains_give_the_stress_of_the_implicit_law() {
        let lame = LameParameters::from_engineering(2e5, 0.3);
        let h: Matrix3<f64> = 1e-9 * Matrix3::new(1.0, 3.0, 0.0, -1.0, -2.0, 0.0, 0.0, 0.0, 0.0);
        let strain = [h[(0, 0)], h[(1, 1)], h[(2, 2)], h[(0, 1)] + h[(1, 0)], 0.0, 0.0];
        let deformation = Deformation { strain: Some(strain), ..Deformation::from_gradient(Matrix3::identity() + h) };
        let near = |a: Voigt, b: Voigt| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-7 * 2e5 * 1e-9);
        let solid = Hypoelastic::<false>::from_lame(lame).stress(&deformation, &mut ()).unwrap();
        assert!(near(solid, LinearElastic::from_lame(lame).stress(&deformation, &mut ()).unwrap()), "{solid:?}");
        let plane = Hypoelastic::<true>::from_lame(lame).stress(&deformation, &mut ()).unwrap();
        let reference = LinearElasticPlaneStress::from_lame(lame).stress(&deformation, &mut ()).unwrap();
        assert!(near(plane, reference), "{plane:?} {reference:?}");
        assert_ne!(plane, solid);
    }

    #[test]
    fn stress_is_per_current_area_and_needs_a_strain() {
        let law = Hypoelastic::<false>::from_lame(LameParameters { lambda: 2.0, mu: 1.0 });
        let mut deformation = Deformation::from_gradient(2.0 * Matrix3::identity());
        assert!(matches!(law.stress(&deformation, &mut ()), Err(LawError::Unsuitable { .. })));
        deformation.strain = Some([1.0, 0.0, 0.0, 0.5, 0.0, 0.0]);
        assert_eq!(law.stress(&deformation, &mut ()).unwrap(), [0.5, 0.25, 0.25, 0.0625, 0.0, 0.0]);
    }
}
