//! Objects, shapes and operators.
//!
//! Names, parameters and ranges come from [`pathmarch_field::registry`]; nothing here knows a shape.

use super::arguments::{accepted, arguments, missing_arguments, name, properties, string, twice};
use super::declared::{Declaration, Declarations, MATERIAL, given_entries};
use super::drawings::{self, Files};
use super::fields::Fields;
use super::names::{NORMAL, PLACEMENT, POINT, listed, nearest, solids, unexpected_node};
use super::params::{self, Given, PARAM};
use super::report::{Report, draft, shown};
use super::schema::{self, AXES, FONT, Properties, single, triple};
use super::surfaces::Materials;
use super::syntax::MAX_NESTING;
use super::tree::{Entry, Node, Span};
use crate::assets::Assets;
use crate::materials::Material;
use crate::scene::Object;
use pathmarch_field::Outline;
use pathmarch_field::graph::Kind;
use pathmarch_field::{
    Blend, BlendProfile, Field, Modifier, Node as FieldNode, Operator, Param, Placement, ShapeRef, Solid, Unit,
    registry,
};

/// More shapes are refused.
pub(crate) const MAX_SHAPES: usize = 100_000;

/// More segments of all that is drawn are refused: their tables must fit the memory that a GPU binds at once.
const MAX_SEGMENTS: usize = 100_000;

/// Turns object nodes into objects.
pub(crate) struct Solids<'m> {
    pub(crate) materials: &'m mut Materials,
    /// Shapes that the file declares.
    fields: &'m Fields,
    files: Files<'m>,
    declared: &'m Declarations<'m>,
    /// Whether declarations are read by themselves, so that those that they use are not expanded.
    checking: bool,
    /// Uses of declared shapes that were expanded.
    expanded: usize,
    /// Operators and uses around.
    depth: usize,
    /// Names of the objects so far, and where.
    pub(crate) names: std::collections::HashMap<String, Span>,
    shapes: usize,
    segments: usize,
    default: Option<u32>,
    /// How many operators of profiles are around.
    planes: usize,
}

