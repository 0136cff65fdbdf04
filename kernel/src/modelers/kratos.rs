//! Kratos's modelers: read mdpa files, and turn geometries into elements and conditions.

use crate::diagnostic::InputErrors;
use crate::io::mdpa::{self, Category, CellNames};
use crate::model::{Cells, Model, Properties};
use crate::parameters::{Key, Kind, Parameters, Settings};
use crate::registry::{Building, Modeler, ModelerEntry, Registry};
use std::path::PathBuf;

const IMPORT: &[Key] = &[
    Key::new("echo_level", Kind::Integer { min: 0 }, "0", "ignored"),
    Key::required("input_filename", Kind::Text, "mdpa file, with or without .mdpa"),
    Key::required("model_part_name", Kind::Text, "root model part to make"),
];
const CREATE: &[Key] = &[
    Key::new("echo_level", Kind::Integer { min: 0 }, "0", "ignored"),
    Key::new("elements_list", Kind::List, "[]", "objects of model_part_name and element_name"),
    Key::new("conditions_list", Kind::List, "[]", "objects of model_part_name and condition_name"),
];
const ELEMENTS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part whose geometries become elements"),
    Key::required("element_name", Kind::Text, "registered element"),
];
const CONDITIONS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part whose geometries become conditions"),
    Key::required("condition_name", Kind::Text, "registered condition"),
];

/// Registers the modelers of this file.
pub fn register(registry: &mut Registry) {
    registry.modeler(ModelerEntry {
        name: "ImportMDPAModeler",
        keys: IMPORT,
        lists: Vec::new,
        help: "reads an mdpa file into a new root model part",
        build: |building| {
            let mut file = building.options.folder.join(building.settings.text("input_filename"));
            if file.extension().is_none_or(|extension| extension != "mdpa") {
                file.as_mut_os_string().push(".mdpa");
            }
            Ok(Box::new(Import { file, part: building.settings.text("model_part_name").into() }))
        },
    });
    registry.modeler(ModelerEntry {
        name: "CreateEntitiesFromGeometriesModeler",
        keys: CREATE,
        lists: Vec::new,
        help: "makes elements and conditions of the geometries of model parts",
        build: create,
    });
}

struct Import {
    file: PathBuf,
    part: String,
}

impl Modeler for Import {
    fn setup_geometry(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        model.insert(mdpa::read(&self.file, &self.part, registry)?);
        Ok(())
    }
}

struct Create {
    entries: Vec<(Category, Settings)>,
}

fn create(building: Building) -> Result<Box<dyn Modeler>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut entries = Vec::new();
    for (category, list, keys) in
        [(Category::Element, "elements_list", ELEMENTS), (Category::Condition, "conditions_list", CONDITIONS)]
    {
        for entry in building.settings.get(list).map_or(Vec::new(), Parameters::entries) {
            entries.extend(errors.absorb(entry.read(keys)).map(|settings| (category, settings)));
        }
    }
    errors.or(Box::new(Create { entries }))
}

impl Modeler for Create {
    fn setup_geometry(&mut self, _: &mut Model, _: &Registry) -> Result<(), InputErrors> {
        Ok(())
    }

    fn setup_model_part(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        for (category, settings) in &self.entries {
            errors.absorb(create_entities(model, registry, *category, settings));
        }
        errors.or(())
    }
}

/// Makes one element (or condition) of each geometry of a part, with the geometry's nodes.
fn create_entities(
    model: &mut Model,
    registry: &Registry,
    category: Category,
    settings: &Settings,
) -> Result<(), InputErrors> {
    let key = if category == Category::Element { "element_name" } else { "condition_name" };
    let (path, name) = (settings.text("model_part_name").to_string(), settings.text(key).to_string());
    let Some(shape) = registry.shape(category, &name) else {
        let names = registry.names(category);
        let diagnostic = settings.error(key, format!("{name:?} is not registered"));
        return Err(diagnostic.allowed(&name, names.iter().map(String::as_str)).into());
    };
    let Some(members) = model.members(&path) else {
        let diagnostic = settings.error("model_part_name", format!("there is no model part {path:?}"));
        return Err(model.suggest_part(diagnostic, &path).into());
    };
    let below = path.split_once('.').map(|(_, below)| below.to_string());
    let Some(part) = model.part_mut(&members.root) else { return Ok(()) };
    let geometries: Vec<u32> = match &below {
        Some(below) => part.find(below).map_or(Vec::new(), |sub| sub.geometries.clone()),
        None => (0..part.geometries.len() as u32).collect(),
    };
    let wrong = geometries.iter().find(|&&g| part.geometries.shapes[g as usize].node_count() != shape.node_count());
    if let Some(&wrong) = wrong {
        let id = part.geometries.ids[wrong as usize];
        let found = part.geometries.name_of(wrong as usize);
        return Err(settings.error(key, format!("{name:?} does not fit the geometry {id}, a {found}")).into());
    }
    part.properties.entry(0).or_insert_with(Properties::default);
    let geometry_cells = part.geometries.clone();
    let cells: &mut Cells = if category == Category::Element { &mut part.elements } else { &mut part.conditions };
    let first = cells.len() as u32;
    let next_id = cells.ids.iter().max().map_or(1, |id| id.saturating_add(1));
    for (i, &geometry) in geometries.iter().enumerate() {
        cells.push(next_id + i as u32, &name, shape, 0, geometry_cells.nodes_of(geometry as usize));
    }
    let made: Vec<u32> = (first..first + geometries.len() as u32).collect();
    add_to_owners(&mut part.children, category, &geometries, &made);
    Ok(())
}

/// Parts that hold a geometry hold what was made of it, too, as the children's lists show.
fn add_to_owners(children: &mut [crate::model::SubModelPart], category: Category, from: &[u32], made: &[u32]) {
    for child in children {
        let list = if category == Category::Element { &mut child.elements } else { &mut child.conditions };
        for (geometry, entity) in from.iter().zip(made) {
            if child.geometries.binary_search(geometry).is_ok() {
                list.push(*entity);
            }
        }
        list.sort_unstable();
        add_to_owners(&mut child.children, category, from, made);
    }
}
