//! The controls of textures: those of the one in the braces of a material's parameter, and what makes one stand there.

use super::control::{ControlKind, Value};
use super::error::EditError;
use super::key;
use super::layout::{before_spaces, bytes};
use super::patch::Patch;
use super::slots::{List, Place, arguments, child, control, parameter_control};
use super::write::Writer;
use crate::language::schema::{BUMP, COLOUR, ORBIT_TRAP, PLACEMENT};
use crate::language::textures::{HEIGHT, PICTURE, PICTURE_SIZE, names};
use crate::language::tree::Node;
use crate::materials::{MaterialParam, ParamKind, Texturing};
use crate::textures;
use pathmarch_field::Param;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Mutex;

/// Where something stands in a texture, or in a node of colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Inside {
    /// Its first argument.
    Argument,
    /// A property.
    Property(&'static str),
    /// The arguments of a node in its braces.
    Node(&'static str),
    /// The colour of this index in its braces.
    Colour(usize),
}

/// The node of a texture in the braces of the node `owner` of a material.
pub(super) fn texture_node<'n>(material: &'n Node<'static>, owner: &str) -> Option<&'n Node<'static>> {
    child(material, owner)?.child_nodes().iter().find(|node| names().contains(&&*node.name.value))
}

/// What a place inside is inside of: the texture of an owner, or the orbit trap.
fn holder<'n>(material: &'n Node<'static>, owner: &str) -> Option<&'n Node<'static>> {
    if owner == ORBIT_TRAP { child(material, ORBIT_TRAP) } else { texture_node(material, owner) }
}

/// The colour nodes of a texture or an orbit trap.
fn colours<'n>(node: &'n Node<'static>) -> impl Iterator<Item = &'n Node<'static>> {
    node.child_nodes().iter().filter(|child| child.name.value == COLOUR)
}

/// The node that holds the value, for a place inside.
pub(super) fn target<'n>(material: &'n Node<'static>, owner: &str, inside: Inside) -> Option<&'n Node<'static>> {
    let holder = holder(material, owner)?;
    match inside {
        Inside::Argument | Inside::Property(_) => Some(holder),
        Inside::Node(name) => child(holder, name),
        Inside::Colour(index) => colours(holder).nth(index),
    }
}

/// The key of a control that has no name in the source: the same text is the same key. There are as many as there are
/// parameters of materials times words of textures.
fn made_key(text: String) -> &'static str {
    static KEYS: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut keys = KEYS.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    match keys.get(&*text) {
        Some(key) => key,
        None => {
            let key: &'static str = Box::leak(text.into_boxed_str());
            keys.insert(key);
            key
        }
    }
}

impl List<'_> {
    /// The controls of the texture that stands for a parameter; whether there is one.
    pub(super) fn texture_of(&mut self, param: &'static MaterialParam, owner: &'static str) -> bool {
        if param.texturing == Texturing::None {
            return false;
        }
        let known = texture_node(self.node, owner).is_some();
        if known {
            self.texture(param.name, owner, param.kind == ParamKind::Colour, &[]);
            if let ParamKind::Number = param.kind {
                for (word, doc, default) in [
                    ("from", "Value of the parameter for a value of 0.", param.min),
                    ("to", "Value of the parameter for a value of 1.", param.max),
                ] {
                    let end = Param::between("", 0.0, param.min, param.max, doc).with_default(default);
                    self.inside(param.name, owner, word, &end, Inside::Property(word));
                }
            }
        }
        known
    }

    /// What makes a texture stand for a parameter that has a value.
    pub(super) fn texture_choice_of(&mut self, param: &'static MaterialParam, owner: &'static str) {
        if param.texturing != Texturing::None {
            self.choice(param.name, owner);
        }
    }

    /// The relief.
    pub(super) fn bump(&mut self) {
        match texture_node(self.node, BUMP) {
            Some(_) => self.texture(BUMP, BUMP, false, std::slice::from_ref(&HEIGHT)),
            None => self.choice(BUMP, BUMP),
        }
    }

    /// The range and the colours of an orbit trap.
    pub(super) fn trap(&mut self) {
        let Some(node) = child(self.node, ORBIT_TRAP) else { return };
        for (word, default) in [("from", 0.0), ("to", 1.0)] {
            let doc = "Value of the trap at this end of its colours.";
            let end = Param::any("", 0.0, doc).with_default(default);
            self.inside(ORBIT_TRAP, ORBIT_TRAP, word, &end, Inside::Property(word));
        }
        self.colours(ORBIT_TRAP, ORBIT_TRAP, colours(node).count());
    }

    fn choice(&mut self, name: &str, owner: &'static str) {
        let mut options: Vec<Cow<'static, str>> =
            textures::kinds().iter().map(|kind| Cow::Borrowed(kind.name)).collect();
        if texture_node(self.node, owner).is_some_and(|node| node.name.value == PICTURE) {
            options.push(Cow::Borrowed(PICTURE));
        }
        let doc = match owner {
            BUMP => "A relief that light sees and the shape does not have.",
            _ => "What varies along the surface in place of one value.",
        };
        let key = made_key(format!("{name}.{}", key::TEXTURE));
        let initial = Value::Text(options[0].to_string());
        let mut control = control(key, key, doc, "", ControlKind::Choice(options), Value::None);
        control.label = Cow::Owned(if owner == BUMP { BUMP.to_owned() } else { format!("{name} texture") });
        control.initial = initial;
        self.push(control, Place::Texture(owner));
    }

    fn texture(&mut self, name: &str, owner: &'static str, coloured: bool, more: &'static [Param]) {
        self.choice(name, owner);
        let Some(node) = texture_node(self.node, owner) else { return };
        let params = match textures::kind(&node.name.value) {
            Some(kind) => kind.params,
            None => {
                let doc = "A .png or .jpg file, relative to the scene file.";
                let key = made_key(format!("{name}.{PICTURE}"));
                let mut control = control(key, key, doc, "", ControlKind::Text, Value::Text(String::new()));
                (control.label, control.required) = (Cow::Owned(format!("{name} {PICTURE}")), true);
                self.push(control, Place::Inside(owner, Inside::Argument));
                std::slice::from_ref(&PICTURE_SIZE)
            }
        };
        for param in params.iter().chain(more) {
            self.inside(name, owner, &param.name, param, Inside::Property(&param.name));
        }
        for setting in PLACEMENT {
            let key = made_key(format!("{name}.texture.{}", setting.name));
            self.setting(key, key, setting, Place::Inside(owner, Inside::Node(setting.name)));
            let label = format!("{name} {}", super::slots::label(setting.name));
            self.relabel(Cow::Owned(label));
        }
        if coloured {
            self.colours(name, owner, colours(node).count());
        }
    }

    fn inside(&mut self, name: &str, owner: &'static str, word: &'static str, param: &Param, place: Inside) {
        let mut control = parameter_control(param);
        control.key = made_key(format!("{name}.{word}"));
        control.label = Cow::Owned(format!("{name} {word}"));
        self.push(control, Place::Inside(owner, place));
    }

    /// The colours that are there.
    fn colours(&mut self, name: &str, owner: &'static str, count: usize) {
        for index in 0..count {
            let key = made_key(format!("{name}.{COLOUR}.{}", index + 1));
            let doc = "A colour of the row, from the value 0 to the value 1.";
            let kind = ControlKind::Colour { max: 1.0 };
            let mut control = control(key, key, doc, "", kind, Value::Colour([0.0; 3]));
            (control.label, control.required) = (Cow::Owned(format!("{name} {COLOUR} {}", index + 1)), true);
            self.push(control, Place::Inside(owner, Inside::Colour(index)));
        }
    }
}

