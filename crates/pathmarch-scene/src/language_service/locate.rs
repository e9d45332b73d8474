//! The word at a place of a text.

use crate::language::keywords::DECAL;
use crate::language::tree::{Block, Entry, Node, Span};
use crate::materials;
use crate::reference::{IN_OBJECTS, MATERIAL_KINDS, PLACEMENTS, TEXTURES, TOP_OF_FILE};
use crate::textures;

/// Part of a node.
#[derive(Clone, Copy)]
pub(super) enum Part<'b> {
    Name,
    /// Name of a property.
    Property(&'b Entry<'static>),
    /// Argument, or value of a property.
    Value(&'b Entry<'static>),
}

/// A part of a node, and the nodes around it, the outermost first.
pub(super) struct Located<'b> {
    pub(super) parents: Vec<&'b Node<'static>>,
    pub(super) node: &'b Node<'static>,
    pub(super) part: Part<'b>,
}

fn contains(span: Span, at: usize) -> bool {
    (span.start as usize..=span.end as usize).contains(&at)
}

/// The part of a node at byte `at`.
pub(super) fn locate<'b>(file: &'b Block<'static>, at: usize) -> Option<Located<'b>> {
    let mut parents = Vec::new();
    let mut block = file;
    loop {
        // The last one that touches the place: a word that starts there rather than one that ends.
        let node = block.nodes.iter().rev().find(|node| contains(node.whole, at))?;
        let inside = |block: &&Block| block.span.start < at as u32 && at as u32 <= block.span.end;
        match node.children.as_ref().filter(inside) {
            Some(children) => {
                parents.push(node);
                block = children;
            }
            None => return Some(Located { parents, node, part: part(node, at)? }),
        }
    }
}

fn part<'b>(node: &'b Node<'static>, at: usize) -> Option<Part<'b>> {
    if contains(node.name.span, at) {
        return Some(Part::Name);
    }
    let entry = node.entries.iter().rev().find(|entry| contains(entry.span, at))?;
    let is_name = entry.name.as_ref().is_some_and(|name| contains(name.span, at));
    Some(if is_name { Part::Property(entry) } else { Part::Value(entry) })
}

/// Owners of the nodes in the braces of the innermost of `parents`, as the reference names them, the most special first.
pub(super) fn owners_in<'b>(parents: &[&'b Node<'static>]) -> Vec<&'b str> {
    let Some(parent) = parents.last() else { return vec![TOP_OF_FILE] };
    let mut owners = owners_of(parent);
    match &*parent.name.value {
        "material" => {
            let kinds = parent.child_nodes().iter().filter_map(|child| materials::kind(&child.name.value));
            owners.extend(kinds.map(|kind| kind.name).chain([MATERIAL_KINDS]));
        }
        DECAL => owners.push(PLACEMENTS),
        _ if parents.iter().rev().nth(1).is_some_and(|node| node.name.value == "material") => owners.push(TEXTURES),
        name if textures::names().contains(&name) => owners.extend([PLACEMENTS, TEXTURES]),
        _ if parents.iter().any(|node| matches!(&*node.name.value, "object" | "shape")) => {
            owners.extend([IN_OBJECTS, PLACEMENTS]);
        }
        _ => {}
    }
    owners
}

/// A node as the owner of its properties and of the nodes in its braces.
pub(super) fn owners_of<'b>(node: &'b Node<'static>) -> Vec<&'b str> {
    let argument = node.entries.iter().find(|entry| entry.name.is_none()).map(|entry| &entry.value);
    let is = |word: &str| matches!(argument, Some(crate::language::tree::Value::Text(text)) if text == word);
    match &*node.name.value {
        "sky" if is("gradient") => vec!["sky \"gradient\"", "sky"],
        "sky" if is("day") => vec!["sky \"day\"", "sky"],
        name => vec![name],
    }
}
