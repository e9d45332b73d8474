//! Textures: what stands in the braces of a parameter of a material, or of `bump`.
//!
//! The node that names the kind carries its numbers as properties; in its braces stand its place and, for a colour, the
//! colours of its values.

use super::arguments::{Range, arguments, colour, in_range, no_children, properties, string};
use super::names::{PLACEMENT, unexpected_node};
use super::report::{Report, draft, shown};
use super::schema::COLOUR;
use super::solids::{Placements, number};
use super::tree::{Entry, Node};
use crate::assets::Assets;
use crate::materials::Meaning;
use crate::textures::{self, Pattern, Texture, TextureKind, TextureNumbers};
use pathmarch_field::Param;
use std::path::Path;

/// What a texture's values are to stand for.
#[derive(Clone, Copy)]
pub(super) enum Use {
    /// A colour.
    Colour,
    /// A number of this range.
    Number(Range),
    /// A height, metres.
    Height,
}

/// The node of a picture.
pub(crate) const PICTURE: &str = "picture";
/// The most colours of a row.
const MOST_COLOURS: usize = 64;
/// Width of a picture that says none.
pub(crate) static PICTURE_SIZE: Param = Param::length("size", 1.0, "Width of the picture.");
/// Height of a relief that says none.
pub(crate) static HEIGHT: Param =
    Param::any("height", 0.005, "How far outwards a value of 1 is from one of 0; below 0 it is inwards.");

/// The names of all textures.
pub(crate) fn names() -> Vec<&'static str> {
    textures::kinds().iter().map(|kind| kind.name).chain([PICTURE]).collect()
}

/// Where files are looked for, and those that were read before.
pub(super) struct Files<'a> {
    /// The path of the scene file.
    pub(super) scene: &'a str,
    pub(super) assets: &'a mut Assets,
}

