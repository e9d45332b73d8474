//! Objects, shapes and operators.
//!
//! Names, parameters and ranges come from [`pathmarch_field::registry`]; nothing here knows a particular shape.

mod flux;
mod instances;
mod meshes;

use super::arguments::{arguments, missing_arguments, name, properties, string, twice};
use super::context::{Context, Files};
use super::custom_sdf::CustomSdfs;
use super::declarations::Declarations;
use super::materials::Materials;
use super::outlines;
use super::parameters::numbers;
use super::placement::Placements;
use super::settings::Properties;
use super::unexpected::unexpected_node;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::diagnostics::spelling::{listed, nearest};
use crate::language::keywords::{FONT, MATERIAL, MESH, NORMAL, PLACEMENT, POINT, solids};
use crate::language::syntax::MAX_NESTING;
use crate::language::tree::{Entry, Node, Span};
use crate::materials::Material;
use crate::mesh_files::MeshFile;
use crate::scene::Object;
use crate::settings::{self, BLEND, EMITTER, VISIBILITY};
use crate::unit::LengthUnit;
use flux::{FluxError, scale_emission};
use pathmarch_field::Outline;
use pathmarch_field::graph::Kind;
use pathmarch_field::outline::NUMBERS_OF_ARC;
use pathmarch_field::{
    Aabb, Blend, BlendProfile, Field, Modifier, Node as FieldNode, Operator, Placement, ShapeRef, Solid, registry,
};
use std::collections::HashMap;
use std::sync::Arc;

/// More shapes are refused.
pub(crate) const MAX_SHAPES: usize = 100_000;

/// Largest number of segments of all outlines: their tables must fit the memory that a GPU binds at once.
const MAX_SEGMENTS: usize = 100_000;

/// Parameter of modifiers that turn their shapes.
const TURNS: &str = "turns-per-metre";

/// Turns object nodes into objects.
pub(crate) struct Solids<'m> {
    pub(crate) materials: &'m mut Materials,
    /// Shapes that the file declares.
    fields: &'m CustomSdfs,
    files: Files<'m>,
    declared: &'m Declarations<'m>,
    /// True while declarations are checked one by one, without expanding those that they use.
    checking: bool,
    /// Uses of declared shapes that were expanded.
    expanded: usize,
    /// Operators and uses around.
    depth: usize,
    /// Names of the objects so far, and where.
    pub(crate) names: HashMap<String, Span>,
    shapes: usize,
    segments: usize,
    default: Option<u32>,
    /// Mesh files whose materials the scene has, and their indices.
    mesh_materials: Vec<(Arc<MeshFile>, Vec<u32>)>,
    /// Number of operators of profiles around.
    planes: usize,
}

impl<'m> Solids<'m> {
    pub(crate) fn new(
        materials: &'m mut Materials,
        declared: &'m Declarations<'m>,
        fields: &'m CustomSdfs,
        files: Files<'m>,
    ) -> Self {
        Self {
            materials,
            fields,
            files,
            declared,
            checking: false,
            expanded: 0,
            depth: 0,
            names: Default::default(),
            shapes: 0,
            segments: 0,
            default: None,
            mesh_materials: Vec::new(),
            planes: 0,
        }
    }

    /// The index of the default material, which is added at the first call.
    fn default_material(&mut self) -> u32 {
        *self.default.get_or_insert_with(|| {
            self.materials.list.push(Material::default_white());
            self.materials.list.len() as u32 - 1
        })
    }

    /// The material of this entry; 0 after a mistake.
    fn material(&mut self, entry: &Entry, context: &mut Context) -> u32 {
        let Some(name) = string(entry, "`material`", context) else { return 0 };
        if let Some(&index) = self.materials.index.get(name) {
            return index;
        }
        if context.report.is_full() {
            // Nobody will see the nearest name, and to look for it takes time for each of many materials.
            context.report.count();
            return 0;
        }
        let help = match nearest(name, self.materials.index.keys().map(String::as_str)) {
            Some(word) => format!("Did you mean `{word}`?"),
            None => format!("Declare it: material \"{}\" {{ diffuse 0.8 }}.", shown(name).trim_matches('`')),
        };
        let message = format!("There is no material {}.", shown(name));
        let mistake = draft("pathmarch::unknown_material", entry.value_span, message).label("unknown material");
        let mut known: Vec<&str> = self.materials.index.keys().map(String::as_str).collect();
        known.sort_unstable();
        context.report.add(mistake.help(help).expected(known));
        0
    }

