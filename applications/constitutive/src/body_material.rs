//! Materials of bodies, from a file or from the project itself: constants and law of each part.

use crate::{Catalogue, Kinematics, Law, MaterialPlaces, Options};
use bia_kernel::diagnostic::{InputErrors, Place};
use bia_kernel::model::{ModelPart, Properties, Table, Value};
use bia_kernel::parameters::{Document, Key, Kind, Parameters, Settings};
use std::path::{Path, PathBuf};

/// Keys of `material_import_settings`.
pub const MATERIAL_IMPORT: &[Key] = &[
    Key::new("materials_filename", Kind::Text, "\"\"", "materials file"),
    Key::optional("materials", Kind::List, "the entries of the materials file's list \"properties\", here"),
];
const ENTRY: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of the bodies, root name first"),
    Key::required("properties_id", Kind::Integer { min: 0 }, "id of these properties"),
    Key::required("Material", Kind::Object(MATERIAL), "the material"),
];
const MATERIAL: &[Key] = &[
    Key::optional("name", Kind::Text, "ignored"),
    Key::optional("constitutive_law", Kind::Object(LAW), "the law"),
    Key::new("Variables", Kind::Any, "{}", "constants by variable name"),
    Key::new("Tables", Kind::Any, "{}", "tables by any name"),
];
const LAW: &[Key] = &[Key::required("name", Kind::Text, "name of the law")];
const TABLE: &[Key] = &[
    Key::required("input_variable", Kind::Text, "argument"),
    Key::required("output_variable", Kind::Text, "value"),
    Key::required("data", Kind::List, "pairs [argument, value]"),
];

/// Variables that elements take from a material, beside those of the laws.
const ELEMENT_VARIABLES: &[&str] = &["DENSITY", "THICKNESS", "CROSS_AREA", "MATERIAL_POINTS_PER_ELEMENT"];
/// Variables that Kratos's materials may carry though the present law does not read them.
const OTHER_VARIABLES: &[&str] = &[
    "YOUNG_MODULUS",
    "POISSON_RATIO",
    "BULK_MODULUS",
    "DYNAMIC_VISCOSITY",
    "COHESION",
    "INTERNAL_FRICTION_ANGLE",
    "INTERNAL_DILATANCY_ANGLE",
    "COHESION_RESIDUAL",
    "INTERNAL_FRICTION_ANGLE_RESIDUAL",
    "INTERNAL_DILATANCY_ANGLE_RESIDUAL",
    "SHAPE_FUNCTION_BETA",
    "PRE_CONSOLIDATION_STRESS",
    "OVER_CONSOLIDATION_RATIO",
    "SWELLING_SLOPE",
    "NORMAL_COMPRESSION_SLOPE",
    "CRITICAL_STATE_LINE",
    "INITIAL_SHEAR_MODULUS",
    "ALPHA_SHEAR",
    "JC_PARAMETER_A",
    "JC_PARAMETER_B",
    "JC_PARAMETER_C",
    "JC_PARAMETER_n",
    "JC_PARAMETER_m",
    "REFERENCE_STRAIN_RATE",
    "TAYLOR_QUINNEY_COEFFICIENT",
    "MELD_TEMPERATURE",
    "REFERENCE_TEMPERATURE",
    "TEMPERATURE",
    "SPECIFIC_HEAT",
];

/// Where the materials come from.
#[derive(Debug, Clone)]
pub enum MaterialSource {
    /// A materials file.
    File(PathBuf),
    /// A list in the project.
    Project(Parameters),
}

