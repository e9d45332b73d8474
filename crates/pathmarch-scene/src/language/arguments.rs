//! Reads what stands behind a node's name, and says what is wrong with it.
//!
//! Every function reports its mistakes and returns what it could make of the rest, so that one mistake hides no other.

use super::names::{nearest, suggestion, unexpected_node};
use super::report::{Report, draft, shown};
use super::tree::{Entry, Node, Span, Value};

/// The numbers that are allowed.
#[derive(Clone, Copy)]
pub(crate) struct Range {
    pub(crate) min: f32,
    pub(crate) min_allowed: bool,
    pub(crate) max: f32,
    pub(crate) max_allowed: bool,
}

impl Range {
    /// Every finite number.
    pub(crate) const ANY: Self = Self::from_to(f32::MIN, f32::MAX);
    /// Zero or more.
    pub(crate) const NOT_NEGATIVE: Self = Self::from_to(0.0, f32::MAX);
    /// More than zero.
    pub(crate) const POSITIVE: Self = Self { min_allowed: false, ..Self::NOT_NEGATIVE };

    /// Both ends included.
    pub(crate) const fn from_to(min: f32, max: f32) -> Self {
        Self { min, min_allowed: true, max, max_allowed: true }
    }
    /// Neither end included.
    pub(crate) const fn between(min: f32, max: f32) -> Self {
        Self { min, min_allowed: false, max, max_allowed: false }
    }
    pub(crate) fn accepts(self, value: f32) -> bool {
        (value > self.min || self.min_allowed && value == self.min)
            && (value < self.max || self.max_allowed && value == self.max)
    }
    /// As in "must be …".
    pub(crate) fn in_words(self) -> String {
        let Self { min, max, .. } = self;
        match (min > f32::MIN, max < f32::MAX) {
            (true, true) if self.min_allowed => format!("from {min} to {max}"),
            (true, true) => format!("above {min} and below {max}"),
            (true, false) if self.min_allowed => format!("{min} or more"),
            (true, false) => format!("above {min}"),
            (false, true) => format!("at most {max}"),
            (false, false) => "a finite number".to_owned(),
        }
    }
}

fn described(value: &Value) -> &'static str {
    match value {
        Value::Text(_) => "a string",
        Value::Number(_) => "a number",
        Value::Bool(_) => "a truth value",
        Value::Null | Value::Bad => "nothing",
    }
}

/// The entry is not of the expected type.
pub(crate) fn wrong_type(entry: &Entry, what: &str, expected: &str, report: &mut Report) {
    if entry.value == Value::Bad {
        return;
    }
    let mistake = draft("pathmarch::wrong_type", entry.value_span, format!("{what} must be {expected}."))
        .label(format!("this is {}", described(&entry.value)));
    let numeric = matches!(&entry.value, Value::Text(text) if text.trim().parse::<f64>().is_ok());
    report.add(if numeric { mistake.help("Delete the quotes.") } else { mistake });
}

/// The finite number of an entry; `what` as in "`radius`".
pub(crate) fn finite(entry: &Entry, what: &str, report: &mut Report) -> Option<f32> {
    let Value::Number(number) = entry.value else {
        wrong_type(entry, what, "a number", report);
        return None;
    };
    let value = number as f32;
    if value.is_finite() {
        return Some(value);
    }
    let too_large = number.is_finite();
    let label = if too_large { "too large a number" } else { "not finite" };
    report
        .add(draft("pathmarch::not_finite", entry.value_span, format!("{what} must be a finite number.")).label(label));
    None
}

/// A value is outside its range.
pub(crate) fn out_of_range(span: Span, what: &str, words: &str, report: &mut Report) {
    let message = format!("{what} must be {words}.");
    report.add(draft("pathmarch::out_of_range", span, message).label("out of range"));
}

/// The number of an entry, if within the range.
pub(crate) fn in_range(entry: &Entry, what: &str, range: Range, report: &mut Report) -> Option<f32> {
    let value = finite(entry, what, report)?;
    if !range.accepts(value) {
        out_of_range(entry.value_span, what, &range.in_words(), report);
        return None;
    }
    Some(value)
}

/// The whole number of an entry.
pub(crate) fn whole(entry: &Entry, what: &str, (min, max): (u32, u32), report: &mut Report) -> Option<u32> {
    let value = finite(entry, what, report).and(match entry.value {
        Value::Number(number) => Some(number),
        _ => None,
    })?;
    if value.fract() != 0.0 || value < f64::from(min) || value > f64::from(max) {
        out_of_range(entry.value_span, what, &format!("a whole number from {min} to {max}"), report);
        return None;
    }
    Some(value as u32)
}

/// The string of an entry.
pub(crate) fn string<'n>(entry: &'n Entry, what: &str, report: &mut Report) -> Option<&'n str> {
    match &entry.value {
        Value::Text(text) => Some(text),
        _ => {
            wrong_type(entry, what, "a string", report);
            None
        }
    }
}

/// The truth value of an entry.
pub(crate) fn flag(entry: &Entry, what: &str, report: &mut Report) -> Option<bool> {
    match entry.value {
        Value::Bool(value) => Some(value),
        _ => {
            wrong_type(entry, what, "#true or #false", report);
            None
        }
    }
}

