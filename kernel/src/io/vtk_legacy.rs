//! Legacy VTK files in the exact form that Kratos Multiphysics writes, so that scripts made for its output work.
//!
//! Format: VTK User's Guide, "VTK File Formats", version 4.0 of the file, `UNSTRUCTURED_GRID` with fields as
//! `FIELD FieldData`. Real numbers are `float`, integers `int`; binary files are big-endian. Sections follow
//! each other as in Kratos's files: `CELLS` only where there are cells, no `POINT_DATA` for vertices without
//! point fields, a blank after each entry of a row of several numbers but none after a single one.

use super::dataset::{CellsOf, Dataset, Field, FieldData, VTK_VERTEX};
use super::files::write_atomically;
use super::number::{push_float, push_integer};
use std::io::{self, Write};
use std::path::Path;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Text with `precision` digits after the point (Kratos: 7).
    Ascii {
        /// Digits after the point.
        precision: usize,
    },
    /// Big-endian binary: about a third of the size and ten times faster.
    Binary,
}

/// Writes `data` to `path` as a legacy VTK file and returns its size in bytes.
///
/// Real numbers lose precision: they are `f32` in binary files and are read as such from text files.
///
/// # Errors
/// `InvalidInput` with a [`DatasetError`](super::dataset::DatasetError) when the lists of `data` do not
/// belong together; otherwise those of the file system. No part of a file is left.
pub fn write_legacy(path: &Path, data: &Dataset, encoding: Encoding) -> io::Result<u64> {
    data.check()?;
    write_atomically(path, |out| {
        let mut file = LegacyFile { out, text: Vec::with_capacity(2 * PORTION), encoding };
        file.header()?;
        file.geometry(data)?;
        file.fields_of(data)?;
        file.finish()
    })
}

/// Bytes formatted before they are handed on.
const PORTION: usize = 1 << 16;

struct LegacyFile<'a> {
    out: &'a mut dyn Write,
    text: Vec<u8>,
    encoding: Encoding,
}

impl LegacyFile<'_> {
    fn header(&mut self) -> io::Result<()> {
        let kind = if self.encoding == Encoding::Binary { "BINARY" } else { "ASCII" };
        self.line(format_args!("# vtk DataFile Version 4.0\nvtk output\n{kind}\nDATASET UNSTRUCTURED_GRID\n"))
    }

    fn geometry(&mut self, data: &Dataset) -> io::Result<()> {
        self.line(format_args!("POINTS {} float\n", data.points.len()))?;
        self.floats(data.points.as_flattened(), 3)?;
        let cells = data.cell_count();
        if cells == 0 {
            return Ok(());
        }
        match &data.cells {
            CellsOf::Vertices => {
                self.line(format_args!("\nCELLS {cells} {}\n", 2 * cells))?;
                (0..cells).try_for_each(|point| self.cell(&[point as u32]))?;
                self.line(format_args!("\nCELL_TYPES {cells}\n"))?;
                (0..cells).try_for_each(|_| self.integer_row(&[i32::from(VTK_VERTEX)]))
            }
            CellsOf::Mesh { starts, nodes, types } => {
                self.line(format_args!("\nCELLS {cells} {}\n", cells + nodes.len()))?;
                starts.windows(2).try_for_each(|s| self.cell(&nodes[s[0] as usize..s[1] as usize]))?;
                self.line(format_args!("\nCELL_TYPES {cells}\n"))?;
                types.iter().try_for_each(|&kind| self.integer_row(&[i32::from(kind)]))
            }
        }
    }

    fn fields_of(&mut self, data: &Dataset) -> io::Result<()> {
        if data.cells != CellsOf::Vertices || !data.point_fields.is_empty() {
            self.fields("POINT_DATA", data.points.len(), &data.point_fields)?;
        }
        if data.cell_count() > 0 {
            self.fields("CELL_DATA", data.cell_count(), &data.cell_fields)?;
        }
        Ok(())
    }

    fn fields(&mut self, section: &str, entities: usize, fields: &[Field]) -> io::Result<()> {
        self.line(format_args!("{section} {entities}\nFIELD FieldData {}\n", fields.len()))?;
        for Field { name, components, values } in fields {
            let kind = if matches!(values, FieldData::F64(_)) { "float" } else { "int" };
            self.line(format_args!("{} {components} {entities}  {kind}\n", one_word(name)))?;
            match values {
                FieldData::F64(values) => self.floats(values, *components)?,
                FieldData::I32(values) => values.chunks(*components).try_for_each(|row| self.integer_row(row))?,
            }
        }
        Ok(())
    }

    /// Rows of `components` real numbers.
    fn floats(&mut self, values: &[f64], components: usize) -> io::Result<()> {
        match self.encoding {
            Encoding::Binary => values.chunks(PORTION / 4).try_for_each(|portion| {
                self.text.extend(portion.iter().flat_map(|&value| (value as f32).to_be_bytes()));
                self.pass_on()
            }),
            Encoding::Ascii { precision } => values.chunks(components).try_for_each(|row| {
                for &value in row {
                    push_float(&mut self.text, value, precision);
                    self.text.push(b' ');
                }
                self.end_row(components)
            }),
        }
    }

    /// A row of integers.
    fn integer_row(&mut self, row: &[i32]) -> io::Result<()> {
        if self.encoding == Encoding::Binary {
            self.text.extend(row.iter().flat_map(|value| value.to_be_bytes()));
            return self.pass_on();
        }
        for &value in row {
            push_integer(&mut self.text, value.into());
            self.text.push(b' ');
        }
        self.end_row(row.len())
    }

    /// The number of a cell's nodes and their indices; no blank at the end.
    fn cell(&mut self, nodes: &[u32]) -> io::Result<()> {
        let numbers = std::iter::once(nodes.len() as u32).chain(nodes.iter().copied());
        if self.encoding == Encoding::Binary {
            self.text.extend(numbers.flat_map(u32::to_be_bytes));
            return self.pass_on();
        }
        for number in numbers {
            push_integer(&mut self.text, number.into());
            self.text.push(b' ');
        }
        self.end_row(1)
    }

    /// Ends a text row whose last byte is a blank, which stays in rows of several numbers.
    fn end_row(&mut self, components: usize) -> io::Result<()> {
        if components == 1 {
            self.text.pop();
        }
        self.text.push(b'\n');
        self.pass_on()
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) -> io::Result<()> {
        self.text.write_fmt(line)
    }

    fn pass_on(&mut self) -> io::Result<()> {
        if self.text.len() >= PORTION { self.finish() } else { Ok(()) }
    }

    fn finish(&mut self) -> io::Result<()> {
        self.out.write_all(&self.text)?;
        self.text.clear();
        Ok(())
    }
}

/// A name as one printable word: other bytes, `"` and `%` as `%XX`, which VTK's readers turn back.
fn one_word(name: &str) -> String {
    let mut word = String::with_capacity(name.len());
    for byte in name.bytes() {
        match byte {
            b'"' | b'%' => word.push_str(&format!("%{byte:02X}")),
            b'!'..=b'~' => word.push(char::from(byte)),
            _ => word.push_str(&format!("%{byte:02X}")),
        }
    }
    word
}

#[cfg(test)]
#[path = "vtk_legacy_tests.rs"]
mod tests;
