//! Parameters: numbers with a name, of a file or a declaration, which formulas use.
//!
//! `param "spin" 30 min=0 max=90 doc="Turn of the mill, degrees."` A parameter may use those before it.

use super::arguments::{arguments, missing_arguments, no_children, properties, string, twice};
use super::context::Context;
use super::numbers::{finite, out_of_range, value};
use crate::language::diagnostics::report::{draft, shown};
use crate::language::formulas::expression::is_name;
use crate::language::formulas::scope::{Evaluated, reserved};
use crate::language::keywords::PARAM;
use crate::language::tree::{Entry, Node, Span, Value};
use crate::scene::Parameter;
use crate::settings::Range;

/// Parameters that one file or one declaration may have.
const MOST: usize = 100;
const USAGE: &str = "`param \"name\" 1 min=0 max=2`";

/// A parameter and its value.
#[derive(Clone, Debug)]
pub(crate) struct Declared {
    pub(crate) name: String,
    /// Span of the name.
    pub(crate) span: Span,
    pub(crate) value: Evaluated,
    pub(crate) range: Range,
    pub(crate) doc: Option<String>,
}

impl From<Declared> for Parameter {
    fn from(param: Declared) -> Self {
        let Declared { name, value, range, doc, .. } = param;
        let range = (Some(range.min).filter(|min| *min > f32::MIN), Some(range.max).filter(|max| *max < f32::MAX));
        Self { name, value: value.value as f32, range, doc, animated: value.moving }
    }
}

/// A value that replaces a parameter's own, and its entry.
#[derive(Clone, Copy)]
pub(crate) struct Given<'n> {
    pub(crate) value: Evaluated,
    pub(crate) entry: &'n Entry<'n>,
}

/// The nodes that declare parameters.
pub(crate) fn nodes<'n, 't>(nodes: &'n [Node<'t>]) -> impl Iterator<Item = &'n Node<'t>> {
    nodes.iter().filter(|node| node.name.value == PARAM)
}

/// Name that a node declares, if any.
pub(crate) fn declared_name<'n>(node: &'n Node) -> Option<&'n str> {
    match &node.entries.iter().find(|entry| entry.name.is_none())?.value {
        Value::Text(name) => Some(name),
        _ => None,
    }
}

/// Values that a node's properties give to parameters, evaluated in the scope of the node.
pub(crate) fn given<'n>(named: &[(&'n str, &'n Entry<'n>)], context: &mut Context) -> Vec<(&'n str, Given<'n>)> {
    let mut all = Vec::new();
    for &(name, entry) in named {
        all.extend(value(entry, format_args!("`{name}`"), context).map(|value| (name, Given { value, entry })));
    }
    all
}

/// Declares the parameters of these nodes, which are in scope from then on; `given` are values that replace their own,
/// `taken` names that they must not have.
pub(crate) fn declare<'n>(
    nodes: impl Iterator<Item = &'n Node<'n>>,
    given: &[(&str, Given)],
    taken: &[&str],
    context: &mut Context,
) -> Vec<Declared> {
    let mut all: Vec<Declared> = Vec::new();
    for (index, node) in nodes.enumerate() {
        if index == MOST {
            let message = format!("There are more than {MOST} parameters here.");
            context.report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
            break;
        }
        let Some(param) = one(node, given, taken, context) else { continue };
        match all.iter().find(|other| other.name == param.name) {
            Some(first) => twice(&format!("The parameter {}", shown(&param.name)), param.span, first.span, context),
            None => {
                context.scope.define(&param.name, param.value);
                all.push(param);
            }
        }
    }
    all
}

fn one(node: &Node, given: &[(&str, Given)], taken: &[&str], context: &mut Context) -> Option<Declared> {
    no_children(node, context);
    let properties = properties(node, &["min", "max", "doc"], context);
    let entries = arguments(node, 2, USAGE, context);
    let name = match entries.first() {
        Some(entry) => checked_name(entry, taken, context),
        None => None,
    };
    if entries.len() < 2 && !node.broken() {
        missing_arguments(node, USAGE, context);
    }
    let own = entries.get(1).and_then(|entry| value(entry, "The value of a parameter", context));
    let (mut range, mut doc) = (Range::ANY, None);
    for (word, entry) in properties {
        let what = format!("`{word}`");
        match word {
            "min" => range.min = finite(entry, &what, context).unwrap_or(range.min),
            "max" => range.max = finite(entry, &what, context).unwrap_or(range.max),
            _ => doc = string(entry, &what, context).map(str::to_owned),
        }
        if range.min > range.max {
            let mistake = draft("pathmarch::out_of_range", entry.value_span, "`min` must be at most `max`.");
            context.report.add(mistake.label("no number is within this range"));
            range = Range::ANY;
        }
    }
    let (name, span) = name?;
    let given = given.iter().find(|(other, _)| *other == name).map(|(_, given)| *given);
    let own = own.zip(entries.get(1).copied());
    let Some((value, entry)) = given.map(|given| (given.value, given.entry)).or(own) else {
        let value = Evaluated { value: f64::NAN, moving: false };
        return Some(Declared { name: name.to_owned(), span, value, range, doc });
    };
    if !range.accepts(value.value as f32) {
        out_of_range(entry, value, format_args!("`{name}`"), &range.in_words(), context);
    }
    Some(Declared { name: name.to_owned(), span, value, range, doc })
}

/// A name that formulas can use.
fn checked_name<'n>(entry: &'n Entry, taken: &[&str], context: &mut Context) -> Option<(&'n str, Span)> {
    let name = string(entry, "The name of a parameter", context)?;
    let span = entry.value_span;
    if reserved().any(|other| other == name) || taken.contains(&name) {
        let message = format!("`{name}` is a reserved name.");
        let help = "Choose another name: `t` and `frame` are the moment; functions, constants and words of the \
                    language keep their meaning.";
        context.report.add(draft("pathmarch::reserved_name", span, message).label("taken").help(help));
        return None;
    }
    if !is_name(name) {
        let message = format!("{} cannot be the name of a parameter.", shown(name));
        let mistake = draft("pathmarch::bad_name", span, message).label("formulas could not use it");
        context.report.add(mistake.help("Names consist of letters, digits and `_`, and start with no digit."));
        return None;
    }
    Some((name, span))
}
