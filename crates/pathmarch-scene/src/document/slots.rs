//! The parameters of a node: what each is and where in the text it stands.
//!
//! Shapes, operators and materials say themselves what they have; the rest is in the parser's own table
//! ([`crate::language::schema`]).

use super::control::{Control, ControlKind, NumberRange, Value};
use super::key;
use super::outline::ItemKind;
use super::textures::{Inside, target, texture_node};
use crate::language::Values;
use crate::language::arguments::{Range, srgb};
use crate::language::declared::SHAPE;
use crate::language::expression::Expression;
use crate::language::fields::FIELD;
use crate::language::params;
use crate::language::schema::{self, AXES, FONT, Form, ORBIT_TRAP, Setting};
use crate::language::tree::{self, Block, Entry, Node};
use crate::materials::{self, MaterialKind, MaterialParam, ParamKind, Trap};
use crate::text::DEFAULT_TEXT;
use pathmarch_field::Outline;
use pathmarch_field::{Param, Solid, Unit, registry};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

/// Where in a node a parameter stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// The string that is its first argument.
    Name,
    /// Its argument of this index.
    Argument(usize),
    /// In the words that say what it is.
    Kind,
    /// The number of a shape with this index: an argument or a property.
    Parameter(usize),
    /// A property.
    Property(&'static str),
    /// The arguments of the node itself.
    Arguments,
    /// The arguments of a node in its braces.
    Node(&'static str),
    /// A property of a node in its braces.
    NodeProperty(&'static str, &'static str),
    /// Which texture stands in the braces of a node in its braces.
    Texture(&'static str),
    /// In that texture, or in the orbit trap.
    Inside(&'static str, Inside),
}

/// A parameter.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    pub(super) control: Control,
    pub(super) place: Place,
}

/// A name as long-lived as the program. Each name is kept once: those that people give to the numbers and shapes that they
/// declare, while a program runs.
pub(super) fn interned(name: &str) -> &'static str {
    static NAMES: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    match names.get(name) {
        Some(known) => known,
        None => {
            let kept: &'static str = Box::leak(name.to_owned().into_boxed_str());
            names.insert(kept);
            kept
        }
    }
}

/// The forms of a sky, as they are written and what they are.
pub(super) const SKIES: &[(&str, &str)] = &[
    ("colour", "The same radiance from every direction."),
    ("gradient", "Radiance from up, from the horizon and from below."),
    ("day", "The sky of a clear day, computed, with its sun."),
    ("picture", "A picture of radiance in every direction, a .hdr or .exr file."),
];

/// Which of them a node is.
pub(super) fn sky_form(node: &Node<'static>) -> &'static str {
    match text_argument(node) {
        Some("gradient") => "gradient",
        Some("day") => "day",
        Some(text) if !text.starts_with('#') && Expression::read(text).is_err() => "picture",
        _ => "colour",
    }
}

/// The first argument, if it is a string.
pub(super) fn text_argument<'n>(node: &'n Node<'static>) -> Option<&'n str> {
    match &arguments(node).next()?.value {
        tree::Value::Text(text) => Some(text),
        _ => None,
    }
}

/// The values without a name.
pub(super) fn arguments<'n>(node: &'n Node<'static>) -> impl Iterator<Item = &'n Entry<'static>> {
    node.entries.iter().filter(|entry| entry.name.is_none())
}

/// The property of this name.
pub(super) fn property<'n>(node: &'n Node<'static>, name: &str) -> Option<&'n Entry<'static>> {
    node.entries.iter().find(|entry| entry.name.as_ref().is_some_and(|given| given.value == name))
}

/// The node of this name in a node's braces.
pub(super) fn child<'n>(node: &'n Node<'static>, name: &str) -> Option<&'n Node<'static>> {
    node.child_nodes().iter().find(|child| child.name.value == name)
}

/// The node that says what kind a material is.
pub(super) fn material_kind(node: &Node) -> Option<&'static MaterialKind> {
    node.child_nodes().iter().find_map(|child| materials::kind(&child.name.value))
}

