//! Soft shadows in few steps, for previews.
//!
//! **Idea.** As for a `penumbra` ([`shadow`](crate::integrator::shadow)), near misses of a shadow ray dim the light,
//! relative to the cone that the light subtends. Here, steps are at least half the radius of that cone, so that rays
//! along a surface do not use up their steps. A surface that such a step may skip counts as occluder. The nearest miss
//! between two steps is estimated from the distances at both; without it, long steps would cause bands. A convex
//! surface does not shadow itself.
//!
//! **Source.** Quilez 2010, "Soft shadows in raymarched SDFs", with the improvement by Aaltonen that he describes
//! there.
//!
//! **Cost.** At most 96 evaluations of the occluders, eight rays at a time; ten to twenty for most rays.

use crate::intersect::march::tolerance;
use crate::intersect::ray::{Ray, lanes};
use crate::scene::TraceContext;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3};
use wide::f32x8;

shared_constants! {
    /// Largest number of steps of a shadow ray.
    const SHADOW_STEPS: u32 = 96;
    /// Smallest step, in radii of the light's cone.
    const MIN_STEP: f32 = 0.5;
    /// Smallest value of the longest step divided by the distance so far; the first step has no limit.
    const MAX_STEP: f32 = 0.3;
    /// Longest step divided by the distance so far and by the sharpness. In wide cones, longer steps would cause bands.
    const MAX_STEP_BY_SHARPNESS: f32 = 0.05;
    /// Visibility that counts as full shadow: a step may skip a surface at up to half its length.
    const SHADOWED_VISIBILITY: f32 = 0.5 * MIN_STEP;
}

/// Shadow ray of a preview.
#[derive(Clone, Copy)]
pub(super) struct ShadowRay {
    pub(super) ray: Ray,
    /// Leaf that the ray starts on.
    pub(super) leaf: usize,
    /// Distance of the light, metres.
    pub(super) limit: f32,
    /// One over the tangent of half the angle that the light subtends.
    pub(super) sharpness: f32,
}

/// Visibility of a light along each of eight rays. Objects that are not in `occluders` cast no shadows.
pub(super) fn soft_shadows(ctx: &TraceContext, occluders: &[bool], rays: [ShadowRay; 8]) -> [f32; 8] {
    let frame = ctx.frame;
    let lanes_of = |value: &dyn Fn(&ShadowRay) -> f32| lanes(|k| value(&rays[k]));
    let vector = |value: fn(&Ray) -> Vec3| {
        let component = |k: usize| lanes_of(&|shadow_ray| value(&shadow_ray.ray)[k]);
        FieldVec3::new(component(0), component(1), component(2))
    };
    let (origin, direction) = (vector(|ray| ray.origin), vector(|ray| ray.direction));
    let (leaf, sharpness) =
        (lanes_of(&|shadow_ray| shadow_ray.leaf as f32), lanes_of(&|shadow_ray| shadow_ray.sharpness));
    let t_max = lanes_of(&|shadow_ray| shadow_ray.limit.min(frame.far));
    let start = lanes_of(&|shadow_ray| tolerance(frame, shadow_ray.ray.origin, 0.0));
    let (step_factor, min_step) = (f32x8::splat(frame.step_factor), f32x8::splat(MIN_STEP) / sharpness);
    let max_step_share = f32x8::splat(MAX_STEP).fast_max(f32x8::splat(MAX_STEP_BY_SHARPNESS) * sharpness);
    let (two, at_infinity) = (f32x8::splat(2.0), f32x8::splat(1e30));
    let state = [f32x8::ONE, start, at_infinity];
    let [visibility, ..] =
        f32x8::iterate(f32x8::splat(SHADOW_STEPS as f32), SHADOW_STEPS, state, |[visibility, t, previous]| {
            let distance = ctx.scene.field.distance_to(origin + direction * t, occluders, leaf) * step_factor;
            // Distance back to the nearest miss, if that is within the last step.
            let back_estimate = distance * distance / (two * previous);
            let back = Real::select(back_estimate.lt(previous), back_estimate, f32x8::ZERO);
            let nearest_miss = (distance * distance - back * back).fast_max(f32x8::ZERO).sqrt();
            let visibility = visibility.fast_min(sharpness * nearest_miss / (t - back));
            let max_step = Real::select(previous.lt(at_infinity), t * max_step_share, at_infinity);
            let step = distance.fast_min(max_step).fast_max(t * min_step);
            let t = t + step;
            ([visibility, t, step], !(visibility.lt(f32x8::splat(SHADOWED_VISIBILITY)) | t_max.lt(t)))
        });
    visibility.to_array().map(|visibility| {
        let visibility = (visibility - SHADOWED_VISIBILITY).max(0.0) / (1.0 - SHADOWED_VISIBILITY);
        // Smoothstep.
        visibility * visibility * (3.0 - 2.0 * visibility)
    })
}
