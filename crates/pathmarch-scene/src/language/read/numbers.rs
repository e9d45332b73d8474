//! Numbers of entries, written as such or as formulas.

use super::arguments::{exactly, wrong_type};
use super::context::Context;
use crate::language::diagnostics::report::{Draft, draft, shown};
use crate::language::diagnostics::spelling::nearest;
use crate::language::formulas::expression::{self, Expression, MAX_DEPTH, MAX_LENGTH, Trouble};
use crate::language::formulas::scope::Evaluated;
use crate::language::tree::{Entry, Node, Span, Value};
use crate::settings::Range;
use std::fmt::Display;

/// Number of an entry, given as such or as a formula: not rounded, perhaps not finite.
fn evaluated(entry: &Entry, what: impl Display, context: &mut Context) -> Option<Evaluated> {
    match &entry.value {
        Value::Number(value) => Some(Evaluated { value: *value, moving: false }),
        Value::Text(text) => match context.scope.evaluate(text, entry.value_span) {
            Ok(value) => Some(value),
            Err(trouble) => {
                let mistake = no_formula(entry, text, what, trouble, context);
                mistake.into_iter().for_each(|mistake| context.report.add(mistake));
                None
            }
        },
        _ => {
            wrong_type(entry, what, "a number", context);
            None
        }
    }
}

/// Mistake of a string that has no value as a formula, unless it has been reported.
fn no_formula(entry: &Entry, text: &str, what: impl Display, trouble: Trouble, context: &Context) -> Option<Draft> {
    // If the string is in the file unescaped, the place within it is known.
    let quotes = (entry.value_span.end - entry.value_span.start) as usize - text.len();
    let inside = |start: usize, length: usize| match quotes {
        0 | 2 => {
            let start = entry.value_span.start as usize + quotes / 2 + start;
            Span::new(start, start + length)
        }
        _ => entry.value_span,
    };
    let named = |range: &std::ops::Range<usize>| inside(range.start, range.len());
    let formula = |span, message: String| draft("pathmarch::formula", span, message);
    Some(match trouble {
        Trouble::Told => return None,
        Trouble::TooLong => formula(entry.value_span, "This formula is too long.".to_owned())
            .label(format!("more than {MAX_LENGTH} bytes"))
            .help("Make a `param` of a part of it."),
        Trouble::TooDeep => formula(entry.value_span, "This formula is nested too deeply.".to_owned())
            .label(format!("more than {MAX_DEPTH} brackets, signs and powers"))
            .help("Make a `param` of a part of it."),
        Trouble::TooMuch => formula(entry.value_span, "The formulas of this scene take too long.".to_owned())
            .label("given up here")
            .help("Use fewer or shorter ones."),
        Trouble::Syntax(_) if text.trim().is_empty() => {
            formula(entry.value_span, format!("{what} must be a number.")).label("an empty formula")
        }
        Trouble::Syntax(at) => {
            let character = text[at..].chars().next();
            let label = if character.is_none() { "ends too early" } else { "cannot be read from here on" };
            let span = match character {
                Some(character) => inside(at, character.len_utf8()),
                None => entry.value_span,
            };
            formula(span, format!("{what} is neither a number nor a formula."))
                .label(label)
                .help("Formulas look like \"0.5 + 0.1*sin(2*pi*t)\".")
        }
        Trouble::UnknownName(name, range) => {
            let message = format!("There is no parameter {}.", shown(&name));
            let close = if context.report.is_full() { None } else { nearest(&name, context.scope.names()) };
            let help = match close {
                Some(word) => format!("Did you mean `{word}`?"),
                None => format!("Declare it at the top: param {} 1.", shown(&name).trim_matches('`')),
            };
            let mistake = draft("pathmarch::unknown_name", named(&range), message).label("unknown name");
            let names: Vec<&str> =
                context.scope.names().chain(expression::functions().map(|name| -> &str { name })).collect();
            mistake.help(help).expected(names)
        }
        Trouble::UnknownFunction(name, range) => {
            let message = format!("There is no function {}.", shown(&name));
            let mistake = draft("pathmarch::unknown_name", named(&range), message).label("unknown function");
            match context.scope.params().any(|param| param == name) {
                true => mistake.help(format!("An operator, such as `*`, is missing between `{name}` and the bracket.")),
                false => match nearest(&name, expression::functions()) {
                    Some(word) => mistake.help(format!("Did you mean `{word}`?")).expected(expression::functions()),
                    None => mistake.help("There are `sin`, `cos`, `min`, `max`, `mix` and others."),
                },
            }
        }
        Trouble::Arguments(usage, range) => {
            let message = format!("{} is used in the wrong way.", shown(&text[range.clone()]));
            formula(named(&range), message).label(format!("expected {usage}"))
        }
    })
}

