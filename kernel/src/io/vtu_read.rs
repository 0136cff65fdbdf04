//! Reader of VTK's XML files for unstructured grids (`.vtu`): what ParaView, VTK, meshio and Bia write.
//!
//! Format: VTK User's Guide, "VTK File Formats". Arrays may be text, base64 in place, or appended (raw or
//! base64), plain or compressed by zlib, with headers of 32 or 64 bits, of either byte order. The crate `vtkio`
//! was weighed: it reads these files too, but takes its sizes from the file without a bound and says of a
//! damaged file neither which array nor what is wrong with it, which input from outside needs.

mod arrays;
#[cfg(test)]
mod tests;
mod xml;

use super::dataset::{CellsOf, Dataset, Field, FieldData};
use crate::diagnostic::{Diagnostic, InputErrors, Place};
use arrays::{Coding, Numbers};
use std::path::Path;
use xml::{Scanner, Tag};

/// Reads a file of one piece.
///
/// # Errors
/// A file that cannot be read, of another kind, damaged, or with cells and fields that do not belong together.
pub fn read_vtu(path: &Path) -> Result<Dataset, InputErrors> {
    let bytes = std::fs::read(path).map_err(|error| {
        InputErrors::from(Diagnostic::error(Place::file(path), format!("the file cannot be read: {error}")))
    })?;
    parse_vtu(&bytes, path)
}

/// Reads the bytes of a file; `path` only serves messages.
///
/// # Errors
/// As [`read_vtu`].
pub fn parse_vtu(bytes: &[u8], path: &Path) -> Result<Dataset, InputErrors> {
    let told = |message: String| InputErrors::from(Diagnostic::error(Place::file(path), message));
    let document = Document::scan(bytes).map_err(told)?;
    let data = document.dataset().map_err(told)?;
    data.check().map_err(|error| told(error.to_string()))?;
    if let Some(place) = data.points.iter().position(|x| x.iter().any(|x| !x.is_finite())) {
        return Err(told(format!("the point {place} has a coordinate that is no number")));
    }
    Ok(data)
}

/// A section of the file that holds arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    PointData,
    CellData,
    Points,
    Cells,
}

/// An array as its tag describes it.
struct Array<'a> {
    section: Section,
    name: String,
    kind: String,
    components: usize,
    format: String,
    /// Where it begins in the appended data.
    offset: usize,
    /// What stands between its tags.
    text: &'a [u8],
}

struct Document<'a> {
    coding: Coding,
    points: usize,
    cells: usize,
    arrays: Vec<Array<'a>>,
    /// The appended data, and whether they are base64.
    appended: &'a [u8],
    base64: bool,
}

/// The number in an attribute.
fn number(tag: &Tag, name: &str) -> Result<usize, String> {
    let text = tag.get(name).ok_or_else(|| format!("<{}> has no {name}", tag.name))?;
    text.trim().parse().map_err(|_| format!("{name}={text:?} of <{}> is no count", tag.name))
}

impl<'a> Document<'a> {
    fn scan(bytes: &'a [u8]) -> Result<Self, String> {
        let mut scanner = Scanner::new(bytes);
        let (mut coding, mut piece, mut section) = (None, None, None);
        let (mut arrays, mut appended, mut base64) = (Vec::new(), &[][..], false);
        while let Some(tag) = scanner.tag()? {
            match tag.name.as_str() {
                "VTKFile" => coding = Some(Coding::read(&tag)?),
                _ if coding.is_none() => return Err(format!("begins with <{}>, not with <VTKFile>", tag.name)),
                "Piece" if piece.is_some() => return Err("holds more than one piece; only one is read".into()),
                "Piece" => piece = Some((number(&tag, "NumberOfPoints")?, number(&tag, "NumberOfCells")?)),
                "PointData" => section = Some(Section::PointData),
                "CellData" => section = Some(Section::CellData),
                "Points" => section = Some(Section::Points),
                "Cells" => section = Some(Section::Cells),
                "/PointData" | "/CellData" | "/Points" | "/Cells" => section = None,
                "DataArray" => {
                    if let Some(section) = section {
                        let text = if tag.is_empty { &[][..] } else { scanner.text() };
                        arrays.push(Array::read(&tag, section, text)?);
                    }
                }
                "AppendedData" => {
                    base64 = tag.get("encoding") == Some("base64");
                    appended = scanner.appended()?;
                    break;
                }
                _ => {}
            }
        }
        let coding = coding.ok_or("is no VTK file: it holds no <VTKFile>")?;
        let (points, cells) = piece.ok_or("holds no <Piece>")?;
        Ok(Self { coding, points, cells, arrays, appended, base64 })
    }

