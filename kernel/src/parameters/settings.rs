//! Checked settings with their defaults filled in.

use super::{Default, Key, Kind, Parameters, describe};
use crate::diagnostic::{Diagnostic, InputErrors, nearest};
use serde_json::Value;
use std::collections::BTreeMap;

/// The values of a component's keys, each of the declared kind.
///
/// The getters take the name of a declared key; asking for another one is a fault of the
/// component, not of the input, and stops the program.
#[derive(Debug, Clone)]
pub struct Settings {
    parameters: Parameters,
    values: BTreeMap<&'static str, Entry>,
}

#[derive(Debug, Clone)]
struct Entry {
    parameters: Parameters,
    given: bool,
    nested: Option<Settings>,
}

impl Settings {
    pub(super) fn read(parameters: &Parameters, keys: &'static [Key]) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let Some(object) = parameters.value().as_object() else {
            return Err(parameters.error(format!("is {}, must be an object", describe(parameters.value()))).into());
        };
        for name in object.keys().filter(|name| !keys.iter().any(|key| key.is(name))) {
            let place = parameters.child(name).unwrap_or_else(|| parameters.clone());
            let allowed = keys.iter().map(|key| key.name);
            errors.push(place.error(format!("the key {name:?} is unknown")).allowed(name, allowed));
        }
        let mut values = BTreeMap::new();
        for key in keys {
            if let Some(entry) = read_key(parameters, key, &mut errors) {
                values.insert(key.name, entry);
            }
        }
        errors.or(Self { parameters: parameters.clone(), values })
    }

    fn entry(&self, key: &str) -> Option<&Entry> {
        self.values.get(key)
    }

    fn value(&self, key: &str) -> &Value {
        match self.entry(key) {
            Some(entry) => entry.parameters.value(),
            None => panic!("a component asks for the key {key:?}, which it has not declared with a default"),
        }
    }

    /// The object these settings were read from.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Whether the user gave the key.
    pub fn given(&self, key: &str) -> bool {
        self.entry(key).is_some_and(|entry| entry.given)
    }

    /// The member with its place, given or default.
    pub fn get(&self, key: &str) -> Option<&Parameters> {
        self.entry(key).map(|entry| &entry.parameters)
    }

    /// An error at a member (or at the object, if it is not there).
    pub fn error(&self, key: &str, message: impl Into<String>) -> Diagnostic {
        self.get(key).unwrap_or(&self.parameters).error(message)
    }

    /// A boolean.
    pub fn flag(&self, key: &str) -> bool {
        self.value(key).as_bool().unwrap_or(false)
    }

    /// A real number.
    pub fn number(&self, key: &str) -> f64 {
        self.value(key).as_f64().unwrap_or(0.0)
    }

    /// A whole number.
    pub fn integer(&self, key: &str) -> i64 {
        self.value(key).as_i64().unwrap_or(0)
    }

    /// A text.
    pub fn text(&self, key: &str) -> &str {
        self.value(key).as_str().unwrap_or("")
    }

    /// A list of texts.
    pub fn texts(&self, key: &str) -> Vec<String> {
        let list = self.value(key).as_array().map_or(&[][..], Vec::as_slice);
        list.iter().filter_map(|v| v.as_str().map(str::to_owned)).collect()
    }

    /// Three numbers.
    pub fn vector(&self, key: &str) -> [f64; 3] {
        let list = self.value(key).as_array().map_or(&[][..], Vec::as_slice);
        std::array::from_fn(|i| list.get(i).and_then(Value::as_f64).unwrap_or(0.0))
    }

    /// Three booleans; a single one counts for all.
    pub fn flags(&self, key: &str) -> [bool; 3] {
        match self.value(key) {
            Value::Bool(b) => [*b; 3],
            other => std::array::from_fn(|i| other.get(i).and_then(Value::as_bool).unwrap_or(false)),
        }
    }

    /// Start and end of an interval in seconds.
    pub fn interval(&self, key: &str) -> [f64; 2] {
        let list = self.value(key);
        let bound = |i: usize, open: f64| list.get(i).and_then(Value::as_f64).unwrap_or(open);
        [bound(0, 0.0), bound(1, 1e30)]
    }

    /// The settings of a nested object with declared keys.
    pub fn nested(&self, key: &str) -> Option<&Settings> {
        self.entry(key).and_then(|entry| entry.nested.as_ref())
    }
}

/// The entry of one key; none if it is absent or wrong (then an error was added).
fn read_key(parameters: &Parameters, key: &'static Key, errors: &mut InputErrors) -> Option<Entry> {
    let mut names = std::iter::once(&key.name).chain(key.aliases).filter(|name| parameters.child(name).is_some());
    let (first, second) = (names.next(), names.next());
    if let (Some(first), Some(second)) = (first, second) {
        let message = format!("{first:?} and its older name {second:?} are both given");
        errors.push(parameters.child(second).unwrap_or_else(|| parameters.clone()).error(message).help("keep one"));
    }
    let given = first.and_then(|name| parameters.child(name));
    let (value, given) = match (given, key.default) {
        (Some(value), _) => (value, true),
        (None, Default::Absent) => return None,
        (None, Default::Required) => {
            errors.push(
                parameters
                    .error(format!("the key {:?} is missing", key.name))
                    .help(format!("{}: {}", key.name, key.help)),
            );
            return None;
        }
        (None, Default::Json(text)) => {
            let value = serde_json::from_str(text).unwrap_or(Value::Null);
            (parameters.at(key.name, value), false)
        }
    };
    let mut nested = None;
    if let Kind::Object(keys) = key.kind {
        nested = errors.absorb(Settings::read(&value, keys));
        nested.as_ref()?;
    } else if given && let Err(expected) = check(&key.kind, value.value()) {
        let found = describe(value.value());
        let mut diagnostic = value.error(format!("is {found}, must be {expected}"));
        diagnostic = match (key.kind, value.value().as_str()) {
            // The message lists them.
            (Kind::Choice(names), Some(text)) => match nearest(text, names.iter().copied()) {
                Some(near) => diagnostic.help(format!("did you mean {near:?}?")),
                None => diagnostic.help(format!("{}: {}", key.name, key.help)),
            },
            _ => diagnostic.help(format!("{}: {}", key.name, key.help)),
        };
        errors.push(diagnostic);
        return None;
    }
    Some(Entry { parameters: value, given, nested })
}