/// The finite number of an entry, and whether it depends on the moment; `what` as in "`radius`".
pub(crate) fn value(entry: &Entry, what: impl Display, context: &mut Context) -> Option<Evaluated> {
    let found = evaluated(entry, &what, context)?;
    if (found.value as f32).is_finite() {
        return Some(found);
    }
    let label = if found.value.is_finite() { "too large a number" } else { "not finite" };
    let label = match found.moving {
        true => format!("{label} {}", context.scope.moment_in_words()),
        false => label.to_owned(),
    };
    let message = format!("{what} must be a finite number.");
    context.report.add(draft("pathmarch::not_finite", entry.value_span, message).label(label));
    None
}

/// The finite number of an entry; `what` as in "`radius`".
pub(crate) fn finite(entry: &Entry, what: impl Display, context: &mut Context) -> Option<f32> {
    value(entry, what, context).map(|found| found.value as f32)
}

/// Reports a value out of range.
pub(crate) fn out_of_range(entry: &Entry, value: Evaluated, what: impl Display, words: &str, context: &mut Context) {
    let message = format!("{what} must be {words}.");
    let label = match &entry.value {
        Value::Text(_) if value.moving => format!("is {} {}", value.value as f32, context.scope.moment_in_words()),
        Value::Text(_) => format!("is {}", value.value as f32),
        _ => "out of range".to_owned(),
    };
    context.report.add(draft("pathmarch::out_of_range", entry.value_span, message).label(label));
}

/// The number of an entry, if it is accepted; `words` as in "must be above 0".
pub(crate) fn accepted(
    entry: &Entry,
    what: impl Display,
    accepts: impl Fn(f32) -> bool,
    words: impl Fn() -> String,
    context: &mut Context,
) -> Option<f32> {
    let found = value(entry, &what, context)?;
    let number = found.value as f32;
    if !accepts(number) {
        out_of_range(entry, found, what, &words(), context);
        return None;
    }
    Some(number)
}

/// The number of an entry, if within the range.
pub(crate) fn in_range(entry: &Entry, what: impl Display, range: Range, context: &mut Context) -> Option<f32> {
    accepted(entry, what, |number| range.accepts(number), || range.in_words(), context)
}

/// The whole number of an entry.
pub(crate) fn whole(entry: &Entry, what: impl Display, (min, max): (u32, u32), context: &mut Context) -> Option<u32> {
    let found = value(entry, &what, context)?;
    // Formulas compute whole numbers up to rounding.
    let number = if matches!(entry.value, Value::Number(_)) { found.value } else { f64::from(found.value as f32) };
    if number.fract() != 0.0 || number < f64::from(min) || number > f64::from(max) {
        out_of_range(entry, found, what, &format!("a whole number from {min} to {max}"), context);
        return None;
    }
    Some(number as u32)
}

/// Exactly `K` numbers and nothing else; `usage` is as in "`at x y z`".
pub(crate) fn numbers<const K: usize>(
    node: &Node,
    usage: impl Display,
    range: Range,
    context: &mut Context,
) -> Option<[f32; K]> {
    exactly(node, usage, context, |entry, what, context| in_range(entry, what, range, context))
}

/// Exactly `K` whole numbers and nothing else.
pub(crate) fn whole_numbers<const K: usize>(
    node: &Node,
    usage: impl Display,
    range: (u32, u32),
    context: &mut Context,
) -> Option<[u32; K]> {
    exactly(node, usage, context, |entry, what, context| whole(entry, what, range, context))
}

/// Three numbers that are not all zero, of length one.
pub(crate) fn direction(node: &Node, context: &mut Context) -> Option<[f32; 3]> {
    let name = &node.name.value;
    let value: [f32; 3] = numbers(node, format_args!("`{name} x y z`"), Range::ANY, context)?;
    // In f64, where no finite f32 is too large or too small to be squared.
    let unit = glam::DVec3::from_array(value.map(f64::from)).try_normalize();
    if unit.is_none() {
        let span = node.entries[0].span.to(node.entries[2].span);
        let message = format!("`{name}` must point somewhere.");
        context.report.add(draft("pathmarch::no_direction", span, message).label("a direction of length zero"));
    }
    unit.map(|unit| unit.as_vec3().to_array())
}

/// True if a string that may be something else is a formula: it parses, and is not a single word without a meaning
/// here.
pub(crate) fn is_formula(text: &str, context: &Context) -> bool {
    Expression::read(text)
        .is_ok_and(|formula| !formula.is_name() || context.scope.names().any(|name| name == text.trim()))
}
