//! The parts that CONTRIBUTING.md adds, from outside the crates: a law, a process and the application
//! that registers them. The blocks between the markers stand in CONTRIBUTING.md word for word.

// [law]
use bia_constitutive::{
    ConstitutiveLaw, DENSITY, Deformation, Fault, LawError, Material, MaterialVariable, Range, Tangent, Voigt, tensor,
};

const BULK_MODULUS: MaterialVariable =
    MaterialVariable { name: "BULK_MODULUS", unit: "Pa", help: "bulk modulus", range: Range::Above(0.0) };

/// Elastic fluid, σ = K ln J / J I.
struct ElasticFluid {
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

// [process]
use bia_kernel::error::{Error, Failure};
use bia_kernel::parameters::{Key, Kind, Range as Allowed};
use bia_kernel::processes::{Context, Process};
use bia_kernel::registry::ProcessEntry;
use bia_mpm::points::MaterialPoints;

/// Stops the run when a material point is faster than a limit.
struct SpeedLimit {
    limit: f64,
}

const SPEED_LIMIT: ProcessEntry = ProcessEntry {
    name: "speed_limit_process",
    aliases: &[],
    application: Some("MyApplication"),
    keys: &[Key::required("limit", Kind::Number(Allowed::POSITIVE), "largest speed [m/s]")],
    help: "stops the run when a material point is faster than a limit",
    build: |building| Ok(Box::new(SpeedLimit { limit: building.settings.number("limit") })),
};

impl Process for SpeedLimit {
    fn name(&self) -> &str {
        "speed_limit"
    }

    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        let Some(points) = context.model.extension::<MaterialPoints>() else { return Ok(()) };
        for block in &points.blocks {
            for (point, id) in block.ids.iter().enumerate() {
                let speed = block.velocity.row(point).iter().map(|v| v * v).sum::<f64>().sqrt();
                if speed > self.limit {
                    let what = format!("a speed of {speed} m/s is above the limit of {} m/s", self.limit);
                    let failure = Failure::new(what, "smaller loads, or a higher limit");
                    return Err(failure.at(format!("material point {id}"), block.coordinates(point)).into());
                }
            }
        }
        Ok(())
    }
}
// [/process]

// [application]
use bia_constitutive::{Catalogue, Kinematics, LawEntry};
use bia_kernel::geometry::Shape;
use bia_kernel::io::mdpa::Category;
use bia_kernel::registry::Registry;

/// Adds the components of this application, after those that it builds on.
pub fn register(registry: &mut Registry) {
    let laws: &mut Catalogue = registry.catalogue_mut();
    if let Err(taken) = laws.register(LawEntry::of::<ElasticFluid>("ElasticFluid2D", &[Kinematics::PlaneStrain])) {
        tracing::error!("{taken}");
    }
    registry.process(SPEED_LIMIT);
    registry.cell(Category::Element, "MyElement2D4N", Shape::Quadrilateral4);
}
// [/application]

use bia_constitutive::verify::tangent_from_stress;
use bia_kernel::analysis::Analysis;
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use std::path::Path;

const PROJECT: &str = r#"{
    "problem_data": {"end_time": 0.05},
    "solver_settings": {
        "solver_type": "dynamic", "scheme_type": "newmark", "domain_size": 2, "time_stepping": {"time_step": 0.01},
        "model_import_settings": {"input_filename": "body"}, "grid_model_import_settings": {"input_filename": "grid"},
        "material_import_settings": {"materials_filename": "materials.json"}
    },
    "processes": {"list": [
        {"python_module": "assign_gravity_to_material_point_process",
         "Parameters": {"model_part_name": "MPM_Material", "modulus": 9.81, "direction": [0, -1, 0]}},
        {"python_module": "speed_limit_process", "Parameters": {"limit": 0.25}}
    ]}
}"#;

const MATERIALS: &str = r#"{"properties": [{
    "model_part_name": "Initial_MPM_Material", "properties_id": 1,
    "Material": {
        "constitutive_law": {"name": "ElasticFluid2D"},
        "Variables": {"DENSITY": 1000, "BULK_MODULUS": 1e6, "THICKNESS": 1, "MATERIAL_POINTS_PER_ELEMENT": 4}}}]}"#;

/// A square with this lower left corner and edge, in one element.
fn square(corner: f64, edge: f64, element: &str) -> String {
    let (a, b) = (corner, corner + edge);
    format!(
        "Begin Properties 0\nEnd Properties\nBegin Nodes\n1 {a} {a} 0\n2 {b} {a} 0\n3 {b} {b} 0\n4 {a} {b} 0\nEnd Nodes\n\
         Begin Elements {element}\n1 0 1 2 3 4\nEnd Elements\nBegin SubModelPart Body\nBegin SubModelPartNodes\n1\n2\n3\n4\n\
         End SubModelPartNodes\nBegin SubModelPartElements\n1\nEnd SubModelPartElements\nEnd SubModelPart\n"
    )
}

#[test]
fn an_outside_application_takes_part_in_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("p.json", PROJECT.to_string()),
        ("materials.json", MATERIALS.to_string()),
        ("grid.mdpa", square(0.0, 3.0, "Element2D4N")),
        ("body.mdpa", square(1.0, 1.0, "MyElement2D4N")),
    ];
    for (name, text) in &files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    register(&mut registry);
    let options = RunOptions { folder: folder.path().into(), output: folder.path().into(), kratos_exact: false };
    let document = Document::read(&folder.path().join("p.json")).unwrap();
    let mut analysis = Analysis::prepare(document, &registry, options, false).map_err(|e| e.to_string()).unwrap();
    // After three steps of 0.01 s the speed is 0.2943 m/s.
    let Err(Error::Failure(failure)) = analysis.run(&mut (), None) else { panic!("the limit was passed unseen") };
    let message = failure.to_string();
    assert!(message.contains("a speed of 0.2943") && message.contains("step 3"), "{message}");
}

#[test]
fn the_outside_law_has_a_consistent_tangent() {
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

/// A guide whose code is not this code would lead astray.
#[test]
fn the_guide_shows_this_code() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide = std::fs::read_to_string(root.join("CONTRIBUTING.md")).unwrap();
    let source = std::fs::read_to_string(root.join("tests/contributing.rs")).unwrap();
    for name in ["law", "process", "application"] {
        let (_, rest) = source.split_once(&format!("// [{name}]\n")).unwrap();
        let (code, _) = rest.split_once(&format!("// [/{name}]\n")).unwrap();
        assert!(
            guide.contains(&format!("```rust\n{code}```")),
            "CONTRIBUTING.md and tests/contributing.rs differ: {name}"
        );
    }
}
