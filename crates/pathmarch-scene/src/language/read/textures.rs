//! Textures of a material's parameters and of `bump`.
//!
//! The node that names the kind carries its parameters as properties; its placement and, for a colour, its colour ramp
//! are in its braces.

use super::arguments::{arguments, flag, missing_arguments, no_children, properties, string};
use super::colours::positioned_colour;
use super::context::{Context, Files, relative_to};
use super::numbers::in_range;
use super::parameters::number;
use super::placement::Placements;
use super::unexpected::unexpected_node;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::{COLOUR, PLACEMENT};
use crate::language::tree::{Entry, Node};
use crate::materials::{BUMP_HEIGHT, TextureMapping};
use crate::settings::Range;
use crate::textures::{
    self, PICTURE_SIZE, Pattern, Picture, PictureError, Ramp, Texture, TextureKind, TextureParameters, UvMapping,
};
use pathmarch_field::Param;
use std::path::Path;
use std::sync::Arc;

/// Use of a texture's values.
#[derive(Clone, Copy)]
pub(super) enum Use {
    /// A colour.
    Colour,
    /// A number of this range.
    Number(Range),
    /// A height, metres.
    Height,
}

/// The most colours of a row.
const MOST_COLOURS: usize = 64;
/// Reads the texture in the braces of a node and the mapping of its values; a height is a range that starts at 0.
pub(super) fn texture(
    owner: &Node,
    to: Use,
    files: &mut Files,
    context: &mut Context,
) -> Option<(Texture, TextureMapping)> {
    let place = format!("in `{}`", owner.name.value);
    let mut found: Option<&Node> = None;
    for child in owner.child_nodes() {
        if !textures::names().contains(&&*child.name.value) {
            unexpected_node(&child.name, &textures::names(), &place, context);
        } else if let Some(first) = found {
            let message = format!("`{}` has one texture.", owner.name.value);
            let mistake = draft("pathmarch::duplicate", child.name.span, message).label("a second texture");
            context.report.add(mistake.also(first.name.span, "the first"));
        } else {
            found = Some(child);
        }
    }
    let Some(node) = found else {
        if owner.child_nodes().is_empty() && !owner.broken() {
            let message = format!("`{}` has no texture in its braces.", owner.name.value);
            let mistake = draft("pathmarch::missing_node", owner.name.span, message).label("expected a texture");
            context.report.add(mistake.help(format!("For example: {} {{ fbm size=0.1 }}.", owner.name.value)));
        }
        return None;
    };
    let kind = textures::kind(&node.name.value);
    let numbers = match kind {
        Some(kind) => kind.params,
        None => std::slice::from_ref(&PICTURE_SIZE),
    };
    let meant: &[&str] = match to {
        Use::Colour => &[],
        Use::Number(_) => &["from", "to"],
        Use::Height => &[&BUMP_HEIGHT.name],
    };
    let only_pictures = kind.is_none().then_some(UV);
    let words = numbers.iter().map(|param| &*param.name).chain(meant.iter().copied()).chain(only_pictures);
    let known: Vec<&str> = words.collect();
    let named = properties(node, &known, context);
    let values = values(numbers, &named, context);
    let mapping = mapping(node, kind, to, &named, context);
    let mut placement = Placements::default();
    for child in node.child_nodes() {
        if !(placement.take(child, false, context) || child.name.value == COLOUR && matches!(to, Use::Colour)) {
            let colours = matches!(to, Use::Colour).then_some(COLOUR);
            let known: Vec<&str> = PLACEMENT.iter().copied().chain(colours).collect();
            unexpected_node(&child.name, &known, &format!("in a `{}`", node.name.value), context);
        }
    }
    let pattern = match kind {
        Some(kind) => {
            arguments(node, 0, format_args!("`{}`, with its numbers by name", kind.name), context);
            Pattern::Computed { kind, parameters: values }
        }
        None => {
            let uv = named.iter().find(|(name, _)| *name == UV).map(|(_, entry)| *entry);
            let by_uv = uv.is_some_and(|entry| flag(entry, "`uv`", context).unwrap_or_default());
            let size = (!by_uv).then_some(values[0]);
            picture(node, size, matches!(to, Use::Colour), files, context)?
        }
    };
    Some((Texture { pattern, pose: placement.value.pose() }, mapping?))
}

/// The numbers of a texture.
fn values(params: &[Param], named: &[(&str, &Entry)], context: &mut Context) -> TextureParameters {
    let mut values = TextureParameters::default();
    for (value, param) in values.iter_mut().zip(params) {
        let entry = named.iter().find(|(name, _)| *name == param.name).map(|(_, entry)| *entry);
        *value = entry.and_then(|entry| number(param, entry, context)).unwrap_or(param.default);
    }
    values
}

fn mapping(
    node: &Node,
    kind: Option<&TextureKind>,
    to: Use,
    named: &[(&str, &Entry)],
    context: &mut Context,
) -> Option<TextureMapping> {
    let entry = |name: &str| named.iter().find(|(word, _)| *word == name).map(|(_, entry)| *entry);
    match to {
        Use::Colour => Some(match (ramp(node, context)?, kind) {
            (Some(ramp), _) => TextureMapping::Ramp(ramp),
            (None, None) => TextureMapping::Direct,
            (None, Some(_)) => TextureMapping::Ramp(default_ramp()),
        }),
        Use::Number(range) => {
            let mut end = |word: &str, default: f32| match entry(word) {
                Some(entry) => in_range(entry, format_args!("`{word}`"), range, context),
                None => Some(default),
            };
            let (from, to) = (end("from", range.min), end("to", range.max));
            Some(TextureMapping::Range([from?, to?]))
        }
        Use::Height => {
            let height = match entry(&BUMP_HEIGHT.name) {
                Some(entry) => number(&BUMP_HEIGHT, entry, context),
                None => Some(BUMP_HEIGHT.default),
            };
            Some(TextureMapping::Range([0.0, height?]))
        }
    }
}

