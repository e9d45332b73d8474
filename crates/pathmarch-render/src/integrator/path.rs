//! Path tracing: a unidirectional path tracer with next-event estimation (Kajiya 1986; Carvalho 2020, chapter 4).
//!
//! A path scatters at most `bounces + 1` times, first at the surface that the camera ray hits. At every surface whose
//! BSDF is no delta distribution, one light is sampled: a point, a sun, an emitting surface or the environment map.
//! BSDF sampling hits all of these but points and suns without size, and multiple importance sampling weights both
//! strategies. Only BSDF sampling contributes a constant or gradient sky. After the fourth bounce, Russian roulette
//! (Arvo and Kirk 1990) ends paths with a survival probability of min(1, 3 x throughput). The estimator is unbiased but
//! for sphere tracing (its tolerance of a tenth of a pixel, its number of steps, its far end), unless `clamp`,
//! `caustics "fast"` or a `penumbra` is set.
//!
//! **Dispersion.** At the first surface that disperses, a path chooses a wavelength and takes its colour.
//!
//! **Media.** A surface that transmits starts the next ray on its other side. The absorption coefficient of a solid is
//! added where a path enters it and subtracted where it leaves, so that solids may overlap. With priorities, the path
//! remembers the solids around it ([`scene::nested_dielectrics`](crate::scene::nested_dielectrics)).
//!
//! An emitter that is blended with glass is also hit from inside. There, equilibrium demands n² times the radiance that
//! it emits into air, and only BSDF sampling contributes it.
//!
//! All paths of a tile advance side by side, one surface at a time: intersect all rays, shade each hit, trace all
//! shadow rays.

