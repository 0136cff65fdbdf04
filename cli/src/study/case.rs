//! One project with what is changed in it: what a study or a survey runs.

use bia_kernel::diagnostic::{Diagnostic, InputErrors, nearest};
use bia_kernel::parameters::{Document, Parameters, Settings};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// A run that is wanted.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name, unique in the study: `MPM USL, n=8`.
    pub name: String,
    /// The project.
    pub project: PathBuf,
    /// What is changed in it: pointer and value, in this order.
    pub set: Vec<(String, Value)>,
    /// Threads.
    pub threads: usize,
    /// Wall time after which it is ended, in seconds.
    pub time_limit: f64,
    /// The project as it is run, and check sums of the files that it names.
    pub inputs: Value,
}

/// Where what is set comes from: the objects `set`, and the values for `${name}` in them.
#[derive(Debug, Clone, Default)]
pub struct Changes {
    /// Pointers and what is set there, in the order in which they act.
    set: Vec<(String, Parameters)>,
    values: Map<String, Value>,
}

impl Changes {
    /// These with those of one more object, whose values come first.
    ///
    /// # Errors
    /// `set` or `values` that are no objects, pointers that are none.
    pub fn with(&self, settings: &Settings) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let mut changes = self.clone();
        for (name, value) in settings.get("values").map_or(Ok(Vec::new()), Parameters::object)? {
            match value.value() {
                Value::Number(_) | Value::String(_) | Value::Bool(_) => {
                    changes.values.insert(name, value.value().clone());
                }
                _ => errors.push(value.error("must be a number, a text, true or false")),
            }
        }
        for (pointer, value) in settings.get("set").map_or(Ok(Vec::new()), in_order)? {
            if !pointer.starts_with('/') {
                let help = "a pointer looks like /solver_settings/time_stepping/time_step";
                errors.push(value.error(format!("{pointer:?} is no JSON pointer")).help(help));
            }
            changes.add(pointer, value);
        }
        errors.or(changes)
    }

    /// These, and then others.
    #[must_use]
    pub fn then(mut self, others: &Self) -> Self {
        self.values.extend(others.values.clone());
        others.set.iter().for_each(|(pointer, value)| self.add(pointer.clone(), value.clone()));
        self
    }

    /// These without what is set at such pointers.
    #[must_use]
    pub fn without(&self, is_left_out: impl Fn(&str) -> bool) -> Self {
        let set = self.set.iter().filter(|(pointer, _)| !is_left_out(pointer)).cloned().collect();
        Self { set, values: self.values.clone() }
    }

    /// Whether it sets something at a pointer.
    pub fn sets(&self, pointer: &str) -> bool {
        self.set.iter().any(|(own, _)| own == pointer)
    }

    /// Adds one more, behind which what was set there or within has no effect.
    fn add(&mut self, pointer: String, value: Parameters) {
        if !pointer.ends_with("/-") {
            let is_within =
                |own: &str| own.strip_prefix(&pointer).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
            self.set.retain(|(own, _)| !is_within(own));
        }
        self.set.push((pointer, value));
    }

    /// Pointers and values in their order, with the names replaced.
    ///
    /// # Errors
    /// Names that have no value.
    pub fn resolve(&self) -> Result<Vec<(String, Value, Parameters)>, InputErrors> {
        let mut errors = InputErrors::default();
        let mut list = Vec::new();
        for (pointer, place) in &self.set {
            match self.replace(place.value()) {
                Ok(value) => list.push((pointer.clone(), value, place.clone())),
                Err(name) => {
                    let diagnostic = place.error(format!("${{{name}}} has no value"));
                    errors.push(diagnostic.allowed(&name, self.values.keys().map(String::as_str)));
                }
            }
        }
        errors.or(list)
    }

    /// The value with all `${name}` replaced; `Err` holds a name without value. A text that is one name
    /// alone becomes its value, a number say.
    fn replace(&self, value: &Value) -> Result<Value, String> {
        match value {
            Value::String(text) => self.replace_in(text),
            Value::Array(list) => list.iter().map(|entry| self.replace(entry)).collect(),
            Value::Object(members) => {
                let replaced = members.iter().map(|(key, value)| Ok((key.clone(), self.replace(value)?)));
                Ok(Value::Object(replaced.collect::<Result<_, String>>()?))
            }
            other => Ok(other.clone()),
        }
    }

    fn replace_in(&self, text: &str) -> Result<Value, String> {
        let (mut out, mut rest) = (String::new(), text);
        while let Some((before, behind)) = rest.split_once("${") {
            let Some((name, after)) = behind.split_once('}') else { break };
            let value = self.values.get(name).ok_or_else(|| name.to_string())?;
            if before.is_empty() && after.is_empty() && out.is_empty() {
                return Ok(value.clone());
            }
            out += before;
            match value {
                Value::String(text) => out += text,
                other => out += &other.to_string(),
            }
            rest = after;
        }
        Ok(Value::String(out + rest))
    }
}

