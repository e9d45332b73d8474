//! Parameters of textures, of orbit traps and of decals.

use super::List;
use super::controls::{number_range, parameter_control};
use super::place::{Inside, Place, colours, decals};
use crate::document::control::{Control, ControlKind, Value};
use crate::document::key;
use crate::document::tree::nodes::{child, texture_node};
use crate::language::keywords::{BUMP, COLOUR, COLOUR_POSITION, DECAL, ORBIT_TRAP, TRAP_NUMBERS};
use crate::materials::{BUMP_HEIGHT, MaterialParam, ParamKind, Texturing};
use crate::settings::{self, PLACEMENT};
use crate::textures::{self, PICTURE, PICTURE_SIZE};
use pathmarch_field::Param;
use std::borrow::Cow;

impl List<'_> {
    /// Adds the parameters of the texture of a material's parameter. Returns false if it has none.
    pub(super) fn texture_of(&mut self, param: &'static MaterialParam, owner: &'static str) -> bool {
        if param.texturing == Texturing::None || texture_node(self.node, owner).is_none() {
            return false;
        }
        self.texture(param.name(), owner, param.kind == ParamKind::Colour, &[]);
        if let ParamKind::Number = param.kind {
            for (word, doc, default) in [
                ("from", "Value of the parameter for a texture of 0.", param.spec.range.min),
                ("to", "Value of the parameter for a texture of 1.", param.spec.range.max),
            ] {
                let end = Param::within("", default, param.spec.range, doc);
                self.inside(param.name(), owner, word, &end, Inside::Property(word));
            }
        }
        true
    }

    /// Adds the choice of a texture for a material's parameter that has a value.
    pub(super) fn texture_choice_of(&mut self, param: &'static MaterialParam, owner: &'static str) {
        if param.texturing != Texturing::None {
            self.choice(param.name(), owner);
        }
    }

    /// Adds the bump texture, or the choice of one.
    pub(super) fn bump(&mut self) {
        match texture_node(self.node, BUMP) {
            Some(_) => self.texture(BUMP, BUMP, false, std::slice::from_ref(&BUMP_HEIGHT)),
            None => self.choice(BUMP, BUMP),
        }
    }

    /// Adds the range and the colours of an orbit trap.
    pub(super) fn orbit_trap_colours(&mut self) {
        let Some(node) = child(self.node, ORBIT_TRAP) else { return };
        for (word, default) in TRAP_NUMBERS {
            let doc = match word {
                "from" | "to" => "Value of the trap at this end of the colours.",
                _ => "Centre of the trap, in the coordinates of the fractal.",
            };
            let end = Param { default, ..Param::any("", 0.0, doc) };
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
            BUMP => "Bumps that light shows, without changing the shape.",
            _ => "Texture that varies the parameter along the surface.",
        };
        let label = if owner == BUMP { BUMP.to_owned() } else { format!("{name} texture") };
        let initial = Value::Text(options[0].to_string());
        let key = format!("{name}.{}", key::TEXTURE);
        let control = Control::new(key, label, doc, ControlKind::Choice(options), Value::None);
        self.push(Control { initial, ..control }, Place::Texture(owner));
    }

    fn texture(&mut self, name: &str, owner: &'static str, coloured: bool, more: &'static [Param]) {
        self.choice(name, owner);
        let Some(node) = texture_node(self.node, owner) else { return };
        let params = match textures::kind(&node.name.value) {
            Some(kind) => kind.params,
            None => {
                let doc = "A .png or .jpg file, relative to the scene file.";
                let (key, label) = (format!("{name}.{PICTURE}"), format!("{name} {PICTURE}"));
                let control = Control::new(key, label, doc, ControlKind::Text, Value::Text(String::new()));
                self.push(control.required(), Place::Inside(owner, Inside::Argument));
                std::slice::from_ref(&PICTURE_SIZE)
            }
        };
        for param in params.iter().chain(more) {
            self.inside(name, owner, &param.name, param, Inside::Property(&param.name));
        }
        for setting in PLACEMENT {
            let place = Place::Inside(owner, Inside::Node(setting.name));
            self.setting(format!("{name}.texture.{}", setting.name), setting, place);
            if let Some(parameter) = self.parameters.last_mut() {
                parameter.control.label = Cow::Owned(format!("{name} {}", setting.label));
            }
        }
        if coloured {
            self.colours(name, owner, colours(node).count());
        }
    }

    fn inside(&mut self, name: &str, owner: &'static str, word: &str, param: &Param, place: Inside) {
        let (key, label) = (format!("{name}.{word}").into(), format!("{name} {word}").into());
        self.push(Control { key, label, ..parameter_control(param) }, Place::Inside(owner, place));
    }

    /// Adds the colours of a ramp.
    fn colours(&mut self, name: &str, owner: &'static str, count: usize) {
        for index in 0..count {
            let key = format!("{name}.{COLOUR}.{}", index + 1);
            let owner_name = if name == COLOUR { String::new() } else { format!("{name} ") };
            let label = format!("{owner_name}{COLOUR} {}", index + 1);
            let doc = "Colour of the ramp, which goes from the value 0 to the value 1.";
            let control = Control::new(key, label, doc, ControlKind::Colour { max: 1.0 }, Value::Colour([0.0; 3]));
            self.push(control.required(), Place::Inside(owner, Inside::Colour(index)));
            let unit = Param::between("", 0.0, 0.0, 1.0, "Value that has this colour; evenly spaced when absent.");
            let kind = ControlKind::Number(number_range(unit.range, false, "", None));
            let key = format!("{name}.{COLOUR}.{}.{COLOUR_POSITION}", index + 1);
            let label = format!("{name} {COLOUR} {} {COLOUR_POSITION}", index + 1);
            let control = Control::new(key, label, unit.doc, kind, Value::None);
            let initial = Value::Number(if count > 1 { index as f32 / (count - 1) as f32 } else { 0.0 });
            self.push(Control { initial, ..control }, Place::Inside(owner, Inside::ColourPosition(index)));
        }
    }

    /// Adds the parameters of all decals, and the file of one more.
    pub(super) fn decals(&mut self) {
        let count = decals(self.node).count();
        for index in 0..=count {
            let name = format!("{DECAL} {}", index + 1);
            let doc = "A .png or .jpg file that is projected once, relative to the scene file.";
            let (key, label) = (format!("{DECAL}.{}.{PICTURE}", index + 1), format!("{name} {PICTURE}"));
            let control = Control::new(key, label, doc, ControlKind::Picture, Value::Text(String::new()));
            self.push(control, Place::Decal(index, Inside::Argument));
            if index == count {
                break;
            }
            let settings = settings::DECAL.iter().map(|setting| (setting, Inside::Property(setting.name)));
            for (setting, inside) in
                settings.chain(PLACEMENT.iter().map(|setting| (setting, Inside::Node(setting.name))))
            {
                self.setting(format!("{DECAL}.{}.{}", index + 1, setting.name), setting, Place::Decal(index, inside));
                if let Some(parameter) = self.parameters.last_mut() {
                    parameter.control.label = Cow::Owned(format!("{name} {}", setting.label));
                }
            }
        }
    }
}