/// From dark to light grey: where no colours are given.
pub(super) fn default_ramp() -> Ramp {
    Ramp::even(vec![[0.02; 3], [0.9; 3]])
}

/// The colour ramp in the braces of a node, `None` inside without colours; `None` after a mistake.
pub(super) fn ramp(node: &Node, context: &mut Context) -> Option<Option<Ramp>> {
    let nodes: Vec<&Node> = node.child_nodes().iter().filter(|child| child.name.value == COLOUR).collect();
    if nodes.len() > MOST_COLOURS {
        let what = &node.name.value;
        let message = format!("An `{what}` has at most {MOST_COLOURS} colours, not {}.", nodes.len());
        let message =
            if what.starts_with(['a', 'e', 'i', 'o', 'u']) { message } else { message.replacen("An", "A", 1) };
        context.report.add(draft("pathmarch::too_large", node.name.span, message).label("too many colours"));
        return None;
    }
    let read: Vec<_> = nodes.iter().map(|child| positioned_colour(child, context)).collect();
    let read: Vec<([f32; 3], Option<f32>)> = read.into_iter().collect::<Option<_>>()?;
    if read.is_empty() {
        return Some(None);
    }
    let mut last: Option<(f32, &Node)> = None;
    let given: Vec<Option<f32>> = read.iter().map(|(_, position)| *position).collect();
    for (node, position) in nodes.iter().zip(&given) {
        let Some(mut position) = *position else { continue };
        if let Some((before, first)) = last.filter(|(before, _)| position < *before) {
            let message =
                format!("This colour is at {position}, before the last one at {before}, whose place it takes.");
            let warning = draft("pathmarch::out_of_order", node.span(), message).label("its `at` falls");
            let help = "Give the colours of a ramp in the order of their `at`.";
            context.report.warn(warning.also(first.span(), "the last one").help(help));
            position = before;
        }
        last = Some((position, node));
    }
    let positions = last.map(|_| Ramp::spaced(&given));
    let colours = read.into_iter().map(|(colour, _)| colour).collect();
    Some(Some(Ramp { colours, positions }))
}

/// Property of pictures at the texture coordinates of a mesh.
const UV: &str = "uv";

/// `picture "wood.jpg" size=1`; without a size, at texture coordinates.
fn picture(node: &Node, size: Option<f32>, encoded: bool, files: &mut Files, context: &mut Context) -> Option<Pattern> {
    let usage = "`picture \"wood.jpg\" size=1`";
    let entries = arguments(node, 1, usage, context);
    let Some(entry) = entries.first() else {
        missing_arguments(node, usage, context);
        return None;
    };
    let load = |path: &Path| files.assets.texture(path, encoded);
    let picture = texels(entry, "a texture", load, files.scene, context)?;
    Some(match size {
        Some(size) => Pattern::Picture { picture, size },
        None => Pattern::UvPicture { picture, mapping: UvMapping::default() },
    })
}

/// The picture in the file that an entry names; `None` after a mistake. `purpose` as in "cannot be a texture".
pub(super) fn texels(
    entry: &Entry,
    purpose: &str,
    load: impl FnOnce(&Path) -> Result<Arc<Picture>, PictureError>,
    scene: &str,
    context: &mut Context,
) -> Option<Arc<Picture>> {
    let name = string(entry, "The picture", context)?;
    if name.is_empty() {
        let mistake = draft("pathmarch::empty_name", entry.value_span, "This name is empty.");
        context.report.add(mistake.label("expected the path of a .png or .jpg file"));
        return None;
    }
    let path = relative_to(scene, name);
    if context.refuses(&path, entry) {
        return None;
    }
    match load(&path) {
        Ok(picture) => Some(picture),
        Err(error) => {
            let message = format!("The picture {} cannot be {purpose}.", shown(name));
            let mistake = draft("pathmarch::texture_picture", entry.value_span, message);
            context.report.add(mistake.label(error.to_string()).help(error.help()));
            None
        }
    }
}

/// Reports braces of a parameter that cannot be textured.
pub(super) fn refuse(node: &Node, context: &mut Context) {
    let has_texture = node.child_nodes().iter().any(|child| textures::names().contains(&&*child.name.value));
    if !has_texture {
        return no_children(node, context);
    }
    let message = format!("`{}` cannot be textured.", node.name.value);
    let child = node.child_nodes()[0].name.span;
    let mistake = draft("pathmarch::no_texture", child, message).label("not here");
    context.report.add(mistake.help(match &*node.name.value {
        "absorb" => "It is the same everywhere in the solid. Its colour may vary.",
        "emit" => "A lamp has one radiance. Make several lamps, or light a surface whose colour varies.",
        "ior" => "It is the same everywhere. Its roughness may vary.",
        _ => "It is the same everywhere.",
    }));
}
