//! The part of a line that is inside a convex solid.
//!
//! Idea: a convex solid is what half spaces, slabs and quadrics have in common, and so is its span (Kay and Kajiya 1986, "Ray
//! Tracing Complex Scenes"; Haines 1991, "Fast Ray-Convex Polyhedron Intersection"). Quadratics are solved in the form that
//! does not cancel (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection").

use crate::number::Real;

/// Ray parameter beyond every scene, metres: "no hit". Finite, so that arithmetic with it stays defined.
pub const T_MAX: f32 = 1e30;

/// The part of a line that is inside a convex solid, metres from its origin; it enters behind where it leaves if it misses.
#[derive(Clone, Copy, Debug)]
pub struct RayInterval<N> {
    /// Where it enters, or -[`T_MAX`] where it always was inside.
    pub enter: N,
    /// Where it leaves, or [`T_MAX`] where it always will be.
    pub leave: N,
}

impl<N: Real> RayInterval<N> {
    /// A line that misses.
    pub fn nowhere() -> Self {
        Self { enter: N::constant(T_MAX), leave: N::constant(-T_MAX) }
    }
    /// A line that is inside all along.
    pub fn everywhere() -> Self {
        Self { enter: N::constant(-T_MAX), leave: N::constant(T_MAX) }
    }
    /// What is below zero of a height that starts at `height` and rises by `slope`.
    #[inline(always)]
    pub fn half_space(height: N, slope: N) -> Self {
        let slope = slope.divisor();
        let t = -height / slope;
        let falls = slope.lt(N::zero());
        Self { enter: N::select(falls, t, N::constant(-T_MAX)), leave: N::select(falls, N::constant(T_MAX), t) }
    }
    /// What is within `half` of zero of a height that starts at `height` and rises by `slope`.
    #[inline(always)]
    pub fn slab(height: N, slope: N, half: N) -> Self {
        let slope = slope.divisor();
        let (a, b) = ((-half - height) / slope, (half - height) / slope);
        Self { enter: a.min(b), leave: a.max(b) }
    }
    /// Where a·t² + 2·b·t + c is not above zero, for `a` above zero; `discriminant` is b² - a·c, however it was found.
    #[inline(always)]
    pub fn quadric(a: N, b: N, c: N, discriminant: N) -> Self {
        let root = discriminant.max(N::zero()).sqrt();
        let q = (-b - root * b.sign()).named("q");
        let (one, other) = (q / a.max(N::constant(1e-20)), c / q.divisor());
        let hit = N::zero().lt(discriminant);
        let nowhere = Self::nowhere();
        Self {
            enter: N::select(hit, one.min(other), nowhere.enter),
            leave: N::select(hit, one.max(other), nowhere.leave),
        }
    }
    /// What both are inside of.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self { enter: self.enter.max(other.enter), leave: self.leave.min(other.leave) }
    }
    /// What any is inside of, where that is a span: where the line meets both, they overlap.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        // One that misses must not count.
        let empty = |span: &Self| span.leave.lt(span.enter);
        let nowhere = Self::nowhere();
        let kept = |span: &Self| {
            let gone = empty(span);
            [N::select(gone, nowhere.enter, span.enter), N::select(gone, nowhere.leave, span.leave)]
        };
        let ([a, b], [c, d]) = (kept(&self), kept(&other));
        Self { enter: a.min(c), leave: b.max(d) }
    }
    /// The first end ahead of the origin, or [`T_MAX`].
    #[inline(always)]
    pub fn ahead(self) -> N {
        let (near, far) = (self.enter.named("near"), self.leave.named("far"));
        let ahead = N::select(N::zero().lt(near), near, far);
        N::select(near.lt(far) & N::zero().lt(far), ahead, N::constant(T_MAX))
    }
}
