//! A crate outside adds a law of its own in one line.

use bia_constitutive::{
    Catalogue, ConstitutiveLaw, DENSITY, Deformation, Fault, Kinematics, LawEntry, LawError, Material, MaterialPlaces,
    MaterialVariable, Options, Range, Tangent, Voigt, catalogue, tensor,
};
use bia_kernel::model::{Properties, Value};

const BULK_MODULUS: MaterialVariable =
    MaterialVariable { name: "BULK_MODULUS", unit: "Pa", help: "bulk modulus", range: Range::Above(0.0) };

/// An ideal elastic fluid, σ = K ln J / J · I.
struct Fluid {
    bulk_modulus: f64,
}

impl ConstitutiveLaw for Fluid {
    const NAME: &'static str = "elastic fluid";
    const HELP: &'static str = "pressure from the volume alone";
    const VARIABLES: &'static [MaterialVariable] = &[DENSITY, BULK_MODULUS];
    type State = ();

    fn new(material: &Material) -> Result<Self, Fault> {
        Ok(Self { bulk_modulus: material.get(BULK_MODULUS)? })
    }

    fn stress(&self, d: &Deformation, (): &mut ()) -> Result<Voigt, LawError> {
        let jacobian = tensor::volume_ratio(&d.gradient)?;
        let mean = self.bulk_modulus * jacobian.ln() / jacobian;
        Ok([mean, mean, mean, 0.0, 0.0, 0.0])
    }

    fn stress_and_tangent(&self, d: &Deformation, (): &mut ()) -> Result<(Voigt, Tangent), LawError> {
        let jacobian = tensor::volume_ratio(&d.gradient)?;
        let pressure = self.bulk_modulus * jacobian.ln() / jacobian;
        Ok((self.stress(d, &mut ())?, tensor::isotropic_tangent(self.bulk_modulus / jacobian, -pressure)))
    }

    fn strain(&self, d: &Deformation) -> Voigt {
        tensor::strain_to_voigt(&tensor::almansi_strain(&d.gradient))
    }

    fn wave_speed(&self, density: f64) -> f64 {
        (self.bulk_modulus / density).sqrt()
    }
}

#[test]
fn an_outside_law_is_registered_found_built_and_verified() {
    let mut laws: Catalogue = catalogue();
    laws.register(LawEntry::of::<Fluid>("ElasticFluid3D", &[Kinematics::ThreeDimensional])).unwrap();

    let mut material = Properties { law: Some("my_laws.ElasticFluid3D".into()), ..Default::default() };
    let options = Options::default();
    let build = |material: &Properties| {
        laws.build(material, Kinematics::ThreeDimensional, &options, &MaterialPlaces::default())
            .map_err(|e| e.to_string())
    };
    let error = build(&material).err().unwrap();
    assert!(error.contains("DENSITY is missing") && error.contains("BULK_MODULUS is missing"), "{error}");

    material.values.insert("DENSITY".into(), Value::Number(1000.0));
    material.values.insert("BULK_MODULUS".into(), Value::Number(2e9));
    let law = build(&material).unwrap();
    assert!((law.wave_speed(1000.0) - 2e6_f64.sqrt()).abs() < 1e-9);

    let law = Fluid { bulk_modulus: 2e9 };
    let deformation = Deformation::from_gradient(nalgebra::Matrix3::new(0.9, 0.1, 0.0, -0.2, 1.1, 0.3, 0.1, 0.0, 0.8));
    let (_, tangent) = law.stress_and_tangent(&deformation, &mut ()).unwrap();
    let all = Kinematics::ThreeDimensional.voigt();
    let reference = bia_constitutive::verify::tangent_from_stress(&law, &deformation, &(), all).unwrap();
    for (row, expected) in tangent.iter().zip(reference) {
        for (entry, expected) in row.iter().zip(expected) {
            assert!((entry - expected).abs() < 1e-8 * 2e9, "{entry} {expected}");
        }
    }
}
