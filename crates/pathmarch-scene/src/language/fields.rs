//! `field "name" { … }`: shapes that a scene declares itself, in WGSL.
//!
//! What is wrong in the WGSL is shown where it stands in the file, through the escapes and margins of the string
//! ([`super::strings::origins`]).

use super::arguments::{Range, arguments, in_range, missing_arguments, name, no_children, properties, string, twice};
use super::names::{NORMAL, PLACEMENT, TOP, solids, unexpected_node};
use super::params::{self, Declared, PARAM};
use super::report::{Report, draft, shown};
use super::strings::origins;
use super::tree::{Block, Entry, Node, Span};
use crate::assets::Assets;
use pathmarch_field::custom_sdf::{CodeDiagnostic, MAX_PARAMS};
use pathmarch_field::{CustomShape, Info, Param, Shape, ShapeRef, Solid, Unit, registry};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// The word that declares a shape.
pub(crate) const FIELD: &str = "field";
/// Fields of a scene; more are refused.
const MAX_FIELDS: usize = 64;
/// Characters of a name.
const MAX_NAME: usize = 40;
const USAGE: &str = "`field \"name\" { … }`";
/// What stands in the braces of a field.
const KNOWN: &[&str] = &[PARAM, "lipschitz", "bounds", "wgsl", "doc"];
/// The word for a field without bounds.
const ENDLESS: &str = "none";

/// The shapes that a scene declares.
#[derive(Clone, Default)]
pub(crate) struct Fields {
    shapes: Vec<Arc<CustomShape>>,
    /// Names of those that have mistakes, so that these are not told again where they are used.
    broken: Vec<String>,
}

impl Fields {
    /// The shape of this name.
    pub(crate) fn shape(&self, name: &str) -> Option<ShapeRef> {
        let shape = self.shapes.iter().find(|shape| &*shape.info().name == name)?;
        Some(ShapeRef::Custom(shape.clone()))
    }
    /// What stands in objects under this name: of the registry, or one of these.
    pub(crate) fn solid(&self, name: &str) -> Option<Solid<'_>> {
        let own = || self.shapes.iter().find(|shape| &*shape.info().name == name);
        registry::solid(name).or_else(|| Some(Solid::Shape(&**own()?)))
    }
    /// Every shape, those of the registry first.
    pub(crate) fn all_shapes(&self) -> impl Iterator<Item = &(dyn Shape + 'static)> {
        let own = self.shapes.iter().map(|shape| &**shape as &(dyn Shape + 'static));
        registry::shapes().iter().copied().chain(own)
    }
    /// Whether this name was declared, with mistakes.
    pub(crate) fn is_broken(&self, name: &str) -> bool {
        self.broken.iter().any(|broken| broken == name)
    }
    /// The names of all shapes.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.shapes.iter().map(|shape| &*shape.info().name)
    }

    /// Those of a file.
    pub(crate) fn new(file: &Block, assets: &mut Assets, report: &mut Report) -> Self {
        let mut fields = Self::default();
        let mut known: HashMap<String, (String, Span)> = HashMap::new();
        for (index, node) in file.nodes.iter().filter(|node| node.name.value == FIELD).enumerate() {
            if index == MAX_FIELDS {
                let message = format!("The scene has more than {MAX_FIELDS} fields.");
                report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
                break;
            }
            let before = report.count_so_far();
            if !node.entries.iter().any(|entry| entry.name.is_none()) {
                missing_arguments(node, USAGE, report);
            }
            properties(node, &[], report);
            let Some((name, span)) = name(node, USAGE, report) else { continue };
            let identifier = name.replace('-', "_");
            match known.get(&identifier) {
                Some((other, first)) if other == name => {
                    twice(&format!("The field {}", shown(name)), span, *first, report)
                }
                Some((other, first)) => {
                    let message = format!("{} is too much like {}.", shown(name), shown(other));
                    let mistake = draft("pathmarch::duplicate", span, message).label("the same but for - and _");
                    report.add(mistake.also(*first, "the other one is here"));
                }
                None => {
                    check_name(name, span, report);
                    known.insert(identifier.clone(), (name.to_owned(), span));
                }
            }
            let outside = report.scope.enter();
            let field = read(node, name, &identifier, assets, report);
            report.scope.leave(outside);
            match field.filter(|_| report.count_so_far() == before) {
                Some(field) => fields.shapes.push(Arc::new(field)),
                None => fields.broken.push(name.to_owned()),
            }
        }
        fields
    }
}

/// Reports a name that no shape may have.
fn check_name(name: &str, span: Span, report: &mut Report) {
    let words = [PLACEMENT, &[NORMAL, "material"], TOP].concat();
    if solids().any(|solid| solid == name) || words.contains(&name) {
        let message = format!("{} has a meaning already.", shown(name));
        let mistake = draft("pathmarch::reserved_name", span, message).label("taken");
        report.add(mistake.help("Choose another name for the field."));
        return;
    }
    let mut parts = name.split(['-', '_']);
    let plain = parts.all(|part| !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric()));
    if !plain || !name.starts_with(|c: char| c.is_ascii_alphabetic()) || name.len() > MAX_NAME {
        let message = format!("{} cannot be the name of a field.", shown(name));
        let mistake = draft("pathmarch::bad_name", span, message).label("not a name for a shape");
        let help = format!("Use up to {MAX_NAME} letters and digits, a letter first, with single - or _ between them.");
        report.add(mistake.help(help));
    }
}

