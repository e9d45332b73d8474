//! Values of controls, read from the entries of nodes.

use super::place::{Place, entries};
use crate::document::control::{ControlKind, Value};
use crate::document::text::literals;
use crate::document::tree::nodes::texture_node;
use crate::language::Values;
use crate::language::read::colours::srgb;
use crate::language::tree::{self, Entry, Node};

/// Value at a place: `None` if nothing is there, `Some(None)` if it cannot be read.
pub(super) fn given(node: &Node<'static>, place: &Place, kind: &ControlKind) -> Option<Option<Value>> {
    if let Place::Texture(owner) = place {
        return texture_node(node, owner).map(|node| Some(Value::Text(node.name.value.to_string())));
    }
    let entries = entries(node, place);
    (!entries.is_empty()).then(|| read(&entries, kind))
}

/// Value of the formulas at a place.
pub(super) fn evaluated(node: &Node<'static>, place: &Place, kind: &ControlKind, values: &Values) -> Option<Value> {
    let numbers: Option<Vec<f32>> = entries(node, place).iter().map(|entry| number(entry, values)).collect();
    plain(&numbers?, kind)
}

/// Numbers as the value of a control.
fn plain(numbers: &[f32], kind: &ControlKind) -> Option<Value> {
    match (kind, numbers) {
        (ControlKind::Number(_), [number]) => Some(Value::Number(*number)),
        (ControlKind::Triple { .. }, [x, y, z]) => Some(Value::Triple([*x, *y, *z])),
        (ControlKind::Colour { .. }, [grey]) => Some(Value::Colour([*grey; 3])),
        (ControlKind::Colour { .. }, [r, g, b]) => Some(Value::Colour([*r, *g, *b])),
        (ControlKind::Size { .. }, [width, height]) => Some(Value::Size([*width as u32, *height as u32])),
        _ => None,
    }
}

fn read(entries: &[&Entry], kind: &ControlKind) -> Option<Value> {
    let numbers: Option<Vec<f32>> = entries.iter().map(|entry| read_number(entry)).collect();
    if let Some(value) = numbers.and_then(|numbers| plain(&numbers, kind)) {
        return Some(value);
    }
    let text = match entries.first().map(|entry| &entry.value) {
        Some(tree::Value::Text(text)) if entries.len() == 1 => Some(text.to_string()),
        _ => None,
    };
    match kind {
        ControlKind::Colour { .. } if text.as_ref().is_some_and(|text| text.starts_with('#')) => {
            text.and_then(|text| srgb(&text)).map(Value::Colour)
        }
        ControlKind::Number(_) | ControlKind::Triple { .. } | ControlKind::Colour { .. } | ControlKind::Size { .. } => {
            let texts: Vec<String> = entries.iter().map(|entry| formula_text(entry)).collect::<Option<_>>()?;
            // There must be as many formulas as there would be numbers.
            plain(&vec![0.0; texts.len()], kind).map(|_| Value::Formulas(texts))
        }
        ControlKind::Flag => match entries.first()?.value {
            tree::Value::Bool(value) => Some(Value::Flag(value)),
            _ => None,
        },
        ControlKind::Text | ControlKind::Picture | ControlKind::Choice(_) | ControlKind::Material(_) => {
            text.map(Value::Text)
        }
    }
}

/// Text of a number or a formula.
pub(crate) fn formula_text(entry: &Entry) -> Option<String> {
    match &entry.value {
        tree::Value::Number(_) => read_number(entry).map(literals::number),
        tree::Value::Text(text) => Some(text.to_string()),
        _ => None,
    }
}

/// Finite number of an entry that is not a formula.
pub(crate) fn read_number(entry: &Entry) -> Option<f32> {
    match entry.value {
        tree::Value::Number(number) => Some(number as f32).filter(|number| number.is_finite()),
        _ => None,
    }
}

/// Number of an entry, or value of its formula.
pub(super) fn number(entry: &Entry, values: &Values) -> Option<f32> {
    match entry.value {
        tree::Value::Text(_) => values.formulas.get(&entry.value_span.start).map(|value| *value as f32),
        _ => read_number(entry),
    }
}
