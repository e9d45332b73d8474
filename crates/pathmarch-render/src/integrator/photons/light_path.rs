//! Light paths: from a light over focusing surfaces to the first one that is not.
//!
//! A light path carries power, not radiance. So refraction does not scale it by the square of the relative index, and a
//! shading normal scales it by the ratio of cosines (Veach 1997, "Robust Monte Carlo Methods for Light Transport
//! Simulation", sections 5.2 and 5.3).

use super::emission::Emission;
use crate::integrator::nested_dielectrics::refracting_parameters;
use crate::integrator::participating_media::{medium_after, transmittance_in};
use crate::intersect::march::march;
use crate::intersect::ray::{Hit, Ray, RaySegment};
use crate::sampling::basis::{basis, local_viewer};
use crate::sampling::sobol::{PixelSampler, hash};
use crate::scene::material::{BOUNDARY, FOCUSES};
use crate::scene::photon_map::{MAX_FOCUSING, Photon};
use crate::scene::{Medium, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use glam::Vec3;
use pathmarch_field::graph::Batch;
use pathmarch_scene::Sampler;
use rayon::prelude::*;

/// Largest number of boundaries of media that a light path crosses.
const MAX_BOUNDARIES: u32 = 64;
/// Number of light paths that are traced side by side.
const BATCH: u32 = 512;
/// Number of columns in which light paths are arranged for the sampler.
const COLUMNS: u32 = 1 << 10;
/// Seed of light paths, so that they are independent of camera paths.
const SEED: u32 = 0x6c62_272e;
/// Length of the path at its start, metres. Only camera rays have length 0.
const FIRST_LENGTH: f32 = 1e-20;

/// Pairs of random numbers of a light path.
mod pair {
    /// Choice of light and target (x), and of the wavelength (y).
    pub(super) const CHOICE: u32 = 0;
    /// Position on the light.
    pub(super) const POSITION: u32 = 1;
    /// Direction.
    pub(super) const DIRECTION: u32 = 2;
    /// First pair of the first focusing surface.
    pub(super) const SURFACE: u32 = 3;
    /// Direction, from the first pair of the surface.
    pub(super) const SCATTER: u32 = 0;
    /// Choice of the lobe (x) and Russian roulette (y), likewise.
    pub(super) const LOBE: u32 = 1;
    /// Number of pairs of each surface.
    pub(super) const PER_SURFACE: u32 = 2;
}

/// Light path before its next surface.
struct LightPath {
    sampler: PixelSampler,
    ray: Ray,
    /// Power, W.
    power: Vec3,
    /// Power at the start.
    emitted: f32,
    /// Length, metres.
    length: f32,
    /// Media of the solids around the path.
    medium: Medium,
    /// Wavelength, nanometres; `None` before the first surface that disperses.
    wavelength: Option<f32>,
    /// Number of focusing surfaces so far.
    focusing: u32,
}

/// Photons of the light paths of one sample, in the order of the paths.
pub(super) fn photons(ctx: &TraceContext, emission: &Emission, sample: u32, count: u32) -> Vec<Photon> {
    let batches: Vec<u32> = (0..count).step_by(BATCH as usize).collect();
    let trace = |&first: &u32| trace_batch(ctx, emission, sample, first..(first + BATCH).min(count), count);
    let photons: Vec<Vec<Photon>> = batches.par_iter().map(trace).collect();
    photons.into_iter().flatten().collect()
}

fn trace_batch(
    ctx: &TraceContext,
    emission: &Emission,
    sample: u32,
    indices: std::ops::Range<u32>,
    count: u32,
) -> Vec<Photon> {
    let mut paths = start(ctx, emission, sample, indices, count);
    let mut photons = Vec::new();
    for _ in 0..=MAX_FOCUSING + MAX_BOUNDARIES {
        if paths.is_empty() {
            break;
        }
        let interactions = intersect(ctx, &mut paths);
        let mut interactions = interactions.iter();
        paths.retain_mut(|path| {
            interactions.next().is_some_and(|interaction| follow(ctx, path, interaction, &mut photons).is_some())
        });
    }
    photons
}

/// Starts of light paths with these indices, without those whose light is blocked before.
fn start(
    ctx: &TraceContext,
    emission: &Emission,
    sample: u32,
    indices: std::ops::Range<u32>,
    count: u32,
) -> Vec<LightPath> {
    let seed = hash(ctx.frame.seed ^ SEED);
    let independent = ctx.frame.sampler == Sampler::Independent as u32;
    let sampler_of =
        |index: u32| PixelSampler::new(index % COLUMNS, index / COLUMNS, sample, seed).independent(independent);
    let mut parallel = Vec::new();
    let mut paths = Vec::with_capacity(indices.len());
    for sampler in indices.map(sampler_of) {
        let [choice, _] = sampler.sample_2d(pair::CHOICE);
        let (position, direction) = (sampler.sample_2d(pair::POSITION), sampler.sample_2d(pair::DIRECTION));
        let Some(start) = emission.sample(ctx.scene, ctx.frame, choice, position, direction) else { continue };
        let power = start.power / count as f32;
        if power.max_element() > 0.0 && power.is_finite() {
            parallel.push(start.is_parallel);
            let (ray, medium) = (start.ray, start.medium);
            let emitted = power.max_element();
            let (length, wavelength, focusing) = (FIRST_LENGTH, None, 0);
            paths.push(LightPath { sampler, ray, power, emitted, length, medium, wavelength, focusing });
        }
    }
    if parallel.contains(&true) {
        let segment = |path: &LightPath| RaySegment {
            ray: Ray { direction: -path.ray.direction, ..path.ray },
            path_length: path.length,
            limit: f32::INFINITY,
        };
        let blockers = march(ctx, &paths.iter().map(segment).collect::<Vec<_>>());
        let mut kept = parallel.iter().zip(&blockers).map(|(parallel, blocker)| !parallel || blocker.is_none());
        paths.retain(|_| kept.next().unwrap_or(false));
    }
    paths
}

/// Intersects the rays of paths; removes those without a hit and returns the interactions of the others.
fn intersect(ctx: &TraceContext, paths: &mut Vec<LightPath>) -> Vec<SurfaceInteraction> {
    let segment_of = |path: &LightPath| RaySegment { ray: path.ray, path_length: path.length, limit: f32::INFINITY };
    let segments: Vec<RaySegment> = paths.iter().map(segment_of).collect();
    let hits = march(ctx, &segments);
    let mut arrivals: Vec<(RaySegment, Hit)> = Vec::with_capacity(paths.len());
    let mut results = segments.into_iter().zip(hits);
    paths.retain_mut(|path| {
        let Some((segment, Some(hit))) = results.next() else { return false };
        if ctx.config.absorption {
            path.power *= transmittance_in(ctx, &path.medium, hit.t);
        }
        path.length += hit.t;
        arrivals.push((segment, hit));
        true
    });
    let seed = |k: usize| paths[k].sampler.unstratified_seed(paths[k].focusing);
    surface_interactions(ctx, &arrivals, |k, blend| f32::choice(seed(k), blend))
}

/// Follows a path at a surface: on over a focusing one; elsewhere it ends, as a photon if it met a focusing one before.
fn follow(
    ctx: &TraceContext,
    path: &mut LightPath,
    interaction: &SurfaceInteraction,
    photons: &mut Vec<Photon>,
) -> Option<()> {
    let &SurfaceInteraction { p, normal, inside, normal_offset, .. } = interaction;
    let material_index = ctx.scene.leaves[interaction.leaf].material as usize;
    let material = &ctx.scene.materials[material_index];
    if material.has(BOUNDARY) || ctx.config.nested_dielectrics && ctx.scene.is_skipped(&path.medium, interaction.leaf) {
        path.medium = medium_after(ctx, &path.medium, interaction.leaf, inside);
        path.ray.origin = p - normal_offset;
        return Some(());
    }
    let bsdf = ctx.scene.bsdfs[material_index].filter(|_| !material.emits())?;
    if !material.has(FOCUSES) {
        if path.focusing > 0 {
            photons.push(Photon::new(p, -path.ray.direction, normal, path.power, path.focusing));
        }
        return None;
    }
    if path.focusing == MAX_FOCUSING.min(ctx.frame.bounces) {
        return None;
    }
    let textured = TexturedPoint::new(ctx, interaction, path.length);
    let textured_parameters = textured.as_ref().map(|textured| textured.parameters(&material.parameters));
    let parameters = textured_parameters.unwrap_or(material.parameters);
    let sampler = path.sampler;
    let carried = (&mut path.wavelength, &mut path.power);
    let refracting = refracting_parameters(ctx, &path.medium, interaction.leaf, &parameters, carried, || {
        sampler.sample_2d(pair::CHOICE)[1]
    });
    let parameters = refracting.unwrap_or(parameters);
    let incoming = -path.ray.direction;
    let ns = shading_normal(ctx.config, textured.as_ref(), interaction, incoming);
    let world_from_local = basis(ns);
    let wo = local_viewer(world_from_local.transpose(), incoming);
    let first_pair = pair::SURFACE + pair::PER_SURFACE * path.focusing;
    let [u, v] = path.sampler.sample_2d(first_pair + pair::SCATTER);
    let [lobe, roulette] = path.sampler.sample_2d(first_pair + pair::LOBE);
    let scattered = (bsdf.sample)(&parameters, wo, inside, [u, v, lobe])?;
    let direction = (world_from_local * scattered.wi).normalize();
    let is_transmission = scattered.wi.z < 0.0;
    if ctx.config.shading_normals && is_transmission != (direction.dot(normal) < 0.0) {
        return None;
    }
    path.power *= scattered.weight * (scattered.eta * scattered.eta);
    if ctx.config.shading_normals {
        let geometric = (direction.dot(normal) / incoming.dot(normal)).abs();
        let shading = (wo.z / scattered.wi.z).abs();
        path.power *= (geometric * shading).min(MAX_NORMAL_CORRECTION);
    }
    let survival_probability = (path.power.max_element() / path.emitted).min(1.0);
    if roulette >= survival_probability {
        return None;
    }
    path.power /= survival_probability;
    if is_transmission {
        path.medium = medium_after(ctx, &path.medium, interaction.leaf, inside);
    }
    path.ray = Ray { origin: p + if is_transmission { -normal_offset } else { normal_offset }, direction };
    path.focusing += 1;
    Some(())
}

/// Largest correction for a shading normal, which is unbounded at grazing angles.
const MAX_NORMAL_CORRECTION: f32 = 4.0;
