//! Names of nodes.

use super::transaction::Transaction;
use crate::document::tree::nodes::text_argument;
use crate::document::tree::outline::ItemKind;
use crate::language::keywords::PARAM;
use crate::language::tree::Node;

/// Title of a node in messages and labels.
pub(super) fn title(node: &Node<'static>, kind: ItemKind) -> String {
    let name = if kind.is_named() { text_argument(node) } else { None };
    let unnamed = if kind == ItemKind::Camera { "main" } else { &node.name.value };
    name.unwrap_or(unnamed).to_owned()
}

/// A word with its article.
pub(super) fn one(word: &str) -> String {
    format!("{} {word}", if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" })
}

/// A free name: `wanted`, or with a number after it.
pub(super) fn free_name(transaction: &Transaction, word: &str, wanted: &str) -> String {
    let names = names(transaction, word);
    if !names.iter().any(|name| name == wanted) {
        return wanted.to_owned();
    }
    let stem = wanted.trim_end_matches(|c: char| c.is_ascii_digit());
    let stem = if stem.len() < wanted.len() && stem.ends_with(' ') { stem.trim_end() } else { wanted };
    let between = if word == PARAM { "_" } else { " " };
    let mut numbered = (2_usize..).map(|number| format!("{stem}{between}{number}"));
    numbered.find(|name| !names.contains(name)).unwrap_or_default()
}

/// The names of all nodes of this word.
pub(super) fn names(transaction: &Transaction, word: &str) -> Vec<String> {
    let nodes = transaction.file.nodes.iter().filter(|node| node.name.value == word);
    let name = |node| text_argument(node).map(str::to_owned).or_else(|| (word == "camera").then(|| "main".to_owned()));
    nodes.filter_map(name).collect()
}
