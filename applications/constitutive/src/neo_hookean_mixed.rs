//! Neo-Hookean solid for mixed displacement-pressure elements.
//!
//! W = μ/2 (J^(−2/3) tr b − 3) + p (J − 1) − Ψ*(p),  b = F Fᵀ
//! σ = μ J^(−5/3) dev b + p I
//! J c = −⅔ (τ_iso ⊗ I + I ⊗ τ_iso) + ⅔ μ J^(−2/3) tr b (𝕀 − ⅓ I ⊗ I) + p J (I ⊗ I − 2 𝕀),
//! τ_iso = μ J^(−2/3) dev b, 𝕀_abcd = ½(δ_ac δ_bd + δ_ad δ_bc), at constant p.
//!
//! Source: Simo, Taylor and Pister 1985; Bonet and Wood, §6.5. The tangent of Kratos lacks J^(−2/3)
//! in the second term.

use nalgebra::Matrix3;

use crate::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LawEntry, LawError, Material, MaterialVariable,
    MixedModuli, Shear, Tangent, Voigt, VolumetricLaw, YOUNG_MODULUS,
    material::POISSON_RATIO_TO_HALF,
    mixed_pressure,
    tensor::{
        VOIGT_PAIRS, almansi_strain, displacement_gradient, strain_to_voigt, stress_to_voigt, tensor_of, volume_change,
        volume_ratio,
    },
};

/// Neo-Hookean solid with nodal pressure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NeoHookeanMixed {
    mu: f64,
    compressibility: f64,
    volumetric: VolumetricLaw,
    kratos_tangent: bool,
}

/// Stress and what the tangent needs beside it.
struct Answer {
    stress: Matrix3<f64>,
    /// τ_iso/J.
    isochoric: Matrix3<f64>,
    pressure: f64,
    /// J^(−2/3).
    scale: f64,
    trace: f64,
    jacobian: f64,
}

impl NeoHookeanMixed {
    /// From the shear modulus (Pa) and 1/κ (1/Pa), with the exact tangent.
    pub fn from_moduli(mu: f64, compressibility: f64, volumetric: VolumetricLaw) -> Self {
        Self { mu, compressibility, volumetric, kratos_tangent: false }
    }

    fn evaluate(&self, deformation: &Deformation) -> Result<Answer, LawError> {
        let jacobian = volume_ratio(&deformation.gradient)?;
        let pressure = mixed_pressure(deformation)?;
        // b − I, whose deviator is that of b.
        let h = displacement_gradient(&deformation.gradient);
        let stretch = h + h.transpose() + h * h.transpose();
        let scale = jacobian.cbrt().powi(-2);
        let deviator = stretch - Matrix3::from_diagonal_element(stretch.trace() / 3.0);
        let isochoric = self.mu * scale / jacobian * deviator;
        let stress = isochoric + Matrix3::from_diagonal_element(pressure);
        Ok(Answer { stress, isochoric, pressure, scale, trace: 3.0 + stretch.trace(), jacobian })
    }
}

impl ConstitutiveLaw for NeoHookeanMixed {
    const NAME: &'static str = "neo-Hookean with nodal pressure";
    const HELP: &'static str =
        "Neo-Hookean solid for mixed elements, σ = μ J^(−5/3) dev b + p I (Simo, Taylor and Pister 1985)";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, YOUNG_MODULUS, POISSON_RATIO_TO_HALF];
    const MIXED: bool = true;
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        let (young, poisson) = (material.get(YOUNG_MODULUS)?, material.get(POISSON_RATIO_TO_HALF)?);
        Ok(Self {
            mu: young / (2.0 * (1.0 + poisson)),
            compressibility: 3.0 * (1.0 - 2.0 * poisson) / young,
            volumetric: material.options().mixed.unwrap_or_default(),
            kratos_tangent: material.options().kratos_exact,
        })
    }

    fn stress(&self, deformation: &Deformation, _: &mut ()) -> Result<Voigt, LawError> {
        Ok(stress_to_voigt(&self.evaluate(deformation)?.stress))
    }

    fn stress_and_tangent(&self, deformation: &Deformation, _: &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let at = self.evaluate(deformation)?;
        let scale = if self.kratos_tangent { 1.0 } else { at.scale };
        let spherical = 2.0 / 3.0 * self.mu * scale * at.trace / at.jacobian;
        let one = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let mut tangent = [[0.0; 6]; 6];
        for (row, (a, b)) in VOIGT_PAIRS.into_iter().enumerate() {
            for (column, (c, d)) in VOIGT_PAIRS.into_iter().enumerate() {
                let symmetric = 0.5 * (one(a, c) * one(b, d) + one(a, d) * one(b, c));
                let traces = one(a, b) * one(c, d);
                let mixed = at.isochoric[(a, b)] * one(c, d) + one(a, b) * at.isochoric[(c, d)];
                tangent[row][column] = spherical * (symmetric - traces / 3.0) - 2.0 / 3.0 * mixed
                    + at.pressure * (traces - 2.0 * symmetric);
            }
        }
        Ok((stress_to_voigt(&at.stress), tangent))
    }

    /// Almansi strain.
    fn strain(&self, deformation: &Deformation) -> Voigt {
        strain_to_voigt(&almansi_strain(&deformation.gradient))
    }

    /// Infinite where the solid is incompressible.
    fn wave_speed(&self, density: f64) -> f64 {
        ((1.0 / self.compressibility + 4.0 / 3.0 * self.mu) / density).sqrt()
    }

    /// Ψ_dev + p (J − 1) − Ψ*(p); Ψ_dev alone without a pressure.
    fn energy(&self, deformation: &Deformation) -> Option<f64> {
        let jacobian = volume_ratio(&deformation.gradient).ok()?;
        let h = displacement_gradient(&deformation.gradient);
        let change = volume_change(&tensor_of(&h));
        // J^(−2/3) tr b − 3 = J^(−2/3) tr(b − I) + 3 (J^(−2/3) − 1), without its cancellation.
        let logarithm = -2.0 / 3.0 * change.ln_1p();
        let stretch = 2.0 * h.trace() + h.norm_squared();
        let isochoric = 0.5 * self.mu * (jacobian.cbrt().powi(-2) * stretch + 3.0 * logarithm.exp_m1());
        let p = deformation.pressure.unwrap_or(0.0);
        Some(isochoric + p * change - self.volumetric.complementary_energy(p, self.compressibility))
    }

    fn mixed(&self) -> Option<MixedModuli> {
        let Self { mu, compressibility, volumetric, .. } = *self;
        Some(MixedModuli { compressibility, shear: Shear::Elastic(mu), volumetric })
    }
}