use super::camera::{camera_rays, pixel_sampler};
use super::guides::{Guide, GuideRecorder};
use super::light_sampling::{self, nth_light_sample};
use super::media_segment::{self, Vertex};
use super::medium::transmittance;
use super::nested_dielectrics::refracting_parameters;
use super::opaque_surfaces::{self, SurfaceOfPath, kind_in_lanes};
use super::participating_media::medium_after;
use super::path_reuse::PathReuse;
use super::path_state::{Path, clamped};
use super::shadow::{self, ShadowTest};
use super::splitting::camera_ray_index;
use super::surface_samples::{SurfaceSample, SurfaceSamples};
use crate::intersect::march::march;
use crate::intersect::ray::{Ray, RaySegment};
use crate::sampling::basis::{basis, local_viewer, renormalized};
use crate::sampling::sobol::PixelSampler;
use crate::scene::leaf::IN_GLASS;
use crate::scene::material::{DELTA, EMITS, FOCUSES, GLOWS, TRANSMITS};
use crate::scene::photon_map::LitSurface;
use crate::scene::{Medium, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::shading::textured_point::{TexturedPoint, shading_normal};
use glam::Vec3;
use pathmarch_field::graph::Batch;
use pathmarch_scene::materials::KindInLanes;
use std::iter::repeat_n;

/// Radiance of `samples` samples of each of these pixels from sample `first` on, pixel by pixel. More than one sample
/// only if they share a camera ray.
pub(crate) fn trace(ctx: &TraceContext, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
    let mut reuse = ctx.config.path_reuse.then(|| PathReuse::new(pixels, samples));
    let ray_index = camera_ray_index(first, ctx.config.splitting);
    let samplers: Vec<PixelSampler> = pixels.iter().map(|&(x, y)| pixel_sampler(ctx, x, y, ray_index)).collect();
    let rays = camera_rays(ctx.frame, pixels, &samplers).into_iter().zip(samplers);
    let (mut paths, mut radiance) = start_paths(ctx, rays);
    let vertices = intersect_paths(ctx, &mut paths, 0, &mut radiance, None);
    if ctx.config.splitting == 1 {
        let radiance = continue_paths(ctx, paths, vertices, radiance, None, reuse.as_mut());
        return with_shared_light(ctx, reuse, radiance).0;
    }
    let radiance = radiance.iter().flat_map(|&value| repeat_n(value, samples as usize)).collect();
    let split_paths = paths.iter().flat_map(|path| {
        (0..samples).map(|k| {
            let (slot, sampler) = (path.slot * samples as usize + k as usize, path.sampler.with_sample(first + k));
            Path { slot, sampler, ..path.clone() }
        })
    });
    let vertices = vertices.into_iter().flat_map(|vertex| repeat_n(vertex, samples as usize)).collect();
    let radiance = continue_paths(ctx, split_paths.collect(), vertices, radiance, None, reuse.as_mut());
    with_shared_light(ctx, reuse, radiance).0
}

/// Radiance of paths that share the light of their second surfaces, and what each has of it; these radiances without `reuse`.
pub(super) fn with_shared_light(
    ctx: &TraceContext,
    reuse: Option<PathReuse>,
    mut radiance: Vec<Vec3>,
) -> (Vec<Vec3>, Option<Vec<Vec3>>) {
    let shared = reuse.map(|reuse| reuse.share(ctx, &mut radiance));
    (radiance, shared)
}

/// Radiance of one sample of each of these pixels, which do not share camera rays, and their guides.
pub(crate) fn trace_with_guides(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32) -> (Vec<Vec3>, Vec<Guide>) {
    let samplers: Vec<PixelSampler> = pixels.iter().map(|&(x, y)| pixel_sampler(ctx, x, y, sample)).collect();
    let rays = camera_rays(ctx.frame, pixels, &samplers);
    let mut recorder = GuideRecorder::new(ctx, rays.clone());
    let (mut paths, mut radiance) = start_paths(ctx, rays.into_iter().zip(samplers));
    let vertices = intersect_paths(ctx, &mut paths, 0, &mut radiance, Some(&mut recorder));
    let mut reuse = ctx.config.path_reuse.then(|| PathReuse::new(pixels, 1));
    let radiance = continue_paths(ctx, paths, vertices, radiance, Some(&mut recorder), reuse.as_mut());
    let (radiance, shared) = with_shared_light(ctx, reuse, radiance);
    let guides = recorder.into_guides(ctx, &radiance, shared.as_deref());
    (radiance, guides)
}

/// Radiance along each of these rays. They must start in the medium around the camera.
pub(crate) fn radiance_along(ctx: &TraceContext, rays: impl Iterator<Item = (Ray, PixelSampler)>) -> Vec<Vec3> {
    let (mut paths, mut radiance) = start_paths(ctx, rays);
    let vertices = intersect_paths(ctx, &mut paths, 0, &mut radiance, None);
    continue_paths(ctx, paths, vertices, radiance, None, None)
}

/// Light that the surface which a camera ray hits emits towards the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SeenEmission {
    /// Radiance, W/(m² sr).
    pub(super) radiance: Vec3,
    /// True if the surface is an emitter, which scatters no light.
    pub(super) is_emitter: bool,
}

/// Emission that these camera rays see.
pub(super) fn emission_along(ctx: &TraceContext, rays: impl Iterator<Item = (Ray, PixelSampler)>) -> Vec<SeenEmission> {
    let (mut paths, mut radiance) = start_paths(ctx, rays);
    let vertices = intersect_paths(ctx, &mut paths, 0, &mut radiance, None);
    radiance.fill(Vec3::ZERO);
    let mut are_emitters = vec![false; radiance.len()];
    for (path, vertex) in paths.iter().zip(&vertices) {
        if let Vertex::Surface(interaction) = vertex {
            are_emitters[path.slot] = !add_emission(ctx, path, interaction, 0, &mut radiance);
        }
    }
    let seen = |(radiance, is_emitter): (Vec3, bool)| SeenEmission { radiance, is_emitter };
    radiance.into_iter().zip(are_emitters).map(seen).collect()
}

/// Starts a path with each of these rays. Returns the paths and the radiance of each so far.
fn start_paths(ctx: &TraceContext, rays: impl Iterator<Item = (Ray, PixelSampler)>) -> (Vec<Path>, Vec<Vec3>) {
    let medium = ctx.frame.camera_medium();
    let index = if ctx.config.nested_dielectrics { ctx.scene.index_within(&medium.around, 0.0) } else { 1.0 };
    let paths: Vec<Path> = rays
        .enumerate()
        .map(|(slot, (ray, sampler))| Path {
            slot,
            sampler,
            ray,
            previous_vertex: ray.origin,
            previous_normal: None,
            throughput: Vec3::ONE,
            length: 0.0,
            scatter_pdf: 0.0,
            medium,
            lights_are_counted: false,
            met_photons: false,
            index_square: index * index,
            wavelength: None,
        })
        .collect();
    let radiance = vec![Vec3::ZERO; paths.len()];
    (paths, radiance)
}

