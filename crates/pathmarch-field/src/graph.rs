//! A scene's field: shapes placed in space and combined.
//!
//! People write a tree of [`Node`]s. [`Field::new`] moves every placement down to the leaves (a solid's distance under a
//! similarity is its distance in local coordinates times the scale; Hart 1996, section 2.3), so that a leaf is one
//! transform away from the world, and evaluates the tree for one point or eight. [`crate::wgsl::Program`] prints the same
//! tree for the GPU. Cost of an evaluation: one virtual call and one transform for each leaf.
//!
//! Here is what a field consists of, and what is known of it without evaluating it. `build.rs` makes it; `distance.rs` and
//! `surface.rs` evaluate it.

mod analytic;
mod batch;
mod build;
pub(crate) mod bvh;
mod coordinates;
mod distance;
mod leaf;
mod node;
mod pose;
pub(crate) mod shape_grid;
mod surface;

use crate::blend::Blend;
use crate::bounds::Aabb;
use crate::modifiers::Modifier;
use crate::number::Vec3;
use crate::operators::Operator;
use crate::shapes::TRAPS;
pub use batch::Batch;
use bvh::Bvh;
pub use coordinates::Coordinates;
pub use leaf::Leaf;
pub use node::{Kind, Node, Placement};
pub use pose::{Pose, Turn};
use shape_grid::ShapeGrid;
pub use surface::Surface;

/// The tree with placements moved to the leaves.
#[derive(Clone, Debug)]
pub(crate) enum Tree {
    Leaf(u32),
    /// OperatorDef, blend in world metres, children, number of its first choice.
    Operator {
        operator: &'static dyn Operator,
        smooth: Option<Blend>,
        children: Vec<Tree>,
        first_choice: u32,
    },
    Modifier(Box<Modified>),
}

/// What a modifier holds, in its space.
#[derive(Clone, Debug)]
pub(crate) struct Modified {
    pub(crate) modifier: &'static dyn Modifier,
    /// Counts the modifiers of the field, those inside first.
    pub(crate) index: u32,
    /// What it reads.
    pub(crate) coefficients: Vec<f32>,
    pub(crate) copies: u32,
    pub(crate) pose: Pose,
    pub(crate) inside: Tree,
    params: Vec<f32>,
    inside_bounds: Aabb,
}

/// Everything of a scene, as one signed distance field: the union of its objects.
///
/// Rays meet an object that is a single shape with a closed form ([`Shape::closed_form`](crate::Shape::closed_form))
/// directly; the others must be marched. [`distance`](Self::distance) is over all,
/// [`sphere_traced_distance`](Self::sphere_traced_distance) over the latter.
#[derive(Clone, Debug)]
pub struct Field {
    leaves: Vec<Leaf>,
    objects: Vec<Tree>,
    /// Whether nothing is met in closed form.
    sphere_traces_all: bool,
    bounds: Aabb,
    object_bounds: Vec<Aabb>,
    sphere_traced_bounds: Aabb,
    /// How each object is evaluated.
    strategies: Vec<EvalStrategy>,
    shape_grids: Vec<ShapeGrid>,
    /// Over many objects of closed form.
    bvh: Bvh,
    /// How many choices and modifiers there are so far.
    choices: u32,
    modifiers: u32,
}

/// Stands for the leaf where a ray met none of closed form.
pub const SPHERE_TRACED: f32 = -1.0;

/// How an object is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EvalStrategy {
    /// By itself: rays meet it in closed form.
    Analytic,
    /// By itself: marched as code.
    SphereTraced,
    /// It is the shape_grid of this number.
    ShapeGrid(usize),
    /// Its one shape is in a shape_grid of such objects.
    InShapeGrid,
    /// Its one shape is met in closed form, by way of the hierarchy.
    InBvh,
}

