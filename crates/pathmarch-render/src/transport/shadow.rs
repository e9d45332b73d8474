//! What of a light's sample arrives at a surface.
//!
//! A shadow ray is marched to the light and meets something or nothing. Two settings bend this. With
//! `caustics "fast"` it goes straight on through clear glass, weighed by Fresnel's law, tint and absorption (the
//! simplification of Carvalho 2020, section 4.4, with the physics of the interface): biased, but free of noise, and the
//! only light that a `point` or a `sun` without size can send through glass. A `penumbra` on such a light softens its
//! shadows by the near misses of the march (Quilez 2010, "Soft shadows in raymarched SDFs"): an approximation that knows
//! neither the light's size nor its distance, in which glass casts the shadow of a solid.

use super::camera::Ray;
use super::lights::{self, LightSample};
use super::march::{Hit, MAX_STEPS, March, march, rounding_at, start_offset, tolerance};
use super::paint::Painted;
use super::path::{left_after, medium_beyond};
use crate::frame::{CLEAR, Prepared, SHEET, passes_straight};
use glam::Vec3;
use pathmarch_field::graph::Batch;
use pathmarch_field::number::Vec3 as FieldVec3;

/// Clear glass that a shadow ray passes at most.
const MAX_PASSED: u32 = 8;

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
    pub(super) before: f32,
    pub(super) medium: Vec3,
    pub(super) seed: u32,
}

/// What arrives of each connection: its slot and radiance.
pub(super) fn arriving(prepared: &Prepared, connections: Vec<Connection>) -> Vec<(usize, Vec3)> {
    let mut arrived = Vec::with_capacity(connections.len());
    let mut under_way = Vec::with_capacity(connections.len());
    for mut connection in connections {
        if connection.light.penumbra > 0.0 {
            let light = near_misses(prepared, connection.ray, connection.light.distance, connection.light.penumbra);
            let left = left_after(connection.medium, connection.light.distance);
            arrived.push((connection.slot, connection.radiance * left * light));
        } else {
            let (light_pdf, scatter_pdf) = (connection.light.pdf, connection.scatter_pdf);
            connection.light.weight = lights::sampled_weight(prepared.features.light_search, light_pdf, scatter_pdf);
            under_way.push(connection);
        }
    }
    for _ in 0..=(if prepared.features.fast_caustics { MAX_PASSED } else { 0 }) {
        if under_way.is_empty() {
            break;
        }
        let marches: Vec<March> =
            under_way.iter().map(|c| March { ray: c.ray, before: c.before, limit: c.light.distance }).collect();
        let hits = march(prepared, &marches);
        let mut going_on = Vec::new();
        for (connection, obstacle) in under_way.into_iter().zip(hits) {
            match meet(prepared, connection, obstacle) {
                Meeting::Arrives(slot, radiance) => arrived.push((slot, radiance)),
                Meeting::GoesOn(connection) => going_on.push(connection),
                Meeting::Blocked => {}
            }
        }
        under_way = going_on;
    }
    arrived
}

enum Meeting {
    Arrives(usize, Vec3),
    GoesOn(Connection),
    Blocked,
}

fn meet(prepared: &Prepared, mut connection: Connection, obstacle: Option<Hit>) -> Meeting {
    if prepared.features.absorption {
        let length = obstacle.map_or(connection.light.distance, |hit| hit.t);
        connection.radiance *= left_after(connection.medium, length);
    }
    let arrives = |c: &Connection| Meeting::Arrives(c.slot, c.radiance * c.light.weight);
    let target = connection.light.target;
    let Some(Hit { t, direct }) = obstacle else {
        return if target.is_none() { arrives(&connection) } else { Meeting::Blocked };
    };
    let fast = prepared.features.fast_caustics;
    if target.is_none() && !fast {
        return Meeting::Blocked;
    }
    let Ray { origin, direction } = connection.ray;
    let reached = origin + direction * t;
    let p = FieldVec3::new(reached.x, reached.y, reached.z);
    let threshold = |index| f32::choice(connection.seed, index);
    let met = prepared.field.surface_met(p, Hit::met(direct), &threshold);
    let leaf = &prepared.leaves[met.leaf as usize];
    if target == Some(met.leaf as u32) {
        // A sheet's gradient points to the side it is seen from.
        let seen = leaf.flags & SHEET == 0 || direction.dot(Vec3::from(leaf.facing)) < 0.0;
        return if seen { arrives(&connection) } else { Meeting::Blocked };
    }
    let material = &prepared.materials[leaf.material as usize];
    if !fast || material.flags & CLEAR != CLEAR {
        return Meeting::Blocked;
    }
    let gradient = Vec3::new(met.field.gradient.x, met.field.gradient.y, met.field.gradient.z);
    let steepness = gradient.length().max(1e-6);
    let outward = gradient / steepness;
    let cosine = outward.dot(direction);
    let painted = Painted::new(prepared, met.leaf as usize, reached, outward, connection.before);
    let numbers = painted.map_or(material.numbers, |painted| painted.numbers(&material.numbers));
    connection.radiance *= passes_straight(&numbers, cosine.abs().min(1.0));
    connection.medium = medium_beyond(connection.medium, Vec3::from(material.absorption), cosine > 0.0);
    // No path finds this light again.
    connection.light.weight = 1.0;
    let on = reached - outward * (met.field.value / steepness);
    let off = rounding_at(&prepared.frame, reached, Vec3::from(leaf.at));
    let margin = start_offset(off, met.field.value / steepness);
    connection.ray.origin = on + outward * if cosine > 0.0 { margin } else { -margin };
    connection.light.distance -= t;
    Meeting::GoesOn(connection)
}

/// The share of a light that the nearest of the near misses leaves. Everything is marched, for nothing met in closed
/// form is nearly met.
fn near_misses(prepared: &Prepared, ray: Ray, limit: f32, sharpness: f32) -> f32 {
    let frame = &prepared.frame;
    let mut light = 1.0f32;
    let last = limit.min(frame.far);
    let mut t = tolerance(frame, ray.origin, 0.0);
    for _ in 0..MAX_STEPS {
        let p = ray.origin + ray.direction * t;
        let distance = prepared.field.estimated_distance(FieldVec3::new(p.x, p.y, p.z)) * frame.step_factor;
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
