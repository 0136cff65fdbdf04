//! The file of a checkpoint.

use super::{Archive, CheckpointError, Contents, Entry, Mode, size_of_type};
use crate::io::files::write_atomically;
use serde_json::{Map, Value, json};
use std::io::{self, Write};
use std::path::Path;

const MAGIC: &[u8; 8] = b"BIACHKPT";
/// Version of the format: one more whenever older programs would misread the file.
pub const FORMAT: u64 = 3;
const BYTE_ORDER: &str = if cfg!(target_endian = "little") { "<" } else { ">" };
/// Columns begin at whole multiples of this many bytes from the start of the file.
const ALIGNMENT: usize = 8;

/// Writes a checkpoint, whole or not at all; `exchange` shows the state twice, for the header and for
/// the columns. Returns the number of bytes.
///
/// # Errors
/// Those of `exchange` and of the file system.
pub fn write(
    path: &Path,
    head: Map<String, Value>,
    exchange: &mut dyn FnMut(&mut Archive) -> Result<(), CheckpointError>,
) -> Result<u64, CheckpointError> {
    let (columns, values) = list(exchange)?;
    write_file(path, &header(head, values, columns), &mut |out| exchange(&mut Archive::writing(out)))
}

/// Writes what was kept in memory, as [`write`] does.
///
/// # Errors
/// Those of the file system.
pub fn write_kept(path: &Path, head: Map<String, Value>, kept: &Contents) -> Result<u64, CheckpointError> {
    let mut columns: Vec<(&String, &(Entry, usize))> = kept.columns.iter().collect();
    columns.sort_by_key(|(name, (_, offset))| (*offset, *name));
    let names: Vec<&String> = columns.iter().map(|(name, _)| *name).collect();
    let listed = columns.into_iter().map(|(name, (entry, _))| (name.clone(), entry.clone())).collect();
    write_file(path, &header(head, kept.values.clone(), listed), &mut |out| {
        names.iter().try_for_each(|name| {
            let (_, bytes) = kept.column(name)?;
            out.write_all(bytes).map_err(|source| CheckpointError::File { path: name.into(), source })
        })
    })
}

/// Writes the header and what `write_columns` writes, with their sum.
fn write_file(
    path: &Path,
    header: &[u8],
    write_columns: &mut dyn FnMut(&mut dyn Write) -> Result<(), CheckpointError>,
) -> Result<u64, CheckpointError> {
    let mut refused = None;
    let written = write_atomically(path, |out| {
        let mut out = Summed { inner: out, sum: crc32fast::Hasher::new() };
        out.write_all(MAGIC)?;
        out.write_all(&(header.len() as u64).to_le_bytes())?;
        out.write_all(header)?;
        if let Err(error) = write_columns(&mut out) {
            refused = Some(error);
            return Err(io::Error::other("the state cannot be written"));
        }
        let sum = out.sum.finalize();
        out.inner.write_all(&sum.to_le_bytes())
    });
    match (written, refused) {
        (Ok(bytes), _) => Ok(bytes),
        (Err(_), Some(error)) => Err(error),
        (Err(source), None) => Err(CheckpointError::File { path: path.into(), source }),
    }
}

/// Keeps the state in memory, so that a run can go back to it; in the room of `spare`, which is done with.
///
/// # Errors
/// Those of `exchange`.
pub fn keep(
    spare: Contents,
    exchange: &mut dyn FnMut(&mut Archive) -> Result<(), CheckpointError>,
) -> Result<Contents, CheckpointError> {
    let (columns, values) = list(exchange)?;
    let mut kept = Contents { values, bytes: spare.bytes, ..Contents::default() };
    let mut offset = 0;
    for (name, entry) in columns {
        let length = entry.count * entry.width * size_of_type(entry.kind).unwrap_or(0);
        kept.columns.insert(name, (entry, offset));
        offset += length;
    }
    kept.bytes.clear();
    kept.bytes.reserve_exact(offset);
    exchange(&mut Archive::writing(&mut kept.bytes))?;
    Ok(kept)
}

