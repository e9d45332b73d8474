//! Bounding box of a modifier's child or result, as coefficients that its functions read.

use crate::bounds::Aabb;
use crate::number::{Real, Vec3};

/// Finite stand-in for an infinite coordinate, metres.
pub(super) const ENDLESS: f32 = 1e30;

/// Corners of a box as coefficients, finite.
pub(super) fn corners(bounds: Aabb) -> [f32; 6] {
    let finite = |v: f32| v.clamp(-ENDLESS, ENDLESS);
    let ([a, b, c], [d, e, f]) = (bounds.min.map(finite), bounds.max.map(finite));
    [a, b, c, d, e, f]
}

/// Signed distance to a box given by its corners, metres.
#[inline(always)]
pub(super) fn box_distance<N: Real>(p: Vec3<N>, [x, y, z, xx, yy, zz]: [N; 6]) -> N {
    let outside = Vec3::new((x - p.x).max(p.x - xx), (y - p.y).max(p.y - yy), (z - p.z).max(p.z - zz));
    outside.max(N::zero()).length() + outside.largest().min(N::zero())
}

/// Largest distance of a box's points from an axis; `a` and `b` are the other two axes.
pub(super) fn reach(bounds: Aabb, a: usize, b: usize) -> f32 {
    let far = |k: usize| bounds.min[k].abs().max(bounds.max[k].abs());
    far(a).hypot(far(b)).clamp(1e-6, ENDLESS)
}
