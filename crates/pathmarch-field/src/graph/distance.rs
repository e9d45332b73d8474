//! Distances of a field on the CPU: of all, of what is marched, of objects that count; and hits in closed form.

use super::crowd::Afar;
use super::{Batch, Field, MARCHED, Modified, Role, Tree};
use crate::number::Vec3;
use crate::span::NO_HIT;

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
        for object in self.alone() {
            nearest = nearest.min(self.tree_distance(object, p));
        }
        for crowd in &self.crowds {
            nearest = nearest.min(crowd.distance(self, p, Afar::Estimate));
        }
        self.bvh.distance(self, p, nearest, |_| true, N::constant(MARCHED))
    }

    /// Distance to the nearest surface that must be marched, from outside or inside; infinite where there is none. Every
    /// object keeps its own surface: what lies inside a clear one is seen.
    pub fn marched_distance<N: Batch>(&self, p: Vec3<N>) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for object in self.marched_alone() {
            nearest = nearest.min(self.tree_distance(object, p).abs());
        }
        for crowd in &self.crowds {
            nearest = nearest.min(crowd.distance(self, p, Afar::Bound).abs());
        }
        nearest
    }

    /// Distance from each point to the nearest surface of the objects that count, from outside or inside; infinite where
    /// there is none. `counts` has one entry for each object, in their order. The object whose only leaf has the number `own`
    /// does not count if it has a closed form: it is convex, so that nothing of it is before its own surface.
    pub fn distance_to<N: Batch>(&self, p: Vec3<N>, counts: &[bool], own: N) -> N {
        let mut nearest = N::constant(f32::INFINITY);
        for (object, _) in self.alone_with(counts).filter(|(_, counts)| *counts) {
            let closer = nearest.min(self.tree_distance(object, p).abs());
            nearest = match self.direct(object) {
                Some(leaf) => {
                    let is_own = (own - N::constant(leaf as f32)).abs().lt(N::constant(0.5));
                    N::select(is_own, nearest, closer)
                }
                None => closer,
            };
        }
        for crowd in self.crowds_that_count(counts) {
            nearest = nearest.min(self.crowds[crowd].distance(self, p, Afar::Estimate).abs());
        }
        let leaf_counts = |leaf: u32| counts.get(self.leaves[leaf as usize].object as usize) == Some(&true);
        self.bvh.distance(self, p, nearest, leaf_counts, own)
    }

    /// Signed distance from each point to each object, in their order, metres.
    pub fn object_distances<N: Batch>(&self, p: Vec3<N>) -> impl Iterator<Item = N> {
        self.objects.iter().zip(&self.roles).map(move |(object, role)| match role {
            Role::Crowd(crowd) => self.crowds[*crowd].distance(self, p, Afar::Exact),
            _ => self.tree_distance(object, p),
        })
    }

    /// Metres along each unit vector `direction` to the first surface of the objects that are met in closed form, or
    /// [`NO_HIT`]; and the number of its leaf, or [`MARCHED`].
    pub fn direct_hit<N: Batch>(&self, origin: Vec3<N>, direction: Vec3<N>) -> (N, N) {
        let mut hit = (N::constant(NO_HIT), N::constant(MARCHED));
        for object in self.direct_alone() {
            hit = self.object_hit(object, origin, direction, hit);
        }
        self.bvh.hit(self, origin, direction, hit)
    }

    pub(super) fn tree_distance<N: Batch>(&self, tree: &Tree, p: Vec3<N>) -> N {
        match tree {
            Tree::Leaf(leaf) => self.leaves[*leaf as usize].distance(p),
            Tree::Modify(modified) => {
                let p = modified.pose.local(p);
                let (inside, _) = self.nearest_inside(modified, p);
                modified.pose.length(N::modifier(modified.modifier).distance(p, inside, &modified.numbers))
            }
            Tree::Combine { operator, smooth, children, .. } => {
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
        for place in 0..modified.places {
            let place = N::constant(place as f32);
            let point = N::modifier(modified.modifier).point(p, place, &modified.numbers);
            let distance = self.tree_distance(&modified.inside, point);
            nearest.1 = N::select(distance.lt(nearest.0), place, nearest.1);
            nearest.0 = nearest.0.min(distance);
        }
        nearest
    }
}