    fn dataset(&self) -> Result<Dataset, String> {
        let one = |section: Section, name: &str| {
            let mut found = self.arrays.iter().filter(|a| a.section == section && (name.is_empty() || a.name == name));
            found.next().ok_or_else(|| format!("holds no array {name:?} in <{section:?}>"))
        };
        let places = one(Section::Points, "")?;
        if places.components != 3 {
            return Err(format!("the points have {} coordinates, must have 3", places.components));
        }
        let flat = self.numbers(places, Some(self.points))?.into_reals();
        let points = flat.chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect();
        let indices = |name: &str, count: Option<usize>| -> Result<Vec<u32>, String> {
            let numbers = self.numbers(one(Section::Cells, name)?, count)?.into_integers();
            let numbers = numbers.ok_or_else(|| format!("{name:?} holds numbers that are not whole"))?;
            let index = |n: i64| u32::try_from(n).map_err(|_| format!("{name:?} holds {n}, which is no index"));
            numbers.into_iter().map(index).collect()
        };
        let nodes = indices("connectivity", None)?;
        let starts = std::iter::once(0).chain(indices("offsets", Some(self.cells))?).collect();
        let types = indices("types", Some(self.cells))?;
        let types = types.into_iter().map(|t| u8::try_from(t).map_err(|_| format!("{t} is no type of cells")));
        let types = types.collect::<Result<_, _>>()?;
        let fields = |section: Section, count: usize| {
            self.arrays.iter().filter(|a| a.section == section).map(|a| self.field(a, count)).collect::<Result<_, _>>()
        };
        Ok(Dataset {
            points,
            cells: CellsOf::Mesh { starts, nodes, types },
            point_fields: fields(Section::PointData, self.points)?,
            cell_fields: fields(Section::CellData, self.cells)?,
        })
    }

    fn field(&self, array: &Array, count: usize) -> Result<Field, String> {
        let numbers = self.numbers(array, Some(count))?;
        let values = match numbers {
            Numbers::Integer(values) if values.iter().all(|&value| i32::try_from(value).is_ok()) => {
                FieldData::I32(values.into_iter().map(|value| value as i32).collect())
            }
            numbers => FieldData::F64(numbers.into_reals()),
        };
        Ok(Field { name: array.name.clone(), components: array.components, values })
    }

    /// The numbers of an array, which must be as many as its components for each of `count`.
    fn numbers(&self, array: &Array, count: Option<usize>) -> Result<Numbers, String> {
        let told = |message: String| format!("the array {:?}: {message}", array.name);
        let needed = count.map(|count| count.saturating_mul(array.components));
        let numbers = match array.format.as_str() {
            "ascii" => self.coding.of_text(array.text, &array.kind),
            "binary" => arrays::base64(array.text).and_then(|bytes| self.coding.of_bytes(&bytes, &array.kind, needed)),
            "appended" => self.chunk(array).and_then(|chunk| match self.base64 {
                true => self.coding.of_bytes(&arrays::base64(chunk)?, &array.kind, needed),
                false => self.coding.of_bytes(chunk, &array.kind, needed),
            }),
            other => Err(format!("the format {other:?} is not known")),
        };
        let numbers = numbers.map_err(told)?;
        match needed {
            Some(needed) if numbers.len() != needed => {
                Err(told(format!("{} numbers are there, {needed} are needed", numbers.len())))
            }
            _ => Ok(numbers),
        }
    }

    /// The appended data from the array's beginning to that of the next one.
    fn chunk(&self, array: &Array) -> Result<&'a [u8], String> {
        let later = self.arrays.iter().filter(|other| other.format == "appended" && other.offset > array.offset);
        let end = later.map(|other| other.offset).min().unwrap_or(self.appended.len());
        self.appended.get(array.offset..end).ok_or_else(|| "lies beyond the end of the file".to_string())
    }
}

impl<'a> Array<'a> {
    fn read(tag: &Tag, section: Section, text: &'a [u8]) -> Result<Self, String> {
        let get = |name: &str| tag.get(name).unwrap_or_default().to_string();
        let format = get("format");
        Ok(Self {
            section,
            name: get("Name"),
            kind: get("type"),
            components: if tag.get("NumberOfComponents").is_some() { number(tag, "NumberOfComponents")? } else { 1 },
            offset: if format == "appended" { number(tag, "offset")? } else { 0 },
            format,
            text,
        })
    }
}
