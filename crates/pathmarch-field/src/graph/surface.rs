//! Surfaces of a field on the CPU: distance, gradient, and the leaf whose material shows.

use super::far_field::FarField;
use super::{Batch, EvalStrategy, Field, Modified, RayKind, Tree};
use crate::number::{Dual, Real, Vec3};

/// Nearest surface to a point.
#[derive(Clone, Copy, Debug)]
pub struct Surface<N> {
    /// Signed distance, metres, and its gradient.
    pub field: Dual<N>,
    /// Index into [`Field::leaves`] of the leaf whose material shows.
    pub leaf: N,
}

impl Field {
    /// Surface of the nearest object to each point: signed distance to that object, gradient, and the leaf whose material
    /// shows. Smooth operators blend materials at random: each shows with the probability of its weight, by the point's seed.
    pub fn surface<N: Batch>(&self, p: Vec3<N>, seeds: N::Seeds) -> Surface<N> {
        self.nearest_surface(p, |_| N::truth(true), &|index| N::choice(seeds, index), FarField::Exact)
    }

    /// Surface of the union at each point: that of the object with the least signed distance, as in
    /// [`distance`](Self::distance). Thresholds are as in [`surface_at_hit`](Self::surface_at_hit).
    pub fn union_surface<N: Batch>(&self, p: Vec3<N>, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let mut least = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        for object in &self.objects {
            let surface = self.tree_surface(object, p, threshold, FarField::Exact);
            let is_less = surface.field.value.lt(least.field.value);
            least = Surface {
                field: Dual::select(is_less, surface.field, least.field),
                leaf: N::select(is_less, surface.leaf, least.leaf),
            };
        }
        least
    }

    /// Surface at the hit of a ray at each point, as [`surface`](Self::surface). `hit_leaf` is the leaf returned by
    /// [`analytic_hit`](Self::analytic_hit), or [`SPHERE_TRACED`](super::SPHERE_TRACED) for the nearest sphere-traced object.
    /// In a smooth operator, the second material shows if its weight exceeds the threshold of the blend's index:
    /// [`Batch::choice`], or 0.5 for the larger weight.
    pub fn surface_at_hit<N: Batch>(&self, p: Vec3<N>, hit_leaf: N, threshold: &dyn Fn(u32) -> N) -> Surface<N> {
        let leaves = hit_leaf.lanes();
        let mut result = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        let mut left = (1 << N::LANES) - 1;
        let sphere_traced = N::bits(hit_leaf.lt(N::zero()));
        if sphere_traced != 0 {
            result = self.nearest_surface(p, |analytic| N::truth(!analytic), threshold, FarField::Estimate);
            left &= !sphere_traced;
        }
        while left != 0 {
            let leaf = leaves[left.trailing_zeros() as usize];
            let is_hit = (hit_leaf - N::constant(leaf)).abs().lt(N::constant(0.5));
            left &= (left - 1) & !N::bits(is_hit);
            let shape = self.leaves.get(leaf as usize);
            let shape = shape.filter(|leaf| !self.has_triangles() || !leaf.is_triangles());
            if let Some(shape) = shape {
                let field = shape.surface_at_hit(p);
                result = Surface {
                    field: Dual::select(is_hit, field, result.field),
                    leaf: N::select(is_hit, N::constant(leaf), result.leaf),
                };
            }
        }
        result
    }

    fn nearest_surface<N: Batch>(
        &self,
        p: Vec3<N>,
        is_included: impl Fn(bool) -> N::Mask,
        threshold: &dyn Fn(u32) -> N,
        far_field: FarField,
    ) -> Surface<N> {
        let mut nearest = Surface { field: Dual::independent(N::constant(f32::INFINITY)), leaf: N::zero() };
        let mut add = |surface: Surface<N>, is_included: N::Mask| {
            let closer = surface.field.value.abs().lt(nearest.field.value.abs()) & is_included;
            nearest = Surface {
                field: Dual::select(closer, surface.field, nearest.field),
                leaf: N::select(closer, surface.leaf, nearest.leaf),
            };
        };
        if N::any(is_included(true)) {
            for (object, strategy) in self.objects.iter().zip(&self.strategies) {
                if matches!(strategy, EvalStrategy::Analytic | EvalStrategy::InBvh | EvalStrategy::Triangles) {
                    add(self.tree_surface(object, p, threshold, far_field), is_included(true));
                }
            }
        }
        for object in self.objects_sphere_traced_by(RayKind::Secondary) {
            add(self.tree_surface(object, p, threshold, far_field), is_included(false));
        }
        if let Some(shape_grid) = self.separate_shape_grid() {
            add(shape_grid.surface(self, p, threshold, far_field), is_included(false));
        }
        nearest
    }

    pub(super) fn tree_surface<N: Batch>(
        &self,
        tree: &Tree,
        p: Vec3<N>,
        threshold: &dyn Fn(u32) -> N,
        far_field: FarField,
    ) -> Surface<N> {
        match tree {
            Tree::Leaf(index) => {
                let field = self.leaves[*index as usize].surface(p);
                Surface { field, leaf: N::constant(*index as f32) }
            }
            Tree::Modifier(modified) => {
                let Modified { modifier, coefficients, pose, inside, .. } = &**modified;
                let p = pose.local(p);
                let copy = if modified.copies > 1 { self.nearest_copy(modified, p, far_field).1 } else { N::zero() };
                let point = N::modifier(*modifier).point_gradient(p, copy, coefficients);
                let Surface { field, leaf } = self.tree_surface(inside, point.values(), threshold, far_field);
                let inside = Dual { value: field.value, gradient: point.pulled_back(field.gradient) };
                Surface { field: pose.world(N::modifier(*modifier).gradient(p, inside, coefficients)), leaf }
            }
            Tree::Operator { shape_grid: Some(index), .. } => {
                self.shape_grids[*index as usize].surface(self, p, threshold, far_field)
            }
            Tree::Operator { operator, smooth, children, first_choice, .. } => {
                let mut result = self.tree_surface(&children[0], p, threshold, far_field);
                for (k, child) in children[1..].iter().enumerate() {
                    let other = self.tree_surface(child, p, threshold, far_field);
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
