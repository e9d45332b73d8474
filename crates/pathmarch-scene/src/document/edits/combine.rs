//! Shapes and objects that are combined by an operator, or moved into one another.
//!
//! What moves keeps its material, and what is empty without it goes: an object cannot be empty.

use super::naming::{free_name, title};
use super::structure::{self, group};
use super::transaction::Transaction;
use crate::document::error::EditError;
use crate::document::text::layout::{Chunk, bytes};
use crate::document::text::literals::quoted;
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::{child, property};
use crate::document::tree::outline::{Found, ItemKind, shown};
use crate::document::tree::path::Path;
use crate::language::keywords::{MATERIAL, PLACEMENT};
use pathmarch_field::registry;
use std::iter::successors;

/// Combines shapes, operators and objects by an operator, in the place of the first of them. Returns its path.
pub(crate) fn combine(transaction: &mut Transaction, paths: &[Path], operator: &str) -> Result<Path, EditError> {
    let mut paths = outermost(paths);
    if paths.len() < 2 {
        return Err(EditError::NotHere("Select at least two shapes or objects to combine.".to_owned()));
    }
    for path in &paths {
        check_solid(transaction, path)?;
    }
    for path in &paths[1..] {
        check_places(transaction, path, &paths[0])?;
    }
    paths[0] = only_child(transaction, &paths[0])?;
    for next in 1..paths.len() {
        let (chunk, removed) = take(transaction, &paths[next], paths[0].parent().as_ref())?;
        paths = paths.iter().map(|path| path.after_removal(&removed).unwrap_or_default()).collect();
        let (parent, index) = (paths[0].parent(), paths[0].index() + next);
        let put = transaction.put_in(parent.as_ref(), index, &chunk)?;
        paths = paths.iter().map(|path| path.after_insertion(&put)).collect();
        paths[next] = put;
    }
    group(transaction, &paths, operator)
}

/// Moves a node, with its comments.
pub(crate) fn move_to(
    transaction: &mut Transaction,
    path: &Path,
    parent: Option<&Path>,
    index: usize,
) -> Result<Path, EditError> {
    let stays = path.parent().as_ref() == parent || parent.is_some_and(|parent| parent.is_within(path));
    match if stays { None } else { move_solid(transaction, path, parent, index)? } {
        Some(path) => Ok(path),
        None => structure::move_to(transaction, path, parent, index),
    }
}

/// Moves a node into an object or an operator, where it then has this index, with the shapes of an object; or a shape
/// out of all of them, into an object of its own. `None` if the move is of neither kind.
fn move_solid(
    transaction: &mut Transaction,
    path: &Path,
    parent: Option<&Path>,
    index: usize,
) -> Result<Option<Path>, EditError> {
    let found = transaction.find(path)?;
    let holds = parent.map(|parent| transaction.find(parent)).transpose()?.map(|found| found.kind.holds_shapes());
    let (word, kind) = (found.node.name.value.to_string(), found.kind);
    if !(kind == ItemKind::Object && holds == Some(true) || kind.is_solid() && holds != Some(false)) {
        return Ok(None);
    }
    let (mut chunk, removed) = take(transaction, path, parent)?;
    if parent.is_none() {
        let name = quoted(&free_name(transaction, "object", &word));
        chunk = Chunk::wrapped(&format!("object {name}"), &[chunk], false, transaction.style);
    }
    let parent = parent.and_then(|parent| parent.after_removal(&removed));
    transaction.put_in(parent.as_ref(), index, &chunk).map(Some)
}

/// Paths that are in no other of them, each once, in their order.
fn outermost(paths: &[Path]) -> Vec<Path> {
    let inside = |path: &Path| paths.iter().any(|other| other != path && path.is_within(other));
    let mut kept: Vec<Path> = Vec::new();
    for path in paths.iter().filter(|path| !inside(path)) {
        if !kept.contains(path) {
            kept.push(path.clone());
        }
    }
    kept
}

fn check_solid(transaction: &Transaction, path: &Path) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    if found.kind.is_solid() || found.kind == ItemKind::Object {
        return Ok(());
    }
    let name = title(found.node, found.kind);
    Err(EditError::NotHere(format!("`{name}` has no shape. Only shapes, operators and objects can be combined.")))
}