/// Continues paths from their current vertices to their ends. Returns the radiance of all, and records guides
/// if a recorder is given.
fn continue_paths(
    ctx: &TraceContext,
    mut paths: Vec<Path>,
    mut vertices: Vec<Vertex>,
    mut radiance: Vec<Vec3>,
    mut recorder: Option<&mut GuideRecorder>,
    mut reuse: Option<&mut PathReuse>,
) -> Vec<Vec3> {
    for surface_index in 0.. {
        if paths.is_empty() {
            break;
        }
        if let Some(recorder) = &mut recorder {
            for (path, vertex) in paths.iter().zip(&vertices) {
                let Vertex::Surface(interaction) = vertex else { continue };
                recorder.record(ctx, path, path.throughput, interaction, surface_index, radiance[path.slot]);
            }
        }
        if let Some(reuse) = reuse.as_mut().filter(|_| surface_index < 2) {
            for (path, vertex) in paths.iter_mut().zip(&vertices) {
                let Vertex::Surface(interaction) = vertex else { continue };
                if reuse.record(ctx, path, interaction, surface_index, radiance[path.slot]) {
                    (radiance[path.slot], path.throughput) = (Vec3::ZERO, Vec3::ONE);
                }
            }
        }
        let scatters: Vec<bool> = paths
            .iter()
            .zip(&vertices)
            .map(|(path, vertex)| match vertex {
                Vertex::Surface(interaction) => add_emission(ctx, path, interaction, surface_index, &mut radiance),
                Vertex::Medium => true,
            })
            .collect();
        if surface_index > ctx.frame.bounces {
            break;
        }
        let shadow_tests = if surface_index == 0 && ctx.config.indirect_samples > 1 {
            scatter_several(ctx, &mut paths, &vertices, scatters, &mut radiance)
        } else {
            scatter(ctx, &mut paths, &vertices, scatters, (surface_index, 0), &mut radiance)
        };
        if let Some(recorder) = &mut recorder {
            recorder.reflections.sample_lights(&shadow_tests, |test| test.slot);
        }
        for (slot, direct_light) in shadow::direct_light(ctx, shadow_tests, surface_index) {
            let light = clamped(ctx, direct_light, surface_index);
            radiance[slot] += light;
            if let Some(recorder) = &mut recorder {
                recorder.reflections.add_sampled(slot, light);
            }
        }
        if let Some(recorder) = &mut recorder {
            for path in &paths {
                recorder.reflections.go_on(path.slot, path.ray.direction, radiance[path.slot]);
            }
        }
        vertices = intersect_paths(ctx, &mut paths, surface_index + 1, &mut radiance, recorder.as_deref_mut());
        if let Some(recorder) = &mut recorder {
            for path in &paths {
                recorder.reflections.arrive(path.slot, path.length);
            }
        }
    }
    radiance
}

/// Samples lights, and several rays that leave the first surface of each path that `scatters`. Replaces it by as many paths of
/// which each carries its share, and returns the light samples.
fn scatter_several(
    ctx: &TraceContext,
    paths: &mut Vec<Path>,
    vertices: &[Vertex],
    scatters: Vec<bool>,
    radiance: &mut [Vec3],
) -> Vec<ShadowTest> {
    let count = ctx.config.indirect_samples;
    let arriving = std::mem::take(paths);
    let mut shadow_tests = Vec::new();
    for part in 0..count {
        let mut leaving = arriving.clone();
        shadow_tests.extend(scatter(ctx, &mut leaving, vertices, scatters.clone(), (0, part), radiance));
        paths.extend(leaving.into_iter().map(|path| Path {
            sampler: path.sampler.part(part, count),
            throughput: path.throughput / count as f32,
            ..path
        }));
    }
    shadow_tests
}

