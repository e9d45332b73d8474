//! Uses of declared shapes, each expanded into the shapes of its declaration.

use super::{MAX_SHAPES, Solids, combined};
use crate::assets::Assets;
use crate::language::diagnostics::report::draft;
use crate::language::keywords::{MATERIAL, PARAM, PLACEMENT};
use crate::language::read::arguments::properties;
use crate::language::read::context::{Context, Files};
use crate::language::read::custom_sdf::CustomSdfs;
use crate::language::read::declarations::{Declaration, Declarations, given_entries};
use crate::language::read::materials::Materials;
use crate::language::read::params::{self, Given};
use crate::language::read::placement::Placements;
use crate::language::read::unexpected::unexpected_node;
use crate::language::tree::Node;
use pathmarch_field::graph::Kind;
use pathmarch_field::{Node as FieldNode, Placement, registry};

impl Solids<'_> {
    /// Checks every declaration by itself, with the defaults of its parameters, and records which are sound.
    pub(crate) fn check(
        materials: &mut Materials,
        declared: &mut Declarations,
        fields: &CustomSdfs,
        (scene, assets): (&str, &mut Assets),
        context: &mut Context,
    ) {
        let mut sound = Vec::new();
        let animated = context.scope.animated;
        for declaration in &declared.list {
            let before = context.report.count_so_far();
            let files = Files { scene, assets: &mut *assets };
            let mut solids = Solids { checking: true, planes: 1, ..Solids::new(materials, declared, fields, files) };
            if declaration.node.child_nodes().iter().all(|child| child.name.value == PARAM)
                && !declaration.node.broken()
            {
                let message = "This shape is empty.";
                let mistake = draft("pathmarch::no_shapes", declaration.node.name.span, message);
                let help = "For example: shape \"pin\" { param length 1; cylinder 0.1 length }.";
                context.report.add(mistake.label("expected a shape in its braces").help(help));
            }
            solids.body(declaration, &[], Some(0), context);
            sound.push(declaration.sound && context.report.count_so_far() == before && !declaration.node.broken());
        }
        context.scope.animated = animated;
        for (declaration, sound) in declared.list.iter_mut().zip(sound) {
            declaration.sound = sound;
        }
        declared.spread();
    }

    /// Reads the shapes of a declaration, with these values of its parameters.
    fn body(
        &mut self,
        declaration: &Declaration,
        given: &[(&str, Given)],
        material: Option<u32>,
        context: &mut Context,
    ) -> Vec<FieldNode> {
        let outside = context.scope.enter();
        let nodes = declaration.node.child_nodes();
        params::declare(params::nodes(nodes), given, &[MATERIAL], context);
        let mut children = Vec::new();
        for child in nodes.iter().filter(|child| child.name.value != PARAM) {
            if PLACEMENT.contains(&&*child.name.value) {
                let message = format!("A declared shape has no `{}` of its own.", child.name.value);
                let mistake = draft("pathmarch::misplaced_node", child.name.span, message).label("not here");
                context.report.add(mistake.help("Put it where the shape is used, or in the braces of a shape in it."));
            } else {
                children.extend(self.solid(child, material, ("in a declared shape", &[PARAM]), context));
            }
        }
        context.scope.leave(outside);
        children
    }

    /// A use of a declared shape.
    pub(super) fn instance(
        &mut self,
        declaration: &Declaration,
        node: &Node,
        material: Option<u32>,
        context: &mut Context,
    ) -> Option<FieldNode> {
        let mut known = declaration.params.clone();
        known.push(MATERIAL);
        let mut named = properties(node, &known, context);
        let own = named.iter().position(|(name, _)| *name == MATERIAL).map(|at| named.swap_remove(at).1);
        let material = own.map(|entry| self.material(entry, context)).or(material);
        let entries = given_entries(declaration, node, named, context);
        let given = params::given(&entries, context);
        let mut placement = Placements::default();
        for child in node.child_nodes() {
            if !placement.take(child, false, context) {
                unexpected_node(&child.name, PLACEMENT, &format!("in a `{}`", declaration.name), context);
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
            context.report.add(draft("pathmarch::too_large", node.name.span, message).label("one too many"));
        }
        if !declaration.sound || self.expanded > MAX_SHAPES || self.shapes > MAX_SHAPES {
            return None;
        }
        let outermost = context.report.within.is_none();
        if outermost {
            context.report.within = Some((node.name.span, "used here".to_owned()));
        }
        let mut children = self.body(declaration, &given, material, context);
        if outermost {
            context.report.within = None;
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
}