    /// An object, where it could be made of something and is not hidden.
    pub(crate) fn object(&mut self, node: &Node, unit: LengthUnit, context: &mut Context) -> Option<Object> {
        let usage = "`object \"name\" { … }`";
        if !node.entries.iter().any(|entry| entry.name.is_none()) {
            missing_arguments(node, usage, context);
        }
        let given = name(node, usage, context);
        if let Some((name, span)) = given {
            match self.names.get(name) {
                Some(&first) => twice(&format!("The object {}", shown(name)), span, first, context),
                None => drop(self.names.insert(name.to_owned(), span)),
            }
        }
        let mut known = vec![MATERIAL];
        known.extend(settings::names(VISIBILITY).into_iter().chain(settings::names(EMITTER)));
        let named = properties(node, &known, context);
        let hidden = Properties::of(VISIBILITY, &named).flag("hidden", context);
        let own = named.iter().find(|(name, _)| *name == MATERIAL);
        let material = own.map(|(_, entry)| self.material(entry, context));
        let mut children = Vec::new();
        for child in node.child_nodes() {
            if PLACEMENT.contains(&&*child.name.value) {
                let message = format!("An object has no `{}` of its own.", child.name.value);
                let mistake = draft("pathmarch::misplaced_node", child.name.span, message).label("not here");
                context.report.add(
                    mistake.help("Put it in the braces of the shape, or put the shapes into a `union { … }` with it."),
                );
            } else {
                children.extend(self.solid(child, material, ("in an object", &[]), context));
            }
        }
        if node.child_nodes().is_empty() && !node.broken() {
            let mistake = draft("pathmarch::no_shapes", node.name.span, "This object has no shape.");
            context.report.add(
                mistake.label("expected a shape in its braces").help("For example: object \"ball\" { sphere 1 }."),
            );
        }
        let mut root = if children.len() > 1 { combined("union", children)? } else { children.pop()? };
        meshes::refuse_combined_triangles(&root, node, context);
        let lumens = Properties::of(EMITTER, &named).number("lumen", context);
        let mut material = material.unwrap_or_else(|| first_tag(&root));
        if let Some(lumens) = lumens.filter(|_| !hidden && !context.report.has_mistakes()) {
            let span =
                named.iter().find(|(name, _)| *name == EMITTER[0].name).map_or(node.name.span, |(_, it)| it.span);
            let scaled = self.scaled_to(lumens, &mut root, unit, span, context);
            material = scaled.get(&material).copied().unwrap_or(material);
        }
        let material = material as usize;
        let object = Object { name: given?.0.to_owned(), material, root };
        (!hidden).then_some(object)
    }

    /// Gives a solid materials that emit this flux; reports where that is not possible. Returns the new materials.
    fn scaled_to(
        &mut self,
        lumens: f32,
        root: &mut FieldNode,
        unit: LengthUnit,
        span: Span,
        context: &mut Context,
    ) -> HashMap<u32, u32> {
        match scale_emission(root, lumens, unit, &mut self.materials.list) {
            Ok(scaled) => return scaled,
            Err(FluxError::Dark) => {
                let message = "`lumen` has no effect: no material of this object emits.";
                let warning = draft("pathmarch::no_effect", span, message).label("no effect");
                let help = "Give it a material that emits: material \"lamp\" { emit 1 0.9 0.8 }.";
                context.report.warn(warning.help(help));
            }
            Err(FluxError::Area(reason)) => {
                let message = format!("The area of this object is not known: {reason}.");
                let mistake = draft("pathmarch::no_flux", span, message).label("not here");
                let help = "Give its material a radiance instead: 1 lm on each m² is a radiance of 0.000466.";
                context.report.add(mistake.help(help));
            }
        }
        HashMap::new()
    }

