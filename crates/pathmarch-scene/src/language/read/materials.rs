//! Materials.
//!
//! The parameters of a material come from [`crate::materials`]: the node that names its kind carries the first, nodes
//! beside it carry the others.

use super::arguments::{arguments, exactly, flag, missing_arguments, name, properties, string, twice};
use super::colours::colour;
use super::context::{Context, Files};
use super::decals::decals;
use super::numbers::{accepted, in_range, numbers};
use super::settings::NodesByName;
use super::textures::{self, Use};
use super::unexpected::{unexpected_node, with_article};
use crate::language::diagnostics::report::{draft, shown};
use crate::language::diagnostics::spelling::{listed, suggestion};
use crate::language::keywords::{BUMP, COLOUR, DECAL, ORBIT_TRAP, TRAP_NUMBERS};
use crate::language::tree::{Entry, Node, Span, Value};
use crate::materials::{
    self, Bump, IOR, Material, MaterialParam, OrbitTrap, PRIORITY, ParamKind, TextureMapping, TexturedParameter,
    Texturing, Trap,
};
use crate::settings::Range;
use std::collections::HashMap;

/// The materials of a file and where each name was given.
#[derive(Default)]
pub(crate) struct Materials {
    pub(crate) list: Vec<Material>,
    pub(crate) index: HashMap<String, u32>,
    spans: Vec<Span>,
}

impl Materials {
    /// Adds the material of `node`, with defaults in place of mistakes, so that its users find it.
    pub(crate) fn add(&mut self, node: &Node, files: &mut Files, context: &mut Context) {
        let usage = "`material \"name\" { … }`";
        properties(node, &[], context);
        if !node.entries.iter().any(|entry| entry.name.is_none()) {
            missing_arguments(node, usage, context);
        }
        let given = name(node, usage, context);
        let described = describe(node, files, context);
        let Some((name, span)) = given else { return };
        if let Some(&first) = self.index.get(name) {
            twice(&format!("The material {}", shown(name)), span, self.spans[first as usize], context);
            return;
        }
        let material = described.unwrap_or_else(Material::default_white);
        self.index.insert(name.to_owned(), self.list.len() as u32);
        self.spans.push(span);
        self.list.push(Material { name: name.to_owned(), ..material });
    }
}

/// The material of a node, without its name.
fn describe(node: &Node, files: &mut Files, context: &mut Context) -> Option<Material> {
    let children = node.child_nodes();
    let mut kinds = children.iter().filter_map(|child| Some((child, materials::kind(&child.name.value)?)));
    let Some((kind_node, kind)) = kinds.next() else {
        let names: Vec<&str> = materials::kinds().iter().map(|kind| kind.name).collect();
        for child in children {
            unexpected_node(&child.name, &names, "in a material", context);
        }
        if children.is_empty() && !node.broken() {
            let mistake = draft("pathmarch::missing_node", node.name.span, "This material has no kind.");
            let label = format!("expected {} in its braces", listed(names, "or"));
            context.report.add(mistake.label(label).help("For example: material \"white\" { diffuse 0.8 }."));
        }
        return None;
    };
    if let Some((second, _)) =
        kinds.find(|(second, other)| other.name != kind.name && !std::ptr::eq(*second, kind_node))
    {
        let message = "A material is of one kind.";
        let mistake = draft("pathmarch::duplicate", second.name.span, message).label("a second kind");
        context.report.add(mistake.also(kind_node.name.span, "the first"));
    }
    let beside = kind.params.get(1..).unwrap_or_default().iter().map(|param| param.name());
    let mut known: Vec<&str> = std::iter::once(kind.name).chain(beside).collect();
    known.extend(materials::kinds().iter().map(|kind| kind.name).filter(|name| *name != kind.name));
    if kind.is_shaded() {
        known.extend([ORBIT_TRAP, DECAL, BUMP]);
    }
    let others = foreign_parameters(node, kind, context);
    known.extend(others.iter().copied());
    let repeated: &[&str] = if kind.is_shaded() { &[DECAL] } else { &[] };
    let place = format!("in a `{}` material", kind.name);
    let settings = NodesByName::with_repeated(node, &known, repeated, &place, context);
    let mut material = Material::new("", kind);
    for (index, param) in kind.params.iter().enumerate() {
        let Some(node) = settings.get(if index == 0 { kind.name } else { param.name() }) else { continue };
        let is_textured = !node.child_nodes().is_empty() || node.children.is_some() && node.entries.is_empty();
        let has_value = param.texturing == Texturing::None && node.child_nodes().is_empty();
        if !is_textured || has_value {
            material.values[index] = value(node, param, context).unwrap_or(param.default_value());
        } else if param.texturing == Texturing::None {
            textures::refuse(node, context);
        } else if let Some(painted) = painted(node, index, param, files, context) {
            material.values[index] = painted.average();
            material.textured.push(painted);
        }
    }
    if kind.params.is_empty() {
        arguments(kind_node, 0, format_args!("`{}`", kind.name), context);
    }
    warn_without_effect(&material, &settings, context);
    material.orbit_trap = settings.get(ORBIT_TRAP).and_then(|node| orbit_trap(node, context));
    if kind.is_shaded() {
        material.decals = decals(node, files, context);
    }
    material.bump = settings.get(BUMP).and_then(|node| {
        properties(node, &[], context);
        arguments(node, 0, "`bump { fbm size=0.05 height=0.005 }`", context);
        match textures::texture(node, Use::Height, files, context)? {
            (texture, TextureMapping::Range([_, height])) => Some(Bump { texture, height }),
            _ => None,
        }
    });
    Some(material)
}