impl MaterialSource {
    /// From the object `material_import_settings` with the keys [`MATERIAL_IMPORT`]; `folder` is that
    /// of the project.
    ///
    /// # Errors
    /// No source, or two of them.
    pub fn read(settings: &Settings, folder: &Path) -> Result<Self, InputErrors> {
        let Some(nested) = settings.nested("material_import_settings") else {
            return Err(settings.error("material_import_settings", "must be an object").into());
        };
        match (nested.text("materials_filename"), nested.get("materials")) {
            ("", Some(list)) => Ok(Self::Project(list.clone())),
            ("", None) => {
                let message = "\"materials_filename\" is missing";
                let help = "name the materials file, or write its list here as \"materials\"";
                Err(settings.error("material_import_settings", message).help(help).into())
            }
            (name, None) => Ok(Self::File(folder.join(name))),
            (_, Some(list)) => {
                let message = "the materials stand here and in \"materials_filename\"";
                Err(list.error(message).help("keep one of the two").into())
            }
        }
    }

    /// Reads the materials and gives each element and condition of the named parts its properties.
    /// `roots` are the names under which materials may know `bodies`.
    ///
    /// # Errors
    /// All faults of the materials together.
    pub fn assign(
        &self,
        bodies: &mut ModelPart,
        roots: &[&str],
        catalogue: &Catalogue,
    ) -> Result<Vec<BodyMaterial>, InputErrors> {
        let list = match self {
            Self::File(file) => {
                let root = Parameters::root(Document::read(file)?);
                let list = root.child("properties").filter(|list| list.value().is_array());
                list.ok_or_else(|| InputErrors::from(root.error("the list \"properties\" is missing")))?
            }
            Self::Project(list) => list.clone(),
        };
        let mut errors = InputErrors::default();
        let mut materials: Vec<BodyMaterial> = Vec::new();
        for entry in list.entries() {
            let Some((path, properties)) = errors.absorb(read_entry(&entry, catalogue)) else { continue };
            if let Some(other) = materials.iter().find(|m| m.properties.id == properties.id) {
                let place = other.parameters.place();
                let message = format!("properties_id {} stands twice; the first is at {place}", properties.id);
                errors.push(entry.error(message));
            }
            errors.absorb(apply(bodies, roots, &path, properties.id, &entry));
            bodies.properties.insert(properties.id, properties.clone());
            materials.push(BodyMaterial { properties, parameters: entry });
        }
        errors.or(materials)
    }
}

/// A material with the place it was read from.
pub struct BodyMaterial {
    /// Its constants.
    pub properties: Properties,
    /// Its entry in the file.
    pub parameters: Parameters,
}

/// A law made for the elements of a scene.
pub struct BuiltLaw {
    /// The law.
    pub law: Box<dyn Law>,
    /// Its name in the materials file, without the path before it.
    pub name: String,
    /// Kinematics for which it was made: the law's name chooses plane stress in the plane.
    pub kinematics: Kinematics,
}

/// Poisson's ratio above which elements of displacements alone are told to lock.
const LOCKS: f64 = 0.45;

impl BodyMaterial {
    /// Legal but suspicious facts; `of_displacements` where there are no pressures beside them.
    pub fn warnings(&self, of_displacements: bool) -> Vec<String> {
        let (id, mut warnings) = (self.properties.id, Vec::new());
        if !self.properties.tables.is_empty() {
            warnings.push(format!("properties {id}: tables have no effect, no law of this build reads one"));
        }
        let ratio = self.properties.number("POISSON_RATIO").filter(|ratio| of_displacements && *ratio > LOCKS);
        warnings.extend(ratio.map(|ratio| {
            format!(
                "properties {id}: Poisson's ratio {ratio} with a displacement formulation locks: bodies look too stiff"
            )
        }));
        warnings
    }

    /// The place of a constant; without a name (or if it has another name), of all of them.
    pub fn place_of(&self, name: Option<&str>) -> Parameters {
        let variables = self.parameters.child("Material").and_then(|m| m.child("Variables"));
        let variables = variables.unwrap_or_else(|| self.parameters.clone());
        name.and_then(|name| variables.child(name)).unwrap_or(variables)
    }

