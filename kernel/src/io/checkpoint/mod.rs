//! Checkpoints: all that a run keeps from step to step, in one file, so that it can be taken up again.
//!
//! Whoever keeps something exchanges it with an [`Archive`]: the same calls write a checkpoint and read
//! it, so that the two cannot differ. Numbers keep all their bits.
//!
//! The file ([`file`]): eight bytes of magic, the length of the header (u64), the header as JSON, the
//! columns one after the other as raw numbers, and a CRC-32 of everything before it. The header names each
//! column with its type as numpy spells it, its shape and its place in the file.

pub mod file;
#[cfg(test)]
mod tests;

use serde_json::{Map, Value};
use std::collections::HashMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a checkpoint cannot be written or taken up.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// A component whose state nobody can save.
    #[error("{0} does not say what it keeps from step to step, so that a run with it cannot be resumed")]
    Unsupported(String),
    /// The checkpoint lacks what the run needs.
    #[error("the checkpoint does not hold {0:?}")]
    Missing(String),
    /// The checkpoint does not fit the run.
    #[error("{name} is {stored} in the checkpoint, but {expected} in the run")]
    Differs {
        /// What.
        name: String,
        /// In the checkpoint.
        stored: String,
        /// In the run.
        expected: String,
    },
    /// A file that goes on where the checkpoint left it cannot be used.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Not a whole checkpoint.
    #[error("{} is damaged: {why}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
}

/// Numbers that columns are made of.
pub trait Element: bytemuck::Pod {
    /// Type of the numbers, as numpy spells it but for the order of bytes.
    const TYPE: &'static str;
    /// Numbers of an element.
    const WIDTH: usize;
}

macro_rules! element {
    ($($number:ty, $name:literal;)*) => {$(
        impl Element for $number {
            const TYPE: &'static str = $name;
            const WIDTH: usize = 1;
        }
        impl<const N: usize> Element for [$number; N]
        where
            [$number; N]: bytemuck::Pod,
        {
            const TYPE: &'static str = $name;
            const WIDTH: usize = N;
        }
    )*};
}

element! { f64, "f8"; u64, "u8"; u32, "u4"; u8, "u1"; }

/// A column as the header describes it.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Entry {
    kind: &'static str,
    count: usize,
    width: usize,
}

/// What an archive does with what it is shown.
enum Mode<'a> {
    /// Learns names and sizes, for the header.
    Listing { columns: Vec<(String, Entry)>, values: Map<String, Value> },
    /// Writes the columns.
    Writing { out: &'a mut dyn Write },
    /// Gives back what a file holds.
    Loading { contents: &'a Contents },
}

/// What a checkpoint file holds.
#[derive(Debug, Default)]
pub struct Contents {
    /// Members that the writer put beside the columns.
    pub head: Map<String, Value>,
    values: Map<String, Value>,
    columns: HashMap<String, (Entry, usize)>,
    bytes: Vec<u8>,
}

/// Through which the state of a run goes to a checkpoint or comes from it.
pub struct Archive<'a> {
    mode: Mode<'a>,
    section: String,
}

impl<'a> Archive<'a> {
    /// An archive that gives back what a file holds.
    pub fn loading(contents: &'a Contents) -> Self {
        Self { mode: Mode::Loading { contents }, section: String::new() }
    }

    fn listing() -> Self {
        Self { mode: Mode::Listing { columns: Vec::new(), values: Map::new() }, section: String::new() }
    }

    fn writing(out: &'a mut dyn Write) -> Self {
        Self { mode: Mode::Writing { out }, section: String::new() }
    }

    /// Whether the state comes from a checkpoint; else it goes there.
    pub fn is_loading(&self) -> bool {
        matches!(self.mode, Mode::Loading { .. })
    }

