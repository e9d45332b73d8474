//! What of a light's sample arrives at a surface.
//!
//! A shadow ray is marched to the light and meets something or nothing. Two settings bend this. With
//! `caustics "fast"` it goes straight on through clear glass, weighed by Fresnel's law, tint and absorption (the
//! simplification of Carvalho 2020, section 4.4, with the physics of the interface): biased, but free of noise, and the
//! only light that a `point` or a `sun` without size can send through glass. A `penumbra` on such a light softens its
//! shadows by the near misses of the march (Quilez 2010, "Soft shadows in raymarched SDFs"): an approximation that knows
//! neither the light's size nor its distance, in which glass casts the shadow of a solid.

use super::light_sampling::{self, LightSample};
use super::medium::{medium_beyond, transmittance};
use crate::intersect::march::{MAX_STEPS, march, tolerance};
use crate::intersect::ray::{Hit, Ray, RaySegment};
use crate::sampling::sobol::PixelSampler;
use crate::scene::TraceContext;
use crate::scene::leaf::IN_GLASS;
use crate::scene::material::{CLEAR, straight_transmittance};
use crate::shading::surface_interaction::{SurfaceInteraction, interactions};
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::graph::Batch;
use pathmarch_field::number::Vec3 as FieldVec3;

shared_constants! {
    /// Largest number of clear surfaces that a shadow ray passes.
    const MAX_PASSED: u32 = 8;
}

/// Light on its way from a source that may be hidden.
pub(super) struct Connection {
    pub(super) slot: usize,
    /// What arrives if nothing is in the way.
    pub(super) radiance: Vec3,
    /// Density of scattering into the light's direction.
    pub(super) scatter_pdf: f32,
    pub(super) light: LightSample,
    pub(super) ray: Ray,
    /// Length of the path before the ray.
    pub(super) path_length: f32,
    pub(super) medium: Vec3,
    /// Of the path.
    pub(super) random: PixelSampler,
}

/// What arrives of each connection to the lights of surface `surface_index` of its path: its slot and radiance.
pub(super) fn arriving(ctx: &TraceContext, connections: Vec<Connection>, surface_index: u32) -> Vec<(usize, Vec3)> {
    let mut arrived = Vec::with_capacity(connections.len());
    let mut under_way = connections;
    if ctx.config.penumbra {
        under_way.retain(|connection| {
            let LightSample { distance, penumbra, .. } = connection.light;
            if penumbra > 0.0 {
                let light = near_misses(ctx, connection.ray, distance, penumbra);
                let left = transmittance(connection.medium, distance);
                arrived.push((connection.slot, connection.radiance * left * light));
            }
            penumbra <= 0.0
        });
    }
    for connection in &mut under_way {
        let (light_pdf, scatter_pdf) = (connection.light.pdf, connection.scatter_pdf);
        connection.light.weight = light_sampling::sample_weight(ctx.config.light_search, light_pdf, scatter_pdf);
    }
    for _ in 0..=(if ctx.config.fast_caustics { MAX_PASSED } else { 0 }) {
        if under_way.is_empty() {
            break;
        }
        let march_of = |c: &Connection| RaySegment { ray: c.ray, path_length: c.path_length, limit: c.light.distance };
        let marches: Vec<RaySegment> = under_way.iter().map(march_of).collect();
        let hits = march(ctx, &marches);
        if ctx.config.absorption {
            for (connection, obstacle) in under_way.iter_mut().zip(&hits) {
                let length = obstacle.map_or(connection.light.distance, |hit| hit.t);
                connection.radiance *= transmittance(connection.medium, length);
            }
        }
        let mut obstacles = Vec::new();
        let mut ends = marches.into_iter().zip(hits);
        under_way.retain(|connection| {
            let obstacle = ends.next().and_then(|(march, hit)| Some((march, hit?)));
            let has_target = connection.light.target.is_some();
            if obstacle.is_none() && !has_target {
                arrived.push((connection.slot, connection.radiance * connection.light.weight));
            }
            let matters = has_target || ctx.config.fast_caustics;
            obstacles.extend(obstacle.filter(|_| matters));
            obstacle.is_some() && matters
        });
        let seed = |k: usize| under_way[k].random.unstratified_seed(surface_index);
        let met = interactions(ctx, &obstacles, |k, blend| f32::choice(seed(k), blend));
        let mut met = obstacles.into_iter().zip(met);
        under_way.retain_mut(|connection| {
            met.next().is_some_and(|((_, Hit { t, .. }), obstacle)| {
                if connection.light.target != Some(obstacle.leaf as u32) {
                    return passes(ctx, connection, t, &obstacle);
                }
                // From inside glass, paths alone find the light.
                let from_glass = obstacle.inside && ctx.scene.leaves[obstacle.leaf].has(IN_GLASS);
                if !from_glass && ctx.scene.emits_towards(obstacle.leaf, -connection.ray.direction) {
                    arrived.push((connection.slot, connection.radiance * connection.light.weight));
                }
                false
            })
        });
    }
    arrived
}

/// Whether a connection goes on through an obstacle that its ray met after `t` metres, and what of it does.
fn passes(ctx: &TraceContext, connection: &mut Connection, t: f32, obstacle: &SurfaceInteraction) -> bool {
    let leaf = &ctx.scene.leaves[obstacle.leaf];
    let material = &ctx.scene.materials[leaf.material as usize];
    if !ctx.config.fast_caustics || material.flags & CLEAR != CLEAR {
        return false;
    }
    let cosine = obstacle.normal.dot(connection.ray.direction).abs();
    let textured = TexturedPoint::new(ctx, obstacle.leaf, obstacle.p, obstacle.outward(), connection.path_length);
    let numbers = textured.map_or(material.parameters, |textured| textured.numbers(&material.parameters));
    connection.radiance *= straight_transmittance(&numbers, cosine.min(1.0));
    connection.medium = medium_beyond(connection.medium, Vec3::from(material.absorption), obstacle.inside);
    // No path finds this light again.
    connection.light.weight = 1.0;
    connection.ray.origin = obstacle.p - obstacle.normal_offset;
    connection.light.distance -= t;
    true
}

/// The share of a light that the nearest of the near misses leaves. Everything is marched, for nothing met in closed
/// form is nearly met.
fn near_misses(ctx: &TraceContext, ray: Ray, limit: f32, sharpness: f32) -> f32 {
    let frame = ctx.frame;
    let mut light = 1.0f32;
    let last = limit.min(frame.far);
    let mut t = tolerance(frame, ray.origin, 0.0);
    for _ in 0..MAX_STEPS {
        let p = ray.origin + ray.direction * t;
        let distance = ctx.scene.field.estimated_distance(FieldVec3::new(p.x, p.y, p.z)) * frame.step_factor;
        light = light.min(sharpness * distance / t);
        if light < 0.001 {
            return 0.0;
        }
        t += distance;
        if t > last {
            break;
        }
    }
    // Smooth at both ends.
    light * light * (3.0 - 2.0 * light)
}