/// Samples a light and the next ray of each path that `scatters`. Removes the paths that end, and returns the light samples.
fn scatter(
    ctx: &TraceContext,
    paths: &mut Vec<Path>,
    vertices: &[Vertex],
    mut scatters: Vec<bool>,
    (surface_index, part): (u32, u32),
    radiance: &mut [Vec3],
) -> Vec<ShadowTest> {
    let samples = SurfaceSamples::new(ctx, paths, surface_index, part);
    let mut shadow_tests = Vec::with_capacity(paths.len() * samples.light_samples as usize);
    let mut opaque: Vec<(KindInLanes, Vec<SurfaceOfPath>)> = Vec::new();
    for (index, (vertex, scatters)) in vertices.iter().zip(&mut scatters).enumerate() {
        if !*scatters {
            continue;
        }
        if let Vertex::Surface(interaction) = vertex
            && let Some(kind) = kind_in_lanes(ctx, ctx.scene.leaves[interaction.leaf].material as usize)
        {
            match opaque.iter_mut().find(|(other, _)| *other == kind) {
                Some((_, surfaces)) => surfaces.push((index, interaction)),
                None => {
                    let mut surfaces = Vec::with_capacity(paths.len());
                    surfaces.push((index, interaction));
                    opaque.push((kind, surfaces));
                }
            }
            continue;
        }
        let (path, samples) = (&mut paths[index], samples.of(index));
        let next_ray = match vertex {
            Vertex::Surface(interaction) => {
                let radiance = &mut radiance[path.slot];
                shade(ctx, path, interaction, &samples, surface_index, radiance, &mut shadow_tests)
            }
            Vertex::Medium => media_segment::scatter(ctx, path, surface_index, samples.scatter, samples.choice[1]),
        };
        *scatters = next_ray.is_some();
    }
    for (kind, surfaces) in &opaque {
        let shade = opaque_surfaces::shading_of(*kind);
        for surfaces in surfaces.chunks(8) {
            let going_on = shade(ctx, paths, surfaces, &samples, surface_index, &mut shadow_tests);
            for (lane, (index, _)) in surfaces.iter().enumerate() {
                scatters[*index] = going_on >> lane & 1 == 1;
            }
        }
    }
    let mut kept = scatters.into_iter();
    paths.retain(|_| kept.next() == Some(true));
    shadow_tests
}

/// Intersects the rays of paths. Removes paths without a hit and adds the radiance of the sky to them. Returns the
/// vertices of the others.
fn intersect_paths(
    ctx: &TraceContext,
    paths: &mut Vec<Path>,
    surface_index: u32,
    radiance: &mut [Vec3],
    recorder: Option<&mut GuideRecorder>,
) -> Vec<Vertex> {
    if ctx.config.media {
        return media_segment::follow(ctx, paths, surface_index, radiance, recorder);
    }
    let segment_of = |path: &Path| RaySegment { ray: path.ray, path_length: path.length, limit: f32::INFINITY };
    let segments: Vec<RaySegment> = paths.iter().map(segment_of).collect();
    let hits = march(ctx, &segments);
    let mut segment_hits = Vec::with_capacity(paths.len());
    let mut results = segments.into_iter().zip(hits);
    paths.retain_mut(|path| {
        let end = results.next().and_then(|(segment, hit)| Some((segment, hit?)));
        if ctx.config.absorption {
            path.throughput *= transmittance(path.medium.absorption, end.map_or(f32::INFINITY, |(_, hit)| hit.t));
        }
        if let Some((_, hit)) = end {
            path.length += hit.t;
            path.ray.origin += path.ray.direction * hit.t;
        } else {
            let contribution = path.throughput * path.escaped_radiance(ctx);
            // Light that a ray hits counts as direct light of the previous surface.
            radiance[path.slot] += clamped(ctx, contribution, surface_index.saturating_sub(1));
        }
        segment_hits.extend(end);
        end.is_some()
    });
    let seed = |k: usize| paths[k].sampler.unstratified_seed(surface_index);
    let interactions = surface_interactions(ctx, &segment_hits, |k, blend| f32::choice(seed(k), blend));
    interactions.into_iter().map(Vertex::Surface).collect()
}

