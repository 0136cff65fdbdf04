//! The JSON Schema of a whole project, made of the tables of keys of all registered components.

use super::project::{LEGACY_LISTS, PROBLEM_DATA, WITHOUT_EFFECT};
use super::restart::{NAME, RESTART};
use crate::parameters::schema::object;
use crate::parameters::{Key, Kind};
use crate::registry::Registry;
use serde_json::{Map, Value, json};

const PROJECT: &[Key] = &[
    Key::required("problem_data", Kind::Object(PROBLEM_DATA), "times and names"),
    Key::required("solver_settings", Kind::Any, "the solver, by its solver_type"),
    Key::new("modelers", Kind::List, "[]", "objects of name and parameters, run in their order before the solver"),
    Key::new("processes", Kind::Any, "{}", "lists of objects of python_module and Parameters, run in their order"),
    Key::new("output_processes", Kind::Any, "{}", "the same for processes that write files"),
    Key::optional(NAME, Kind::Object(RESTART), "checkpoints"),
    Key::new("kratos_exact", Kind::Bool, "false", "reproduce Kratos 10.4.4 to round-off, its faults included"),
];

/// The members of a project, for documents.
pub fn project_keys() -> &'static [Key] {
    PROJECT
}

/// The schema of `ProjectParameters.json` for the components of this registry.
pub fn project_schema(registry: &Registry) -> Value {
    let mut definitions = Map::new();
    let solvers = registry.solvers().iter().map(|entry| {
        definitions.insert(entry.types[0].into(), object(entry.keys));
        (spellings(entry.types), json!({"enum": spellings(entry.types)}), entry.types[0])
    });
    let solver = by_name("solver_type", solvers);
    let processes = registry.processes().iter().map(|entry| {
        definitions.insert(entry.name.into(), block("Parameters", entry.keys, entry.help));
        let names: Vec<&str> = std::iter::once(entry.name).chain(entry.aliases.iter().copied()).collect();
        (vec![entry.name.to_string()], ends_in(&names), entry.name)
    });
    let process = by_name("python_module", processes);
    let modelers = registry.modelers().iter().map(|entry| {
        definitions.insert(entry.name.into(), block("parameters", entry.keys, entry.help));
        (vec![format!("Modelers.Bia.{}", entry.name)], ends_in(&[entry.name]), entry.name)
    });
    let modeler = by_name("name", modelers);
    definitions.insert("solver_settings".into(), solver);
    definitions.insert("process".into(), process);
    definitions.insert("modeler".into(), modeler);
    let blocks = json!({"type": "array", "items": reference("process")});
    let lists = json!({"type": "object", "additionalProperties": blocks});
    let mut properties = json!({
        "$schema": {"type": "string", "description": "where this schema lies, for editors"},
        "problem_data": object(PROBLEM_DATA),
        "solver_settings": reference("solver_settings"),
        "modelers": {"type": "array", "items": reference("modeler")},
        "processes": lists,
        "output_processes": lists,
        NAME: object(RESTART),
        "analysis_stage": {"type": "string"},
        "kratos_exact": {"type": "boolean", "default": false,
                         "description": "reproduce Kratos 10.4.4 to round-off, its faults included"},
    });
    for name in LEGACY_LISTS {
        properties[*name] = blocks.clone();
    }
    for name in WITHOUT_EFFECT {
        properties[*name] = json!({"deprecated": true, "description": "has no effect in Bia"});
    }
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Project of Bia",
        "type": "object",
        "required": ["problem_data", "solver_settings"],
        "properties": properties,
        "$defs": definitions,
    })
}

fn reference(name: &str) -> Value {
    json!({"$ref": format!("#/$defs/{name}")})
}

/// A block whose settings stand in a member of their own.
fn block(member: &str, keys: &[Key], help: &str) -> Value {
    json!({"description": help, "properties": {member: object(keys)}, "required": [member]})
}

/// A name, also behind the names of modules.
fn ends_in(names: &[&str]) -> Value {
    json!({"pattern": format!("(^|\\.)({})$", names.join("|"))})
}

/// An object whose other members depend on the text `key`: of each component the names to suggest,
/// the condition that chooses it, and its definition.
fn by_name<'a>(key: &str, entries: impl Iterator<Item = (Vec<String>, Value, &'a str)>) -> Value {
    let (mut names, mut rules, mut conditions) = (Vec::new(), Vec::new(), Vec::new());
    for (of_entry, condition, definition) in entries {
        let chosen = json!({"properties": {key: condition}, "required": [key]});
        rules.push(json!({"if": chosen, "then": reference(definition)}));
        conditions.push(condition);
        names.extend(of_entry);
    }
    let key_schema = json!({"type": "string", "examples": names, "anyOf": conditions});
    json!({"type": "object", "properties": {key: key_schema}, "allOf": rules})
}

/// A solver type as Kratos's projects spell it: case, `-` and `_` make no difference.
fn spellings(types: &[&str]) -> Vec<String> {
    let capital = |word: &str| {
        let mut letters = word.chars();
        letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect::<String>())
    };
    let mut all = Vec::new();
    for name in types {
        let capitals: Vec<String> = name.split('_').map(capital).collect();
        all.extend([name.to_string(), name.replace('_', "-"), capitals.join("_"), capitals.join("-")]);
        all.extend([capital(name), capital(&name.replace('_', "-"))]);
    }
    all.sort();
    all.dedup();
    all
}
