//! `ImportGmshModeler`: meshes that Gmsh wrote.

use super::reading::insert;
use crate::diagnostic::InputErrors;
use crate::io::gmsh;
use crate::model::Model;
use crate::parameters::{Key, Kind, Settings};
use crate::registry::{Modeler, ModelerEntry, Registry};
use std::path::PathBuf;

const KEYS: &[Key] = &[
    Key::required("input_filename", Kind::Text, "msh file of format 2.2 or 4.1"),
    Key::required("model_part_name", Kind::Text, "root model part to make; physical groups are its sub model parts"),
    Key::optional("element_prefix", Kind::Text, "beginning of the elements' names, by default as the part asks"),
];

/// Registers the modeler of this file.
pub(super) fn register(registry: &mut Registry) {
    registry.modeler(ModelerEntry {
        name: "ImportGmshModeler",
        keys: KEYS,
        lists: Vec::new,
        help: "reads a mesh of Gmsh into a new root model part; groups of lower dimension are geometries, of which \
               CreateEntitiesFromGeometriesModeler makes conditions",
        build: |building| {
            let file = building.options.folder.join(building.settings.text("input_filename"));
            Ok(Box::new(Import { file, settings: building.settings }))
        },
    });
}

struct Import {
    file: PathBuf,
    settings: Settings,
}

impl Modeler for Import {
    fn setup_geometry(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        let name = self.settings.text("model_part_name");
        let prefix = match self.settings.given("element_prefix") {
            true => self.settings.text("element_prefix"),
            false => registry.element_prefix(name),
        };
        insert(model, gmsh::read(&self.file, name, prefix)?, &self.settings)
    }
}