impl<'m> Solids<'m> {
    pub(super) fn new(
        materials: &'m mut Materials,
        declared: &'m Declarations<'m>,
        fields: &'m Fields,
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
            planes: 0,
        }
    }

    /// Reads every declaration by itself, with its parameters as they are declared; says which are sound.
    pub(crate) fn check(
        materials: &mut Materials,
        declared: &mut Declarations,
        fields: &Fields,
        (scene, assets): (&str, &mut Assets),
        report: &mut Report,
    ) {
        let mut sound = Vec::new();
        let animated = report.scope.animated;
        for declaration in &declared.list {
            let before = report.count_so_far();
            let files = Files { scene, assets: &mut *assets };
            let mut solids = Solids { checking: true, planes: 1, ..Solids::new(materials, declared, fields, files) };
            if declaration.node.child_nodes().iter().all(|child| child.name.value == PARAM)
                && !declaration.node.broken()
            {
                let message = "This shape holds nothing.";
                let mistake = draft("pathmarch::no_shapes", declaration.node.name.span, message);
                let help = "For example: shape \"pin\" { param length 1; cylinder 0.1 length }.";
                report.add(mistake.label("expected a shape in its braces").help(help));
            }
            solids.body(declaration, &[], Some(0), report);
            sound.push(declaration.sound && report.count_so_far() == before && !declaration.node.broken());
        }
        report.scope.animated = animated;
        for (declaration, sound) in declared.list.iter_mut().zip(sound) {
            declaration.sound = sound;
        }
        declared.spread();
    }

    /// What a declared shape holds, with these values of its parameters.
    fn body(
        &mut self,
        declaration: &Declaration,
        given: &[(&str, Given)],
        material: Option<u32>,
        report: &mut Report,
    ) -> Vec<FieldNode> {
        let outside = report.scope.enter();
        let nodes = declaration.node.child_nodes();
        params::declare(params::nodes(nodes), given, &[MATERIAL], report);
        let mut children = Vec::new();
        for child in nodes.iter().filter(|child| child.name.value != PARAM) {
            if PLACEMENT.contains(&&*child.name.value) {
                let message = format!("A declared shape has no `{}` of its own.", child.name.value);
                let mistake = draft("pathmarch::misplaced_node", child.name.span, message).label("not here");
                report.add(mistake.help("Put it where the shape is used, or in the braces of what it holds."));
            } else {
                children.extend(self.solid(child, material, ("in a declared shape", &[PARAM]), report));
            }
        }
        report.scope.leave(outside);
        children
    }

    /// A use of a declared shape.
    fn instance(
        &mut self,
        declaration: &Declaration,
        node: &Node,
        material: Option<u32>,
        report: &mut Report,
    ) -> Option<FieldNode> {
        let mut known = declaration.params.clone();
        known.push(MATERIAL);
        let mut named = properties(node, &known, report);
        let own = named.iter().position(|(name, _)| *name == MATERIAL).map(|at| named.swap_remove(at).1);
        let material = own.map(|entry| self.material(entry, report)).or(material);
        let entries = given_entries(declaration, node, named, report);
        let given = params::given(&entries, report);
        let mut placement = Placements::default();
        for child in node.child_nodes() {
            if !placement.take(child, false, report) {
                unexpected_node(&child.name, PLACEMENT, &format!("in a `{}`", declaration.name), report);
            }
        }
        let placement = placement.value;
        if self.checking {
            // Something of the kind, for what looks at it.
            let shape = registry::shape("sphere")?;
            let params = shape.params().iter().map(|param| param.default).collect();
            return Some(FieldNode { kind: Kind::Shape { shape: shape.into(), params, tag: 0 }, placement });
        }
        self.expanded += 1;
        if self.expanded == MAX_SHAPES + 1 {
            let message = format!("The scene uses declared shapes more than {MAX_SHAPES} times.");
            report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
        }
        if !declaration.sound || self.expanded > MAX_SHAPES || self.shapes > MAX_SHAPES {
            return None;
        }
        let outermost = report.within.is_none();
        if outermost {
            report.within = Some((node.name.span, "used here".to_owned()));
        }
        let mut children = self.body(declaration, &given, material, report);
        if outermost {
            report.within = None;
        }
        match &mut children[..] {
            [] => None,
            [only] if only.placement == Placement::default() => {
                only.placement = placement;
                children.pop()
            }
            [_] if placement == Placement::default() => children.pop(),
            _ => Some(FieldNode { placement, ..combined("union", children)? }),
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
    fn material(&mut self, entry: &Entry, report: &mut Report) -> u32 {
        let Some(name) = string(entry, "`material`", report) else { return 0 };
        if let Some(&index) = self.materials.index.get(name) {
            return index;
        }
        let help = match nearest(name, self.materials.index.keys().map(String::as_str)) {
            Some(word) => format!("Did you mean `{word}`?"),
            None => format!("Declare it: material \"{}\" {{ diffuse 0.8 }}.", shown(name).trim_matches('`')),
        };
        let message = format!("There is no material {}.", shown(name));
        report
            .add(draft("pathmarch::unknown_material", entry.value_span, message).label("unknown material").help(help));
        0
    }

    /// An object, where it could be made of something.
    pub(crate) fn object(&mut self, node: &Node, report: &mut Report) -> Option<Object> {
        let usage = "`object \"name\" { … }`";
        if !node.entries.iter().any(|entry| entry.name.is_none()) {
            missing_arguments(node, usage, report);
        }
        let given = name(node, usage, report);
        if let Some((name, span)) = given {
            match self.names.get(name) {
                Some(&first) => twice(&format!("The object {}", shown(name)), span, first, report),
                None => drop(self.names.insert(name.to_owned(), span)),
            }
        }
        let material = properties(node, &["material"], report).first().map(|(_, entry)| self.material(entry, report));
        let mut children = Vec::new();
        for child in node.child_nodes() {
            if PLACEMENT.contains(&&*child.name.value) {
                let message = format!("An object has no `{}` of its own.", child.name.value);
                let mistake = draft("pathmarch::misplaced_node", child.name.span, message).label("not here");
                report.add(
                    mistake.help("Put it in the braces of the shape, or put the shapes into a `union { … }` with it."),
                );
            } else {
                children.extend(self.solid(child, material, ("in an object", &[]), report));
            }
        }
        if node.child_nodes().is_empty() && !node.broken() {
            let mistake = draft("pathmarch::no_shapes", node.name.span, "This object has no shape.");
            report.add(
                mistake.label("expected a shape in its braces").help("For example: object \"ball\" { sphere 1 }."),
            );
        }
        let root = if children.len() > 1 { combined("union", children)? } else { children.pop()? };
        let material = material.unwrap_or_else(|| first_tag(&root)) as usize;
        Some(Object { name: given?.0.to_owned(), material, root })
    }

    /// A shape or an operator; `place` says where it stands, `others` what else may stand there.
    fn solid(
        &mut self,
        node: &Node,
        material: Option<u32>,
        place: (&str, &[&'static str]),
        report: &mut Report,
    ) -> Option<FieldNode> {
        if self.depth > MAX_NESTING {
            let message = format!("Shapes are nested more than {MAX_NESTING} levels deep.");
            report.add(draft("pathmarch::nesting", node.name.span, message).label("one level too many"));
            return None;
        }
        self.depth += 1;
        let solid = self.solid_within(node, material, place, report);
        self.depth -= 1;
        solid
    }

    fn solid_within(
        &mut self,
        node: &Node,
        material: Option<u32>,
        (place, others): (&str, &[&'static str]),
        report: &mut Report,
    ) -> Option<FieldNode> {
        let declared = self.declared;
        match registry::solid(&node.name.value) {
            Some(Solid::Shape(shape)) => self.counted_shape(shape.into(), node, material, report),
            Some(Solid::Operator(operator)) => self.operator(operator, node, material, report),
            Some(Solid::Modifier(modifier)) => self.modifier(modifier, node, material, report),
            None => {
                if let Some(shape) = self.fields.shape(&node.name.value) {
                    return self.counted_shape(shape, node, material, report);
                }
                if let Some(index) = declared.find(&node.name.value) {
                    return self.instance(&declared.list[index], node, material, report);
                }
                if !self.fields.is_broken(&node.name.value) {
                    let words = solids().chain(self.fields.names()).chain(others.iter().copied());
                    let known: Vec<&str> = words.map(|word| -> &str { word }).chain(declared.names()).collect();
                    unexpected_node(&node.name, &known, place, report);
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
        report: &mut Report,
    ) -> Option<FieldNode> {
        self.shapes += 1;
        if self.shapes == MAX_SHAPES + 1 {
            let message = format!("The scene has more than {MAX_SHAPES} shapes.");
            report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
        }
        (self.shapes <= MAX_SHAPES).then(|| self.shape(shape, node, material, report))
    }

    fn shape(&mut self, shape: ShapeRef, node: &Node, material: Option<u32>, report: &mut Report) -> FieldNode {
        let info = shape.info();
        if info.profile && self.planes == 0 {
            let message = format!("`{}` is a profile: it has no depth.", info.name);
            let mistake = draft("pathmarch::profile", node.name.span, message).label("not here");
            let operators = registry::modifiers().iter().filter(|modifier| modifier.of_profiles());
            let operators = listed(operators.map(|modifier| &*modifier.info().name), "or");
            report.add(mistake.help(format!("Put it into {operators}: extrude 0.2 {{ {} }}.", info.name)));
        }
        let mut known: Vec<&str> = shape.params().iter().map(|param| &*param.name).collect();
        known.push("material");
        known.extend((info.outline == Some(Outline::Text)).then_some(FONT));
        let mut named = properties(node, &known, report);
        let own = named.iter().position(|(name, _)| *name == "material").map(|at| named.swap_remove(at).1);
        let is_font = |(name, _): &(&str, &Entry)| info.outline == Some(Outline::Text) && *name == FONT;
        let font = named.iter().position(is_font).map(|at| named.swap_remove(at).1);
        let tag = match (own, material) {
            (Some(entry), _) => self.material(entry, report),
            (None, Some(material)) => material,
            (None, None) => self.default_material(),
        };
        let mut params = numbers(Solid::Shape(&*shape), node, &named, report);
        match info.outline {
            Some(Outline::Points) => params.extend(drawings::points(node, report)),
            Some(Outline::Text) => params.extend(drawings::text(node, font, &mut self.files, report)),
            None => {}
        }
        let segments = (params.len() - shape.params().len()) / 4;
        let fitted = self.segments <= MAX_SEGMENTS;
        self.segments += segments;
        if fitted && self.segments > MAX_SEGMENTS {
            let message = format!("The outlines of the scene have more than {MAX_SEGMENTS} segments.");
            let mistake = draft("pathmarch::too_large", node.name.span, message).label("too many with this");
            report.add(mistake.help("Write less: a letter has about a hundred."));
        }
        let has_points = info.outline == Some(Outline::Points);
        let mut placement = Placements::default();
        for child in node.child_nodes() {
            if placement.take(child, info.facing, report) || has_points && child.name.value == POINT {
                continue;
            }
            let word = &child.name.value;
            if solids().chain(self.fields.names()).any(|solid| solid == word) || self.declared.find(word).is_some() {
                let message = format!("`{}` is a shape and holds no others.", info.name);
                let mistake =
                    draft("pathmarch::unexpected_children", child.name.span, message).label("unexpected shape");
                report.add(mistake.help("Operators hold shapes, as in `union { … }`."));
            } else if word == NORMAL {
                let message = format!("`{}` faces nowhere and has no `{NORMAL}`.", info.name);
                let mistake = draft("pathmarch::misplaced_node", child.name.span, message).label("not here");
                report.add(mistake.help("Turn it with `rotate x y z`."));
            } else {
                let facing = info.facing.then_some(NORMAL);
                let points = has_points.then_some(POINT);
                let known: Vec<&str> = PLACEMENT.iter().copied().chain(facing).chain(points).collect();
                unexpected_node(&child.name, &known, &format!("in a `{}`", info.name), report);
            }
        }
        FieldNode { kind: Kind::Shape { shape, params, tag }, placement: placement.value }
    }

    fn operator(
        &mut self,
        operator: &'static dyn Operator,
        node: &Node,
        material: Option<u32>,
        report: &mut Report,
    ) -> Option<FieldNode> {
        let name = &*operator.info().name;
        let blending = if operator.blends() { schema::BLEND } else { &[] };
        let mut known: Vec<&str> = operator.params().iter().map(|param| &*param.name).collect();
        known.extend(schema::names(blending));
        known.push("material");
        let mut named = properties(node, &known, report);
        let own = named.iter().position(|(name, _)| *name == "material").map(|at| named.swap_remove(at).1);
        let material = own.map(|entry| self.material(entry, report)).or(material);
        let smooth = if operator.blends() {
            arguments(node, 0, &format!("`{name} smooth=0.1 {{ … }}`"), report);
            blend(&named, report)
        } else {
            numbers(Solid::Operator(operator), node, &named, report).first().map(|&amount| amount.into())
        };
        let (placement, children, written) = self.held(node, material, report);
        let (least, most) = operator.children();
        let needs = if least == most { "two" } else { "at least two" };
        if written == 1 && written < least && !node.broken() {
            let mistake = draft("pathmarch::too_few_shapes", node.name.span, format!("`{name}` of a single shape."));
            let what = &*operator.info().doc;
            let help = format!("It needs {needs}: {}{}", what[..1].to_lowercase(), &what[1..]);
            report.add(mistake.label("expected another shape in its braces").help(help));
        }
        if let Some(extra) =
            node.child_nodes().iter().filter(|child| !PLACEMENT.contains(&&*child.name.value)).nth(most)
        {
            let message = format!("`{name}` of {written} shapes.");
            let help = "Put shapes that belong together into a `union { … }`.";
            let mistake = draft("pathmarch::too_many_shapes", extra.name.span, message);
            report.add(mistake.label(format!("expected {needs}, this is one more")).help(help));
        }
        Some(FieldNode { kind: Kind::Operator { operator, smooth, children }, placement })
    }

    fn modifier(
        &mut self,
        modifier: &'static dyn Modifier,
        node: &Node,
        material: Option<u32>,
        report: &mut Report,
    ) -> Option<FieldNode> {
        let mut known: Vec<&str> = modifier.params().iter().map(|param| &*param.name).collect();
        known.push("material");
        let mut named = properties(node, &known, report);
        let own = named.iter().position(|(name, _)| *name == "material").map(|at| named.swap_remove(at).1);
        let material = own.map(|entry| self.material(entry, report)).or(material);
        let params = numbers(Solid::Modifier(modifier), node, &named, report);
        self.planes += usize::from(modifier.of_profiles());
        let (placement, children, _) = self.held(node, material, report);
        self.planes -= usize::from(modifier.of_profiles());
        if !modifier.in_plane()
            && let Some(profile) = children.iter().find_map(profile)
        {
            let name = &*modifier.info().name;
            let message =
                format!("`{name}` turns what it holds about y, and `{profile}` is a profile in the plane z = 0.");
            let mistake = draft("pathmarch::out_of_plane", node.name.span, message).label("not of a profile");
            report.add(mistake.help(format!("Put it around the whole: {name} {{ extrude {{ {profile} }} }}.")));
            return None;
        }
        // That a profile has no end along z does not matter within its plane.
        let is_endless = |child: &&FieldNode| {
            let bounds = Field::new(std::slice::from_ref(*child)).bounds();
            let axes = if profile(child).is_some() { 2 } else { 3 };
            (0..axes).any(|k| !bounds.min[k].is_finite() || !bounds.max[k].is_finite())
        };
        if modifier.needs_bounds()
            && let Some(endless) = children.iter().find(is_endless)
        {
            let what = first_name(endless);
            let message =
                format!("`{what}` has no end, and `{}` needs what it holds to have one.", modifier.info().name);
            let mistake = draft("pathmarch::endless", node.name.span, message).label("not of something endless");
            report.add(mistake.help("Cut it first: intersect { box 10 1 10; … }."));
            return None;
        }
        Some(FieldNode { kind: Kind::Modifier { modifier, params, children }, placement })
    }

    /// What stands in the braces of an operator: where it stands, and what it holds; and of how many that is of.
    fn held(&mut self, node: &Node, material: Option<u32>, report: &mut Report) -> (Placement, Vec<FieldNode>, usize) {
        let name = &node.name.value;
        let mut placement = Placements::default();
        let mut children = Vec::new();
        let mut written = 0;
        let place = format!("in a `{name}`");
        for child in node.child_nodes() {
            if !placement.take(child, false, report) {
                written += 1;
                children.extend(self.solid(child, material, (&place, PLACEMENT), report));
            }
        }
        if written == 0 && !node.broken() {
            let message = format!("`{name}` of nothing.");
            let mistake = draft("pathmarch::too_few_shapes", node.name.span, message);
            report.add(mistake.label("expected shapes in its braces"));
        }
        (placement.value, children, written)
    }
}

/// How an operator blends, by its properties; sharp after a mistake.
fn blend(named: &[(&str, &Entry)], report: &mut Report) -> Option<Blend> {
    let properties = Properties::of(schema::BLEND, named);
    let amount = properties.number("smooth", report);
    let profile = properties.choice("profile", "profile of blends", &BlendProfile::ALL, BlendProfile::name, report);
    let steps = properties.whole("steps", report);
    let amount = amount.filter(|width| *width > 0.0)?;
    Some(Blend { amount, profile: profile?, steps: steps? as f32 })
}

/// What the first profile of a solid is called, of those that nothing makes solid.
fn profile(node: &FieldNode) -> Option<&str> {
    match &node.kind {
        Kind::Shape { shape, .. } => Some(shape.info()).filter(|info| info.profile).map(|info| &*info.name),
        Kind::Modifier { modifier, .. } if modifier.of_profiles() => None,
        Kind::Operator { children, .. } | Kind::Modifier { children, .. } => children.iter().find_map(profile),
    }
}

/// What the first endless solid is called.
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

/// The numbers of a shape or an operator: arguments in order, or by name; one size for several where it allows it.
fn numbers(solid: Solid, node: &Node, named: &[(&str, &Entry)], report: &mut Report) -> Vec<f32> {
    let all = solid.params();
    let sizes = solid.info().size_params;
    // The argument of a text is its words.
    let is_text = solid.info().outline == Some(Outline::Text);
    let entries = if is_text { Vec::new() } else { arguments(node, all.len(), &usage(solid), report) };
    let mut given: Vec<Option<&Entry>> = vec![None; all.len()];
    let size_named = named.iter().any(|(name, _)| all[..sizes].iter().any(|param| &*param.name == *name));
    let one_size = sizes > 1 && !size_named && (1..sizes).contains(&entries.len());
    // One size stands for `sizes` parameters; the arguments after it are the parameters after those.
    let slots = if one_size { sizes - 1..all.len() } else { 0..all.len() };
    if one_size && entries.len() > slots.len() {
        let span = entries[0].span.to(entries[entries.len() - 1].span);
        let message = format!("`{}` has one size or {sizes}, not {}.", solid.info().name, entries.len());
        let mistake = draft("pathmarch::missing_argument", span, message).label(format!("expected {}", usage(solid)));
        report.add(mistake);
        return all.iter().map(|param| param.default).collect();
    }
    for (slot, entry) in slots.zip(&entries) {
        given[slot] = Some(entry);
    }
    for (name, entry) in named {
        let Some(slot) = all.iter().position(|param| &*param.name == *name) else { continue };
        match given[slot] {
            Some(first) => twice(&format!("`{name}`"), entry.span, first.span, report),
            None => given[slot] = Some(entry),
        }
    }
    let mut values: Vec<f32> = all
        .iter()
        .zip(given)
        .map(|(param, entry)| entry.and_then(|entry| number(param, entry, report)).unwrap_or(param.default))
        .collect();
    if one_size {
        let size = values[sizes - 1];
        values[..sizes].fill(size);
    }
    values
}

pub(super) fn number(param: &Param, entry: &Entry, report: &mut Report) -> Option<f32> {
    let what = format!("`{}`", param.name);
    if param.unit == Unit::Axis {
        let word = string(entry, &what, report)?;
        let axis = AXES.iter().position(|axis| *axis == word);
        if axis.is_none() {
            let mistake =
                draft("pathmarch::unknown_axis", entry.value_span, format!("There is no axis {}.", shown(word)));
            report.add(mistake.label("unknown axis").help("Expected \"x\", \"y\" or \"z\"."));
        }
        return axis.map(|axis| axis as f32);
    }
    let accepts = |value: f32| param.accepts(value) && (param.unit != Unit::Count || value.fract() == 0.0);
    accepted(entry, &what, accepts, || param.range_in_words(), report)
}

/// As in "`box x y z`".
fn usage(solid: Solid) -> String {
    let info = solid.info();
    if info.outline == Some(Outline::Points) {
        return format!("`{} {{ {POINT} x y; … }}`", info.name);
    }
    let names: Vec<&str> =
        std::iter::once(&*info.name).chain(solid.params().iter().map(|param| &*param.name)).collect();
    match info.size_params {
        0 | 1 => format!("`{}`", names.join(" ")),
        sizes => {
            let one: Vec<&str> = [&*info.name, "size"].into_iter().chain(names[1 + sizes..].iter().copied()).collect();
            format!("`{}` or `{}`", names.join(" "), one.join(" "))
        }
    }
}

/// Gathers `at`, `rotate`, `scale` and `normal`.
#[derive(Default)]
pub(super) struct Placements {
    pub(super) value: Placement,
    seen: Vec<(String, Span)>,
}

impl Placements {
    /// Takes the node if it is one of them.
    pub(super) fn take(&mut self, node: &Node, facing: bool, report: &mut Report) -> bool {
        let word = &*node.name.value;
        let placement = PLACEMENT.contains(&word) || facing && word == NORMAL;
        if !placement {
            return false;
        }
        if let Some((_, first)) = self.seen.iter().find(|(other, _)| other == word) {
            twice(&format!("`{word}`"), node.name.span, *first, report);
            return true;
        }
        self.seen.push((word.to_owned(), node.name.span));
        match word {
            "at" => self.value.at = triple(node, &schema::PLACEMENT[0], report),
            "rotate" => self.value.rotate = triple(node, &schema::PLACEMENT[1], report),
            "scale" => self.value.scale = single(node, &schema::PLACEMENT[2], report),
            _ => self.value.normal = triple(node, &schema::NORMAL, report),
        }
        true
    }
}
