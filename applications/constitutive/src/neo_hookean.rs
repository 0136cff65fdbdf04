//! Compressible neo-Hookean solid.
//!
//! W = μ/2 (tr b − 3) − μ ln J + λ/2 (ln J)²,  b = F Fᵀ
//! τ = λ ln J I + μ (b − I),  σ = τ/J
//! c_abcd = [λ δ_ab δ_cd + (μ − λ ln J)(δ_ac δ_bd + δ_ad δ_bc)]/J
//!
//! Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, §6.4.3.

use nalgebra::Matrix3;

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LameParameters, LawEntry, LawError, Material,
    MaterialVariable, POISSON_RATIO, PlaneStress, Tangent, Voigt, YOUNG_MODULUS,
    tensor::{
        almansi_strain, displacement_gradient, isotropic_tangent, log_volume_ratio, strain_to_voigt, stress_to_voigt,
        volume_ratio,
    },
};

/// Compressible neo-Hookean solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHookean {
    lame: LameParameters,
}

/// b − I = H + Hᵀ + H Hᵀ, H = F − I.
fn left_cauchy_green_minus_identity(f: &Matrix3<f64>) -> Matrix3<f64> {
    let h = displacement_gradient(f);
    h + h.transpose() + h * h.transpose()
}

impl NeoHookean {
    /// From Lamé's parameters.
    pub fn from_lame(lame: LameParameters) -> Self {
        Self { lame }
    }

    /// Cauchy stress, J and ln J.
    #[inline]
    fn evaluate(&self, f: &Matrix3<f64>) -> Result<(Voigt, f64, f64), LawError> {
        let LameParameters { lambda, mu } = self.lame;
        let jacobian = volume_ratio(f)?;
        let log_jacobian = log_volume_ratio(f, jacobian);
        let mut stress =
            stress_to_voigt(&left_cauchy_green_minus_identity(f)).map(|component| mu * component / jacobian);
        for normal in &mut stress[..3] {
            *normal += lambda * log_jacobian / jacobian;
        }
        Ok((stress, jacobian, log_jacobian))
    }
}

impl ConstitutiveLaw for NeoHookean {
    const NAME: &'static str = "neo-Hookean";
    const HELP: &'static str =
        "Compressible neo-Hookean solid, W = μ/2 (tr b − 3) − μ ln J + λ/2 (ln J)² (Bonet and Wood, §6.4.3)";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS, POISSON_RATIO];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self::from_lame(LameParameters::of(material)?))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        Ok(self.evaluate(&deformation.gradient)?.0)
    }

    fn stress_and_tangent(&self, deformation: &Deformation, _: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let LameParameters { lambda, mu } = self.lame;
        let (stress, jacobian, log_jacobian) = self.evaluate(&deformation.gradient)?;
        Ok((stress, isotropic_tangent(lambda / jacobian, (mu - lambda * log_jacobian) / jacobian)))
    }

    /// Almansi strain.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        strain_to_voigt(&almansi_strain(&deformation.gradient))
    }

    fn wave_speed(&self, density: f64) -> f64 {
        self.lame.pressure_wave_speed(density)
    }

    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        let LameParameters { lambda, mu } = self.lame;
        let f = &deformation.gradient;
        let log_jacobian = log_volume_ratio(f, volume_ratio(f).ok()?);
        let stretch = 0.5 * left_cauchy_green_minus_identity(f).trace() - log_jacobian;
        Some(mu * stretch + 0.5 * lambda * log_jacobian * log_jacobian)
    }
}

/// The names under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    use Kinematics::{Axisymmetric, PlaneStrain, ThreeDimensional, UniaxialStrain};
    vec![
        LawEntry::of::<NeoHookean>("HyperElasticNeoHookean3DLaw", &[ThreeDimensional, UniaxialStrain]),
        LawEntry::of::<NeoHookean>("HyperElasticNeoHookeanPlaneStrain2DLaw", &[PlaneStrain]),
        LawEntry::of::<NeoHookean>("HyperElasticNeoHookeanAxisym2DLaw", &[Axisymmetric]),
        LawEntry::of::<PlaneStress<NeoHookean>>("HyperElasticNeoHookeanPlaneStress2DLaw", &[Kinematics::PlaneStress]),
    ]
}
