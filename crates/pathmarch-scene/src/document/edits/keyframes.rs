//! Keyframes: formulas of the form `keys(t, 0, 1, 2, 5)`, with a time and a value for each key. In place of `t` may stand
//! `t % 4`, which repeats them.

use super::write::check::numbers_of;
use crate::document::control::{Control, ControlKind, Value};
use crate::document::error::EditError;
use crate::document::text::literals::number;

/// Keys nearer to each other in time are one, seconds.
const SAME_TIME: f64 = 1e-4;

/// Keys of a formula.
struct Keys<'t> {
    /// Argument in place of `t`, and the period of repetition.
    time: &'t str,
    period: Option<f64>,
    /// Times, seconds, and values.
    keys: Vec<(f64, f64)>,
}

/// The keys of a formula; `None` of any other.
fn keys(formula: &str) -> Option<Keys<'_>> {
    let inside = formula.trim().strip_prefix("keys(")?.strip_suffix(')')?;
    let mut parts = inside.split(',').map(str::trim);
    let time = parts.next()?;
    let period = match time.split_once('%') {
        Some((t, period)) if t.trim() == "t" => Some(period.trim().parse().ok().filter(|period| *period > 0.0)?),
        None if time == "t" => None,
        _ => return None,
    };
    let numbers: Vec<f64> = parts.map(|part| part.parse().ok()).collect::<Option<_>>()?;
    let (pairs, rest) = numbers.as_chunks::<2>();
    (!pairs.is_empty() && rest.is_empty()).then(|| Keys {
        time,
        period,
        keys: pairs.iter().map(|[t, v]| (*t, *v)).collect(),
    })
}

/// A formula of keys with another key.
fn with_key(formula: &str, seconds: f64, value: f32) -> Option<String> {
    let Keys { time, period, mut keys } = keys(formula)?;
    let at = period.map_or(seconds, |period| seconds.rem_euclid(period));
    match keys.iter_mut().find(|(time, _)| (time - at).abs() < SAME_TIME) {
        Some(same) => same.1 = f64::from(value),
        None => keys.push((at, f64::from(value))),
    }
    keys.sort_by(|a, b| a.0.total_cmp(&b.0));
    Some(written(time, &keys))
}

fn written(time: &str, keys: &[(f64, f64)]) -> String {
    let numbers = keys.iter().flat_map(|(time, value)| [rounded(*time), number(*value as f32)]);
    format!("keys({})", std::iter::once(time.to_owned()).chain(numbers).collect::<Vec<_>>().join(", "))
}

/// Seconds with four decimals at most.
fn rounded(seconds: f64) -> String {
    let text = format!("{seconds:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Times of all keys of a control, seconds.
pub(crate) fn times(control: &Control) -> Vec<f64> {
    let Value::Formulas(texts) = &control.value else { return Vec::new() };
    texts.iter().filter_map(|text| keys(text)).flat_map(|keys| keys.keys).map(|(time, _)| time).collect()
}

/// A new value of a control with keys: where its numbers differ from a formula of keys, they become keys at this moment.
pub(crate) fn keyed(control: &Control, value: &Value, seconds: f64) -> Option<Value> {
    let Value::Formulas(texts) = &control.value else { return None };
    let (new, now) = (numbers_of(value)?, numbers_of(&control.present)?);
    if new.len() != now.len() || !texts.iter().any(|text| keys(text).is_some()) {
        return None;
    }
    // A grey is one formula.
    let texts: Vec<String> = if texts.len() == 1 { vec![texts[0].clone(); new.len()] } else { texts.clone() };
    let text = |((text, new), now): ((&String, &f32), &f32)| match new == now {
        true => text.clone(),
        false => with_key(text, seconds, *new).unwrap_or_else(|| number(*new)),
    };
    Some(Value::Formulas(texts.iter().zip(&new).zip(&now).map(text).collect()))
}

/// The present value of a control as keys at this moment, besides those that it has.
pub(crate) fn with_keys(control: &Control, seconds: f64) -> Result<Value, EditError> {
    let can_move =
        matches!(control.kind, ControlKind::Number(_) | ControlKind::Triple { .. } | ControlKind::Colour { .. });
    let refused = |why: &str| Err(EditError::Needed(format!("`{}` {why}", control.label)));
    let (Some(now), true) = (numbers_of(&control.present), can_move) else {
        return refused("has no numbers to animate.");
    };
    let texts: Vec<Option<&String>> = match &control.value {
        Value::Formulas(texts) if texts.len() == 1 => vec![Some(&texts[0]); now.len()],
        Value::Formulas(texts) => texts.iter().map(Some).collect(),
        _ => vec![None; now.len()],
    };
    let mut keyed = Vec::new();
    for (text, now) in texts.iter().zip(&now) {
        match text {
            Some(text) if text.trim().parse::<f64>().is_err() => match with_key(text, seconds, *now) {
                Some(text) => keyed.push(text),
                None => return refused("is a formula. Replace it by a number to set keys."),
            },
            _ => keyed.push(written("t", &[(seconds, f64::from(*now))])),
        }
    }
    Ok(Value::Formulas(keyed))
}
