//! Decals of materials: `decal "logo.png" size=0.1 { at 0 0.1 0.05 }`.

use super::arguments::{arguments, missing_arguments};
use super::context::{Context, Files};
use super::placement::Placements;
use super::settings::Properties;
use super::textures::texels;
use super::unexpected::unexpected_node;
use crate::language::diagnostics::report::draft;
use crate::language::keywords::{DECAL, PLACEMENT};
use crate::language::tree::Node;
use crate::settings;
use crate::textures::{Decal, DecalSpace};

/// The most decals of a material.
const MOST_DECALS: usize = 64;

/// The decals of a material, from the lowest to the topmost.
pub(super) fn decals(material: &Node, files: &mut Files, context: &mut Context) -> Vec<Decal> {
    let nodes: Vec<&Node> = material.child_nodes().iter().filter(|child| child.name.value == DECAL).collect();
    if let Some(extra) = nodes.get(MOST_DECALS) {
        let message = format!("A material has at most {MOST_DECALS} decals, not {}.", nodes.len());
        context.report.add(draft("pathmarch::too_large", extra.name.span, message).label("one too many"));
        return Vec::new();
    }
    nodes.into_iter().filter_map(|node| decal(node, files, context)).collect()
}

/// A decal; `None` after a mistake.
fn decal(node: &Node, files: &mut Files, context: &mut Context) -> Option<Decal> {
    let usage = "`decal \"logo.png\" size=0.1`";
    let properties = Properties::new(node, settings::DECAL, context);
    let size = properties.number("size", context);
    let depth = properties.number("depth", context).or(size);
    let angle = properties.number("angle", context);
    let opacity = properties.number("opacity", context);
    let space = if properties.flag("world", context) { DecalSpace::World } else { DecalSpace::Shape };
    let mut placement = Placements::default();
    for child in node.child_nodes() {
        if !placement.take(child, false, context) {
            unexpected_node(&child.name, PLACEMENT, "in a `decal`", context);
        }
    }
    let entries = arguments(node, 1, usage, context);
    let Some(entry) = entries.first() else {
        missing_arguments(node, usage, context);
        return None;
    };
    let picture = texels(entry, "a decal", |path| files.assets.decal(path), files.scene, context)?;
    let min_cosine = angle?.to_radians().cos();
    let pose = placement.value.pose();
    Some(Decal { picture, size: size?, depth: depth?, min_cosine, opacity: opacity?, pose, space })
}