/// The properties among `known`, each at most once; reports all others.
pub(crate) fn properties<'n, 'k>(
    node: &'n Node,
    known: &[&'k str],
    report: &mut Report,
) -> Vec<(&'k str, &'n Entry<'n>)> {
    let mut found: Vec<(&'k str, &'n Entry<'n>)> = Vec::new();
    for entry in &node.entries {
        let Some(name) = &entry.name else { continue };
        let Some(&word) = known.iter().find(|word| **word == name.value) else {
            let help = match known.is_empty() {
                true => format!("`{}` has no properties.", node.name.value),
                false => suggestion(&name.value, known),
            };
            let message = format!("`{}` has no property {}.", node.name.value, shown(&name.value));
            let mistake = draft("pathmarch::unknown_property", name.span, message).label("unknown property");
            report.add(mistake.help(help));
            continue;
        };
        match found.iter().find(|(other, _)| *other == word) {
            Some((_, first)) => twice(&format!("`{word}`"), entry.span, first.span, report),
            None => found.push((word, entry)),
        }
    }
    found
}

/// Something is given a second time.
pub(crate) fn twice(what: &str, second: Span, first: Span, report: &mut Report) {
    let message = format!("{what} is given twice.");
    report.add(draft("pathmarch::duplicate", second, message).label("again here").also(first, "first here"));
}

/// The arguments, of which at most `most` are allowed; `usage` is as in "`fov 40`".
pub(crate) fn arguments<'n>(node: &'n Node, most: usize, usage: &str, report: &mut Report) -> Vec<&'n Entry<'n>> {
    let mut arguments: Vec<&Entry> = node.entries.iter().filter(|entry| entry.name.is_none()).collect();
    if arguments.len() > most {
        let extra = arguments[most].span.to(arguments[arguments.len() - 1].span);
        let count = match (most, arguments.len() - most) {
            (0, _) => format!("`{}` takes no arguments.", node.name.value),
            (_, 1) => format!("`{}` has an argument too many.", node.name.value),
            (_, extra) => format!("`{}` has {extra} arguments too many.", node.name.value),
        };
        report.add(
            draft("pathmarch::unexpected_argument", extra, count).label("unused").help(format!("Expected {usage}.")),
        );
        arguments.truncate(most);
    }
    arguments
}

/// Reports braces where there should be none.
pub(crate) fn no_children(node: &Node, report: &mut Report) {
    if let Some(child) = node.child_nodes().first() {
        let message = format!("`{}` holds no other nodes.", node.name.value);
        report.add(draft("pathmarch::unexpected_children", child.name.span, message).label("unexpected node"));
    }
}

/// Reports too few arguments.
pub(crate) fn missing_arguments(node: &Node, usage: &str, report: &mut Report) {
    let message = format!("`{}` has too few arguments.", node.name.value);
    let mistake = draft("pathmarch::missing_argument", node.span(), message).label(format!("expected {usage}"));
    report.add(mistake);
}

/// Exactly `K` arguments and nothing else, each as `read` reads it; it is given the name of what it reads.
fn exactly<const K: usize, T>(
    node: &Node,
    usage: &str,
    report: &mut Report,
    read: impl Fn(&Entry, &str, &mut Report) -> Option<T>,
) -> Option<[T; K]> {
    let what = format!("`{}`", node.name.value);
    properties(node, &[], report);
    no_children(node, report);
    let entries = arguments(node, K, usage, report);
    let values: Vec<Option<T>> = entries.iter().map(|entry| read(entry, &what, report)).collect();
    if values.len() < K {
        missing_arguments(node, usage, report);
        return None;
    }
    let values: Vec<T> = values.into_iter().collect::<Option<_>>()?;
    values.try_into().ok()
}

/// Exactly `K` numbers and nothing else; `usage` is as in "`at x y z`".
pub(crate) fn numbers<const K: usize>(node: &Node, usage: &str, range: Range, report: &mut Report) -> Option<[f32; K]> {
    exactly(node, usage, report, |entry, what, report| in_range(entry, what, range, report))
}

/// Exactly `K` whole numbers and nothing else.
pub(crate) fn whole_numbers<const K: usize>(
    node: &Node,
    usage: &str,
    range: (u32, u32),
    report: &mut Report,
) -> Option<[u32; K]> {
    exactly(node, usage, report, |entry, what, report| whole(entry, what, range, report))
}

/// One of the things in `all`, by the name that is a node's only argument; `what` as in "There is no …".
pub(crate) fn choice<T: Copy>(
    node: &Node,
    what: &str,
    all: &[T],
    name_of: fn(T) -> &'static str,
    report: &mut Report,
) -> Option<T> {
    let names: Vec<&str> = all.iter().map(|&one| name_of(one)).collect();
    let usage = format!("`{} \"{}\"`", node.name.value, names[0]);
    properties(node, &[], report);
    no_children(node, report);
    let entries = arguments(node, 1, &usage, report);
    let Some(entry) = entries.first() else {
        missing_arguments(node, &usage, report);
        return None;
    };
    let text = string(entry, &format!("`{}`", node.name.value), report)?;
    named(entry, text, what, all, name_of, report)
}

/// One of the things in `all`, by the name that an entry says; `what` as in "There is no …".
pub(crate) fn named<T: Copy>(
    entry: &Entry,
    text: &str,
    what: &str,
    all: &[T],
    name_of: fn(T) -> &'static str,
    report: &mut Report,
) -> Option<T> {
    let names: Vec<&str> = all.iter().map(|&one| name_of(one)).collect();
    let found = names.iter().position(|name| *name == text);
    if found.is_none() {
        let message = format!("There is no {what} {}.", shown(text));
        let mistake = draft("pathmarch::unknown_name", entry.value_span, message).label("unknown name");
        report.add(mistake.help(suggestion(text, &names)));
    }
    found.map(|index| all[index])
}

/// Three numbers that are not all zero, of length one.
pub(crate) fn direction(node: &Node, report: &mut Report) -> Option<[f32; 3]> {
    let name = &node.name.value;
    let value: [f32; 3] = numbers(node, &format!("`{name} x y z`"), Range::ANY, report)?;
    // In f64, where no finite f32 is too large or too small to be squared.
    let unit = glam::DVec3::from_array(value.map(f64::from)).try_normalize();
    if unit.is_none() {
        let span = node.entries[0].span.to(node.entries[2].span);
        let message = format!("`{name}` must point somewhere.");
        report.add(draft("pathmarch::no_direction", span, message).label("a direction of length zero"));
    }
    unit.map(|unit| unit.as_vec3().to_array())
}

/// A colour: three numbers, one number, or "#rrggbb" and nothing else.
pub(crate) fn colour(node: &Node, range: Range, report: &mut Report) -> Option<[f32; 3]> {
    let what = format!("`{}`", node.name.value);
    let usage = format!("`{} r g b`, one number, or \"#rrggbb\"", node.name.value);
    properties(node, &[], report);
    no_children(node, report);
    let entries = arguments(node, 3, &usage, report);
    if let [entry] = entries[..]
        && let Value::Text(text) = &entry.value
    {
        let colour = srgb(text);
        if colour.is_none() {
            let message = format!("{} is no colour.", shown(text));
            let mistake =
                draft("pathmarch::not_a_colour", entry.value_span, message).label("expected \"#rrggbb\" or \"#rgb\"");
            report.add(mistake.help("Six hexadecimal digits after #, red, green and blue; or three numbers, linear."));
        }
        return colour;
    }
    let mut number = |entry: &Entry| in_range(entry, &what, range, report);
    match entries[..] {
        [grey] => number(grey).map(|grey| [grey; 3]),
        [red, green, blue] => {
            let values = [number(red), number(green), number(blue)];
            Some([values[0]?, values[1]?, values[2]?])
        }
        _ => {
            missing_arguments(node, &usage, report);
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

/// The name that is a node's only argument, not empty.
pub(crate) fn name<'n>(node: &'n Node, usage: &str, report: &mut Report) -> Option<(&'n str, Span)> {
    let entry = *arguments(node, 1, usage, report).first()?;
    let text = string(entry, "A name", report)?;
    if text.is_empty() {
        report.add(draft("pathmarch::empty_name", entry.value_span, "This name is empty.").label("expected a name"));
        return None;
    }
    Some((text, entry.value_span))
}

/// Nodes found in braces, each of a known name and at most once.
pub(crate) struct Settings<'n> {
    found: Vec<&'n Node<'n>>,
}

impl<'n> Settings<'n> {
    /// Reports unknown nodes and repeated ones. `place` as in "in a camera".
    pub(crate) fn new(node: &'n Node<'n>, known: &[&str], place: &str, report: &mut Report) -> Self {
        let mut found: Vec<&'n Node<'n>> = Vec::new();
        for child in node.child_nodes() {
            if !known.contains(&&*child.name.value) {
                unexpected_node(&child.name, known, place, report);
            } else if let Some(first) = found.iter().find(|other| other.name.value == child.name.value) {
                twice(&format!("`{}`", child.name.value), child.name.span, first.name.span, report);
            } else {
                found.push(child);
            }
        }
        Self { found }
    }
    /// The node of this name.
    pub(crate) fn get(&self, name: &str) -> Option<&'n Node<'n>> {
        self.found.iter().copied().find(|node| node.name.value == name)
    }
    /// As [`Self::get`]; reports that it is missing. Says nothing where something could not be read.
    pub(crate) fn require(&self, name: &str, example: &str, owner: &Node, report: &mut Report) -> Option<&'n Node<'n>> {
        let found = self.get(name);
        let misspelt = owner.child_nodes().iter().any(|child| nearest(&child.name.value, [name]).is_some());
        if found.is_none() && !owner.broken() && !misspelt {
            let message = format!("This `{}` has no `{name}`.", owner.name.value);
            let mistake = draft("pathmarch::missing_node", owner.name.span, message)
                .label(format!("expected `{name}` in its braces"));
            report.add(mistake.help(format!("For example: {example}.")));
        }
        found
    }
}
