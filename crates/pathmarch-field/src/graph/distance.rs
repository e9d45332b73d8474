//! Distances of a field on the CPU: of all, of what is marched, of objects that count; and hits in closed form.

use super::shape_grid::FarField;
use super::{Batch, EvalStrategy, Field, Modified, SPHERE_TRACED, Tree};
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

    /// [`distance`](Self::distance), which far from unions of many shapes need only be about right: what shading asks for.
    pub fn estimated_distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.single_objects() {
            nearest = nearest.min(self.tree_distance(object, p));
        }
        for shape_grid in &self.shape_grids {
            nearest = nearest.min(shape_grid.distance(self, p, FarField::Estimate));
        }
        self.bvh.distance(self, p, nearest, |_| true, N::constant(SPHERE_TRACED))
    }

    /// Distance to the nearest surface that must be marched, from outside or inside; infinite where there is none. Every
    /// object keeps its own surface: what lies inside a clear one is seen.
    pub fn sphere_traced_distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.sphere_traced_objects() {
            nearest = nearest.min(self.tree_distance(object, p).abs());
        }
        for shape_grid in &self.shape_grids {
            nearest = nearest.min(shape_grid.distance(self, p, FarField::Bound).abs());
        }
        nearest
    }

    /// Distance from each point to the nearest surface of the objects that count, from outside or inside; infinite where
    /// there is none. `counts` has one entry for each object, in their order. The object whose only leaf has the number `own`
    /// does not count if it has a closed form: it is convex, so that nothing of it is before its own surface.
    pub fn distance_to<N: Batch>(&self, p: Vec3<N>, counts: &[bool], own: N) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for (object, _) in self.single_objects_with(counts).filter(|(_, counts)| *counts) {
            let closer = nearest.min(self.tree_distance(object, p).abs());
            nearest = match self.direct(object) {
                Some(leaf) => {
                    let is_own = (own - N::constant(leaf as f32)).abs().lt(N::constant(0.5));
                    N::select(is_own, nearest, closer)
                }
                None => closer,
            };
        }
        for shape_grid in self.included_shape_grids(counts) {
            nearest = nearest.min(self.shape_grids[shape_grid].distance(self, p, FarField::Estimate).abs());
        }
        let leaf_counts = |leaf: u32| counts.get(self.leaves[leaf as usize].object as usize) == Some(&true);
        self.bvh.distance(self, p, nearest, leaf_counts, own)
    }

    /// Signed distance from each point to each object, in their order, metres.
    pub fn object_distances<N: Batch>(&self, p: Vec3<N>) -> impl Iterator<Item = N> {
        self.objects.iter().zip(&self.strategies).map(move |(object, strategy)| match strategy {
            EvalStrategy::ShapeGrid(shape_grid) => self.shape_grids[*shape_grid].distance(self, p, FarField::Exact),
            _ => self.tree_distance(object, p),
        })
    }

    /// Metres along each unit vector `direction` to the first surface of the objects that are met in closed form, or
    /// [`T_MAX`]; and the number of its leaf, or [`SPHERE_TRACED`].
    pub fn analytic_hit<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> (N, N) {
        let mut hit = (N::constant(T_MAX), N::constant(SPHERE_TRACED));
        for object in self.analytic_objects() {
            hit = self.object_hit(object, origin, direction, hit);
        }
        self.bvh.hit(self, origin, direction, hit)
    }

    pub(super) fn tree_distance<N: Batch>(&self, tree: &Tree, p: Vec3<N>) -> N {
        match tree {
            Tree::Leaf(leaf) => self.leaves[*leaf as usize].distance(p),
            Tree::Modifier(modified) => {
                let p = modified.pose.local(p);
                let (inside, _) = self.nearest_inside(modified, p);
                modified.pose.length(N::modifier(modified.modifier).distance(p, inside, &modified.coefficients))
            }
            Tree::Operator { operator, smooth, children, .. } => {
                let mut result = self.tree_distance(&children[0], p);
                for child in &children[1..] {
                    result = N::operator(*operator).distance(result, self.tree_distance(child, p), *smooth);
                }
                result
            }
        }
    }

    /// The least distance of what a modifier holds at the points of `p`, and the number of that point.
    pub(super) fn nearest_inside<N: Batch>(&self, modified: &Modified, p: Vec3<N>) -> (N, N) {
        let mut nearest = (N::constant(f32::INFINITY), N::zero());
        for place in 0..modified.copies {
            let place = N::constant(place as f32);
            let point = N::modifier(modified.modifier).point(p, place, &modified.coefficients);
            let distance = self.tree_distance(&modified.inside, point);
            nearest.1 = N::select(distance.lt(nearest.0), place, nearest.1);
            nearest.0 = nearest.0.min(distance);
        }
        nearest
    }
}
