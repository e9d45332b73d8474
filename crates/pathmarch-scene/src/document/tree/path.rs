//! Paths to nodes in the tree of a file.

use std::fmt;

/// A node of a [`Document`](crate::Document): its index among the [`Item`](crate::document::Item)s at the top of the file, then
/// among the children of that one, and so on. Parameter nodes such as `at` have no path, so that giving a shape a place
/// changes no path. The empty path is the file itself and names no node.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Path(Vec<usize>);

impl Path {
    /// The node at the top of the file with this index.
    pub fn top(index: usize) -> Self {
        Self(vec![index])
    }
    /// The child with this index.
    pub fn child(&self, index: usize) -> Self {
        let mut indexes = self.0.clone();
        indexes.push(index);
        Self(indexes)
    }
    /// The node that this one is a child of; `None` at the top of the file.
    pub fn parent(&self) -> Option<Self> {
        let (_, parents) = self.0.split_last()?;
        (!parents.is_empty()).then(|| Self(parents.to_vec()))
    }
    /// The indexes, from the top of the file.
    pub fn indexes(&self) -> &[usize] {
        &self.0
    }
    /// The index among its siblings; 0 for the empty path.
    pub fn index(&self) -> usize {
        self.0.last().copied().unwrap_or(0)
    }
    /// True if it is `other` or within it.
    pub fn is_within(&self, other: &Self) -> bool {
        self.0.starts_with(&other.0)
    }
    /// True if it has the same parent as `other`.
    pub fn is_sibling_of(&self, other: &Self) -> bool {
        self.0.len() == other.0.len() && self.parent() == other.parent()
    }
    /// Path of this node after `removed` is removed; `None` if it is removed with it.
    pub fn after_removal(&self, removed: &Self) -> Option<Self> {
        if self.is_within(removed) {
            return None;
        }
        let mut indexes = self.0.clone();
        if let Some(index) = self.later_sibling(removed) {
            indexes[index] -= 1;
        }
        Some(Self(indexes))
    }
    /// Path of this node after another is inserted at `inserted`.
    pub fn after_insertion(&self, inserted: &Self) -> Self {
        let mut indexes = self.0.clone();
        if let Some(index) = self.later_sibling(inserted) {
            indexes[index] += 1;
        }
        Self(indexes)
    }
    /// Path of this node after `from` is moved to `to`.
    pub fn after_move(&self, from: &Self, to: &Self) -> Self {
        match self.after_removal(from) {
            Some(path) => path.after_insertion(to),
            None => Self(to.0.iter().chain(&self.0[from.0.len()..]).copied().collect()),
        }
    }
    /// The level at which this path goes through `other` or a later sibling of it.
    fn later_sibling(&self, other: &Self) -> Option<usize> {
        let (&index, parents) = other.0.split_last()?;
        let level = parents.len();
        (self.0.starts_with(parents) && *self.0.get(level)? >= index).then_some(level)
    }
}

impl From<Vec<usize>> for Path {
    fn from(indexes: Vec<usize>) -> Self {
        Self(indexes)
    }
}

impl fmt::Display for Path {
    /// As in `7/0/2`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let indexes: Vec<String> = self.0.iter().map(usize::to_string).collect();
        f.write_str(&indexes.join("/"))
    }
}
