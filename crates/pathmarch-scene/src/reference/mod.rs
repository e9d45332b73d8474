//! Reference of every word of the scene language, from the tables that its reader uses.
//!
//! A word may mean several things: `point` is a light and a corner of a polygon. The reference also knows words of other
//! programs that the language does not have.

mod page;

use crate::language::diagnostics::missing_words;
use crate::language::keywords::{MATERIAL, TOP};
use crate::materials::{self, MaterialParam};
use crate::settings::{self, Setting};
use crate::textures;
pub use page::page;
use pathmarch_field::{Param, Solid, registry};

/// One meaning of a word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// What it belongs to: a node, the kind of a material, or one of [`TOP_OF_FILE`], [`IN_OBJECTS`], [`PLACEMENTS`],
    /// [`MATERIAL_KINDS`] and [`TEXTURES`]. Empty for a word that the language does not have.
    pub owner: &'static str,
    /// Word with its place, as in "`roughness` of `metal`".
    pub title: String,
    /// One sentence.
    pub doc: String,
    /// Parameters and settings, one a line.
    pub details: Vec<String>,
}

impl Entry {
    /// The same in Markdown.
    pub fn markdown(&self) -> String {
        let details: String = self.details.iter().map(|line| format!("\n- {}", detail(line))).collect();
        let gap = if details.is_empty() { "" } else { "\n" };
        format!("**{}**\n\n{}{gap}{details}", self.title, self.doc)
    }
}

/// A line of details, of which the first word is a name if two spaces follow it.
fn detail(line: &str) -> String {
    match line.split_once("  ") {
        Some((name, rest)) if !name.contains(' ') => format!("`{name}` {rest}"),
        _ => line.to_owned(),
    }
}

/// Owner of the nodes at the top of a file.
pub const TOP_OF_FILE: &str = "scene";
/// Owner of shapes, operators and modifiers.
pub const IN_OBJECTS: &str = "object";
/// Owner of `at`, `rotate` and `scale`.
pub const PLACEMENTS: &str = "shapes and operators";
/// Owner of the kinds of material.
pub const MATERIAL_KINDS: &str = "material";
/// Owner of the textures.
pub const TEXTURES: &str = "texture";

/// Tables of settings, with the node that contains them.
const TABLES: [(&str, &[Setting]); 10] = [
    ("camera", settings::CAMERA),
    ("render", settings::RENDER),
    ("fog", settings::FOG),
    ("sun", settings::SUN),
    ("point", settings::POINT),
    ("spot", settings::SPOT),
    ("sky \"gradient\"", settings::GRADIENT),
    ("sky \"day\"", settings::DAY),
    ("sky \"day\"", settings::DAY_GROUND),
    (PLACEMENTS, settings::PLACEMENT),
];

/// Tables of settings that are properties, with their node.
const PROPERTIES: [(&str, &[Setting]); 10] = [
    ("lens", settings::LENS),
    ("sky \"day\"", settings::DAY),
    ("sky", settings::PICTURE),
    ("mesh", settings::MESH),
    ("decal", settings::DECAL),
    ("object", settings::VISIBILITY),
    ("object", settings::EMITTER),
    ("sun", settings::VISIBILITY),
    ("point", settings::VISIBILITY),
    ("spot", settings::VISIBILITY),
];

/// Nodes that no table has, with their owner and help.
const OTHER_NODES: [(&str, &str, &str); 13] = [
    (MATERIAL_KINDS, "bump", "Texture of heights that turns the normals of a surface."),
    (MATERIAL_KINDS, "orbit-trap", "Colours of a fractal by the orbits of its points."),
    (MATERIAL_KINDS, "decal", "Picture that is projected once, over the colour of a material: a label, a logo."),
    (TEXTURES, "picture", "Picture of a .png or .jpg file."),
    (TEXTURES, "colour", "Colour of a ramp, from the lowest value to the highest."),
    (IN_OBJECTS, "mesh", "Triangles of a mesh file, or their distance field."),
    ("polygon", "point", "Corner of a polygon: `point x y`."),
    ("curve", "point", "Point of a curve: `point x y`."),
    ("field", "lipschitz", "Largest length of the gradient; 1 for an exact distance."),
    ("field", "bounds", "Edges of a box around the origin that cuts the solid, or \"none\"."),
    ("field", "wgsl", "Code in WGSL, with `fn distance(p: vec3f) -> f32`."),
    ("field", "glsl", "Code in GLSL, with `float map(vec3 p)` or `float DE(vec3 p)`."),
    ("field", "doc", "Help: one sentence."),
];

