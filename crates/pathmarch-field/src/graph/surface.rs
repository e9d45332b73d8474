//! Surfaces of a field on the CPU: distance, gradient, and the leaf whose material shows.

use super::crowd::Afar;
use super::{Batch, Field, Modified, Role, Tree};
use crate::number::{Dual, Real, Vec3};

/// The nearest surface as seen from a point.
#[derive(Clone, Copy, Debug)]
pub struct Surface<N> {
    /// Distance and its gradient.
    pub field: Dual<N>,
    /// Index into [`Field::leaves`] of the leaf whose material shows, as a number.
    pub leaf: N,
}

impl Field {
    /// The nearest surface of an object from each point: signed distance to that object, gradient, and the leaf whose
    /// material shows. Where smooth operators blend materials, one of them is chosen with the probability of its weight,
    /// by the point's seed.
    pub fn surface<N: Batch>(&self, p: Vec3<N>, seeds: N::Seeds) -> Surface<N> {
        self.nearest_surface(p, |_| N::truth(true), &|index| N::choice(seeds, index), Afar::Exact)
    }

    /// The surface of the union at each point: of the object whose signed distance is least, as in
    /// [`distance`](Self::distance). Thresholds are as in [`surface_met`](Self::surface_met).
    pub fn union_surface<N: Batch>(&self, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let mut least = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for (object, role) in self.objects.iter().zip(&self.roles) {
            let surface = match role {
                Role::Crowd(crowd) => self.crowds[*crowd].surface(self, p, threshold, Afar::Exact),
                _ => self.tree_surface(object, p, threshold),
            };
            let is_less = surface.field.value.lt(least.field.value);
            least = Surface {
                field: Dual::select(is_less, surface.field, least.field),
                leaf: N::select(is_less, surface.leaf, least.leaf),
            };
        }
        least
    }

    /// The surface that a ray met at each point, as [`surface`](Self::surface): of the leaf of closed form that
    /// [`direct_hit`](Self::direct_hit) gave as `met`, or of the objects that are marched where that is
    /// [`MARCHED`](super::MARCHED). Where a smooth operator blends two materials, the second one shows if its weight exceeds
    /// the threshold of the blend's number: [`Batch::choice`], or 0.5 for the heavier one.
    pub fn surface_met<N: Batch>(&self, p: Vec3<N>, met: N, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let all = &met.lanes()[..N::LANES];
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        if all.iter().any(|&met| met < 0.0) {
            result = self.nearest_surface(p, |closed| N::truth(!closed), threshold, Afar::Estimate);
        }
        for (lane, &leaf) in all.iter().enumerate().filter(|(_, leaf)| **leaf >= 0.0) {
            if all[..lane].contains(&leaf) {
                continue;
            }
            let Some(shape) = self.leaves.get(leaf as usize) else { continue };
            let field = if shape.hollow { -shape.surface(p) } else { shape.surface(p) };
            let is_it = (met - N::constant(leaf)).abs().lt(N::constant(0.5));
            result = Surface {
                field: Dual::select(is_it, field, result.field),
                leaf: N::select(is_it, N::constant(leaf), result.leaf),
            };
        }
        result
    }

    fn nearest_surface<N: Batch>(
        &self,
        p: Vec3<N>,
        counts: impl Fn(bool) -> N::Mask,
        threshold: &dyn Fn(u32) -> N,
        afar: Afar,
    ) -> Surface<N> {
        let mut nearest = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        let mut add = |surface: Surface<N>, counts: N::Mask| {
            let closer = surface.field.value.abs().lt(nearest.field.value.abs()) & counts;
            nearest = Surface {
                field: Dual::select(closer, surface.field, nearest.field),
                leaf: N::select(closer, surface.leaf, nearest.leaf),
            };
        };
        for (object, role) in self.objects.iter().zip(&self.roles) {
            let closed = matches!(role, Role::Direct | Role::InBvh);
            let is_evaluated = closed || *role == Role::Marched;
            if is_evaluated && N::any(counts(closed)) {
                add(self.tree_surface(object, p, threshold), counts(closed));
            }
        }
        for crowd in &self.crowds {
            add(crowd.surface(self, p, threshold, afar), counts(false));
        }
        nearest
    }

    pub(super) fn tree_surface<N: Batch>(&self, tree: &Tree, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        match tree {
            Tree::Leaf(index) => {
                let field = self.leaves[*index as usize].surface(p);
                Surface { field, leaf: N::constant(*index as f32) }
            }
            Tree::Modify(modified) => {
                let Modified { modifier, numbers, pose, inside, .. } = &**modified;
                let p = pose.local(p);
                let place = if modified.places > 1 { self.nearest_inside(modified, p).1 } else { N::zero() };
                let point = N::modifier(*modifier).point_gradient(p, place, numbers);
                let Surface { field, leaf } = self.tree_surface(inside, point.values(), threshold);
                let inside = Dual { value: field.value, gradient: point.pulled(field.gradient) };
                Surface { field: pose.world(N::modifier(*modifier).gradient(p, inside, numbers)), leaf }
            }
            Tree::Combine { operator, smooth, children, first_choice } => {
                let mut result = self.tree_surface(&children[0], p, threshold);
                for (k, child) in children[1..].iter().enumerate() {
                    let other = self.tree_surface(child, p, threshold);
                    let weight = N::operator(*operator).weight(result.field.value, other.field.value, *smooth);
                    let least = match smooth {
                        Some(_) => threshold(first_choice + k as u32),
                        None => N::constant(0.5),
                    };
                    let other_shows = least.lt(weight);
                    result = Surface {
                        field: N::operator(*operator).gradient(result.field, other.field, *smooth),
                        leaf: N::select(other_shows, other.leaf, result.leaf),
                    };
                }
                result
            }
        }
    }
}