/// Members of an object in the order of the file, which is that in which they act.
///
/// # Errors
/// It is no object.
pub fn in_order(object: &Parameters) -> Result<Vec<(String, Parameters)>, InputErrors> {
    object.object()?;
    let keys = object.value().as_object().map(|members| members.keys().cloned().collect::<Vec<_>>());
    let place = |key: String| object.child(&key).map(|value| (key, value));
    Ok(keys.unwrap_or_default().into_iter().filter_map(place).collect())
}

impl Case {
    /// The case of this project with these changes.
    ///
    /// # Errors
    /// A project that cannot be read, pointers that lead nowhere, each with its place in the study.
    pub fn new(
        name: String,
        project: PathBuf,
        changes: &Changes,
        threads: usize,
        time_limit: f64,
    ) -> Result<Self, InputErrors> {
        let mut document = Document::read(&project)?;
        let mut errors = InputErrors::default();
        let mut set = Vec::new();
        for (pointer, value, place) in changes.resolve()? {
            if let Err(wrong) = document.set(&pointer, &value.to_string()) {
                for fault in wrong.0 {
                    let message = format!("{pointer} of {}: {}", project.display(), fault.message);
                    let near = nearest_member(document.root(), &pointer);
                    errors.push(with_help(place.error(message), near.or(fault.help)));
                }
            }
            set.push((pointer, value));
        }
        errors.or(())?;
        let folder = project.parent().unwrap_or_else(|| Path::new(""));
        let mut files = Map::new();
        add_files(folder, document.root(), &mut files);
        let inputs = json!({"project": document.root(), "files": files, "threads": threads});
        Ok(Self { name, project, set, threads, time_limit, inputs })
    }

    /// All of it for programs.
    pub fn json(&self) -> Value {
        let set: Vec<Value> = self.set.iter().map(|(pointer, value)| json!([pointer, value])).collect();
        json!({
            "name": self.name, "project": self.project, "set": set, "threads": self.threads,
            "time_limit": self.time_limit, "command": self.command(),
        })
    }

    /// The command that runs it, as a shell takes it.
    pub fn command(&self) -> String {
        let mut words = vec!["bia run".to_string(), quoted(&self.project.display().to_string())];
        words.push(format!("--threads {}", self.threads));
        words.extend(self.set.iter().map(|(pointer, value)| format!("--set {}", quoted(&assignment(pointer, value)))));
        words.join(" ")
    }

    /// Arguments of `--set`.
    pub fn assignments(&self) -> Vec<String> {
        self.set.iter().map(|(pointer, value)| assignment(pointer, value)).collect()
    }
}

fn assignment(pointer: &str, value: &Value) -> String {
    format!("{pointer}={value}")
}

