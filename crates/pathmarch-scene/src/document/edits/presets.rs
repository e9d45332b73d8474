//! Presets of materials: texts for the braces of a material.

use super::additions::add_top;
use super::naming::{free_name, title};
use super::transaction::Transaction;
use crate::document::control::Value;
use crate::document::error::EditError;
use crate::document::key;
use crate::document::text::layout::bytes;
use crate::document::text::literals::quoted;
use crate::document::text::patch::Patch;
use crate::document::tree::nodes::text_argument;
use crate::document::tree::outline::ItemKind;
use crate::document::tree::path::Path;
use crate::language::diagnostics::spelling::listed;
use crate::language::keywords::MATERIAL;
use crate::language::tree::{Block, Node};

/// A material to start from.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name for people.
    pub name: &'static str,
    /// Text in the braces of the material.
    text: &'static str,
}

impl Preset {
    /// Text in the braces of a material.
    pub const fn text(&self) -> &'static str {
        self.text
    }
}

const fn preset(name: &'static str, text: &'static str) -> Preset {
    Preset { name, text }
}

/// All presets.
pub const PRESETS: &[Preset] = &[
    preset("gold", "metal 1 0.78 0.34; roughness 0.2"),
    preset("copper", "metal 0.95 0.64 0.54; roughness 0.25"),
    preset("chrome", "metal 0.55 0.56 0.55; roughness 0.03"),
    preset("clay", "diffuse 0.55 0.27 0.16"),
    preset("plaster", "diffuse 0.8"),
    preset("wax", "principled 0.86 0.72 0.48; roughness 0.5"),
    preset("skin", "principled 0.74 0.42 0.31; roughness 0.45; ior 1.4"),
    preset("rubber", "principled 0.03; roughness 0.7"),
    preset("plastic", "principled 0.75 0.06 0.05; roughness 0.25"),
    preset("car paint", "principled 0.35 0.02 0.03; metallic 0.4; roughness 0.35; coat 1; coat-roughness 0.03"),
    preset("glass", "glass 1; ior 1.5; roughness 0"),
    preset("frosted glass", "glass 1; ior 1.5; roughness 0.3"),
    preset("water", "glass 1; ior 1.33; roughness 0; absorb 0.35 0.07 0.04"),
    preset("lamp", "emit 8"),
];

/// The preset of this name.
fn find(name: &str) -> Result<&'static Preset, EditError> {
    PRESETS.iter().find(|preset| preset.name == name).ok_or_else(|| {
        let names = listed(PRESETS.iter().map(|preset| preset.name), "or");
        EditError::NotHere(format!("There is no preset `{name}`. Expected {names}."))
    })
}

/// Adds a preset to the materials, unless one of its name and text is there, and gives it to nodes.
pub(crate) fn give(transaction: &mut Transaction, users: &[Path], name: &str) -> Result<(), EditError> {
    let preset = find(name)?;
    let braces = format!("{{ {} }}", preset.text);
    let is_it = |node: &&Node<'static>| {
        let same = |block: &Block<'static>| transaction.text[bytes(block.span)] == braces;
        node.name.value == MATERIAL && text_argument(node) == Some(name) && node.children.as_ref().is_some_and(same)
    };
    let mut users = users.to_vec();
    let mut material = name.to_owned();
    if !transaction.file.nodes.iter().any(|node| is_it(&node)) {
        material = free_name(transaction, MATERIAL, name);
        let added = add_top(transaction, MATERIAL, &format!("material {} {braces}", quoted(&material)))?;
        users = users.iter().map(|user| user.after_insertion(&added)).collect();
    }
    for user in users {
        let found = transaction.find(&user)?;
        let parameter = transaction.parameter(&user, key::MATERIAL)?;
        let patches = transaction.writer(found).write(&parameter, &Value::Text(material.clone()))?;
        transaction.then(patches)?;
    }
    Ok(())
}

/// Replaces all that is in the braces of a material.
pub(crate) fn apply(transaction: &mut Transaction, path: &Path, name: &str) -> Result<(), EditError> {
    let found = transaction.find(path)?;
    if found.kind != ItemKind::Material {
        let title = title(found.node, found.kind);
        return Err(EditError::NotHere(format!("`{title}` is no material. Select one.")));
    }
    let preset = find(name)?;
    let patch = match &found.node.children {
        Some(block) => Patch::replace(bytes(block.span), format!("{{ {} }}", preset.text)),
        None => Patch::insert(found.node.whole.end as usize, format!(" {{ {} }}", preset.text)),
    };
    transaction.last(vec![patch]);
    Ok(())
}
