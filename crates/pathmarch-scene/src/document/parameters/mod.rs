//! The parameters of a node: the control of each, and its place in the text.
//!
//! Shapes, operators, materials and textures declare their parameters themselves; all others are in the tables of
//! [`crate::settings`].

mod controls;
mod place;
mod solids;
mod textures;
mod values;

use super::control::{Control, ControlKind, Value};
use super::key;
use super::tree::nodes::{arguments, child, material_kind, material_names, property, sky_form, text_argument};
use super::tree::outline::ItemKind;
use crate::language::Values;
use crate::language::keywords::{FIELD, FONT, MATERIAL, MESH, ORBIT_TRAP, SHAPE};
use crate::language::read::params;
use crate::language::tree::{self, Block, Node};
use crate::materials::{self, Trap};
use crate::settings::{self, AUTO, Range, SKY_FORMS, Setting, SettingKind};
use crate::svg_path::DEFAULT_PATH;
use crate::text::DEFAULT_TEXT;
pub(crate) use controls::{material_control, parameter_value};
use controls::{number_range, setting_control};
use pathmarch_field::Outline;
use pathmarch_field::{Solid, registry};
pub(crate) use place::{Inside, Place, holder, target};
pub(crate) use solids::{has_one_size, number_arguments, parameter_values};
use std::borrow::Cow;
pub(crate) use values::{formula_text, read_number};

/// A parameter of a node.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    pub(crate) control: Control,
    pub(crate) place: Place,
}

/// All parameters of a node.
pub(crate) fn parameters(
    file: &Block<'static>,
    values: &Values,
    kind: ItemKind,
    node: &Node<'static>,
) -> Vec<Parameter> {
    let mut list = List { node, values, parameters: Vec::new() };
    match kind {
        ItemKind::Include => {
            let doc = "File from which this one takes materials, shapes, objects and lights; relative to this one.";
            let control = Control::new("file", "file", doc, ControlKind::Text, Value::Text(String::new()));
            list.push(control.required(), Place::Name);
        }
        ItemKind::Param => list.param(),
        ItemKind::Camera => {
            list.name("main");
            list.nodes(settings::CAMERA);
        }
        ItemKind::Render => list.nodes(settings::RENDER),
        ItemKind::Sky => list.sky(),
        ItemKind::Fog => list.nodes(settings::FOG),
        ItemKind::Sun => {
            list.nodes(settings::SUN);
            list.properties(settings::VISIBILITY);
        }
        ItemKind::Point => {
            list.light(settings::POINT);
            list.properties(settings::VISIBILITY);
        }
        ItemKind::Spot => {
            list.light(settings::SPOT);
            list.properties(settings::VISIBILITY);
        }
        ItemKind::Material => list.material(),
        ItemKind::Object => {
            list.name("");
            list.material_of(file, "Material of the shapes that name no other.");
            if list.emits(file) {
                list.properties(settings::EMITTER);
            }
            list.properties(settings::VISIBILITY);
        }
        ItemKind::Shape | ItemKind::Operator => {
            if node.name.value == MESH {
                list.mesh(file);
            } else if let Some(solid) = values.fields.solid(&node.name.value) {
                list.solid(file, solid);
            }
        }
        ItemKind::Field | ItemKind::Declaration => list.name(""),
        ItemKind::Instance => {
            if let Some(declared) = declaration(file, values, &node.name.value) {
                list.instance(file, declared);
            }
        }
        ItemKind::Version | ItemKind::Other => {}
    }
    list.parameters
}

/// Declaration of a shape, in a file or in those that it includes.
fn declaration<'n>(file: &'n Block<'static>, values: &'n Values, name: &str) -> Option<&'n Node<'static>> {
    let all = file.nodes.iter().chain(values.included.iter());
    let mut declared = all.filter(|declared| matches!(&*declared.name.value, SHAPE | FIELD));
    declared.find(|declared| text_argument(declared) == Some(name))
}

/// Parameters of a node, so far.
struct List<'n> {
    node: &'n Node<'static>,
    values: &'n Values,
    parameters: Vec<Parameter>,
}