/// Warns of parameters of glass that have no effect beside the others.
fn warn_without_effect(material: &Material, settings: &NodesByName, context: &mut Context) {
    let is_set = |name: &str| {
        let index = material.kind.params.iter().position(|param| param.name() == name);
        let node = settings.get(name).filter(|node| !node.broken());
        let is_textured = material.textured.iter().any(|textured| Some(textured.param) == index);
        node.filter(|_| is_textured || material.value(name).is_some_and(|value| value != [0.0; 3]))
    };
    if !material.dielectric().is_thin {
        if let Some(node) = is_set(PRIORITY).filter(|_| !material.transmits()) {
            let message = "This material transmits no light: its `priority` has no effect.";
            let warning = draft("pathmarch::no_effect", node.name.span, message).label("no effect");
            let help =
                "Only solids that light enters fill the space in order: `glass`, and `principled` with `transmission`.";
            context.report.warn(warning.help(help));
        }
        return;
    }
    const SOLID: &str = "For a frosted or thick pane use a solid, such as a `box`, without `thin`.";
    const TINT: &str = "Tint thin glass by its colour: `glass 0.8 0.9 1`.";
    const STRAIGHT: &str = "Light passes a sheet straight, in all colours.";
    for (name, help) in [
        ("roughness", SOLID),
        ("multiscatter", SOLID),
        ("abbe", STRAIGHT),
        ("absorb", TINT),
        ("scatter", SOLID),
        ("anisotropy", SOLID),
        ("glow", SOLID),
        (PRIORITY, "A sheet fills no space."),
    ] {
        let Some(node) = is_set(name) else { continue };
        let message = format!("`{name}` has no effect on thin glass, which is smooth and has no inside.");
        let warning = draft("pathmarch::no_effect", node.name.span, message).label("no effect");
        context.report.warn(warning.help(help));
    }
}

/// Reports the parameters of other kinds of material, with what this kind has. Returns their names.
fn foreign_parameters<'n>(node: &'n Node, kind: &materials::MaterialKind, context: &mut Context) -> Vec<&'n str> {
    let has = |kind: &materials::MaterialKind, name: &str| kind.params.iter().skip(1).any(|param| param.name() == name);
    let mut found: Vec<&str> = Vec::new();
    for child in node.child_nodes() {
        let name = &*child.name.value;
        let owners = materials::kinds().iter().filter(|other| has(other, name)).map(|other| other.name);
        let of_surfaces = [ORBIT_TRAP, DECAL, BUMP].contains(&name) && !kind.is_shaded();
        let shaded = materials::kinds().iter().filter(|other| of_surfaces && other.is_shaded());
        let owners: Vec<&str> = owners.chain(shaded.map(|other| other.name)).collect();
        if owners.is_empty() || has(kind, name) || materials::kind(name).is_some() {
            continue;
        }
        found.push(name);
        let message = with_article(&format!("in a `{}` material", kind.name));
        let message = format!("{} has no `{name}`.", message.trim_start_matches("in ").replacen('a', "A", 1));
        let own = kind
            .params
            .iter()
            .skip(1)
            .map(MaterialParam::name)
            .chain([BUMP, DECAL].into_iter().filter(|_| kind.is_shaded()));
        let own = match own.clone().count() {
            0 => format!("`{}` has no parameters beside its value.", kind.name),
            _ => format!("It has {}.", listed(own, "and")),
        };
        let help = format!("{own} `{name}` is a parameter of {}.", listed(owners, "and"));
        let mistake = draft("pathmarch::unknown_node", child.name.span, message).label("unknown parameter");
        context.report.add(mistake.help(help));
    }
    found
}

