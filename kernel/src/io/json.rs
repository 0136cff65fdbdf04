//! JSON written as it comes, for results too large to be held as a tree.

use serde_json::Value;
use std::io::{Result, Write};

/// An object that is being written, member by member.
pub struct JsonObject<'a> {
    out: &'a mut dyn Write,
    empty: bool,
}

impl<'a> JsonObject<'a> {
    /// Opens an object.
    ///
    /// # Errors
    /// The writer's, as for all that follows.
    pub fn open(out: &'a mut dyn Write) -> Result<Self> {
        out.write_all(b"{")?;
        Ok(Self { out, empty: true })
    }

    fn key(&mut self, key: &str) -> Result<()> {
        if !std::mem::replace(&mut self.empty, false) {
            self.out.write_all(b",")?;
        }
        serde_json::to_writer(&mut *self.out, key)?;
        self.out.write_all(b":")
    }

    /// A member with a small value.
    pub fn value(&mut self, key: &str, value: &Value) -> Result<()> {
        self.key(key)?;
        Ok(serde_json::to_writer(&mut *self.out, value)?)
    }

    /// A member that is a list of whole numbers.
    pub fn integers(&mut self, key: &str, values: impl IntoIterator<Item = u32>) -> Result<()> {
        self.key(key)?;
        self.list(values, |out, value| {
            serde_json::to_writer(out, &value)?;
            Ok(())
        })
    }

    /// A member that is a list of numbers.
    pub fn numbers(&mut self, key: &str, values: impl IntoIterator<Item = f64>) -> Result<()> {
        self.key(key)?;
        self.list(values, number)
    }

    /// A member that is a list of lists of numbers.
    pub fn rows<R: AsRef<[f64]>>(&mut self, key: &str, rows: impl IntoIterator<Item = R>) -> Result<()> {
        self.key(key)?;
        self.list(rows, |out, row| {
            out.push(b'[');
            for (i, &value) in row.as_ref().iter().enumerate() {
                if i > 0 {
                    out.push(b',');
                }
                number(out, value)?;
            }
            out.push(b']');
            Ok(())
        })
    }

    /// A member that is an object, written by `fill`.
    pub fn object(&mut self, key: &str, fill: impl FnOnce(&mut JsonObject) -> Result<()>) -> Result<()> {
        self.key(key)?;
        let mut inner = JsonObject::open(self.out)?;
        fill(&mut inner)?;
        inner.close()
    }

    /// Closes the object.
    pub fn close(self) -> Result<()> {
        self.out.write_all(b"}")
    }

    fn list<T>(
        &mut self,
        values: impl IntoIterator<Item = T>,
        write: impl Fn(&mut Vec<u8>, T) -> Result<()>,
    ) -> Result<()> {
        const FLUSH: usize = 1 << 16;
        let mut buffer = vec![b'['];
        for (i, value) in values.into_iter().enumerate() {
            if i > 0 {
                buffer.push(b',');
            }
            write(&mut buffer, value)?;
            if buffer.len() > FLUSH {
                self.out.write_all(&buffer)?;
                buffer.clear();
            }
        }
        buffer.push(b']');
        self.out.write_all(&buffer)
    }
}

/// Shortest digits that read back to the same number; JSON has no infinities: they become null.
fn number(out: &mut Vec<u8>, value: f64) -> Result<()> {
    if value.is_finite() {
        serde_json::to_writer(out, &value)?;
    } else {
        out.extend_from_slice(b"null");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_written_reads_back() {
        let mut text = Vec::new();
        let mut object = JsonObject::open(&mut text).unwrap();
        object.value("a \"b\"", &json!({"x": 1})).unwrap();
        object.numbers("n", [0.1, f64::NAN, 1e-300]).unwrap();
        object.rows("r", [[1.0, 2.0], [3.0, 4.0]]).unwrap();
        object.integers("i", []).unwrap();
        object.object("o", |inner| inner.integers("k", [7])).unwrap();
        object.close().unwrap();
        let read: Value = serde_json::from_slice(&text).unwrap();
        let expected = json!({"a \"b\"": {"x": 1}, "n": [0.1, null, 1e-300], "r": [[1.0, 2.0], [3.0, 4.0]],
            "i": [], "o": {"k": [7]}});
        assert_eq!(read, expected);
    }
}