    /// Reads a shape or an operator; `place` as in "in an object", `others` are further names that are allowed there.
    fn solid(
        &mut self,
        node: &Node,
        material: Option<u32>,
        place: (&str, &[&'static str]),
        context: &mut Context,
    ) -> Option<FieldNode> {
        if self.depth > MAX_NESTING {
            let message = format!("Shapes are nested more than {MAX_NESTING} levels deep.");
            context.report.add(draft("pathmarch::nesting", node.name.span, message).label("one level too many"));
            return None;
        }
        self.depth += 1;
        let solid = self.solid_within(node, material, place, context);
        self.depth -= 1;
        solid
    }

    fn solid_within(
        &mut self,
        node: &Node,
        material: Option<u32>,
        (place, others): (&str, &[&'static str]),
        context: &mut Context,
    ) -> Option<FieldNode> {
        let declared = self.declared;
        match registry::solid(&node.name.value) {
            Some(Solid::Shape(shape)) => self.counted_shape(shape.into(), node, material, context),
            Some(Solid::Operator(operator)) => self.operator(operator, node, material, context),
            Some(Solid::Modifier(modifier)) => self.modifier(modifier, node, material, context),
            None if node.name.value == MESH => self.mesh(node, material, context),
            None => {
                if let Some(shape) = self.fields.shape(&node.name.value) {
                    return self.counted_shape(shape, node, material, context);
                }
                if let Some(index) = declared.find(&node.name.value) {
                    return self.instance(&declared.list[index], node, material, context);
                }
                if !self.fields.is_broken(&node.name.value) {
                    let words = solids().chain(self.fields.names()).chain(others.iter().copied());
                    let known: Vec<&str> = words.map(|word| -> &str { word }).chain(declared.names()).collect();
                    unexpected_node(&node.name, &known, place, context);
                }
                None
            }
        }
    }

    /// A shape, unless there are too many.
    fn counted_shape(
        &mut self,
        shape: ShapeRef,
        node: &Node,
        material: Option<u32>,
        context: &mut Context,
    ) -> Option<FieldNode> {
        self.shapes += 1;
        if self.shapes == MAX_SHAPES + 1 {
            let message = format!("The scene has more than {MAX_SHAPES} shapes.");
            context.report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
        }
        (self.shapes <= MAX_SHAPES).then(|| self.shape(shape, node, material, context))
    }

    fn shape(&mut self, shape: ShapeRef, node: &Node, material: Option<u32>, context: &mut Context) -> FieldNode {
        let info = shape.info();
        if info.profile && self.planes == 0 {
            let message = format!("`{}` is a profile: it has no depth.", info.name);
            let mistake = draft("pathmarch::profile", node.name.span, message).label("not here");
            let operators = registry::modifiers().iter().filter(|modifier| modifier.of_profiles());
            let operators = listed(operators.map(|modifier| &*modifier.info().name), "or");
            context.report.add(mistake.help(format!("Put it into {operators}: extrude 0.2 {{ {} }}.", info.name)));
        }
        let mut known: Vec<&str> = shape.params().iter().map(|param| &*param.name).collect();
        known.push(MATERIAL);
        known.extend((info.outline == Some(Outline::Text)).then_some(FONT));
        let mut named = properties(node, &known, context);
        let own = named.iter().position(|(name, _)| *name == MATERIAL).map(|at| named.swap_remove(at).1);
        let is_font = |(name, _): &(&str, &Entry)| info.outline == Some(Outline::Text) && *name == FONT;
        let font = named.iter().position(is_font).map(|at| named.swap_remove(at).1);
        let tag = match (own, material) {
            (Some(entry), _) => self.material(entry, context),
            (None, Some(material)) => material,
            (None, None) => self.default_material(),
        };
        let mut params = numbers(Solid::Shape(&*shape), node, &named, context);
        match info.outline {
            Some(Outline::Points) => params.extend(outlines::points(node, context)),
            Some(Outline::Text) => params.extend(outlines::text(node, font, &mut self.files, context)),
            Some(Outline::Curve) => params.extend(outlines::curve(node, params[0], context)),
            Some(Outline::Path) => params.extend(outlines::path(node, params[0], context)),
            None => {}
        }
        let numbers = match info.outline {
            Some(Outline::Curve | Outline::Path) => NUMBERS_OF_ARC,
            _ => 4,
        };
        let segments = (params.len() - shape.params().len()) / numbers;
        let fitted = self.segments <= MAX_SEGMENTS;
        self.segments += segments;
        if fitted && self.segments > MAX_SEGMENTS {
            let message = format!("The outlines of the scene have more than {MAX_SEGMENTS} segments.");
            let mistake = draft("pathmarch::too_large", node.name.span, message).label("too many with this");
            context.report.add(mistake.help("Write less: a letter has about a hundred."));
        }
        let has_points = info.outline.is_some_and(Outline::has_points);
        let mut placement = Placements::default();
        for child in node.child_nodes() {
            if placement.take(child, info.facing, context) || has_points && child.name.value == POINT {
                continue;
            }
            let word = &child.name.value;
            if solids().chain(self.fields.names()).any(|solid| solid == word) || self.declared.find(word).is_some() {
                let message = format!("`{}` is a shape and cannot contain others.", info.name);
                let mistake =
                    draft("pathmarch::unexpected_children", child.name.span, message).label("unexpected shape");
                context.report.add(mistake.help("Operators contain shapes, as in `union { … }`."));
            } else if word == NORMAL {
                let message = format!("`{}` faces no direction, so it takes no `{NORMAL}`.", info.name);
                let mistake = draft("pathmarch::misplaced_node", child.name.span, message).label("not here");
                context.report.add(mistake.help("Turn it with `rotate x y z`."));
            } else {
                let facing = info.facing.then_some(NORMAL);
                let points = has_points.then_some(POINT);
                let known: Vec<&str> = PLACEMENT.iter().copied().chain(facing).chain(points).collect();
                unexpected_node(&child.name, &known, &format!("in a `{}`", info.name), context);
            }
        }
        FieldNode { kind: Kind::Shape { shape, params, tag }, placement: placement.value }
    }

    fn operator(
        &mut self,
        operator: &'static dyn Operator,
        node: &Node,
        material: Option<u32>,
        context: &mut Context,
    ) -> Option<FieldNode> {
        let name = &*operator.info().name;
        let blending = if operator.blends() { BLEND } else { &[] };
        let mut known: Vec<&str> = operator.params().iter().map(|param| &*param.name).collect();
        known.extend(settings::names(blending));
        known.push(MATERIAL);
        let mut named = properties(node, &known, context);
        let own = named.iter().position(|(name, _)| *name == MATERIAL).map(|at| named.swap_remove(at).1);
        let material = own.map(|entry| self.material(entry, context)).or(material);
        let smooth = if operator.blends() {
            arguments(node, 0, format_args!("`{name} smooth=0.1 {{ … }}`"), context);
            blend(&named, context)
        } else {
            numbers(Solid::Operator(operator), node, &named, context).first().map(|&amount| amount.into())
        };
        let (placement, children, written) = self.held(node, material, context);
        let (least, most) = operator.children();
        let needs = if least == most { "two" } else { "at least two" };
        if written == 1 && written < least && !node.broken() {
            let mistake = draft("pathmarch::too_few_shapes", node.name.span, format!("`{name}` of a single shape."));
            let what = &*operator.info().doc;
            let help = format!("It needs {needs}: {}{}", what[..1].to_lowercase(), &what[1..]);
            context.report.add(mistake.label("expected another shape in its braces").help(help));
        }
        if let Some(extra) =
            node.child_nodes().iter().filter(|child| !PLACEMENT.contains(&&*child.name.value)).nth(most)
        {
            let message = format!("`{name}` of {written} shapes.");
            let help = "Put shapes that belong together into a `union { … }`.";
            let mistake = draft("pathmarch::too_many_shapes", extra.name.span, message);
            context.report.add(mistake.label(format!("expected {needs}, this is one more")).help(help));
        }
        Some(FieldNode { kind: Kind::Operator { operator, smooth, children }, placement })
    }

    fn modifier(
        &mut self,
        modifier: &'static dyn Modifier,
        node: &Node,
        material: Option<u32>,
        context: &mut Context,
    ) -> Option<FieldNode> {
        let mut known: Vec<&str> = modifier.params().iter().map(|param| &*param.name).collect();
        known.push(MATERIAL);
        let mut named = properties(node, &known, context);
        let own = named.iter().position(|(name, _)| *name == MATERIAL).map(|at| named.swap_remove(at).1);
        let material = own.map(|entry| self.material(entry, context)).or(material);
        let params = numbers(Solid::Modifier(modifier), node, &named, context);
        self.planes += usize::from(modifier.of_profiles());
        let (placement, children, _) = self.held(node, material, context);
        self.planes -= usize::from(modifier.of_profiles());
        if !modifier.in_plane()
            && let Some(profile) = children.iter().find_map(profile)
        {
            let name = &*modifier.info().name;
            let message =
                format!("`{name}` turns its shapes about y, and `{profile}` is a profile in the plane z = 0.");
            let mistake = draft("pathmarch::out_of_plane", node.name.span, message).label("not of a profile");
            context.report.add(mistake.help(format!("Put it around the whole: {name} {{ extrude {{ {profile} }} }}.")));
            return None;
        }
        if modifier.needs_bounds() {
            let bounds: Vec<Aabb> =
                children.iter().map(|child| Field::new(std::slice::from_ref(child)).bounds()).collect();
            // That a profile has no end along z does not matter within its plane.
            let is_endless = |(child, bounds): &(&FieldNode, &Aabb)| {
                let axes = if profile(child).is_some() { 2 } else { 3 };
                (0..axes).any(|k| !bounds.min[k].is_finite() || !bounds.max[k].is_finite())
            };
            if let Some((endless, _)) = children.iter().zip(&bounds).find(is_endless) {
                let what = first_name(endless);
                let message = format!("`{what}` is infinite, and `{}` needs finite shapes.", modifier.info().name);
                let mistake = draft("pathmarch::endless", node.name.span, message).label("not of something endless");
                context.report.add(mistake.help("Cut it first: intersect { box 10 1 10; … }."));
                return None;
            }
            if let Some(at) = modifier.params().iter().position(|param| param.name == TURNS) {
                warn_of_degrees(node, params[at], &bounds, context);
            }
        }
        Some(FieldNode { kind: Kind::Modifier { modifier, params, children }, placement })
    }

    /// Reads the braces of an operator: its placement, its shapes, and the number of nodes written for them.
    fn held(
        &mut self,
        node: &Node,
        material: Option<u32>,
        context: &mut Context,
    ) -> (Placement, Vec<FieldNode>, usize) {
        let name = &node.name.value;
        let mut placement = Placements::default();
        let mut children = Vec::new();
        let mut written = 0;
        let place = format!("in a `{name}`");
        for child in node.child_nodes() {
            if !placement.take(child, false, context) {
                written += 1;
                children.extend(self.solid(child, material, (&place, PLACEMENT), context));
            }
        }
        if written == 0 && !node.broken() {
            let message = format!("`{name}` without shapes.");
            let mistake = draft("pathmarch::too_few_shapes", node.name.span, message);
            context.report.add(mistake.label("expected shapes in its braces"));
        }
        (placement.value, children, written)
    }
}

/// Warns of a twist or bend of shapes with these bounds whose number was most likely meant in degrees: it makes many turns
/// within their own width.
fn warn_of_degrees(node: &Node, turns_per_metre: f32, bounds: &[Aabb], context: &mut Context) {
    const MANY_TURNS: f32 = 8.0;
    let is_wide = |inside: &Aabb| {
        let reach = [0, 2].map(|axis| inside.min[axis].abs().max(inside.max[axis].abs()));
        inside.is_finite() && turns_per_metre.abs() * reach[0].max(reach[1]) > MANY_TURNS
    };
    if bounds.iter().any(is_wide) {
        let message = format!("A `{}` of {turns_per_metre} turns within each metre.", node.name.value);
        let warning = draft("pathmarch::many_turns", node.name.span, message).label("are these degrees?");
        let turns = turns_per_metre / 360.0;
        let help = format!("The number is in turns per metre: {turns_per_metre}° per metre are {turns:.3}.");
        context.report.warn(warning.help(help));
    }
}

/// Blend of an operator, by its properties; sharp after a mistake.
fn blend(named: &[(&str, &Entry)], context: &mut Context) -> Option<Blend> {
    let properties = Properties::of(BLEND, named);
    let amount = properties.number("smooth", context);
    let profile = properties.choice("profile", context);
    let steps = properties.whole("steps", context);
    let amount = amount.filter(|width| *width > 0.0)?;
    let profile = BlendProfile::ALL.into_iter().find(|known| Some(known.name()) == profile)?;
    Some(Blend { amount, profile, steps: steps? as f32 })
}

/// Name of the first profile that no operator makes solid.
fn profile(node: &FieldNode) -> Option<&str> {
    match &node.kind {
        Kind::Shape { shape, .. } => Some(shape.info()).filter(|info| info.profile).map(|info| &*info.name),
        Kind::Modifier { modifier, .. } if modifier.of_profiles() => None,
        Kind::Operator { children, .. } | Kind::Modifier { children, .. } => children.iter().find_map(profile),
    }
}

/// Name of the outermost shape or operator.
fn first_name(node: &FieldNode) -> &str {
    match &node.kind {
        Kind::Shape { shape, .. } => &shape.info().name,
        Kind::Operator { operator, .. } => &operator.info().name,
        Kind::Modifier { modifier, .. } => &modifier.info().name,
    }
}

/// The nodes under one of the registry's operators.
fn combined(operator: &str, children: Vec<FieldNode>) -> Option<FieldNode> {
    let operator = registry::operator(operator)?;
    Some(FieldNode { kind: Kind::Operator { operator, smooth: None, children }, placement: Placement::default() })
}

/// The material of the first shape.
fn first_tag(node: &FieldNode) -> u32 {
    match &node.kind {
        Kind::Shape { tag, .. } => *tag,
        Kind::Operator { children, .. } | Kind::Modifier { children, .. } => children.first().map_or(0, first_tag),
    }
}
