//! Compressible neo-Hookean solid.
//!
//! W = μ/2 (tr b − 3) − μ ln J + λ/2 (ln J)²,  b = F Fᵀ
//! τ = λ ln J I + μ (b − I),  σ = τ/J
//! c_abcd = [λ δ_ab δ_cd + (μ − λ ln J)(δ_ac δ_bd + δ_ad δ_bc)]/J
//!
//! Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, §6.4.3.

use bia_kernel::lanes::Real;
use nalgebra::Matrix3;

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LameParameters, LawEntry, LawError, Material,
    MaterialVariable, POISSON_RATIO, PlaneStress, Tangent, Voigt, YOUNG_MODULUS,
    tensor::{
        Tensor, VOIGT_PAIRS, almansi_strain, displacement_gradient, isotropic_tangent, strain_to_voigt, tensor_of,
        volume_change, volume_ratio,
    },
};

/// Compressible neo-Hookean solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHookean {
    lame: LameParameters,
}

impl NeoHookean {
    /// From Lamé's parameters.
    pub fn from_lame(lame: LameParameters) -> Self {
        Self { lame }
    }

    /// Kirchhoff stress, J − 1 and ln J.
    #[inline(always)]
    fn kirchhoff<R: Real>(&self, f: &Tensor<R>) -> ([R; 6], R, R) {
        let LameParameters { lambda, mu } = self.lame;
        let mut h = *f;
        for a in 0..3 {
            h[a][a] = h[a][a] - 1.0;
        }
        let change = volume_change(&h);
        let log_jacobian = change.ln_1p();
        let mut stress = [change; 6];
        for k in 0..6 {
            // b − I = H + Hᵀ + H Hᵀ.
            let (a, b) = VOIGT_PAIRS[k];
            let stretch = h[a][b] + h[b][a] + (h[a][0] * h[b][0] + h[a][1] * h[b][1] + h[a][2] * h[b][2]);
            stress[k] = stretch * mu;
        }
        for k in 0..3 {
            stress[k] += log_jacobian * lambda;
        }
        (stress, change, log_jacobian)
    }

    /// Cauchy stress, J and ln J.
    #[inline]
    fn evaluate(&self, f: &Matrix3<f64>) -> Result<(Voigt, f64, f64), LawError> {
        let jacobian = volume_ratio(f)?;
        let (stress, _, log_jacobian) = self.kirchhoff(&tensor_of(f));
        Ok((stress.map(|component| component / jacobian), jacobian, log_jacobian))
    }
}

impl ConstitutiveLaw for NeoHookean {
    const NAME: &'static str = "neo-Hookean";
    const HELP: &'static str =
        "Compressible neo-Hookean solid, W = μ/2 (tr b − 3) − μ ln J + λ/2 (ln J)² (Bonet and Wood, §6.4.3)";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS, POISSON_RATIO];
    const IN_STEP: bool = true;
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self::from_lame(LameParameters::of(material)?))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        Ok(self.evaluate(&deformation.gradient)?.0)
    }

    #[inline(always)]
    fn stress_in_step<R: Real>(&self, gradient: &Tensor<R>, _: &[R; 6]) -> [R; 6] {
        let (mut stress, change, _) = self.kirchhoff(gradient);
        let inverse = change.constant(1.0) / (change + 1.0);
        for k in 0..6 {
            stress[k] *= inverse;
        }
        stress
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
        volume_ratio(&deformation.gradient).ok()?;
        let h = displacement_gradient(&deformation.gradient);
        let log_jacobian = volume_change(&tensor_of(&h)).ln_1p();
        let stretch = h.trace() + 0.5 * h.norm_squared() - log_jacobian;
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
