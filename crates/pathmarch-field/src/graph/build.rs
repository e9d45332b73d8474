//! Construction of a field from a scene's tree: placements move down to the leaves, and each object gets its evaluation
//! strategy.

use super::bvh::Bvh;
use super::pose::Frame;
use super::{EvalStrategy, Field, Kind, Leaf, Modified, Node, Tree, shape_grid};
use crate::blend::Blend;
use crate::bounds::Aabb;
use crate::mesh_shape::MeshGeometry;
use crate::operators::Operator;
use crate::registry::union;
use crate::shapes::ShapeRef;
use std::sync::Arc;

impl Field {
    /// Builds the union of `objects`. Operators and modifiers without children are left out.
    pub fn new(objects: &[Node]) -> Self {
        Self::with_shape_grids_from(objects, shape_grid::MIN_SHAPES)
    }

    /// [`new`](Self::new) with another least number of shapes of a shape grid; for tests.
    #[doc(hidden)]
    pub fn with_shape_grids_from(objects: &[Node], least: usize) -> Self {
        Self::of(objects, least, false, &|_| false)
    }

    /// [`new`](Self::new) of objects some of which are lamps: opaque, and alike on all of their surface, by their tags. Shapes of
    /// lamps that rays intersect analytically stay so in unions and in counted copies, each with a leaf and a surface of
    /// its own.
    pub fn with_lamps(objects: &[Node], is_lamp: impl Fn(u32) -> bool) -> Self {
        Self::of(objects, shape_grid::MIN_SHAPES, false, &is_lamp)
    }

    /// [`new`](Self::new) without analytic objects and shape grids; for tests.
    #[doc(hidden)]
    pub fn all_sphere_traced(objects: &[Node]) -> Self {
        Self::of(objects, usize::MAX, true, &|_| false)
    }

    fn of(objects: &[Node], least: usize, sphere_traces_all: bool, is_lamp: &dyn Fn(u32) -> bool) -> Self {
        let mut field = Self {
            sphere_traces_all,
            leaves: Vec::new(),
            objects: Vec::new(),
            bounds: Aabb::NOTHING,
            object_bounds: Vec::new(),
            sphere_traced_bounds: Aabb::NOTHING,
            strategies: Vec::new(),
            singles: Vec::new(),
            analytic: Vec::new(),
            shape_grids: Vec::new(),
            coarse_grids: false,
            bvh: Bvh::default(),
            mesh_instances: Bvh::default(),
            mesh_words: Arc::default(),
            choices: 0,
            modifiers: 0,
        };
        for (index, object) in objects.iter().enumerate() {
            if let Some(tree) = field.add(object, Frame::WORLD, index as u32, false) {
                let bounds = field.tree_bounds(&tree);
                field.bounds = field.bounds.union(bounds);
                field.object_bounds.push(bounds);
                if field.is_triangles(&tree) {
                    field.strategies.push(EvalStrategy::Triangles);
                } else if field.is_analytic(&tree) {
                    field.strategies.push(EvalStrategy::Analytic);
                    field.mark_subtracted(&tree, false);
                } else {
                    field.strategies.push(match field.is_lit_by_field(&tree) {
                        true => EvalStrategy::LitByField,
                        false => EvalStrategy::SphereTraced,
                    });
                    field.sphere_traced_bounds = field.sphere_traced_bounds.union(bounds);
                }
                field.objects.push(tree);
            }
        }
        let lamps = field.separate_lamps(is_lamp);
        field.gather_mesh_instances();
        field.gather_shape_grids(least);
        field.add_to_bvh(lamps);
        field
    }

    fn add(&mut self, node: &Node, frame: Frame, object: u32, modified: bool) -> Option<Tree> {
        let frame = frame.inside(&node.placement);
        match &node.kind {
            Kind::Shape { shape, params, tag } => {
                let tags = shape.mesh().map(MeshGeometry::tags).filter(|tags| !tags.is_empty());
                let first = self.leaves.len() as u32;
                for (slot, &tag) in (0..).zip(tags.unwrap_or(std::slice::from_ref(tag))) {
                    self.leaves.push(Leaf {
                        shape: shape.variant(params).map_or_else(|| shape.clone(), ShapeRef::from),
                        params: shape.coefficients(params),
                        tag,
                        object,
                        pose: frame.pose(),
                        modified,
                        slot,
                        subtracted: false,
                        copy_of: None,
                        lamp: false,
                    });
                }
                Some(Tree::Leaf(first))
            }
            Kind::Operator { operator, smooth, children } => {
                let scale = if operator.blends() { frame.scale } else { 1.0 };
                let smooth = smooth.map(|blend| Blend { amount: blend.amount * scale, ..blend });
                self.combine(*operator, smooth, children, frame, object, modified)
            }
            Kind::Modifier { modifier, params, children } => {
                let inside = self.combine(union(), None, children, Frame::WORLD, object, true)?;
                // An intersection may be empty, and an empty box has no corners.
                let inside_bounds = Some(self.tree_bounds(&inside)).filter(|bounds| !bounds.is_empty());
                let inside_bounds = inside_bounds.unwrap_or(Aabb::centred(0.0, 0.0, 0.0));
                self.modifiers += 1;
                Some(Tree::Modifier(Box::new(Modified {
                    modifier: *modifier,
                    index: self.modifiers - 1,
                    coefficients: modifier.coefficients(params, inside_bounds),
                    copies: modifier.copies(params, inside_bounds),
                    pose: frame.pose(),
                    inside,
                    params: params.clone(),
                    inside_bounds,
                })))
            }
        }
    }

    fn combine(
        &mut self,
        operator: &'static dyn Operator,
        smooth: Option<Blend>,
        children: &[Node],
        frame: Frame,
        object: u32,
        modified: bool,
    ) -> Option<Tree> {
        let mut children: Vec<Tree> =
            children.iter().filter_map(|child| self.add(child, frame, object, modified)).collect();
        let first_choice = self.choices;
        self.choices += children.len() as u32;
        match children.len() {
            0 => None,
            1 => children.pop(),
            _ => Some(Tree::Operator { operator, smooth, children, first_choice, shape_grid: None }),
        }
    }
}
