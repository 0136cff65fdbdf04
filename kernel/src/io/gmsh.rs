//! Reader of Gmsh's mesh files (`.msh`), formats 2.2 and 4.1, as text or binary, and writer of them.
//!
//! The format is described in the Gmsh reference manual, section "File formats". Cells of the highest
//! dimension become elements, those of lower dimension geometries; each physical group becomes a sub
//! model part with its nodes, elements and geometries, from which `CreateEntitiesFromGeometriesModeler`
//! makes conditions. Elementary entities, partitions and post-processing data are passed over.
//!
//! What Gmsh writes is made fit for use: nodes that no cell holds are left out, a cell that stands once
//! for each of its groups counts once, and plane cells that are numbered clockwise are turned over.

mod cells;
mod part;
mod source;
#[cfg(test)]
mod tests;
mod version2;
mod version4;
mod write;

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::model::ModelPart;
use cells::CellType;
pub(super) use part::geometry;
use source::{Form, Source};
use std::collections::BTreeMap;
use std::path::Path;
pub use write::{Version, losses, write};

/// What the file says, before ids become indices.
#[derive(Debug, Default)]
struct RawMesh {
    /// Names of physical groups by dimension and tag.
    names: BTreeMap<(usize, i32), String>,
    /// Id and coordinates (m).
    nodes: Vec<(u32, [f64; 3])>,
    cells: Vec<RawCell>,
}

/// A cell as it stands in the file.
#[derive(Debug, Clone, PartialEq)]
struct RawCell {
    id: u32,
    kind: CellType,
    /// Tags of its physical groups.
    groups: Vec<i32>,
    /// Ids of its nodes.
    nodes: Vec<u32>,
}

/// Reads a mesh file into a root model part called `part_name`. Elements are called
/// `{prefix}{dimension}D{nodes}N`.
///
/// # Errors
/// A file that cannot be read, another format or version, a truncated or contradictory file, and cells
/// of a kind that Bia does not have, with line (text) or byte (binary).
pub fn read(path: &Path, part_name: &str, prefix: &str) -> Result<ModelPart, InputErrors> {
    let bytes = std::fs::read(path).map_err(|error| {
        InputErrors::from(Diagnostic::error(Place::file(path), format!("the mesh file cannot be read: {error}")))
    })?;
    parse(&bytes, path, part_name, prefix)
}

/// Reads the bytes of a mesh file; `path` only serves messages.
///
/// # Errors
/// As [`read`].
pub fn parse(bytes: &[u8], path: &Path, part_name: &str, prefix: &str) -> Result<ModelPart, InputErrors> {
    let mut source = Source::new(bytes, path);
    let raw = raw_mesh(&mut source)?;
    part::model_part(raw, part_name, prefix, path)
}

fn raw_mesh(source: &mut Source) -> Result<RawMesh, InputErrors> {
    let mut raw = RawMesh::default();
    let Some(version) = format(source)? else {
        let message = "the file does not begin with $MeshFormat";
        return Err(source.fault(message).help("a Gmsh mesh file of format 2.2 or 4.1 is needed").into());
    };
    let mut groups = version4::EntityGroups::default();
    let (mut nodes, mut elements) = (false, false);
    while let Some(section) = source.section()? {
        match section.as_str() {
            "PhysicalNames" => raw.names = names(source)?,
            "Entities" if version == 4 => groups = version4::entities(source)?,
            "Nodes" if nodes => return Err(source.fault("the section $Nodes stands twice").into()),
            "Elements" if elements => return Err(source.fault("the section $Elements stands twice").into()),
            "Nodes" => {
                nodes = true;
                raw.nodes = if version == 4 { version4::nodes(source)? } else { version2::nodes(source)? };
            }
            "Elements" => {
                elements = true;
                raw.cells =
                    if version == 4 { version4::elements(source, &groups)? } else { version2::elements(source)? };
            }
            // Partitions, periodic links and data at nodes are of no use here.
            other => {
                source.skip_section(other)?;
                continue;
            }
        }
        source.end_of(&section)?;
    }
    for (found, name) in [(nodes, "$Nodes"), (elements, "$Elements")] {
        if !found {
            return Err(source.fault(format!("the file ends without the section {name}")).into());
        }
    }
    Ok(raw)
}

/// The version, 2 or 4, after `$MeshFormat`; none if the file begins with something else.
fn format(source: &mut Source) -> Result<Option<u32>, InputErrors> {
    match source.section() {
        Ok(Some(name)) if name == "MeshFormat" => {}
        _ => return Ok(None),
    }
    let line = source.line()?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let [version, kind, size] = words[..] else {
        return Err(source.fault(format!("{line:?} is no line of version, kind and size")).into());
    };
    let version = match version {
        "2" | "2.0" | "2.1" | "2.2" => 2,
        "4.1" => 4,
        other => {
            let message = format!("the format {other} of Gmsh is not read");
            let help = "save the mesh as 4.1 or 2.2 (Mesh.MshFileVersion in Gmsh)";
            return Err(source.fault(message).help(help).into());
        }
    };
    match (kind, size) {
        ("0", _) => source.set_form(Form::Text),
        ("1", "8") => source.set_binary()?,
        _ => {
            let message = format!("{kind:?} and {size:?} must be 0 for text or 1 for binary, and 8 bytes a number");
            return Err(source.fault(message).into());
        }
    }
    source.end_of("MeshFormat")?;
    Ok(Some(version))
}

/// The section of names is text in either form.
fn names(source: &mut Source) -> Result<BTreeMap<(usize, i32), String>, InputErrors> {
    let mut names = BTreeMap::new();
    let count = source.line()?;
    let Ok(count) = count.trim().parse::<usize>() else {
        return Err(source.fault(format!("{count:?} is no number of names")).into());
    };
    for _ in 0..count {
        let line = source.line()?;
        let mut words = line.trim().splitn(3, char::is_whitespace);
        let (dimension, tag, name) = (words.next(), words.next(), words.next());
        let numbers = dimension.and_then(|d| d.parse::<usize>().ok()).zip(tag.and_then(|t| t.parse::<i32>().ok()));
        let name = name.map(str::trim).and_then(|name| name.strip_prefix('"')?.strip_suffix('"'));
        let Some((key, name)) = numbers.filter(|(dimension, _)| *dimension <= 3).zip(name) else {
            return Err(source.fault(format!("{line:?} is not: dimension, tag, \"name\"")).into());
        };
        if name.is_empty() || name.contains('.') {
            let message = format!("a physical group is called {name:?}");
            return Err(source.fault(message).help("its name becomes that of a sub model part: no dots").into());
        }
        names.insert(key, name.to_string());
    }
    Ok(names)
}