    /// A number above 0 that the elements of a scene take.
    ///
    /// # Errors
    /// It is missing though `needed`, or not above 0.
    pub fn positive(&self, name: &str, needed: bool) -> Result<Option<f64>, InputErrors> {
        match self.properties.number(name) {
            Some(number) if number > 0.0 => Ok(Some(number)),
            Some(number) => {
                let message = format!("{name} is {number}, must be a number above 0");
                Err(self.place_of(Some(name)).error(message).into())
            }
            None if needed => {
                let error = self.place_of(None).error(format!("the material variable {name} is missing"));
                Err(error.help(format!("{name}: {}", meaning(name))).into())
            }
            None => Ok(None),
        }
    }

    /// The law that the material names, for elements of these kinematics; plane strain becomes plane
    /// stress where the law is for that alone.
    ///
    /// # Errors
    /// Those of [`Catalogue::build`].
    pub fn law(
        &self,
        catalogue: &Catalogue,
        kinematics: Kinematics,
        options: &Options,
    ) -> Result<BuiltLaw, InputErrors> {
        let entry = self.properties.law.as_deref().and_then(|name| catalogue.find(name));
        let refined = match (kinematics, entry) {
            (Kinematics::PlaneStrain, Some(entry))
                if !entry.kinematics.contains(&Kinematics::PlaneStrain)
                    && entry.kinematics.contains(&Kinematics::PlaneStress) =>
            {
                Kinematics::PlaneStress
            }
            _ => kinematics,
        };
        let law_name = self.parameters.child("Material").and_then(|m| m.child("constitutive_law")?.child("name"));
        let values = self.place_of(None);
        let law = law_name.as_ref().unwrap_or(&self.parameters).place();
        let places = MaterialPlaces { law, values: values.place() };
        let law = catalogue.build(&self.properties, refined, options, &places).map_err(|mut faults| {
            // The law knows the pointer of a value, the document its line.
            for place in faults.0.iter_mut().map(|fault| &mut fault.place).filter(|place| **place != places.law) {
                *place = place.pointer.as_deref().map_or_else(Place::default, |p| values.document().place(p));
            }
            faults
        })?;
        let name = entry.map_or_else(String::new, |entry| entry.name.to_string());
        Ok(BuiltLaw { law, name, kinematics: refined })
    }
}

fn read_entry(entry: &Parameters, catalogue: &Catalogue) -> Result<(String, Properties), InputErrors> {
    let settings = entry.read(ENTRY)?;
    let mut errors = InputErrors::default();
    let id = u32::try_from(settings.integer("properties_id")).unwrap_or_else(|_| {
        let message = format!("is {}, must be at most {}", settings.integer("properties_id"), u32::MAX);
        errors.push(settings.error("properties_id", message));
        0
    });
    let mut properties = Properties { id, ..Properties::default() };
    if let Some(material) = settings.nested("Material") {
        properties.law = material.nested("constitutive_law").map(|law| law.text("name").to_string());
        // Kratos's own projects write null for none.
        let mut members = |key: &str| {
            material.get(key).filter(|m| !m.value().is_null()).and_then(|object| errors.absorb(object.object()))
        };
        let (variables, tables) = (members("Variables"), members("Tables"));
        for (name, value) in variables.unwrap_or_default() {
            let Some((last, number)) = errors.absorb(read_variable(&name, &value, catalogue)) else { continue };
            if properties.values.insert(last.clone(), number).is_some() {
                let message = format!("{name:?} and another key both give {last}");
                errors.push(value.error(message).help(format!("keep {last} alone")));
            }
        }
        for (_, table) in tables.unwrap_or_default() {
            properties.tables.extend(errors.absorb(read_table(&table)));
        }
    }
    errors.or((settings.text("model_part_name").to_string(), properties))
}

