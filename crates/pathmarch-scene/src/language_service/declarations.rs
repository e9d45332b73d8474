//! What a text and the files that it includes declare: materials, shapes, fields and parameters.

use super::OpenText;
use crate::language::keywords::{FIELD, PARAM, SHAPE};
use crate::language::read::params::declared_name;
use crate::language::tree::{Node, Value};
use crate::materials;
use crate::reference::{Entry, IN_OBJECTS, TOP_OF_FILE};

impl OpenText {
    /// Nodes at the top of the text, then those of the files that it includes.
    fn top_nodes(&self) -> impl Iterator<Item = &Node<'static>> {
        self.file.iter().flat_map(|file| &file.nodes).chain(self.values.included.iter())
    }
    /// The first node of this word that declares this name.
    pub(super) fn declared(&self, word: &str, name: &str) -> Option<&Node<'static>> {
        self.top_nodes().find(|node| node.name.value == word && declared_name(node) == Some(name))
    }
    /// Help on a declared shape or field.
    pub(super) fn declared_solid(&self, name: &str) -> Option<Entry> {
        let node = self.declared(SHAPE, name).or_else(|| self.declared(FIELD, name))?;
        let doc = node.child_nodes().iter().find(|child| child.name.value == "doc").and_then(declared_name);
        let params = node.child_nodes().iter().filter(|child| child.name.value == PARAM);
        Some(Entry {
            owner: IN_OBJECTS,
            title: format!("{} `{name}`", node.name.value),
            doc: doc.unwrap_or("A shape of this scene.").to_owned(),
            details: params.filter_map(param_in_line).collect(),
        })
    }
    /// Help on a declared material.
    pub(super) fn declared_material(&self, name: &str) -> Option<Entry> {
        let node = self.declared("material", name)?;
        let kind = node.child_nodes().iter().find_map(|child| materials::kind(&child.name.value));
        let doc = kind.map_or("A material of this scene.".to_owned(), |kind| format!("`{}`: {}", kind.name, kind.doc));
        let title = format!("material `{name}`");
        Some(Entry { owner: TOP_OF_FILE, title, doc, details: Vec::new() })
    }
    /// The parameter that a formula within `parents` means.
    pub(super) fn parameter<'a>(&'a self, name: &str, parents: &[&'a Node<'static>]) -> Option<&'a Node<'static>> {
        let declares = |node: &&Node| node.name.value == PARAM && declared_name(node) == Some(name);
        let own = parents.first().and_then(|parent| parent.child_nodes().iter().find(declares));
        own.or_else(|| self.declared(PARAM, name))
    }
}

/// Help on a parameter that a node declares.
pub(super) fn param_entry(node: &Node) -> Option<Entry> {
    let name = declared_name(node)?;
    let doc = property(node, "doc").unwrap_or_else(|| "A parameter of this scene.".to_owned());
    let value = node.entries.iter().filter(|entry| entry.name.is_none()).nth(1).and_then(|entry| shown(&entry.value));
    let limit = |word: &str| property(node, word).map(|value| format!("{word} {value}"));
    let details = value.into_iter().chain(limit("min")).chain(limit("max")).collect();
    Some(Entry { owner: TOP_OF_FILE, title: format!("parameter `{name}`"), doc, details })
}

/// Name, help and value in a line.
fn param_in_line(node: &Node<'static>) -> Option<String> {
    let Entry { doc, details, .. } = param_entry(node)?;
    Some(format!("{}  {doc} {}", declared_name(node)?, details.join(", ")))
}

/// Value of a property, as text.
fn property(node: &Node, word: &str) -> Option<String> {
    let entry = node.entries.iter().find(|entry| entry.name.as_ref().is_some_and(|name| name.value == word))?;
    shown(&entry.value)
}

fn shown(value: &Value) -> Option<String> {
    match value {
        Value::Text(text) => Some(text.to_string()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}
