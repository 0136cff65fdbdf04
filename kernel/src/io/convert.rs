//! Meshes from one format to another: Gmsh's `.msh`, Kratos's `.mdpa`, VTK's `.vtu`.
//!
//! Everything goes through a [`ModelPart`]. What the target cannot hold is told in words, never dropped
//! silently; what it can hold comes back equal when it is read again.

#[cfg(test)]
mod tests;
mod vtu_mesh;

use super::dataset::Dataset;
use super::vtu::{VtuEncoding, VtuOptions, write_vtu};
use super::{gmsh, mdpa, vtu_read};
use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::geometry::Shape;
use crate::model::ModelPart;
use std::path::Path;

/// A format of meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Gmsh, `.msh`.
    Gmsh,
    /// Kratos, `.mdpa`.
    Mdpa,
    /// VTK, `.vtu`.
    Vtu,
}

impl Format {
    /// The format that the end of a file's name means.
    ///
    /// # Errors
    /// Another end, or none.
    pub fn of(path: &Path) -> Result<Self, InputErrors> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("msh") => Ok(Self::Gmsh),
            Some("mdpa") => Ok(Self::Mdpa),
            Some("vtu") => Ok(Self::Vtu),
            other => {
                let message = match other {
                    Some(other) => format!("there is no format of meshes {other:?}"),
                    None => "the name has no end that tells the format".into(),
                };
                let known = ["msh", "mdpa", "vtu"];
                Err(Diagnostic::error(Place::file(path), message).allowed(other.unwrap_or_default(), known).into())
            }
        }
    }
}

/// How meshes are read and written.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// How the names of elements begin where the file gives none; empty: `Element`.
    pub element_prefix: String,
    /// Version of Gmsh's format.
    pub msh: gmsh::Version,
    /// Write `.msh` files in binary form.
    pub msh_binary: bool,
    /// Write real numbers of `.vtu` files in single precision.
    pub single_precision: bool,
}

/// Reads a mesh; `kinds` knows the names of elements and conditions.
///
/// # Errors
/// All faults of the file.
pub fn read(path: &Path, kinds: &dyn mdpa::CellNames, options: &Options) -> Result<ModelPart, InputErrors> {
    let prefix = if options.element_prefix.is_empty() { "Element" } else { &options.element_prefix };
    match Format::of(path)? {
        Format::Gmsh => gmsh::read(path, "Mesh", prefix),
        Format::Mdpa => mdpa::read(path, "Mesh", kinds),
        Format::Vtu => vtu_mesh::model_part(vtu_read::read_vtu(path)?, prefix, kinds, path),
    }
}

/// What was written, and what the format could not hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// Size of the file in bytes.
    pub bytes: u64,
    /// Each thing that the file does not hold, in words.
    pub losses: Vec<String>,
}

/// Writes a mesh.
///
/// # Errors
/// The end of the name means no format, or the file cannot be written.
pub fn write(part: &ModelPart, path: &Path, options: &Options) -> Result<Written, InputErrors> {
    let (written, losses) = match Format::of(path)? {
        Format::Gmsh => (gmsh::write(part, path, options.msh, options.msh_binary), gmsh::losses(part)),
        Format::Mdpa => (mdpa::write(part, path), mdpa::losses(part)),
        Format::Vtu => {
            // Base64 is read by programs that take the file for XML, meshio among them.
            let form = VtuOptions {
                encoding: VtuEncoding::Base64Appended,
                compress: true,
                single_precision: options.single_precision,
            };
            (write_vtu(path, &dataset(part), None, &form), vtu_mesh::losses(part))
        }
    };
    let told = |error: std::io::Error| {
        InputErrors::from(Diagnostic::error(Place::file(path), format!("the mesh cannot be written: {error}")))
    };
    written.map(|bytes| Written { bytes, losses }).map_err(told)
}

/// A root model part as a data set: all cells, ids, and one field of zeros and ones for each kind of cells and
/// each sub model part (see `vtu_mesh`).
pub fn dataset(part: &ModelPart) -> Dataset {
    vtu_mesh::dataset(part)
}

/// The model part of a data set read from `path`, which only serves messages; cells of the highest dimension are its
/// elements, called by their shapes, and its nodes stand in the order of the points.
///
/// # Errors
/// Cells of a kind that Bia does not have; ids that do not ascend.
pub fn model_part(data: Dataset, path: &Path) -> Result<ModelPart, InputErrors> {
    let is_name = |name: &str| ["Element ", "Condition "].iter().any(|kind| name.starts_with(kind));
    let cell_fields = data.cell_fields.into_iter().filter(|field| !is_name(&field.name)).collect();
    vtu_mesh::model_part(Dataset { cell_fields, ..data }, "Element", &NoNames, path)
}

/// No registered names.
struct NoNames;

impl mdpa::CellNames for NoNames {
    fn shape(&self, _: mdpa::Category, _: &str) -> Option<Shape> {
        None
    }

    fn names(&self, _: mdpa::Category) -> Vec<String> {
        Vec::new()
    }
}
