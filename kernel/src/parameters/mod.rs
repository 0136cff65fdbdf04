//! Parameters: JSON with declared keys.
//!
//! A component declares its keys once, as a table of [`Key`]s with kind, default, range and help.
//! [`Parameters::read`] checks a JSON object against the table, fills in the defaults and returns
//! [`Settings`]; all faults of an object are reported together, each with file, line, pointer and
//! the nearest allowed name. The same table feeds the documentation.

mod document;
mod key;
pub mod schema;
mod settings;

pub use document::Document;
pub use key::{Default, Key, Kind, Range};
pub use settings::Settings;

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::io::files::resolve;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// A value of a JSON document together with its place.
#[derive(Debug, Clone)]
pub struct Parameters {
    document: Arc<Document>,
    pointer: String,
    value: Value,
}

impl Parameters {
    /// The root of a document.
    pub fn root(document: Document) -> Self {
        let value = document.root().clone();
        Self { document: Arc::new(document), pointer: String::new(), value }
    }

    /// The value itself.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// What it is, for messages: `the text "abc"`, `the number 3`.
    pub fn describe(&self) -> String {
        describe(&self.value)
    }

    /// The document it stands in.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Its JSON pointer.
    pub fn pointer(&self) -> &str {
        &self.pointer
    }

    /// Its place in the file.
    pub fn place(&self) -> Place {
        self.document.place(&self.pointer)
    }

    /// Whether a path is this document itself, or an existing file beside it that the document names,
    /// or a mesh.
    pub fn is_input(&self, path: &Path) -> bool {
        let found = resolve(path);
        let is_mesh = found.extension().is_some_and(|extension| extension == "mdpa" || extension == "msh");
        let folder = self.document.path().parent().unwrap_or_else(|| Path::new(""));
        let materials = self.document.root().pointer("/solver_settings/material_import_settings/materials_filename");
        let is_materials = materials.and_then(Value::as_str).is_some_and(|name| resolve(&folder.join(name)) == found);
        found.exists() && (is_mesh || is_materials || resolve(self.document.path()) == found)
    }

    /// The member `key` of an object.
    pub fn child(&self, key: &str) -> Option<Parameters> {
        let value = self.value.get(key)?.clone();
        Some(self.at(&key.replace('~', "~0").replace('/', "~1"), value))
    }

    /// The entries of a list; empty for anything else.
    pub fn entries(&self) -> Vec<Parameters> {
        let list = self.value.as_array().map_or(&[][..], Vec::as_slice);
        list.iter().enumerate().map(|(i, value)| self.at(&i.to_string(), value.clone())).collect()
    }

    /// Members of an object in alphabetical order, which is the order in which Kratos visits them.
    pub fn members(&self) -> Vec<(String, Parameters)> {
        let mut keys: Vec<&String> = self.value.as_object().map(|o| o.keys().collect()).unwrap_or_default();
        keys.sort();
        keys.into_iter().filter_map(|key| Some((key.clone(), self.child(key)?))).collect()
    }

    /// The same place with another value (a filled-in default, for example).
    pub(crate) fn at(&self, key: &str, value: Value) -> Parameters {
        Parameters { document: self.document.clone(), pointer: format!("{}/{key}", self.pointer), value }
    }

    /// The same without what stands at a pointer below it, if anything does.
    #[must_use]
    pub fn without(mut self, below: &str) -> Parameters {
        let Some((object, key)) = below.rsplit_once('/') else { return self };
        if let Some(Value::Object(members)) = self.value.pointer_mut(object) {
            members.shift_remove(&key.replace("~1", "/").replace("~0", "~"));
        }
        self
    }

    /// The entries of a list.
    ///
    /// # Errors
    /// It is something else.
    pub fn list(&self) -> Result<Vec<Parameters>, InputErrors> {
        match self.value {
            Value::Array(_) => Ok(self.entries()),
            _ => Err(self.error(format!("is {}, must be a list", describe(&self.value))).into()),
        }
    }

    /// The members of an object in alphabetical order.
    ///
    /// # Errors
    /// It is something else.
    pub fn object(&self) -> Result<Vec<(String, Parameters)>, InputErrors> {
        match self.value {
            Value::Object(_) => Ok(self.members()),
            _ => Err(self.error(format!("is {}, must be an object", describe(&self.value))).into()),
        }
    }

    /// An error at this place.
    pub fn error(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::error(self.place(), message)
    }

    /// A warning at this place.
    pub fn warning(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::warning(self.place(), message)
    }

    /// Checks this object against a table of keys and fills in defaults.
    ///
    /// # Errors
    /// Unknown keys, missing required keys, wrong kinds, values out of range: all together.
    pub fn read(&self, keys: &'static [Key]) -> Result<Settings, InputErrors> {
        Settings::read(self, keys)
    }

    /// The text of a required member.
    ///
    /// # Errors
    /// It is missing or no text.
    pub fn text(&self, key: &str) -> Result<String, InputErrors> {
        if !self.value.is_object() {
            return Err(self.error(format!("is {}, must be an object", describe(&self.value))).into());
        }
        let child = self.child(key).ok_or_else(|| self.error(format!("{key:?} is missing")))?;
        match child.value.as_str() {
            Some(text) => Ok(text.into()),
            None => Err(child.error(format!("is {}, must be a text", describe(&child.value))).into()),
        }
    }
}

/// How a value is named in messages: `the text "abc"`, `the number 3`.
pub(crate) fn describe(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(b) => format!("{b}"),
        Value::Number(n) => format!("the number {n}"),
        Value::String(s) => format!("the text {s:?}"),
        Value::Array(list) if list.len() <= 3 && list.iter().all(|entry| !entry.is_array() && !entry.is_object()) => {
            let entries: Vec<String> = list.iter().map(Value::to_string).collect();
            format!("the list [{}]", entries.join(", "))
        }
        Value::Array(list) => format!("a list of {}", list.len()),
        Value::Object(_) => "an object".into(),
    }
}
