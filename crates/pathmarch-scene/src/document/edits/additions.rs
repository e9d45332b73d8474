//! Additions to a scene: new nodes that are valid, visible and short.

use super::naming::free_name;
use super::transaction::Transaction;
use crate::document::control::{Addition, Group};
use crate::document::error::EditError;
use crate::document::mesh_import::ImportedNode;
use crate::document::text::layout::{Chunk, bytes};
use crate::document::text::literals::{number, quoted, string_like};
use crate::document::tree::nodes::text_argument;
use crate::document::tree::outline::ItemKind;
use crate::document::tree::path::Path;
use crate::language::keywords::{AXES, FIELD, FOG, INCLUDE, PARAM, SHAPE};
use crate::materials;
use crate::settings::{self, SKY_FORMS};
use crate::svg_path::DEFAULT_PATH;
use crate::text::DEFAULT_TEXT;
use pathmarch_field::Outline;
use pathmarch_field::{Modifier, Shape, Solid, Unit, registry};
use std::borrow::Cow;

/// Additions to a node of this kind, or to the file.
pub(crate) fn additions(transaction: &Transaction, parent: Option<ItemKind>) -> Vec<Addition> {
    let shapes = |group| {
        transaction
            .fields()
            .all_shapes()
            .map(move |shape| addition(group, shape.info().name.clone(), shape.info().doc.clone()))
    };
    let operators = registry::solids().filter(|solid| solid.is_operator());
    match parent {
        Some(kind) if kind.holds_shapes() => declared(transaction)
            .chain(shapes(Group::Shape))
            .chain(operators.map(|op| addition(Group::Operator, op.info().name.clone(), op.info().doc.clone())))
            .collect(),
        Some(_) => Vec::new(),
        None => {
            let has = |word: &str| transaction.file.nodes.iter().any(|node| node.name.value == word);
            let mut all: Vec<Addition> = shapes(Group::Object).collect();
            all.extend(materials::kinds().iter().map(|kind| addition(Group::Material, kind.name, kind.doc)));
            all.push(addition(Group::Light, "sun", "Light from far away."));
            all.push(addition(Group::Light, "point", "Light from a point, the same in every direction."));
            all.push(addition(Group::Light, "spot", "Light from a point, in a cone."));
            all.push(addition(Group::Camera, "camera", "Another point of view."));
            if !has("sky") {
                let forms = SKY_FORMS.iter().filter(|(name, _)| *name != "picture");
                all.extend(forms.map(|(name, doc)| addition(Group::Sky, *name, *doc)));
            }
            if !has(FOG) {
                all.push(addition(Group::Sky, FOG, "Medium between the objects, which scatters and absorbs light."));
            }
            if !has("render") {
                all.push(addition(Group::Render, "render", "Size and quality of the picture."));
            }
            all.push(addition(Group::Param, PARAM, "A number with a name, which formulas use."));
            all
        }
    }
}

/// The shapes that the file declares.
fn declared(transaction: &Transaction) -> impl Iterator<Item = Addition> {
    let values = transaction.values();
    let shapes = transaction.file.nodes.iter().chain(values.included.iter()).filter(|node| node.name.value == SHAPE);
    let names: Vec<String> = shapes.filter_map(text_argument).map(str::to_owned).collect();
    names.into_iter().map(|name| addition(Group::Shape, name, "Shape that this file declares or includes."))
}

fn addition(group: Group, name: impl Into<Cow<'static, str>>, doc: impl Into<Cow<'static, str>>) -> Addition {
    Addition { group, name: name.into(), doc: doc.into() }
}