/// The texture in the braces of a node and what its values mean; a height is a range that starts at 0.
pub(super) fn texture(owner: &Node, to: Use, files: &mut Files, report: &mut Report) -> Option<(Texture, Meaning)> {
    let place = format!("in `{}`", owner.name.value);
    let mut found: Option<&Node> = None;
    for child in owner.child_nodes() {
        if !names().contains(&&*child.name.value) {
            unexpected_node(&child.name, &names(), &place, report);
        } else if let Some(first) = found {
            let message = format!("`{}` has one texture.", owner.name.value);
            let mistake = draft("pathmarch::duplicate", child.name.span, message).label("a second texture");
            report.add(mistake.also(first.name.span, "the first"));
        } else {
            found = Some(child);
        }
    }
    let Some(node) = found else {
        if owner.child_nodes().is_empty() && !owner.broken() {
            let message = format!("`{}` has no texture in its braces.", owner.name.value);
            let mistake = draft("pathmarch::missing_node", owner.name.span, message).label("expected a texture");
            report.add(mistake.help(format!("For example: {} {{ fbm size=0.1 }}.", owner.name.value)));
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
        Use::Height => &["height"],
    };
    let known: Vec<&str> = numbers.iter().map(|param| &*param.name).chain(meant.iter().copied()).collect();
    let named = properties(node, &known, report);
    let values = values(numbers, &named, report);
    let meaning = meaning(node, kind, to, &named, report);
    let mut placement = Placements::default();
    for child in node.child_nodes() {
        if !(placement.take(child, false, report) || child.name.value == COLOUR && matches!(to, Use::Colour)) {
            let colours = matches!(to, Use::Colour).then_some(COLOUR);
            let known: Vec<&str> = PLACEMENT.iter().copied().chain(colours).collect();
            unexpected_node(&child.name, &known, &format!("in a `{}`", node.name.value), report);
        }
    }
    let pattern = match kind {
        Some(kind) => {
            arguments(node, 0, &format!("`{}`, with its numbers by name", kind.name), report);
            Pattern::Computed { kind, numbers: values }
        }
        None => picture(node, values[0], matches!(to, Use::Colour), files, report)?,
    };
    Some((Texture { pattern, pose: placement.value.pose() }, meaning?))
}

/// The numbers of a texture.
fn values(params: &[Param], named: &[(&str, &Entry)], report: &mut Report) -> TextureNumbers {
    let mut values = TextureNumbers::default();
    for (value, param) in values.iter_mut().zip(params) {
        let entry = named.iter().find(|(name, _)| *name == param.name).map(|(_, entry)| *entry);
        *value = entry.and_then(|entry| number(param, entry, report)).unwrap_or(param.default);
    }
    values
}

fn meaning(
    node: &Node,
    kind: Option<&TextureKind>,
    to: Use,
    named: &[(&str, &Entry)],
    report: &mut Report,
) -> Option<Meaning> {
    let entry = |name: &str| named.iter().find(|(word, _)| *word == name).map(|(_, entry)| *entry);
    match to {
        Use::Colour => {
            let colours = colours(node, report)?;
            Some(match (colours.is_empty(), kind) {
                (false, _) => Meaning::Colours(colours),
                (true, None) => Meaning::OwnColours,
                (true, Some(_)) => Meaning::Colours(DEFAULT_COLOURS.to_vec()),
            })
        }
        Use::Number(range) => {
            let mut end = |word: &str, default: f32| match entry(word) {
                Some(entry) => in_range(entry, &format!("`{word}`"), range, report),
                None => Some(default),
            };
            let (from, to) = (end("from", range.min), end("to", range.max));
            Some(Meaning::Range([from?, to?]))
        }
        Use::Height => {
            let height = match entry(&HEIGHT.name) {
                Some(entry) => number(&HEIGHT, entry, report),
                None => Some(HEIGHT.default),
            };
            Some(Meaning::Range([0.0, height?]))
        }
    }
}

/// From dark to light grey: where no colours are given.
pub(super) const DEFAULT_COLOURS: [[f32; 3]; 2] = [[0.02; 3], [0.9; 3]];

/// The row of colours in the braces of a node; `None` after a mistake.
pub(super) fn colours(node: &Node, report: &mut Report) -> Option<Vec<[f32; 3]>> {
    let nodes: Vec<&Node> = node.child_nodes().iter().filter(|child| child.name.value == COLOUR).collect();
    if nodes.len() > MOST_COLOURS {
        let what = &node.name.value;
        let message = format!("An `{what}` has at most {MOST_COLOURS} colours, not {}.", nodes.len());
        let message =
            if what.starts_with(['a', 'e', 'i', 'o', 'u']) { message } else { message.replacen("An", "A", 1) };
        report.add(draft("pathmarch::too_large", node.name.span, message).label("too many colours"));
        return None;
    }
    let read: Vec<_> = nodes.iter().map(|child| colour(child, Range::from_to(0.0, 1.0), report)).collect();
    read.into_iter().collect()
}

/// `picture "wood.jpg" size=1`.
fn picture(node: &Node, size: f32, encoded: bool, files: &mut Files, report: &mut Report) -> Option<Pattern> {
    let usage = "`picture \"wood.jpg\" size=1`";
    let entries = arguments(node, 1, usage, report);
    let Some(entry) = entries.first() else {
        super::arguments::missing_arguments(node, usage, report);
        return None;
    };
    let name = string(entry, "The picture", report)?;
    if name.is_empty() {
        let mistake = draft("pathmarch::empty_name", entry.value_span, "This name is empty.");
        report.add(mistake.label("expected the path of a .png or .jpg file"));
        return None;
    }
    let path = Path::new(files.scene).parent().unwrap_or(Path::new("")).join(name);
    match files.assets.texture(&path, encoded) {
        Ok(picture) => Some(Pattern::Picture { picture, size }),
        Err(error) => {
            let message = format!("The picture {} cannot be a texture.", shown(name));
            let mistake = draft("pathmarch::texture_picture", entry.value_span, message);
            report.add(mistake.label(error.to_string()).help(error.help()));
            None
        }
    }
}

/// Reports braces behind a parameter that no texture may stand for.
pub(super) fn refuse(node: &Node, report: &mut Report) {
    let has_texture = node.child_nodes().iter().any(|child| names().contains(&&*child.name.value));
    if !has_texture {
        return no_children(node, report);
    }
    let message = format!("No texture may stand for `{}`.", node.name.value);
    let child = node.child_nodes()[0].name.span;
    let mistake = draft("pathmarch::no_texture", child, message).label("not here");
    report.add(mistake.help(match &*node.name.value {
        "absorb" => "It is of what the solid is filled with, which is the same everywhere. Its colour may vary.",
        "emit" => "A lamp is of one radiance. Make several lamps, or light a surface whose colour varies.",
        "ior" => "It is the same everywhere. Its roughness may vary.",
        _ => "It is the same everywhere.",
    }));
}
