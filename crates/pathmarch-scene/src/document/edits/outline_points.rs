//! Control points of outlines: the `point` nodes of polygons and curves.

use super::transaction::Transaction;
use crate::document::error::EditError;
use crate::document::text::layout::{Chunk, Site, bytes, insert_first};
use crate::document::text::literals::{number, numbers};
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::{arguments, property};
use crate::document::tree::path::Path;
use crate::language::Values;
use crate::language::keywords::{CORNER, POINT};
use crate::language::tree::{Block, Entry, Node, Value};

/// Control point of a polygon or a curve, in the plane of the profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Position, metres.
    pub at: [f32; 2],
    /// True if the curve has a corner there; always true for a polygon.
    pub is_corner: bool,
}

/// Indexes of the point nodes of a block.
fn point_indexes(block: &Block<'static>) -> Vec<usize> {
    (0..block.nodes.len()).filter(|index| block.nodes[*index].name.value == POINT).collect()
}

/// Control points of a node. None if one of them cannot be read.
pub(crate) fn control_points(node: &Node<'static>, values: &Values) -> Vec<ControlPoint> {
    let Some(block) = &node.children else { return Vec::new() };
    let read = |index: usize| {
        let point = &block.nodes[index];
        let coordinates: Vec<f32> = arguments(point).map(|entry| coordinate(entry, values)).collect::<Option<_>>()?;
        let [x, y] = coordinates[..] else { return None };
        let is_corner = property(point, CORNER).is_some_and(|entry| entry.value == Value::Bool(true));
        Some(ControlPoint { at: [x, y], is_corner: is_corner || node.name.value == "polygon" })
    };
    point_indexes(block).into_iter().map(read).collect::<Option<_>>().unwrap_or_default()
}

/// Present value of a coordinate.
fn coordinate(entry: &Entry, values: &Values) -> Option<f32> {
    match entry.value {
        Value::Text(_) => values.formulas.get(&entry.value_span.start).map(|value| *value as f32),
        Value::Number(value) => Some(value as f32).filter(|value| value.is_finite()),
        _ => None,
    }
}

/// The block and the index in it of a control point.
fn site<'t>(transaction: &'t Transaction, path: &Path, point: usize) -> Result<Site<'t>, EditError> {
    let found = transaction.find(path)?;
    transaction.writer(found).check_braces()?;
    let block = found.node.children.as_ref();
    let site = block.and_then(|block| {
        let index = *point_indexes(block).get(point)?;
        Some(Site { block, top: false, index })
    });
    site.ok_or_else(|| {
        EditError::NotHere(format!(
            "`{}` has no point {}. Select one of those that it has.",
            found.node.name.value,
            point + 1
        ))
    })
}

/// Moves a point. A coordinate that is a formula stays as it is.
pub(crate) fn set(transaction: &mut Transaction, path: &Path, point: usize, at: [f32; 2]) -> Result<(), EditError> {
    let site = site(transaction, path, point)?;
    let entries: Vec<&Entry> = arguments(site.node()).collect();
    let formula = |entry: &&&Entry| matches!(entry.value, Value::Text(_));
    if let (2, Some(first)) = (entries.iter().filter(formula).count(), entries.first()) {
        let (label, formula) =
            (POINT.to_owned(), transaction.text[bytes(first.value_span)].trim_matches('"').to_owned());
        return Err(EditError::Formula { label, formula });
    }
    let changed = entries.iter().zip(at).filter(|(entry, new)| match entry.value {
        Value::Number(now) => now as f32 != *new,
        _ => false,
    });
    let patches = changed.map(|(entry, new)| Patch::replace(bytes(entry.value_span), number(new))).collect();
    transaction.last(patches);
    Ok(())
}

/// Adds a point, which then has this index.
pub(crate) fn add(transaction: &mut Transaction, path: &Path, point: usize, at: [f32; 2]) -> Result<(), EditError> {
    let chunk = Chunk::new(&format!("{POINT} {}", numbers(&at)), transaction.style);
    let patch = match point.checked_sub(1) {
        Some(before) => site(transaction, path, before)?.insert_behind(&transaction.text, &chunk, transaction.style),
        None => {
            let found = transaction.find(path)?;
            transaction.writer(found).check_braces()?;
            insert_first(&transaction.text, found.node, &chunk, transaction.style)
        }
    };
    transaction.last(vec![patch]);
    Ok(())
}

/// Removes a point.
pub(crate) fn remove(transaction: &mut Transaction, path: &Path, point: usize) -> Result<(), EditError> {
    let patch = site(transaction, path, point)?.removal(&transaction.text, false);
    transaction.last(vec![patch]);
    Ok(())
}

/// Makes the curve have a corner at a point, or be smooth there.
pub(crate) fn set_corner(
    transaction: &mut Transaction,
    path: &Path,
    point: usize,
    is_corner: bool,
) -> Result<(), EditError> {
    let site = site(transaction, path, point)?;
    let writer = transaction.writer(transaction.find(path)?).of(site.node());
    let patches = match (is_corner, property(site.node(), CORNER)) {
        (true, _) => writer.write_property(CORNER, &crate::document::control::Value::Flag(true)),
        (false, Some(entry)) => vec![writer.remove(entry)],
        (false, None) => Vec::new(),
    };
    transaction.last(patches);
    Ok(())
}
