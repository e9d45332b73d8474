//! What the ray of a mode without noise has met: the point on the surface, its normal and its leaf.

use super::camera::Ray;
use super::march::{Hit, March, rounding_at, start_offset};
use super::path::{facing, near};
use super::steady;
use crate::frame::{Prepared, SHEET};
use glam::Vec3;
use wide::f32x8;

/// What a ray has met.
pub(crate) struct Visible {
    /// On the surface.
    pub(crate) p: Vec3,
    pub(crate) leaf: usize,
    /// On the side that the ray comes from, of length one.
    pub(crate) normal: Vec3,
    /// Whether that side is the inside of the solid.
    pub(super) inside: bool,
    /// From `p` to where rays start on this side.
    pub(super) away: Vec3,
    /// Length of the path to it, metres.
    pub(super) length: f32,
}

impl Visible {
    /// The normal on the outside.
    pub(super) fn outward(&self) -> Vec3 {
        if self.inside { -self.normal } else { self.normal }
    }
}

/// The surfaces at the ends of rays, eight at a time; blends as in this sample.
pub(crate) fn visible(prepared: &Prepared, rays: &[(March, Hit)], sample: u32) -> Vec<Visible> {
    let mut result = Vec::with_capacity(rays.len());
    for chunk in rays.chunks(8) {
        let lane = |k: usize| chunk.get(k).unwrap_or(&chunk[0]);
        let reached: [Vec3; 8] = std::array::from_fn(|k| lane(k).0.ray.origin + lane(k).0.ray.direction * lane(k).1.t);
        let direct = f32x8::from(std::array::from_fn(|k| Hit::met(lane(k).1.direct)));
        let threshold = |index| f32x8::splat(steady::threshold(sample, index));
        let surfaces = near(reached, |p| prepared.field.surface_met(p, direct, &threshold));
        for ((&(March { ray, before, .. }, hit), near), reached) in chunk.iter().zip(&surfaces).zip(reached) {
            let steepness = near.gradient.length().max(1e-6);
            let outward = near.gradient / steepness;
            let normal = facing(prepared, near, outward, &Ray { origin: reached, ..ray }, hit.t);
            let off = rounding_at(&prepared.frame, reached, Vec3::from(prepared.leaves[near.leaf].at));
            let left = near.distance / steepness;
            result.push(Visible {
                p: reached - outward * left,
                leaf: near.leaf,
                normal,
                inside: normal.dot(outward) < 0.0,
                away: normal * start_offset(off, left),
                length: before + hit.t,
            });
        }
    }
    result
}

/// Whether a leaf shines on the side of this normal: sheets do on one side only.
pub(super) fn shines(prepared: &Prepared, leaf: usize, normal: Vec3) -> bool {
    let leaf = &prepared.leaves[leaf];
    leaf.flags & SHEET == 0 || normal.dot(Vec3::from(leaf.facing)) > 0.0
}