/// Names of all materials of a file and of those that it includes.
pub(super) fn material_names(file: &Block<'static>, values: &Values) -> Vec<String> {
    let nodes = file.nodes.iter().chain(values.included.iter());
    let materials = nodes.filter(|node| node.name.value == "material");
    materials.filter_map(|node| text_argument(node).map(str::to_owned)).collect()
}

/// The parameters of a node.
pub(super) fn slots(file: &Block<'static>, values: &Values, kind: ItemKind, node: &Node<'static>) -> Vec<Slot> {
    let mut list = List { node, values, slots: Vec::new() };
    match kind {
        ItemKind::Include => {
            let doc = "Another file of which this takes materials, shapes, objects and lights; relative to this one.";
            let control = control("file", "file", doc, "", ControlKind::Text, Value::Text(String::new()));
            list.push(control.required(), Place::Name);
        }
        ItemKind::Param => list.param(),
        ItemKind::Camera => {
            list.name("main");
            list.nodes(schema::CAMERA);
        }
        ItemKind::Render => list.nodes(schema::RENDER),
        ItemKind::Sky => list.sky(),
        ItemKind::Sun => list.nodes(schema::SUN),
        ItemKind::Point => list.nodes(schema::POINT),
        ItemKind::Material => list.material(),
        ItemKind::Object => {
            list.name("");
            list.material_of(file, "Material of its shapes that name no other.");
        }
        ItemKind::Shape | ItemKind::Operator => {
            if let Some(solid) = values.fields.solid(&node.name.value) {
                list.solid(file, solid);
            }
        }
        ItemKind::Field => list.name(""),
        ItemKind::Declaration => list.name(""),
        ItemKind::Instance => {
            let all = file.nodes.iter().chain(values.included.iter());
            let declared = all.filter(|declared| matches!(&*declared.name.value, SHAPE | FIELD));
            let mut declared = declared.filter(|declared| text_argument(declared) == Some(&*node.name.value));
            if let Some(declared) = declared.next() {
                list.instance(file, declared);
            }
        }
        ItemKind::Version | ItemKind::Other => {}
    }
    list.slots
}

pub(super) struct List<'n> {
    pub(super) node: &'n Node<'static>,
    values: &'n Values,
    slots: Vec<Slot>,
}

