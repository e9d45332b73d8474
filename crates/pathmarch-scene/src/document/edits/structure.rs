//! Edits of the tree: nodes removed, renamed, moved, wrapped and copied.

use super::naming::{free_name, names, one, title};
use super::transaction::Transaction;
use crate::document::error::EditError;
use crate::document::text::layout::{Chunk, bytes, indent, starts_line, tail};
use crate::document::text::literals::{quoted, string_like};
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::{arguments, child, property, text_argument};
use crate::document::tree::outline::{Found, ItemKind, shown};
use crate::document::tree::path::Path;
use crate::language::Values;
use crate::language::diagnostics::spelling::listed;
use crate::language::formulas::expression;
use crate::language::keywords::{PLACEMENT, SHAPE};
use crate::language::read::params;
use crate::language::tree::{self, Node};
use pathmarch_field::{Solid, registry};

/// Removes a node, unless something needs it.
pub(crate) fn remove(transaction: &mut Transaction, path: &Path) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    let name = title(found.node, found.kind);
    let needed = |reason: String| Err(EditError::Needed(reason));
    let siblings = shown(found.block, found.parent).count();
    match found.kind {
        ItemKind::Version => return needed("A scene starts with its version, which cannot be removed.".to_owned()),
        ItemKind::Camera if names(transaction, "camera").len() == 1 => {
            return needed(format!("`{name}` is the only camera, and a scene needs one. Add another first."));
        }
        ItemKind::Material => {
            let users = users(transaction, &name);
            let (others, shared) = (users.len().saturating_sub(3), names(transaction, "material"));
            let twice = shared.iter().filter(|other| **other == name).count() > 1;
            if !users.is_empty() && !twice {
                let and = if others > 0 { format!(", and {others} more") } else { String::new() };
                let users = listed(users.iter().take(3).map(String::as_str), "and");
                return needed(format!(
                    "`{name}` is the material of {users}{and}. Give them another first, or remove them."
                ));
            }
        }
        ItemKind::Shape | ItemKind::Instance | ItemKind::Operator if siblings == 1 => {
            let parent = path.parent().unwrap_or_default();
            let parent = transaction.find(&parent)?;
            let parent = title(parent.node, parent.kind);
            return needed(format!("`{name}` is all that `{parent}` contains. Remove `{parent}` instead."));
        }
        _ => {}
    }
    transaction.take_out(path, false)
}

/// The objects that name a material, or in which something does.
fn users(transaction: &Transaction, material: &str) -> Vec<String> {
    fn uses(node: &Node<'static>, material: &str) -> bool {
        let own = property(node, "material").map(|entry| &entry.value);
        matches!(own, Some(tree::Value::Text(name)) if name == material)
            || node.child_nodes().iter().any(|child| uses(child, material))
    }
    let objects = transaction.file.nodes.iter().filter(holds_shapes);
    objects.filter(|node| uses(node, material)).map(|node| title(node, ItemKind::Object)).collect()
}

/// Copies a material, and gives the copy to one of its users.
pub(crate) fn copy_material(transaction: &mut Transaction, user: &Path, material: &Path) -> Result<Path, EditError> {
    let copy = duplicate(transaction, material)?;
    let user = user.after_insertion(&copy);
    let name = text_argument(transaction.find(&copy)?.node).unwrap_or_default().to_owned();
    let node = transaction.find(&user)?.node;
    let patch = match property(node, "material") {
        Some(entry) => Patch::replace(bytes(entry.value_span), quoted(&name)),
        None => Patch::insert(node.span().end as usize, format!(" material={}", quoted(&name))),
    };
    transaction.then(vec![patch])?;
    Ok(copy)
}

/// The number of objects, shapes and operators that name a material.
pub(crate) fn uses_of(nodes: &[Node<'static>], material: &str) -> usize {
    let own = |node: &Node<'static>| {
        let value = property(node, "material").map(|entry| &entry.value);
        usize::from(matches!(value, Some(tree::Value::Text(name)) if name == material))
    };
    nodes.iter().map(|node| own(node) + uses_of(node.child_nodes(), material)).sum()
}

