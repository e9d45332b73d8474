//! Names that fit a place, as the reader expects them there.
//!
//! A word that does not exist is put at the place, once as it is and once as the name of a property; the mistakes that
//! the reader then reports there list what it expected.

use super::OpenText;
use super::locate::{Part, locate, owners_in, owners_of};
use crate::diagnostic::Mistake;
use crate::document::quoted;
use crate::language::tree::{Block, Span, Value};
use crate::language::{self, expected_at};
use crate::materials::{self, ParamKind};
use crate::reference::{self, Entry};
use crate::settings::{self, Setting};
use pathmarch_field::{Param, Solid, registry};
use std::ops::Range;

/// A word that no text has, far from all names.
const MARK: &str = "zqxjzqxjzqxjzqxj";

/// What a completion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompletionKind {
    /// Name of a node.
    Node,
    /// Name of a property.
    Property,
    /// Value: a declared name or a word of a list.
    Value,
    /// Name in a formula.
    Formula,
}

/// A name that fits.
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// The name.
    pub label: String,
    /// What it is.
    pub kind: CompletionKind,
    /// Text to insert; in that of nodes and properties `${1:…}` marks what comes next, as in snippets of the language server
    /// protocol.
    pub insert: String,
    /// What the reference says of it.
    pub help: Option<Entry>,
}

/// Names that fit, and what they replace.
#[derive(Clone, Debug, PartialEq)]
pub struct Completions {
    /// Bytes of the word that is replaced, perhaps none.
    pub range: Range<usize>,
    /// The names.
    pub list: Vec<Completion>,
}

impl OpenText {
    /// Names that fit at byte `at`, which replace the word there.
    pub fn completions(&mut self, at: usize) -> Completions {
        let string = self.string_at(at);
        let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '-' && string.is_none();
        let range = word(&self.text, at, is_part);
        let mut found = Completions { range: range.clone(), list: Vec::new() };
        if let Some(mistake) = self.expected(&range, MARK) {
            let in_formula = is_formula(&mistake);
            if let Some(string) = string.clone().filter(|_| !in_formula) {
                found.range = string;
            }
            found.list.extend(self.listed(&mistake, &range, string.is_some()));
        }
        if string.is_none()
            && let Some(mistake) = self.expected(&range, &format!("{MARK}=1"))
            && mistake.code == "pathmarch::unknown_property"
        {
            found.list.extend(self.listed(&mistake, &range, false));
        }
        found
    }

    /// Bytes between the quotes of the string at byte `at`.
    fn string_at(&self, at: usize) -> Option<Range<usize>> {
        let located = locate(self.file.as_ref()?, at)?;
        let Part::Value(entry) = located.part else { return None };
        let Span { start, end } = entry.value_span;
        let inside = start as usize + 1..(end as usize).checked_sub(1)?;
        let is_string = matches!(entry.value, Value::Text(_)) && self.text[start as usize..].starts_with('"');
        (is_string && inside.start <= at && at <= inside.end).then_some(inside)
    }

    /// The mistake at a word that replaces a range, with the names that are expected instead.
    fn expected(&mut self, range: &Range<usize>, word: &str) -> Option<Mistake> {
        let text = self.with(range, word);
        expected_at(&self.name, &text, range.start, &mut self.assets)
    }
    fn with(&self, range: &Range<usize>, word: &str) -> String {
        format!("{}{word}{}", &self.text[..range.start], &self.text[range.end..])
    }

    fn listed(&self, mistake: &Mistake, range: &Range<usize>, in_string: bool) -> Vec<Completion> {
        let kind = match mistake.code {
            "pathmarch::unknown_node" => CompletionKind::Node,
            "pathmarch::unknown_property" => CompletionKind::Property,
            _ if is_formula(mistake) => CompletionKind::Formula,
            _ => CompletionKind::Value,
        };
        let text = self.with(range, MARK);
        let file = language::nodes(&text).map(Block::into_owned);
        let located = file.as_ref().and_then(|file| locate(file, range.start));
        let owners = match (&located, kind) {
            (Some(located), CompletionKind::Node) => owners_in(&located.parents),
            (Some(located), _) => owners_of(located.node),
            (None, _) => Vec::new(),
        };
        mistake.expected.iter().map(|name| self.completion(name, kind, &owners, in_string)).collect()
    }

    fn completion(&self, name: &str, kind: CompletionKind, owners: &[&str], in_string: bool) -> Completion {
        let help = match kind {
            CompletionKind::Node => {
                self.declared_solid(name).or_else(|| reference::entries_of(name, owners).into_iter().next())
            }
            CompletionKind::Property => reference::property(name, owners),
            CompletionKind::Value => self.declared_material(name),
            CompletionKind::Formula => None,
        };
        let insert = match kind {
            CompletionKind::Node => node_snippet(name, owners),
            CompletionKind::Property => format!("{name}=${{1:{}}}", property_value(name, owners)),
            CompletionKind::Value if in_string => quoted(name).trim_matches('"').to_owned(),
            CompletionKind::Value if !name.starts_with('#') => quoted(name),
            CompletionKind::Value | CompletionKind::Formula => name.to_owned(),
        };
        Completion { label: name.to_owned(), kind, insert, help }
    }
}

