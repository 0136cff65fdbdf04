//! VTK's XML files for unstructured grids (`.vtu`): ParaView's native form, compressed and exact in double precision.
//!
//! Format: VTK User's Guide, "VTK File Formats", XML formats, version 1.0 with 64-bit headers. Arrays follow the
//! XML text as one block of appended data. An array is `[bytes]` and its bytes, or, compressed, `[blocks][size of
//! a block][size of the last one, 0 if whole][compressed size of each]` and the zlib streams. In base64 the
//! uncompressed header and data are encoded as one, the compressed ones one after the other.

use super::base64::write_base64;
use super::dataset::{CellsOf, Dataset, Field, FieldData, VTK_VERTEX};
use super::files::write_atomically;
use super::number::{push_integer, push_shortest};
use bytemuck::Pod;
use flate2::{Compress, Compression, FlushCompress, Status};
use rayon::prelude::*;
use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

/// How the arrays of a `.vtu` file are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VtuEncoding {
    /// Binary after the XML text: smallest and fastest. Not well-formed XML; VTK and ParaView read it.
    #[default]
    RawAppended,
    /// The same in base64: a third larger, well-formed XML, readable by meshio and other XML readers.
    Base64Appended,
    /// Text that people can read, exact, never compressed.
    Ascii,
}

/// Options of [`write_vtu`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VtuOptions {
    /// How the arrays are stored.
    pub encoding: VtuEncoding,
    /// Compress with zlib at its fastest level (not for text).
    pub compress: bool,
    /// Write real numbers and coordinates as `f32`: half the size, 7 digits.
    pub single_precision: bool,
}

impl Default for VtuOptions {
    fn default() -> Self {
        Self { encoding: VtuEncoding::default(), compress: true, single_precision: false }
    }
}

/// Writes `data` to `path` as a `.vtu` file, with the `time` in seconds if given, and returns its size in bytes.
///
/// Compression runs in blocks on all threads; the file does not depend on their number.
///
/// # Errors
/// `InvalidInput` with a [`DatasetError`](super::dataset::DatasetError) when the lists of `data` do not
/// belong together; otherwise those of the file system. No part of a file is left.
pub fn write_vtu(path: &Path, data: &Dataset, time: Option<f64>, options: &VtuOptions) -> io::Result<u64> {
    data.check()?;
    let mut document = Document { options: *options, xml: Vec::new(), appended: Vec::new(), offset: 0 };
    document.grid(data, time)?;
    write_atomically(path, |out| document.write_to(out))
}

/// Bytes of one compressed block: small enough for all threads, large enough for zlib's window of 32 KiB.
const BLOCK: usize = 1 << 16;

/// A number type of the format.
trait Number: Pod + Sync {
    const VTK_NAME: &'static str;
    fn push_text(self, text: &mut Vec<u8>);
}

macro_rules! numbers {
    ($($kind:ty, $name:literal, $push:expr;)*) => {
        $(impl Number for $kind {
            const VTK_NAME: &'static str = $name;
            fn push_text(self, text: &mut Vec<u8>) {
                $push(text, self.into());
            }
        })*
    };
}

numbers! {
    f64, "Float64", push_shortest::<f64>;
    f32, "Float32", push_shortest::<f32>;
    i32, "Int32", push_integer;
    u8, "UInt8", push_integer;
}

/// An array as it stands in the appended data.
struct Encoded<'a> {
    header: Vec<u8>,
    body: Vec<Cow<'a, [u8]>>,
}

struct Document<'a> {
    options: VtuOptions,
    /// The text up to the appended data.
    xml: Vec<u8>,
    appended: Vec<Encoded<'a>>,
    /// Length of `appended` in the file.
    offset: u64,
}

