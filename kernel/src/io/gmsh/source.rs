//! The bytes of a mesh file as sections of numbers, written as text or binary.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use std::path::Path;

/// How numbers stand in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Text,
    /// Little-endian, or big-endian.
    Binary {
        big_endian: bool,
    },
}

/// A cursor over the file.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
    form: Form,
    path: &'a Path,
}

impl<'a> Source<'a> {
    pub fn new(bytes: &'a [u8], path: &'a Path) -> Self {
        // A byte order mark is no content.
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        Self { bytes, at, form: Form::Text, path }
    }

    pub fn set_form(&mut self, form: Form) {
        self.form = form;
    }

    /// Reads the number 1 that tells the order of bytes.
    pub fn set_binary(&mut self) -> Result<(), InputErrors> {
        let one: [u8; 4] = self.take()?;
        self.form = match (i32::from_le_bytes(one), i32::from_be_bytes(one)) {
            (1, _) => Form::Binary { big_endian: false },
            (_, 1) => Form::Binary { big_endian: true },
            _ => return Err(self.fault("the number after the format line is not 1").into()),
        };
        Ok(())
    }

    /// A fault at the cursor: its line in text, its byte in binary.
    pub fn fault(&self, message: impl Into<String>) -> Diagnostic {
        let message: String = message.into();
        match self.form {
            Form::Text => {
                let before = &self.bytes[..self.at.min(self.bytes.len())];
                // The cursor stands behind what was read.
                let before = before.strip_suffix(b"\n").unwrap_or(before);
                let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
                Diagnostic::error(Place::line(self.path, line), message)
            }
            Form::Binary { .. } => Diagnostic::error(Place::file(self.path), format!("byte {}: {message}", self.at)),
        }
    }

    fn ended(&self) -> InputErrors {
        self.fault("the file ends too soon").help("it seems truncated: write it again").into()
    }

    /// Whether `count` items of at least this many bytes (or digits) can follow.
    pub fn check_count(&self, count: u64, binary_size: u64) -> Result<usize, InputErrors> {
        let least = if self.form == Form::Text { 2 } else { binary_size };
        let left = (self.bytes.len() - self.at) as u64;
        // The last number of a text may stand without its blank.
        if count.saturating_mul(least) > left + 1 {
            return Err(self.fault(format!("{count} items are announced, for which the file is too short")).into());
        }
        Ok(count as usize)
    }

    /// The rest of the line.
    pub fn line(&mut self) -> Result<String, InputErrors> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(self.ended());
        }
        let length = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        let text = &rest[..length];
        match std::str::from_utf8(text.strip_suffix(b"\r").unwrap_or(text)) {
            Ok(text) => Ok(text.to_string()),
            Err(_) => Err(self.fault("the line is not UTF-8").into()),
        }
    }

    fn skip_blanks(&mut self) {
        let blanks = self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_whitespace());
        self.at += blanks.count();
    }

    /// The next section's name without `$`; none at the end of the file.
    pub fn section(&mut self) -> Result<Option<String>, InputErrors> {
        self.skip_blanks();
        if self.at == self.bytes.len() {
            return Ok(None);
        }
        let line = self.line()?;
        match line.trim().strip_prefix('$') {
            Some(name) => Ok(Some(name.to_string())),
            None => {
                let shown: String = line.chars().take(40).collect();
                Err(self.fault(format!("{shown:?} stands where a section $… must begin")).into())
            }
        }
    }

    /// Passes over the end of a section that was read.
    pub fn end_of(&mut self, section: &str) -> Result<(), InputErrors> {
        match self.section()? {
            Some(end) if end.strip_prefix("End") == Some(section) => Ok(()),
            Some(found) => Err(self.fault(format!("${found} stands where $End{section} must")).into()),
            None => Err(self.ended()),
        }
    }

    /// Passes over a section that is of no use.
    pub fn skip_section(&mut self, section: &str) -> Result<(), InputErrors> {
        let end = format!("$End{section}");
        let found = self.bytes[self.at..].windows(end.len()).position(|bytes| bytes == end.as_bytes());
        let Some(found) = found else {
            return Err(self.fault(format!("the section ${section} has no end")).into());
        };
        self.at += found + end.len();
        Ok(())
    }

    fn word(&mut self) -> Result<&'a str, InputErrors> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
        if length == 0 {
            return Err(self.ended());
        }
        self.at += length;
        std::str::from_utf8(&rest[..length]).map_err(|_| self.fault("a word is not UTF-8").into())
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], InputErrors> {
        match self.bytes[self.at..].first_chunk::<N>() {
            Some(chunk) => {
                self.at += N;
                Ok(*chunk)
            }
            None => Err(self.ended()),
        }
    }

    fn parse<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, InputErrors> {
        let word = self.word()?;
        word.parse().map_err(|_| self.fault(format!("{word:?} is no {what}")).into())
    }

    /// A whole number of 4 bytes in binary files.
    pub fn int(&mut self) -> Result<i32, InputErrors> {
        match self.form {
            Form::Text => self.parse("whole number"),
            Form::Binary { big_endian } => {
                let bytes = self.take()?;
                Ok(if big_endian { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) })
            }
        }
    }

    /// A count or tag of 8 bytes in binary files of version 4.
    pub fn size(&mut self) -> Result<u64, InputErrors> {
        match self.form {
            Form::Text => self.parse("whole number of at least 0"),
            Form::Binary { big_endian } => {
                let bytes = self.take()?;
                Ok(if big_endian { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
            }
        }
    }

    /// A finite number.
    pub fn double(&mut self) -> Result<f64, InputErrors> {
        let number: f64 = match self.form {
            Form::Text => self.parse("number")?,
            Form::Binary { big_endian } => {
                let bytes = self.take()?;
                if big_endian { f64::from_be_bytes(bytes) } else { f64::from_le_bytes(bytes) }
            }
        };
        match number.is_finite() {
            true => Ok(number),
            false => Err(self.fault(format!("{number} is not finite")).into()),
        }
    }

    /// An id of 4 bytes.
    pub fn int_id(&mut self) -> Result<u32, InputErrors> {
        let number = self.int()?;
        self.id(i64::from(number))
    }

    /// An id of 8 bytes.
    pub fn size_id(&mut self) -> Result<u32, InputErrors> {
        let number = self.size()?;
        self.id(i64::try_from(number).unwrap_or(i64::MAX))
    }

    fn id(&self, number: i64) -> Result<u32, InputErrors> {
        match u32::try_from(number) {
            Ok(id) if id > 0 => Ok(id),
            _ => Err(self.fault(format!("the id {number} is not between 1 and {}", u32::MAX)).into()),
        }
    }

    /// Coordinates (m).
    pub fn place(&mut self) -> Result<[f64; 3], InputErrors> {
        Ok([self.double()?, self.double()?, self.double()?])
    }

    pub fn is_text(&self) -> bool {
        self.form == Form::Text
    }
}