impl<'d> Writer<'d> {
    /// What makes the parameter of a texture or of colours have this value.
    pub(super) fn write_inside(&self, owner: &str, inside: Inside, value: &Value) -> Result<Vec<Patch>, EditError> {
        let Some(holder) = holder(self.node, owner) else { return Ok(Vec::new()) };
        match (inside, target(self.node, owner, inside)) {
            (Inside::Property(word), Some(node)) => Ok(self.of(node).write_property(word, value)),
            (_, Some(node)) => Ok(self.of(node).write_arguments(value)),
            (Inside::Node(name), None) => self.of(holder).insert(&format!("{name} {}", super::number::fresh(value))),
            (_, None) => Ok(Vec::new()),
        }
    }

    /// What makes it have its default.
    pub(super) fn erase_inside(&self, owner: &str, inside: Inside) -> Result<Vec<Patch>, EditError> {
        let Some(holder) = holder(self.node, owner) else { return Ok(Vec::new()) };
        match inside {
            Inside::Property(word) => {
                let entry = super::slots::property(holder, word);
                Ok(entry.map(|entry| self.of(holder).remove(entry)).into_iter().collect())
            }
            Inside::Node(name) => self.of(holder).erase_node(name),
            Inside::Argument | Inside::Colour(_) => Ok(Vec::new()),
        }
    }

    /// What makes a texture of this kind stand for a parameter. Of another one its place and its colours stay.
    pub(super) fn write_texture(&self, owner: &str, kind: &str) -> Result<Vec<Patch>, EditError> {
        let Some(node) = child(self.node, owner) else { return self.insert(&format!("{owner} {{ {kind} }}")) };
        if let Some(texture) = texture_node(self.node, owner) {
            let known: Vec<&str> =
                textures::kind(kind).into_iter().flat_map(|kind| kind.params).map(|p| &*p.name).collect();
            let stays = |name: &str| known.contains(&name) || ["from", "to", &HEIGHT.name].contains(&name);
            let mut patches = vec![Patch::replace(bytes(texture.name.span), kind)];
            for entry in &texture.entries {
                if !entry.name.as_ref().is_some_and(|name| stays(&name.value)) {
                    let span = bytes(entry.span);
                    patches.push(Patch::remove(before_spaces(self.text, span.start)..span.end));
                }
            }
            return Ok(patches);
        }
        let mut patches: Vec<Patch> = arguments(node)
            .map(|entry| {
                let span = bytes(entry.span);
                Patch::remove(before_spaces(self.text, span.start)..span.end)
            })
            .collect();
        match &node.children {
            Some(_) => patches.extend(self.of(node).insert(kind)?),
            None => patches.push(Patch::insert(node.whole.end as usize, format!(" {{ {kind} }}"))),
        }
        Ok(patches)
    }

    /// What gives a parameter its default again in place of a texture.
    pub(super) fn erase_texture(&self, owner: &str) -> Result<Vec<Patch>, EditError> {
        let is_kind = crate::materials::kind(owner).is_some();
        match child(self.node, owner).and_then(|node| node.children.as_ref()) {
            Some(block) if is_kind => {
                let start = before_spaces(self.text, block.span.start as usize);
                Ok(vec![Patch::remove(start..block.span.end as usize)])
            }
            _ => self.erase_node(owner),
        }
    }
}
