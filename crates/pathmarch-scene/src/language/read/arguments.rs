//! Arguments and properties of a node.

use super::context::Context;
use crate::language::diagnostics::report::{Draft, draft, shown};
use crate::language::diagnostics::spelling::suggestion;
use crate::language::tree::{Entry, Node, Span, Value};
use std::fmt::{self, Display};

fn described(value: &Value) -> &'static str {
    match value {
        Value::Text(_) => "a string",
        Value::Number(_) => "a number",
        Value::Bool(_) => "a truth value",
        Value::Null | Value::Bad => "nothing",
    }
}

/// The entry is not of the expected type.
pub(crate) fn wrong_type(entry: &Entry, what: impl Display, expected: &str, context: &mut Context) {
    type_mistake(entry, what, expected).into_iter().for_each(|mistake| context.report.add(mistake));
}

/// Mistake of an entry of another type; `None` if it could not be read.
fn type_mistake(entry: &Entry, what: impl Display, expected: &str) -> Option<Draft> {
    let mistake = draft("pathmarch::wrong_type", entry.value_span, format!("{what} must be {expected}."));
    (entry.value != Value::Bad).then(|| mistake.label(format!("this is {}", described(&entry.value))))
}

/// The string of an entry.
pub(crate) fn string<'n>(entry: &'n Entry, what: impl Display, context: &mut Context) -> Option<&'n str> {
    match &entry.value {
        Value::Text(text) => Some(text),
        _ => {
            wrong_type(entry, what, "a string", context);
            None
        }
    }
}

/// The truth value of an entry.
pub(crate) fn flag(entry: &Entry, what: impl Display, context: &mut Context) -> Option<bool> {
    match entry.value {
        Value::Bool(value) => Some(value),
        _ => {
            let mistake = type_mistake(entry, what, "#true or #false");
            mistake.into_iter().for_each(|mistake| context.report.add(mistake.expected(["#true", "#false"])));
            None
        }
    }
}

/// The properties among `known`, each at most once; reports all others.
pub(crate) fn properties<'n, 'k>(
    node: &'n Node,
    known: &[&'k str],
    context: &mut Context,
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
            context.report.add(mistake.help(help).expected(known.iter().copied()));
            continue;
        };
        match found.iter().find(|(other, _)| *other == word) {
            Some((_, first)) => twice(&format!("`{word}`"), entry.span, first.span, context),
            None => found.push((word, entry)),
        }
    }
    found
}

/// Something is given a second time.
pub(crate) fn twice(what: &str, second: Span, first: Span, context: &mut Context) {
    let message = format!("{what} is given twice.");
    context.report.add(draft("pathmarch::duplicate", second, message).label("again here").also(first, "first here"));
}

/// The arguments, of which at most `most` are allowed; `usage` is as in "`fov 40`".
pub(crate) fn arguments<'n>(
    node: &'n Node,
    most: usize,
    usage: impl Display,
    context: &mut Context,
) -> Vec<&'n Entry<'n>> {
    let mut arguments: Vec<&Entry> = node.entries.iter().filter(|entry| entry.name.is_none()).collect();
    if arguments.len() > most {
        let extra = arguments[most].span.to(arguments[arguments.len() - 1].span);
        let count = match (most, arguments.len() - most) {
            (0, _) => format!("`{}` takes no arguments.", node.name.value),
            (_, 1) => format!("`{}` has one argument too many.", node.name.value),
            (_, extra) => format!("`{}` has {extra} arguments too many.", node.name.value),
        };
        context.report.add(
            draft("pathmarch::unexpected_argument", extra, count).label("unused").help(format!("Expected {usage}.")),
        );
        arguments.truncate(most);
    }
    arguments
}

/// Reports braces where there should be none.
pub(crate) fn no_children(node: &Node, context: &mut Context) {
    if let Some(child) = node.child_nodes().first() {
        let message = format!("`{}` takes no nodes in braces.", node.name.value);
        context.report.add(draft("pathmarch::unexpected_children", child.name.span, message).label("unexpected node"));
    }
}

/// Reports too few arguments.
pub(crate) fn missing_arguments(node: &Node, usage: impl Display, context: &mut Context) {
    let message = format!("`{}` has too few arguments.", node.name.value);
    let mistake = draft("pathmarch::missing_argument", node.span(), message).label(format!("expected {usage}"));
    context.report.add(mistake);
}

/// Exactly `K` arguments and nothing else, each as `read` reads it; it is given the name of what it reads.
pub(super) fn exactly<const K: usize, T: Copy + Default>(
    node: &Node,
    usage: impl Display,
    context: &mut Context,
    read: impl Fn(&Entry, fmt::Arguments, &mut Context) -> Option<T>,
) -> Option<[T; K]> {
    properties(node, &[], context);
    no_children(node, context);
    let entries = arguments(node, K, &usage, context);
    let mut values = [T::default(); K];
    let mut are_read = true;
    for (value, entry) in values.iter_mut().zip(&entries) {
        let found = read(entry, format_args!("`{}`", node.name.value), context);
        are_read &= found.is_some();
        *value = found.unwrap_or_default();
    }
    if entries.len() < K {
        missing_arguments(node, usage, context);
        return None;
    }
    are_read.then_some(values)
}

/// The name that is a node's only argument, not empty.
pub(crate) fn name<'n>(node: &'n Node, usage: &str, context: &mut Context) -> Option<(&'n str, Span)> {
    let entry = *arguments(node, 1, usage, context).first()?;
    let text = string(entry, "A name", context)?;
    if text.is_empty() {
        context
            .report
            .add(draft("pathmarch::empty_name", entry.value_span, "This name is empty.").label("expected a name"));
        return None;
    }
    Some((text, entry.value_span))
}

/// Reads one of the names of a choice, which is a node's only argument.
pub(super) fn choice(node: &Node, noun: &str, names: &[&'static str], context: &mut Context) -> Option<&'static str> {
    let usage = format!("`{} \"{}\"`", node.name.value, names[0]);
    properties(node, &[], context);
    no_children(node, context);
    let entries = arguments(node, 1, &usage, context);
    let Some(entry) = entries.first() else {
        missing_arguments(node, &usage, context);
        return None;
    };
    named(entry, format_args!("`{}`", node.name.value), noun, names, context)
}

/// Reads one of the names of a choice from an entry; `noun` as in "There is no {noun} `x`".
pub(super) fn named(
    entry: &Entry,
    what: impl Display,
    noun: &str,
    names: &[&'static str],
    context: &mut Context,
) -> Option<&'static str> {
    let text = string(entry, what, context)?;
    let found = names.iter().find(|name| **name == text).copied();
    if found.is_none() {
        let message = format!("There is no {noun} {}.", shown(text));
        let mistake = draft("pathmarch::unknown_name", entry.value_span, message).label("unknown name");
        context.report.add(mistake.help(suggestion(text, names)).expected(names.iter().copied()));
    }
    found
}
