//! What rays have met: the point on the surface, its normal and its leaf, eight at a time.

use super::march::{Hit, March, Rays8, lanes, rounding_at, start_offset};
use crate::frame::{DIRECT, Prepared, SHEET};
use glam::Vec3;
use pathmarch_field::graph::Surface;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

/// What a ray has met.
#[derive(Clone, Copy, Debug)]
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
    pub(crate) length: f32,
}

impl Visible {
    /// The normal on the outside.
    pub(crate) fn outward(&self) -> Vec3 {
        if self.inside { -self.normal } else { self.normal }
    }
}

/// The surfaces that rays have met. Where materials blend, the second one shows if its weight exceeds the threshold of this ray and
/// blend.
pub(crate) fn visible(
    prepared: &Prepared,
    met: &[(March, Hit)],
    threshold: impl Fn(usize, u32) -> f32,
) -> Vec<Visible> {
    let mut result = Vec::with_capacity(met.len());
    for (number, chunk) in met.chunks(8).enumerate() {
        let of_lane = |lane: usize| lane.min(chunk.len() - 1);
        let rays = Rays8::new(chunk.iter().map(|(march, _)| march));
        let t = lanes(|lane| chunk[of_lane(lane)].1.t);
        let reached = rays.origin + rays.direction * t;
        let direct = lanes(|lane| Hit::met(chunk[of_lane(lane)].1.direct));
        let threshold = |blend| lanes(|lane| threshold(8 * number + of_lane(lane), blend));
        let Surface { field, leaf } = prepared.field.surface_at_hit(reached, direct, &threshold);
        let leaf: [usize; 8] = leaf.to_array().map(|leaf| leaf as usize);
        let record = |lane: usize| &prepared.leaves[leaf[lane]];
        let at = FieldVec3::new(
            lanes(|lane| record(lane).at[0]),
            lanes(|lane| record(lane).at[1]),
            lanes(|lane| record(lane).at[2]),
        );
        let is_direct = lanes(|lane| f32::from(record(lane).flags & DIRECT != 0));

        let inverse = f32x8::ONE / field.gradient.length().fast_max(f32x8::splat(1e-6));
        let outward = field.gradient * inverse;
        let left = field.value * inverse;
        let off = rounding_at(&prepared.frame, reached, at);
        // On the surface but for rounding, the side is the one the ray comes from; else the field says it.
        let doubt = off + f32x8::splat(prepared.frame.rounding) * t;
        let on_surface = Mask8(f32x8::ZERO.simd_lt(is_direct)) | Mask8(field.value.abs().simd_le(doubt));
        let inside = Real::select(on_surface, -outward.dot(rays.direction), field.value).simd_lt(f32x8::ZERO);
        let normal = outward * Real::select(Mask8(inside), f32x8::splat(-1.0), f32x8::ONE);
        let (p, away) = (apart(reached - outward * left), apart(normal * start_offset(off, left)));
        let (normal, inside) = (apart(normal), inside.to_bitmask());
        result.extend(chunk.iter().enumerate().map(|(lane, (march, hit))| Visible {
            p: p[lane],
            leaf: leaf[lane],
            normal: normal[lane],
            inside: inside >> lane & 1 == 1,
            away: away[lane],
            length: march.before + hit.t,
        }));
    }
    result
}

/// The vector of each lane.
fn apart(v: FieldVec3<f32x8>) -> [Vec3; 8] {
    let [x, y, z] = [v.x, v.y, v.z].map(f32x8::to_array);
    std::array::from_fn(|lane| Vec3::new(x[lane], y[lane], z[lane]))
}

/// Whether a leaf shines on the side of this normal: sheets do on one side only.
pub(super) fn shines(prepared: &Prepared, leaf: usize, normal: Vec3) -> bool {
    let leaf = &prepared.leaves[leaf];
    leaf.flags & SHEET == 0 || normal.dot(Vec3::from(leaf.facing)) > 0.0
}