impl Field {
    /// The shapes in the order they were written.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }
    /// A box that holds every solid.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
    /// A box that holds each object.
    pub fn object_bounds(&self) -> &[Aabb] {
        &self.object_bounds
    }
    /// A box that holds every solid that must be marched; [`Aabb::NOTHING`] where there is none.
    pub fn sphere_traced_bounds(&self) -> Aabb {
        self.sphere_traced_bounds
    }
    /// The shape of an object that is a single one which rays meet in closed form.
    pub(crate) fn direct(&self, object: &Tree) -> Option<u32> {
        match object {
            Tree::Leaf(index) if !self.sphere_traces_all && self.leaves[*index as usize].shape.is_analytic() => {
                Some(*index)
            }
            _ => None,
        }
    }
    /// Whether the leaf of this number is an object by itself, which rays meet in closed form.
    pub fn is_analytic_object(&self, leaf: usize) -> bool {
        let object = self.leaves.get(leaf).and_then(|leaf| self.objects.get(leaf.object as usize));
        object.is_some_and(|object| self.direct(object).is_some())
    }
    /// Reports whether finding the hit of a ray takes loops: sphere tracing or the traversal of a BVH or grid.
    pub fn has_loops(&self) -> bool {
        !self.sphere_traced_bounds().is_empty() || !self.bvh.nodes.is_empty() || !self.shape_grids.is_empty()
    }
    /// Whether rays meet the object of this leaf in closed form.
    pub fn is_analytic_leaf(&self, leaf: usize) -> bool {
        let strategy = self.leaves.get(leaf).and_then(|leaf| self.strategies.get(leaf.object as usize));
        matches!(strategy, Some(EvalStrategy::Analytic | EvalStrategy::InBvh))
    }
    /// What the orbit of a point of the world comes near to on the leaf of this number:
    /// [`Shape::orbit`](crate::Shape::orbit), where the leaf is a fractal.
    pub fn orbit(&self, leaf: usize, p: Vec3<f32>) -> Option<[f32; TRAPS]> {
        let shape = self.leaves.get(leaf).filter(|leaf| leaf.shape.has_orbit())?;
        Some(shape.shape.orbit(self.coordinates(leaf, p)?.point, &shape.params))
    }
    /// A box in the world that holds the leaf of this number, if there is one: of one that a modifier holds, the box of its
    /// object.
    pub fn leaf_bounds(&self, leaf: usize) -> Aabb {
        let Some(leaf) = self.leaves.get(leaf) else { return Aabb::NOTHING };
        match leaf.modified {
            false => leaf.pose.world_bounds(leaf.shape.bounds(&leaf.params)),
            true => self.object_bounds.get(leaf.object as usize).copied().unwrap_or(Aabb::EVERYTHING),
        }
    }
    /// An upper bound of |∇distance|: operators and placements keep the largest of the leaves'.
    pub fn lipschitz(&self) -> f32 {
        self.objects.iter().map(|object| self.tree_lipschitz(object)).fold(1.0, f32::max)
    }

    fn tree_lipschitz(&self, tree: &Tree) -> f32 {
        match tree {
            Tree::Leaf(leaf) => {
                let leaf = &self.leaves[*leaf as usize];
                leaf.shape.lipschitz(&leaf.params)
            }
            Tree::Operator { children, .. } => {
                children.iter().map(|child| self.tree_lipschitz(child)).fold(1.0, f32::max)
            }
            Tree::Modifier(modified) => self.tree_lipschitz(&modified.inside),
        }
    }

    fn tree_bounds(&self, tree: &Tree) -> Aabb {
        match tree {
            Tree::Leaf(leaf) => {
                let leaf = &self.leaves[*leaf as usize];
                leaf.pose.world_bounds(leaf.shape.bounds(&leaf.params))
            }
            Tree::Modifier(modified) => {
                modified.pose.world_bounds(modified.modifier.bounds(&modified.params, modified.inside_bounds))
            }
            Tree::Operator { operator, smooth, children, .. } if shape_grid::joins(*operator) => children
                .iter()
                .map(|child| self.tree_bounds(child))
                .fold(Aabb::NOTHING, Aabb::union)
                .expanded(shape_grid::growth(*smooth, children.len())),
            Tree::Operator { operator, smooth, children, .. } => children
                .iter()
                .map(|child| self.tree_bounds(child))
                .reduce(|a, b| operator.bounds(a, b, *smooth))
                .unwrap_or(Aabb::NOTHING),
        }
    }
}
