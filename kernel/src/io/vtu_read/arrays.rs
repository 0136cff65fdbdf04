//! From the bytes or text of an array to its numbers.

use super::xml::Tag;
use crate::io::base64::read_base64;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// Values of an array.
#[derive(Debug)]
pub(super) enum Numbers {
    Real(Vec<f64>),
    Integer(Vec<i64>),
}

impl Numbers {
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Integer(values) => values.len(),
        }
    }

    pub fn into_reals(self) -> Vec<f64> {
        match self {
            Self::Real(values) => values,
            Self::Integer(values) => values.into_iter().map(|value| value as f64).collect(),
        }
    }

    pub fn into_integers(self) -> Option<Vec<i64>> {
        match self {
            Self::Real(_) => None,
            Self::Integer(values) => Some(values),
        }
    }
}

/// How the file writes binary data.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coding {
    big_endian: bool,
    /// Bytes of a number in the headers.
    header: usize,
    compressed: bool,
}

impl Coding {
    /// From the tag `VTKFile`.
    pub fn read(tag: &Tag) -> Result<Self, String> {
        match tag.get("type") {
            Some("UnstructuredGrid") => {}
            other => return Err(format!("holds {}, not an unstructured grid", other.unwrap_or("nothing"))),
        }
        let compressed = match tag.get("compressor") {
            None => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => return Err(format!("is compressed by {other}; save it with zlib, or not compressed")),
        };
        let header = if tag.get("header_type") == Some("UInt64") { 8 } else { 4 };
        Ok(Self { big_endian: tag.get("byte_order") == Some("BigEndian"), header, compressed })
    }

    /// Numbers written as text.
    pub fn of_text(self, text: &[u8], kind: &str) -> Result<Numbers, String> {
        let text = std::str::from_utf8(text).map_err(|_| "is not UTF-8".to_string())?;
        let words = text.split_ascii_whitespace();
        if kind.starts_with("Float") {
            let real = |word: &str| word.parse().map_err(|_| format!("{word:?} is no number"));
            return words.map(real).collect::<Result<_, _>>().map(Numbers::Real);
        }
        width(kind)?;
        let integer = |word: &str| word.parse().map_err(|_| format!("{word:?} is no whole number"));
        words.map(integer).collect::<Result<_, _>>().map(Numbers::Integer)
    }

    /// Numbers of a header with data, of which `needed` are expected.
    pub fn of_bytes(self, bytes: &[u8], kind: &str, needed: Option<usize>) -> Result<Numbers, String> {
        let limit = needed.map(|needed| needed.saturating_mul(width(kind).unwrap_or(8)));
        let data = if self.compressed { self.inflate(bytes, limit)? } else { self.plain(bytes)?.to_vec() };
        self.decode(&data, kind)
    }

    fn word(self, bytes: &[u8], index: usize) -> Result<usize, String> {
        let begin = index.saturating_mul(self.header);
        let word = bytes.get(begin..begin.saturating_add(self.header)).ok_or("is cut off in its header")?;
        let digit = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        let value = if self.big_endian { word.iter().fold(0, digit) } else { word.iter().rev().fold(0, digit) };
        usize::try_from(value).map_err(|_| "announces more than memory can hold".to_string())
    }

    fn plain(self, bytes: &[u8]) -> Result<&[u8], String> {
        let size = self.word(bytes, 0)?;
        let data = &bytes[self.header..];
        data.get(..size).ok_or_else(|| format!("announces {size} bytes, and {} follow", data.len()))
    }

    /// Blocks of zlib streams; more than `limit` bytes are a fault.
    fn inflate(self, bytes: &[u8], limit: Option<usize>) -> Result<Vec<u8>, String> {
        let (blocks, size, last) = (self.word(bytes, 0)?, self.word(bytes, 1)?, self.word(bytes, 2)?);
        let mut begin = blocks.saturating_add(3).saturating_mul(self.header);
        if begin > bytes.len() {
            return Err("is cut off in its header".into());
        }
        let mut data = Vec::new();
        for block in 0..blocks {
            let packed = self.word(bytes, 3 + block)?;
            let end = begin.saturating_add(packed);
            let stream = bytes.get(begin..end).ok_or("is cut off")?;
            let expected = if block + 1 == blocks && last > 0 { last } else { size };
            let before = data.len();
            let most = (expected as u64).saturating_add(1);
            ZlibDecoder::new(stream)
                .take(most)
                .read_to_end(&mut data)
                .map_err(|error| format!("block {block} cannot be decompressed: {error}"))?;
            if data.len() - before != expected {
                return Err(format!("block {block} has {} bytes, {expected} are announced", data.len() - before));
            }
            if limit.is_some_and(|limit| data.len() > limit) {
                return Err("holds more numbers than there are places for them".into());
            }
            begin = end;
        }
        Ok(data)
    }

    fn decode(self, data: &[u8], kind: &str) -> Result<Numbers, String> {
        let width = width(kind)?;
        if !data.len().is_multiple_of(width) {
            return Err(format!("{} bytes are no whole number of {kind}", data.len()));
        }
        let rows = data.chunks_exact(width).map(|chunk| {
            let mut bytes = [0; 8];
            bytes[..width].copy_from_slice(chunk);
            if self.big_endian {
                bytes[..width].reverse();
            }
            u64::from_le_bytes(bytes)
        });
        Ok(match kind {
            "Float64" => Numbers::Real(rows.map(f64::from_bits).collect()),
            "Float32" => Numbers::Real(rows.map(|bits| f64::from(f32::from_bits(bits as u32))).collect()),
            "Int8" => Numbers::Integer(rows.map(|bits| i64::from(bits as i8)).collect()),
            "Int16" => Numbers::Integer(rows.map(|bits| i64::from(bits as i16)).collect()),
            "Int32" => Numbers::Integer(rows.map(|bits| i64::from(bits as i32)).collect()),
            _ => {
                let whole = |bits: u64| i64::try_from(bits).map_err(|_| format!("{bits} is too large"));
                match kind {
                    "Int64" => Numbers::Integer(rows.map(|bits| bits as i64).collect()),
                    _ => Numbers::Integer(rows.map(whole).collect::<Result<_, _>>()?),
                }
            }
        })
    }
}

/// Bytes of a number of this type.
fn width(kind: &str) -> Result<usize, String> {
    match kind {
        "Int8" | "UInt8" => Ok(1),
        "Int16" | "UInt16" => Ok(2),
        "Int32" | "UInt32" | "Float32" => Ok(4),
        "Int64" | "UInt64" | "Float64" => Ok(8),
        other => Err(format!("the type {other:?} is not read")),
    }
}

/// Bytes of a text in base64.
pub(super) fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    read_base64(text).ok_or_else(|| "is no base64".to_string())
}