impl List<'_> {
    pub(super) fn push(&mut self, control: Control, place: Place) {
        let given = given(self.node, place, &control.kind);
        let value = given.clone().flatten().unwrap_or_else(|| control.default.clone());
        let present = match &value {
            Value::Formulas(_) => self.worth(place, &control.kind).unwrap_or_else(|| control.default.clone()),
            plain => plain.clone(),
        };
        self.slots.push(Slot { control: Control { value, present, given: given.is_some(), ..control }, place });
    }
    /// What the formulas at a place are worth.
    fn worth(&self, place: Place, kind: &ControlKind) -> Option<Value> {
        let numbers: Option<Vec<f32>> =
            entries(self.node, place).iter().map(|entry| number(entry, self.values)).collect();
        plain(&numbers?, kind)
    }

    /// Gives the last control another name for people.
    pub(super) fn relabel(&mut self, label: Cow<'static, str>) {
        if let Some(slot) = self.slots.last_mut() {
            slot.control.label = label;
        }
    }

    fn name(&mut self, default: &str) {
        let default = Value::Text(default.to_owned());
        let doc = "Its name, unlike those of the others.";
        self.push(control(key::NAME, key::NAME, doc, "", ControlKind::Text, default).required(), Place::Name);
    }
    fn kind(&mut self, options: Vec<&'static str>, now: &str, doc: &'static str) {
        let kind = ControlKind::Choice(options.into_iter().map(Cow::Borrowed).collect());
        let mut control = control(key::KIND, key::KIND, doc, "", kind, Value::Text(now.to_owned())).required();
        (control.value, control.present, control.given) = (control.default.clone(), control.default.clone(), true);
        self.slots.push(Slot { control, place: Place::Kind });
    }
    fn material_of(&mut self, file: &Block<'static>, doc: &'static str) {
        let kind = ControlKind::Material(material_names(file, self.values));
        self.push(control(key::MATERIAL, key::MATERIAL, doc, "", kind, Value::None), Place::Property("material"));
    }

    /// A setting of the parser's table.
    pub(super) fn setting(&mut self, key: &'static str, label: &'static str, setting: &'static Setting, place: Place) {
        let (kind, default) = match setting.form {
            Form::Number { range, default } => {
                let kind = ControlKind::Number(number_range(range, false, setting.unit, default));
                (kind, default.map_or(Value::None, Value::Number))
            }
            Form::Whole { range: (min, max), default } => {
                let range = Range::from_to(min as f32, max as f32);
                let default = default as f32;
                (ControlKind::Number(number_range(range, true, setting.unit, Some(default))), Value::Number(default))
            }
            Form::Size { range: (min, max), default } => (ControlKind::Size { min, max }, Value::Size(default)),
            Form::Triple { default } => (ControlKind::Triple { direction: false }, Value::Triple(default)),
            Form::Direction { default } => (ControlKind::Triple { direction: true }, Value::Triple(default)),
            Form::Colour { max, default } => (ControlKind::Colour { max }, default.map_or(Value::None, Value::Colour)),
            Form::Choice { words } => {
                let words: Vec<Cow<str>> = words().into_iter().map(Cow::Borrowed).collect();
                let first = Value::Text(words[0].to_string());
                (ControlKind::Choice(words), first)
            }
            Form::Flag { default } => (ControlKind::Flag, Value::Flag(default)),
            Form::Properties(_) => return,
        };
        let mut control = control(key, label, setting.doc, setting.unit, kind, default);
        control.required = setting.required;
        if control.default == Value::None {
            control.initial = example(setting, &control.kind);
        }
        self.push(control, place);
    }
    /// Settings that are nodes in braces.
    fn nodes(&mut self, table: &'static [Setting]) {
        for setting in table {
            match setting.form {
                Form::Properties(properties) => {
                    for property in properties {
                        let (key, label) = LENS_KEYS
                            .iter()
                            .find_map(|(name, key, label)| (*name == property.name).then_some((*key, *label)))
                            .unwrap_or((property.name, property.name));
                        self.setting(key, label, property, Place::NodeProperty(setting.name, property.name));
                    }
                }
                _ => self.setting(setting.name, label(setting.name), setting, Place::Node(setting.name)),
            }
        }
    }
    fn placement(&mut self, facing: bool) {
        let keys = [key::AT, key::ROTATE, key::SCALE];
        for (setting, key) in schema::PLACEMENT.iter().zip(keys) {
            self.setting(key, label(setting.name), setting, Place::Node(setting.name));
        }
        if facing {
            self.setting(key::NORMAL, schema::NORMAL.name, &schema::NORMAL, Place::Node(schema::NORMAL.name));
        }
    }

    fn param(&mut self) {
        self.name("");
        let control = self.declared_number(self.node, key::VALUE);
        self.push(Control { default: Value::Number(0.0), ..control }.required(), Place::Argument(1));
    }
    /// The control of a number that a `param` node declares; its default is the value there.
    fn declared_number(&self, param: &Node<'static>, name: &'static str) -> Control {
        let number = |entry: Option<&Entry<'static>>| entry.and_then(|entry| number(entry, self.values));
        let limit = |word: &str, open: f32| number(property(param, word)).unwrap_or(open);
        let range = Range::from_to(limit("min", f32::MIN), limit("max", f32::MAX));
        let default = number(arguments(param).nth(1));
        let kind = ControlKind::Number(number_range(range, false, "", default));
        let mut control = control(name, name, "", "", kind, Value::Number(default.unwrap_or(0.0)));
        control.doc = match property(param, "doc").map(|entry| &entry.value) {
            Some(tree::Value::Text(doc)) => Cow::Owned(doc.to_string()),
            _ => Cow::Borrowed("A number that formulas find under its name."),
        };
        control
    }

    /// A use of a declared shape.
    fn instance(&mut self, file: &Block<'static>, declared: &Node<'static>) {
        for (index, param) in params::nodes(declared.child_nodes()).enumerate() {
            let Some(name) = params::declared_name(param).map(interned) else { continue };
            let control = self.declared_number(param, name);
            let is_argument = arguments(self.node).nth(index).is_some();
            self.push(control, if is_argument { Place::Argument(index) } else { Place::Property(name) });
        }
        self.material_of(file, "Material of what it holds that names no other; that of what it stands in when absent.");
        self.placement(false);
    }

    fn sky(&mut self) {
        let form = sky_form(self.node);
        self.kind(SKIES.iter().map(|(name, _)| *name).collect(), form, "What the sky is.");
        let properties = |list: &mut Self, table: &'static [Setting]| {
            for setting in table {
                list.setting(setting.name, setting.name, setting, Place::Property(setting.name));
            }
        };
        match form {
            "gradient" => self.nodes(schema::GRADIENT),
            "day" => {
                properties(self, schema::DAY);
                self.nodes(schema::DAY_GROUND);
            }
            "picture" => {
                let doc = "A .hdr or .exr file, relative to the scene file.";
                let none = Value::Text(String::new());
                let control = control(key::PICTURE, key::PICTURE, doc, "", ControlKind::Picture, none);
                self.push(control.required(), Place::Name);
                properties(self, schema::PICTURE);
            }
            _ => {
                let doc = "Radiance from every direction.";
                let kind = ControlKind::Colour { max: f32::MAX };
                let control = control("colour", "colour", doc, "W/(m² sr)", kind, Value::Colour([0.0; 3]));
                self.push(control.required(), Place::Arguments);
            }
        }
    }

    fn material(&mut self) {
        self.name("");
        let kinds = materials::kinds().iter().map(|kind| kind.name).collect();
        let Some(kind) = material_kind(self.node) else { return self.kind(kinds, "", "What it is made of.") };
        self.kind(kinds, kind.name, kind.doc);
        for (index, param) in kind.params.iter().enumerate() {
            let owner = if index == 0 { kind.name } else { param.name };
            if !self.texture_of(param, owner) {
                self.push(material_control(param), Place::Node(owner));
                self.texture_choice_of(param, owner);
            }
        }
        if kind.bsdf.is_some() {
            self.orbit_trap();
            self.trap();
            self.bump();
        }
    }

    fn orbit_trap(&mut self) {
        let traps = ControlKind::Choice(Trap::ALL.map(|trap| Cow::Borrowed(trap.name())).to_vec());
        let doc = "Colours fractals by what their orbits come near to.";
        let mut trap = control(ORBIT_TRAP, "orbit trap", doc, "", traps, Value::None);
        trap.initial = Value::Text(Trap::Point.name().to_owned());
        self.push(trap, Place::Node(ORBIT_TRAP));
    }

    fn solid(&mut self, file: &Block<'static>, solid: Solid) {
        let is_alike =
            |other: &Solid| other.is_operator() == solid.is_operator() && other.info().profile == solid.info().profile;
        let own = self.values.fields.names().filter(|_| !solid.is_operator() && !solid.info().profile).map(interned);
        let alike = registry::solids().filter(is_alike).map(|other| interned(&other.info().name)).chain(own);
        self.kind(alike.collect(), &solid.info().name, interned(&solid.info().doc));
        if solid.info().outline == Some(Outline::Text) {
            let words = Value::Text(DEFAULT_TEXT.to_owned());
            let doc = "What it says; \\n begins another line.";
            self.push(control(key::TEXT, key::TEXT, doc, "", ControlKind::Text, words).required(), Place::Argument(0));
            let doc = "A .ttf or .otf file, relative to the scene file; the font that comes along when absent.";
            let none = Value::Text(String::new());
            self.push(control(FONT, FONT, doc, "", ControlKind::Picture, none), Place::Property(FONT));
        }
        let given = parameters(solid, self.node);
        for (param, (index, entry)) in solid.params().iter().zip(given.into_iter().enumerate()) {
            let control = parameter_control(param);
            let value = entry.and_then(|entry| read_parameter(param, entry));
            let present = match &value {
                Some(Value::Formulas(_)) => entry.and_then(|entry| number(entry, self.values)).map(Value::Number),
                plain => plain.clone(),
            };
            let present = present.unwrap_or_else(|| control.default.clone());
            let (given, value) = (value.is_some(), value.unwrap_or_else(|| control.default.clone()));
            self.slots
                .push(Slot { control: Control { value, present, given, ..control }, place: Place::Parameter(index) });
        }
        if let Solid::Operator(operator) = solid
            && operator.blends()
        {
            for setting in schema::BLEND {
                self.setting(setting.name, setting.name, setting, Place::Property(setting.name));
            }
        }
        let doc = match solid.is_operator() {
            false => "Material of this shape; that of what it stands in when absent.",
            true => "Material of its shapes that name no other; that of what it stands in when absent.",
        };
        self.material_of(file, doc);
        self.placement(solid.info().facing);
    }
}