/// A word for a shell.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/_-.=+,:@%".contains(c);
    match word.chars().all(is_plain) && !word.is_empty() {
        true => word.to_string(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

fn with_help(diagnostic: Diagnostic, help: Option<String>) -> Diagnostic {
    match help {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}

/// The name that was meant by the first part of a pointer that does not exist.
fn nearest_member(root: &Value, pointer: &str) -> Option<String> {
    let (mut value, mut so_far) = (root, String::new());
    for token in pointer.split('/').skip(1) {
        let next = value.pointer(&format!("/{token}"));
        if let Some(next) = next {
            value = next;
            so_far = format!("{so_far}/{token}");
            continue;
        }
        let names = value.as_object()?.keys().map(String::as_str);
        return nearest(token, names).map(|near| format!("did you mean {so_far}/{near}?"));
    }
    None
}

/// Check sums of the files beside the project that any text in it names, meshes without their extension
/// too, and tables that such a file names.
fn add_files(folder: &Path, value: &Value, files: &mut Map<String, Value>) {
    match value {
        Value::Object(members) => members.values().for_each(|value| add_files(folder, value, files)),
        Value::Array(list) => list.iter().for_each(|value| add_files(folder, value, files)),
        Value::String(name) if !name.is_empty() && name.len() < 256 => {
            for name in [name.clone(), format!("{name}.mdpa")] {
                let path = folder.join(&name);
                if !files.contains_key(&name)
                    && path.is_file()
                    && let Ok(bytes) = std::fs::read(&path)
                {
                    let sum = format!("CRC-32 {:08x}, {} bytes", crc32fast::hash(&bytes), bytes.len());
                    files.insert(name, sum.into());
                }
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changes(values: Value) -> Changes {
        Changes { set: Vec::new(), values: values.as_object().unwrap().clone() }
    }

    #[test]
    fn later_changes_replace_earlier_ones() {
        let of = |text: &str| {
            let root = Parameters::root(Document::parse(Path::new("s.json"), text.into()).unwrap());
            let keys: &[bia_kernel::parameters::Key] = super::super::keys::SWEEP;
            Changes::default().with(&root.read(keys).unwrap()).unwrap()
        };
        let shared = of(r#"{"label": "a", "set": {"/a": 1, "/b/0": 2, "/bc": 3, "/l/-": 4}, "values": {"n": 5}}"#);
        let own = of(r#"{"label": "b", "set": {"/b": [6], "/l/-": 7, "/a": "${n}"}}"#);
        let pointers = |changes: &Changes| -> Vec<(String, String)> {
            let list = changes.resolve().unwrap();
            list.into_iter().map(|(pointer, value, _)| (pointer, value.to_string())).collect()
        };
        let pair = |a: &str, b: &str| (a.to_string(), b.to_string());
        let both = shared.without(|pointer| pointer == "/bc").then(&own);
        assert_eq!(pointers(&both), [pair("/l/-", "4"), pair("/b", "[6]"), pair("/l/-", "7"), pair("/a", "5")]);
        assert!(both.sets("/b") && !both.sets("/b/0"));
    }

    #[test]
    fn names_become_values() {
        let changes = changes(json!({"n": 8, "law": "Neo"}));
        let replaced = changes.replace(&json!({"a": ["${n}", 1], "b": "x${n}y${law}", "c": "$n"})).unwrap();
        assert_eq!(replaced, json!({"a": [8, 1], "b": "x8yNeo", "c": "$n"}));
        assert_eq!(changes.replace(&json!("${m}")).unwrap_err(), "m");
    }

    #[test]
    fn words_are_safe_for_a_shell() {
        assert_eq!(quoted("/a/b=1.5"), "/a/b=1.5");
        assert_eq!(quoted("it's {x}"), "'it'\\''s {x}'");
    }

    #[test]
    fn the_meant_member_is_told() {
        let root = json!({"solver_settings": {"time_stepping": {"time_step": 1}}});
        let near = nearest_member(&root, "/solver_settings/time_steping/time_step");
        assert_eq!(near.as_deref(), Some("did you mean /solver_settings/time_stepping?"));
    }
}
