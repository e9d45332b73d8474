//! Interval of a line inside a convex solid.
//!
//! Idea: a convex solid is an intersection of half-spaces, slabs and quadrics; its interval is the intersection of theirs (Kay and Kajiya 1986, "Ray
//! Tracing Complex Scenes"; Haines 1991, "Fast Ray-Convex Polyhedron Intersection"). Quadratics are solved in the form that
//! does not cancel (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection").

use crate::number::Real;

/// Ray parameter beyond every scene, metres: "no hit". Finite, so that arithmetic with it stays defined.
pub const T_MAX: f32 = 1e30;

/// Interval of a line inside a convex solid, metres from its origin; empty if `enter` is above `leave`.
#[derive(Clone, Copy, Debug)]
pub struct RayInterval<N> {
    /// Ray parameter at which it enters, or -[`T_MAX`] if unbounded.
    pub enter: N,
    /// Ray parameter at which it leaves, or [`T_MAX`] if unbounded.
    pub leave: N,
}

impl<N: Real> RayInterval<N> {
    /// Empty interval of a line that misses.
    pub fn empty() -> Self {
        Self { enter: N::constant(T_MAX), leave: N::constant(-T_MAX) }
    }
    /// Unbounded interval of a line that is inside everywhere.
    pub fn unbounded() -> Self {
        Self { enter: N::constant(-T_MAX), leave: N::constant(T_MAX) }
    }
    /// Interval with `height + slope * t` below zero.
    #[inline(always)]
    pub fn half_space(height: N, slope: N) -> Self {
        let slope = slope.divisor();
        let t = -height / slope;
        let falls = slope.lt(N::zero());
        Self { enter: N::select(falls, t, N::constant(-T_MAX)), leave: N::select(falls, N::constant(T_MAX), t) }
    }
    /// Interval with `height + slope * t` within `half` of zero.
    #[inline(always)]
    pub fn slab(height: N, slope: N, half: N) -> Self {
        let slope = slope.divisor();
        let (a, b) = ((-half - height) / slope, (half - height) / slope);
        Self { enter: a.min(b), leave: a.max(b) }
    }
    /// Interval with a·t² + 2·b·t + c at most zero, for `a` above zero. `discriminant` is b² - a·c, computed by the caller in
    /// its most precise form.
    #[inline(always)]
    pub fn quadric(a: N, b: N, c: N, discriminant: N) -> Self {
        let root = discriminant.max(N::zero()).sqrt();
        let q = (-b - root * b.sign()).named("q");
        let (one, other) = (q / a.max(N::constant(1e-20)), c / q.divisor());
        let hit = N::zero().lt(discriminant);
        let empty = Self::empty();
        Self { enter: N::select(hit, one.min(other), empty.enter), leave: N::select(hit, one.max(other), empty.leave) }
    }
    /// Intersection of both intervals.
    #[inline(always)]
    pub fn intersection(self, other: Self) -> Self {
        Self { enter: self.enter.max(other.enter), leave: self.leave.min(other.leave) }
    }
    /// Union of both intervals, which must overlap unless one is empty.
    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        // Empty intervals must not extend the union.
        let is_empty = |interval: &Self| interval.leave.lt(interval.enter);
        let empty = Self::empty();
        let kept = |interval: &Self| {
            let gone = is_empty(interval);
            [N::select(gone, empty.enter, interval.enter), N::select(gone, empty.leave, interval.leave)]
        };
        let ([a, b], [c, d]) = (kept(&self), kept(&other));
        Self { enter: a.min(c), leave: b.max(d) }
    }
    /// First end with a positive ray parameter, or [`T_MAX`].
    #[inline(always)]
    pub fn first_hit(self) -> N {
        let (near, far) = (self.enter.named("near"), self.leave.named("far"));
        let ahead = N::select(N::zero().lt(near), near, far);
        N::select(near.lt(far) & N::zero().lt(far), ahead, N::constant(T_MAX))
    }
}