/// Word, key and label of what stands behind `lens`.
const LENS_KEYS: &[(&str, &str, &str)] =
    &[("radius", "lens.radius", "lens radius"), ("focus", "lens.focus", "focus distance")];

/// The name of a setting for people, where it is not its word.
pub(super) fn label(word: &'static str) -> &'static str {
    match word {
        "at" => "position",
        "rotate" => "rotation",
        "fov" => "field of view",
        "tonemap" => "tone mapping",
        word => word,
    }
}

pub(super) fn control(
    key: &'static str,
    label: &'static str,
    doc: &'static str,
    unit: &'static str,
    kind: ControlKind,
    default: Value,
) -> Control {
    let initial = default.clone();
    let (label, doc, value, present) = (label.into(), doc.into(), default.clone(), default.clone());
    Control { key, label, doc, unit, kind, value, present, default, initial, given: false, required: false }
}

impl Control {
    fn required(self) -> Self {
        Self { required: true, ..self }
    }
}

/// The number of a parameter as the value of its control.
pub(super) fn parameter_value(param: &Param, value: f32) -> Value {
    match param.unit {
        Unit::Axis => Value::Text(AXES.get(value as usize).copied().unwrap_or_default().to_owned()),
        _ => Value::Number(value),
    }
}

/// A parameter of a shape or an operator.
pub(super) fn parameter_control(param: &Param) -> Control {
    if param.unit == Unit::Axis {
        let kind = ControlKind::Choice(AXES.map(Cow::Borrowed).to_vec());
        return control(
            interned(&param.name),
            interned(&param.name),
            interned(&param.doc),
            "",
            kind,
            parameter_value(param, param.default),
        );
    }
    let range = Range { min: param.min, min_allowed: param.min_allowed, max: param.max, max_allowed: true };
    let unit = if param.unit == Unit::Count { "" } else { param.unit.name() };
    let range = number_range(range, param.unit == Unit::Count, unit, Some(param.default));
    control(
        interned(&param.name),
        interned(&param.name),
        interned(&param.doc),
        unit,
        ControlKind::Number(range),
        Value::Number(param.default),
    )
}

/// A parameter of a kind of material.
pub(super) fn material_control(param: &'static MaterialParam) -> Control {
    let (kind, default) = match param.kind {
        ParamKind::Colour => (ControlKind::Colour { max: param.max }, Value::Colour(param.default)),
        ParamKind::Number => {
            let range = number_range(Range::from_to(param.min, param.max), false, "", Some(param.default[0]));
            (ControlKind::Number(range), Value::Number(param.default[0]))
        }
    };
    control(interned(param.name), interned(param.name), interned(param.doc), "", kind, default)
}

/// What the example in the table begins with.
fn example(setting: &Setting, kind: &ControlKind) -> Value {
    let numbers: Vec<f32> = setting.example.split([' ', '=']).skip(1).filter_map(|word| word.parse().ok()).collect();
    match (kind, &numbers[..]) {
        (ControlKind::Number(_), [number, ..]) => Value::Number(*number),
        (ControlKind::Colour { .. }, [r, g, b]) => Value::Colour([*r, *g, *b]),
        _ => Value::None,
    }
}

fn number_range(range: Range, whole: bool, unit: &str, default: Option<f32>) -> NumberRange {
    let Range { min, min_allowed, max, max_allowed } = range;
    let size = default.unwrap_or(1.0).abs();
    let endless = max - min > 1e4;
    let logarithmic = min >= 0.0 && endless;
    let low = match (logarithmic, min > f32::MIN) {
        _ if unit == "°" && min == f32::MIN => -360.0,
        (true, _) if min_allowed => min,
        (true, _) => (0.01 * size).max(0.001),
        (false, true) if min_allowed => min,
        (false, true) => min + 0.01 * (max - min),
        (false, false) => -10.0_f32.max(4.0 * size),
    };
    let high = match max < f32::MAX && !endless {
        _ if unit == "°" && max == f32::MAX => 360.0,
        true if max_allowed => max,
        true => max - 0.01 * (max - min),
        false if whole => (16.0 * size.max(1.0)).min(max),
        false => 10.0_f32.max(4.0 * size),
    };
    NumberRange { min, min_allowed, max, max_allowed, whole, soft: (low, high), logarithmic }
}

/// What stands at a place: nothing, something that cannot be read, or a value.
fn given(node: &Node<'static>, place: Place, kind: &ControlKind) -> Option<Option<Value>> {
    if let Place::Texture(owner) = place {
        return texture_node(node, owner).map(|node| Some(Value::Text(node.name.value.to_string())));
    }
    let entries = entries(node, place);
    (!entries.is_empty()).then(|| read(&entries, kind))
}

/// The arguments or the property at a place.
fn entries<'n>(node: &'n Node<'static>, place: Place) -> Vec<&'n Entry<'static>> {
    let all = |node: &'n Node<'static>| arguments(node).collect();
    match place {
        Place::Kind | Place::Parameter(_) => Vec::new(),
        Place::Name => arguments(node).take(1).collect(),
        Place::Argument(index) => arguments(node).skip(index).take(1).collect(),
        Place::Property(name) => property(node, name).into_iter().collect(),
        Place::Arguments => all(node),
        Place::Node(name) => child(node, name).map_or_else(Vec::new, all),
        Place::NodeProperty(name, word) => {
            child(node, name).and_then(|child| property(child, word)).into_iter().collect()
        }
        Place::Texture(_) => Vec::new(),
        Place::Inside(owner, inside) => match (target(node, owner, inside), inside) {
            (Some(node), Inside::Property(word)) => property(node, word).into_iter().collect(),
            (Some(node), Inside::Argument) => arguments(node).take(1).collect(),
            (node, _) => node.map_or_else(Vec::new, all),
        },
    }
}