/// The names under which materials files know this law.
pub(crate) fn entries() -> Vec<LawEntry> {
    use Kinematics::{PlaneStrain, ThreeDimensional};
    vec![
        LawEntry::of::<NeoHookeanMixed>("HyperElasticNeoHookeanUP3DLaw", &[ThreeDimensional]),
        LawEntry::of::<NeoHookeanMixed>("HyperElasticNeoHookeanPlaneStrainUP2DLaw", &[PlaneStrain]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::{stress_from_energy, tangent_from_stress};

    const ALL: &[usize] = &[0, 1, 2, 3, 4, 5];

    fn deformed() -> Deformation {
        let gradient = Matrix3::new(1.3, 0.2, -0.1, 0.05, 0.9, 0.15, -0.2, 0.1, 1.2);
        Deformation { pressure: Some(-0.7), ..Deformation::from_gradient(gradient) }
    }

    #[test]
    fn stress_and_tangent_are_derivatives_and_kratos_tangent_is_not() {
        let law = NeoHookeanMixed::from_moduli(2.0, 0.1, VolumetricLaw::Linear);
        let (stress, tangent) = law.stress_and_tangent(&deformed(), &mut ()).unwrap();
        let energy = stress_from_energy(&law, &deformed(), ALL).unwrap();
        assert!(stress.iter().zip(energy).all(|(s, e)| (s - e).abs() < 1e-9), "{stress:?} {energy:?}");
        let reference = tangent_from_stress(&law, &deformed(), &(), ALL).unwrap();
        let distance = |tangent: &Tangent| {
            let pairs = tangent.iter().flatten().zip(reference.iter().flatten());
            pairs.map(|(c, r)| (c - r).abs()).fold(0.0, f64::max)
        };
        assert!(distance(&tangent) < 1e-8, "{}", distance(&tangent));
        let kratos = NeoHookeanMixed { kratos_tangent: true, ..law };
        assert!(distance(&kratos.stress_and_tangent(&deformed(), &mut ()).unwrap().1) > 0.1);
    }

    /// At small strain the law is Hooke's with the deviator of the strain; the mean stress is p.
    #[test]
    fn small_strain_and_pressure() {
        let law = NeoHookeanMixed::from_moduli(3.0, 0.0, VolumetricLaw::Miehe);
        let size = 2.0_f64.powi(-30);
        let h = Matrix3::new(0.3, 0.8, -0.2, 0.1, -0.6, 0.5, 0.4, -0.7, 0.9);
        let at =
            Deformation { pressure: Some(0.25 * size), ..Deformation::from_gradient(Matrix3::identity() + size * h) };
        let stress = law.stress(&at, &mut ()).unwrap().map(|s| s / size);
        let mean = h.trace() / 3.0;
        for (k, (a, b)) in VOIGT_PAIRS.into_iter().enumerate() {
            let expected = 3.0 * (h[(a, b)] + h[(b, a)]) + if a == b { 0.25 - 6.0 * mean } else { 0.0 };
            assert!((stress[k] - expected).abs() < 1e-6, "{k}: {} {expected}", stress[k]);
        }
        assert!(ConstitutiveLaw::wave_speed(&law, 1.0).is_infinite());
        let none = law.stress(&Deformation::from_gradient(Matrix3::identity()), &mut ());
        assert!(matches!(none, Err(LawError::Unsuitable { .. })));
    }
}