impl<'a> Document<'a> {
    fn grid(&mut self, data: &'a Dataset, time: Option<f64>) -> io::Result<()> {
        let order = if cfg!(target_endian = "big") { "BigEndian" } else { "LittleEndian" };
        let compressor = if self.compressed() { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
        writeln!(self.xml, "<?xml version=\"1.0\"?>")?;
        writeln!(
            self.xml,
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" \
             header_type=\"UInt64\"{compressor}>"
        )?;
        writeln!(self.xml, "<UnstructuredGrid>")?;
        if let Some(time) = time {
            write!(self.xml, "<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\"")?;
            writeln!(self.xml, " format=\"ascii\">{time:?}</DataArray>\n</FieldData>")?;
        }
        let (points, cells) = (data.points.len(), data.cell_count());
        writeln!(self.xml, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">")?;
        self.fields("PointData", &data.point_fields)?;
        self.fields("CellData", &data.cell_fields)?;
        writeln!(self.xml, "<Points>")?;
        self.reals("Points", 3, data.points.as_flattened())?;
        writeln!(self.xml, "</Points>\n<Cells>")?;
        self.cells(data)?;
        writeln!(self.xml, "</Cells>\n</Piece>\n</UnstructuredGrid>")
    }

    fn fields(&mut self, section: &str, fields: &'a [Field]) -> io::Result<()> {
        writeln!(self.xml, "<{section}>")?;
        for Field { name, components, values } in fields {
            match values {
                FieldData::F64(values) => self.reals(name, *components, values)?,
                FieldData::I32(values) => self.array(name, *components, Cow::Borrowed(values.as_slice()))?,
            }
        }
        writeln!(self.xml, "</{section}>")
    }

    fn cells(&mut self, data: &'a Dataset) -> io::Result<()> {
        // `Dataset::check` has made sure that the indices fit into i32, which VTK stores as they are.
        let (nodes, ends, types): (Vec<i32>, Vec<i32>, Cow<[u8]>) = match &data.cells {
            CellsOf::Vertices => {
                let count = data.points.len() as i32;
                ((0..count).collect(), (1..=count).collect(), vec![VTK_VERTEX; data.points.len()].into())
            }
            CellsOf::Mesh { starts, nodes, types } => (
                nodes.iter().map(|&node| node as i32).collect(),
                starts.iter().skip(1).map(|&end| end as i32).collect(),
                types.into(),
            ),
        };
        self.array("connectivity", 1, Cow::Owned(nodes))?;
        self.array("offsets", 1, Cow::Owned(ends))?;
        self.array("types", 1, types)
    }

    fn reals(&mut self, name: &str, components: usize, values: &'a [f64]) -> io::Result<()> {
        if self.options.single_precision {
            let single: Vec<f32> = values.iter().map(|&value| value as f32).collect();
            self.array(name, components, Cow::Owned(single))
        } else {
            self.array(name, components, Cow::Borrowed(values))
        }
    }

    fn array<T: Number>(&mut self, name: &str, components: usize, values: Cow<'a, [T]>) -> io::Result<()> {
        let (kind, name) = (T::VTK_NAME, escaped(name));
        write!(self.xml, "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"")?;
        if self.options.encoding == VtuEncoding::Ascii {
            writeln!(self.xml, " format=\"ascii\">")?;
            push_rows(&mut self.xml, &values, components);
            return writeln!(self.xml, "</DataArray>");
        }
        writeln!(self.xml, " format=\"appended\" offset=\"{}\"/>", self.offset)?;
        let encoded = self.encode(values)?;
        self.offset += self.length(&encoded);
        self.appended.push(encoded);
        Ok(())
    }

    fn compressed(&self) -> bool {
        self.options.compress && self.options.encoding != VtuEncoding::Ascii
    }

    fn encode<T: Number>(&self, values: Cow<'a, [T]>) -> io::Result<Encoded<'a>> {
        if self.compressed() {
            return compress(bytemuck::cast_slice(&values));
        }
        let bytes: Cow<'a, [u8]> = match values {
            Cow::Borrowed(values) => Cow::Borrowed(bytemuck::cast_slice(values)),
            Cow::Owned(values) => Cow::Owned(bytemuck::cast_slice(&values).to_vec()),
        };
        Ok(Encoded { header: (bytes.len() as u64).to_ne_bytes().to_vec(), body: vec![bytes] })
    }

    /// Bytes that `encoded` takes in the file.
    fn length(&self, encoded: &Encoded) -> u64 {
        let (header, body) = (encoded.header.len() as u64, encoded.body.iter().map(|part| part.len() as u64).sum());
        let base64 = |bytes: u64| bytes.div_ceil(3) * 4;
        match (self.options.encoding, self.compressed()) {
            (VtuEncoding::Base64Appended, true) => base64(header) + base64(body),
            (VtuEncoding::Base64Appended, false) => base64(header + body),
            _ => header + body,
        }
    }

    fn write_to(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&self.xml)?;
        if self.options.encoding != VtuEncoding::Ascii {
            let base64 = self.options.encoding == VtuEncoding::Base64Appended;
            let name = if base64 { "base64" } else { "raw" };
            write!(out, "<AppendedData encoding=\"{name}\">\n_")?;
            for Encoded { header, body } in &self.appended {
                let parts = body.iter().map(|part| part.as_ref());
                match (base64, self.compressed()) {
                    (false, _) => std::iter::once(header.as_slice()).chain(parts).try_for_each(|p| out.write_all(p))?,
                    (true, true) => {
                        write_base64(out, std::iter::once(header.as_slice()))?;
                        write_base64(out, parts)?;
                    }
                    (true, false) => write_base64(out, std::iter::once(header.as_slice()).chain(parts))?,
                }
            }
            writeln!(out, "\n</AppendedData>")?;
        }
        writeln!(out, "</VTKFile>")
    }
}

/// The header and the zlib streams of an array.
fn compress(bytes: &[u8]) -> io::Result<Encoded<'static>> {
    let blocks: Vec<Vec<u8>> = bytes
        .par_chunks(BLOCK)
        .map_init(|| Compress::new(Compression::fast(), true), compress_block)
        .collect::<io::Result<_>>()?;
    let sizes = [blocks.len(), BLOCK, bytes.len() % BLOCK].into_iter().chain(blocks.iter().map(Vec::len));
    let header = sizes.flat_map(|size| (size as u64).to_ne_bytes()).collect();
    Ok(Encoded { header, body: blocks.into_iter().map(Cow::Owned).collect() })
}

fn compress_block(zlib: &mut Compress, block: &[u8]) -> io::Result<Vec<u8>> {
    zlib.reset();
    // zlib's bound: data that cannot be compressed grow by 5 bytes per 16 KiB and a few more.
    let mut stream = Vec::with_capacity(block.len() + block.len() / 1000 + 64);
    match zlib.compress_vec(block, &mut stream, FlushCompress::Finish)? {
        Status::StreamEnd => {
            stream.shrink_to_fit();
            Ok(stream)
        }
        status => Err(io::Error::other(format!("zlib stopped with {status:?}"))),
    }
}

fn push_rows<T: Number>(text: &mut Vec<u8>, values: &[T], components: usize) {
    for row in values.chunks(components) {
        for (i, &value) in row.iter().enumerate() {
            if i > 0 {
                text.push(b' ');
            }
            value.push_text(text);
        }
        text.push(b'\n');
    }
}

/// Text for an XML attribute in double quotes.
pub(super) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            other => safe.push(other),
        }
    }
    safe
}

#[cfg(test)]
#[path = "vtu_tests.rs"]
mod tests;