/// Properties that no table has, with their owner and help.
const OTHER_PROPERTIES: [(&str, &str, &str); 17] = [
    ("param", "min", "Smallest value that it may have."),
    ("param", "max", "Largest value that it may have."),
    ("param", "doc", "Help: one sentence."),
    ("glsl", "entry", "Name of the distance function."),
    ("point", "corner", "Of a curve: makes a corner there."),
    ("text", "font", "Path of a .ttf, .otf or .ttc file, relative to the scene file."),
    ("colour", "at", "Value that has this colour, from 0 to 1; colours without it are evenly spaced."),
    ("picture", "size", "Width of the picture, metres. Default 1."),
    ("bump", "height", "Height of the texture's largest value, metres."),
    ("picture", "uv", "Texture coordinates of the mesh instead of a projection."),
    ("orbit-trap", "x", "Centre of the trap."),
    ("orbit-trap", "y", "Centre of the trap."),
    ("orbit-trap", "z", "Centre of the trap."),
    ("orbit-trap", "from", "Value of the first colour."),
    ("orbit-trap", "to", "Value of the last colour."),
    (TEXTURES, "from", "Value of the parameter where the texture is 0."),
    (TEXTURES, "to", "Value of the parameter where the texture is 1."),
];

/// Meanings of nodes at the top of a file.
const NODES: [(&str, &str); 15] = [
    ("pathmarch", "Version of the scene language; the first node of a file."),
    ("include", "File from which this one takes materials, shapes, objects and lights."),
    ("unit", "Unit of lengths for reports and exports: \"m\", \"cm\", \"mm\" or \"in\"."),
    ("param", "Number with a name, which formulas use."),
    ("camera", "Camera; the first one of a file is the default."),
    ("render", "Size and quality of the picture."),
    ("sky", "Radiance of the surroundings: one colour, a gradient, a day or a picture."),
    ("fog", "Medium between the objects, which scatters, absorbs and emits light."),
    ("sun", "Light from far away."),
    ("point", "Light from a point, the same in every direction."),
    ("spot", "Light from a point, in a cone."),
    ("material", "Material with a name, which objects and shapes use by `material=`."),
    ("field", "Distance function in WGSL, which is then a shape."),
    ("shape", "Shape made of others, with parameters of its own."),
    ("object", "Object: its shapes and their material."),
];

/// All meanings of a word, and advice for a word that the language does not have. Empty for an unknown word.
pub fn entries(word: &str) -> Vec<Entry> {
    let mut found: Vec<Entry> = nodes(word).chain(solids(word)).chain(materials(word)).collect();
    found.extend(textures::kind(word).map(|kind| Entry {
        owner: TEXTURES,
        title: format!("texture `{word}`"),
        doc: kind.doc.to_owned(),
        details: parameters(kind.params),
    }));
    found.extend(OTHER_NODES.iter().filter(|(_, name, _)| *name == word).map(|(owner, name, doc)| Entry {
        owner,
        title: format!("`{name}` of {owner}"),
        doc: (*doc).to_owned(),
        details: properties(name),
    }));
    found.extend(settings_named(word, PLACEMENTS, std::slice::from_ref(&settings::NORMAL)));
    found.extend(TABLES.iter().flat_map(|(owner, table)| settings_named(word, owner, table)));
    let of_properties = PROPERTIES.iter().filter(|(owner, _)| TABLES.iter().all(|(table, _)| table != owner));
    found.extend(of_properties.flat_map(|(owner, table)| settings_named(word, owner, table)));
    if found.is_empty() {
        found.extend(missing_words::advice(word).map(|advice| Entry {
            owner: "",
            title: format!("`{word}` (not a word of the language)"),
            doc: advice.to_owned(),
            details: Vec::new(),
        }));
    }
    found
}