/// `Err` names what would be right.
fn check(kind: &Kind, value: &Value) -> Result<(), String> {
    // An object may name a csv table; whoever reads the value checks it.
    let is_function = |v: &Value| v.is_number() || v.is_string() || v.is_object();
    let list = value.as_array().map_or(&[][..], Vec::as_slice);
    let fits = match kind {
        Kind::Bool => value.is_boolean(),
        Kind::Integer { min } => value.as_i64().is_some_and(|i| i >= *min),
        Kind::Number(range) => value.as_f64().is_some_and(|x| range.contains(x)),
        Kind::NumberOr(range, names) => {
            value.as_f64().is_some_and(|x| range.contains(x))
                || value.as_str().is_some_and(|text| names.contains(&text))
        }
        Kind::Text => value.is_string(),
        Kind::Choice(names) => value.as_str().is_some_and(|text| names.contains(&text)),
        Kind::Vector3 => list.len() == 3 && list.iter().all(Value::is_number),
        Kind::Interval => {
            list.len() == 2 && list[0].is_number() && (list[1].is_number() || list[1] == "End") && {
                let end = list[1].as_f64().unwrap_or(f64::INFINITY);
                list[0].as_f64().is_some_and(|start| start <= end)
            }
        }
        Kind::Function => is_function(value),
        Kind::Functions3 => list.len() == 3 && list.iter().all(|v| v.is_null() || is_function(v)),
        Kind::Bools3 => value.is_boolean() || list.len() == 3 && list.iter().all(Value::is_boolean),
        Kind::Texts => value.is_array() && list.iter().all(Value::is_string),
        Kind::List => value.is_array(),
        Kind::Object(_) => value.is_object(),
        Kind::Any => true,
    };
    if fits { Ok(()) } else { Err(expected(kind)) }
}

fn expected(kind: &Kind) -> String {
    match kind {
        Kind::Bool => "true or false".into(),
        Kind::Integer { min: i64::MIN } => "a whole number".into(),
        Kind::Integer { min } => format!("a whole number of at least {min}"),
        Kind::Number(range) => range.text.into(),
        Kind::NumberOr(range, names) => {
            let names: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
            format!("{} or {}", range.text, names.join(" or "))
        }
        Kind::Text => "a text".into(),
        Kind::Choice(names) => format!("one of {}", names.join(", ")),
        Kind::Vector3 => "a list of three numbers".into(),
        Kind::Interval => "[start, end] with start <= end, where end may be \"End\"".into(),
        Kind::Function => "a number or a function of x, y, z, X, Y, Z, t as text".into(),
        Kind::Functions3 => "a list of three, each a number, a function of x, y, z, t as text, or null".into(),
        Kind::Bools3 => "true, false or a list of three of them".into(),
        Kind::Texts => "a list of texts".into(),
        Kind::List => "a list".into(),
        Kind::Object(_) => "an object".into(),
        Kind::Any => "any value".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Document, Range};
    use super::*;
    use std::path::Path;

    const INNER: &[Key] = &[Key::new("depth", Kind::Integer { min: 0 }, "3", "how deep")];
    const KEYS: &[Key] = &[
        Key::required("name", Kind::Text, "its name"),
        Key::new("time_step", Kind::Number(Range::POSITIVE), "0.1", "step [s]").or(&["dt"]),
        Key::new("mode", Kind::Choice(&["slow", "fast"]), "\"slow\"", "how"),
        Key::new("interval", Kind::Interval, "[0.0, \"End\"]", "when [s]"),
        Key::new("inner", Kind::Object(INNER), "{}", "nested"),
    ];

    fn read(text: &str) -> Result<Settings, InputErrors> {
        Parameters::root(Document::parse(Path::new("p.json"), text.into()).unwrap()).read(KEYS)
    }

    #[test]
    fn defaults_are_filled_and_old_names_accepted() {
        let settings = read(r#"{"name": "a", "dt": 2}"#).unwrap();
        assert_eq!(settings.number("time_step"), 2.0);
        assert_eq!(settings.text("mode"), "slow");
        assert_eq!(settings.interval("interval"), [0.0, 1e30]);
        assert_eq!(settings.nested("inner").unwrap().integer("depth"), 3);
        assert!(settings.given("time_step") && !settings.given("mode"));
    }

    #[test]
    fn all_faults_come_together_with_place_and_near_name() {
        let text = "{\n\"time_stp\": 1,\n\"time_step\": -1,\n\"mode\": \"fst\",\n\"inner\": {\"depht\": 1},\n\"interval\": [2, 1]}";
        let errors = read(text).unwrap_err();
        let all = errors.to_string();
        assert_eq!(errors.0.len(), 6, "{all}");
        for part in [
            "p.json:2:13 at /time_stp: the key \"time_stp\" is unknown",
            "did you mean \"time_step\"?",
            "the key \"name\" is missing",
            "p.json:3:14 at /time_step: is the number -1, must be a number above 0",
            "did you mean \"fast\"?",
            "/inner/depht",
            "start <= end",
        ] {
            assert!(all.contains(part), "{part:?} is not in\n{all}");
        }
    }
}
