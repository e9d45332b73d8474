//! Checks of a scene that has been read: limits of 32-bit numbers, and warnings.

pub(crate) mod extent;
mod media;
pub(crate) mod warnings;

use super::tree::{Block, Node, Value};

/// Nodes of these words that the scene has, in their order: those that are not hidden.
fn visible_nodes<'f>(file: &'f Block, words: &'f [&str]) -> impl Iterator<Item = &'f Node<'f>> {
    let is_hidden = |node: &Node| {
        let hidden = node.entries.iter().find(|entry| entry.name.as_ref().is_some_and(|name| name.value == "hidden"));
        hidden.is_some_and(|entry| entry.value == Value::Bool(true))
    };
    file.nodes.iter().filter(move |node| words.contains(&&*node.name.value) && !is_hidden(node))
}
