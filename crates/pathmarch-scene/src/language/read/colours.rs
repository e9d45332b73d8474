//! Colours.

use super::arguments::{arguments, missing_arguments, no_children, properties};
use super::context::{Context, WrittenColour};
use super::numbers::{in_range, is_formula};
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::COLOUR_POSITION;
use crate::language::tree::{Entry, Node, Value};
use crate::settings::Range;
use std::fmt::Display;

/// A colour: three numbers, one number, or "#rrggbb" and nothing else.
pub(crate) fn colour(node: &Node, range: Range, context: &mut Context) -> Option<[f32; 3]> {
    let what = format_args!("`{}`", node.name.value);
    let usage = format_args!("`{} r g b`, one number, or \"#rrggbb\"", node.name.value);
    properties(node, &[], context);
    channels(node, range, what, usage, context)
}

/// The colour of a ramp, with its position if it has `at=`; `None` after a mistake.
pub(super) fn positioned_colour(node: &Node, context: &mut Context) -> Option<([f32; 3], Option<f32>)> {
    let unit = Range::from_to(0.0, 1.0);
    let usage = format_args!("`{} r g b at=0.5`", node.name.value);
    let given = properties(node, &[COLOUR_POSITION], context);
    let position = match given.first() {
        Some((_, entry)) => in_range(entry, format_args!("`{COLOUR_POSITION}`"), unit, context).map(Some),
        None => Some(None),
    };
    let colour = channels(node, unit, format_args!("`{}`", node.name.value), usage, context);
    Some((colour?, position?))
}

/// The colour of a node's arguments, of which there is nothing in braces.
fn channels(
    node: &Node,
    range: Range,
    what: impl Display + Copy,
    usage: impl Display + Copy,
    context: &mut Context,
) -> Option<[f32; 3]> {
    no_children(node, context);
    let entries = arguments(node, 3, usage, context);
    let value = value(node, &entries, range, what, usage, context);
    let is_written = |entry: &&Entry| matches!(&entry.value, Value::Number(_)) || is_srgb(entry);
    if let (Some(value), Some(first), Some(last)) = (value, entries.first(), entries.last())
        && entries.iter().all(is_written)
    {
        context.colours.push(WrittenColour { span: first.span.to(last.span), value });
    }
    value
}

fn is_srgb(entry: &Entry) -> bool {
    matches!(&entry.value, Value::Text(text) if srgb(text).is_some())
}

/// The colour of these arguments; reports mistakes.
fn value(
    node: &Node,
    entries: &[&Entry],
    range: Range,
    what: impl Display + Copy,
    usage: impl Display + Copy,
    context: &mut Context,
) -> Option<[f32; 3]> {
    if let [entry] = entries[..]
        && let Value::Text(text) = &entry.value
        && !is_formula(text, context)
    {
        let colour = srgb(text);
        if colour.is_none() {
            let message = format!("{} is not a colour.", shown(text));
            let mistake =
                draft("pathmarch::not_a_colour", entry.value_span, message).label("expected \"#rrggbb\" or \"#rgb\"");
            context
                .report
                .add(mistake.help("Six hexadecimal digits after #, red, green and blue; or three numbers, linear."));
        }
        return colour;
    }
    let mut number = |entry: &Entry| in_range(entry, what, range, context);
    match entries[..] {
        [grey] => number(grey).map(|grey| [grey; 3]),
        [red, green, blue] => {
            let values = [number(red), number(green), number(blue)];
            Some([values[0]?, values[1]?, values[2]?])
        }
        _ => {
            missing_arguments(node, usage, context);
            None
        }
    }
}

/// Linear Rec. 709 of "#rrggbb" or "#rgb", which are encoded as sRGB (IEC 61966-2-1).
pub(crate) fn srgb(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#')?;
    let digits: Vec<u32> = digits.chars().map(|c| c.to_digit(16)).collect::<Option<_>>()?;
    let bytes = match digits[..] {
        [r, g, b] => [r * 17, g * 17, b * 17],
        [a, b, c, d, e, f] => [a * 16 + b, c * 16 + d, e * 16 + f],
        _ => return None,
    };
    Some(bytes.map(|byte| {
        let encoded = f64::from(byte) / 255.0;
        let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        linear as f32
    }))
}
