//! The JSON Schema of scenes and tasks, with which editors complete and explain keys: the [declaration](super::keys) of each key,
//! without the rules between keys, which only the reader knows.

use super::input::Kind;
use super::keys::{self, Key, KeyTable, Usual, Value};
use super::limits::Limits;
use serde_json::{Map, Value as Json, json};

/// A number with a unit starts like a number.
const QUANTITY: &str = r"^\s*[-+−]?[0-9.]";

/// The schema (draft 7) of scenes or of tasks.
pub fn schema(kind: Kind) -> Json {
    let (table, mut definitions) = (kind.keys(), Map::new());
    let mut root = object(table, &mut definitions);
    if kind == Kind::Scene {
        root["allOf"] = table.key("model").choices().iter().map(|names| of_model(table, names[0])).collect();
    }
    root["$schema"] = json!("http://json-schema.org/draft-07/schema#");
    root["title"] = json!(format!("camdrive: {}", table.title));
    root["definitions"] = Json::Object(definitions);
    root
}

/// The tables of a model, and the required ones.
fn of_model(table: &'static KeyTable, model: &str) -> Json {
    let limited = || table.all().filter(|key| !key.models.is_empty());
    let foreign = limited().filter(|key| !key.models.contains(&model)).map(|key| (key.key.to_owned(), json!(false)));
    // A train has a machine or a drive.
    let needed = limited().filter(|key| key.models.contains(&model) && is_required(key) && model != keys::TRAIN);
    json!({
        "if": { "properties": { "model": { "const": model } }, "required": ["model"] },
        "then": {
            "properties": foreign.collect::<Map<_, _>>(),
            "required": needed.map(|key| key.key).collect::<Vec<_>>(),
        },
    })
}

fn is_required(key: &Key) -> bool {
    matches!(key.usual, Usual::Required)
}

fn object(table: &'static KeyTable, definitions: &mut Map<String, Json>) -> Json {
    let required: Vec<&str> = table.all().filter(|k| is_required(k) && k.models.is_empty()).map(|k| k.key).collect();
    let mut properties = Map::new();
    for key in table.all() {
        let property = property(key, definitions);
        properties.entry(key.key).or_insert(property);
    }
    json!({ "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

/// A reference to the schema of a table, which occurs once.
fn reference(table: &'static KeyTable, definitions: &mut Map<String, Json>) -> Json {
    let name: String = table.title.chars().filter(|c| c.is_ascii_alphanumeric() || "._".contains(*c)).collect();
    if !definitions.contains_key(&name) {
        definitions.insert(name.clone(), Json::Null);
        let schema = object(table, definitions);
        definitions.insert(name.clone(), schema);
    }
    json!({ "$ref": format!("#/definitions/{name}") })
}

fn property(key: &Key, definitions: &mut Map<String, Json>) -> Json {
    let mut kinds: Vec<Json> = key.values.iter().filter_map(|value| of_value(*value, definitions)).collect();
    let mut schema = if kinds.len() == 1 { kinds.remove(0) } else { json!({ "anyOf": kinds }) };
    if schema.get("$ref").is_some() {
        // Keys next to a reference are ignored.
        schema = json!({ "allOf": [schema] });
    }
    schema["description"] = json!(key.described());
    match key.usual {
        Usual::Number(number) if matches!(key.values[0], Value::Count(..)) => schema["default"] = json!(number as u32),
        Usual::Number(number) => schema["default"] = json!(number),
        Usual::Name(name) => schema["default"] = json!(name),
        _ => {}
    }
    schema
}

fn number(limits: Limits) -> Json {
    let mut schema = json!({ "type": ["number", "string"], "pattern": QUANTITY });
    let [min, max] = limits.ends();
    if min.is_finite() {
        schema[if limits.is_open() { "exclusiveMinimum" } else { "minimum" }] = json!(min);
    }
    if max.is_finite() {
        schema["maximum"] = json!(max);
    }
    schema
}

/// Editors offer the first name of each; the other names are valid as well.
fn choice(names: &[&[&str]]) -> Json {
    let first: Vec<&str> = names.iter().map(|names| names[0]).collect();
    let others: Vec<String> = names.iter().flat_map(|names| &names[1..]).map(|name| name.replace('+', r"\+")).collect();
    match others.is_empty() {
        true => json!({ "enum": first }),
        false => {
            json!({ "anyOf": [{ "enum": first }, { "type": "string", "pattern": format!("^({})$", others.join("|")) }] })
        }
    }
}

fn of_value(value: Value, definitions: &mut Map<String, Json>) -> Option<Json> {
    let any = || json!({ "type": ["number", "string"], "pattern": QUANTITY });
    Some(match value {
        Value::Nothing => return None,
        Value::Real(_, limits) => number(limits),
        Value::Word(word) => json!({ "const": word }),
        Value::Reals(_) => json!({ "type": "array", "items": any() }),
        Value::Pairs => json!({
            "type": "array",
            "items": { "type": "array", "items": any(), "minItems": 2, "maxItems": 2 },
        }),
        Value::Count(min, max) => json!({ "type": "integer", "minimum": min, "maximum": max }),
        Value::Text => json!({ "type": "string" }),
        Value::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        Value::Values => json!({ "type": ["array", "number", "string", "boolean"] }),
        Value::Flag => json!({ "type": "boolean" }),
        Value::Choice(names) => choice(names),
        Value::Table(table) => reference(table, definitions),
        Value::Named(table) => json!({ "type": "object", "additionalProperties": reference(table, definitions) }),
        // Strict editors refuse keys that a schema does not allow.
        Value::Variables => json!({ "type": "object", "additionalProperties": true }),
        Value::Tables(table) => json!({ "type": "array", "items": reference(table, definitions) }),
    })
}