/// Contribution of light that a surface emits towards a path.
fn emitted_light(
    ctx: &TraceContext,
    path: &Path,
    interaction: &SurfaceInteraction,
    emission: Vec3,
    surface_index: u32,
) -> Vec3 {
    let &SurfaceInteraction { normal, inside, .. } = interaction;
    let leaf = &ctx.scene.leaves[interaction.leaf];
    let light = ctx.scene.light_of(interaction.leaf, interaction.triangle);
    let is_counted =
        |light: usize| !ctx.config.traced_caustics || ctx.scene.starts_light_paths(&ctx.scene.lights[light].shape);
    let counted = path.lights_are_counted && light.is_some_and(is_counted);
    if !ctx.scene.emits_towards(interaction.leaf, normal) || counted {
        return Vec3::ZERO;
    }
    let mut weight = 1.0;
    if inside && leaf.has(IN_GLASS) {
        weight = path.index_square;
    } else if let Some(light) = light.filter(|_| path.scatter_pdf > 0.0) {
        let cosine = normal.dot(path.ray.direction).abs();
        let (vertex, shape) = (path.previous_vertex, &ctx.scene.lights[light].shape);
        let pmf = light_sampling::light_pmf(ctx.scene, light, vertex, path.previous_normal);
        let light_pdf = light_sampling::light_pdf(shape, pmf, vertex, path.ray.origin, cosine);
        weight = light_sampling::hit_weight(ctx.config.direct_lighting, path.scatter_pdf, light_pdf);
    }
    clamped(ctx, path.throughput * emission * weight, surface_index.saturating_sub(1))
}

/// Contribution of the light that a surface emits towards a path; zero if it emits none.
pub(super) fn emission_towards(
    ctx: &TraceContext,
    path: &Path,
    interaction: &SurfaceInteraction,
    surface_index: u32,
) -> Vec3 {
    let material = ctx.scene.material_of(interaction.leaf);
    if material.flags & (EMITS | GLOWS) == 0 {
        return Vec3::ZERO;
    }
    let emission = Vec3::from(material.emission);
    let textured = || TexturedPoint::new(ctx, interaction, path.length)?.emission();
    let varies = ctx.config.emission_textures && material.has(GLOWS);
    let emission = if varies { textured().unwrap_or(emission) } else { emission };
    emitted_light(ctx, path, interaction, emission, surface_index)
}

/// Adds the light that a surface emits towards a path. Returns true if it also scatters light.
fn add_emission(
    ctx: &TraceContext,
    path: &Path,
    interaction: &SurfaceInteraction,
    surface_index: u32,
    radiance: &mut [Vec3],
) -> bool {
    radiance[path.slot] += emission_towards(ctx, path, interaction, surface_index);
    !ctx.scene.material_of(interaction.leaf).emits()
}