/// Numbers as the value of a control.
fn plain(numbers: &[f32], kind: &ControlKind) -> Option<Value> {
    match (kind, numbers) {
        (ControlKind::Number(_), [number]) => Some(Value::Number(*number)),
        (ControlKind::Triple { .. }, [x, y, z]) => Some(Value::Triple([*x, *y, *z])),
        (ControlKind::Colour { .. }, [grey]) => Some(Value::Colour([*grey; 3])),
        (ControlKind::Colour { .. }, [r, g, b]) => Some(Value::Colour([*r, *g, *b])),
        (ControlKind::Size { .. }, [width, height]) => Some(Value::Size([*width as u32, *height as u32])),
        _ => None,
    }
}

fn read(entries: &[&Entry], kind: &ControlKind) -> Option<Value> {
    let numbers: Option<Vec<f32>> = entries.iter().map(|entry| read_number(entry)).collect();
    if let Some(value) = numbers.and_then(|numbers| plain(&numbers, kind)) {
        return Some(value);
    }
    let text = match entries.first().map(|entry| &entry.value) {
        Some(tree::Value::Text(text)) if entries.len() == 1 => Some(text.to_string()),
        _ => None,
    };
    match kind {
        ControlKind::Colour { .. } if text.as_ref().is_some_and(|text| text.starts_with('#')) => {
            text.and_then(|text| srgb(&text)).map(Value::Colour)
        }
        ControlKind::Number(_) | ControlKind::Triple { .. } | ControlKind::Colour { .. } | ControlKind::Size { .. } => {
            let texts: Vec<String> = entries.iter().map(|entry| formula_text(entry)).collect::<Option<_>>()?;
            // As many as there would be numbers.
            plain(&vec![0.0; texts.len()], kind).map(|_| Value::Formulas(texts))
        }
        ControlKind::Flag => match entries.first()?.value {
            tree::Value::Bool(value) => Some(Value::Flag(value)),
            _ => None,
        },
        ControlKind::Text | ControlKind::Picture | ControlKind::Choice(_) | ControlKind::Material(_) => {
            text.map(Value::Text)
        }
    }
}

