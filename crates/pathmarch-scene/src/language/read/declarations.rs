//! Shapes that a file declares: `shape "bolt" { param length 0.1; cylinder 0.01 height=length; … }`.
//!
//! A declared shape is the union of its children. Each use is expanded: the children are read again with the parameters
//! of the use in scope. Before that, every declaration is checked once by itself, without expanding those that it uses;
//! one with a mistake, or a recursive one, is never expanded, so that a mistake is reported once and expansion ends.
//! Cost: that of the resulting shapes, whose number is bounded as if they had been written out.

use super::arguments::{arguments, missing_arguments, name, properties, twice};
use super::context::Context;
use super::custom_sdf::CustomSdfs;
use super::params::{declared_name, nodes};
use crate::language::diagnostics::report::{Report, draft, shown};
use crate::language::formulas::scope::Scope;
use crate::language::keywords::{FIELD, MATERIAL, MESH, NORMAL, PARAM, PLACEMENT, SHAPE, solids};
use crate::language::syntax::MAX_NESTING;
use crate::language::tree::{Entry, Node, Span};
use std::collections::HashMap;

/// A declared shape.
pub(crate) struct Declaration<'n> {
    pub(crate) name: &'n str,
    pub(crate) node: &'n Node<'n>,
    /// Names of its parameters.
    pub(crate) params: Vec<&'n str>,
    /// True if it may be expanded: it has no mistakes of its own.
    pub(crate) sound: bool,
}

impl Declaration<'_> {
    /// As in "`bolt length head`".
    pub(crate) fn usage(&self) -> String {
        let words: Vec<&str> = std::iter::once(self.name).chain(self.params.iter().copied()).collect();
        format!("`{}`", words.join(" "))
    }
}

/// The declared shapes of a file, by name.
#[derive(Default)]
pub(crate) struct Declarations<'n> {
    pub(crate) list: Vec<Declaration<'n>>,
    index: HashMap<&'n str, usize>,
}

impl<'n> Declarations<'n> {
    /// Finds the declarations among these nodes. Reports mistakes in their names, and recursion.
    pub(crate) fn gather(
        nodes: impl IntoIterator<Item = &'n Node<'n>>,
        fields: &CustomSdfs,
        context: &mut Context,
    ) -> Self {
        let mut all = Self::default();
        for node in nodes.into_iter().filter(|node| node.name.value == SHAPE) {
            all.declare(node, fields, context);
        }
        all.find_cycles(context);
        all
    }
    /// The index of the shape of this name.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }
    /// Names of all.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'n str> {
        self.list.iter().map(|declaration| declaration.name)
    }

    fn declare(&mut self, node: &'n Node<'n>, fields: &CustomSdfs, context: &mut Context) {
        let usage = "`shape \"name\" { … }`";
        properties(node, &[], context);
        if !node.entries.iter().any(|entry| entry.name.is_none()) {
            missing_arguments(node, usage, context);
        }
        let Some((name, span)) = name(node, usage, context) else { return };
        let taken = solids().chain(fields.names()).chain(PLACEMENT.iter().copied()).chain([NORMAL, PARAM, MATERIAL]);
        if taken.into_iter().any(|word| word == name) || fields.is_broken(name) {
            let message = format!("{} is a reserved name.", shown(name));
            let mistake = draft("pathmarch::reserved_name", span, message).label("taken");
            context
                .report
                .add(mistake.help("Choose another name: shapes, operators, fields and placements keep theirs."));
            return;
        }
        match self.index.get(name) {
            Some(&first) => {
                let first = self.list[first].node.entries.iter().find(|entry| entry.name.is_none());
                let first = first.map_or(span, |entry| entry.value_span);
                twice(&format!("The shape {}", shown(name)), span, first, context);
            }
            None => {
                self.index.insert(name, self.list.len());
                let params = nodes(node.child_nodes()).filter_map(|param| declared_name(param)).collect();
                self.list.push(Declaration { name, node, params, sound: true });
            }
        }
    }

    /// Marks users of unsound shapes as unsound, so that they are not expanded either.
    pub(crate) fn spread(&mut self) {
        let mut users = vec![Vec::new(); self.list.len()];
        for (user, declaration) in self.list.iter().enumerate() {
            self.uses(declaration.node).into_iter().for_each(|(used, _)| users[used].push(user));
        }
        let mut left: Vec<usize> = (0..self.list.len()).filter(|&index| !self.list[index].sound).collect();
        while let Some(index) = left.pop() {
            for &user in &users[index] {
                if std::mem::replace(&mut self.list[user].sound, false) {
                    left.push(user);
                }
            }
        }
    }

    /// Reports where a shape is used within itself, straight or through others.
    fn find_cycles(&mut self, context: &mut Context) {
        #[derive(Clone, Copy, PartialEq)]
        enum Seen {
            Never,
            Now,
            Before,
        }
        let uses: Vec<Vec<(usize, Span)>> = self.list.iter().map(|declaration| self.uses(declaration.node)).collect();
        let mut seen = vec![Seen::Never; self.list.len()];
        for start in 0..self.list.len() {
            if seen[start] != Seen::Never {
                continue;
            }
            // Each with the number of its uses that have been followed; a stack of our own, for chains may be long.
            let mut path = vec![(start, 0)];
            seen[start] = Seen::Now;
            while let Some((at, next)) = path.last_mut() {
                let Some(&(used, span)) = uses[*at].get(*next) else {
                    seen[*at] = Seen::Before;
                    path.pop();
                    continue;
                };
                *next += 1;
                match seen[used] {
                    Seen::Never => {
                        seen[used] = Seen::Now;
                        path.push((used, 0));
                    }
                    Seen::Now => {
                        let message = format!("The shape {} would contain itself.", shown(self.list[used].name));
                        let mistake = draft("pathmarch::recursion", span, message).label("used within itself");
                        context.report.add(mistake.also(self.list[used].node.name.span, "declared here"));
                        let inside = path.iter().skip_while(|(at, _)| *at != used);
                        inside.for_each(|(at, _)| self.list[*at].sound = false);
                    }
                    Seen::Before => {}
                }
            }
        }
    }

    /// Declared shapes used within a node, with the spans of their names.
    fn uses(&self, node: &Node) -> Vec<(usize, Span)> {
        let mut all = Vec::new();
        for child in node.child_nodes() {
            all.extend(self.find(&child.name.value).map(|index| (index, child.name.span)));
            all.extend(self.uses(child));
        }
        all
    }
}

