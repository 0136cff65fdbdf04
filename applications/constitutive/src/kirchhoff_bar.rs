//! Laterally free bar of a Saint-Venant–Kirchhoff solid.
//!
//! P = E/2 F(F² − 1),  σ = P (per undeformed cross section: τ = P F, J = F),  c = E F³,
//! W = E/8 (F² − 1)²
//!
//! Convex in F: tension steepens into shocks at √(P/(ρ(F − 1))), compression spreads into fans; below
//! F = 1/√3 the tangent is not positive and waves have no speed. In one dimension only.
//!
//! Source: Renaud and Heuzé, COMPDYN 2017, §5.3.

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LawEntry, LawError, Material, MaterialVariable, Tangent,
    Voigt, YOUNG_MODULUS,
    tensor::{displacement_gradient, volume_ratio},
};

/// Saint-Venant–Kirchhoff bar without stress across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KirchhoffBar {
    young: f64,
}

impl KirchhoffBar {
    /// From Young's modulus (Pa).
    pub fn from_young(young: f64) -> Self {
        Self { young }
    }

    /// F and F² − 1 = H (2 + H), H = F − 1, which keeps its digits at small strain.
    fn stretch(deformation: &Deformation) -> Result<(f64, f64), LawError> {
        volume_ratio(&deformation.gradient)?;
        let strain = displacement_gradient(&deformation.gradient)[(0, 0)];
        Ok((1.0 + strain, strain * (2.0 + strain)))
    }
}

impl ConstitutiveLaw for KirchhoffBar {
    const NAME: &'static str = "Saint-Venant–Kirchhoff bar";
    const HELP: &'static str =
        "Saint-Venant–Kirchhoff bar in uniaxial stress, P = E/2 F(F² − 1) (Renaud and Heuzé 2017)";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self::from_young(material.get(YOUNG_MODULUS)?))
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        let (stretch, doubled_strain) = Self::stretch(deformation)?;
        Ok([0.5 * self.young * stretch * doubled_strain, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    fn stress_and_tangent(&self, deformation: &Deformation, state: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let (stretch, _) = Self::stretch(deformation)?;
        let mut tangent = [[0.0; 6]; 6];
        tangent[0][0] = self.young * stretch.powi(3);
        Ok((self.stress(deformation, state)?, tangent))
    }

    /// Green–Lagrange strain along the bar.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        let doubled_strain = Self::stretch(deformation).map_or(f64::NAN, |(_, doubled)| doubled);
        [0.5 * doubled_strain, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    /// √(E/ρ).
    fn wave_speed(&self, density: f64) -> f64 {
        (self.young / density).sqrt()
    }

    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        let (_, doubled_strain) = Self::stretch(deformation).ok()?;
        Some(0.125 * self.young * doubled_strain * doubled_strain)
    }
}

/// The name under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    vec![LawEntry::of::<KirchhoffBar>("KirchhoffSaintVenantUniaxialStress1DLaw", &[Kinematics::UniaxialStrain])]
}