/// A number or a formula as text.
pub(super) fn formula_text(entry: &Entry) -> Option<String> {
    match &entry.value {
        tree::Value::Number(_) => read_number(entry).map(super::number::number),
        tree::Value::Text(text) => Some(text.to_string()),
        _ => None,
    }
}

/// The finite number of an entry.
pub(super) fn read_number(entry: &Entry) -> Option<f32> {
    match entry.value {
        tree::Value::Number(number) => Some(number as f32).filter(|number| number.is_finite()),
        _ => None,
    }
}

/// The number of an entry, or what its formula is worth.
fn number(entry: &Entry, values: &Values) -> Option<f32> {
    match entry.value {
        tree::Value::Text(_) => values.formulas.get(&entry.value_span.start).map(|value| *value as f32),
        _ => read_number(entry),
    }
}

/// What an entry gives to a parameter.
fn read_parameter(param: &Param, entry: &Entry) -> Option<Value> {
    match (&entry.value, param.unit) {
        (tree::Value::Text(word), Unit::Axis) => {
            AXES.iter().any(|axis| axis == word).then(|| Value::Text(word.to_string()))
        }
        (_, Unit::Axis) => None,
        (tree::Value::Text(text), _) => Some(Value::Formulas(vec![text.to_string()])),
        _ => read_number(entry).map(Value::Number),
    }
}

