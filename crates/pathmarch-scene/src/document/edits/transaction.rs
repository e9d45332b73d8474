//! An edit in progress: a series of patches of the text, each found in the tree of the text before it.
//!
//! The document changes only once the series is complete.

use super::write::Writer;
use crate::document::error::EditError;
use crate::document::parameters::{Parameter, parameters};
use crate::document::text::layout::{Chunk, Site, Style, insert_first};
use crate::document::text::patch::{Hunk, Patch, apply, compose};
use crate::document::tree::outline::{Found, ItemKind, find, shown};
use crate::document::tree::path::Path;
use crate::language::read::custom_sdf::CustomSdfs;
use crate::language::tree::Block;
use crate::language::{self, Values};
use std::borrow::Cow;

/// A text, its tree, and the ranges in which it differs from the document's.
pub(crate) struct Transaction<'d> {
    pub(crate) text: Cow<'d, str>,
    pub(crate) file: Cow<'d, Block<'static>>,
    pub(crate) style: &'d Style,
    /// Values of formulas, by their places in the document's text.
    known: &'d Values,
    hunks: Vec<Hunk>,
}

impl<'d> Transaction<'d> {
    pub(crate) fn new(text: &'d str, file: &'d Block<'static>, known: &'d Values, style: &'d Style) -> Self {
        Self { text: Cow::Borrowed(text), file: Cow::Borrowed(file), style, known, hunks: Vec::new() }
    }

    /// Applies patches and parses the new text, for further patches.
    pub(crate) fn then(&mut self, patches: Vec<Patch>) -> Result<(), EditError> {
        if patches.is_empty() {
            return Ok(());
        }
        self.last(patches);
        let Some(file) = language::nodes(&self.text) else { return Err(EditError::Unreadable("the scene".to_owned())) };
        self.file = Cow::Owned(file.into_owned());
        Ok(())
    }

    /// Applies the last patches; the tree no longer matches the text.
    pub(crate) fn last(&mut self, patches: Vec<Patch>) {
        let (text, hunks) = apply(&self.text, patches);
        self.hunks = compose(&self.hunks, &hunks);
        self.text = Cow::Owned(text);
    }

    /// Returns the new text, and the ranges in which it differs from the document's.
    pub(crate) fn finish(self) -> (String, Vec<Hunk>) {
        (self.text.into_owned(), self.hunks)
    }

    /// Node of this path. Refused if the text around it could not be parsed.
    pub(crate) fn find(&self, path: &Path) -> Result<Found<'_>, EditError> {
        let found = find(&self.file, path).ok_or_else(|| EditError::NoSuchNode(path.clone()))?;
        match found.block.closed {
            true => Ok(found),
            false => Err(EditError::Unreadable(found.node.name.value.to_string())),
        }
    }
    pub(crate) fn site<'f>(&self, found: Found<'f>) -> Site<'f> {
        Site { block: found.block, top: found.parent.is_none(), index: found.index }
    }
    pub(crate) fn writer<'w>(&'w self, found: Found<'w>) -> Writer<'w> {
        Writer { text: &self.text, style: self.style, node: found.node, fields: self.fields() }
    }
    /// Custom SDFs of the document.
    pub(crate) fn fields(&self) -> &'d CustomSdfs {
        &self.known.fields
    }
    pub(crate) fn parameters(&self, path: &Path) -> Result<Vec<Parameter>, EditError> {
        let found = self.find(path)?;
        Ok(parameters(&self.file, &self.values(), found.kind, found.node))
    }
    /// Values of formulas, by their present places, except those that the edit has changed.
    pub(crate) fn values(&self) -> Cow<'_, Values> {
        if self.hunks.is_empty() {
            return Cow::Borrowed(self.known);
        }
        let now = |at: u32| {
            let before = self.hunks.iter().take_while(|hunk| hunk.old.start <= at as usize);
            let (mut shift, mut touched) = (0, false);
            for hunk in before {
                shift += hunk.new.len() as isize - hunk.old.len() as isize;
                touched |= hunk.old.contains(&(at as usize));
            }
            (!touched).then(|| (at as usize).wrapping_add_signed(shift) as u32)
        };
        let formulas = self.known.formulas.iter().filter_map(|(at, value)| Some((now(*at)?, *value))).collect();
        let (fields, included) = (self.known.fields.clone(), self.known.included.clone());
        Cow::Owned(Values { formulas, fields, included, ..Values::default() })
    }
    pub(crate) fn parameter(&self, path: &Path, key: &str) -> Result<Parameter, EditError> {
        let word = self.find(path)?.node.name.value.to_string();
        let parameter = self.parameters(path)?.into_iter().find(|parameter| parameter.control.key == key);
        parameter.ok_or_else(|| EditError::NoSuchControl { node: word, key: key.to_owned() })
    }

    /// Number of outline nodes in a node, or at the top of the file.
    fn count(&self, parent: Option<&Path>) -> usize {
        let found = parent.map(|parent| find(&self.file, parent));
        match found {
            Some(Some(found)) => found.node.children.as_ref().map_or(0, |block| shown(block, Some(found.kind)).count()),
            Some(None) => 0,
            None => shown(&self.file, None).count(),
        }
    }

    /// Applies a patch that adds or removes children of a node. Refused if their number is then not as expected,
    /// because of an unclosed comment or string.
    pub(crate) fn then_count(&mut self, parent: Option<&Path>, more: isize, patch: Patch) -> Result<(), EditError> {
        let expected = self.count(parent).checked_add_signed(more);
        self.then(vec![patch])?;
        match expected == Some(self.count(parent)) {
            true => Ok(()),
            false => Err(EditError::Unreadable("the scene".to_owned())),
        }
    }

    /// Removes a node from the text.
    pub(crate) fn take_out(&mut self, path: &Path, comments: bool) -> Result<(), EditError> {
        let patch = self.site(self.find(path)?).removal(&self.text, comments);
        self.then_count(path.parent().as_ref(), -1, patch)
    }

    /// Inserts a chunk into a node, or at the top of the file, at this index or at the last possible one.
    pub(crate) fn put_in(&mut self, parent: Option<&Path>, index: usize, chunk: &Chunk) -> Result<Path, EditError> {
        let found = parent.map(|parent| self.find(parent)).transpose()?;
        if let Some(found) = found {
            self.writer(found).check_braces()?;
        }
        let block = match found {
            Some(found) => found.node.children.as_ref(),
            None => Some(&*self.file),
        };
        let kind: Option<ItemKind> = found.map(|found| found.kind);
        let items: Vec<usize> =
            block.map_or_else(Vec::new, |block| shown(block, kind).map(|(index, _)| index).collect());
        // Nothing goes before the version, which is the first node of a file.
        let index = index.min(items.len()).max(usize::from(parent.is_none() && !items.is_empty()));
        let before = match index.checked_sub(1) {
            Some(before) => items.get(before).copied(),
            None => match items.first() {
                Some(first) => first.checked_sub(1),
                None => block.and_then(|block| block.nodes.len().checked_sub(1)),
            },
        };
        let top = parent.is_none();
        let patch = match (block, before, found) {
            (Some(block), Some(index), _) => Site { block, top, index }.insert_behind(&self.text, chunk, self.style),
            (_, None, Some(found)) => insert_first(&self.text, found.node, chunk, self.style),
            _ => Patch::insert(self.text.len(), format!("{}{}", chunk.indented(""), self.style.newline)),
        };
        self.then_count(parent, 1, patch)?;
        Ok(parent.map_or_else(|| Path::top(index), |parent| parent.child(index)))
    }
}
