//! Tables of keys as JSON Schema (draft 2020-12), so that editors complete and check input files.

use super::{Default, Key, Kind, Range};
use serde_json::{Map, Value, json};

/// The schema of an object with these keys and no others.
pub fn object(keys: &[Key]) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for key in keys {
        let schema = of_key(key);
        for alias in key.aliases {
            let mut old = schema.clone();
            old["deprecated"] = true.into();
            old["description"] = format!("older name of {}", key.name).into();
            properties.insert((*alias).into(), old);
        }
        properties.insert(key.name.into(), schema);
        // Where an older name may stand, the checks of Bia alone can tell that neither does.
        if matches!(key.default, Default::Required) && key.aliases.is_empty() {
            required.push(key.name);
        }
    }
    json!({"type": "object", "properties": properties, "required": required, "additionalProperties": false})
}

fn of_key(key: &Key) -> Value {
    let mut schema = of_kind(key.kind);
    schema["description"] = key.help.into();
    if let Default::Json(text) = key.default
        && let Ok(value) = serde_json::from_str::<Value>(text)
    {
        schema["default"] = value;
    }
    schema
}

fn number(range: Range) -> Value {
    let mut schema = json!({"type": "number"});
    if range.low.is_finite() {
        schema[if range.low_open { "exclusiveMinimum" } else { "minimum" }] = range.low.into();
    }
    if range.high.is_finite() {
        schema["maximum"] = range.high.into();
    }
    schema
}

fn of_kind(kind: Kind) -> Value {
    let three = |items: Value| json!({"type": "array", "items": items, "minItems": 3, "maxItems": 3});
    match kind {
        Kind::Bool => json!({"type": "boolean"}),
        Kind::Integer { min } => json!({"type": "integer", "minimum": min}),
        Kind::Number(range) => number(range),
        Kind::NumberOr(range, words) => json!({"anyOf": [number(range), {"enum": words}]}),
        Kind::Text => json!({"type": "string"}),
        Kind::Choice(words) => json!({"type": "string", "enum": words}),
        Kind::Vector3 => three(json!({"type": "number"})),
        Kind::Interval => json!({"type": "array", "minItems": 2, "maxItems": 2,
                                 "items": {"anyOf": [{"type": "number"}, {"type": "string"}]}}),
        Kind::Function => json!({"type": ["number", "string"]}),
        Kind::Functions3 => three(json!({"type": ["number", "string", "null"]})),
        Kind::Bools3 => json!({"anyOf": [{"type": "boolean"}, three(json!({"type": "boolean"}))]}),
        Kind::Texts => json!({"type": "array", "items": {"type": "string"}}),
        Kind::List => json!({"type": "array"}),
        Kind::Object(keys) => object(keys),
        Kind::Any => json!({}),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_ranges_defaults_and_old_names_are_told() {
        const INNER: &[Key] = &[Key::required("step", Kind::Number(Range::POSITIVE), "time step [s]")];
        const KEYS: &[Key] = &[
            Key::required("size", Kind::Integer { min: 1 }, "dimension"),
            Key::new("alpha", Kind::Number(Range::FRACTION), "0.5", "blend").or(&["old_alpha"]),
            Key::new("stepping", Kind::Object(INNER), "{}", "steps"),
        ];
        let schema = object(KEYS);
        assert_eq!(schema["required"], json!(["size"]));
        assert_eq!(schema["properties"]["alpha"]["default"], 0.5);
        assert_eq!(schema["properties"]["alpha"]["maximum"], 1.0);
        assert_eq!(schema["properties"]["old_alpha"]["deprecated"], true);
        let step = &schema["properties"]["stepping"]["properties"]["step"];
        assert_eq!((&step["exclusiveMinimum"], &step["description"]), (&json!(0.0), &json!("time step [s]")));
        assert_eq!(schema["additionalProperties"], false);
    }
}
