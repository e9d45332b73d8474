//! Distances of a field on the CPU: to all objects, to sphere-traced ones, to chosen ones; and analytic hits.

use super::far_field::FarField;
use super::{Batch, Field, Modified, RayKind, SPHERE_TRACED, Tree};
use crate::number::Vec3;
use crate::ray_interval::T_MAX;

impl Field {
    /// Signed distance from each point to the nearest surface, metres; infinite in an empty scene.
    pub fn distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for distance in self.object_distances(p) {
            nearest = nearest.min(distance);
        }
        nearest
    }

    /// Signed distance as [`distance`](Self::distance), but only an estimate far from shape grids; enough for shading.
    pub fn estimated_distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.single_objects() {
            nearest = nearest.min(self.tree_distance(object, p, FarField::Estimate));
        }
        if let Some(shape_grid) = self.separate_shape_grid() {
            nearest = nearest.min(shape_grid.distance(self, p, FarField::Estimate));
        }
        self.bvh.distance(self, p, nearest, |_| true, N::constant(SPHERE_TRACED))
    }

    /// Unsigned distance to the nearest surface of the sphere-traced objects, metres; infinite if there are none. Every object
    /// keeps its own surface, so that objects inside a transparent one are visible.
    pub fn sphere_traced_distance<N: Batch>(&self, p: Vec3<N>, kind: RayKind) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.objects_sphere_traced_by(kind) {
            nearest = nearest.min(self.tree_distance(object, p, FarField::Bound).abs());
        }
        if let Some(shape_grid) = self.separate_shape_grid() {
            nearest = nearest.min(shape_grid.distance(self, p, FarField::Bound).abs());
        }
        nearest
    }

    /// Unsigned distance from each point to the nearest surface of the included objects, metres; infinite if there are none.
    /// `included` has one entry for each object. The analytic object whose only leaf is `ignored_leaf` is left out: it is
    /// convex and does not occlude its own surface.
    pub fn distance_to<N: Batch>(&self, p: Vec3<N>, included: &[bool], ignored_leaf: N) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for (object, _) in self.single_objects_with(included).filter(|(_, included)| *included) {
            let closer = nearest.min(self.tree_distance(object, p, FarField::Estimate).abs());
            nearest = match self.direct(object) {
                Some(leaf) if !self.leaves[leaf as usize].is_triangles() => {
                    let is_ignored = (ignored_leaf - N::constant(leaf as f32)).abs().lt(N::constant(0.5));
                    N::select(is_ignored, nearest, closer)
                }
                _ => closer,
            };
        }
        if let Some(shape_grid) = self.included_shape_grid(included) {
            nearest = nearest.min(self.shape_grids[shape_grid].distance(self, p, FarField::Estimate).abs());
        }
        let is_included = |leaf: u32| included.get(self.leaves[leaf as usize].object as usize) == Some(&true);
        self.bvh.distance(self, p, nearest, is_included, ignored_leaf)
    }

    /// Reports whether an object contains a point. Distances are evaluated only within its bounds.
    pub fn contains(&self, object: usize, p: Vec3<f32>) -> bool {
        let bounds = self.object_bounds[object];
        let inside = |value: f32, axis: usize| bounds.min[axis] <= value && value <= bounds.max[axis];
        inside(p.x, 0)
            && inside(p.y, 1)
            && inside(p.z, 2)
            && self.tree_distance(&self.objects[object], p, FarField::Exact) < 0.0
    }

    /// Signed distance from each point to each object, in their order, metres.
    pub fn object_distances<N: Batch>(&self, p: Vec3<N>) -> impl Iterator<Item = N> {
        self.objects.iter().map(move |object| self.tree_distance(object, p, FarField::Exact))
    }

    /// First analytic hit of each ray: metres along the unit vector `direction`, or [`T_MAX`]; and the index of the leaf, or
    /// [`SPHERE_TRACED`] if there is none.
    pub fn analytic_hit<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> (N, N) {
        self.analytic_hit_before(N::constant(T_MAX), origin, direction)
    }

    /// [`analytic_hit`](Self::analytic_hit) at less than this distance along each ray, metres; that distance if there is none.
    pub fn analytic_hit_before<N: Batch>(&self, limit: N, origin: Vec3<N>, direction: Vec3<N>) -> (N, N) {
        let mut hit = (limit, N::constant(SPHERE_TRACED));
        for object in &self.analytic {
            hit = self.object_hit(object, origin, direction, hit);
        }
        self.bvh.hit(self, origin, direction, hit)
    }

    pub(super) fn tree_distance<N: Batch>(&self, tree: &Tree, p: Vec3<N>, far_field: FarField) -> N {
        match tree {
            Tree::Leaf(leaf) => self.leaves[*leaf as usize].distance(p),
            Tree::Modifier(modified) => {
                let p = modified.pose.local(p);
                let (inside, _) = self.nearest_copy(modified, p, far_field);
                modified.pose.length(N::modifier(modified.modifier).distance(p, inside, &modified.coefficients))
            }
            Tree::Operator { shape_grid: Some(index), .. } => {
                self.shape_grids[*index as usize].distance(self, p, far_field)
            }
            Tree::Operator { operator, smooth, children, .. } => {
                let mut result = self.tree_distance(&children[0], p, far_field);
                for child in &children[1..] {
                    let other = self.tree_distance(child, p, far_field);
                    result = N::operator(*operator).distance(result, other, *smooth);
                }
                result
            }
        }
    }

    /// Least distance of a modifier's child over its domain copies at `p`, and the index of that copy.
    pub(super) fn nearest_copy<N: Batch>(&self, modified: &Modified, p: Vec3<N>, far_field: FarField) -> (N, N) {
        let mut nearest = (N::constant(f32::INFINITY), N::zero());
        for copy in 0..modified.copies {
            let copy = N::constant(copy as f32);
            let point = N::modifier(modified.modifier).point(p, copy, &modified.coefficients);
            let distance = self.tree_distance(&modified.inside, point, far_field);
            nearest.1 = N::select(distance.lt(nearest.0), copy, nearest.1);
            nearest.0 = nearest.0.min(distance);
        }
        nearest
    }
}
