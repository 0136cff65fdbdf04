//! Linear bar: the first Piola–Kirchhoff stress is linear in the displacement gradient.
//!
//! P = (λ + 2μ)(F − 1),  σ = P (uniaxial strain: τ = P F, J = F),  c = λ + 2μ,  W = ½(λ + 2μ)(F − 1)²
//!
//! The wave equation holds at any amplitude: for comparison with its solutions. One dimension only,
//! where there is no rotation that the law could miss; it does not resist compression to nothing.

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LameParameters, LawEntry, LawError, Material,
    MaterialVariable, POISSON_RATIO, Tangent, Voigt, YOUNG_MODULUS,
    tensor::{displacement_gradient, volume_ratio},
};

/// Linear bar in uniaxial strain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NominalElastic {
    lame: LameParameters,
}

impl NominalElastic {
    /// From Lamé's parameters.
    pub fn from_lame(lame: LameParameters) -> Self {
        Self { lame }
    }

    /// λ + 2μ.
    fn modulus(&self) -> f64 {
        self.lame.lambda + 2.0 * self.lame.mu
    }
}

impl ConstitutiveLaw for NominalElastic {
    const NAME: &'static str = "linear bar";
    const HELP: &'static str = "Linear bar in uniaxial strain, P = (λ + 2μ)(F − 1): the wave equation at any amplitude";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS, POISSON_RATIO];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self::from_lame(LameParameters::of(material)?))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        let stretch = volume_ratio(&deformation.gradient)?;
        let strain = displacement_gradient(&deformation.gradient)[(0, 0)];
        let across = self.lame.lambda * strain / stretch;
        Ok([self.modulus() * strain, across, across, 0.0, 0.0, 0.0])
    }

    fn stress_and_tangent(&self, deformation: &Deformation, state: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let mut tangent = [[0.0; 6]; 6];
        tangent[0][0] = self.modulus();
        Ok((self.stress(deformation, state)?, tangent))
    }

    /// Displacement gradient.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        [displacement_gradient(&deformation.gradient)[(0, 0)], 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    fn wave_speed(&self, density: f64) -> f64 {
        self.lame.pressure_wave_speed(density)
    }

    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        Some(0.5 * self.modulus() * displacement_gradient(&deformation.gradient)[(0, 0)].powi(2))
    }
}

/// The name under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    vec![LawEntry::of::<NominalElastic>("LinearElasticUniaxialStrain1DLaw", &[Kinematics::UniaxialStrain])]
}
