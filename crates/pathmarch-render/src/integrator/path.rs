//! The estimator: unidirectional path tracing with next-event estimation (Kajiya 1986; Carvalho 2020, chapter 4).
//!
//! A path scatters at most `bounces + 1` times, the first time at the surface the camera sees. At every surface that
//! scatters in more than single directions a light is sampled: points, suns, emitting surfaces, the environment. The path
//! meets all of these but points and suns without size, too, and both ways are weighed by multiple importance sampling. A constant or gradient
//! sky is found by the path alone. Beyond the fourth bounce a path goes on with the probability of three times its throughput (Russian
//! roulette; Arvo and Kirk 1990). Unbiased but for the march (its tolerance of a tenth of a pixel, its steps, its end), unless `clamp`,
//! `caustics "fast"` or a `penumbra` is set.
//!
//! Clear solids: a surface that transmits starts the path on its other side. What the medium absorbs is added where a path
//! enters a solid and taken off where it leaves it, so that solids may lie in one another.
//!
//! A lamp that is blended with glass is met from inside, too, where equilibrium demands n² times the radiance that it emits into air;
//! there paths alone find it.
//!
//! Here the paths of a tile go side by side, one surface at a time: march all, shade each, march all shadow rays.

use super::camera::{camera_rays, pixel_sampler};
use super::light_sampling;
use super::medium::{medium_beyond, transmittance};
use super::shadow::{self, Connection};
use super::splitting::ray_of;
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment};
use crate::sampling::basis::basis;
use crate::sampling::sobol::{PixelSampler, pair};
use crate::scene::TraceContext;
use crate::scene::leaf::IN_GLASS;
use crate::scene::material::{DELTA, TRANSMITS};
use crate::shading::surface_interaction::{SurfaceInteraction, interactions};
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::graph::Batch;
use std::iter::repeat_n;

shared_constants! {
    /// Survival probability of a path over its throughput: Russian roulette spares paths that carry a third of their light.
    const SURVIVAL: f32 = 3.0;
    /// Bounce after which Russian roulette begins.
    const ROULETTE_DEPTH: u32 = 4;
}

#[derive(Clone)]
struct Path {
    slot: usize,
    random: PixelSampler,
    ray: Ray,
    /// Where the lights of the last surface were seen from.
    previous_vertex: Vec3,
    throughput: Vec3,
    length: f32,
    /// Density of the ray's direction over solid angle; 0 for a single direction.
    scatter_pdf: f32,
    /// What the medium that the path is in absorbs, per metre.
    medium: Vec3,
    /// Whether the path went straight through clear glass, as shadow rays do, since it last sampled a light.
    passing: bool,
    /// Square of the refractive index where the path is.
    index_square: f32,
}

/// A contribution of light after this many bounces, within the limit that is set.
fn limited(ctx: &TraceContext, contribution: Vec3, bounces: u32) -> Vec3 {
    if bounces == 0 {
        return contribution;
    }
    contribution * (ctx.frame.clamp / contribution.max_element().max(ctx.frame.clamp))
}

/// The radiance of so many samples from this one on of each of these pixels, those of a pixel in a row; more than one only
/// where they share a ray of the camera.
pub(crate) fn trace(ctx: &TraceContext, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
    let shared = ray_of(first, ctx.config.splitting);
    let randoms: Vec<PixelSampler> = pixels.iter().map(|&(x, y)| pixel_sampler(ctx.frame, x, y, shared)).collect();
    let rays = camera_rays(ctx.frame, pixels, &randoms).into_iter().zip(randoms);
    if ctx.config.splitting == 1 {
        return radiance_along(ctx, rays);
    }
    let (mut paths, mut radiance) = start(ctx, rays);
    let reached = arrive(ctx, &mut paths, 0, &mut radiance);
    let radiance = radiance.iter().flat_map(|&ended| repeat_n(ended, samples as usize)).collect();
    let split = paths.iter().flat_map(|path| {
        (0..samples).map(|k| {
            let (slot, random) = (path.slot * samples as usize + k as usize, path.random.with_sample(first + k));
            Path { slot, random, ..path.clone() }
        })
    });
    let reached = reached.into_iter().flat_map(|surface| repeat_n(surface, samples as usize)).collect();
    go_on(ctx, split.collect(), reached, radiance)
}

/// The radiance along each of these rays, which start where the camera is or in the same medium.
pub(crate) fn radiance_along(ctx: &TraceContext, rays: impl Iterator<Item = (Ray, PixelSampler)>) -> Vec<Vec3> {
    let (mut paths, mut radiance) = start(ctx, rays);
    let reached = arrive(ctx, &mut paths, 0, &mut radiance);
    go_on(ctx, paths, reached, radiance)
}

