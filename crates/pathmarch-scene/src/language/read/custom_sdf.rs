//! `field "name" { … }`: shapes that a scene declares itself, in WGSL or GLSL.
//!
//! Mistakes in the code are shown where they stand in the file, through the escapes and margins of the string
//! ([`origins`]).

use super::arguments::{arguments, missing_arguments, name, no_children, properties, string, twice};
use super::context::Context;
use super::numbers::in_range;
use super::params::{self, Declared};
use super::unexpected::unexpected_node;
use crate::assets::Assets;
use crate::language::diagnostics::foreign_code::is_glsl;
use crate::language::diagnostics::report::{Draft, draft, shown};
use crate::language::formulas::expression::is_name;
use crate::language::formulas::scope::reserved;
use crate::language::keywords::{FIELD, NORMAL, PARAM, PLACEMENT, TOP, solids};
use crate::language::syntax::strings::origins;
use crate::language::tree::{Block, Entry, Node, Span, Value};
use crate::settings::Range;
use pathmarch_field::custom_sdf::glsl::{Shader, ShaderParam};
use pathmarch_field::custom_sdf::{Code, CodeDiagnostic, MAX_PARAMS};
use pathmarch_field::{CustomShape, Info, Param, Shape, ShapeRef, Solid, Unit, registry};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// Largest number of custom SDFs in a scene.
const MAX_FIELDS: usize = 64;
/// Characters of a name.
const MAX_NAME: usize = 40;
const USAGE: &str = "`field \"name\" { … }`";
/// Nodes in the braces of a field.
const KNOWN: &[&str] = &[PARAM, "lipschitz", "bounds", "wgsl", "glsl", "doc"];
/// The word for a field without bounds.
const ENDLESS: &str = "none";

/// Custom SDFs of a scene.
#[derive(Clone, Default)]
pub(crate) struct CustomSdfs {
    shapes: Vec<Arc<CustomShape>>,
    /// Names of those with mistakes, so that their uses report none.
    broken: Vec<String>,
}

impl CustomSdfs {
    /// The shape of this name.
    pub(crate) fn shape(&self, name: &str) -> Option<ShapeRef> {
        let shape = self.shapes.iter().find(|shape| &*shape.info().name == name)?;
        Some(ShapeRef::Custom(shape.clone()))
    }
    /// Shape or operator of this name, of the registry or custom.
    pub(crate) fn solid(&self, name: &str) -> Option<Solid<'_>> {
        let own = || self.shapes.iter().find(|shape| &*shape.info().name == name);
        registry::solid(name).or_else(|| Some(Solid::Shape(&**own()?)))
    }
    /// Every shape, those of the registry first.
    pub(crate) fn all_shapes(&self) -> impl Iterator<Item = &(dyn Shape + 'static)> {
        let own = self.shapes.iter().map(|shape| &**shape as &(dyn Shape + 'static));
        registry::shapes().iter().copied().chain(own)
    }
    /// True if this name is declared, with mistakes.
    pub(crate) fn is_broken(&self, name: &str) -> bool {
        self.broken.iter().any(|broken| broken == name)
    }
    /// The names of all shapes.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.shapes.iter().map(|shape| &*shape.info().name)
    }

    /// Those of a file.
    pub(crate) fn new(file: &Block, assets: &mut Assets, context: &mut Context) -> Self {
        let mut fields = Self::default();
        let mut known: HashMap<String, (String, Span)> = HashMap::new();
        for (index, node) in file.nodes.iter().filter(|node| node.name.value == FIELD).enumerate() {
            if index == MAX_FIELDS {
                let message = format!("The scene has more than {MAX_FIELDS} fields.");
                context.report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
                break;
            }
            let before = context.report.count_so_far();
            if !node.entries.iter().any(|entry| entry.name.is_none()) {
                missing_arguments(node, USAGE, context);
            }
            properties(node, &[], context);
            let Some((name, span)) = name(node, USAGE, context) else { continue };
            let identifier = name.replace('-', "_");
            match known.get(&identifier) {
                Some((other, first)) if other == name => {
                    twice(&format!("The field {}", shown(name)), span, *first, context)
                }
                Some((other, first)) => {
                    let message = format!("{} is too much like {}.", shown(name), shown(other));
                    let mistake = draft("pathmarch::duplicate", span, message).label("the same but for - and _");
                    context.report.add(mistake.also(*first, "the other one is here"));
                }
                None => {
                    check_name(name, span, context);
                    known.insert(identifier.clone(), (name.to_owned(), span));
                }
            }
            let outside = context.scope.enter();
            let field = read(node, name, &identifier, assets, context);
            context.scope.leave(outside);
            match field.filter(|_| context.report.count_so_far() == before) {
                Some(field) => fields.shapes.push(Arc::new(field)),
                None => fields.broken.push(name.to_owned()),
            }
        }
        fields
    }
}

