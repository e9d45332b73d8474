//! Light from all around, for previews: what a few thousand paths find in the air before what the camera sees.
//!
//! **Idea.** From points close before the first surfaces of a coarse grid of camera rays, paths go into all directions.
//! Their radiance, as a function of direction, is kept as nine spherical harmonics, already integrated to the irradiance of a
//! normal (Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps"). So a preview of a
//! closed room is as bright as its picture, and surfaces take colour from what they face. Light that a preview casts itself,
//! that of known lights straight from them, is left out; the sky is not.
//!
//! **Where we differ.** One function for the whole picture instead of one for each place: cheap, never in pieces, and wrong
//! where parts of a picture lie in different light. A path brighter than [`LIMIT`] times the mean counts as that, so that no
//! lucky one tints the picture. The paths have their own numbers, the same for every seed.
//!
//! **Cost.** 4,096 paths of at most five surfaces on the CPU, whatever the backend: 5 to 20 ms on two cores.

use super::camera::{Ray, central_ray};
use super::lights::{LightRecord, luminance};
use super::march::{March, march};
use super::path;
use super::random::{Random, unit};
use super::steady::HEAVIER;
use super::visible::visible;
use crate::frame::{EMITS, LIGHT_SHIFT, Prepared};
use crate::settings::LightSearch;
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::{PI, TAU};

/// Columns and rows of the grid of camera rays.
const GRID: [u32; 2] = [8, 4];
/// Paths from each point.
const DIRECTIONS: u32 = 128;
/// Paths that are brighter than this many times the mean are limited.
const LIMIT: f32 = 12.0;
/// How far towards the surface a point lies.
const NEARLY: f32 = 0.92;
/// Bounces of the paths at most.
const BOUNCES: u32 = 4;

/// The polynomials of spherical harmonics up to the second degree.
pub(super) fn basis(n: Vec3) -> [f32; 9] {
    [1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y]
}

/// Squares of their norms times the factor of a cosine lobe.
const NORMS: [f32; 9] = {
    const ONE: f32 = 0.488_602_5 * 0.488_602_5 * 2.0 / 3.0 * PI;
    const TWO: f32 = 1.092_548_4 * 1.092_548_4 / 4.0 * PI;
    [
        0.282_094_8 * 0.282_094_8 * PI,
        ONE,
        ONE,
        ONE,
        TWO,
        TWO,
        0.315_391_57 * 0.315_391_57 / 4.0 * PI,
        TWO,
        0.546_274_2 * 0.546_274_2 / 4.0 * PI,
    ]
};

/// Irradiance as factors of [`basis`] of a normal, without what the lights of these indices give straight from them.
pub(super) fn light_from_all_around(prepared: &mut Prepared, known: &[u32]) -> [Vec3; 9] {
    let points = points(prepared);
    if points.is_empty() {
        return [Vec3::ZERO; 9];
    }
    // A path from a camera there has one bounce behind it.
    let bounces = prepared.frame.bounces;
    prepared.frame.bounces = bounces.saturating_sub(1).min(BOUNCES);
    let found: Vec<(Vec3, Vec3)> = points
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, &point)| {
            let rays = (0..DIRECTIONS).map(|k| {
                let random = Random::new(index as u32, 0, k, 0);
                (Ray { origin: point, direction: direction(random.pair(0)) }, random)
            });
            let rays: Vec<(Ray, Random)> = rays.collect();
            let directions: Vec<Vec3> = rays.iter().map(|(ray, _)| ray.direction).collect();
            directions.into_iter().zip(radiance(prepared, rays, known, bounces > 0))
        })
        .collect();
    prepared.frame.bounces = bounces;
    let mean = found.iter().map(|(_, radiance)| luminance((*radiance).into())).sum::<f32>() / found.len() as f32;
    let mut factors = [Vec3::ZERO; 9];
    for (direction, radiance) in &found {
        let limited = *radiance * (LIMIT * mean / luminance((*radiance).into()).max(LIMIT * mean).max(1e-30));
        for ((factor, value), norm) in factors.iter_mut().zip(basis(*direction)).zip(NORMS) {
            *factor += limited * (value * norm * 4.0 * PI / found.len() as f32);
        }
    }
    factors
}

