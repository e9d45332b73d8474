//! Controls of nodes as JSON.

use pathmarch_render::pathmarch_scene::document::{Control, ControlKind, Item, Value};
use serde::Serialize;
use serde_json::{Value as Json, json};

/// Node of the outline.
#[derive(Serialize)]
pub(crate) struct Node<'a> {
    path: &'a [usize],
    kind: String,
    word: &'a str,
    title: &'a str,
    children: Vec<Node<'a>>,
}

impl<'a> From<&'a Item> for Node<'a> {
    fn from(item: &'a Item) -> Self {
        let children = item.children.iter().map(Self::from).collect();
        let kind = format!("{:?}", item.kind).to_lowercase();
        Self { path: item.path.indexes(), kind, word: &item.word, title: item.title(), children }
    }
}

/// A control: its type, range and value.
pub(crate) fn control(control: &Control) -> Json {
    let Control { key, label, doc, unit, kind, value, present, given, required, initial, .. } = control;
    json!({
        "key": key, "label": label, "doc": doc, "unit": unit, "kind": kind_json(kind), "value": value_json(value),
        "present": value_json(present), "initial": value_json(initial), "given": given, "required": required,
    })
}

fn kind_json(kind: &ControlKind) -> Json {
    match kind {
        ControlKind::Number(range) => json!({
            "type": "number", "soft": [range.soft.0, range.soft.1], "whole": range.whole,
            "logarithmic": range.logarithmic, "words": range.in_words(),
        }),
        ControlKind::Triple { direction } => json!({ "type": "triple", "direction": direction }),
        ControlKind::Colour { max } => json!({ "type": "colour", "max": max }),
        ControlKind::Choice(choices) => json!({ "type": "choice", "choices": choices }),
        ControlKind::Text => json!({ "type": "text" }),
        ControlKind::Picture => json!({ "type": "picture" }),
        ControlKind::Flag => json!({ "type": "flag" }),
        ControlKind::Material(names) => json!({ "type": "material", "choices": names }),
        ControlKind::Size { min, max } => json!({ "type": "size", "min": min, "max": max }),
    }
}

fn value_json(value: &Value) -> Json {
    match value {
        Value::None => Json::Null,
        Value::Number(number) => json!(number),
        Value::Triple(numbers) | Value::Colour(numbers) => json!(numbers),
        Value::Size(size) => json!(size),
        Value::Text(text) => json!(text),
        Value::Flag(flag) => json!(flag),
        Value::Formulas(formulas) => json!({ "formulas": formulas }),
    }
}

/// Value of a control from JSON; `None` if it is of another type.
pub(crate) fn value(kind: &ControlKind, json: &Json) -> Option<Value> {
    if json.is_null() {
        return Some(Value::None);
    }
    if let Some(formulas) = json.get("formulas") {
        return serde_json::from_value(formulas.clone()).ok().map(Value::Formulas);
    }
    let triple = || serde_json::from_value::<[f32; 3]>(json.clone()).ok();
    match kind {
        ControlKind::Number(_) => json.as_f64().map(|number| Value::Number(number as f32)),
        ControlKind::Triple { .. } => triple().map(Value::Triple),
        ControlKind::Colour { .. } => triple().map(Value::Colour),
        ControlKind::Flag => json.as_bool().map(Value::Flag),
        ControlKind::Size { .. } => serde_json::from_value(json.clone()).ok().map(Value::Size),
        ControlKind::Choice(_) | ControlKind::Text | ControlKind::Picture | ControlKind::Material(_) => {
            json.as_str().map(|text| Value::Text(text.to_owned()))
        }
    }
}
