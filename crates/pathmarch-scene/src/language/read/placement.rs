//! Placement of shapes, operators and textures.

use super::arguments::twice;
use super::context::Context;
use super::settings::{single, triple};
use crate::language::keywords::{NORMAL, PLACEMENT};
use crate::language::tree::{Node, Span};
use crate::settings;
use pathmarch_field::Placement;

/// Gathers `at`, `rotate`, `scale` and `normal`.
#[derive(Default)]
pub(super) struct Placements<'n> {
    pub(super) value: Placement,
    seen: Vec<(&'n str, Span)>,
}

impl<'n> Placements<'n> {
    /// Takes the node if it is one of them.
    pub(super) fn take(&mut self, node: &'n Node, facing: bool, context: &mut Context) -> bool {
        let word = &*node.name.value;
        let placement = PLACEMENT.contains(&word) || facing && word == NORMAL;
        if !placement {
            return false;
        }
        if let Some((_, first)) = self.seen.iter().find(|(other, _)| *other == word) {
            twice(&format!("`{word}`"), node.name.span, *first, context);
            return true;
        }
        self.seen.push((word, node.name.span));
        match word {
            "at" => self.value.at = triple(node, &settings::PLACEMENT[0], context),
            "rotate" => self.value.rotate = triple(node, &settings::PLACEMENT[1], context),
            "scale" => self.value.scale = single(node, &settings::PLACEMENT[2], context),
            _ => self.value.normal = triple(node, &settings::NORMAL, context),
        }
        true
    }
}