/// Whether all components can be saved; writes nothing.
///
/// # Errors
/// Those of `exchange`.
pub fn check(exchange: &mut dyn FnMut(&mut Archive) -> Result<(), CheckpointError>) -> Result<(), CheckpointError> {
    exchange(&mut Archive::listing())
}

/// Names and sizes of the columns, and the single values.
type Listed = (Vec<(String, Entry)>, Map<String, Value>);

fn list(exchange: &mut dyn FnMut(&mut Archive) -> Result<(), CheckpointError>) -> Result<Listed, CheckpointError> {
    let mut archive = Archive::listing();
    exchange(&mut archive)?;
    match archive.mode {
        Mode::Listing { columns, values } => Ok((columns, values)),
        _ => Ok(Listed::default()),
    }
}

fn header(head: Map<String, Value>, values: Map<String, Value>, columns: Vec<(String, Entry)>) -> Vec<u8> {
    let mut offset = 0;
    let mut listed = Vec::with_capacity(columns.len());
    for (name, Entry { kind, count, width }) in columns {
        listed.push(json!({
            "name": name, "type": format!("{BYTE_ORDER}{kind}"), "shape": [count, width], "offset": offset
        }));
        offset += count * width * size_of_type(kind).unwrap_or(0);
    }
    let mut header = json!({"format": FORMAT, "head": head, "values": values, "columns": listed}).to_string();
    // Blanks bring the first column to a multiple; offsets count from there.
    let length = header.len() + MAGIC.len() + size_of::<u64>();
    header.extend(std::iter::repeat_n(' ', length.next_multiple_of(ALIGNMENT) - length));
    header.into_bytes()
}

/// Reads a checkpoint and checks that it is whole.
///
/// # Errors
/// It cannot be read, or is damaged.
pub fn read(path: &Path) -> Result<Contents, CheckpointError> {
    let bytes = std::fs::read(path).map_err(|source| CheckpointError::File { path: path.into(), source })?;
    parse(bytes).map_err(|why| CheckpointError::Damaged { path: path.into(), why: why.into() })
}

fn parse(bytes: Vec<u8>) -> Result<Contents, &'static str> {
    let start = bytes.strip_prefix(MAGIC).ok_or("it does not begin like a checkpoint")?;
    let (all, sum) = bytes.split_last_chunk::<4>().ok_or("it is cut off")?;
    if crc32fast::hash(all) != u32::from_le_bytes(*sum) {
        return Err("its check sum is wrong, so that it is cut off or changed");
    }
    let (length, rest) = start.split_first_chunk::<8>().ok_or("it is cut off")?;
    let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| "its header is too long")?;
    let header = rest.get(..length).ok_or("its header is cut off")?;
    let mut header: Value = serde_json::from_slice(header).map_err(|_| "its header is no JSON")?;
    if header["format"] != FORMAT {
        return Err("it has the format of another version of Bia");
    }
    let mut object = |name: &str| match header[name].take() {
        Value::Object(map) => Ok(map),
        _ => Err("its header lacks a member"),
    };
    let (head, values) = (object("head")?, object("values")?);
    let data = MAGIC.len() + size_of::<u64>() + length;
    let list = header["columns"].as_array().ok_or("its header has no columns")?;
    let columns = list.iter().map(|column| entry(column, data).ok_or("its header has a column that is none"));
    Ok(Contents { head, values, columns: columns.collect::<Result<_, _>>()?, bytes })
}

fn entry(column: &Value, data: usize) -> Option<(String, (Entry, usize))> {
    let whole = |value: &Value| value.as_u64().and_then(|value| usize::try_from(value).ok());
    let kind = column["type"].as_str()?.strip_prefix(BYTE_ORDER)?;
    let kind = ["f8", "u8", "u4", "u1"].into_iter().find(|known| *known == kind)?;
    let entry = Entry { kind, count: whole(&column["shape"][0])?, width: whole(&column["shape"][1])? };
    Some((column["name"].as_str()?.into(), (entry, data + whole(&column["offset"])?)))
}

/// Sums up what goes through it.
struct Summed<'a> {
    inner: &'a mut dyn Write,
    sum: crc32fast::Hasher,
}

impl Write for Summed<'_> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(data)?;
        self.sum.update(&data[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
