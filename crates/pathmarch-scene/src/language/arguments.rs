//! Reads what stands behind a node's name, and says what is wrong with it.
//!
//! Every function reports its mistakes and returns what it could make of the rest, so that one mistake hides no other.

use super::expression::{Expression, MAX_DEPTH, MAX_LENGTH, Trouble};
use super::names::{nearest, suggestion, unexpected_node};
use super::report::{Draft, Report, draft, shown};
use super::scope::Evaluated;
use super::tree::{Entry, Node, Span, Value};

/// The numbers that are allowed.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The smallest number.
    pub min: f32,
    /// Whether that number itself is allowed.
    pub min_allowed: bool,
    /// The largest number.
    pub max: f32,
    /// Whether that number itself is allowed.
    pub max_allowed: bool,
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
    /// Whether a number is in the range: never one that is not finite.
    pub fn accepts(self, value: f32) -> bool {
        (value > self.min || self.min_allowed && value == self.min)
            && (value < self.max || self.max_allowed && value == self.max)
    }
    /// As in "must be …".
    pub fn in_words(self) -> String {
        let Self { min, max, .. } = self;
        match (min > f32::MIN, max < f32::MAX) {
            (true, true) if self.min_allowed => format!("from {min} to {max}"),
            (true, true) if self.max_allowed => format!("above {min} and at most {max}"),
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
    let mistake = draft("pathmarch::wrong_type", entry.value_span, format!("{what} must be {expected}."));
    report.add(mistake.label(format!("this is {}", described(&entry.value))));
}

/// The number of an entry, as it stands there or as a formula: not rounded, perhaps not finite.
fn evaluated(entry: &Entry, what: &str, report: &mut Report) -> Option<Evaluated> {
    match &entry.value {
        Value::Number(value) => Some(Evaluated { value: *value, moving: false }),
        Value::Text(text) => match report.scope.evaluate(text, entry.value_span) {
            Ok(value) => Some(value),
            Err(trouble) => {
                let mistake = no_formula(entry, text, what, trouble, report);
                mistake.into_iter().for_each(|mistake| report.add(mistake));
                None
            }
        },
        _ => {
            wrong_type(entry, what, "a number", report);
            None
        }
    }
}

/// Why the string of an entry has no value, unless that is told already.
fn no_formula(entry: &Entry, text: &str, what: &str, trouble: Trouble, report: &Report) -> Option<Draft> {
    // Where the string stands in the file as it is, the place within it is known, too.
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
            let help = match nearest(&name, report.scope.names()) {
                Some(word) => format!("Did you mean `{word}`?"),
                None => format!("Declare it at the top: param {} 1.", shown(&name).trim_matches('`')),
            };
            draft("pathmarch::unknown_name", named(&range), message).label("unknown name").help(help)
        }
        Trouble::UnknownFunction(name, range) => {
            let message = format!("There is no function {}.", shown(&name));
            let mistake = draft("pathmarch::unknown_name", named(&range), message).label("unknown function");
            match report.scope.params().any(|param| param == name) {
                true => mistake.help(format!("Between `{name}` and the bracket belongs an operator, such as `*`.")),
                false => match nearest(&name, super::expression::functions()) {
                    Some(word) => mistake.help(format!("Did you mean `{word}`?")),
                    None => mistake.help("`sin`, `cos`, `min`, `max`, `mix` and others are there."),
                },
            }
        }
        Trouble::Arguments(usage, range) => {
            let message = format!("{} is used in another way.", shown(&text[range.clone()]));
            formula(named(&range), message).label(format!("expected {usage}"))
        }
    })
}

/// The finite number of an entry, and whether it depends on the moment; `what` as in "`radius`".
pub(crate) fn value(entry: &Entry, what: &str, report: &mut Report) -> Option<Evaluated> {
    let found = evaluated(entry, what, report)?;
    if (found.value as f32).is_finite() {
        return Some(found);
    }
    let label = if found.value.is_finite() { "too large a number" } else { "not finite" };
    let label = match found.moving {
        true => format!("{label} {}", report.scope.moment_in_words()),
        false => label.to_owned(),
    };
    let message = format!("{what} must be a finite number.");
    report.add(draft("pathmarch::not_finite", entry.value_span, message).label(label));
    None
}

/// The finite number of an entry; `what` as in "`radius`".
pub(crate) fn finite(entry: &Entry, what: &str, report: &mut Report) -> Option<f32> {
    value(entry, what, report).map(|found| found.value as f32)
}

/// The value of an entry is outside of what is allowed.
pub(crate) fn out_of_range(entry: &Entry, value: Evaluated, what: &str, words: &str, report: &mut Report) {
    let message = format!("{what} must be {words}.");
    let label = match &entry.value {
        Value::Text(_) if value.moving => format!("is {} {}", value.value as f32, report.scope.moment_in_words()),
        Value::Text(_) => format!("is {}", value.value as f32),
        _ => "out of range".to_owned(),
    };
    report.add(draft("pathmarch::out_of_range", entry.value_span, message).label(label));
}

/// The number of an entry, if it is accepted; `words` as in "must be above 0".
pub(crate) fn accepted(
    entry: &Entry,
    what: &str,
    accepts: impl Fn(f32) -> bool,
    words: impl Fn() -> String,
    report: &mut Report,
) -> Option<f32> {
    let found = value(entry, what, report)?;
    let number = found.value as f32;
    if !accepts(number) {
        out_of_range(entry, found, what, &words(), report);
        return None;
    }
    Some(number)
}

/// The number of an entry, if within the range.
pub(crate) fn in_range(entry: &Entry, what: &str, range: Range, report: &mut Report) -> Option<f32> {
    accepted(entry, what, |number| range.accepts(number), || range.in_words(), report)
}

/// The whole number of an entry.
pub(crate) fn whole(entry: &Entry, what: &str, (min, max): (u32, u32), report: &mut Report) -> Option<u32> {
    let found = value(entry, what, report)?;
    // Formulas compute whole numbers up to rounding.
    let number = if matches!(entry.value, Value::Number(_)) { found.value } else { f64::from(found.value as f32) };
    if number.fract() != 0.0 || number < f64::from(min) || number > f64::from(max) {
        out_of_range(entry, found, what, &format!("a whole number from {min} to {max}"), report);
        return None;
    }
    Some(number as u32)
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

/// Whether a string that may be something else is meant as a formula: it is one, and no single word that is not in sight.
pub(crate) fn is_formula(text: &str, report: &Report) -> bool {
    Expression::read(text)
        .is_ok_and(|formula| !formula.is_name() || report.scope.names().any(|name| name == text.trim()))
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
        && !is_formula(text, report)
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
