//! Checks of values that controls are set to.

use crate::document::control::{ControlKind, Value};
use crate::document::error::EditError;
use crate::document::parameters::Parameter;
use crate::document::text::literals::number;
use crate::language::characters;
use crate::settings::Range;

/// Checks that the control accepts a value.
pub(crate) fn check(parameter: &Parameter, value: &Value) -> Result<(), EditError> {
    let control = &parameter.control;
    let label = || control.label.to_string();
    let wrong = |expected: &str| Err(EditError::WrongValue { label: label(), expected: expected.to_owned() });
    let out = |range: String| Err(EditError::OutOfRange { label: label(), range });
    match (&control.kind, value) {
        (ControlKind::Number(range), Value::Number(value)) if !range.accepts(*value) => out(range.in_words()),
        (ControlKind::Triple { .. } | ControlKind::Colour { .. }, Value::Triple(values) | Value::Colour(values))
            if !values.iter().all(|value| value.is_finite()) =>
        {
            out("finite numbers".to_owned())
        }
        (ControlKind::Triple { direction: true }, Value::Triple([0.0, 0.0, 0.0])) => {
            out("a direction, of any length but 0".to_owned())
        }
        (ControlKind::Colour { max }, Value::Colour(values)) => match Range::from_to(0.0, *max) {
            range if values.iter().all(|value| range.accepts(*value)) => Ok(()),
            range => out(format!("a colour with every channel {}", range.in_words())),
        },
        (ControlKind::Size { min, max }, Value::Size(size)) => {
            match size.iter().all(|side| (min..=max).contains(&side)) {
                true => Ok(()),
                false => out(format!("whole numbers from {min} to {max}")),
            }
        }
        (ControlKind::Choice(words), Value::Text(text)) if !words.iter().any(|word| word == text) => {
            out(format!("one of {}", words.join(", ")))
        }
        (ControlKind::Material(names), Value::Text(text)) if !names.contains(text) => {
            out(format!("the name of a material, and there is none called {text}"))
        }
        (ControlKind::Text | ControlKind::Picture, Value::Text(text)) if text.is_empty() => {
            Err(EditError::Name(format!("`{}` must not be empty.", control.label)))
        }
        (_, Value::Formulas(texts)) if texts.iter().any(|text| text.trim().is_empty()) => {
            Err(EditError::Name(format!("`{}` must not be empty.", control.label)))
        }
        (ControlKind::Number(_), Value::Formulas(texts)) if texts.len() == 1 => Ok(()),
        (ControlKind::Triple { .. }, Value::Formulas(texts)) if texts.len() == 3 => Ok(()),
        (ControlKind::Colour { .. }, Value::Formulas(texts)) if matches!(texts.len(), 1 | 3) => Ok(()),
        (ControlKind::Size { .. }, Value::Formulas(texts)) if texts.len() == 2 => Ok(()),
        (ControlKind::Number(_), Value::Number(_))
        | (ControlKind::Triple { .. }, Value::Triple(_))
        | (
            ControlKind::Choice(_) | ControlKind::Text | ControlKind::Picture | ControlKind::Material(_),
            Value::Text(_),
        )
        | (ControlKind::Flag, Value::Flag(_)) => Ok(()),
        (ControlKind::Number(_), _) => wrong("a number"),
        (ControlKind::Triple { .. }, _) => wrong("three numbers"),
        (ControlKind::Colour { .. }, _) => wrong("a colour"),
        (ControlKind::Size { .. }, _) => wrong("a width and a height"),
        (ControlKind::Flag, _) => wrong("yes or no"),
        _ => wrong("a text"),
    }
}

/// The numbers of a value, in order.
pub(crate) fn numbers_of(value: &Value) -> Option<Vec<f32>> {
    match value {
        Value::Number(number) => Some(vec![*number]),
        Value::Triple(numbers) | Value::Colour(numbers) => Some(numbers.to_vec()),
        Value::Size(size) => Some(size.map(|side| side as f32).to_vec()),
        _ => None,
    }
}

/// Merges a value with the formulas of a control: numbers equal to a formula's present value leave the formula, others
/// are refused. Only texts replace a formula.
pub(crate) fn keeping_formulas(parameter: &Parameter, value: Value) -> Result<Value, EditError> {
    let control = &parameter.control;
    let Value::Formulas(now) = &control.value else { return Ok(value) };
    if matches!(value, Value::None | Value::Formulas(_)) {
        return Ok(value);
    }
    let formula = now.iter().find(|text| characters::number(text).is_none());
    let refused = || {
        let (label, formula) = (control.label.to_string(), formula.cloned().unwrap_or_default());
        Err(EditError::Formula { label, formula })
    };
    // Handles that are dragged round what they do not move.
    let same = |new: f32, present: f32| (new - present).abs() <= 2e-3 * present.abs().max(1.0);
    let (Some(mut new), Some(mut present)) = (numbers_of(&value), numbers_of(&control.present)) else {
        return refused();
    };
    // A colour of one formula is grey.
    if now.len() == 1 && new.iter().chain(&present).all(|number| *number == new[0]) {
        new.truncate(1);
        present.truncate(1);
    }
    if now.len() != new.len() || new.len() != present.len() {
        return refused();
    }
    let mut texts = Vec::new();
    for (text, (new, present)) in now.iter().zip(new.into_iter().zip(present)) {
        match characters::number(text) {
            _ if same(new, present) => texts.push(text.clone()),
            Some(_) => texts.push(number(new)),
            None => return refused(),
        }
    }
    Ok(Value::Formulas(texts))
}
