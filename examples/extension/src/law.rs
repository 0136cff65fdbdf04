//! A law: one struct, one impl.

// [law]
use bia_constitutive::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, LawError, Material, MaterialVariable, Range, Tangent, Voigt, tensor,
};

const BULK_MODULUS: MaterialVariable =
    MaterialVariable { name: "BULK_MODULUS", unit: "Pa", help: "bulk modulus", range: Range::Above(0.0) };

/// Elastic fluid, σ = K ln J / J I.
pub struct ElasticFluid {
    bulk_modulus: f64,
}

impl ConstitutiveLaw for ElasticFluid {
    const NAME: &'static str = "elastic fluid";
    const HELP: &'static str = "pressure from the change of volume alone, σ = K ln J / J I";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, BULK_MODULUS];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self { bulk_modulus: material.get(BULK_MODULUS)? })
    }

    fn stress(&self, deformation: &Deformation, (): &mut ()) -> Result<Voigt, LawError> {
        let jacobian = tensor::volume_ratio(&deformation.gradient)?;
        let mean = self.bulk_modulus * jacobian.ln() / jacobian;
        Ok([mean, mean, mean, 0.0, 0.0, 0.0])
    }

    fn stress_and_tangent(&self, deformation: &Deformation, (): &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let stress = self.stress(deformation, &mut ())?;
        let jacobian = tensor::volume_ratio(&deformation.gradient)?;
        Ok((stress, tensor::isotropic_tangent(self.bulk_modulus / jacobian, -stress[0])))
    }

    fn strain(&self, deformation: &Deformation) -> Voigt {
        tensor::strain_to_voigt(&tensor::almansi_strain(&deformation.gradient))
    }

    fn wave_speed(&self, density: f64) -> f64 {
        (self.bulk_modulus / density).sqrt()
    }
}
// [/law]

#[cfg(test)]
mod tests {
    use super::*;
    use bia_constitutive::Kinematics;
    use bia_constitutive::verify::tangent_from_stress;

    #[test]
    fn the_tangent_is_consistent() {
        let law = ElasticFluid { bulk_modulus: 2e9 };
        let mut deformation = Deformation::from_gradient(Default::default());
        for (i, entry) in [0.9, -0.2, 0.1, 0.1, 1.1, 0.0, 0.0, 0.3, 0.8].into_iter().enumerate() {
            deformation.gradient[i] = entry;
        }
        let (_, tangent) = law.stress_and_tangent(&deformation, &mut ()).unwrap();
        let reference = tangent_from_stress(&law, &deformation, &(), Kinematics::ThreeDimensional.voigt()).unwrap();
        for (entry, expected) in tangent.iter().flatten().zip(reference.iter().flatten()) {
            assert!((entry - expected).abs() < 1e-8 * 2e9, "{entry} {expected}");
        }
    }
}