/// Properties of a node that belongs to no table of settings, one a line.
fn properties(node: &str) -> Vec<String> {
    let of_tables =
        PROPERTIES.iter().filter(|(owner, _)| *owner == node).flat_map(|(_, table)| table.iter()).map(in_line);
    let others = OTHER_PROPERTIES.iter().filter(|(owner, ..)| *owner == node);
    of_tables.chain(others.map(|(_, word, doc)| format!("{word}  {doc}"))).collect()
}

/// Every word of the language that [`entries`] knows, in alphabetical order.
pub fn words() -> Vec<String> {
    let kinds = materials::kinds().iter();
    let mut words: Vec<String> = TOP.iter().map(|word| (*word).to_owned()).collect();
    words.extend(registry::solids().map(|solid| solid.info().name.to_string()));
    words.extend(kinds.clone().map(|kind| kind.name.to_owned()));
    words.extend(kinds.flat_map(|kind| kind.params.iter().skip(1)).map(|param| param.name().to_owned()));
    words.extend(textures::kinds().iter().map(|kind| kind.name.to_owned()));
    words.extend(OTHER_NODES.iter().map(|(_, name, _)| (*name).to_owned()).chain([settings::NORMAL.name.to_owned()]));
    words.extend(TABLES.iter().flat_map(|(_, table)| table.iter()).map(|setting| setting.name.to_owned()));
    words.sort();
    words.dedup();
    words
}

/// The meanings of a word that belong to one of these owners; all meanings if none does.
pub fn entries_of(word: &str, owners: &[&str]) -> Vec<Entry> {
    let all = entries(word);
    let ours: Vec<Entry> = all.iter().filter(|entry| owners.contains(&entry.owner)).cloned().collect();
    if ours.is_empty() { all } else { ours }
}

/// Meaning of a property of a node. `owners` are names of the node, the most special first, as in `sky "day"` and `sky`.
pub fn property(word: &str, owners: &[&str]) -> Option<Entry> {
    let of_solid = |owner: &&str| solid_property(registry::solid(owner)?, word);
    let of_texture = |owner: &&str| {
        let param = textures::kind(owner)?.params.iter().find(|param| param.name == word)?;
        Some(parameter_entry(TEXTURES, param))
    };
    let found = owners.iter().find_map(|owner| of_solid(owner).or_else(|| of_texture(owner)));
    let in_tables = || {
        let owned = |(owner, _): &&(&'static str, &'static [Setting])| owners.contains(owner);
        PROPERTIES.iter().filter(owned).find_map(|(owner, table)| settings_named(word, owner, table))
    };
    let others = || {
        let mut others = OTHER_PROPERTIES.iter();
        let (owner, word, doc) = others.find(|(owner, other, _)| owners.contains(owner) && *other == word)?;
        Some(Entry { owner, title: format!("`{word}` of {owner}"), doc: (*doc).to_owned(), details: Vec::new() })
    };
    found.or_else(in_tables).or_else(others).or_else(|| (word == MATERIAL).then(material_property))
}

/// Property of a shape, an operator or a modifier.
fn solid_property(solid: Solid, word: &str) -> Option<Entry> {
    let blends = matches!(solid, Solid::Operator(operator) if operator.blends());
    let blend = || settings::BLEND.iter().find(|setting| blends && setting.name == word);
    let param = solid.params().iter().find(|param| param.name == word);
    let entry = param.map(|param| parameter_entry(IN_OBJECTS, param));
    entry.or_else(|| blend().and_then(|_| settings_named(word, "operators that blend", settings::BLEND)))
}

/// Meaning of a parameter.
pub(crate) fn parameter_entry(owner: &'static str, param: &Param) -> Entry {
    let title = format!("`{}`", param.name);
    Entry { owner, title, doc: param.doc.to_string(), details: vec![parameter_values(param)] }
}