/// Gives a node another name, and all that refer to it.
pub(crate) fn rename(transaction: &mut Transaction, path: &Path, new: &str) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    let word = found.node.name.value.to_string();
    if !found.kind.is_named() {
        return Err(EditError::Name(format!(
            "A `{word}` has no name. Cameras, materials, fields, objects, parameters and declared shapes have."
        )));
    }
    if new.is_empty() {
        return Err(EditError::Name(format!("The name of {} must not be empty.", one(&word))));
    }
    let old = text_argument(found.node);
    if old == Some(new) || old.is_none() && found.kind == ItemKind::Camera && new == "main" {
        return Ok(());
    }
    if names(transaction, &word).iter().any(|name| name == new) {
        let word = one(&word);
        return Err(EditError::Name(format!("There is {word} called `{new}` already. Choose another name.")));
    }
    let mut patches = vec![name_patch(transaction, found, new)];
    if let (ItemKind::Material, Some(old)) = (found.kind, old) {
        let objects = transaction.file.nodes.iter().filter(holds_shapes);
        objects.for_each(|object| references(&transaction.text, object, (old, new), &mut patches));
    }
    if let (ItemKind::Field, Some(old)) = (found.kind, old) {
        let objects = transaction.file.nodes.iter().filter(holds_shapes);
        objects.for_each(|object| uses(object, (old, new), &mut patches));
    }
    if let (ItemKind::Declaration, Some(old)) = (found.kind, old) {
        let objects = transaction.file.nodes.iter().filter(holds_shapes);
        objects.for_each(|object| instances(&transaction.text, object, (old, new), &mut patches));
    }
    if let (ItemKind::Param, Some(old)) = (found.kind, old) {
        let values = transaction.values();
        let others = transaction.file.nodes.iter();
        others.for_each(|node| formulas(node, &values, (old, new), &mut patches));
    }
    transaction.last(patches);
    Ok(())
}

/// True if a node at the top of a file may contain shapes.
fn holds_shapes(node: &&Node<'static>) -> bool {
    matches!(&*node.name.value, "object" | SHAPE)
}

/// Renames the uses of a declared shape in a node's braces.
fn instances(text: &str, node: &Node<'static>, (old, new): (&str, &str), patches: &mut Vec<Patch>) {
    for child in node.child_nodes() {
        if child.name.value == old {
            let range = bytes(child.name.span);
            let written = string_like(new, &text[range.clone()]);
            patches.push(Patch::replace(range, written));
        }
        instances(text, child, (old, new), patches);
    }
}

/// Renames a parameter in the formulas of a node and its children, except where another parameter of this name hides
/// it.
fn formulas(node: &Node<'static>, values: &Values, names: (&str, &str), patches: &mut Vec<Patch>) {
    let hidden = params::nodes(node.child_nodes()).any(|own| params::declared_name(own) == Some(names.0));
    if hidden {
        return;
    }
    for entry in &node.entries {
        if let tree::Value::Text(text) = &entry.value
            && values.formulas.contains_key(&entry.value_span.start)
        {
            let renamed = expression::renamed(text, names);
            if renamed != **text {
                patches.push(Patch::replace(bytes(entry.value_span), quoted(&renamed)));
            }
        }
    }
    node.child_nodes().iter().for_each(|child| formulas(child, values, names, patches));
}

fn name_patch(transaction: &Transaction, found: Found, new: &str) -> Patch {
    match arguments(found.node).next() {
        Some(entry) => {
            let range = bytes(entry.value_span);
            let text = string_like(new, &transaction.text[range.clone()]);
            Patch::replace(range, text)
        }
        None => Patch::insert(bytes(found.node.name.span).end, format!(" {}", quoted(new))),
    }
}

