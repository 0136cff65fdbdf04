//! Where a solver's mesh comes from, and the mesh itself, checked.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::geometry::check_cells;
use crate::io::gmsh;
use crate::io::mdpa::{self, Category};
use crate::model::{Model, ModelPart};
use crate::parameters::{Key, Kind, Settings};
use crate::registry::Registry;
use std::path::{Path, PathBuf};

/// Keys of `model_import_settings` and its like.
pub const MESH_IMPORT: &[Key] = &[
    Key::new(
        "input_type",
        Kind::Choice(&["mdpa", "gmsh", "use_input_model_part"]),
        "\"mdpa\"",
        "where the mesh comes from",
    ),
    Key::new("input_filename", Kind::Text, "\"\"", "mdpa file, with or without .mdpa, or msh file"),
];

/// Faults of cells that are shown; the rest is counted.
const SHOWN: usize = 20;

/// Where a mesh comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MeshSource {
    /// An mdpa file.
    File(PathBuf),
    /// A msh file of Gmsh.
    Gmsh(PathBuf),
    /// A modeler has made the part.
    Modeler,
}

impl MeshSource {
    /// From the object `settings[key]` with the keys [`MESH_IMPORT`]; `folder` is that of the project.
    ///
    /// # Errors
    /// No file is named.
    pub fn read(settings: &Settings, key: &str, folder: &Path) -> Result<Self, InputErrors> {
        let Some(nested) = settings.nested(key) else {
            return Ok(MeshSource::Modeler);
        };
        if nested.text("input_type") == "use_input_model_part" {
            return Ok(MeshSource::Modeler);
        }
        let name = nested.text("input_filename");
        if name.is_empty() {
            let message = "the key \"input_filename\" is missing";
            return Err(nested
                .parameters()
                .error(message)
                .help(
                    "name an mdpa file, or set input_type to \"use_input_model_part\" and let a modeler make the mesh",
                )
                .into());
        }
        let mut file = folder.join(name);
        if nested.text("input_type") == "gmsh" {
            return Ok(MeshSource::Gmsh(file));
        }
        if file.extension().is_none_or(|extension| extension != "mdpa") {
            file.as_mut_os_string().push(".mdpa");
        }
        Ok(MeshSource::File(file))
    }

    /// The file, if it is one.
    pub fn file(&self) -> Option<&Path> {
        match self {
            MeshSource::File(file) | MeshSource::Gmsh(file) => Some(file),
            MeshSource::Modeler => None,
        }
    }

    /// Where an element of the mesh stands.
    pub fn place(&self, id: u32) -> Place {
        match self {
            MeshSource::File(file) => mdpa::place_of(file, Category::Element, id),
            MeshSource::Gmsh(file) => Place::file(file),
            MeshSource::Modeler => Place::default(),
        }
    }

    /// Reads the root part `name` into the model unless a modeler has made it, and checks its cells
    /// for a space of this dimension; `settings[key]` is what named the source.
    ///
    /// # Errors
    /// Faults of the file and the mesh, all together; there is no such part.
    pub fn import(
        &self,
        model: &mut Model,
        name: &str,
        dimension: usize,
        registry: &Registry,
        (settings, key): (&Settings, &str),
    ) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        match self {
            MeshSource::File(file) => {
                if let Some(part) = errors.absorb(mdpa::read(file, name, registry)) {
                    model.insert(part);
                }
            }
            MeshSource::Gmsh(file) => {
                if let Some(part) = errors.absorb(gmsh::read(file, name, registry.element_prefix(name))) {
                    model.insert(part);
                }
            }
            MeshSource::Modeler if model.part(name).is_none() => {
                let message = format!("no modeler makes the model part {name:?}");
                let parts: Vec<&str> = model.parts().iter().map(|part| part.name.as_str()).collect();
                let diagnostic = settings.error(key, message);
                errors.push(diagnostic.help(format!("name an mdpa file; the modelers make: {}", parts.join(", "))));
            }
            MeshSource::Modeler => {}
        }
        if let Some(part) = model.part(name) {
            self.check(part, dimension, &mut errors);
        }
        errors.or(())
    }

    /// Refuses cells that are turned inside out, folded or flat.
    fn check(&self, part: &ModelPart, dimension: usize, errors: &mut InputErrors) {
        let faults = check_cells(part, &part.elements, dimension);
        for fault in faults.iter().take(SHOWN) {
            errors.push(Diagnostic::error(self.place(fault.id()), fault.to_string()));
        }
        if faults.len() > SHOWN {
            let message = format!("and {} more cells of {}", faults.len() - SHOWN, part.name);
            errors.push(Diagnostic::error(self.file().map_or_else(Place::default, Place::file), message));
        }
    }
}
