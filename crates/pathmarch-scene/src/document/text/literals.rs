//! Values as text.

use crate::document::control::Value;
use crate::language::characters::{self, is_forbidden, is_newline, is_word, looks_like_number};
use std::fmt::Write;

/// Shortest decimal that reads as this number; with an exponent only for many digits.
pub(crate) fn number(value: f32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let plain = (1e-6..1e10).contains(&value.abs());
    let text = if plain { format!("{value}") } else { format!("{value:e}") };
    // The reader rounds to f64 first, which can matter half-way between two f32.
    if text.parse::<f64>().is_ok_and(|read| read as f32 == value) { text } else { format!("{:e}", f64::from(value)) }
}

/// Several numbers.
pub(crate) fn numbers(values: &[f32]) -> String {
    let numbers: Vec<String> = values.iter().map(|value| number(*value)).collect();
    numbers.join(" ")
}

/// A string, in quotes.
pub(crate) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted.push_str("\\n"),
            '\r' => quoted.push_str("\\r"),
            '\t' => quoted.push_str("\\t"),
            c if is_newline(c) || is_forbidden(c) => drop(write!(quoted, "\\u{{{:x}}}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// String in the style of the present text `now`: without quotes if that has none and the string needs none.
pub(crate) fn string_like(text: &str, now: &str) -> String {
    let keyword = matches!(text, "true" | "false" | "null" | "inf" | "-inf" | "nan");
    let bare = !text.is_empty() && text.chars().all(is_word) && !looks_like_number(text) && !keyword;
    if bare && !now.starts_with(['"', '#']) { text.to_owned() } else { quoted(text) }
}

/// A formula, in quotes; a number if it is only that.
pub(crate) fn formula(text: &str) -> String {
    let text = text.trim();
    match characters::number(text) {
        Some(value) if value.is_finite() => text.to_owned(),
        _ => quoted(text),
    }
}

/// Text of a value after a name.
pub(crate) fn fresh(value: &Value) -> String {
    match value {
        Value::None => String::new(),
        Value::Number(value) => number(*value),
        Value::Triple(values) => numbers(values),
        Value::Colour([r, g, b]) if r == g && g == b => number(*r),
        Value::Colour(values) => numbers(values),
        Value::Size([width, height]) => format!("{width} {height}"),
        Value::Text(text) => quoted(text),
        Value::Flag(value) => format!("#{value}"),
        Value::Formulas(all) => all.iter().map(|one| formula(one)).collect::<Vec<_>>().join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::{number, quoted, string_like};
    use crate::language::characters;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.1, "0.1"),
            (-2.0, "-2"),
            (1e-3, "0.001"),
            (-0.0, "0"),
            (1e30, "1e30"),
            (2.5e-9, "2.5e-9"),
            (16384.0, "16384"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }

    proptest! {
        #[test]
        fn numbers_are_read_as_they_were(bits in any::<u32>()) {
            let value = f32::from_bits(bits);
            prop_assume!(value.is_finite());
            prop_assert_eq!(characters::number(&number(value)).map(|read| read as f32), Some(value));
        }
        #[test]
        fn strings_are_read_as_they_were(text in "\\PC{0,12}|[\u{0}-\u{30}\\\\\"]{0,6}|true|-inf|1a|-") {
            for written in [quoted(&text), string_like(&text, "bare")] {
                let file = format!("a {written}");
                let block = crate::language::nodes(&file).expect("read");
                let value = block.nodes[0].entries[0].value.clone();
                prop_assert_eq!(value, crate::language::tree::Value::Text(text.clone().into()));
            }
        }
    }
}