/// As in "Default 1, m; above 0."
fn parameter_values(param: &Param) -> String {
    let unit = match param.unit.name() {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    format!("Default {}{unit}; {}.", param.default_in_words(), param.range_in_words())
}

fn material_property() -> Entry {
    let doc = "Material of the shapes in it that have none of their own.".to_owned();
    Entry { owner: IN_OBJECTS, title: format!("`{MATERIAL}`"), doc, details: Vec::new() }
}

/// The word of the language that is spelt most like this one.
pub fn nearest(word: &str) -> Option<String> {
    let words = words();
    crate::language::diagnostics::spelling::nearest(word, words.iter().map(String::as_str)).map(str::to_owned)
}

fn nodes(word: &str) -> impl Iterator<Item = Entry> {
    let found = NODES.iter().filter(move |(name, _)| *name == word);
    found.map(|(name, doc)| {
        let tables = TABLES.iter().filter(|(owner, _)| owner == name);
        let details = tables.flat_map(|(_, table)| table.iter()).map(in_line).chain(properties(name)).collect();
        Entry { owner: TOP_OF_FILE, title: format!("node `{name}`"), doc: (*doc).to_owned(), details }
    })
}

fn solids(word: &str) -> impl Iterator<Item = Entry> {
    registry::solid(word).into_iter().map(|solid| {
        let kind = match solid {
            Solid::Shape(shape) if shape.info().profile => "profile",
            Solid::Shape(_) => "shape",
            Solid::Operator(_) => "operator",
            Solid::Modifier(_) => "modifier",
        };
        let info = solid.info();
        let details = parameters(solid.params());
        Entry { owner: IN_OBJECTS, title: format!("{kind} `{}`", info.name), doc: info.doc.to_string(), details }
    })
}

/// A kind of material, and the parameters of this name of other kinds.
fn materials(word: &str) -> impl Iterator<Item = Entry> {
    let kinds = materials::kinds().iter();
    let itself = kinds.clone().filter(move |kind| kind.name == word).map(|kind| {
        let details = kind.params.iter().map(material_parameter).collect();
        let title = format!("material `{}`", kind.name);
        Entry { owner: MATERIAL_KINDS, title, doc: kind.doc.to_owned(), details }
    });
    let parameters = kinds.flat_map(move |kind| {
        let same = kind.params.iter().skip(1).filter(move |param| param.name() == word);
        same.map(|param| Entry {
            owner: kind.name,
            title: format!("`{}` of material `{}`", param.name(), kind.name),
            doc: param.spec.doc.to_string(),
            details: vec![material_parameter(param)],
        })
    });
    itself.chain(parameters)
}

fn settings_named(word: &str, owner: &'static str, table: &'static [Setting]) -> Option<Entry> {
    let setting = table.iter().find(|setting| setting.name == word)?;
    Some(Entry {
        owner,
        title: format!("`{word}` of {owner}"),
        doc: setting.doc.to_owned(),
        details: vec![format!("For example: {}. Range: {}.", setting.example, setting.kind.range_in_words())],
    })
}

fn in_line(setting: &Setting) -> String {
    format!("{}  {}", setting.name, setting.doc)
}

fn parameters(params: &[Param]) -> Vec<String> {
    params.iter().map(|param| format!("{}  {} {}", param.name, param.doc, parameter_values(param))).collect()
}

fn material_parameter(param: &MaterialParam) -> String {
    let kind = param.kind.name();
    let Param { name, doc, .. } = &param.spec;
    format!("{name}  {doc} A {kind}; default {}; {}.", param.default_in_words(), param.range_in_words())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_has_an_entry_with_a_sentence() {
        let words = words();
        assert!(words.len() > 100, "{}", words.len());
        for word in &words {
            let entries = entries(word);
            assert!(!entries.is_empty(), "{word}");
            assert!(entries.iter().all(|entry| !entry.doc.is_empty()), "{entries:?}");
        }
        assert!(TOP.iter().all(|word| NODES.iter().any(|(name, _)| name == word)));
    }

    #[test]
    fn a_word_may_mean_several_things_or_be_missing() {
        let roughness: Vec<String> = entries("roughness").into_iter().map(|entry| entry.title).collect();
        assert!(
            roughness.len() > 1 && roughness.contains(&"`roughness` of material `metal`".to_owned()),
            "{roughness:?}"
        );
        assert!(entries("hair")[0].doc.starts_with("Not supported yet"));
        assert_eq!(entries("wood")[0].title, "texture `wood`");
        assert_eq!(entries("principled")[0].title, "material `principled`");
        assert!(entries("qqq").is_empty());
        assert_eq!(nearest("shpere").as_deref(), Some("sphere"));
    }
}