fn references(text: &str, node: &Node<'static>, (old, new): (&str, &str), patches: &mut Vec<Patch>) {
    if let Some(entry) = property(node, "material")
        && matches!(&entry.value, tree::Value::Text(name) if name == old)
    {
        let range = bytes(entry.value_span);
        let written = string_like(new, &text[range.clone()]);
        patches.push(Patch::replace(range, written));
    }
    node.child_nodes().iter().for_each(|child| references(text, child, (old, new), patches));
}

/// Renames the uses of a custom SDF.
fn uses(node: &Node<'static>, (old, new): (&str, &str), patches: &mut Vec<Patch>) {
    for child in node.child_nodes() {
        if child.name.value == old {
            let range = bytes(child.name.span);
            patches.push(Patch::replace(range, new));
        }
        uses(child, (old, new), patches);
    }
}

/// Moves a node, with its comments.
pub(crate) fn move_to(
    transaction: &mut Transaction,
    path: &Path,
    parent: Option<&Path>,
    index: usize,
) -> Result<Path, EditError> {
    let found = transaction.find(path)?;
    let name = title(found.node, found.kind);
    let not_here = |reason: String| Err(EditError::NotHere(reason));
    if parent.is_some_and(|parent| parent.is_within(path)) {
        return not_here(format!("`{name}` cannot be moved into itself."));
    }
    match parent.map(|parent| transaction.find(parent)).transpose()? {
        _ if found.kind == ItemKind::Version => {
            return not_here("The version stays at the top of the file.".to_owned());
        }
        Some(target) if !target.kind.holds_shapes() || !found.kind.is_solid() && found.kind != ItemKind::Object => {
            let target = title(target.node, target.kind);
            return not_here(format!(
                "`{name}` cannot be in `{target}`: objects and operators contain shapes and operators."
            ));
        }
        _ => {}
    }
    if path.parent().as_ref() == parent && path.index() == index {
        return Ok(path.clone());
    }
    let site = transaction.site(found);
    let chunk = Chunk::of(&transaction.text, &site, true);
    let parent = parent.and_then(|parent| parent.after_removal(path));
    transaction.take_out(path, true)?;
    transaction.put_in(parent.as_ref(), index, &chunk)
}

/// Puts siblings into the braces of an operator.
pub(crate) fn group(transaction: &mut Transaction, paths: &[Path], operator: &str) -> Result<Path, EditError> {
    if !registry::solid(operator).is_some_and(Solid::is_operator) {
        let operators = registry::solids().filter(|solid| solid.is_operator());
        let names = listed(operators.map(|operator| &*operator.info().name), "or");
        return Err(EditError::NotHere(format!("There is no operator `{operator}`. Expected {names}.")));
    }
    let mut paths = paths.to_vec();
    paths.sort();
    paths.dedup();
    let Some((first, others)) = paths.split_first() else {
        return Err(EditError::NotHere("Nothing is selected. Select shapes to group.".to_owned()));
    };
    let mut chunks = Vec::new();
    let mut lines = false;
    for path in &paths {
        let found = transaction.find(path)?;
        if !found.kind.is_solid() || !path.is_sibling_of(first) {
            let reason = "Only shapes and operators of one object or operator can be grouped. Select some of those.";
            return Err(EditError::NotHere(reason.to_owned()));
        }
        let site = transaction.site(found);
        lines |= path == first && site.lines(&transaction.text).is_some();
        chunks.push(Chunk::of(&transaction.text, &site, true));
    }
    let chunk = Chunk::wrapped(operator, &chunks, lines, transaction.style);
    for path in others.iter().rev() {
        transaction.take_out(path, true)?;
    }
    let site = transaction.site(transaction.find(first)?);
    let range = site.range(&transaction.text);
    let patch = Patch::replace(range, chunk.indented(&site.indent(&transaction.text, transaction.style)));
    transaction.then_count(first.parent().as_ref(), 0, patch)?;
    Ok(first.clone())
}