    /// Names within `work` stand under this name.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn section<T, E>(&mut self, name: &str, work: impl FnOnce(&mut Self) -> Result<T, E>) -> Result<T, E> {
        let before = self.section.len();
        self.section.push_str(name);
        self.section.push('/');
        let result = work(self);
        self.section.truncate(before);
        result
    }

    /// A column of any length.
    ///
    /// # Errors
    /// It cannot be written; the checkpoint has no such column.
    pub fn column<T: Element>(&mut self, name: &str, values: &mut Vec<T>) -> Result<(), CheckpointError> {
        if let Mode::Loading { contents } = &self.mode {
            let name = format!("{}{name}", self.section);
            let (entry, bytes) = contents.column(&name)?;
            values.resize(entry.count, T::zeroed());
            fill(&name, entry, bytes, values)
        } else {
            self.slice(name, values)
        }
    }

    /// A column whose length the run knows beforehand.
    ///
    /// # Errors
    /// It cannot be written; the checkpoint has no such column, or one of another length.
    pub fn slice<T: Element>(&mut self, name: &str, values: &mut [T]) -> Result<(), CheckpointError> {
        let name = format!("{}{name}", self.section);
        match &mut self.mode {
            Mode::Listing { columns, .. } => {
                columns.push((name, Entry { kind: T::TYPE, count: values.len(), width: T::WIDTH }));
                Ok(())
            }
            Mode::Writing { out } => {
                let written = out.write_all(bytemuck::cast_slice(values));
                written.map_err(|source| CheckpointError::File { path: name.into(), source })
            }
            Mode::Loading { contents } => {
                let (entry, bytes) = contents.column(&name)?;
                fill(&name, entry, bytes, values)
            }
        }
    }

    /// A number with all its bits.
    ///
    /// # Errors
    /// Those of [`Self::slice`].
    pub fn number(&mut self, name: &str, value: &mut f64) -> Result<(), CheckpointError> {
        self.slice(name, std::slice::from_mut(value))
    }

    /// A column of switches.
    ///
    /// # Errors
    /// Those of [`Self::column`].
    pub fn switches(&mut self, name: &str, values: &mut Vec<[bool; 3]>) -> Result<(), CheckpointError> {
        let mut bytes: Vec<[u8; 3]> = values.iter().map(|row| row.map(u8::from)).collect();
        self.column(name, &mut bytes)?;
        if self.is_loading() {
            *values = bytes.into_iter().map(|row| row.map(|byte| byte != 0)).collect();
        }
        Ok(())
    }

    /// A whole number.
    ///
    /// # Errors
    /// The checkpoint has no such value; likewise below.
    pub fn count(&mut self, name: &str, value: &mut usize) -> Result<(), CheckpointError> {
        let read = |stored: &Value| stored.as_u64().and_then(|stored| usize::try_from(stored).ok());
        self.value(name, value, |value| (*value).into(), read)
    }

    /// A switch.
    ///
    /// # Errors
    /// See [`Self::count`].
    pub fn flag(&mut self, name: &str, value: &mut bool) -> Result<(), CheckpointError> {
        self.value(name, value, |value| (*value).into(), Value::as_bool)
    }

    /// Switches, a byte each.
    ///
    /// # Errors
    /// See [`Self::count`].
    pub fn flags(&mut self, name: &str, values: &mut Vec<bool>) -> Result<(), CheckpointError> {
        let mut bytes: Vec<u8> = values.iter().map(|value| u8::from(*value)).collect();
        self.column(name, &mut bytes)?;
        if self.is_loading() {
            *values = bytes.into_iter().map(|byte| byte != 0).collect();
        }
        Ok(())
    }

    /// Texts.
    ///
    /// # Errors
    /// See [`Self::count`].
    pub fn texts(&mut self, name: &str, value: &mut Vec<String>) -> Result<(), CheckpointError> {
        let read = |stored: &Value| {
            let list = stored.as_array()?.iter().map(|text| text.as_str().map(str::to_owned));
            list.collect::<Option<Vec<String>>>()
        };
        self.value(name, value, |value| value.clone().into(), read)
    }

    /// A file to which the run appends: it goes on where it stood, and what came after is cut off.
    ///
    /// # Errors
    /// See [`Self::count`]; the file is gone, or shorter than it was.
    pub fn growing_file(&mut self, name: &str, path: &Path, file: &mut Option<File>) -> Result<(), CheckpointError> {
        let failed = |source| CheckpointError::File { path: path.into(), source };
        let mut is_begun = file.is_some();
        let mut length = match file {
            Some(file) => file.stream_position().map_err(failed)? as usize,
            None => 0,
        };
        self.flag(&format!("{name}_begun"), &mut is_begun)?;
        self.count(&format!("{name}_length"), &mut length)?;
        if self.is_loading() {
            *file = if is_begun { Some(reopen(path, length as u64).map_err(failed)?) } else { None };
        }
        Ok(())
    }

    fn value<T>(
        &mut self,
        name: &str,
        value: &mut T,
        store: impl Fn(&T) -> Value,
        read: impl Fn(&Value) -> Option<T>,
    ) -> Result<(), CheckpointError> {
        let name = format!("{}{name}", self.section);
        match &mut self.mode {
            Mode::Listing { values, .. } => {
                values.insert(name, store(value));
            }
            Mode::Writing { .. } => {}
            Mode::Loading { contents } => {
                let stored = contents.values.get(&name).and_then(read);
                *value = stored.ok_or(CheckpointError::Missing(name))?;
            }
        }
        Ok(())
    }
}

impl Contents {
    fn column(&self, name: &str) -> Result<(&Entry, &[u8]), CheckpointError> {
        let found = self.columns.get(name).and_then(|(entry, offset)| {
            let length = entry.count * entry.width * size_of_type(entry.kind)?;
            Some((entry, self.bytes.get(*offset..offset.checked_add(length)?)?))
        });
        found.ok_or_else(|| CheckpointError::Missing(name.into()))
    }
}

fn fill<T: Element>(name: &str, entry: &Entry, bytes: &[u8], values: &mut [T]) -> Result<(), CheckpointError> {
    let expected = Entry { kind: T::TYPE, count: values.len(), width: T::WIDTH };
    if *entry != expected {
        let shown = |entry: &Entry| format!("{} × {} numbers of type {}", entry.count, entry.width, entry.kind);
        let (stored, expected) = (shown(entry), shown(&expected));
        return Err(CheckpointError::Differs { name: name.into(), stored, expected });
    }
    bytemuck::cast_slice_mut(values).copy_from_slice(bytes);
    Ok(())
}

/// Bytes of a number of this type.
fn size_of_type(kind: &str) -> Option<usize> {
    kind.get(1..)?.parse().ok()
}

/// Opens a file to go on after `length` bytes, and cuts off the rest.
///
/// # Errors
/// It does not exist, or is shorter.
pub fn reopen(path: &Path, length: u64) -> io::Result<File> {
    let mut file = OpenOptions::new().write(true).open(path)?;
    let present = file.metadata()?.len();
    if present < length {
        let message = format!("holds {present} bytes, but held {length} when the checkpoint was written");
        return Err(io::Error::new(io::ErrorKind::InvalidData, message));
    }
    file.set_len(length)?;
    file.seek(SeekFrom::End(0))?;
    Ok(file)
}
