//! A JSON file as text and value together, so that every complaint can name its line.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use serde_json::Value;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A JSON document with its source text. `//` and `/* */` comments are allowed, as in Kratos.
#[derive(Debug, Clone)]
pub struct Document {
    path: PathBuf,
    text: String,
    root: Value,
    /// Pointers whose values do not stand in the text.
    set: Vec<String>,
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
    /// JSON syntax, with line and column; a key that stands twice in an object.
    pub fn parse(path: &Path, text: String) -> Result<Self, InputErrors> {
        // A byte order mark is no content.
        let text = text.strip_prefix('\u{feff}').map_or_else(|| text.clone(), str::to_owned);
        let clean = without_comments(&text);
        let root = serde_json::from_str(&clean).map_err(|error| syntax_error(path, &text, &error))?;
        let mut errors = InputErrors::default();
        for (pointer, first, second) in doubles(clean.as_bytes()) {
            let place = place_at(path, &pointer, &text, second);
            let key = pointer.rsplit('/').next().unwrap_or_default();
            let line = line_and_column(&text, first).0;
            let message = format!("the key {key:?} stands twice in one object, first on line {line}");
            errors.push(Diagnostic::error(place, message).help("remove one of them; only one could have an effect"));
        }
        errors.or(Self { path: path.to_path_buf(), text, root, set: Vec::new() })
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

    /// Replaces (or adds to an object) the value at a JSON pointer; `text` is JSON, or a plain word. `-` is
    /// the entry after the last one of a list (RFC 6901), which is added.
    ///
    /// # Errors
    /// A pointer whose parent does not exist or is no object or list.
    pub fn set(&mut self, pointer: &str, text: &str) -> Result<(), InputErrors> {
        let value = serde_json::from_str(text).unwrap_or_else(|_| Value::String(text.into()));
        let place = Place { file: Some(self.path.clone()), pointer: Some(pointer.into()), ..Place::default() };
        let Some((parent, key)) = pointer.rsplit_once('/').filter(|_| pointer.starts_with('/')) else {
            let help = "a pointer looks like /solver_settings/time_stepping/time_step";
            return Err(Diagnostic::error(place, "is no JSON pointer").help(help).into());
        };
        self.set.push(pointer.into());
        let key = key.replace("~1", "/").replace("~0", "~");
        match self.root.pointer_mut(parent) {
            Some(Value::Object(object)) => {
                object.insert(key, value);
                Ok(())
            }
            Some(Value::Array(list)) if key == "-" => {
                list.push(value);
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
        let below =
            |set: &String| pointer.strip_prefix(set.as_str()).is_some_and(|r| r.is_empty() || r.starts_with('/'));
        let mut place = Place { file: Some(self.path.clone()), pointer: Some(pointer.into()), ..Place::default() };
        if self.set.iter().any(below) {
            place.pointer = Some(format!("{pointer} (set on the command line)"));
            return place;
        }
        match locate(&self.text, pointer) {
            Some(offset) => place_at(&self.path, pointer, &self.text, offset),
            None => place,
        }
    }
}

fn syntax_error(path: &Path, text: &str, error: &serde_json::Error) -> Diagnostic {
    let line = text.lines().nth(error.line().saturating_sub(1)).unwrap_or_default();
    // The parser counts bytes, people count letters.
    let column = line.char_indices().take_while(|(byte, _)| byte + 1 < error.column()).count() + 1;
    let place = Place { column: Some(column), ..Place::line(path, error.line()) };
    let message = error.to_string();
    let message = message.split(" at line").next().unwrap_or_default();
    let help = match message {
        "number out of range" => "a number must be smaller than 1.8e308",
        "expected ident" | "expected value" => {
            "a value is a number, \"text\", true, false, null, a list or an object; JSON has no nan or infinity"
        }
        _ => "look for a missing comma, quote or bracket just before this place",
    };
    Diagnostic::error(place, format!("is not JSON: {message}")).help(help)
}

fn place_at(path: &Path, pointer: &str, text: &str, offset: usize) -> Place {
    let (line, column) = line_and_column(text, offset);
    Place { file: Some(path.to_path_buf()), pointer: Some(pointer.into()), line: Some(line), column: Some(column) }
}

/// Line and column of a byte offset, both counted from 1.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or_default();
    let column = before.rsplit('\n').next().map_or(1, |line| line.chars().count() + 1);
    (before.matches('\n').count() + 1, column)
}

/// Keys that stand twice in one object: pointer, offset of the first and of the second. `bytes` is
/// JSON without comments.
fn doubles(bytes: &[u8]) -> Vec<(String, usize, usize)> {
    /// An open object or list: its pointer, the keys so far, and the key or index that comes.
    struct Open {
        pointer: String,
        keys: HashMap<String, usize>,
        index: Option<usize>,
        key: String,
    }
    let mut found = Vec::new();
    let mut open: Vec<Open> = Vec::new();
    let (mut at, mut key_comes) = (0, false);
    while at < bytes.len() {
        match bytes[at] {
            b'{' | b'[' => {
                let pointer = open.last().map_or_else(String::new, |parent| match parent.index {
                    Some(index) => format!("{}/{index}", parent.pointer),
                    None => format!("{}/{}", parent.pointer, parent.key),
                });
                key_comes = bytes[at] == b'{';
                let index = (!key_comes).then_some(0);
                open.push(Open { pointer, keys: HashMap::new(), index, key: String::new() });
            }
            b'}' | b']' => {
                open.pop();
                key_comes = false;
            }
            b',' => match open.last_mut() {
                Some(Open { index: Some(index), .. }) => *index += 1,
                _ => key_comes = true,
            },
            b'"' => {
                let end = skip_value(bytes, at);
                if let Some(object) = open.last_mut().filter(|_| key_comes) {
                    let key: String = serde_json::from_slice(&bytes[at..end]).unwrap_or_default();
                    object.key = key.replace('~', "~0").replace('/', "~1");
                    match object.keys.get(&key) {
                        Some(&first) => found.push((format!("{}/{}", object.pointer, object.key), first, at)),
                        None => drop(object.keys.insert(key, at)),
                    }
                    key_comes = false;
                }
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
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
        let errors = Document::parse(Path::new("f.json"), "{\"é\": \"ü\" 1}".into()).unwrap_err();
        assert_eq!(errors.0[0].place.column, Some(11), "{errors}");
    }

    #[test]
    fn keys_that_stand_twice_are_found_in_their_object() {
        let doubles = |text: &str| Document::parse(Path::new("f.json"), text.into()).err().map(|e| e.to_string());
        assert_eq!(doubles("{\"a\": {\"a\": [\"a\", \"a\"]}, \"b\": {\"a\": 1}}"), None);
        let message = doubles("{\"l\": [1, {\n\"b/c\": {\"x\": 1}, // \"b/c\"\n\"b\\/c\": 2}]}").unwrap();
        assert!(message.contains("f.json:3:1 at /l/1/b~1c") && message.contains("first on line 2"), "{message}");
    }

    #[test]
    fn values_are_set_by_pointer() {
        let mut document = Document::parse(Path::new("f.json"), TEXT.into()).unwrap();
        document.set("/a/b~1c/0", "7").unwrap();
        document.set("/a/new", "word").unwrap();
        assert_eq!(document.root()["a"]["b/c"][0], 7);
        assert_eq!(document.root()["a"]["new"], "word");
        document.set("/a/b~1c/-", "[8]").unwrap();
        assert_eq!(document.root()["a"]["b/c"][3][0], 8);
        assert!(document.set("/nope/x", "1").is_err() && document.set("e", "1").is_err());
        assert!(document.place("/a/new").to_string().ends_with("/a/new (set on the command line)"));
        assert_eq!(document.place("/a/newer").line, Some(2));
    }
}