/// The field of a node, where it could be made; mistakes are in the report.
fn read(node: &Node, name: &str, identifier: &str, assets: &mut Assets, report: &mut Report) -> Option<CustomShape> {
    let mut found: HashMap<&str, &Node> = HashMap::new();
    for child in node.child_nodes() {
        let word = &*child.name.value;
        if !KNOWN.contains(&word) {
            unexpected_node(&child.name, KNOWN, "in a field", report);
        } else if word != PARAM {
            match found.get(word) {
                Some(first) => twice(&format!("`{word}`"), child.name.span, first.name.span, report),
                None => drop(found.insert(word, child)),
            }
        }
    }
    let missing = |word: &str, help: &str, report: &mut Report| {
        if !node.broken() {
            let message = format!("This `field` has no `{word}`.");
            let mistake = draft("pathmarch::missing_node", node.name.span, message);
            report.add(mistake.label(format!("expected `{word}` in its braces")).help(help));
        }
    };
    let params = own_params(node, report);
    let lipschitz = match found.get("lipschitz") {
        Some(node) => one(node, "`lipschitz 1.5`", report)
            .and_then(|entry| in_range(entry, "`lipschitz`", Range { max: 1e6, ..Range::POSITIVE }, report)),
        None => Some(1.0),
    };
    let edges = match found.get("bounds") {
        Some(node) => bounds(node, report),
        None => {
            let help = "For example: bounds 2 2 2, the edges of a box around the origin that cuts the solid; or bounds \"none\".";
            missing("bounds", help, report);
            None
        }
    };
    let doc = match found.get("doc") {
        Some(node) => one(node, "`doc \"What it is.\"`", report).and_then(|entry| string(entry, "`doc`", report)),
        None => None,
    };
    let Some(text) = found.get("wgsl") else {
        missing("wgsl", "For example: wgsl \"fn distance(p: vec3f) -> f32 { return length(p) - 1.0; }\".", report);
        return None;
    };
    let entry = one(text, "`wgsl \"fn distance(p: vec3f) -> f32 { … }\"`", report)?;
    let text = string(entry, "`wgsl`", report)?;
    let params = params?;
    let names: Vec<String> = params.iter().map(|param| param.name.to_string()).collect();
    let code = match assets.code(identifier, &names, text) {
        Ok(code) => code,
        Err(faults) => {
            for fault in faults {
                wrong(entry, &fault, report);
            }
            return None;
        }
    };
    let doc = doc.map_or(Cow::Borrowed("A field of this scene."), |doc| Cow::Owned(doc.to_owned()));
    let info = Info::with_names(Cow::Owned(name.to_owned()), doc, "this scene").inexact();
    Some(CustomShape::new(info, params, lipschitz?, edges?, code))
}

/// The only argument of a node.
fn one<'n>(node: &'n Node<'n>, usage: &str, report: &mut Report) -> Option<&'n Entry<'n>> {
    properties(node, &[], report);
    no_children(node, report);
    let entries = arguments(node, 1, usage, report);
    if entries.is_empty() && !node.broken() {
        missing_arguments(node, usage, report);
    }
    entries.first().copied()
}

/// The edges of the box, `Some(None)` for none.
fn bounds(node: &Node, report: &mut Report) -> Option<Option<[f32; 3]>> {
    const USAGE: &str = "`bounds x y z` or `bounds \"none\"`";
    properties(node, &[], report);
    no_children(node, report);
    let entries = arguments(node, 3, USAGE, report);
    let edge =
        |entry: &Entry, report: &mut Report| in_range(entry, "`bounds`", Range { max: 1e6, ..Range::POSITIVE }, report);
    match entries[..] {
        [entry] => match &entry.value {
            super::tree::Value::Text(word) if word == ENDLESS => Some(None),
            _ => edge(entry, report).map(|edge| Some([edge; 3])),
        },
        [x, y, z] => {
            let edges = [edge(x, report), edge(y, report), edge(z, report)];
            Some(Some([edges[0]?, edges[1]?, edges[2]?]))
        }
        _ => {
            if !node.broken() {
                missing_arguments(node, USAGE, report);
            }
            None
        }
    }
}

/// Reports what is wrong in a text, where it stands in the file.
fn wrong(entry: &Entry, fault: &CodeDiagnostic, report: &mut Report) {
    let span = fault.range.as_ref().and_then(|range| {
        let (text, base) = report.text_at(entry.value_span);
        let start = entry.value_span.start as usize;
        let written = text.get(start - base..entry.value_span.end as usize - base)?;
        let places = origins(written);
        let first = *places.get(range.start)?;
        let last = *places.get(range.end.max(range.start + 1) - 1)?;
        let length = written.get(last..)?.chars().next()?.len_utf8();
        Some(Span::new(start + first, start + last + length))
    });
    let mistake =
        draft("pathmarch::wgsl", span.unwrap_or(entry.value_span), fault.message.clone()).label(fault.label.clone());
    report.add(match &fault.help {
        Some(help) => mistake.help(help.clone()),
        None => mistake,
    });
}

/// The parameters of a field, which formulas in it may use from then on; nothing after a mistake.
fn own_params(node: &Node, report: &mut Report) -> Option<Vec<Param>> {
    let before = report.count_so_far();
    // Where the shape is used, properties of these names mean something else.
    let mut params: Vec<Param> = Vec::new();
    for declared in params::declare(params::nodes(node.child_nodes()), &[], &["material"], report) {
        let Declared { name, span, value, range, doc } = declared;
        if params.len() == MAX_PARAMS {
            let message = format!("A field has at most {MAX_PARAMS} parameters.");
            report.add(draft("pathmarch::too_large", span, message).label("one too many"));
            break;
        }
        let name = Cow::Owned(name);
        let doc = doc.map_or(Cow::Borrowed("A number of this field."), Cow::Owned);
        let Range { min, max, .. } = range;
        let default = value.value as f32;
        params.push(Param { name, unit: Unit::Ratio, default, min, min_allowed: true, max, doc });
    }
    (report.count_so_far() == before).then_some(params)
}
