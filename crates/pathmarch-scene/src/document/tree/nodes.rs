//! Lookups in nodes.

use crate::language::Values;
use crate::language::formulas::expression::Expression;
use crate::language::tree::{Block, Entry, Node, Value};
use crate::materials::{self, MaterialKind};
use crate::textures;

/// Arguments of a node: its entries without a name.
pub(crate) fn arguments<'n>(node: &'n Node<'static>) -> impl Iterator<Item = &'n Entry<'static>> {
    node.entries.iter().filter(|entry| entry.name.is_none())
}

/// First argument, if it is a string.
pub(crate) fn text_argument<'n>(node: &'n Node<'static>) -> Option<&'n str> {
    match &arguments(node).next()?.value {
        Value::Text(text) => Some(text),
        _ => None,
    }
}

/// Property of this name.
pub(crate) fn property<'n>(node: &'n Node<'static>, name: &str) -> Option<&'n Entry<'static>> {
    node.entries.iter().find(|entry| entry.name.as_ref().is_some_and(|given| given.value == name))
}

/// Child of this name.
pub(crate) fn child<'n>(node: &'n Node<'static>, name: &str) -> Option<&'n Node<'static>> {
    node.child_nodes().iter().find(|child| child.name.value == name)
}

/// Kind of a material node.
pub(crate) fn material_kind(node: &Node) -> Option<&'static MaterialKind> {
    node.child_nodes().iter().find_map(|child| materials::kind(&child.name.value))
}

/// Names of all materials of a file and of the files that it includes.
pub(crate) fn material_names(file: &Block<'static>, values: &Values) -> Vec<String> {
    let nodes = file.nodes.iter().chain(values.included.iter());
    let materials = nodes.filter(|node| node.name.value == "material");
    materials.filter_map(|node| text_argument(node).map(str::to_owned)).collect()
}

/// Texture in the braces of a material's child `owner`.
pub(crate) fn texture_node<'n>(material: &'n Node<'static>, owner: &str) -> Option<&'n Node<'static>> {
    child(material, owner)?.child_nodes().iter().find(|node| textures::names().contains(&&*node.name.value))
}

/// Form of a sky node, a name of [`SKY_FORMS`](crate::settings::SKY_FORMS).
pub(crate) fn sky_form(node: &Node<'static>) -> &'static str {
    match text_argument(node) {
        Some("gradient") => "gradient",
        Some("day") => "day",
        Some(text) if !text.starts_with('#') && Expression::read(text).is_err() => "picture",
        _ => "colour",
    }
}