/// Adds something to a node, or to the file.
pub(crate) fn add(
    transaction: &mut Transaction,
    parent: Option<&Path>,
    addition: &Addition,
) -> Result<Path, EditError> {
    let kind = parent.map(|parent| transaction.find(parent).map(|found| found.kind)).transpose()?;
    if !additions(transaction, kind).contains(addition) {
        let name = &addition.name;
        return Err(EditError::NotHere(format!("`{name}` cannot be added here, or there is one already.")));
    }
    let word = &*addition.name;
    let (node, text) = match addition.group {
        Group::Shape | Group::Operator => {
            let text = match transaction.fields().solid(word) {
                Some(Solid::Shape(shape)) if is_in_plane(transaction, parent) => shape_text(shape),
                Some(Solid::Shape(shape)) => solid_text(shape),
                Some(Solid::Modifier(modifier)) => modifier_text(modifier),
                None => string_like(word, ""),
                _ => operator_text(word),
            };
            let chunk = Chunk::new(&text, transaction.style);
            return transaction.put_in(parent, usize::MAX, &chunk);
        }
        Group::Object => {
            let name = quoted(&free_name(transaction, "object", word));
            let shape = match transaction.fields().solid(word) {
                Some(Solid::Shape(shape)) => solid_text(shape),
                _ => String::new(),
            };
            ("object", format!("object {name} {{ {shape} }}"))
        }
        Group::Material => {
            let name = quoted(&free_name(transaction, "material", word));
            let first = materials::kind(word).and_then(|kind| kind.params.first());
            let [r, g, b] = first.map_or([0.0; 3], materials::MaterialParam::default_value);
            let value = match first {
                None => String::new(),
                Some(_) if r == g && g == b => format!(" {}", number(r)),
                Some(param) if param.kind == materials::ParamKind::Number => format!(" {}", number(r)),
                Some(_) => format!(" {} {} {}", number(r), number(g), number(b)),
            };
            ("material", format!("material {name} {{ {word}{value} }}"))
        }
        Group::Light if word == "sun" => ("sun", format!("sun {{ {} }}", settings::required(settings::SUN, "; "))),
        Group::Light if word == "spot" => ("spot", format!("spot {{ {} }}", settings::required(settings::SPOT, "; "))),
        Group::Light => ("point", format!("point {{ {} }}", settings::required(settings::POINT, "; "))),
        Group::Camera => {
            let name = quoted(&free_name(transaction, "camera", "camera"));
            ("camera", format!("camera {name} {{\n\t{}\n}}", settings::required(settings::CAMERA, "\n\t")))
        }
        Group::Sky => match word {
            "gradient" => ("sky", format!("sky \"gradient\" {{ {} }}", settings::required(settings::GRADIENT, "; "))),
            FOG => (FOG, format!("{FOG} {{ {} }}", settings::FOG[0].example)),
            "day" => ("sky", "sky \"day\"".to_owned()),
            _ => ("sky", "sky 0.5".to_owned()),
        },
        Group::Param => (PARAM, format!("{PARAM} {} 1 min=0 max=2", quoted(&free_name(transaction, PARAM, "amount")))),
        Group::Render => {
            let words = settings::RENDER.iter().take(2).map(|setting| setting.example);
            ("render", format!("render {{ {} }}", words.collect::<Vec<_>>().join("; ")))
        }
    };
    add_top(transaction, node, &text)
}

/// Adds imported nodes to the file, with free names. Returns their paths.
pub(crate) fn add_imported(transaction: &mut Transaction, nodes: &[ImportedNode]) -> Result<Vec<Path>, EditError> {
    let add = |node: &ImportedNode| {
        let name = node.name.as_ref().map(|name| quoted(&free_name(transaction, node.word, name)));
        let name = name.map_or_else(String::new, |name| format!(" {name}"));
        add_top(transaction, node.word, &format!("{}{name} {{ {} }}", node.word, node.body))
    };
    nodes.iter().map(add).collect()
}

