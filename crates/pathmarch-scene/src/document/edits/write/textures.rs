//! Writing of textures.

use super::Writer;
use crate::document::control::Value;
use crate::document::error::EditError;
use crate::document::parameters::{Inside, Place, holder, target};
use crate::document::text::layout::{before_spaces, bytes};
use crate::document::text::literals::{fresh, numbers};
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::{arguments, child, property, texture_node};
use crate::language::keywords::{COLOUR_POSITION, DECAL};
use crate::language::tree::{self, Entry, Node};
use crate::materials::{self, BUMP_HEIGHT};
use crate::textures;

impl<'d> Writer<'d> {
    /// Patches that set a parameter of a texture, a colour ramp or a decal.
    pub(crate) fn write_inside(&self, place: &Place, inside: Inside, value: &Value) -> Result<Vec<Patch>, EditError> {
        let Some(holder) = holder(self.node, place) else {
            return match (place, inside) {
                (Place::Decal(..), Inside::Argument) => self.insert(&format!("{DECAL} {}", fresh(value))),
                _ => Ok(Vec::new()),
            };
        };
        match (inside, target(holder, inside)) {
            (Inside::Property(word), Some(node)) => Ok(self.of(node).write_property(word, value)),
            (Inside::ColourPosition(_), Some(node)) => Ok(self.of(node).write_property(COLOUR_POSITION, value)),
            (_, Some(node)) => Ok(self.of(node).write_arguments(value)),
            (Inside::Node(name), None) => self.of(holder).insert(&format!("{name} {}", fresh(value))),
            (_, None) => Ok(Vec::new()),
        }
    }

    /// Patches that reset it to its default.
    pub(crate) fn erase_inside(&self, place: &Place, inside: Inside) -> Result<Vec<Patch>, EditError> {
        let Some(holder) = holder(self.node, place) else { return Ok(Vec::new()) };
        let erased = |node: &Node<'static>, word: &str| {
            let entry = property(node, word);
            entry.map(|entry| self.of(node).remove(entry)).into_iter().collect()
        };
        match inside {
            Inside::Property(word) => Ok(erased(holder, word)),
            Inside::ColourPosition(_) => {
                Ok(target(holder, inside).map_or_else(Vec::new, |node| erased(node, COLOUR_POSITION)))
            }
            Inside::Node(name) => self.of(holder).erase_node(name),
            // A decal without a picture is none.
            Inside::Argument if matches!(place, Place::Decal(..)) => {
                self.erase_child(|child| std::ptr::eq(child, holder))
            }
            Inside::Argument | Inside::Colour(_) => Ok(Vec::new()),
        }
    }

    /// Patches that give a parameter a texture of this kind. Placement and colours of a previous texture stay; a colour
    /// becomes the last one of the ramp.
    pub(crate) fn write_texture(&self, owner: &str, kind: &str) -> Result<Vec<Patch>, EditError> {
        let Some(node) = child(self.node, owner) else { return self.insert(&format!("{owner} {{ {kind} }}")) };
        if let Some(texture) = texture_node(self.node, owner) {
            let known: Vec<&str> =
                textures::kind(kind).into_iter().flat_map(|kind| kind.params).map(|p| &*p.name).collect();
            let stays = |name: &str| known.contains(&name) || ["from", "to", &BUMP_HEIGHT.name].contains(&name);
            let mut patches = vec![Patch::replace(bytes(texture.name.span), kind)];
            for entry in &texture.entries {
                if !entry.name.as_ref().is_some_and(|name| stays(&name.value)) {
                    let span = bytes(entry.span);
                    patches.push(Patch::remove(before_spaces(self.text, span.start)..span.end));
                }
            }
            return Ok(patches);
        }
        let texture = match (self.ramp_to_colour(node), textures::kind(kind)) {
            (Some(ramp), Some(_)) => format!("{kind} {{ {ramp} }}"),
            _ => kind.to_owned(),
        };
        let mut patches: Vec<Patch> = arguments(node)
            .map(|entry| {
                let span = bytes(entry.span);
                Patch::remove(before_spaces(self.text, span.start)..span.end)
            })
            .collect();
        match &node.children {
            Some(_) => patches.extend(self.of(node).insert(&texture)?),
            None => patches.push(Patch::insert(node.whole.end as usize, format!(" {{ {texture} }}"))),
        }
        Ok(patches)
    }

    /// The ramp from a darker shade to the colour that a node gives; `None` of a node that gives no colour. A formula stays
    /// one in the last colour, and has a dark grey before it.
    fn ramp_to_colour(&self, node: &Node<'static>) -> Option<String> {
        let given: Vec<_> = arguments(node).collect();
        let is_colour = materials::kind(&node.name.value).is_some() && !given.is_empty() || given.len() == 3;
        let written: Vec<&str> = given.iter().map(|entry| &self.text[bytes(entry.value_span)]).collect();
        let darker = |entry: &&Entry<'static>| match entry.value {
            tree::Value::Number(value) => Some(((0.3 * value * 1e3).round() / 1e3) as f32),
            _ => None,
        };
        let shade = given.iter().map(darker).collect::<Option<Vec<f32>>>();
        let shade = shade.map_or_else(|| "0.05".to_owned(), |shade| numbers(&shade));
        is_colour.then(|| format!("colour {shade}; colour {}", written.join(" ")))
    }

    /// Patches that replace a texture by the default of its parameter.
    pub(crate) fn erase_texture(&self, owner: &str) -> Result<Vec<Patch>, EditError> {
        let is_kind = materials::kind(owner).is_some();
        match child(self.node, owner).and_then(|node| node.children.as_ref()) {
            Some(block) if is_kind => {
                let start = before_spaces(self.text, block.span.start as usize);
                Ok(vec![Patch::remove(start..block.span.end as usize)])
            }
            _ => self.erase_node(owner),
        }
    }
}
