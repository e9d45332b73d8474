//! Surfaces of a field on the CPU: distance, gradient, and the leaf whose material shows.

use super::shape_grid::FarField;
use super::{Batch, EvalStrategy, Field, Modified, Tree};
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
        self.nearest_surface(p, |_| N::truth(true), &|index| N::choice(seeds, index), FarField::Exact)
    }

    /// The surface of the union at each point: of the object whose signed distance is least, as in
    /// [`distance`](Self::distance). Thresholds are as in [`surface_at_hit`](Self::surface_at_hit).
    pub fn union_surface<N: Batch>(&self, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let mut least = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for (object, strategy) in self.objects.iter().zip(&self.strategies) {
            let surface = match strategy {
                EvalStrategy::ShapeGrid(shape_grid) => {
                    self.shape_grids[*shape_grid].surface(self, p, threshold, FarField::Exact)
                }
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
    /// [`analytic_hit`](Self::analytic_hit) gave as `met`, or of the objects that are marched where that is
    /// [`SPHERE_TRACED`](super::SPHERE_TRACED). Where a smooth operator blends two materials, the second one shows if its weight exceeds
    /// the threshold of the blend's number: [`Batch::choice`], or 0.5 for the heavier one.
    pub fn surface_at_hit<N: Batch>(&self, p: Vec3<N>, met: N, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let all = &met.lanes()[..N::LANES];
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        if all.iter().any(|&met| met < 0.0) {
            result = self.nearest_surface(p, |closed| N::truth(!closed), threshold, FarField::Estimate);
        }
        for (lane, &leaf) in all.iter().enumerate().filter(|(_, leaf)| **leaf >= 0.0) {
            if all[..lane].contains(&leaf) {
                continue;
            }
            let Some(shape) = self.leaves.get(leaf as usize) else { continue };
            let field = if shape.subtracted { -shape.surface(p) } else { shape.surface(p) };
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
        far_field: FarField,
    ) -> Surface<N> {
        let mut nearest = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        let mut add = |surface: Surface<N>, counts: N::Mask| {
            let closer = surface.field.value.abs().lt(nearest.field.value.abs()) & counts;
            nearest = Surface {
                field: Dual::select(closer, surface.field, nearest.field),
                leaf: N::select(closer, surface.leaf, nearest.leaf),
            };
        };
        for (object, strategy) in self.objects.iter().zip(&self.strategies) {
            let closed = matches!(strategy, EvalStrategy::Analytic | EvalStrategy::InBvh);
            let is_evaluated = closed || *strategy == EvalStrategy::SphereTraced;
            if is_evaluated && N::any(counts(closed)) {
                add(self.tree_surface(object, p, threshold), counts(closed));
            }
        }
        for shape_grid in &self.shape_grids {
            add(shape_grid.surface(self, p, threshold, far_field), counts(false));
        }
        nearest
    }

    pub(super) fn tree_surface<N: Batch>(&self, tree: &Tree, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        match tree {
            Tree::Leaf(index) => {
                let field = self.leaves[*index as usize].surface(p);
                Surface { field, leaf: N::constant(*index as f32) }
            }
            Tree::Modifier(modified) => {
                let Modified { modifier, coefficients, pose, inside, .. } = &**modified;
                let p = pose.local(p);
                let place = if modified.copies > 1 { self.nearest_inside(modified, p).1 } else { N::zero() };
                let point = N::modifier(*modifier).point_gradient(p, place, coefficients);
                let Surface { field, leaf } = self.tree_surface(inside, point.values(), threshold);
                let inside = Dual { value: field.value, gradient: point.pulled(field.gradient) };
                Surface { field: pose.world(N::modifier(*modifier).gradient(p, inside, coefficients)), leaf }
            }
            Tree::Operator { operator, smooth, children, first_choice } => {
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