/// Shades a surface interaction: samples a light and the next ray. `None` ends the path.
pub(super) fn shade(
    ctx: &TraceContext,
    path: &mut Path,
    interaction: &SurfaceInteraction,
    samples: &SurfaceSample,
    surface_index: u32,
    radiance: &mut Vec3,
    shadow_tests: &mut Vec<ShadowTest>,
) -> Option<()> {
    let frame = ctx.frame;
    let &SurfaceInteraction { p, normal, inside, normal_offset, .. } = interaction;
    let leaf = &ctx.scene.leaves[interaction.leaf];
    let material = &ctx.scene.materials[leaf.material as usize];
    let bsdf = ctx.scene.bsdfs[leaf.material as usize]?;
    let textured = TexturedPoint::new(ctx, interaction, path.length);
    let [lobe, wavelength] = samples.lobe;
    let textured_parameters = textured.as_ref().map(|textured| textured.parameters(&material.parameters));
    let parameters = textured_parameters.as_ref().unwrap_or(&material.parameters);
    let carried = (&mut path.wavelength, &mut path.throughput);
    let refracting = refracting_parameters(ctx, &path.medium, interaction.leaf, parameters, carried, || wavelength);
    let parameters = refracting.as_ref().unwrap_or(parameters);
    // Shading normal; the geometric normal decides on which side a direction is.
    let ns = shading_normal(ctx.config, textured.as_ref(), interaction, -path.ray.direction);
    let crosses_surface =
        |wi: Vec3, direction: Vec3| ctx.config.shading_normals && (wi.z < 0.0) != (direction.dot(normal) < 0.0);
    let world_from_local = basis(ns);
    let local_from_world = world_from_local.transpose();
    let wo = local_viewer(local_from_world, -path.ray.direction);
    let transmits = material.has(TRANSMITS);
    let medium_beyond_surface = |medium: &Medium| medium_after(ctx, medium, interaction.leaf, inside);
    let footprint = if ctx.photons.is_some() { path.footprint(p) } else { 0.0 };
    let focuses = ctx.config.traced_caustics && material.has(FOCUSES);
    let [light_choice, roulette] = samples.choice;
    if !material.has(DELTA) {
        path.previous_vertex = if transmits { p } else { p + normal_offset };
        path.previous_normal = (!transmits).then_some(ns);
        let (vertex, normal) = (path.previous_vertex, path.previous_normal);
        // Photons have already contributed the others.
        let is_needed = |shape| !(focuses && path.met_photons && ctx.scene.starts_light_paths(shape));
        for sample in 0..samples.light_samples {
            let (choice, position) = nth_light_sample(sample, samples.light_samples, light_choice, samples.light);
            let Some(chosen) = light_sampling::choose_light(ctx, vertex, normal, choice) else { continue };
            if !is_needed(chosen.shape) {
                continue;
            }
            let Some(light) = light_sampling::sample_direction(ctx, &chosen, vertex, position) else { continue };
            let wi = local_from_world * light.direction;
            let is_transmission = wi.z < 0.0;
            if !(wi.z > 0.0 || transmits) || crosses_surface(wi, light.direction) {
                continue;
            }
            let evaluated = (bsdf.eval)(parameters, wo, wi, inside);
            if evaluated.value.max_element() > 0.0 {
                let radiance = path.throughput * evaluated.value * light.irradiance / samples.light_samples as f32;
                let origin = p + if is_transmission { -normal_offset } else { normal_offset };
                shadow_tests.push(ShadowTest {
                    medium: if is_transmission { medium_beyond_surface(&path.medium) } else { path.medium },
                    ..ShadowTest::new(ctx, path, origin, &light, (radiance, evaluated.pdf))
                });
            }
        }
    }
    if let Some(photons) = ctx.photons.filter(|_| !focuses && samples.light_samples > 0) {
        let reflect = |direction: Vec3| {
            let wi = local_from_world * direction;
            let arrives = (wi.z > 0.0 || transmits) && !crosses_surface(wi, direction);
            if arrives { (bsdf.eval)(parameters, wo, wi, inside).value } else { Vec3::ZERO }
        };
        let surface = LitSurface {
            p,
            normal,
            transmits,
            footprint,
            max_focusing: frame.bounces - surface_index,
            seed: path.sampler.unstratified_seed(surface_index),
        };
        let caustics = path.throughput * photons.reflected(&surface, reflect);
        *radiance += clamped(ctx, caustics, surface_index);
    }
    let [u, v] = samples.scatter;
    let scattered = (bsdf.sample)(parameters, wo, inside, [u, v, lobe])?;
    let direction = renormalized(world_from_local * scattered.wi);
    if crosses_surface(scattered.wi, direction) {
        return None;
    }
    path.throughput *= scattered.weight;
    path.index_square *= scattered.eta * scattered.eta;
    if !path.survives(surface_index, roulette) {
        return None;
    }
    let is_transmission = scattered.wi.z < 0.0;
    if ctx.config.fast_caustics {
        let has_sampled_lights = path.lights_are_counted || path.scatter_pdf > 0.0;
        path.lights_are_counted = scattered.pdf == 0.0 && is_transmission && has_sampled_lights;
    } else if ctx.config.traced_caustics {
        path.met_photons |= !focuses;
        path.lights_are_counted = focuses && path.met_photons;
    }
    path.ray = Ray { origin: p + if is_transmission { -normal_offset } else { normal_offset }, direction };
    path.scatter_pdf = scattered.pdf;
    if is_transmission {
        path.medium = medium_beyond_surface(&path.medium);
    }
    Some(())
}
