//! A JSON file as text and value together, so that every complaint can name its line.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A JSON document with its source text. `//` and `/* */` comments are allowed, as in Kratos.
#[derive(Debug, Clone)]
pub struct Document {
    path: PathBuf,
    text: String,
    root: Value,
}

impl Document {
    /// Reads and parses a file.
    ///
    /// # Errors
    /// A missing or unreadable file, or JSON syntax, with line and column.
    pub fn read(path: &Path) -> Result<Self, InputErrors> {
        let bytes = std::fs::read(path).map_err(|error| {
            let near = near_files(path);
            let diagnostic = Diagnostic::error(Place::file(path), format!("cannot be read: {error}"));
            if near.is_empty() { diagnostic } else { diagnostic.help(format!("files there: {}", near.join(", "))) }
        })?;
        let text = String::from_utf8(bytes).map_err(|error| {
            Diagnostic::error(
                Place::file(path),
                format!("is not UTF-8 text (byte {})", error.utf8_error().valid_up_to()),
            )
        })?;
        Self::parse(path, text)
    }

    /// Parses a text that stands (or would stand) in `path`.
    ///
    /// # Errors
    /// JSON syntax, with line and column.
    pub fn parse(path: &Path, text: String) -> Result<Self, InputErrors> {
        let root = serde_json::from_str(&without_comments(&text)).map_err(|error| {
            let mut place = Place::line(path, error.line());
            place.column = Some(error.column());
            let mut message = error.to_string();
            if let Some(end) = message.find(" at line") {
                message.truncate(end);
            }
            Diagnostic::error(place, format!("is not JSON: {message}"))
                .help("look for a missing comma, quote or bracket just before this place")
        })?;
        Ok(Self { path: path.to_path_buf(), text, root })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The source text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The whole value.
    pub fn root(&self) -> &Value {
        &self.root
    }

    /// Replaces (or adds to an object) the value at a JSON pointer; `text` is JSON, or a plain word.
    ///
    /// # Errors
    /// A pointer whose parent does not exist or is no object or list.
    pub fn set(&mut self, pointer: &str, text: &str) -> Result<(), InputErrors> {
        let value = serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.into()));
        let (parent, key) = pointer.rsplit_once('/').unwrap_or(("", pointer));
        let key = key.replace("~1", "/").replace("~0", "~");
        let place = Place { file: Some(self.path.clone()), pointer: Some(pointer.into()), ..Place::default() };
        match self.root.pointer_mut(parent) {
            Some(Value::Object(object)) => {
                object.insert(key, value);
                Ok(())
            }
            Some(Value::Array(list)) => match key.parse::<usize>().ok().and_then(|i| list.get_mut(i)) {
                Some(entry) => {
                    *entry = value;
                    Ok(())
                }
                None => Err(Diagnostic::error(place, "there is no such entry in the list to set").into()),
            },
            _ => Err(Diagnostic::error(place, "cannot be set: its parent does not exist")
                .help("a pointer looks like /solver_settings/time_stepping/time_step")
                .into()),
        }
    }

    /// Where the value at a JSON pointer stands; the nearest enclosing value if it is not in the text.
    pub fn place(&self, pointer: &str) -> Place {
        let mut place = Place { file: Some(self.path.clone()), pointer: Some(pointer.into()), ..Place::default() };
        if let Some(offset) = locate(&self.text, pointer) {
            let before = &self.text[..offset];
            place.line = Some(before.matches('\n').count() + 1);
            place.column = Some(before.rsplit('\n').next().map_or(1, |line| line.chars().count() + 1));
        }
        place
    }
}

fn near_files(path: &Path) -> Vec<String> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let extension = path.extension();
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|file| file.extension() == extension)
        .filter_map(|file| file.file_name().map(|name| name.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    names.truncate(8);
    names
}

/// Blanks out comments, keeping every byte position and line break.
fn without_comments(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let (mut i, mut in_string) = (0, false);
    while i < bytes.len() {
        match bytes[i] {
            b'\\' if in_string => i += 1,
            b'"' => in_string = !in_string,
            b'/' if !in_string => {
                let rest = &text.as_bytes()[i..];
                let end = if rest.starts_with(b"//") {
                    rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len())
                } else if rest.starts_with(b"/*") {
                    rest.windows(2).skip(2).position(|w| w == b"*/").map_or(rest.len(), |p| p + 4)
                } else {
                    0
                };
                for byte in &mut bytes[i..i + end] {
                    if *byte != b'\n' {
                        *byte = b' ';
                    }
                }
                i += end;
                if end > 0 {
                    continue;
                }
            }
            _ => {}
        }
        i += 1;
    }
    String::from_utf8(bytes).unwrap_or_default()
}

