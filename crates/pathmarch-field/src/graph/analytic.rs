//! Analytic objects: shapes that rays intersect in closed form, and constructive solid geometry of convex shapes.
//!
//! Idea: a line is inside a convex solid along one interval, and inside a union, intersection or difference wherever the same
//! Boolean operation on the intervals holds (Roth 1982, "Ray Casting for Modeling Solids"). The surfaces along a ray are the
//! interval ends at which the result changes. We differ from Roth, who merges sorted lists: each end is tested for whether
//! the solid is just before and just behind it. That needs no list and no branch, and is the same code for one ray and for
//! eight. Faces that touch or coincide need no margin: two equal ends have the same before and behind.
//! Cost: for N shapes, N intersections and 4N² pairs of comparisons; no sphere tracing.

use super::Batch;
use super::{Field, Tree, bvh};
use crate::number::{Real, Vec3};
use crate::operators::Boolean;
use crate::ray_interval::RayInterval;

/// Largest number of shapes of an analytic combination; beyond it sphere tracing is cheaper.
const MAX_SHAPES: usize = 12;

/// Object that rays intersect by itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnalyticObject {
    /// Index of the object.
    pub(super) object: u32,
    /// Leaf of an object that is a single shape.
    pub(super) leaf: Option<u32>,
}

/// Side of an interval's end that is tested.
#[derive(Clone, Copy)]
enum Side {
    Before,
    Behind,
}

impl Field {
    /// Reports whether an object is analytic.
    pub(super) fn is_analytic(&self, object: &Tree) -> bool {
        match object {
            Tree::Leaf(_) => self.direct(object).is_some(),
            _ => !self.sphere_traces_all && self.convex_shapes(object).is_some_and(|count| count <= MAX_SHAPES),
        }
    }

    /// Number of shapes in a sharp combination of convex shapes; `None` for any other tree.
    fn convex_shapes(&self, tree: &Tree) -> Option<usize> {
        match tree {
            Tree::Leaf(index) => self.leaves[*index as usize].shape.is_convex().then_some(1),
            Tree::Modifier(_) => None,
            Tree::Operator { operator, smooth, children, .. } => {
                operator.boolean().filter(|_| smooth.is_none())?;
                children.iter().map(|child| self.convex_shapes(child)).sum()
            }
        }
    }

    /// Marks the shapes that a combination subtracts.
    pub(super) fn mark_subtracted(&mut self, tree: &Tree, subtracted: bool) {
        match tree {
            Tree::Leaf(index) => self.leaves[*index as usize].subtracted = subtracted,
            Tree::Operator { operator, children, .. } => {
                let subtracts = operator.boolean() == Some(Boolean::Difference);
                for (k, child) in children.iter().enumerate() {
                    self.mark_subtracted(child, subtracted != (subtracts && k > 0));
                }
            }
            Tree::Modifier(_) => {}
        }
    }

    /// Hit of a ray with an analytic object, metres and leaf; or the one found before, if that is nearer.
    #[inline]
    pub(super) fn object_hit<N: Batch>(
        &self,
        &AnalyticObject { object, leaf }: &AnalyticObject,
        origin: Vec3<N>,
        direction: Vec3<N>,
        first: (N, N),
    ) -> (N, N) {
        let nearer = |(nearest, hit_leaf): (N, N), t: N, is_hit: N::Mask, leaf: u32| {
            let is_hit = is_hit & t.lt(nearest);
            (N::select(is_hit, t, nearest), N::select(is_hit, N::constant(leaf as f32), hit_leaf))
        };
        if let Some(index) = leaf {
            let t = self.leaves[index as usize].ray(origin, direction);
            let is_hit = t.lt(first.0);
            return (t.min(first.0), N::select(is_hit, N::constant(index as f32), first.1));
        }
        let bounds = self.object_bounds[object as usize];
        if bounds.is_finite() && !bvh::enters(bounds, origin, bvh::inverse(direction), first.0) {
            return first;
        }
        let object = &self.objects[object as usize];
        let mut intervals = Intervals { first: u32::MAX, ends: [[N::zero(); 2]; MAX_SHAPES], count: 0 };
        self.collect(object, origin, direction, &mut intervals);
        let mut hit = first;
        for (k, ends) in (0..).zip(&intervals.ends[..intervals.count]) {
            let [enter, leave] = *ends;
            // The ends of a shape that the line misses may equal those of another.
            let is_entered = enter.lt(leave);
            for t in [enter, leave] {
                let [before, behind] = [Side::Before, Side::Behind].map(|side| intervals.contains(object, t, side));
                let changes = (before & !behind) | (behind & !before);
                hit = nearer(hit, t, changes & is_entered & N::zero().lt(t), intervals.first + k);
            }
        }
        hit
    }

    fn collect<N: Batch>(&self, tree: &Tree, origin: Vec3<N>, direction: Vec3<N>, intervals: &mut Intervals<N>) {
        match tree {
            Tree::Leaf(index) => {
                let RayInterval { enter, leave } = self.leaves[*index as usize].interval(origin, direction);
                intervals.first = intervals.first.min(*index);
                if let Some(ends) = intervals.ends.get_mut(intervals.count) {
                    *ends = [enter, leave];
                    intervals.count += 1;
                }
            }
            Tree::Operator { children, .. } => {
                children.iter().for_each(|child| self.collect(child, origin, direction, intervals));
            }
            Tree::Modifier(_) => {}
        }
    }
}

/// Intervals of a line inside the shapes of an object, whose leaves are consecutive.
struct Intervals<N> {
    first: u32,
    ends: [[N; 2]; MAX_SHAPES],
    count: usize,
}

impl<N: Real> Intervals<N> {
    /// Reports whether the object contains the points just before or just behind `t`.
    fn contains(&self, tree: &Tree, t: N, side: Side) -> N::Mask {
        match tree {
            Tree::Leaf(index) => {
                let [enter, leave] = self.ends[(index - self.first) as usize];
                match side {
                    Side::Before => enter.lt(t) & !leave.lt(t),
                    Side::Behind => !t.lt(enter) & t.lt(leave),
                }
            }
            Tree::Operator { operator, children, .. } => {
                let mut inside = self.contains(&children[0], t, side);
                for child in &children[1..] {
                    let other = self.contains(child, t, side);
                    inside = match operator.boolean() {
                        Some(Boolean::Intersection) => inside & other,
                        Some(Boolean::Difference) => inside & !other,
                        _ => inside | other,
                    };
                }
                inside
            }
            Tree::Modifier(_) => N::truth(false),
        }
    }
}
