//! Places of parameters in nodes.

use crate::document::tree::nodes::{arguments, child, property, texture_node};
use crate::language::keywords::{COLOUR, COLOUR_POSITION, DECAL, ORBIT_TRAP};
use crate::language::tree::{Entry, Node};
use std::borrow::Cow;

/// Place of a parameter in a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Place {
    /// The first argument, a string.
    Name,
    /// The argument of this index.
    Argument(usize),
    /// The words that name the kind of the node.
    Kind,
    /// The parameter of a shape or an operator with this index: an argument or a property.
    Solid(usize),
    /// A property.
    Property(Cow<'static, str>),
    /// All arguments.
    Arguments,
    /// The arguments of the child of this name.
    Node(&'static str),
    /// A property of the child of this name.
    NodeProperty(&'static str, &'static str),
    /// The kind of the texture in the braces of the child of this name.
    Texture(&'static str),
    /// A place in that texture, or in the orbit trap.
    Inside(&'static str, Inside),
    /// A place in the decal of this index.
    Decal(usize, Inside),
}

/// Place in a texture, in a colour ramp or in a decal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Inside {
    /// The first argument.
    Argument,
    /// A property.
    Property(&'static str),
    /// The arguments of the child of this name.
    Node(&'static str),
    /// The colour of this index.
    Colour(usize),
    /// The position of the colour of this index.
    ColourPosition(usize),
}

/// Arguments or property at a place; none for places that are no entries.
pub(super) fn entries<'n>(node: &'n Node<'static>, place: &Place) -> Vec<&'n Entry<'static>> {
    let all = |node: &'n Node<'static>| arguments(node).collect();
    match place {
        Place::Kind | Place::Solid(_) | Place::Texture(_) => Vec::new(),
        Place::Name => arguments(node).take(1).collect(),
        Place::Argument(index) => arguments(node).skip(*index).take(1).collect(),
        Place::Property(name) => property(node, name).into_iter().collect(),
        Place::Arguments => all(node),
        Place::Node(name) => child(node, name).map_or_else(Vec::new, all),
        Place::NodeProperty(name, word) => {
            child(node, name).and_then(|child| property(child, word)).into_iter().collect()
        }
        Place::Inside(_, inside) | Place::Decal(_, inside) => {
            match (holder(node, place).and_then(|holder| target(holder, *inside)), inside) {
                (Some(node), Inside::Property(word)) => property(node, word).into_iter().collect(),
                (Some(node), Inside::ColourPosition(_)) => property(node, COLOUR_POSITION).into_iter().collect(),
                (Some(node), Inside::Argument) => arguments(node).take(1).collect(),
                (node, _) => node.map_or_else(Vec::new, all),
            }
        }
    }
}

/// Node around a place inside: a texture, the orbit trap, or a decal.
pub(crate) fn holder<'n>(material: &'n Node<'static>, place: &Place) -> Option<&'n Node<'static>> {
    match place {
        Place::Inside(owner, _) if *owner == ORBIT_TRAP => child(material, ORBIT_TRAP),
        Place::Inside(owner, _) => texture_node(material, owner),
        Place::Decal(index, _) => decals(material).nth(*index),
        _ => None,
    }
}

/// Decals of a material.
pub(super) fn decals<'n>(material: &'n Node<'static>) -> impl Iterator<Item = &'n Node<'static>> {
    material.child_nodes().iter().filter(|child| child.name.value == DECAL)
}

/// Colours in a texture or an orbit trap.
pub(super) fn colours<'n>(node: &'n Node<'static>) -> impl Iterator<Item = &'n Node<'static>> {
    node.child_nodes().iter().filter(|child| child.name.value == COLOUR)
}

/// Node that has the value of a place inside `holder`.
pub(crate) fn target<'n>(holder: &'n Node<'static>, inside: Inside) -> Option<&'n Node<'static>> {
    match inside {
        Inside::Argument | Inside::Property(_) => Some(holder),
        Inside::Node(name) => child(holder, name),
        Inside::Colour(index) | Inside::ColourPosition(index) => colours(holder).nth(index),
    }
}