fn read_variable(name: &str, value: &Parameters, catalogue: &Catalogue) -> Result<(String, Value), InputErrors> {
    let mut name = name;
    if name == "PARTICLES_PER_ELEMENT" {
        name = "MATERIAL_POINTS_PER_ELEMENT";
        tracing::warn!("{}", value.warning(format!("\"PARTICLES_PER_ELEMENT\" is an old name of {name:?}")));
    }
    let last = name.rsplit('.').next().unwrap_or(name);
    let laws = || {
        catalogue
            .entries()
            .iter()
            .flat_map(|law| law.variables.iter().chain(law.optional))
            .map(|variable| variable.name)
    };
    let known = || ELEMENT_VARIABLES.iter().chain(OTHER_VARIABLES).copied().chain(laws());
    if !known().any(|k| k == last) {
        return Err(value.error(format!("the material variable {name:?} is unknown")).allowed(last, known()).into());
    }
    match value.value().as_f64() {
        Some(number) if number.is_finite() => Ok((last.to_string(), Value::Number(number))),
        _ => Err(value.error(format!("{last} is {}, must be a number", value.describe())).into()),
    }
}

fn read_table(entry: &Parameters) -> Result<((String, String), Table), InputErrors> {
    let settings = entry.read(TABLE)?;
    let list = settings.get("data").map_or(Vec::new(), Parameters::entries);
    let mut pairs = Vec::new();
    for pair in &list {
        match pair.value().as_array().map(|p| p.iter().map(|x| x.as_f64()).collect::<Vec<_>>()).as_deref() {
            Some([Some(x), Some(y)]) => pairs.push((*x, *y)),
            _ => return Err(pair.error("must be a pair of numbers").into()),
        }
    }
    let table = Table::new(pairs).map_err(|message| InputErrors::from(entry.error(message)))?;
    Ok(((settings.text("input_variable").into(), settings.text("output_variable").into()), table))
}

/// What the material variables mean that elements read, with their units.
fn meaning(name: &str) -> &'static str {
    match name {
        "THICKNESS" => "extent of a plane body across its mesh, a number above 0 [m]; 1 is usual",
        "CROSS_AREA" => "area across a body on a line, a number above 0 [m²]",
        "MATERIAL_POINTS_PER_ELEMENT" => "material points in each cell of the body's mesh, a whole number above 0",
        "DENSITY" => "mass per volume of the undeformed material, a number above 0 [kg/m³]",
        _ => "a number above 0",
    }
}

/// Sets the properties of all elements and conditions of a part.
fn apply(bodies: &mut ModelPart, roots: &[&str], path: &str, id: u32, entry: &Parameters) -> Result<(), InputErrors> {
    let (root, below) = path.split_once('.').map_or((path, None), |(root, below)| (root, Some(below)));
    let place = entry.child("model_part_name").unwrap_or_else(|| entry.clone());
    let unknown = |bodies: &ModelPart| {
        let names: Vec<String> = bodies.paths().iter().map(|p| format!("{}.{p}", bodies.name)).collect();
        let diagnostic = place.error(format!("there is no part {path:?} of the bodies"));
        if names.is_empty() {
            return diagnostic.help("their mesh has no sub model parts at all").into();
        }
        InputErrors::from(diagnostic.allowed(path, names.iter().map(String::as_str)))
    };
    if !roots.contains(&root) {
        return Err(unknown(bodies));
    }
    let (elements, conditions) = match below {
        None => ((0..bodies.elements.len() as u32).collect(), (0..bodies.conditions.len() as u32).collect()),
        Some(below) => match bodies.find(below) {
            Some(sub) => (sub.elements.clone(), sub.conditions.clone()),
            None => return Err(unknown(bodies)),
        },
    };
    if elements.is_empty() && conditions.is_empty() {
        return Err(place.error(format!("the part {path:?} has no elements, so its material is for nothing")).into());
    }
    for element in elements {
        bodies.elements.properties[element as usize] = id;
    }
    for condition in conditions {
        bodies.conditions.properties[condition as usize] = id;
    }
    Ok(())
}