/// Puts the children of an operator in its place.
pub(crate) fn ungroup(transaction: &mut Transaction, path: &Path) -> Result<Vec<Path>, EditError> {
    let found = transaction.find(path)?;
    let name = title(found.node, found.kind);
    if found.kind != ItemKind::Operator {
        return Err(EditError::NotHere(format!("`{name}` is not an operator: there is nothing to take out of it.")));
    }
    transaction.writer(found).check_braces()?;
    if let Some(placed) = PLACEMENT.iter().find(|word| child(found.node, word).is_some()) {
        return Err(EditError::Needed(format!(
            "The `{placed}` of this `{name}` moves everything in it. Reset it first, or move it to the shapes."
        )));
    }
    let children: Vec<Found> = shown_in(found);
    let count = children.len();
    if let Some(entry) = property(found.node, "material") {
        // What names no material of its own keeps the one that it has.
        let written = &transaction.text[bytes(entry.value_span)];
        let without = children.iter().filter(|child| property(child.node, "material").is_none());
        let patches =
            without.map(|child| Patch::insert(child.node.span().end as usize, format!(" material={written}")));
        transaction.then(patches.collect())?;
    }
    let found = transaction.find(path)?;
    let Some(block) = &found.node.children else { return Ok(Vec::new()) };
    let text = &transaction.text;
    let whole = bytes(found.node.whole);
    let inside = block.span.start as usize + 1..block.span.end as usize - 1;
    let inner = text[inside.clone()].trim_end().trim_end_matches(['\\', ';']).trim_end();
    let start = inside.end - text[inside.clone()].trim_start().len();
    let range = start..(inside.start + inner.len()).max(start);
    let site = transaction.site(found);
    let like = block.nodes.iter().map(|node| node.whole.start as usize).find(|at| starts_line(text, *at));
    let base = like.map_or("", |at| indent(text, at)).to_owned();
    let outer = match starts_line(text, whole.start) {
        true => indent(text, whole.start).to_owned(),
        false => format!("{}{}", indent(text, whole.start), transaction.style.unit),
    };
    let chunk = Chunk::piece(text, range, base, &block.nodes);
    let mut piece = chunk.indented(&outer);
    // A comment at its end must not swallow what follows.
    if piece.contains("//") && !tail(text, whole.end).ends_line {
        piece.push_str(transaction.style.newline);
        piece.push_str(&outer);
    }
    let patch = Patch::replace(bytes(site.node().whole), piece);
    let parent = path.parent();
    transaction.then_count(parent.as_ref(), count as isize - 1, patch)?;
    let sibling = |index| parent.as_ref().map_or_else(|| Path::top(index), |parent| parent.child(index));
    Ok((path.index()..path.index() + count).map(sibling).collect())
}

/// The nodes in the outline that are in a node.
fn shown_in(found: Found) -> Vec<Found> {
    let Some(block) = &found.node.children else { return Vec::new() };
    let nodes = shown(block, Some(found.kind));
    nodes.map(|(index, node)| Found { node, kind: ItemKind::Other, block, index, parent: Some(found.kind) }).collect()
}

/// Copies a node and inserts the copy after it.
pub(crate) fn duplicate(transaction: &mut Transaction, path: &Path) -> Result<Path, EditError> {
    let found = transaction.find(path)?;
    let word = &*found.node.name.value;
    if matches!(found.kind, ItemKind::Version | ItemKind::Render | ItemKind::Sky | ItemKind::Fog) {
        return Err(EditError::NotHere(format!("A scene has only one `{word}`.")));
    }
    let site = transaction.site(found);
    let mut chunk = Chunk::of(&transaction.text, &site, false);
    if found.kind.is_named() {
        let name = text_argument(found.node).unwrap_or("main");
        let Patch { range, text } = name_patch(transaction, found, &free_name(transaction, word, name));
        let start = found.node.whole.start as usize;
        chunk = chunk.with(&Patch::replace(range.start - start..range.end - start, text));
    }
    let patch = site.insert_behind(&transaction.text, &chunk, transaction.style);
    let (parent, index) = (path.parent(), path.index() + 1);
    transaction.then_count(parent.as_ref(), 1, patch)?;
    Ok(parent.map_or_else(|| Path::top(index), |parent| parent.child(index)))
}