/// Whether the first argument of a shape stands for several sizes.
pub(super) fn has_one_size(solid: Solid, node: &Node<'static>) -> bool {
    let sizes = solid.info().size_params;
    let named = solid.params()[..sizes].iter().any(|param| property(node, &param.name).is_some());
    sizes > 1 && !named && (1..sizes).contains(&arguments(node).count())
}

/// The arguments that are numbers of a shape or an operator: all, but for the words of a text.
pub(super) fn number_arguments<'n>(
    solid: Solid,
    node: &'n Node<'static>,
) -> impl Iterator<Item = &'n Entry<'static>> + use<'n> {
    let is_text = solid.info().outline == Some(Outline::Text);
    arguments(node).filter(move |_| !is_text)
}

/// What gives a shape or an operator its numbers, as far as something does.
pub(super) fn parameters<'n>(solid: Solid, node: &'n Node<'static>) -> Vec<Option<&'n Entry<'static>>> {
    let sizes = solid.info().size_params;
    let one_size = has_one_size(solid, node);
    let entry = |index: usize, param: &Param| {
        let slot = match one_size {
            true if index < sizes => 0,
            true => index + 1 - sizes,
            false => index,
        };
        number_arguments(solid, node).nth(slot).or_else(|| property(node, &param.name))
    };
    solid.params().iter().enumerate().map(|(index, param)| entry(index, param)).collect()
}

/// The values that a shape or an operator is given.
pub(super) fn parameter_values(solid: Solid, node: &Node<'static>) -> Vec<Option<Value>> {
    let given = parameters(solid, node).into_iter().zip(solid.params());
    given.map(|(entry, param)| entry.and_then(|entry| read_parameter(param, entry))).collect()
}
