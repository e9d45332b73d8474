//! Reference of every word of the scene language, from the tables that its reader uses.
//!
//! A word may mean several things: `point` is a light and a corner of a polygon. The reference also knows words of other
//! programs that the language does not have.

use crate::language::diagnostics::missing_words;
use crate::language::keywords::TOP;
use crate::materials::{self, MaterialParam, ParamKind};
use crate::settings::{self, Setting};
use crate::textures;
use pathmarch_field::{Param, Solid, registry};

/// One meaning of a word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Word with its place, as in "`roughness` of `metal`".
    pub title: String,
    /// One sentence.
    pub doc: String,
    /// Parameters and settings, one a line.
    pub details: Vec<String>,
}

/// Tables of settings, with the node that contains them.
const TABLES: [(&str, &[Setting]); 8] = [
    ("camera", settings::CAMERA),
    ("render", settings::RENDER),
    ("sun", settings::SUN),
    ("point", settings::POINT),
    ("sky \"gradient\"", settings::GRADIENT),
    ("sky \"day\"", settings::DAY),
    ("sky \"day\"", settings::DAY_GROUND),
    ("shapes and operators", settings::PLACEMENT),
];

/// Meanings of nodes at the top of a file.
const NODES: [(&str, &str); 12] = [
    ("pathmarch", "Version of the scene language; the first node of a file."),
    ("include", "File from which this one takes materials, shapes, objects and lights."),
    ("param", "Number with a name, which formulas use."),
    ("camera", "Camera; the first one of a file is the default."),
    ("render", "Size and quality of the picture."),
    ("sky", "Radiance of the surroundings: one colour, a gradient, a day or a picture."),
    ("sun", "Light from far away."),
    ("point", "Light from a point, the same in every direction."),
    ("material", "Material with a name, which objects and shapes use by `material=`."),
    ("field", "Distance function in WGSL, which is then a shape."),
    ("shape", "Shape made of others, with parameters of its own."),
    ("object", "Object: its shapes and their material."),
];

/// All meanings of a word, and advice for a word that the language does not have. Empty for an unknown word.
pub fn entries(word: &str) -> Vec<Entry> {
    let mut found: Vec<Entry> = nodes(word).chain(solids(word)).chain(materials(word)).collect();
    found.extend(textures::kind(word).map(|kind| Entry {
        title: format!("texture `{word}`"),
        doc: kind.doc.to_owned(),
        details: parameters(kind.params),
    }));
    found.extend(TABLES.iter().flat_map(|(owner, table)| settings_named(word, owner, table)));
    if found.is_empty() {
        found.extend(missing_words::advice(word).map(|advice| Entry {
            title: format!("`{word}` (not a word of the language)"),
            doc: advice.to_owned(),
            details: Vec::new(),
        }));
    }
    found
}

/// Every word of the language that [`entries`] knows, in alphabetical order.
pub fn words() -> Vec<String> {
    let kinds = materials::kinds().iter();
    let mut words: Vec<String> = TOP.iter().map(|word| (*word).to_owned()).collect();
    words.extend(registry::solids().map(|solid| solid.info().name.to_string()));
    words.extend(kinds.clone().map(|kind| kind.name.to_owned()));
    words.extend(kinds.flat_map(|kind| kind.params.iter().skip(1)).map(|param| param.name().to_owned()));
    words.extend(textures::kinds().iter().map(|kind| kind.name.to_owned()));
    words.extend(TABLES.iter().flat_map(|(_, table)| table.iter()).map(|setting| setting.name.to_owned()));
    words.sort();
    words.dedup();
    words
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
        let details = tables.flat_map(|(_, table)| table.iter()).map(in_line).collect();
        Entry { title: format!("node `{name}`"), doc: (*doc).to_owned(), details }
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
        Entry { title: format!("{kind} `{}`", info.name), doc: info.doc.to_string(), details }
    })
}

/// A kind of material, and the parameters of this name of other kinds.
fn materials(word: &str) -> impl Iterator<Item = Entry> {
    let kinds = materials::kinds().iter();
    let itself = kinds.clone().filter(move |kind| kind.name == word).map(|kind| {
        let details = kind.params.iter().map(material_parameter).collect();
        Entry { title: format!("material `{}`", kind.name), doc: kind.doc.to_owned(), details }
    });
    let parameters = kinds.flat_map(move |kind| {
        let same = kind.params.iter().skip(1).filter(move |param| param.name() == word);
        same.map(|param| Entry {
            title: format!("`{}` of material `{}`", param.name(), kind.name),
            doc: param.spec.doc.to_string(),
            details: vec![material_parameter(param)],
        })
    });
    itself.chain(parameters)
}

fn settings_named(word: &str, owner: &str, table: &'static [Setting]) -> Option<Entry> {
    let setting = table.iter().find(|setting| setting.name == word)?;
    Some(Entry {
        title: format!("`{word}` of {owner}"),
        doc: setting.doc.to_owned(),
        details: vec![format!("For example: {}. Range: {}.", setting.example, setting.kind.range_in_words())],
    })
}

fn in_line(setting: &Setting) -> String {
    format!("{}  {}", setting.name, setting.doc)
}

fn parameters(params: &[Param]) -> Vec<String> {
    let unit = |param: &Param| match param.unit.name() {
        "" => String::new(),
        unit => format!(", {unit}"),
    };
    let line = |param: &Param| {
        let (default, range) = (param.default_in_words(), param.range_in_words());
        format!("{}  {} Default {default}{}; {range}.", param.name, param.doc, unit(param))
    };
    params.iter().map(line).collect()
}

fn material_parameter(param: &MaterialParam) -> String {
    let kind = if param.kind == ParamKind::Colour { "colour" } else { "number" };
    let Param { name, doc, .. } = &param.spec;
    format!("{name}  {doc} A {kind}; default {}; {}.", param.spec.default_in_words(), param.spec.range_in_words())
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
        assert!(entries("fog")[0].doc.starts_with("Not supported yet"));
        assert_eq!(entries("wood")[0].title, "texture `wood`");
        assert_eq!(entries("principled")[0].title, "material `principled`");
        assert!(entries("qqq").is_empty());
        assert_eq!(nearest("shpere").as_deref(), Some("sphere"));
    }
}