/// The texture in the braces of a parameter's node.
fn painted(
    node: &Node,
    index: usize,
    param: &MaterialParam,
    files: &mut Files,
    context: &mut Context,
) -> Option<TexturedParameter> {
    properties(node, &[], context);
    if let Some(entry) = node.entries.iter().find(|entry| entry.name.is_none()) {
        let message = format!("`{}` has a value and a texture.", node.name.value);
        let mistake = draft("pathmarch::unexpected_argument", entry.span, message).label("unused");
        context.report.add(mistake.help("The texture replaces the value. Delete one of them."));
    }
    let to = match param.kind {
        ParamKind::Colour => Use::Colour,
        ParamKind::Number | ParamKind::Flag => Use::Number(param.spec.range),
    };
    let (texture, mapping) = textures::texture(node, to, files, context)?;
    Some(TexturedParameter { param: index, texture, mapping })
}

/// `orbit-trap "point" x=0 y=0 z=0 from=0 to=1 { colour …; colour … }`.
fn orbit_trap(node: &Node, context: &mut Context) -> Option<OrbitTrap> {
    let usage = "`orbit-trap \"point\" from=0 to=1 { colour 0; colour 1 }`";
    let entries = arguments(node, 1, usage, context);
    let mut numbers = TRAP_NUMBERS.map(|(_, default)| Some(default));
    for (word, entry) in properties(node, &TRAP_NUMBERS.map(|(word, _)| word), context) {
        if let Some(index) = TRAP_NUMBERS.iter().position(|(name, _)| *name == word) {
            numbers[index] = in_range(entry, format_args!("`{word}`"), Range::ANY, context);
        }
    }
    for child in node.child_nodes().iter().filter(|child| child.name.value != COLOUR) {
        unexpected_node(&child.name, &[COLOUR], "in an `orbit-trap`", context);
    }
    let ramp = textures::ramp(node, context);
    let trap = match entries.first() {
        Some(entry) => {
            let word = string(entry, "the trap", context)?;
            let trap = Trap::ALL.into_iter().find(|trap| trap.name() == word);
            if trap.is_none() {
                let names: Vec<&str> = Trap::ALL.map(Trap::name).to_vec();
                let message = format!("There is no orbit trap {}.", shown(word));
                let mistake = draft("pathmarch::unknown_trap", entry.value_span, message).label("unknown trap");
                context.report.add(mistake.help(suggestion(word, &names)).expected(names));
            }
            trap?
        }
        None => Trap::Point,
    };
    let [x, y, z, from, to] = numbers;
    let (centre, range) = ([x?, y?, z?], [from?, to?]);
    let ramp = ramp?.unwrap_or_else(textures::default_ramp);
    Some(OrbitTrap { trap, centre, range, ramp })
}

/// The value that a node gives a parameter; the default without arguments.
fn value(node: &Node, param: &MaterialParam, context: &mut Context) -> Option<[f32; 3]> {
    if node.entries.is_empty() && node.children.is_none() && param.kind != ParamKind::Flag {
        return None;
    }
    let range = param.spec.range;
    match param.kind {
        ParamKind::Colour => colour(node, range, context),
        ParamKind::Number => {
            let usage = format_args!("`{} {}`", node.name.value, param.spec.default);
            let is_bubble =
                |entry: &Entry| matches!(entry.value, Value::Number(number) if number > 0.0 && number < 1.0);
            let value: Option<[f32; 1]> = match param.spec.is_whole() {
                // People look for bubbles here: their index is below that of the water around them.
                _ if param.name() == IOR && node.entries.iter().any(is_bubble) => {
                    let words =
                        || format!("{}; a bubble has 1, and a `priority` above its surroundings", range.in_words());
                    exactly(node, usage, context, |entry, what, context| {
                        accepted(entry, what, |number| range.accepts(number), words, context)
                    })
                }
                true => exactly(node, usage, context, |entry, what, context| {
                    let accepts = |number| param.spec.accepts(number);
                    accepted(entry, what, accepts, || param.spec.range_in_words(), context)
                }),
                false => numbers(node, usage, range, context),
            };
            value.map(|[value]| [value, 0.0, 0.0])
        }
        ParamKind::Flag => {
            let usage = format_args!("`{} #true`", node.name.value);
            let value: Option<[bool; 1]> =
                exactly(node, usage, context, |entry, what, context| flag(entry, what, context));
            value.map(|[value]| [f32::from(u8::from(value)), 0.0, 0.0])
        }
    }
}