/// Points in the air before what the camera sees.
fn points(prepared: &Prepared) -> Vec<Vec3> {
    let frame = &prepared.frame;
    let [columns, rows] = GRID;
    let marches: Vec<March> = (0..columns * rows)
        .map(|k| {
            let (x, y) = ((k % columns) as f32 + 0.5, (k / columns) as f32 + 0.5);
            let ray =
                central_ray(frame, x * frame.width as f32 / columns as f32, y * frame.height as f32 / rows as f32);
            March { ray, before: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let hits = march(prepared, &marches);
    let reached = marches.iter().zip(hits).filter_map(|(march, hit)| Some((march.ray, hit?.t)));
    let points: Vec<Vec3> = reached.map(|(ray, t)| ray.origin + ray.direction * (NEARLY * t)).collect();
    // Where nothing is seen there is nothing to light; what is seen between the rays is in the open.
    if points.is_empty() { vec![Vec3::from(frame.position)] } else { points }
}

/// Uniform over all directions.
fn direction([u, v]: [f32; 2]) -> Vec3 {
    let y = 1.0 - 2.0 * u;
    let radius = (1.0 - y * y).max(0.0).sqrt();
    let (sine, cosine) = (TAU * v).sin_cos();
    Vec3::new(radius * cosine, y, radius * sine)
}

/// What rays find, without known lights straight from them.
fn radiance(prepared: &Prepared, rays: Vec<(Ray, Random)>, known: &[u32], bounces: bool) -> Vec<Vec3> {
    let marches: Vec<March> =
        rays.iter().map(|(ray, _)| March { ray: *ray, before: 0.0, limit: f32::INFINITY }).collect();
    let mut found = vec![Vec3::ZERO; rays.len()];
    let (mut slots, mut met) = (Vec::new(), Vec::new());
    for (slot, hit) in march(prepared, &marches).into_iter().enumerate() {
        match hit {
            Some(hit) => {
                slots.push(slot);
                met.push((marches[slot], hit));
            }
            None => found[slot] = prepared.sky.found(LightSearch::Met, rays[slot].0.direction, 0.0),
        }
    }
    let seen = visible(prepared, &met, |_, _| HEAVIER);
    let counted = |leaf: usize| {
        let leaf = &prepared.leaves[leaf];
        let emits = prepared.materials[leaf.material as usize].flags & EMITS != 0;
        let light = leaf.flags >> LIGHT_SHIFT;
        if emits { light == 0 || !known.contains(&(light - 1)) } else { bounces }
    };
    let slots: Vec<usize> =
        slots.into_iter().zip(&seen).filter(|(_, seen)| counted(seen.leaf)).map(|(slot, _)| slot).collect();
    let followed = path::radiance_along(prepared, slots.iter().map(|&slot| rays[slot]));
    for (slot, radiance) in slots.into_iter().zip(followed) {
        // Paths may fail; one that does is one that finds nothing.
        found[slot] = if radiance.is_finite() { radiance } else { Vec3::ZERO };
    }
    found
}

/// The share of the disc of a light's bounding sphere that shines, over rays from all directions.
pub(super) fn shown_share(prepared: &Prepared, light: &LightRecord) -> f32 {
    const RAYS: u32 = 64;
    let middle = Vec3::from(light.place);
    let marches: Vec<March> = (0..RAYS)
        .map(|k| {
            let random = Random::new(0, 0, k, 0);
            let towards = direction(random.pair(0));
            let [u, v] = random.pair(1);
            let (sine, cosine) = (TAU * v).sin_cos();
            let across = super::basis::basis(towards) * Vec3::new(u.sqrt() * cosine, u.sqrt() * sine, -1.0);
            let ray = Ray { origin: middle + across * light.extent, direction: towards };
            March { ray, before: 0.0, limit: 2.0 * light.extent }
        })
        .collect();
    let hits = march(prepared, &marches);
    let met: Vec<_> = marches.into_iter().zip(hits).filter_map(|(march, hit)| Some((march, hit?))).collect();
    let shining = visible(prepared, &met, |_, _| HEAVIER).iter().filter(|seen| seen.leaf as u32 == light.leaf).count();
    (shining as f32 / RAYS as f32).max(unit(1 << 30))
}
