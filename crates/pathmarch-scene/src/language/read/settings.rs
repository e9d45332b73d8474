//! Settings of a table ([`crate::settings`]) in braces or as properties.

use super::arguments::{choice, flag, named, no_children, properties, twice};
use super::colours::colour;
use super::context::Context;
use super::numbers::{direction, in_range, is_formula, numbers, whole, whole_numbers};
use super::unexpected::unexpected_node;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::diagnostics::spelling::nearest;
use crate::language::tree::{Entry, Node, Value};
use crate::settings::{AUTO, Range, Setting, SettingKind, SettingValue, find, names};

/// Nodes found in braces, each of a known name and at most once.
pub(crate) struct NodesByName<'n> {
    found: Vec<&'n Node<'n>>,
}

impl<'n> NodesByName<'n> {
    /// Reports unknown nodes and repeated ones. `place` as in "in a camera".
    pub(crate) fn new(node: &'n Node<'n>, known: &[&str], place: &str, context: &mut Context) -> Self {
        Self::with_repeated(node, known, &[], place, context)
    }
    /// As [`Self::new`]; the names in `repeated` may occur more than once, and are not found.
    pub(crate) fn with_repeated(
        node: &'n Node<'n>,
        known: &[&str],
        repeated: &[&str],
        place: &str,
        context: &mut Context,
    ) -> Self {
        let mut found: Vec<&'n Node<'n>> = Vec::new();
        for child in node.child_nodes() {
            if !known.contains(&&*child.name.value) {
                unexpected_node(&child.name, known, place, context);
            } else if repeated.contains(&&*child.name.value) {
                continue;
            } else if let Some(first) = found.iter().find(|other| other.name.value == child.name.value) {
                twice(&format!("`{}`", child.name.value), child.name.span, first.name.span, context);
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
    pub(crate) fn require(
        &self,
        name: &str,
        example: &str,
        owner: &Node,
        context: &mut Context,
    ) -> Option<&'n Node<'n>> {
        let found = self.get(name);
        let misspelt = owner.child_nodes().iter().any(|child| nearest(&child.name.value, [name]).is_some());
        if found.is_none() && !owner.broken() && !misspelt {
            let message = format!("This `{}` has no `{name}`.", owner.name.value);
            let mistake = draft("pathmarch::missing_node", owner.name.span, message)
                .label(format!("expected `{name}` in its braces"));
            context.report.add(mistake.help(format!("For example: {example}.")));
        }
        found
    }
}

/// Reads the three numbers of a node; `None` after a mistake.
pub(super) fn triple(node: &Node, setting: &Setting, context: &mut Context) -> Option<[f32; 3]> {
    match setting.kind {
        SettingKind::Direction { .. } => direction(node, context),
        _ => numbers(node, setting.usage(), Range::ANY, context),
    }
}

/// Reads the number of a node; `None` after a mistake.
pub(super) fn single(node: &Node, setting: &Setting, context: &mut Context) -> Option<f32> {
    numbers(node, setting.usage(), setting.kind.range(), context).map(|[number]| number)
}

/// Settings that are nodes in braces. A value is the default if its node is absent, and `None` after a mistake, which
/// is reported.
pub(super) struct Braces<'n> {
    node: &'n Node<'n>,
    table: &'static [Setting],
    found: NodesByName<'n>,
}

impl<'n> Braces<'n> {
    /// Finds the nodes. Reports unknown nodes and repeated ones; `place` as in "in a camera".
    pub(super) fn new(node: &'n Node<'n>, table: &'static [Setting], place: &str, context: &mut Context) -> Self {
        Self { node, table, found: NodesByName::new(node, &names(table), place, context) }
    }
    /// The node of this name.
    pub(super) fn get(&self, name: &str) -> Option<&'n Node<'n>> {
        self.found.get(name)
    }
    /// The setting of this name, and its node. Reports a missing node of a required setting.
    fn find(&self, name: &str, context: &mut Context) -> (&'static Setting, Option<&'n Node<'n>>) {
        let setting = find(self.table, name);
        let found = match setting.required {
            true => self.found.require(name, setting.example, self.node, context),
            false => self.found.get(name),
        };
        (setting, found)
    }
    /// Three numbers.
    pub(super) fn triple(&self, name: &str, context: &mut Context) -> Option<[f32; 3]> {
        let (setting, found) = self.find(name, context);
        match (found, setting.kind) {
            (Some(node), _) => triple(node, setting, context),
            (None, SettingKind::Triple { default } | SettingKind::Direction { default }) if !setting.required => {
                Some(default)
            }
            _ => None,
        }
    }
    /// A number.
    pub(super) fn number(&self, name: &str, context: &mut Context) -> Option<f32> {
        let (setting, found) = self.find(name, context);
        match found {
            Some(node) => single(node, setting, context),
            None => setting.kind.default_number(),
        }
    }
    /// A number, or `None` inside for "auto".
    pub(super) fn number_or_auto(&self, name: &str, context: &mut Context) -> Option<Option<f32>> {
        let is_auto = |node: &Node| match &node.entries[..] {
            [entry] if entry.name.is_none() => matches!(&entry.value, Value::Text(text) if *text == AUTO),
            _ => false,
        };
        match self.get(name).filter(|node| is_auto(node)) {
            Some(node) => {
                no_children(node, context);
                Some(None)
            }
            None if self.get(name).is_some_and(|node| reports_near_auto(node, context)) => None,
            None => self.number(name, context).map(Some),
        }
    }
    /// A colour.
    pub(super) fn colour(&self, name: &str, context: &mut Context) -> Option<[f32; 3]> {
        let (setting, found) = self.find(name, context);
        let SettingKind::Colour { max, default } = setting.kind else { return None };
        match found {
            Some(node) => colour(node, Range::from_to(0.0, max), context),
            None => default.filter(|_| !setting.required),
        }
    }
    /// The value that a node gives a render setting; `None` after a mistake.
    pub(super) fn value(setting: &Setting, node: &Node, context: &mut Context) -> Option<SettingValue> {
        Some(match setting.kind {
            SettingKind::Number { .. } => SettingValue::Number(single(node, setting, context)?),
            SettingKind::Whole { range, .. } => {
                let [number] = whole_numbers(node, setting.usage(), range, context)?;
                SettingValue::Whole(number)
            }
            SettingKind::Size { range, .. } => {
                SettingValue::Size(whole_numbers::<2>(node, setting.usage(), range, context)?.into())
            }
            SettingKind::Choice { noun, names } => SettingValue::Choice(choice(node, noun, &names(), context)?),
            _ => return None,
        })
    }
}

/// Reports a word that stands for "auto" but is another one, such as "automatic", and returns true.
fn reports_near_auto(node: &Node, context: &mut Context) -> bool {
    let [entry] = &node.entries[..] else { return false };
    let Value::Text(text) = &entry.value else { return false };
    let word = text.to_lowercase();
    let is_near = word.starts_with(AUTO) || nearest(&word, [AUTO]).is_some();
    if !is_near || is_formula(text, context) {
        return false;
    }
    let message = format!("There is no value {} of `{}`.", shown(text), node.name.value);
    let mistake = draft("pathmarch::unknown_name", entry.value_span, message).label("unknown value");
    let help = format!("Write `{} \"{AUTO}\"`, or a number.", node.name.value);
    context.report.add(mistake.help(help).expected([AUTO]));
    true
}

/// Settings that are properties of a node. A value is the default if its property is absent or wrong.
pub(super) struct Properties<'n> {
    table: &'static [Setting],
    found: Vec<(&'static str, &'n Entry<'n>)>,
}

impl<'n> Properties<'n> {
    /// Chooses the settings of a table among properties that have been found.
    pub(super) fn of(table: &'static [Setting], found: &[(&str, &'n Entry<'n>)]) -> Self {
        let ours = |(word, entry): &(&str, &'n Entry<'n>)| {
            let setting = table.iter().find(|setting| setting.name == *word)?;
            Some((setting.name, *entry))
        };
        Self { table, found: found.iter().filter_map(ours).collect() }
    }
    /// Finds the properties. Reports unknown properties and repeated ones.
    pub(super) fn new(node: &'n Node<'n>, table: &'static [Setting], context: &mut Context) -> Self {
        Self { table, found: properties(node, &names(table), context) }
    }
    fn get(&self, name: &str) -> Option<&'n Entry<'n>> {
        self.found.iter().find(|(word, _)| *word == name).map(|(_, entry)| *entry)
    }
    /// A number; `None` if it is absent and has no default.
    pub(super) fn number(&self, name: &str, context: &mut Context) -> Option<f32> {
        let kind = find(self.table, name).kind;
        let given = self.get(name).and_then(|entry| in_range(entry, format_args!("`{name}`"), kind.range(), context));
        given.or(kind.default_number())
    }
    /// A whole number; `None` after a mistake.
    pub(super) fn whole(&self, name: &str, context: &mut Context) -> Option<u32> {
        let SettingKind::Whole { range, default } = find(self.table, name).kind else { return None };
        self.get(name).map_or(Some(default), |entry| whole(entry, format_args!("`{name}`"), range, context))
    }
    /// A name, the first when absent; `None` after a mistake.
    pub(super) fn choice(&self, name: &str, context: &mut Context) -> Option<&'static str> {
        let SettingKind::Choice { noun, names } = find(self.table, name).kind else { return None };
        let names = names();
        match self.get(name) {
            Some(entry) => named(entry, format_args!("`{name}`"), noun, &names, context),
            None => names.first().copied(),
        }
    }
    /// A truth value.
    pub(super) fn flag(&self, name: &str, context: &mut Context) -> bool {
        let given = self.get(name).and_then(|entry| flag(entry, format_args!("`{name}`"), context));
        given.unwrap_or(matches!(find(self.table, name).kind, SettingKind::Flag { default: true }))
    }
}
