//! Soft shadows in few steps, for previews.
//!
//! **Idea.** As [`shadow`](super::shadow) does for a `penumbra`, a march dims light by its nearest misses, relative to the cone
//! that the light fills. Here the steps are at least half the radius of that cone, so that rays along a surface do not use
//! them up; what such a step may pass is in the shadow. The miss between two steps is guessed from the distances at both,
//! without which long steps would be seen as bands. A convex surface does not hide light from itself.
//!
//! **Source.** Quilez 2010, "Soft shadows in raymarched SDFs", with the improvement by Aaltonen that he gives there.
//!
//! **Cost.** At most 96 evaluations of what casts shadows, eight rays at a time; ten to twenty in most places.

use crate::intersect::march::tolerance;
use crate::intersect::ray::{Ray, lanes};
use crate::scene::TraceContext;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::{Real, Vec3 as FieldVec3};
use wide::f32x8;

shared_constants! {
    const SHADOW_STEPS: u32 = 96;
    /// A step is at least this part of the radius of the light's cone.
    const COARSE: f32 = 0.5;
    /// But for the first one, a step is at most this part of the way so far, times the sharpness where that is more: in wide
    /// cones, longer steps are seen as bands.
    const LONGEST: f32 = 0.3;
    const LONGEST_OF_CONE: f32 = 0.05;
    /// A long step may pass a surface no farther than half of it: so near is in the shadow.
    const PASSED: f32 = 0.5 * COARSE;
}

/// What asks for a shadow.
#[derive(Clone, Copy)]
pub(super) struct ShadowRay {
    pub(super) ray: Ray,
    /// The leaf that it starts on.
    pub(super) own: usize,
    /// Where the light is, metres.
    pub(super) limit: f32,
    /// One over the tangent of half the angle that the light fills.
    pub(super) sharpness: f32,
}

/// What is left of a light along each of eight rays; of the objects, only `occluders` hide anything.
pub(super) fn soft_shadows(ctx: &TraceContext, occluders: &[bool], rays: [ShadowRay; 8]) -> [f32; 8] {
    let frame = ctx.frame;
    let number = |value: &dyn Fn(&ShadowRay) -> f32| lanes(|k| value(&rays[k]));
    let vector = |value: fn(&Ray) -> Vec3| {
        let part = |k: usize| number(&|one| value(&one.ray)[k]);
        FieldVec3::new(part(0), part(1), part(2))
    };
    let (origin, direction) = (vector(|ray| ray.origin), vector(|ray| ray.direction));
    let (own, sharpness) = (number(&|one| one.own as f32), number(&|one| one.sharpness));
    let last = number(&|one| one.limit.min(frame.far));
    let start = number(&|one| tolerance(frame, one.ray.origin, 0.0));
    let (factor, least) = (f32x8::splat(frame.step_factor), f32x8::splat(COARSE) / sharpness);
    let longest = f32x8::splat(LONGEST).fast_max(f32x8::splat(LONGEST_OF_CONE) * sharpness);
    let (two, at_infinity) = (f32x8::splat(2.0), f32x8::splat(1e30));
    let state = [f32x8::ONE, start, at_infinity];
    let [light, ..] = f32x8::iterate(f32x8::splat(SHADOW_STEPS as f32), SHADOW_STEPS, state, |[light, t, previous]| {
        let distance = ctx.scene.field.distance_to(origin + direction * t, occluders, own) * factor;
        // How far back the ray was nearest, unless that was before the last step.
        let guess = distance * distance / (two * previous);
        let back = Real::select(guess.lt(previous), guess, f32x8::ZERO);
        let nearest = (distance * distance - back * back).fast_max(f32x8::ZERO).sqrt();
        let light = light.fast_min(sharpness * nearest / (t - back));
        let most = Real::select(previous.lt(at_infinity), t * longest, at_infinity);
        let step = distance.fast_min(most).fast_max(t * least);
        let t = t + step;
        ([light, t, step], !(light.lt(f32x8::splat(PASSED)) | last.lt(t)))
    });
    light.to_array().map(|light| {
        let light = (light - PASSED).max(0.0) / (1.0 - PASSED);
        // Smooth at both ends.
        light * light * (3.0 - 2.0 * light)
    })
}
