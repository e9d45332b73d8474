//! Ambient light for previews, as spherical harmonics: radiance from all directions near what the camera sees.
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

use crate::integrator::camera::central_ray;
use crate::integrator::path;
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment};
use crate::sampling::basis;
use crate::sampling::r2_sequence::EQUAL_WEIGHTS;
use crate::sampling::sobol::{PixelSampler, unit};
use crate::scene::light::{SphereLight, luminance};
use crate::scene::{FrameUniforms, TraceContext};
use crate::shading::surface_interaction::interactions;
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
pub(super) fn ambient_sh(ctx: &TraceContext, known: &[u32]) -> [Vec3; 9] {
    let points = points(ctx);
    if points.is_empty() {
        return [Vec3::ZERO; 9];
    }
    // A path from a camera there has one bounce behind it.
    let bounces = ctx.frame.bounces;
    let frame = FrameUniforms { bounces: bounces.saturating_sub(1).min(BOUNCES), ..*ctx.frame };
    let ctx = &TraceContext { frame: &frame, ..*ctx };
    let found: Vec<(Vec3, Vec3)> = points
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, &point)| {
            let rays = (0..DIRECTIONS).map(|k| {
                let random = PixelSampler::new(index as u32, 0, k, 0);
                (Ray { origin: point, direction: direction(random.sample_2d(0)) }, random)
            });
            let rays: Vec<(Ray, PixelSampler)> = rays.collect();
            let directions: Vec<Vec3> = rays.iter().map(|(ray, _)| ray.direction).collect();
            directions.into_iter().zip(radiance(ctx, rays, known, bounces > 0))
        })
        .collect();
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
fn points(ctx: &TraceContext) -> Vec<Vec3> {
    let frame = ctx.frame;
    let [columns, rows] = GRID;
    let marches: Vec<RaySegment> = (0..columns * rows)
        .map(|k| {
            let (x, y) = ((k % columns) as f32 + 0.5, (k / columns) as f32 + 0.5);
            let ray =
                central_ray(frame, x * frame.width as f32 / columns as f32, y * frame.height as f32 / rows as f32);
            RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let hits = march(ctx, &marches);
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
fn radiance(ctx: &TraceContext, rays: Vec<(Ray, PixelSampler)>, known: &[u32], bounces: bool) -> Vec<Vec3> {
    let marches: Vec<RaySegment> =
        rays.iter().map(|(ray, _)| RaySegment { ray: *ray, path_length: 0.0, limit: f32::INFINITY }).collect();
    let mut found = vec![Vec3::ZERO; rays.len()];
    let (mut slots, mut met) = (Vec::new(), Vec::new());
    for (slot, hit) in march(ctx, &marches).into_iter().enumerate() {
        match hit {
            Some(hit) => {
                slots.push(slot);
                met.push((marches[slot], hit));
            }
            None => found[slot] = ctx.scene.sky.radiance(rays[slot].0.direction).0,
        }
    }
    let seen = interactions(ctx, &met, |_, _| EQUAL_WEIGHTS);
    let counted = |leaf: usize| {
        if !ctx.scene.material_of(leaf).emits() {
            return bounces;
        }
        ctx.scene.leaves[leaf].light().is_none_or(|light| !known.contains(&(light as u32)))
    };
    let slots: Vec<usize> =
        slots.into_iter().zip(&seen).filter(|(_, seen)| counted(seen.leaf)).map(|(slot, _)| slot).collect();
    let followed = path::radiance_along(ctx, slots.iter().map(|&slot| rays[slot]));
    for (slot, radiance) in slots.into_iter().zip(followed) {
        // Paths may fail; one that does is one that finds nothing.
        found[slot] = if radiance.is_finite() { radiance } else { Vec3::ZERO };
    }
    found
}

/// Share of the disc of a light's bounding sphere that emits, over rays from all directions.
pub(super) fn visible_share(ctx: &TraceContext, sphere: &SphereLight) -> f32 {
    const RAYS: u32 = 64;
    let middle = sphere.centre;
    let marches: Vec<RaySegment> = (0..RAYS)
        .map(|k| {
            let random = PixelSampler::new(0, 0, k, 0);
            let towards = direction(random.sample_2d(0));
            let [u, v] = random.sample_2d(1);
            let (sine, cosine) = (TAU * v).sin_cos();
            let across = basis::basis(towards) * Vec3::new(u.sqrt() * cosine, u.sqrt() * sine, -1.0);
            let ray = Ray { origin: middle + across * sphere.radius, direction: towards };
            RaySegment { ray, path_length: 0.0, limit: 2.0 * sphere.radius }
        })
        .collect();
    let hits = march(ctx, &marches);
    let met: Vec<_> = marches.into_iter().zip(hits).filter_map(|(march, hit)| Some((march, hit?))).collect();
    let shining =
        interactions(ctx, &met, |_, _| EQUAL_WEIGHTS).iter().filter(|seen| seen.leaf as u32 == sphere.leaf).count();
    (shining as f32 / RAYS as f32).max(unit(1 << 30))
}
