//! Reader of Kratos's mesh files (`.mdpa`).
//!
//! The text is a sequence of words parted by blanks; `//` and `/* */` are comments. Words form
//! blocks `Begin NAME … End NAME`, and most blocks hold rows. Kratos lets a row go on over lines;
//! here **a row stands on one line**, because only then can a row with a node too few or too many
//! be told from its neighbours. Everything else is Kratos's grammar, read strictly: a number is
//! read whole or refused, and nothing that was not understood is passed over.
//!
//! Reading takes two passes. The first turns blocks into lists that still hold ids and lines; then
//! ids become indices, once all nodes and cells are known and sorted. So the order of
//! blocks is free (Kratos wants nodes and properties before their use).
//!
//! Contents of `ModelPartData` and `SubModelPartData` are checked and dropped, the legacy block
//! `Mesh` is passed over: nothing in Bia reads them.

mod blocks;
mod cells;
mod data;
mod faults;
mod parts;
mod resolve;
mod values;
mod words;
mod write;

#[cfg(test)]
mod tests;

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::geometry::Shape;
use crate::model::ModelPart;
use faults::Faults;
use std::path::Path;
pub use write::{losses, write};

/// The three kinds of cells of a model part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Category {
    /// Cells with a volume law: block `Elements`.
    Element,
    /// Loads, supports and interfaces: block `Conditions`.
    Condition,
    /// Cells without physics: block `Geometries`.
    Geometry,
}

/// The names that may stand after `Begin Elements`, `Begin Conditions` and `Begin Geometries`.
///
/// The names of geometries (`Triangle2D3`, …) are built in; more may be given here.
pub trait CellNames {
    /// Shape of the cells called `name`; none when the name is not registered.
    fn shape(&self, category: Category, name: &str) -> Option<Shape>;

    /// All registered names of a category, for messages.
    fn names(&self, category: Category) -> Vec<String>;
}

/// Reads a mesh file into a root model part called `part_name`.
///
/// # Errors
/// A file that cannot be opened (with the mesh files of its folder), bytes that are not UTF-8, and
/// everything that [`parse`] refuses.
pub fn read(path: &Path, part_name: &str, kinds: &dyn CellNames) -> Result<ModelPart, InputErrors> {
    let bytes = std::fs::read(path).map_err(|error| cannot_open(path, &error))?;
    let text = std::str::from_utf8(&bytes).map_err(|error| not_utf8(path, &bytes, error.valid_up_to()))?;
    parse(text, path, part_name, kinds)
}

/// Reads the text of a mesh file; `path` only serves messages.
///
/// Nodes and cells come out ascending by id, and so do the lists of sub model parts, which hold
/// what their children hold. A node that stands twice with the same coordinates counts once.
///
/// # Errors
/// Up to 20 faults of the file, in the order of their lines, and the number of further ones.
pub fn parse(text: &str, path: &Path, part_name: &str, kinds: &dyn CellNames) -> Result<ModelPart, InputErrors> {
    if u32::try_from(text.len()).is_err() {
        let message = "the file is larger than 4 GiB, which this reader does not hold";
        return Err(Diagnostic::error(Place::file(path), message).into());
    }
    // A byte order mark is no content.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut faults = Faults::new(path, text);
    let raw = blocks::Reader::new(text, kinds, &mut faults).read();
    let part = resolve::model_part(raw, part_name, &mut faults);
    faults.into_errors().or(part)
}

/// Where a cell stands in a mesh file; the file alone if it cannot be found there. For messages
/// about meshes that were read without fault: model parts do not keep lines.
pub fn place_of(path: &Path, category: Category, id: u32) -> Place {
    let block = match category {
        Category::Element => "Elements",
        Category::Condition => "Conditions",
        Category::Geometry => "Geometries",
    };
    let (text, id) = (std::fs::read_to_string(path).unwrap_or_default(), id.to_string());
    let mut inside = false;
    for (line, content) in text.lines().enumerate() {
        let mut words = content.split_whitespace();
        match words.next() {
            Some("Begin") => inside = words.next() == Some(block),
            Some("End") => inside = false,
            Some(word) if inside && word == id => return Place::line(path, line + 1),
            _ => {}
        }
    }
    Place::file(path)
}

fn cannot_open(path: &Path, error: &std::io::Error) -> InputErrors {
    let diagnostic = Diagnostic::error(Place::file(path), format!("the mesh file cannot be read: {error}"));
    let folder = match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => Path::new("."),
        Some(parent) => parent,
        None => return diagnostic.help("give the path of an .mdpa file").into(),
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return diagnostic.help(format!("the folder {} cannot be read either", folder.display())).into();
    };
    let mut names: Vec<String> = entries
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".mdpa") || name.ends_with(".mdpa.gz"))
        .collect();
    names.sort();
    if names.is_empty() {
        return diagnostic.help(format!("the folder {} holds no .mdpa file", folder.display())).into();
    }
    let found = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    diagnostic.allowed(&found, names.iter().map(String::as_str)).into()
}

fn not_utf8(path: &Path, bytes: &[u8], valid: usize) -> InputErrors {
    let before = &bytes[..valid];
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    let message = match bytes.get(valid) {
        Some(byte) => format!("the byte 0x{byte:02x} is not UTF-8"),
        None => "the file is not UTF-8".to_string(),
    };
    let help = "an mdpa file is UTF-8 text; save it again in that encoding (a compressed file must be unpacked first)";
    Diagnostic::error(Place::line(path, line), message).help(help).into()
}
