//! What may be added to a scene, and how it is written at first: valid, in sight, and short.

use super::control::{Addition, Group};
use super::error::EditError;
use super::kinds::required;
use super::layout::Chunk;
use super::number::{number, quoted, string_like};
use super::outline::ItemKind;
use super::path::Path;
use super::slots::{SKIES, interned, text_argument};
use super::structure::free_name;
use super::work::Work;
use crate::language::declared::SHAPE;
use crate::language::fields::FIELD;
use crate::language::include::INCLUDE;
use crate::language::params::PARAM;
use crate::language::schema::{self, AXES};
use crate::materials;
use crate::text::DEFAULT_TEXT;
use pathmarch_field::Outline;
use pathmarch_field::{Modifier, Shape, Solid, Unit, registry};

/// What may be added to a node of this kind, or to the file.
pub(super) fn additions(work: &Work, parent: Option<ItemKind>) -> Vec<Addition> {
    let shapes = |group| {
        work.fields()
            .all_shapes()
            .map(move |shape| addition(group, interned(&shape.info().name), interned(&shape.info().doc)))
    };
    let operators = registry::solids().filter(|solid| solid.is_operator());
    match parent {
        Some(kind) if kind.holds_shapes() => declared(work)
            .chain(shapes(Group::Shape))
            .chain(operators.map(|op| addition(Group::Operator, &op.info().name, &op.info().doc)))
            .collect(),
        Some(_) => Vec::new(),
        None => {
            let has = |word: &str| work.file.nodes.iter().any(|node| node.name.value == word);
            let mut all: Vec<Addition> = shapes(Group::Object).collect();
            all.extend(materials::kinds().iter().map(|kind| addition(Group::Material, kind.name, kind.doc)));
            all.push(addition(Group::Light, "sun", "Light from far away."));
            all.push(addition(Group::Light, "point", "Light from a point, the same in every direction."));
            all.push(addition(Group::Camera, "camera", "Another point of view."));
            if !has("sky") {
                let forms = SKIES.iter().filter(|(name, _)| *name != "picture");
                all.extend(forms.map(|(name, doc)| addition(Group::Sky, name, doc)));
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
fn declared(work: &Work) -> impl Iterator<Item = Addition> {
    let values = work.values();
    let shapes = work.file.nodes.iter().chain(values.included.iter()).filter(|node| node.name.value == SHAPE);
    let names: Vec<&'static str> = shapes.filter_map(text_argument).map(interned).collect();
    names.into_iter().map(|name| addition(Group::Shape, name, "A shape that this file declares or includes."))
}

fn addition(group: Group, name: &'static str, doc: &'static str) -> Addition {
    Addition { group, name, doc }
}

/// Adds something to a node, or to the file.
pub(super) fn add(work: &mut Work, parent: Option<&Path>, addition: &Addition) -> Result<Path, EditError> {
    let kind = parent.map(|parent| work.find(parent).map(|found| found.kind)).transpose()?;
    if !additions(work, kind).contains(addition) {
        let name = addition.name;
        return Err(EditError::NotHere(format!("`{name}` cannot be added here, or there is one already.")));
    }
    let word = addition.name;
    let (node, text) = match addition.group {
        Group::Shape | Group::Operator => {
            let text = match work.fields().solid(word) {
                Some(Solid::Shape(shape)) if is_in_plane(work, parent) => shape_text(shape),
                Some(Solid::Shape(shape)) => solid_text(shape),
                Some(Solid::Modifier(modifier)) => modifier_text(modifier),
                None => string_like(word, ""),
                _ => operator_text(word),
            };
            let chunk = Chunk::new(&text, work.style);
            return work.put_in(parent, usize::MAX, &chunk);
        }
        Group::Object => {
            let name = quoted(&free_name(work, "object", word));
            let shape = match work.fields().solid(word) {
                Some(Solid::Shape(shape)) => solid_text(shape),
                _ => String::new(),
            };
            ("object", format!("object {name} {{ {shape} }}"))
        }
        Group::Material => {
            let name = quoted(&free_name(work, "material", word));
            let first = materials::kind(word).and_then(|kind| kind.params.first());
            let [r, g, b] = first.map_or([0.0; 3], |param| param.default);
            let value = match first {
                None => String::new(),
                Some(_) if r == g && g == b => format!(" {}", number(r)),
                Some(param) if param.kind == materials::ParamKind::Number => format!(" {}", number(r)),
                Some(_) => format!(" {} {} {}", number(r), number(g), number(b)),
            };
            ("material", format!("material {name} {{ {word}{value} }}"))
        }
        Group::Light if word == "sun" => ("sun", format!("sun {{ {} }}", required(schema::SUN, "; "))),
        Group::Light => ("point", format!("point {{ {} }}", required(schema::POINT, "; "))),
        Group::Camera => {
            let name = quoted(&free_name(work, "camera", "camera"));
            ("camera", format!("camera {name} {{\n\t{}\n}}", required(schema::CAMERA, "\n\t")))
        }
        Group::Sky => match word {
            "gradient" => ("sky", format!("sky \"gradient\" {{ {} }}", required(schema::GRADIENT, "; "))),
            "day" => ("sky", "sky \"day\"".to_owned()),
            _ => ("sky", "sky 0.5".to_owned()),
        },
        Group::Param => (PARAM, format!("{PARAM} {} 1 min=0 max=2", quoted(&free_name(work, PARAM, "amount")))),
        Group::Render => {
            let words = schema::RENDER.iter().take(2).map(|setting| setting.example);
            ("render", format!("render {{ {} }}", words.collect::<Vec<_>>().join("; ")))
        }
    };
    add_top(work, node, &text)
}

/// Adds a node at the top of the file, behind the others of its word, or where files have such nodes.
pub(super) fn add_top(work: &mut Work, word: &str, template: &str) -> Result<Path, EditError> {
    const ORDER: [&str; 11] =
        ["pathmarch", INCLUDE, PARAM, "camera", "render", "sky", "sun", "material", FIELD, SHAPE, "object"];
    let rank = |word: &str| {
        let word = if word == "point" { "sun" } else { word };
        ORDER.iter().position(|other| *other == word).unwrap_or(ORDER.len())
    };
    let nodes = &work.file.nodes;
    let before = nodes.iter().rposition(|node| rank(&node.name.value) <= rank(word));
    let alike = before.is_some_and(|index| {
        let node = &nodes[index];
        let one_line = !work.text[super::layout::bytes(node.whole)].contains('\n') && !template.contains('\n');
        rank(&node.name.value) == rank(word) && one_line
    });
    let chunk = Chunk::new(template, work.style).apart(!alike);
    work.put_in(None, before.map_or(0, |index| index + 1), &chunk)
}

/// A shape with its numbers and, if it is drawn, something to change.
fn shape_text(shape: &dyn Shape) -> String {
    let name = &shape.info().name;
    match shape.info().outline {
        Some(Outline::Points) => return format!("{name} {{ point -0.5 -0.4; point 0.5 -0.4; point 0 0.5 }}"),
        Some(Outline::Text) => return format!("{name} {}", quoted(DEFAULT_TEXT)),
        None => {}
    }
    let numbers = shape.params().iter().map(|param| number(param.default));
    std::iter::once(shape.info().name.to_string()).chain(numbers).collect::<Vec<_>>().join(" ")
}

/// A shape with its numbers, with a depth if it has none of its own.
fn solid_text(shape: &dyn Shape) -> String {
    let text = shape_text(shape);
    if shape.info().profile { format!("extrude 0.25 {{ {text} }}") } else { text }
}

/// Whether a node, or what it stands in, makes solids of profiles.
fn is_in_plane(work: &Work, node: Option<&Path>) -> bool {
    let around = std::iter::successors(node.cloned(), Path::parent);
    let words = around.filter_map(|path| Some(work.find(&path).ok()?.node.name.value.to_string()));
    words
        .into_iter()
        .any(|word| matches!(registry::solid(&word), Some(Solid::Modifier(modifier)) if modifier.of_profiles()))
}

/// A modifier of a shape that has an end, off the middle so that it shows what the modifier does.
fn modifier_text(modifier: &dyn Modifier) -> String {
    let numbers = modifier.params().iter().map(|param| match param.unit {
        Unit::Axis => quoted(AXES[param.default as usize]),
        _ => format!("{}={}", param.name, number(param.default)),
    });
    let words: Vec<String> = std::iter::once(modifier.info().name.to_string()).chain(numbers).collect();
    format!("{} {{\n\t{} {{ at 0.6 0 0 }}\n}}", words.join(" "), finite_shapes().nth(1).unwrap_or_default())
}

/// Shapes that have an end, with their numbers.
fn finite_shapes() -> impl Iterator<Item = String> {
    let finite = |shape: &&&'static dyn Shape| {
        let params: Vec<f32> = shape.params().iter().map(|param| param.default).collect();
        shape.bounds(&params).is_finite()
    };
    registry::shapes().iter().filter(finite).map(|shape| shape_text(*shape))
}

/// An operator of two shapes that have an end, the second moved so that it shows what the operator does.
fn operator_text(word: &str) -> String {
    let mut shapes = finite_shapes();
    let (first, second) = (shapes.next().unwrap_or_default(), shapes.next().unwrap_or_default());
    format!("{word} {{\n\t{first}\n\t{second} {{ at 0.4 0.4 0.4 }}\n}}")
}