/// Mistake in a formula.
fn is_formula(mistake: &Mistake) -> bool {
    ["There is no parameter", "There is no function"].iter().any(|start| mistake.message.starts_with(start))
}

/// Bytes of the word around byte `at`.
fn word(text: &str, at: usize, is_part: impl Fn(char) -> bool) -> Range<usize> {
    let length = |c: char| c.len_utf8();
    let before: usize = text[..at].chars().rev().take_while(|c| is_part(*c)).map(length).sum();
    let after: usize = text[at..].chars().take_while(|c| is_part(*c)).map(length).sum();
    at - before..at + after
}

/// Settings in braces or properties of one of these owners.
fn setting(name: &str, owners: &[&str]) -> Option<&'static Setting> {
    let tables: [(&str, &[Setting]); 16] = [
        ("camera", settings::CAMERA),
        ("render", settings::RENDER),
        ("fog", settings::FOG),
        ("sun", settings::SUN),
        ("point", settings::POINT),
        ("spot", settings::SPOT),
        ("sky \"gradient\"", settings::GRADIENT),
        ("sky \"day\"", settings::DAY_GROUND),
        ("sky \"day\"", settings::DAY),
        ("sky", settings::PICTURE),
        ("lens", settings::LENS),
        ("mesh", settings::MESH),
        ("decal", settings::DECAL),
        ("object", settings::EMITTER),
        (reference::PLACEMENTS, settings::PLACEMENT),
        (reference::PLACEMENTS, std::slice::from_ref(&settings::NORMAL)),
    ];
    let owned = tables.into_iter().filter(|(owner, _)| owners.contains(owner));
    owned.flat_map(|(_, table)| table).find(|setting| setting.name == name)
}

/// A node with its defaults.
fn node_snippet(name: &str, owners: &[&str]) -> String {
    if let Some(setting) = setting(name, owners) {
        let value = setting.example.strip_prefix(name).unwrap_or_default().trim();
        return format!("{name} ${{1:{value}}}");
    }
    if owners.contains(&reference::TOP_OF_FILE) {
        return top_snippet(name);
    }
    if owners.contains(&reference::MATERIAL_KINDS)
        && let Some(value) = material_default(name, owners)
    {
        return format!("{name} ${{1:{value}}}");
    }
    match registry::solid(name).filter(|_| owners.contains(&reference::IN_OBJECTS)) {
        Some(Solid::Operator(_)) => format!("{name} {{\n\t$0\n}}"),
        Some(Solid::Modifier(modifier)) => format!("{} {{\n\t$0\n}}", with_defaults(name, modifier.params())),
        Some(Solid::Shape(shape)) if shape.info().outline.is_none() => with_defaults(name, shape.params()),
        _ => name.to_owned(),
    }
}

/// A name with the defaults of its parameters.
fn with_defaults(name: &str, params: &[Param]) -> String {
    let defaults: Vec<String> = params.iter().map(Param::default_in_words).collect();
    if defaults.is_empty() { name.to_owned() } else { format!("{name} ${{1:{}}}", defaults.join(" ")) }
}

fn top_snippet(name: &str) -> String {
    let required = |table| format!("{name} {{\n\t{}\n}}", settings::required(table, "\n\t"));
    match name {
        "pathmarch" => "pathmarch 1".to_owned(),
        "unit" => "unit ${1:cm}".to_owned(),
        "include" => "include \"$1\"".to_owned(),
        "param" => "param ${1:name} ${2:1}".to_owned(),
        "camera" => required(settings::CAMERA),
        "fog" => "fog {\n\tscatter ${1:0.1}\n}".to_owned(),
        "sun" => required(settings::SUN),
        "point" => required(settings::POINT),
        "spot" => required(settings::SPOT),
        "render" => "render {\n\t$0\n}".to_owned(),
        "sky" => "sky ${1:0.3 0.375 0.5}".to_owned(),
        _ => format!("{name} \"${{1:name}}\" {{\n\t$0\n}}"),
    }
}

/// Default of a material's parameter.
fn material_default(name: &str, owners: &[&str]) -> Option<String> {
    let ours = materials::kinds().iter().filter(|kind| owners.contains(&kind.name) || kind.name == name);
    let param = ours.flat_map(|kind| kind.params).find(|param| param.name() == name)?;
    Some(match param.kind {
        // The default changes nothing.
        ParamKind::Flag => format!("#{}", param.spec.default == 0.0),
        ParamKind::Colour | ParamKind::Number => param.default_in_words(),
    })
}

/// Default of a property.
fn property_value(name: &str, owners: &[&str]) -> String {
    let example = setting(name, owners).or_else(|| settings::BLEND.iter().find(|setting| setting.name == name));
    let example = example.and_then(|setting| setting.example.split_once('=')).map(|(_, value)| value.to_owned());
    let param = || {
        let solid = owners.iter().find_map(|owner| registry::solid(owner))?;
        solid.params().iter().find(|param| param.name == name).map(Param::default_in_words)
    };
    example.or_else(param).unwrap_or_default()
}
