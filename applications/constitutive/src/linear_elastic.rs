//! Linear elastic solid at finite deformation: Saint-Venant–Kirchhoff, the stress of Kratos's
//! LinearElasticIsotropic laws.
//!
//! E = ½(Fᵀ F − I),  S = λ tr E I + 2 μ E,  τ = F S Fᵀ,  σ = τ/J,  W = λ/2 (tr E)² + μ E : E
//! c_abcd = [λ b_ab b_cd + μ (b_ac b_bd + b_ad b_bc)]/J,  b = F Fᵀ
//!
//! Plane stress: S33 = 0 leaves the same form in the plane with λ* = 2λμ/(λ + 2μ) for λ. Stress and
//! tangent are those of [`crate::PlaneStress`] around the law, found without iteration; a test holds
//! the two together.
//!
//! Softens in compression: in uniaxial strain the axial stress falls again below F = 1/√3.
//! Use a neo-Hookean law beyond strains of a few per cent.
//!
//! Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, §6.3.

use nalgebra::Matrix3;

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Hypoelastic, Kinematics, LameParameters, LawEntry, LawError,
    Material, MaterialVariable, POISSON_RATIO, Tangent, Voigt, YOUNG_MODULUS,
    tensor::{green_lagrange_strain, isotropic_tangent_of, strain_to_voigt, stress_to_voigt, volume_ratio},
};

/// Saint-Venant–Kirchhoff solid in three dimensions, plane strain and axisymmetry.
pub type LinearElastic = SaintVenantKirchhoff<false>;
/// Saint-Venant–Kirchhoff solid without stress across the plane.
pub type LinearElasticPlaneStress = SaintVenantKirchhoff<true>;

/// The solid of this file. With `PLANE_STRESS`, F33 = 1 and no shear across the plane are assumed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SaintVenantKirchhoff<const PLANE_STRESS: bool> {
    /// λ (or λ* in plane stress) and μ.
    lame: LameParameters,
    /// Return C/J for the tangent, as Kratos does, instead of pushing C forward. The stress is the
    /// same and Newton's method slower, but its iterations can be compared with Kratos's.
    material_tangent: bool,
}

impl<const PLANE_STRESS: bool> SaintVenantKirchhoff<PLANE_STRESS> {
    /// From the Lamé parameters of the three-dimensional solid, with the consistent tangent.
    pub fn from_lame(lame: LameParameters) -> Self {
        Self { lame: if PLANE_STRESS { lame.of_plane_stress() } else { lame }, material_tangent: false }
    }

    /// Projector P onto the directions that carry stress: I, or diag(1, 1, 0) in plane stress.
    fn projector() -> Matrix3<f64> {
        Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0, 1.0, if PLANE_STRESS { 0.0 } else { 1.0 }))
    }

    /// Cauchy stress and J.
    #[inline]
    fn evaluate(&self, f: &Matrix3<f64>) -> Result<(Voigt, f64), LawError> {
        let LameParameters { lambda, mu } = self.lame;
        let jacobian = volume_ratio(f)?;
        let strain = green_lagrange_strain(f);
        let second_piola_kirchhoff = lambda * strain.trace() * Self::projector() + 2.0 * mu * strain;
        let kirchhoff = f * second_piola_kirchhoff * f.transpose();
        Ok((stress_to_voigt(&kirchhoff).map(|component| component / jacobian), jacobian))
    }
}

impl<const PLANE_STRESS: bool> ConstitutiveLaw for SaintVenantKirchhoff<PLANE_STRESS> {
    const NAME: &'static str = "linear elastic";
    const HELP: &'static str =
        "Saint-Venant–Kirchhoff solid, S = λ tr E I + 2 μ E (Bonet and Wood, §6.3); for moderate strain";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS, POISSON_RATIO];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        let law = Self::from_lame(LameParameters::of(material)?);
        Ok(Self { material_tangent: material.options().kratos_exact, ..law })
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        Ok(self.evaluate(&deformation.gradient)?.0)
    }

    fn stress_and_tangent(&self, deformation: &Deformation, _: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let LameParameters { lambda, mu } = self.lame;
        let f = &deformation.gradient;
        let (stress, jacobian) = self.evaluate(f)?;
        let p = Self::projector();
        let metric = if self.material_tangent { p } else { f * p * f.transpose() };
        Ok((stress, isotropic_tangent_of(lambda / jacobian, mu / jacobian, &metric)))
    }

    /// Green–Lagrange strain.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        strain_to_voigt(&green_lagrange_strain(&deformation.gradient))
    }

    fn wave_speed(&self, density: f64) -> f64 {
        self.lame.pressure_wave_speed(density)
    }

    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        let LameParameters { lambda, mu } = self.lame;
        let strain = green_lagrange_strain(&deformation.gradient);
        let trace = strain.trace();
        Some(0.5 * lambda * trace * trace + mu * strain.dot(&strain))
    }
}

/// The names under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    use Kinematics::{Axisymmetric, PlaneStrain, PlaneStress, ThreeDimensional, UniaxialStrain};
    vec![
        LawEntry::of::<LinearElastic>("LinearElasticIsotropic3DLaw", &[ThreeDimensional, UniaxialStrain])
            .explicit::<Hypoelastic<false>>(),
        LawEntry::of::<LinearElastic>("LinearElasticIsotropicPlaneStrain2DLaw", &[PlaneStrain])
            .explicit::<Hypoelastic<false>>(),
        LawEntry::of::<LinearElastic>("LinearElasticIsotropicAxisym2DLaw", &[Axisymmetric])
            .explicit::<Hypoelastic<false>>(),
        LawEntry::of::<LinearElasticPlaneStress>("LinearElasticIsotropicPlaneStress2DLaw", &[PlaneStress])
            .explicit::<Hypoelastic<true>>(),
        // Kratos's names of the law itself, which explicit solvers do not replace.
        LawEntry::of::<LinearElastic>("KirchhoffSaintVenant3DLaw", &[ThreeDimensional, UniaxialStrain]),
        LawEntry::of::<LinearElastic>("KirchhoffSaintVenantPlaneStrain2DLaw", &[PlaneStrain]),
        LawEntry::of::<LinearElasticPlaneStress>("KirchhoffSaintVenantPlaneStress2DLaw", &[PlaneStress]),
    ]
}