/// Reports a name that no shape may have.
fn check_name(name: &str, span: Span, context: &mut Context) {
    let words = [PLACEMENT, &[NORMAL, "material"], TOP].concat();
    if solids().any(|solid| solid == name) || words.contains(&name) {
        let message = format!("{} is a reserved name.", shown(name));
        let mistake = draft("pathmarch::reserved_name", span, message).label("taken");
        context.report.add(mistake.help("Choose another name for the field."));
        return;
    }
    let mut parts = name.split(['-', '_']);
    let plain = parts.all(|part| !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric()));
    if !plain || !name.starts_with(|c: char| c.is_ascii_alphabetic()) || name.len() > MAX_NAME {
        let message = format!("{} cannot be the name of a field.", shown(name));
        let mistake = draft("pathmarch::bad_name", span, message).label("not a name for a shape");
        let help = format!("Use up to {MAX_NAME} letters and digits, a letter first, with single - or _ between them.");
        context.report.add(mistake.help(help));
    }
}

/// The field of a node, where it could be made; mistakes are in the report.
fn read(node: &Node, name: &str, identifier: &str, assets: &mut Assets, context: &mut Context) -> Option<CustomShape> {
    let mut found: HashMap<&str, &Node> = HashMap::new();
    for child in node.child_nodes() {
        let word = &*child.name.value;
        if !KNOWN.contains(&word) {
            unexpected_node(&child.name, KNOWN, "in a field", context);
        } else if word != PARAM {
            match found.get(word) {
                Some(first) => twice(&format!("`{word}`"), child.name.span, first.name.span, context),
                None => drop(found.insert(word, child)),
            }
        }
    }
    let missing = |word: &str, help: &str, context: &mut Context| {
        if !node.broken() {
            let message = format!("This `field` has no `{word}`.");
            let mistake = draft("pathmarch::missing_node", node.name.span, message);
            context.report.add(mistake.label(format!("expected `{word}` in its braces")).help(help));
        }
    };
    let params = custom_params(node, context);
    let lipschitz = match found.get("lipschitz") {
        Some(node) => one(node, "`lipschitz 1.5`", context)
            .and_then(|entry| in_range(entry, "`lipschitz`", Range { max: 1e6, ..Range::POSITIVE }, context)),
        None => Some(1.0),
    };
    let edges = match found.get("bounds") {
        Some(node) => bounds(node, context),
        None => {
            let help = "For example: bounds 2 2 2, the edges of a box around the origin that cuts the solid; or bounds \"none\".";
            missing("bounds", help, context);
            None
        }
    };
    let doc = match found.get("doc") {
        Some(node) => one(node, "`doc \"What it is.\"`", context).and_then(|entry| string(entry, "`doc`", context)),
        None => None,
    };
    let (params, code) = match (found.get("wgsl"), found.get("glsl")) {
        (Some(_), Some(second)) => {
            let mistake = draft("pathmarch::two_codes", second.name.span, "A `field` has one code.");
            context.report.add(mistake.label("a second code").help("Leave out `wgsl` or `glsl`."));
            return None;
        }
        (Some(text), None) => wgsl_code(text, identifier, params, assets, context)?,
        (None, Some(text)) => glsl_code(text, identifier, params, assets, context)?,
        (None, None) => {
            missing(
                "wgsl",
                "For example: wgsl \"fn distance(p: vec3f) -> f32 { return length(p) - 1.0; }\"; or `glsl`.",
                context,
            );
            return None;
        }
    };
    let doc = doc.map_or(Cow::Borrowed("A field of this scene."), |doc| Cow::Owned(doc.to_owned()));
    let info = Info::with_names(Cow::Owned(name.to_owned()), doc, "this scene").inexact();
    Some(CustomShape::new(info, params, lipschitz?, edges?, code))
}