/// The paths that begin with these rays, and the radiance of each so far.
fn start(ctx: &TraceContext, rays: impl Iterator<Item = (Ray, PixelSampler)>) -> (Vec<Path>, Vec<Vec3>) {
    let paths: Vec<Path> = rays
        .enumerate()
        .map(|(slot, (ray, random))| Path {
            slot,
            random,
            ray,
            previous_vertex: ray.origin,
            throughput: Vec3::ONE,
            length: 0.0,
            scatter_pdf: 0.0,
            medium: Vec3::from(ctx.frame.medium),
            passing: false,
            index_square: 1.0,
        })
        .collect();
    let radiance = vec![Vec3::ZERO; paths.len()];
    (paths, radiance)
}

/// Follows paths from the surfaces that they have reached to their ends; gives the radiance of all.
fn go_on(
    ctx: &TraceContext,
    mut paths: Vec<Path>,
    mut reached: Vec<SurfaceInteraction>,
    mut radiance: Vec<Vec3>,
) -> Vec<Vec3> {
    for surface_index in 0.. {
        if paths.is_empty() {
            break;
        }
        let mut connections = Vec::with_capacity(paths.len());
        let mut met = reached.iter().zip(drawn(ctx, &paths, surface_index));
        paths.retain_mut(|path| {
            met.next().is_some_and(|(surface, drawn)| {
                shade(ctx, path, surface, &drawn, surface_index, &mut radiance, &mut connections).is_some()
            })
        });
        for (slot, arriving) in shadow::arriving(ctx, connections, surface_index) {
            radiance[slot] += limited(ctx, arriving, surface_index);
        }
        reached = arrive(ctx, &mut paths, surface_index + 1, &mut radiance);
    }
    radiance
}

/// The random numbers of a surface.
struct Drawn {
    /// Chooses the light, and whether the path goes on.
    choice: [f32; 2],
    light: [f32; 2],
    scatter: [f32; 2],
    lobe: f32,
}

/// What each of these paths draws at its surface.
fn drawn(ctx: &TraceContext, paths: &[Path], surface_index: u32) -> impl Iterator<Item = Drawn> + use<> {
    let randoms: Vec<PixelSampler> = paths.iter().map(|path| path.random).collect();
    let of = |number: u32| {
        PixelSampler::samples_2d(&randoms, pair::PAIR_SURFACE + pair::PAIRS_PER_SURFACE * surface_index + number)
    };
    let lobes = if ctx.config.chooses_lobes { of(pair::PAIR_LOBE) } else { vec![[0.0; 2]; randoms.len()] };
    let numbers = of(pair::PAIR_CHOICE).into_iter().zip(of(pair::PAIR_LIGHT)).zip(of(pair::PAIR_SCATTER)).zip(lobes);
    numbers.map(|(((choice, light), scatter), [lobe, _])| Drawn { choice, light, scatter, lobe })
}

/// Follows the rays of paths to their next surface, after so many, and gives it for each; those that meet none end.
fn arrive(
    ctx: &TraceContext,
    paths: &mut Vec<Path>,
    surface_index: u32,
    radiance: &mut [Vec3],
) -> Vec<SurfaceInteraction> {
    let march_of = |path: &Path| RaySegment { ray: path.ray, path_length: path.length, limit: f32::INFINITY };
    let marches: Vec<RaySegment> = paths.iter().map(march_of).collect();
    let hits = march(ctx, &marches);
    let mut met = Vec::with_capacity(paths.len());
    let mut ends = marches.into_iter().zip(hits);
    paths.retain_mut(|path| {
        let end = ends.next().and_then(|(march, hit)| Some((march, hit?)));
        if ctx.config.absorption {
            path.throughput *= transmittance(path.medium, end.map_or(f32::INFINITY, |(_, hit)| hit.t));
        }
        if let Some((_, hit)) = end {
            path.length += hit.t;
            path.ray.origin += path.ray.direction * hit.t;
        } else {
            let contribution = path.throughput * beyond(ctx, path);
            // Light that a ray meets fell on the surface before.
            radiance[path.slot] += limited(ctx, contribution, surface_index.saturating_sub(1));
        }
        met.extend(end);
        end.is_some()
    });
    let seed = |k: usize| paths[k].random.unstratified_seed(surface_index);
    interactions(ctx, &met, |k, blend| f32::choice(seed(k), blend))
}

/// Weighted radiance of the sky and the suns for a path that leaves the scene.
fn beyond(ctx: &TraceContext, path: &Path) -> Vec3 {
    let (sky, direction) = (&ctx.scene.sky, path.ray.direction);
    if path.passing {
        // Shadow rays have counted a sampled sky.
        return match sky.radiance(direction) {
            (radiance, None) => radiance,
            _ => Vec3::ZERO,
        };
    }
    light_sampling::sky_radiance(sky, ctx.config.light_search, direction, path.scatter_pdf)
        + light_sampling::sun_radiance(ctx, direction, path.scatter_pdf)
}

