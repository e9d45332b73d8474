//! Objects that rays meet in closed form: shapes whose intersection with a line is known, and sharp combinations of convex
//! ones.
//!
//! Idea: a line is inside a convex solid along one span, and inside a union, intersection or difference of such wherever the
//! same operation on truth values says so (Roth 1982, "Ray Casting for Modeling Solids"). The surfaces along a ray are those
//! ends of spans at which that changes. We differ from Roth, who merges sorted lists: every end is asked whether the solid is
//! there just before it and just behind it, which needs no list, has no branch, and is the same code for one ray and for
//! eight. Faces that touch or coincide need no margin: of two equal ends, what is before and behind both is the same.
//! Cost: for N shapes, N intersections and 4N² pairs of comparisons; nothing is marched.

use super::Batch;
use super::{Field, Tree};
use crate::number::{Real, Vec3};
use crate::operators::Boolean;
use crate::ray_interval::RayInterval;

/// The most shapes of a combination that is met in closed form: beyond it marching costs less.
const MOST_SHAPES: usize = 12;

/// Where a point is seen from: it counts as inside a span whose end it is on this side of.
#[derive(Clone, Copy)]
enum Side {
    Before,
    Behind,
}

impl Field {
    /// Whether rays meet an object in closed form.
    pub(super) fn is_analytic(&self, object: &Tree) -> bool {
        match object {
            Tree::Leaf(_) => self.direct(object).is_some(),
            _ => !self.sphere_traces_all && self.convex_shapes(object).is_some_and(|count| count <= MOST_SHAPES),
        }
    }

    /// How many shapes there are in a sharp combination of convex ones; `None` if it is something else.
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

    /// Remembers which shapes of a combination are taken away from it.
    pub(super) fn mark_subtracted(&mut self, tree: &Tree, subtracted: bool) {
        match tree {
            Tree::Leaf(index) => self.leaves[*index as usize].subtracted = subtracted,
            Tree::Operator { operator, children, .. } => {
                let taken_away = operator.boolean() == Some(Boolean::Difference);
                for (k, child) in children.iter().enumerate() {
                    self.mark_subtracted(child, subtracted != (taken_away && k > 0));
                }
            }
            Tree::Modifier(_) => {}
        }
    }

    /// The first hit so far, metres along a ray and the number of the leaf, or that of an object which is met in closed form
    /// where that is nearer.
    pub(super) fn object_hit<N: Batch>(
        &self,
        object: &Tree,
        origin: Vec3<N>,
        direction: Vec3<N>,
        first: (N, N),
    ) -> (N, N) {
        let nearer = |(nearest, met): (N, N), t: N, counts: N::Mask, leaf: u32| {
            let counts = counts & t.lt(nearest);
            (N::select(counts, t, nearest), N::select(counts, N::constant(leaf as f32), met))
        };
        if let Some(index) = self.direct(object) {
            let t = self.leaves[index as usize].ray(origin, direction);
            return nearer(first, t, N::truth(true), index);
        }
        let mut spans = Spans { first: u32::MAX, ends: [[N::zero(); 2]; MOST_SHAPES], count: 0 };
        self.collect(object, origin, direction, &mut spans);
        let mut hit = first;
        for (k, ends) in (0..).zip(&spans.ends[..spans.count]) {
            for &t in ends {
                let [before, behind] = [Side::Before, Side::Behind].map(|side| spans.holds(object, t, side));
                let changes = (before & !behind) | (behind & !before);
                hit = nearer(hit, t, changes & N::zero().lt(t), spans.first + k);
            }
        }
        hit
    }

    fn collect<N: Batch>(&self, tree: &Tree, origin: Vec3<N>, direction: Vec3<N>, spans: &mut Spans<N>) {
        match tree {
            Tree::Leaf(index) => {
                let RayInterval { enter, leave } = self.leaves[*index as usize].interval(origin, direction);
                spans.first = spans.first.min(*index);
                if let Some(ends) = spans.ends.get_mut(spans.count) {
                    *ends = [enter, leave];
                    spans.count += 1;
                }
            }
            Tree::Operator { children, .. } => {
                children.iter().for_each(|child| self.collect(child, origin, direction, spans));
            }
            Tree::Modifier(_) => {}
        }
    }
}

/// Where a line is inside each shape of an object, whose leaves follow each other.
struct Spans<N> {
    first: u32,
    ends: [[N; 2]; MOST_SHAPES],
    count: usize,
}

impl<N: Real> Spans<N> {
    /// Whether the object holds the points just before or just behind `t`.
    fn holds(&self, tree: &Tree, t: N, side: Side) -> N::Mask {
        match tree {
            Tree::Leaf(index) => {
                let [enter, leave] = self.ends[(index - self.first) as usize];
                match side {
                    Side::Before => enter.lt(t) & !leave.lt(t),
                    Side::Behind => !t.lt(enter) & t.lt(leave),
                }
            }
            Tree::Operator { operator, children, .. } => {
                let mut held = self.holds(&children[0], t, side);
                for child in &children[1..] {
                    let other = self.holds(child, t, side);
                    held = match operator.boolean() {
                        Some(Boolean::Intersection) => held & other,
                        Some(Boolean::Difference) => held & !other,
                        _ => held | other,
                    };
                }
                held
            }
            Tree::Modifier(_) => N::truth(false),
        }
    }
}