/// Refuses a move out of a placed operator, or into another one: the node would jump.
fn check_places(transaction: &Transaction, path: &Path, to: &Path) -> Result<(), EditError> {
    let around = |path: &Path| -> Vec<Path> { successors(path.parent(), Path::parent).collect() };
    let (own, others) = (around(path), around(to));
    let differ = own.iter().filter(|path| !others.contains(path)).chain(others.iter().filter(|p| !own.contains(p)));
    for path in differ {
        let found = transaction.find(path)?;
        let word = &found.node.name.value;
        if let Some(placed) = PLACEMENT.iter().find(|word| child(found.node, word).is_some()) {
            let reason = format!(
                "The `{placed}` of a `{word}` moves some of the selected shapes and not the others. Ungroup it first."
            );
            return Err(EditError::Needed(reason));
        }
        if matches!(registry::solid(word), Some(solid) if solid.is_operator() && !is_boolean(word)) {
            let reason = format!("A `{word}` changes some of the selected shapes and not the others.");
            return Err(EditError::Needed(format!("{reason} Select the `{word}` itself.")));
        }
    }
    Ok(())
}

fn is_boolean(word: &str) -> bool {
    registry::operators().iter().any(|operator| operator.info().name == word && operator.blends())
}

/// The shape or operator that stands for a node: the only one of an object, made one by a union if there are several.
fn only_child(transaction: &mut Transaction, path: &Path) -> Result<Path, EditError> {
    let found = transaction.find(path)?;
    if found.kind != ItemKind::Object {
        return Ok(path.clone());
    }
    match children(found) {
        0 => Err(EditError::Needed(format!("`{}` contains no shape.", title(found.node, found.kind)))),
        1 => Ok(path.child(0)),
        count => group(transaction, &(0..count).map(|index| path.child(index)).collect::<Vec<_>>(), "union"),
    }
}

/// Number of shapes and operators in a node.
fn children(found: Found) -> usize {
    found.node.children.as_ref().map_or(0, |block| shown(block, Some(found.kind)).count())
}

/// Takes the shapes of a node out of the text, for their place in `target`. Returns them and the node that was removed:
/// the outermost one that is empty without them, except what is around `target`.
fn take(transaction: &mut Transaction, path: &Path, target: Option<&Path>) -> Result<(Chunk, Path), EditError> {
    let inner = only_child(transaction, path)?;
    keep_material(transaction, &inner, target)?;
    let site = transaction.site(transaction.find(&inner)?);
    let chunk = Chunk::of(&transaction.text, &site, true);
    let mut removed = inner;
    while let Some(holder) = removed.parent() {
        let found = transaction.find(&holder)?;
        let stays = target.is_some_and(|target| target.is_within(&holder)) || found.kind == ItemKind::Declaration;
        if children(found) > 1 || stays {
            break;
        }
        removed = holder;
    }
    transaction.take_out(&removed, true)?;
    Ok((chunk, removed))
}

/// Gives a node the material that it inherits as its own, unless it inherits the same at its new place.
fn keep_material(transaction: &mut Transaction, path: &Path, target: Option<&Path>) -> Result<(), EditError> {
    let Some(giver) = giver(transaction, Some(path.clone()))?.filter(|giver| giver != path) else { return Ok(()) };
    if self::giver(transaction, target.cloned())?.as_ref() == Some(&giver) {
        return Ok(());
    }
    let Some(entry) = property(transaction.find(&giver)?.node, MATERIAL) else { return Ok(()) };
    let written = transaction.text[bytes(entry.value_span)].to_owned();
    let end = transaction.find(path)?.node.span().end as usize;
    transaction.then(vec![Patch::insert(end, format!(" {MATERIAL}={written}"))])
}

/// Innermost node with a material, of a node and those around it.
fn giver(transaction: &Transaction, path: Option<Path>) -> Result<Option<Path>, EditError> {
    for around in successors(path, Path::parent) {
        if property(transaction.find(&around)?.node, MATERIAL).is_some() {
            return Ok(Some(around));
        }
    }
    Ok(None)
}