/// Parameters and code of a field in WGSL; `params` is `None` if they have mistakes.
fn wgsl_code(
    node: &Node,
    identifier: &str,
    params: Option<Vec<Param>>,
    assets: &mut Assets,
    context: &mut Context,
) -> Option<(Vec<Param>, Arc<Code>)> {
    let entry = one(node, "`wgsl \"fn distance(p: vec3f) -> f32 { … }\"`", context)?;
    let text = string(entry, "`wgsl`", context)?;
    let params = params?;
    match assets.code(identifier, &names(&params), text) {
        Ok(code) => Some((params, code)),
        Err(faults) if is_glsl(text) => {
            glsl(entry, &faults, context);
            None
        }
        Err(faults) => {
            wrong(entry, &faults, "pathmarch::wgsl", context);
            None
        }
    }
}

/// Parameters and code of a field in GLSL, likewise: its uniforms are parameters, unless the field declares them itself.
fn glsl_code(
    node: &Node,
    identifier: &str,
    params: Option<Vec<Param>>,
    assets: &mut Assets,
    context: &mut Context,
) -> Option<(Vec<Param>, Arc<Code>)> {
    const USAGE: &str = "`glsl \"float map(vec3 p) { … }\"`";
    no_children(node, context);
    let function = match properties(node, &["entry"], context).first() {
        Some((_, entry)) => Some(string(entry, "`entry`", context)?),
        None => None,
    };
    let Some(entry) = arguments(node, 1, USAGE, context).first().copied() else {
        if !node.broken() {
            missing_arguments(node, USAGE, context);
        }
        return None;
    };
    let text = string(entry, "`glsl`", context)?;
    let mut params = params?;
    let own = names(&params);
    let read = Shader::read(text, function, &own).and_then(|shader| {
        let code = assets.shader(identifier, &own, text, &shader)?;
        Ok((shader, code))
    });
    let (shader, code) = match read {
        Ok(read) => read,
        Err(faults) => {
            wrong(entry, &faults, "pathmarch::glsl", context);
            return None;
        }
    };
    for warning in &shader.warnings {
        let draft = drafted(entry, warning, "pathmarch::glsl", context);
        context.report.warn(draft);
    }
    for param in shader.params.iter().filter(|param| !own.contains(&param.name)) {
        if !is_param_name(&param.name) {
            let fault = CodeDiagnostic {
                message: format!("The uniform `{}` cannot be a parameter.", param.name),
                label: "a reserved name".to_owned(),
                range: param.place.clone(),
                help: Some("Rename it: formulas have another meaning for this name.".to_owned()),
            };
            wrong(entry, &[fault], "pathmarch::glsl", context);
            return None;
        }
        params.push(uniform_param(param));
    }
    Some((params, code))
}

fn names(params: &[Param]) -> Vec<String> {
    params.iter().map(|param| param.name.to_string()).collect()
}

/// True for a name that a parameter of a field can have.
fn is_param_name(name: &str) -> bool {
    is_name(name) && !reserved().any(|other| other == name) && name != "material"
}

fn uniform_param(param: &ShaderParam) -> Param {
    let doc = param.doc.clone().unwrap_or_else(|| "A uniform of the shader.".to_owned());
    let name = Cow::Owned(param.name.clone());
    Param { name, unit: Unit::Ratio, default: param.default, range: param.range, doc: Cow::Owned(doc) }
}