/// What happens at a surface; `None` where the path ends there.
fn shade(
    ctx: &TraceContext,
    path: &mut Path,
    surface: &SurfaceInteraction,
    drawn: &Drawn,
    surface_index: u32,
    radiance: &mut [Vec3],
    connections: &mut Vec<Connection>,
) -> Option<()> {
    let frame = ctx.frame;
    let &SurfaceInteraction { p, normal, inside, normal_offset, .. } = surface;
    let leaf = &ctx.scene.leaves[surface.leaf];
    let material = &ctx.scene.materials[leaf.material as usize];
    if material.emits() {
        let light = leaf.light();
        // Shadow rays have counted it already.
        let counted = path.passing && light.is_some();
        if ctx.scene.emits_towards(surface.leaf, normal) && !counted {
            let mut weight = 1.0;
            if inside && leaf.has(IN_GLASS) {
                weight = path.index_square;
            } else if let Some(light) = light {
                let cosine = normal.dot(path.ray.direction).abs();
                let light = &ctx.scene.lights[light];
                let light_pdf = light_sampling::pdf(light, path.previous_vertex, path.ray.origin, cosine);
                weight = light_sampling::hit_weight(ctx.config.light_search, path.scatter_pdf, light_pdf);
            }
            let contribution = path.throughput * Vec3::from(material.emission) * weight;
            radiance[path.slot] += limited(ctx, contribution, surface_index.saturating_sub(1));
        }
        return None;
    }
    if surface_index > frame.bounces {
        return None;
    }
    let bsdf = ctx.scene.bsdfs[leaf.material as usize]?;
    let textured = TexturedPoint::new(ctx, surface.leaf, p, surface.outward(), path.length);
    let own = textured.as_ref().map(|textured| textured.numbers(&material.parameters));
    let numbers = own.as_ref().unwrap_or(&material.parameters);
    // What light sees; that of the shape says on which side a direction is.
    let shaded = textured.map_or(normal, |textured| textured.normal(surface.outward(), normal, -path.ray.direction));
    let crosses = |wi: Vec3, direction: Vec3| ctx.config.bump && (wi.z < 0.0) != (direction.dot(normal) < 0.0);
    let world_from_local = basis(shaded);
    let local_from_world = world_from_local.transpose();
    let back = local_from_world * -path.ray.direction;
    // Where the field is so rough that its normal looks normal_offset from the ray, the surface is met from the mirrored direction.
    let wo = back.with_z(back.z.abs().max(1e-5));
    let transmits = material.flags & TRANSMITS != 0;
    let beyond = medium_beyond(path.medium, Vec3::from(material.absorption), inside);
    let [choose_light, go_on] = drawn.choice;
    if material.flags & DELTA == 0 {
        path.previous_vertex = if transmits { p } else { p + normal_offset };
        if let Some(light) = light_sampling::sample(ctx, path.previous_vertex, choose_light, drawn.light) {
            let wi = local_from_world * light.direction;
            let below = wi.z < 0.0;
            if (wi.z > 0.0 || transmits) && !crosses(wi, light.direction) {
                let scattering = (bsdf.eval)(numbers, wo, wi, inside);
                if scattering.value.max_element() > 0.0 {
                    connections.push(Connection {
                        slot: path.slot,
                        radiance: path.throughput * scattering.value * light.irradiance,
                        scatter_pdf: scattering.pdf,
                        ray: Ray {
                            origin: p + if below { -normal_offset } else { normal_offset },
                            direction: light.direction,
                        },
                        light,
                        path_length: path.length,
                        medium: if below { beyond } else { path.medium },
                        random: path.random,
                    });
                }
            }
        }
    }
    let [u, v] = drawn.scatter;
    let scattered = (bsdf.sample)(numbers, wo, inside, [u, v, drawn.lobe])?;
    let direction = (world_from_local * scattered.wi).normalize();
    if crosses(scattered.wi, direction) {
        return None;
    }
    path.throughput *= scattered.weight;
    path.index_square *= scattered.eta * scattered.eta;
    if surface_index > ROULETTE_DEPTH {
        let survival = (SURVIVAL * path.throughput.max_element() * path.index_square).min(1.0);
        if go_on >= survival {
            return None;
        }
        path.throughput /= survival;
    }
    let below = scattered.wi.z < 0.0;
    let straight = scattered.pdf == 0.0 && below && (path.passing || path.scatter_pdf > 0.0);
    path.passing = ctx.config.fast_caustics && straight;
    path.ray = Ray { origin: p + if below { -normal_offset } else { normal_offset }, direction };
    path.scatter_pdf = scattered.pdf;
    if below {
        path.medium = beyond;
    }
    Some(())
}