/// Adds a node at the top of the file, behind the others of its word, or where files have such nodes.
pub(crate) fn add_top(transaction: &mut Transaction, word: &str, template: &str) -> Result<Path, EditError> {
    const ORDER: [&str; 12] =
        ["pathmarch", INCLUDE, PARAM, "camera", "render", "sky", FOG, "sun", "material", FIELD, SHAPE, "object"];
    let rank = |word: &str| {
        let word = if matches!(word, "point" | "spot") { "sun" } else { word };
        ORDER.iter().position(|other| *other == word).unwrap_or(ORDER.len())
    };
    let nodes = &transaction.file.nodes;
    let before = nodes.iter().rposition(|node| rank(&node.name.value) <= rank(word));
    let alike = before.is_some_and(|index| {
        let node = &nodes[index];
        let one_line = !transaction.text[bytes(node.whole)].contains('\n') && !template.contains('\n');
        rank(&node.name.value) == rank(word) && one_line
    });
    let chunk = Chunk::new(template, transaction.style).apart(!alike);
    transaction.put_in(None, before.map_or(0, |index| index + 1), &chunk)
}

/// Text of a shape with its parameters, and an outline if it needs one.
fn shape_text(shape: &dyn Shape) -> String {
    let name = &shape.info().name;
    match shape.info().outline {
        Some(Outline::Points) => return format!("{name} {{ point -0.5 -0.4; point 0.5 -0.4; point 0 0.5 }}"),
        Some(Outline::Text) => return format!("{name} {}", quoted(DEFAULT_TEXT)),
        Some(Outline::Curve) => {
            return format!("{name} {{ point 0 -0.5; point 0.4 -0.1; point 0 0.5 corner=#true; point -0.4 -0.1 }}");
        }
        Some(Outline::Path) => return format!("{name} {}", quoted(DEFAULT_PATH)),
        None => {}
    }
    let numbers = shape.params().iter().map(|param| number(param.default));
    std::iter::once(shape.info().name.to_string()).chain(numbers).collect::<Vec<_>>().join(" ")
}

/// Text of a shape with its parameters; a profile is extruded.
fn solid_text(shape: &dyn Shape) -> String {
    let text = shape_text(shape);
    if shape.info().profile { format!("extrude 0.25 {{ {text} }}") } else { text }
}

/// True if a node, or a node around it, makes solids of profiles.
fn is_in_plane(transaction: &Transaction, node: Option<&Path>) -> bool {
    let around = std::iter::successors(node.cloned(), Path::parent);
    let words = around.filter_map(|path| Some(transaction.find(&path).ok()?.node.name.value.to_string()));
    words
        .into_iter()
        .any(|word| matches!(registry::solid(&word), Some(Solid::Modifier(modifier)) if modifier.of_profiles()))
}

/// Text of a modifier of a finite shape, off the origin so that its effect is visible.
fn modifier_text(modifier: &dyn Modifier) -> String {
    let numbers = modifier.params().iter().map(|param| match param.unit {
        Unit::Axis => quoted(AXES[param.default as usize]),
        _ => format!("{}={}", param.name, number(param.default)),
    });
    let words: Vec<String> = std::iter::once(modifier.info().name.to_string()).chain(numbers).collect();
    format!("{} {{\n\t{} {{ at 0.6 0 0 }}\n}}", words.join(" "), finite_shapes().nth(1).unwrap_or_default())
}

/// Texts of finite shapes, with their parameters.
fn finite_shapes() -> impl Iterator<Item = String> {
    let finite = |shape: &&&'static dyn Shape| {
        let params: Vec<f32> = shape.params().iter().map(|param| param.default).collect();
        shape.bounds(&params).is_finite()
    };
    registry::shapes().iter().filter(finite).map(|shape| shape_text(*shape))
}

/// Text of an operator of two finite shapes, the second moved so that the effect is visible.
fn operator_text(word: &str) -> String {
    let mut shapes = finite_shapes();
    let (first, second) = (shapes.next().unwrap_or_default(), shapes.next().unwrap_or_default());
    format!("{word} {{\n\t{first}\n\t{second} {{ at 0.4 0.4 0.4 }}\n}}")
}