impl List<'_> {
    /// Adds a parameter, with the value that the node gives it.
    fn push(&mut self, control: Control, place: Place) {
        let given = values::given(self.node, &place, &control.kind);
        let value = given.clone().flatten().unwrap_or_else(|| control.default.clone());
        let present = match &value {
            Value::Formulas(_) => values::evaluated(self.node, &place, &control.kind, self.values)
                .unwrap_or_else(|| control.default.clone()),
            plain => plain.clone(),
        };
        let control = Control { value, present, given: given.is_some(), ..control };
        self.parameters.push(Parameter { control, place });
    }

    fn name(&mut self, default: &str) {
        let doc = "Name, unlike those of the others.";
        let control = Control::new(key::NAME, key::NAME, doc, ControlKind::Text, Value::Text(default.to_owned()));
        self.push(control.required(), Place::Name);
    }
    fn kind(&mut self, options: Vec<Cow<'static, str>>, now: &str, doc: impl Into<Cow<'static, str>>) {
        let kind = ControlKind::Choice(options);
        let control = Control::new(key::KIND, key::KIND, doc, kind, Value::Text(now.to_owned())).required();
        self.parameters.push(Parameter { control: Control { given: true, ..control }, place: Place::Kind });
    }
    fn material_of(&mut self, file: &Block<'static>, doc: &'static str) {
        let kind = ControlKind::Material(material_names(file, self.values));
        let control = Control::new(key::MATERIAL, key::MATERIAL, doc, kind, Value::None);
        self.push(control, Place::Property(Cow::Borrowed(MATERIAL)));
    }

    /// True of an object whose material is a lamp, or that has a flux.
    fn emits(&self, file: &Block<'static>) -> bool {
        let is_given = property(self.node, settings::EMITTER[0].name).is_some();
        let Some(tree::Value::Text(name)) = property(self.node, MATERIAL).map(|entry| &entry.value) else {
            return is_given;
        };
        let all = file.nodes.iter().chain(self.values.included.iter()).filter(|node| node.name.value == "material");
        let own = all.filter(|node| text_argument(node) == Some(name)).find_map(material_kind);
        is_given || own.is_some_and(|kind| kind.bsdf.is_none() && kind.has_surface)
    }

    /// A setting of a table.
    fn setting(&mut self, key: impl Into<Cow<'static, str>>, setting: &Setting, place: Place) {
        let control = setting_control(key.into(), setting).map(|control| match setting.kind {
            // It is a number again once it is reset.
            SettingKind::NumberOrAuto { .. } if self.is_auto(setting.name) => {
                let (kind, auto) = (ControlKind::Choice(vec![Cow::Borrowed(AUTO)]), Value::Text(AUTO.to_owned()));
                Control { kind, default: auto, ..control }
            }
            _ => control,
        });
        control.into_iter().for_each(|control| self.push(control, place.clone()));
    }
    /// True if the node gives a setting the value "auto".
    fn is_auto(&self, name: &str) -> bool {
        child(self.node, name).and_then(text_argument) == Some(AUTO)
    }
    /// Settings that are nodes in braces.
    fn nodes(&mut self, table: &'static [Setting]) {
        for setting in table {
            let SettingKind::Properties(properties) = setting.kind else {
                self.setting(setting.name, setting, Place::Node(setting.name));
                continue;
            };
            for property in properties {
                let key = format!("{}.{}", setting.name, property.name);
                self.setting(key, property, Place::NodeProperty(setting.name, property.name));
            }
        }
    }
    /// Settings of a light: its intensity in the unit that it is given in.
    fn light(&mut self, table: &'static [Setting]) {
        let given = |word: &str| child(self.node, word).is_some();
        let luminous = given("candela") || given("lumen");
        let shows = |setting: &&Setting| match setting.name {
            "intensity" => !luminous,
            "candela" | "lumen" => given(setting.name),
            "colour" => luminous,
            _ => true,
        };
        for setting in table.iter().filter(shows).collect::<Vec<_>>() {
            self.setting(setting.name, setting, Place::Node(setting.name));
        }
    }
    /// Settings that are properties.
    fn properties(&mut self, table: &'static [Setting]) {
        for setting in table {
            self.setting(setting.name, setting, Place::Property(Cow::Borrowed(setting.name)));
        }
    }
    fn placement(&mut self, facing: bool) {
        for (setting, key) in settings::PLACEMENT.iter().zip([key::AT, key::ROTATE, key::SCALE]) {
            self.setting(key, setting, Place::Node(setting.name));
        }
        if facing {
            self.setting(key::NORMAL, &settings::NORMAL, Place::Node(settings::NORMAL.name));
        }
    }

    fn param(&mut self) {
        self.name("");
        let control = self.declared_number(self.node, Cow::Borrowed(key::VALUE));
        self.push(Control { default: Value::Number(0.0), ..control }.required(), Place::Argument(1));
    }
    /// Control of a number that a `param` node declares; its default is the value there.
    fn declared_number(&self, param: &Node<'static>, name: Cow<'static, str>) -> Control {
        let number = |entry: Option<&tree::Entry<'static>>| entry.and_then(|entry| values::number(entry, self.values));
        let limit = |word: &str, open: f32| number(property(param, word)).unwrap_or(open);
        let range = Range::from_to(limit("min", f32::MIN), limit("max", f32::MAX));
        let default = number(arguments(param).nth(1));
        let kind = ControlKind::Number(number_range(range, false, "", default));
        let doc = match property(param, "doc").map(|entry| &entry.value) {
            Some(tree::Value::Text(doc)) => Cow::Owned(doc.to_string()),
            _ => Cow::Borrowed("A number that formulas use by its name."),
        };
        Control::new(name.clone(), name, doc, kind, Value::Number(default.unwrap_or(0.0)))
    }

    /// Use of a declared shape.
    fn instance(&mut self, file: &Block<'static>, declared: &Node<'static>) {
        for (index, param) in params::nodes(declared.child_nodes()).enumerate() {
            let Some(name) = params::declared_name(param).map(|name| Cow::<'static, str>::Owned(name.to_owned()))
            else {
                continue;
            };
            let control = self.declared_number(param, name.clone());
            let is_argument = arguments(self.node).nth(index).is_some();
            self.push(control, if is_argument { Place::Argument(index) } else { Place::Property(name) });
        }
        self.material_of(file, "Material of the shapes in it that name no other; that of the parent when absent.");
        self.placement(false);
    }

    fn sky(&mut self) {
        let form = sky_form(self.node);
        self.kind(SKY_FORMS.iter().map(|(name, _)| Cow::Borrowed(*name)).collect(), form, "Form of the sky.");
        match form {
            "gradient" => self.nodes(settings::GRADIENT),
            "day" => {
                self.properties(settings::DAY);
                self.nodes(settings::DAY_GROUND);
            }
            "picture" => {
                let doc = "A .hdr or .exr file, relative to the scene file.";
                let none = Value::Text(String::new());
                let control = Control::new(key::PICTURE, key::PICTURE, doc, ControlKind::Picture, none);
                self.push(control.required(), Place::Name);
                self.properties(settings::PICTURE);
            }
            _ => {
                let doc = "Radiance from every direction.";
                let kind = ControlKind::Colour { max: f32::MAX };
                let control = Control::new("colour", "colour", doc, kind, Value::Colour([0.0; 3]));
                self.push(Control { unit: "W/(m² sr)", ..control }.required(), Place::Arguments);
            }
        }
    }

    fn material(&mut self) {
        self.name("");
        let kinds = materials::kinds().iter().map(|kind| Cow::Borrowed(kind.name)).collect();
        let Some(kind) = material_kind(self.node) else { return self.kind(kinds, "", "Kind of the material.") };
        self.kind(kinds, kind.name, kind.doc);
        for (index, param) in kind.params.iter().enumerate() {
            let owner = if index == 0 { kind.name } else { param.name() };
            if !self.texture_of(param, owner) {
                self.push(material_control(param), Place::Node(owner));
                self.texture_choice_of(param, owner);
            }
        }
        if kind.is_shaded() {
            self.orbit_trap();
            self.orbit_trap_colours();
            self.decals();
            self.bump();
        }
    }

    fn orbit_trap(&mut self) {
        let traps = ControlKind::Choice(Trap::ALL.map(|trap| Cow::Borrowed(trap.name())).to_vec());
        let doc = "Colours fractals by what their orbits come near to.";
        let control = Control::new(ORBIT_TRAP, "orbit trap", doc, traps, Value::None);
        let initial = Value::Text(Trap::Point.name().to_owned());
        self.push(Control { initial, ..control }, Place::Node(ORBIT_TRAP));
    }

    fn solid(&mut self, file: &Block<'static>, solid: Solid) {
        let info = solid.info();
        let is_alike =
            |other: &Solid| other.is_operator() == solid.is_operator() && other.info().profile == info.profile;
        let custom = self.values.fields.names().filter(|_| !solid.is_operator() && !info.profile);
        let custom = custom.map(|name| Cow::Owned(name.to_owned()));
        let alike = registry::solids().filter(is_alike).map(|other| other.info().name.clone()).chain(custom);
        self.kind(alike.collect(), &info.name, info.doc.clone());
        match info.outline {
            Some(Outline::Text) => self.text(),
            Some(Outline::Path) => self.path(),
            Some(Outline::Points | Outline::Curve) | None => {}
        }
        self.parameters.extend(solids::solid_parameters(solid, self.node, self.values));
        if let Solid::Operator(operator) = solid
            && operator.blends()
        {
            self.properties(settings::BLEND);
        }
        let doc = match solid.is_operator() {
            false => "Material of this shape; that of the parent when absent.",
            true => "Material of the shapes in it that name no other; that of the parent when absent.",
        };
        self.material_of(file, doc);
        self.placement(info.facing);
    }

    fn mesh(&mut self, file: &Block<'static>) {
        let doc = "A .glb, .gltf, .obj, .stl, .ply or .npy file, relative to the scene file.";
        let control = Control::new("file", "file", doc, ControlKind::Text, Value::Text(String::new()));
        self.push(control.required(), Place::Argument(0));
        self.properties(settings::MESH);
        self.material_of(file, "Material of the mesh; those of its file when absent.");
        self.placement(false);
    }

    fn path(&mut self) {
        let doc = "A path in the notation of SVG: the attribute d of a <path>.";
        let default = Value::Text(DEFAULT_PATH.to_owned());
        let control = Control::new(key::PATH, key::PATH, doc, ControlKind::Text, default);
        self.push(control, Place::Argument(0));
    }

    /// Words and font of a text.
    fn text(&mut self) {
        let words = Value::Text(DEFAULT_TEXT.to_owned());
        let doc = "Words of the text; \\n begins another line.";
        let control = Control::new(key::TEXT, key::TEXT, doc, ControlKind::Text, words);
        self.push(control.required(), Place::Argument(0));
        let doc = "A .ttf or .otf file, relative to the scene file; the included font when absent.";
        let control = Control::new(FONT, FONT, doc, ControlKind::Picture, Value::Text(String::new()));
        self.push(control, Place::Property(Cow::Borrowed(FONT)));
    }
}
