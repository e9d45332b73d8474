//! Surface interactions: position, normal, side and leaf of hits, eight at a time.

use crate::intersect::march::{rounding_at, start_offset};
use crate::intersect::ray::{Hit, RaySegment, Rays8, lanes};
use crate::scene::TraceContext;
use crate::scene::leaf::ANALYTIC;
use glam::Vec3;
use pathmarch_field::graph::Surface;
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use wide::f32x8;

/// Surface at the hit of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceInteraction {
    /// Position on the surface, in world space.
    pub(crate) p: Vec3,
    /// Leaf of the field; of blended leaves the one that shows.
    pub(crate) leaf: usize,
    /// Unit geometric normal on the side of the ray's origin.
    pub(crate) normal: Vec3,
    /// Whether that side is the inside of the solid.
    pub(crate) inside: bool,
    /// Offset from `p` to the origin of rays that leave on this side.
    pub(crate) normal_offset: Vec3,
    /// Length of the path up to here, metres.
    pub(crate) length: f32,
}

impl SurfaceInteraction {
    /// Unit normal that points out of the solid.
    pub(crate) fn outward(&self) -> Vec3 {
        if self.inside { -self.normal } else { self.normal }
    }
}

/// Surface interactions of hits. Where materials blend, the second one shows if its weight exceeds the threshold of this ray and
/// blend.
pub(crate) fn interactions(
    ctx: &TraceContext,
    hits: &[(RaySegment, Hit)],
    threshold: impl Fn(usize, u32) -> f32,
) -> Vec<SurfaceInteraction> {
    let mut result = Vec::with_capacity(hits.len());
    for (number, chunk) in hits.chunks(8).enumerate() {
        let of_lane = |lane: usize| lane.min(chunk.len() - 1);
        let rays = Rays8::new(chunk.iter().map(|(segment, _)| segment));
        let t = lanes(|lane| chunk[of_lane(lane)].1.t);
        let reached = rays.origin + rays.direction * t;
        let analytic = lanes(|lane| Hit::encoded(chunk[of_lane(lane)].1.analytic));
        let threshold = |blend| lanes(|lane| threshold(8 * number + of_lane(lane), blend));
        let Surface { field, leaf } = ctx.scene.field.surface_at_hit(reached, analytic, &threshold);
        let leaf: [usize; 8] = leaf.to_array().map(|leaf| leaf as usize);
        let record = |lane: usize| &ctx.scene.leaves[leaf[lane]];
        let at = FieldVec3::new(
            lanes(|lane| record(lane).at[0]),
            lanes(|lane| record(lane).at[1]),
            lanes(|lane| record(lane).at[2]),
        );
        let is_analytic = lanes(|lane| f32::from(record(lane).has(ANALYTIC)));

        let inverse = f32x8::ONE / field.gradient.length().fast_max(f32x8::splat(1e-6));
        let outward = field.gradient * inverse;
        let left = field.value * inverse;
        let off = rounding_at(ctx.frame, reached, at);
        // Within rounding of the surface, the direction of the ray decides the side; elsewhere the sign of the field does.
        let doubt = off + f32x8::splat(ctx.frame.rounding) * t;
        let on_surface = Mask8(f32x8::ZERO.simd_lt(is_analytic)) | Mask8(field.value.abs().simd_le(doubt));
        let inside = Real::select(on_surface, -outward.dot(rays.direction), field.value).simd_lt(f32x8::ZERO);
        let normal = outward * Real::select(Mask8(inside), f32x8::splat(-1.0), f32x8::ONE);
        let (p, normal_offset) = (to_lanes(reached - outward * left), to_lanes(normal * start_offset(off, left)));
        let (normal, inside) = (to_lanes(normal), inside.to_bitmask());
        result.extend(chunk.iter().enumerate().map(|(lane, (segment, hit))| SurfaceInteraction {
            p: p[lane],
            leaf: leaf[lane],
            normal: normal[lane],
            inside: inside >> lane & 1 == 1,
            normal_offset: normal_offset[lane],
            length: segment.path_length + hit.t,
        }));
    }
    result
}

/// Vector of each lane.
fn to_lanes(v: FieldVec3<f32x8>) -> [Vec3; 8] {
    let [x, y, z] = [v.x, v.y, v.z].map(f32x8::to_array);
    std::array::from_fn(|lane| Vec3::new(x[lane], y[lane], z[lane]))
}
