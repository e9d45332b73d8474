//! Ambient light of previews: spherical harmonics of the radiance near the visible surfaces.
//!
//! **Idea.** Paths start just in front of the hits of a coarse grid of camera rays and go into all directions. Their
//! radiance, as a function of direction, is projected on nine spherical harmonics and convolved with the cosine lobe,
//! so that the result is the irradiance for a normal (Ramamoorthi and Hanrahan 2001, "An Efficient Representation for
//! Irradiance Environment Maps"). So a preview of a closed room is as bright as its path-traced picture, and surfaces
//! take colour from the surfaces opposite. Direct light of the sampled lights is left out, because the preview computes
//! it analytically. The sky is included.
//!
//! **Differences.** One function serves the whole picture instead of one for each position. That is cheap and has no
//! seams, but is wrong where parts of a picture have different lighting. Paths brighter than [`MAX_RELATIVE_LUMINANCE`]
//! times the mean are clamped, so that no outlier tints the picture. The random numbers are the same for every seed.
//!
//! **Cost.** 4,096 paths of at most five surfaces on the CPU, for both backends: 5 to 20 ms on two cores.

use crate::integrator::camera::central_ray;
use crate::integrator::path;
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment};
use crate::sampling::basis;
use crate::sampling::r2_sequence::EQUAL_WEIGHTS;
use crate::sampling::sobol::{PixelSampler, unit};
use crate::scene::light::{SphereLight, luminance};
use crate::scene::{FrameUniforms, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use glam::Vec3;
use pathmarch_field::number::unit_circle;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Columns and rows of the grid of camera rays.
const CAMERA_GRID: [u32; 2] = [8, 4];
/// Number of paths from each point.
const PATHS_PER_POINT: u32 = 128;
/// Largest luminance of a path, relative to the mean of all.
const MAX_RELATIVE_LUMINANCE: f32 = 12.0;
/// Distance of a point from the camera divided by that of the hit.
const HIT_SHARE: f32 = 0.92;
/// Largest number of bounces of a path.
const MAX_PATH_BOUNCES: u32 = 4;

/// Polynomials of the spherical harmonics up to the second degree, without their norms.
pub(super) fn sh_basis(n: Vec3) -> [f32; 9] {
    [1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y]
}

/// Squared norms of the [`sh_basis`] times the coefficients of the cosine lobe.
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

/// Ambient irradiance as coefficients of the [`sh_basis`] of a normal, W/m², without the direct light of
/// `excluded_lights`.
pub(super) fn ambient_sh(ctx: &TraceContext, excluded_lights: &[u32]) -> [Vec3; 9] {
    let points = points(ctx);
    if points.is_empty() {
        return [Vec3::ZERO; 9];
    }
    // The surface that receives the light accounts for one bounce.
    let bounces = ctx.frame.bounces;
    let frame = FrameUniforms { bounces: bounces.saturating_sub(1).min(MAX_PATH_BOUNCES), ..*ctx.frame };
    let ctx = &TraceContext { frame: &frame, ..*ctx };
    let radiances: Vec<(Vec3, Vec3)> = points
        .par_iter()
        .enumerate()
        .flat_map_iter(|(index, &point)| {
            let rays = (0..PATHS_PER_POINT).map(|k| {
                let sampler = PixelSampler::new(index as u32, 0, k, 0);
                (Ray { origin: point, direction: sample_sphere(sampler.sample_2d(0)) }, sampler)
            });
            let rays: Vec<(Ray, PixelSampler)> = rays.collect();
            let directions: Vec<Vec3> = rays.iter().map(|(ray, _)| ray.direction).collect();
            directions.into_iter().zip(radiance(ctx, rays, excluded_lights, bounces > 0))
        })
        .collect();
    let mean =
        radiances.iter().map(|(_, radiance)| luminance((*radiance).into())).sum::<f32>() / radiances.len() as f32;
    let mut coefficients = [Vec3::ZERO; 9];
    for (direction, radiance) in &radiances {
        let clamped = *radiance
            * (MAX_RELATIVE_LUMINANCE * mean
                / luminance((*radiance).into()).max(MAX_RELATIVE_LUMINANCE * mean).max(1e-30));
        for ((coefficient, value), norm) in coefficients.iter_mut().zip(sh_basis(*direction)).zip(NORMS) {
            *coefficient += clamped * (value * norm * 4.0 * PI / radiances.len() as f32);
        }
    }
    coefficients
}

/// Points in front of the hits of camera rays, in world space.
fn points(ctx: &TraceContext) -> Vec<Vec3> {
    let frame = ctx.frame;
    let [columns, rows] = CAMERA_GRID;
    let segments: Vec<RaySegment> = (0..columns * rows)
        .map(|k| {
            let (x, y) = ((k % columns) as f32 + 0.5, (k / columns) as f32 + 0.5);
            let ray =
                central_ray(frame, x * frame.width as f32 / columns as f32, y * frame.height as f32 / rows as f32);
            RaySegment { ray, path_length: 0.0, limit: f32::INFINITY }
        })
        .collect();
    let hits = march(ctx, &segments);
    let hits_of_rays = segments.iter().zip(hits).filter_map(|(segment, hit)| Some((segment.ray, hit?.t)));
    let points: Vec<Vec3> = hits_of_rays.map(|(ray, t)| ray.origin + ray.direction * (HIT_SHARE * t)).collect();
    // Without hits, the surfaces between the rays, if any, are in the open.
    if points.is_empty() { vec![Vec3::from(frame.position)] } else { points }
}

/// Uniform direction on the unit sphere.
fn sample_sphere([u, v]: [f32; 2]) -> Vec3 {
    let y = 1.0 - 2.0 * u;
    let radius = (1.0 - y * y).max(0.0).sqrt();
    let [cosine, sine] = unit_circle(v);
    Vec3::new(radius * cosine, y, radius * sine)
}

/// Radiance along rays, without the direct light of `excluded_lights`. Without `bounces`, also without that of other
/// surfaces.
fn radiance(ctx: &TraceContext, rays: Vec<(Ray, PixelSampler)>, excluded_lights: &[u32], bounces: bool) -> Vec<Vec3> {
    let segments: Vec<RaySegment> =
        rays.iter().map(|(ray, _)| RaySegment { ray: *ray, path_length: 0.0, limit: f32::INFINITY }).collect();
    let mut radiances = vec![Vec3::ZERO; rays.len()];
    let (mut slots, mut segment_hits) = (Vec::new(), Vec::new());
    for (slot, hit) in march(ctx, &segments).into_iter().enumerate() {
        match hit {
            Some(hit) => {
                slots.push(slot);
                segment_hits.push((segments[slot], hit));
            }
            None => radiances[slot] = ctx.scene.sky.radiance(rays[slot].0.direction).0,
        }
    }
    let interactions = surface_interactions(ctx, &segment_hits, |_, _| EQUAL_WEIGHTS);
    let contributes = |&SurfaceInteraction { leaf, triangle, .. }: &SurfaceInteraction| {
        if !ctx.scene.material_of(leaf).emits() {
            return bounces;
        }
        ctx.scene.light_of(leaf, triangle).is_none_or(|light| !excluded_lights.contains(&(light as u32)))
    };
    let slots: Vec<usize> = slots
        .into_iter()
        .zip(&interactions)
        .filter(|(_, interaction)| contributes(interaction))
        .map(|(slot, _)| slot)
        .collect();
    let traced = path::radiance_along(ctx, slots.iter().map(|&slot| rays[slot]));
    for (slot, radiance) in slots.into_iter().zip(traced) {
        // A path that fails has no radiance.
        radiances[slot] = if radiance.is_finite() { radiance } else { Vec3::ZERO };
    }
    radiances
}

/// Visible area of an emitter divided by that of its bounding sphere's disc, averaged over all directions.
pub(super) fn visible_share(ctx: &TraceContext, sphere: &SphereLight) -> f32 {
    const RAYS: u32 = 64;
    let centre = sphere.centre;
    let segments: Vec<RaySegment> = (0..RAYS)
        .map(|k| {
            let sampler = PixelSampler::new(0, 0, k, 0);
            let direction = sample_sphere(sampler.sample_2d(0));
            let [u, v] = sampler.sample_2d(1);
            let [cosine, sine] = unit_circle(v);
            let disc_point = basis::basis(direction) * Vec3::new(u.sqrt() * cosine, u.sqrt() * sine, -1.0);
            let ray = Ray { origin: centre + disc_point * sphere.radius, direction };
            RaySegment { ray, path_length: 0.0, limit: 2.0 * sphere.radius }
        })
        .collect();
    let hits = march(ctx, &segments);
    let segment_hits: Vec<_> =
        segments.into_iter().zip(hits).filter_map(|(segment, hit)| Some((segment, hit?))).collect();
    let hit_count = surface_interactions(ctx, &segment_hits, |_, _| EQUAL_WEIGHTS)
        .iter()
        .filter(|interaction| interaction.leaf as u32 == sphere.leaf)
        .count();
    (hit_count as f32 / RAYS as f32).max(unit(1 << 30))
}