/// Byte offset of the value at `pointer`, or of the deepest value on the way that exists.
/// Walks only what it must; called for messages, never while running.
fn locate(text: &str, pointer: &str) -> Option<usize> {
    let clean = without_comments(text);
    let mut at = skip_blank(clean.as_bytes(), 0);
    for token in pointer.split('/').skip(1) {
        let token = token.replace("~1", "/").replace("~0", "~");
        match step_into(clean.as_bytes(), at, &token) {
            Some(next) => at = next,
            None => break,
        }
    }
    (at < text.len()).then_some(at)
}

fn skip_blank(bytes: &[u8], mut at: usize) -> usize {
    while at < bytes.len() && bytes[at].is_ascii_whitespace() {
        at += 1;
    }
    at
}

/// End of the JSON value that starts at `at`.
fn skip_value(bytes: &[u8], mut at: usize) -> usize {
    let (mut depth, mut in_string) = (0usize, false);
    while at < bytes.len() {
        match bytes[at] {
            b'\\' if in_string => at += 1,
            b'"' => {
                in_string = !in_string;
                if !in_string && depth == 0 {
                    return at + 1;
                }
            }
            b'{' | b'[' if !in_string => depth += 1,
            b'}' | b']' if !in_string => {
                if depth <= 1 {
                    return if depth == 1 { at + 1 } else { at };
                }
                depth -= 1;
            }
            b',' if !in_string && depth == 0 => return at,
            _ => {}
        }
        at += 1;
    }
    at
}

/// Offset of the member `token` of the object or list that starts at `at`.
fn step_into(bytes: &[u8], at: usize, token: &str) -> Option<usize> {
    let is_object = match bytes.get(at)? {
        b'{' => true,
        b'[' => false,
        _ => return None,
    };
    let wanted = if is_object { None } else { Some(token.parse::<usize>().ok()?) };
    let (mut at, mut index) = (skip_blank(bytes, at + 1), 0);
    while at < bytes.len() && !matches!(bytes[at], b'}' | b']') {
        let mut found = wanted == Some(index);
        if is_object {
            let end = skip_value(bytes, at);
            let end = if bytes[at] == b'"' { end } else { return None };
            found = serde_json::from_slice::<String>(&bytes[at..end]).is_ok_and(|key| key == token);
            at = skip_blank(bytes, end);
            if bytes.get(at) != Some(&b':') {
                return None;
            }
            at = skip_blank(bytes, at + 1);
        }
        if found {
            return Some(at);
        }
        at = skip_blank(bytes, skip_value(bytes, at));
        if bytes.get(at) == Some(&b',') {
            at = skip_blank(bytes, at + 1);
        }
        index += 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "{ // a comment \"with quotes\"\n  \"a\": {\"b/c\": [1, {\"d\": 2}, \"x//y\"]},\n  /* more */ \"e\": 3\n}";

    #[test]
    fn places_are_found_through_comments_and_escapes() {
        let document = Document::parse(Path::new("f.json"), TEXT.into()).unwrap();
        assert_eq!(document.root().pointer("/a/b~1c/2").unwrap(), "x//y");
        let place = document.place("/a/b~1c/1/d");
        assert_eq!((place.line, place.column), (Some(2), Some(26)));
        let place = document.place("/e");
        assert_eq!((place.line, place.column), (Some(3), Some(19)));
        assert_eq!(document.place("/a/missing").line, Some(2), "the enclosing value");
    }

    #[test]
    fn syntax_errors_name_line_and_column() {
        let errors = Document::parse(Path::new("f.json"), "{\n \"a\": 1,\n}".into()).unwrap_err();
        assert_eq!(errors.0[0].place.line, Some(3));
        assert!(errors.to_string().contains("trailing comma"), "{errors}");
    }

    #[test]
    fn values_are_set_by_pointer() {
        let mut document = Document::parse(Path::new("f.json"), TEXT.into()).unwrap();
        document.set("/a/b~1c/0", "7").unwrap();
        document.set("/a/new", "word").unwrap();
        assert_eq!(document.root()["a"]["b/c"][0], 7);
        assert_eq!(document.root()["a"]["new"], "word");
        assert!(document.set("/nope/x", "1").is_err());
    }
}
