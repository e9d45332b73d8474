//! Shadow tests: direct light of light samples, after visibility.
//!
//! A shadow ray is traced towards the light. An occluder blocks it completely, but for two settings. With
//! `caustics "fast"`, the ray passes straight through clear glass, weighted by Fresnel transmittance, tint and absorption (the
//! simplification of Carvalho 2020, section 5.3.3, with the physics of the interface). That is biased but free of noise,
//! and the only way for light of a `point` or of a `sun` without size through glass. A `penumbra` on such a light
//! softens its shadows by the near misses of the shadow ray (Quilez 2010, "Soft shadows in raymarched SDFs"). This
//! approximation depends neither on the size of the light nor on its distance, and glass casts the shadow of an opaque
//! solid.

use super::light_sampling::{self, LightSample};
use super::nested_dielectrics;
use super::participating_media::{medium_after, transmittance_in};
use super::path_state::Path;
use crate::intersect::march::{MAX_STEPS, march, tolerance};
use crate::intersect::ray::{Hit, Ray, RaySegment};
use crate::sampling::sobol::PixelSampler;
use crate::scene::leaf::IN_GLASS;
use crate::scene::material::{BOUNDARY, CLEAR};
use crate::scene::{KernelConfig, Medium, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::graph::Batch;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::straight_transmittance;

shared_constants! {
    /// Largest number of clear surfaces that a shadow ray passes through.
    const MAX_CLEAR_SURFACES: u32 = 8;
    /// Largest number of boundaries of media between two scattering events.
    pub(super) const MAX_CROSSINGS: u32 = 256;
}

/// Light sample of a path whose visibility is to be tested.
pub(super) struct ShadowTest {
    /// Index of the path, see [`direct_light`].
    pub(super) slot: usize,
    /// Radiance without occlusion, W/(m² sr).
    pub(super) radiance: Vec3,
    /// Weight of multiple importance sampling (MIS).
    pub(super) weight: f32,
    pub(super) ray: Ray,
    /// Largest distance of an occluder along the ray, metres.
    pub(super) distance: f32,
    /// Leaf that the ray must hit, for a light that it may miss.
    pub(super) target: Option<u32>,
    /// Sharpness of shadows from near misses; 0 for exact shadows.
    pub(super) penumbra: f32,
    /// Length of the path before the shadow ray, metres.
    pub(super) path_length: f32,
    /// Media of the solids around the ray.
    pub(super) medium: Medium,
    /// Random numbers of the path.
    pub(super) sampler: PixelSampler,
}

impl ShadowTest {
    /// Test of a light sample from `origin`, where BSDF sampling has the pdf `scatter_pdf` over solid angle for its direction.
    pub(super) fn new(
        ctx: &TraceContext,
        path: &Path,
        origin: Vec3,
        light: &LightSample,
        (radiance, scatter_pdf): (Vec3, f32),
    ) -> Self {
        Self {
            slot: path.slot,
            radiance,
            weight: light_sampling::sample_weight(ctx.config.direct_lighting, light.pdf, scatter_pdf),
            ray: Ray { origin, direction: light.direction },
            distance: light.distance,
            target: light.target,
            penumbra: light.penumbra,
            path_length: path.length,
            medium: path.medium,
            sampler: path.sampler,
        }
    }
}

/// Traces the shadow rays of surface `surface_index` of all paths. Returns slot and radiance of the tests with any
/// light.
pub(super) fn direct_light(ctx: &TraceContext, tests: Vec<ShadowTest>, surface_index: u32) -> Vec<(usize, Vec3)> {
    let mut direct_light = Vec::with_capacity(tests.len());
    let mut pending = tests;
    if ctx.config.penumbra {
        pending.retain(|test| {
            let &ShadowTest { distance, penumbra, .. } = test;
            if penumbra > 0.0 {
                let visibility = near_misses(ctx, test.ray, distance, penumbra);
                let attenuation = transmittance_in(ctx, &test.medium, distance);
                direct_light.push((test.slot, test.radiance * attenuation * visibility));
            }
            penumbra <= 0.0
        });
    }
    let passed_surfaces = match ctx.config {
        KernelConfig { boundaries: true, .. } | KernelConfig { nested_dielectrics: true, .. } => MAX_CROSSINGS,
        KernelConfig { fast_caustics: true, .. } => MAX_CLEAR_SURFACES,
        _ => 0,
    };
    for _ in 0..=passed_surfaces {
        if pending.is_empty() {
            break;
        }
        let segment_of =
            |test: &ShadowTest| RaySegment { ray: test.ray, path_length: test.path_length, limit: test.distance };
        let segments: Vec<RaySegment> = pending.iter().map(segment_of).collect();
        let hits = march(ctx, &segments);
        if ctx.config.absorption {
            for (test, occluder) in pending.iter_mut().zip(&hits) {
                let length = occluder.map_or(test.distance, |hit| hit.t);
                test.radiance *= transmittance_in(ctx, &test.medium, length);
            }
        }
        let mut occluders = Vec::new();
        let mut results = segments.into_iter().zip(hits);
        pending.retain(|test| {
            let occluder = results.next().and_then(|(segment, hit)| Some((segment, hit?)));
            let has_target = test.target.is_some();
            if occluder.is_none() && !has_target {
                direct_light.push((test.slot, test.radiance * test.weight));
            }
            let may_continue = has_target || passed_surfaces > 0;
            occluders.extend(occluder.filter(|_| may_continue));
            occluder.is_some() && may_continue
        });
        let seed = |k: usize| pending[k].sampler.unstratified_seed(surface_index);
        let interactions = surface_interactions(ctx, &occluders, |k, blend| f32::choice(seed(k), blend));
        let mut interactions = occluders.into_iter().zip(interactions);
        pending.retain_mut(|test| {
            interactions.next().is_some_and(|((_, Hit { t, .. }), occluder)| {
                if test.target != Some(occluder.leaf as u32) {
                    return pass_through(ctx, test, t, &occluder);
                }
                // From inside glass, only BSDF sampling contributes the light.
                let from_glass = occluder.inside && ctx.scene.leaves[occluder.leaf].has(IN_GLASS);
                if !from_glass && ctx.scene.emits_towards(occluder.leaf, -test.ray.direction) {
                    direct_light.push((test.slot, test.radiance * test.weight));
                }
                false
            })
        });
    }
    direct_light
}

/// Continues a shadow ray through an occluder at distance `t` if it is the boundary of a medium, in a solid of higher priority
/// or, for fast caustics, clear glass, which attenuates its light. Returns false if the occluder blocks the ray.
fn pass_through(ctx: &TraceContext, test: &mut ShadowTest, t: f32, occluder: &SurfaceInteraction) -> bool {
    let leaf = &ctx.scene.leaves[occluder.leaf];
    let material = &ctx.scene.materials[leaf.material as usize];
    let is_nested = ctx.config.nested_dielectrics;
    if material.has(BOUNDARY) || is_nested && ctx.scene.is_skipped(&test.medium, occluder.leaf) {
        test.medium = medium_after(ctx, &test.medium, occluder.leaf, occluder.inside);
        test.ray.origin = occluder.p - occluder.normal_offset;
        test.distance -= t;
        return true;
    }
    if !ctx.config.fast_caustics || material.flags & CLEAR != CLEAR {
        return false;
    }
    let cosine = occluder.normal.dot(test.ray.direction).abs();
    let textured = TexturedPoint::new(ctx, occluder, test.path_length);
    let mut parameters = textured.map_or(material.parameters, |textured| textured.parameters(&material.parameters));
    if is_nested {
        parameters = nested_dielectrics::straight_parameters(ctx, &test.medium, occluder.leaf, &parameters);
    }
    test.radiance *= straight_transmittance(&parameters, cosine.min(1.0));
    test.medium = medium_after(ctx, &test.medium, occluder.leaf, occluder.inside);
    // BSDF sampling leaves out this light.
    test.weight = 1.0;
    test.ray.origin = occluder.p - occluder.normal_offset;
    test.distance -= t;
    true
}

/// Share of a light that the near misses of its shadow ray leave. All objects are sphere-traced: an analytic
/// intersection has no near misses.
fn near_misses(ctx: &TraceContext, ray: Ray, limit: f32, sharpness: f32) -> f32 {
    let frame = ctx.frame;
    let mut visibility = 1.0f32;
    let t_max = limit.min(frame.far);
    let mut t = tolerance(frame, ray.origin, 0.0);
    for _ in 0..MAX_STEPS {
        let p = ray.origin + ray.direction * t;
        let distance = ctx.scene.field.estimated_distance(FieldVec3::new(p.x, p.y, p.z)) * frame.step_factor;
        visibility = visibility.min(sharpness * distance / t);
        if visibility < 0.001 {
            return 0.0;
        }
        t += distance;
        if t > t_max {
            break;
        }
    }
    // Smoothstep.
    visibility * visibility * (3.0 - 2.0 * visibility)
}
