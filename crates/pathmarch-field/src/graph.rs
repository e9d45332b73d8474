//! A scene's field: shapes placed in space and combined.
//!
//! People write a tree of [`Node`]s. [`Field::new`] moves every placement down to the leaves (a solid's distance under a
//! similarity is its distance in local coordinates times the scale; Hart 1996, section 2.3), so that a leaf is one
//! transform away from the world, and evaluates the tree for one point or eight. [`crate::wgsl::Program`] prints the same
//! tree for the GPU. Cost of an evaluation: one virtual call and one transform for each leaf.
//!
//! This file has the parts of a field and the queries that need no evaluation. `build.rs` builds a field; `distance.rs` and
//! `surface.rs` evaluate it.

mod analytic;
mod batch;
mod build;
pub(crate) mod bvh;
mod coordinates;
mod distance;
mod far_field;
mod lamps;
mod leaf;
mod mesh_hit;
mod node;
mod object_motion;
mod pose;
pub(crate) mod shape_grid;
mod surface;

use crate::blend::Blend;
use crate::bounds::Aabb;
use crate::mesh_shape::words::MeshWords;
use crate::modifiers::Modifier;
use crate::number::Vec3;
use crate::operators::Operator;
use crate::shapes::TRAPS;
use analytic::AnalyticObject;
pub use batch::Batch;
use bvh::Bvh;
pub use coordinates::Coordinates;
pub use leaf::Leaf;
pub use mesh_hit::{MeshHit, MeshInteraction, NearestTriangle};
pub use node::{Kind, Node};
pub use object_motion::{Displacement, ObjectMotion};
pub use pose::{Placement, Pose, Turn};
use shape_grid::ShapeGrid;
use std::sync::{Arc, OnceLock};
pub use surface::Surface;

/// The tree with placements moved to the leaves.
#[derive(Clone, Debug)]
pub(crate) enum Tree {
    Leaf(u32),
    /// Operator over children; the blend is in world metres.
    Operator {
        operator: &'static dyn Operator,
        smooth: Option<Blend>,
        children: Vec<Tree>,
        /// Index of the first random choice among its blended materials.
        first_choice: u32,
        /// Index of the shape grid that evaluates it.
        shape_grid: Option<u32>,
    },
    Modifier(Box<Modified>),
}

/// A modifier and its child, which is in the modifier's space.
#[derive(Clone, Debug)]
pub(crate) struct Modified {
    pub(crate) modifier: &'static dyn Modifier,
    /// Index among the modifiers of the field, inner ones first.
    pub(crate) index: u32,
    /// Coefficients that its functions read.
    pub(crate) coefficients: Vec<f32>,
    /// Number of domain copies to evaluate.
    pub(crate) copies: u32,
    pub(crate) pose: Pose,
    pub(crate) inside: Tree,
    params: Vec<f32>,
    inside_bounds: Aabb,
}

/// Signed distance field of a scene: the union of its objects.
///
/// Objects are analytic or sphere-traced. Rays intersect analytic objects in closed form: single shapes with
/// [`Shape::is_analytic`](crate::Shape::is_analytic) and sharp combinations of a few convex shapes. All others are
/// sphere-traced. [`distance`](Self::distance) is that to all objects,
/// [`sphere_traced_distance`](Self::sphere_traced_distance) that to the latter.
#[derive(Clone, Debug)]
pub struct Field {
    leaves: Vec<Leaf>,
    objects: Vec<Tree>,
    /// True if no object is analytic; for tests.
    sphere_traces_all: bool,
    bounds: Aabb,
    object_bounds: Vec<Aabb>,
    sphere_traced_bounds: Aabb,
    /// Evaluation strategy of each object.
    strategies: Vec<EvalStrategy>,
    /// Indices of the objects that are evaluated by themselves.
    singles: Vec<u32>,
    /// Analytic objects among them.
    analytic: Vec<AnalyticObject>,
    shape_grids: Vec<ShapeGrid>,
    /// True if cells of shape grids that are missing are built [coarse](Field::with_coarse_grids).
    coarse_grids: bool,
    /// Hierarchy over many analytic objects.
    bvh: Bvh,
    /// Hierarchy over the meshes of triangles.
    mesh_instances: Bvh,
    /// Encoded meshes, without and with the grids of triangles; made on first use, and shared by copies of the field.
    mesh_words: Arc<[OnceLock<Arc<MeshWords>>; 2]>,
    /// Numbers of choices and modifiers so far.
    choices: u32,
    modifiers: u32,
}

/// Leaf index of a hit that is sphere-traced, in place of an analytic leaf.
pub const SPHERE_TRACED: f32 = -1.0;

