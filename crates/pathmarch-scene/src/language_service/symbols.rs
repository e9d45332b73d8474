//! Outline of a text: what its nodes at the top declare.

use super::OpenText;
use crate::language::keywords::{FIELD, INCLUDE, PARAM, SHAPE};
use crate::language::read::params::declared_name;
use crate::language::tree::{Node, Span};
use crate::materials;
use std::ops::Range;

/// Kind of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymbolKind {
    /// A camera.
    Camera,
    /// A sun or a point light, or the sky.
    Light,
    /// A material.
    Material,
    /// An object.
    Object,
    /// A declared shape.
    Shape,
    /// A custom shape.
    Field,
    /// A parameter.
    Parameter,
    /// An included file.
    Include,
    /// Settings of rendering.
    Settings,
}

/// A node at the top of a text.
#[derive(Clone, Debug, PartialEq)]
pub struct Symbol {
    /// Its name, or else its first word.
    pub name: String,
    /// Its first word, and the kind of a material.
    pub detail: String,
    /// Kind of the node.
    pub kind: SymbolKind,
    /// Bytes of the node.
    pub range: Range<usize>,
    /// Bytes of its name.
    pub name_range: Range<usize>,
}

impl OpenText {
    /// Symbols in the order of the text.
    pub fn symbols(&self) -> Vec<Symbol> {
        self.file.iter().flat_map(|file| &file.nodes).filter_map(symbol).collect()
    }
}

fn symbol(node: &Node<'static>) -> Option<Symbol> {
    let word = &*node.name.value;
    let kind = match word {
        "camera" => SymbolKind::Camera,
        "sun" | "point" | "spot" | "sky" | "fog" => SymbolKind::Light,
        "material" => SymbolKind::Material,
        "object" => SymbolKind::Object,
        "render" => SymbolKind::Settings,
        SHAPE => SymbolKind::Shape,
        FIELD => SymbolKind::Field,
        PARAM => SymbolKind::Parameter,
        INCLUDE => SymbolKind::Include,
        _ => return None,
    };
    let name = declared_name(node);
    let name_entry = node.entries.iter().find(|entry| name.is_some() && entry.name.is_none());
    let material = node.child_nodes().iter().find_map(|child| materials::kind(&child.name.value));
    let detail =
        material.filter(|_| word == "material").map_or(word.to_owned(), |kind| format!("{word}: {}", kind.name));
    Some(Symbol {
        name: name.filter(|name| !name.is_empty()).unwrap_or(word).to_owned(),
        detail,
        kind,
        range: range(node.whole),
        name_range: range(name_entry.map_or(node.name.span, |entry| entry.value_span)),
    })
}

pub(super) fn range(span: Span) -> Range<usize> {
    span.start as usize..span.end as usize
}