/// Number of shapes in each declared shape, by name, except for recursive ones.
pub(crate) fn leaf_counts<'n>(nodes: impl IntoIterator<Item = &'n Node<'n>>) -> HashMap<String, usize> {
    let mut context =
        Context { report: Report::new("", ""), scope: Scope::default(), colours: Vec::new(), folder: None };
    let nodes: Vec<&Node> = nodes.into_iter().collect();
    let all = Declarations::gather(nodes.iter().copied(), &CustomSdfs::default(), &mut context);
    // A field is one shape.
    let fields = nodes.iter().filter(|node| node.name.value == FIELD).filter_map(|node| declared_name(node));
    let mut counts: HashMap<String, usize> = fields.map(|name| (name.to_owned(), 1)).collect();
    // Each round knows those of which all parts are known: as many rounds as they are deep, of which there
    // is a limit.
    let sound: Vec<&Declaration> = all.list.iter().filter(|declaration| declaration.sound).collect();
    for _ in 0..=MAX_NESTING {
        let before = counts.len();
        for declaration in &sound {
            if !counts.contains_key(declaration.name)
                && let Some(count) = leaves(declaration.node, &all, &counts)
            {
                counts.insert(declaration.name.to_owned(), count);
            }
        }
        if counts.len() == before {
            break;
        }
    }
    counts
}

/// Number of shapes in a node's braces; `None` while a declared shape in it has not been counted.
fn leaves(node: &Node, all: &Declarations, counts: &HashMap<String, usize>) -> Option<usize> {
    node.child_nodes().iter().try_fold(0_usize, |sum, child| {
        let own = match pathmarch_field::registry::solid(&child.name.value) {
            Some(solid) if !solid.is_operator() => 1,
            Some(_) => leaves(child, all, counts)?,
            None if child.name.value == MESH => 1,
            None => match counts.get(&*child.name.value) {
                Some(&count) => count,
                None if all.find(&child.name.value).is_some() => return None,
                None => 0,
            },
        };
        Some(sum.saturating_add(own))
    })
}

/// The arguments and properties of a use that give values to parameters, by name.
pub(crate) fn given_entries<'n>(
    declaration: &Declaration<'n>,
    node: &'n Node<'n>,
    named: Vec<(&'n str, &'n Entry<'n>)>,
    context: &mut Context,
) -> Vec<(&'n str, &'n Entry<'n>)> {
    let entries = arguments(node, declaration.params.len(), declaration.usage(), context);
    let mut all: Vec<_> = declaration.params.iter().copied().zip(entries).collect();
    for (name, entry) in named {
        match all.iter().find(|(other, _)| *other == name) {
            Some((_, first)) => twice(&format!("`{name}`"), entry.span, first.span, context),
            None => all.push((name, entry)),
        }
    }
    all
}