/// The only argument of a node.
fn one<'n>(node: &'n Node<'n>, usage: &str, context: &mut Context) -> Option<&'n Entry<'n>> {
    properties(node, &[], context);
    no_children(node, context);
    let entries = arguments(node, 1, usage, context);
    if entries.is_empty() && !node.broken() {
        missing_arguments(node, usage, context);
    }
    entries.first().copied()
}

/// The edges of the box, `Some(None)` for none.
fn bounds(node: &Node, context: &mut Context) -> Option<Option<[f32; 3]>> {
    const USAGE: &str = "`bounds x y z` or `bounds \"none\"`";
    properties(node, &[], context);
    no_children(node, context);
    let entries = arguments(node, 3, USAGE, context);
    let edge = |entry: &Entry, context: &mut Context| {
        in_range(entry, "`bounds`", Range { max: 1e6, ..Range::POSITIVE }, context)
    };
    match entries[..] {
        [entry] => match &entry.value {
            Value::Text(word) if word == ENDLESS => Some(None),
            _ => edge(entry, context).map(|edge| Some([edge; 3])),
        },
        [x, y, z] => {
            let edges = [edge(x, context), edge(y, context), edge(z, context)];
            Some(Some([edges[0]?, edges[1]?, edges[2]?]))
        }
        _ => {
            if !node.broken() {
                missing_arguments(node, USAGE, context);
            }
            None
        }
    }
}

/// Reports code in GLSL once, at the first place that is not WGSL.
fn glsl(entry: &Entry, faults: &[CodeDiagnostic], context: &mut Context) {
    let span = faults.first().and_then(|fault| place(entry, fault, context)).unwrap_or(entry.value_span);
    let mistake = draft("pathmarch::glsl", span, "This is GLSL: use `glsl`.").label("no WGSL from here");
    let help = "Write `glsl` in place of `wgsl` before the code.";
    context.report.add(mistake.help(help));
}

/// Reports faults in a code at their places in the file.
fn wrong(entry: &Entry, faults: &[CodeDiagnostic], id: &'static str, context: &mut Context) {
    for fault in faults {
        let draft = drafted(entry, fault, id, context);
        context.report.add(draft);
    }
}

fn drafted(entry: &Entry, fault: &CodeDiagnostic, id: &'static str, context: &Context) -> Draft {
    let span = place(entry, fault, context);
    let mistake = draft(id, span.unwrap_or(entry.value_span), fault.message.clone()).label(fault.label.clone());
    match &fault.help {
        Some(help) => mistake.help(help.clone()),
        None => mistake,
    }
}

/// Place of a fault in the file.
fn place(entry: &Entry, fault: &CodeDiagnostic, context: &Context) -> Option<Span> {
    fault.range.as_ref().and_then(|range| {
        let (text, base) = context.report.text_at(entry.value_span);
        let start = entry.value_span.start as usize;
        let written = text.get(start - base..entry.value_span.end as usize - base)?;
        let places = origins(written);
        let first = *places.get(range.start)?;
        let last = *places.get(range.end.max(range.start + 1) - 1)?;
        let length = written.get(last..)?.chars().next()?.len_utf8();
        Some(Span::new(start + first, start + last + length))
    })
}

/// The parameters of a field, which formulas in it may use from then on; nothing after a mistake.
fn custom_params(node: &Node, context: &mut Context) -> Option<Vec<Param>> {
    let before = context.report.count_so_far();
    // Where the shape is used, properties of these names mean something else.
    let mut params: Vec<Param> = Vec::new();
    for declared in params::declare(params::nodes(node.child_nodes()), &[], &["material"], context) {
        let Declared { name, span, value, range, doc } = declared;
        if params.len() == MAX_PARAMS {
            let message = format!("A field has at most {MAX_PARAMS} parameters.");
            context.report.add(draft("pathmarch::too_large", span, message).label("one too many"));
            break;
        }
        let name = Cow::Owned(name);
        let doc = doc.map_or(Cow::Borrowed("A number of this field."), Cow::Owned);
        let default = value.value as f32;
        params.push(Param { name, unit: Unit::Ratio, default, range, doc });
    }
    (context.report.count_so_far() == before).then_some(params)
}