/// Evaluation strategy of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EvalStrategy {
    /// By itself: rays intersect it analytically.
    Analytic,
    /// By itself: sphere-traced, printed as code that may read shape grids.
    SphereTraced,
    /// Its single shape is in the grid of separate objects, which is the last one.
    InShapeGrid,
    /// Its shapes are analytic and in the BVH: one, or those of lamps.
    InBvh,
    /// By itself: rays intersect its triangles.
    Triangles,
    /// By itself: camera rays intersect its triangles; for others it is sphere-traced.
    LitByField,
}

/// Kind of a ray, for meshes that have one form for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayKind {
    /// From the camera.
    Camera,
    /// From a surface.
    Secondary,
}

impl Field {
    /// Shapes, in the order of the scene.
    pub fn leaves(&self) -> &[Leaf] {
        &self.leaves
    }
    /// Bounds of all solids.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }
    /// Bounds of each object.
    pub fn object_bounds(&self) -> &[Aabb] {
        &self.object_bounds
    }
    /// Bounds of all sphere-traced objects; [`Aabb::NOTHING`] if there are none.
    pub fn sphere_traced_bounds(&self) -> Aabb {
        self.sphere_traced_bounds
    }
    /// Leaf of an object that is a single analytic shape.
    pub(crate) fn direct(&self, object: &Tree) -> Option<u32> {
        match object {
            Tree::Leaf(index) if !self.sphere_traces_all && self.leaves[*index as usize].shape.is_analytic() => {
                Some(*index)
            }
            _ => None,
        }
    }
    /// Reports whether this leaf is analytic, with all of its surface: a whole object, or one of several lamps.
    pub fn is_analytic_object(&self, leaf: usize) -> bool {
        let Some(leaf) = self.leaves.get(leaf) else { return false };
        leaf.lamp || self.objects.get(leaf.object as usize).is_some_and(|object| self.direct(object).is_some())
    }
    /// Leaf that the scene declares: this one, or the one that it is a copy of.
    pub fn declared_leaf(&self, leaf: usize) -> usize {
        self.leaves.get(leaf).and_then(|leaf| leaf.copy_of).map_or(leaf, |declared| declared as usize)
    }
    /// Reports whether finding the hit of a ray takes loops: sphere tracing or the traversal of a BVH or grid.
    pub fn has_loops(&self) -> bool {
        !self.sphere_traced_bounds().is_empty()
            || !self.bvh.nodes.is_empty()
            || !self.shape_grids.is_empty()
            || self.has_triangles()
    }
    /// Reports whether the object of this leaf is analytic.
    pub fn is_analytic_leaf(&self, leaf: usize) -> bool {
        let strategy = self.leaves.get(leaf).and_then(|leaf| self.strategies.get(leaf.object as usize));
        matches!(strategy, Some(EvalStrategy::Analytic | EvalStrategy::InBvh | EvalStrategy::Triangles))
    }
    /// Orbit traps of a world point on this leaf, about a centre in its local coordinates ([`EvalShape::orbit`](crate::EvalShape::orbit)), if it is a fractal.
    pub fn orbit(&self, leaf: usize, p: Vec3<f32>, centre: Vec3<f32>) -> Option<[f32; TRAPS]> {
        let shape = self.leaves.get(leaf).filter(|leaf| leaf.shape.has_orbit())?;
        Some(shape.shape.orbit(self.coordinates(leaf, p)?.point, centre, &shape.params))
    }
    /// World bounds of this leaf; those of its object if it is inside a modifier.
    pub fn leaf_bounds(&self, leaf: usize) -> Aabb {
        let Some(leaf) = self.leaves.get(leaf) else { return Aabb::NOTHING };
        match leaf.modified {
            false => leaf.pose.world_bounds(leaf.shape.bounds(&leaf.params)),
            true => self.object_bounds.get(leaf.object as usize).copied().unwrap_or(Aabb::EVERYTHING),
        }
    }
    /// World bounds of this leaf and of all copies of it that are leaves of their own.
    pub fn declared_bounds(&self, leaf: usize) -> Aabb {
        let bounds = self.leaf_bounds(leaf);
        if self.leaves.get(leaf).is_none_or(|leaf| leaf.copy_of.is_none()) {
            return bounds;
        }
        let copies = self.leaves.iter().enumerate().filter(|(_, other)| other.copy_of == Some(leaf as u32));
        copies.map(|(copy, _)| self.leaf_bounds(copy)).fold(bounds, Aabb::union)
    }
    /// Lipschitz constant, an upper bound of |∇distance|: the largest of all leaves; operators and placements keep it.
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
            Tree::Operator { operator, smooth, children, .. } if shape_grid::is_union(*operator) => children
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
