//! Segments of paths through participating media, see [`participating_media`](super::participating_media).
//!
//! Boundaries of media, and the surfaces of solids inside others of higher priority, are no surfaces: a path crosses them
//! on its way to its next scattering event.

use super::guides::GuideRecorder;
use super::light_sampling;
use super::medium::transmittance;
use super::participating_media::{
    emitted_radiance, medium_after, phase_function, sample_distance, sample_phase, sample_point,
};
use super::path_state::{Path, clamped};
use super::shadow::{self, MAX_CROSSINGS, ShadowTest};
use crate::intersect::march::march;
use crate::intersect::ray::{Hit, RaySegment};
use crate::sampling::sobol::{PixelSampler, pair};
use crate::scene::material::BOUNDARY;
use crate::scene::{Medium, TraceContext};
use crate::shading::surface_interaction::{SurfaceInteraction, surface_interactions};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::graph::Batch;

shared_constants! {
    /// Least distance of scattering events from the surface behind them, in rounding errors, so that none lies beyond it.
    const SURFACE_MARGIN: f32 = 16.0;
    /// Length of a path at its origin in a medium, metres, for the hit tolerance: a tolerance of the length from the camera
    /// would let rays pass through the surface that they start close to.
    const LENGTH_IN_MEDIUM: f32 = 1e-20;
}

/// Place at which a path scatters.
#[derive(Clone, Copy)]
pub(super) enum Vertex {
    Surface(SurfaceInteraction),
    /// Point in a medium, the origin of the path's ray.
    Medium,
}

/// Follows the rays of paths to their next surfaces or scattering events. Adds light that media on the way emit and
/// scatter, and that of the sky. Removes paths that escape, and returns the vertices of the others. If a recorder is given,
/// it records the surfaces behind scattering events.
pub(super) fn follow(
    ctx: &TraceContext,
    paths: &mut Vec<Path>,
    surface_index: u32,
    radiance: &mut [Vec3],
    mut recorder: Option<&mut GuideRecorder>,
) -> Vec<Vertex> {
    let mut vertices: Vec<Option<Vertex>> = vec![None; paths.len()];
    let mut pending: Vec<usize> = (0..paths.len()).collect();
    // Rays beyond the boundaries of media in which paths scatter, for guides.
    let mut beyond = Vec::new();
    for crossing in 0..MAX_CROSSINGS {
        if pending.is_empty() {
            break;
        }
        let segment_of = |&index: &usize| {
            let Path { ray, length, .. } = paths[index];
            RaySegment { ray, path_length: length, limit: f32::INFINITY }
        };
        let segments: Vec<RaySegment> = pending.iter().map(segment_of).collect();
        let hits = march(ctx, &segments);
        let samplers: Vec<PixelSampler> = pending.iter().map(|&index| paths[index].sampler).collect();
        let samples = segment_samples(&samplers, surface_index, crossing);
        let mut shadow_tests = Vec::new();
        let mut arrivals: Vec<Arrival> = Vec::with_capacity(pending.len());
        let mut arriving = Vec::with_capacity(pending.len());
        let mut before_sky = Vec::new();
        for (((&index, segment), hit), samples) in pending.iter().zip(&segments).zip(hits).zip(samples) {
            let path = &mut paths[index];
            let throughput = path.throughput;
            let start = path.ray.origin;
            let Passed { end, emitted } = pass(ctx, path, hit, surface_index, &samples, radiance, &mut shadow_tests);
            if let (Some((light, depth)), Some(recorder)) =
                (emitted, recorder.as_deref_mut().filter(|_| surface_index == 0))
            {
                recorder.record_medium(path.slot, start + path.ray.direction * depth, light);
            }
            if matches!(end, SegmentEnd::Event) {
                vertices[index] = Some(Vertex::Medium);
                if recorder.is_none() {
                    continue;
                }
            }
            if let Some(hit) = hit {
                arrivals.push(Arrival { index, hit, throughput, end });
                arriving.push((*segment, hit));
            } else if matches!(end, SegmentEnd::Event) {
                before_sky.push(path.slot);
            }
        }
        let mut first = recorder.as_deref_mut().filter(|_| surface_index == 0);
        if let Some(recorder) = &mut first {
            recorder.sample_lights_in_media(&shadow_tests);
        }
        for (slot, light) in shadow::direct_light(ctx, shadow_tests, surface_index) {
            let light = clamped(ctx, light, surface_index);
            radiance[slot] += light;
            if let Some(recorder) = &mut first {
                recorder.media.add_sampled(slot, light);
            }
        }
        if let Some(recorder) = recorder.as_deref_mut() {
            for &index in pending.iter().filter(|&&index| matches!(vertices[index], Some(Vertex::Medium))) {
                let path = &paths[index];
                recorder.record_event(path.slot, path.ray.origin, surface_index, radiance[path.slot]);
            }
            before_sky.into_iter().for_each(|slot| recorder.end(slot));
        }
        let seed = |k: usize| paths[arrivals[k].index].sampler.unstratified_seed(surface_index);
        let interactions = surface_interactions(ctx, &arriving, |k, blend| f32::choice(seed(k), blend));
        pending.clear();
        for (Arrival { index, hit, throughput, end }, interaction) in arrivals.into_iter().zip(interactions) {
            let path = &mut paths[index];
            let is_crossed = is_crossed(ctx, path, &interaction);
            if let (SegmentEnd::Event, Some(recorder)) = (&end, &mut recorder) {
                if is_crossed && surface_index == 0 {
                    let mut crossing = Path { throughput, ..path.clone() };
                    cross(ctx, &mut crossing, &interaction, hit.t);
                    beyond.push(crossing);
                    continue;
                }
                if !is_crossed {
                    recorder.record(ctx, path, throughput, &interaction, surface_index, radiance[path.slot]);
                }
                recorder.end(path.slot);
                continue;
            }
            if is_crossed {
                cross(ctx, path, &interaction, hit.t);
                pending.push(index);
            } else {
                path.length += hit.t;
                path.ray.origin += path.ray.direction * hit.t;
                vertices[index] = Some(Vertex::Surface(interaction));
            }
        }
    }
    if let Some(recorder) = recorder {
        record_surfaces_beyond(ctx, beyond, radiance, recorder);
    }
    let mut kept = vertices.iter();
    paths.retain(|_| kept.next().is_some_and(Option::is_some));
    vertices.into_iter().flatten().collect()
}

/// True if a path crosses the surface that its ray has reached, as if it were not there.
fn is_crossed(ctx: &TraceContext, path: &Path, interaction: &SurfaceInteraction) -> bool {
    ctx.scene.material_of(interaction.leaf).has(BOUNDARY)
        || ctx.config.nested_dielectrics && ctx.scene.is_skipped(&path.medium, interaction.leaf)
}

/// Moves a path to the other side of a surface at a distance of `t` metres.
fn cross(ctx: &TraceContext, path: &mut Path, interaction: &SurfaceInteraction, t: f32) {
    // Like an event in the medium, the boundary is found to rounding, so that no chord is missed.
    let is_boundary = ctx.scene.material_of(interaction.leaf).has(BOUNDARY);
    path.length = if is_boundary { LENGTH_IN_MEDIUM } else { path.length + t };
    path.medium = medium_after(ctx, &path.medium, interaction.leaf, interaction.inside);
    path.ray.origin = interaction.p - interaction.normal_offset;
}

/// Records the first surfaces on the rays of paths that scatter in media before these.
fn record_surfaces_beyond(ctx: &TraceContext, mut beyond: Vec<Path>, radiance: &[Vec3], recorder: &mut GuideRecorder) {
    let slots: Vec<usize> = beyond.iter().map(|path| path.slot).collect();
    for _ in 0..MAX_CROSSINGS {
        if beyond.is_empty() {
            break;
        }
        let segment_of = |path: &Path| RaySegment { ray: path.ray, path_length: path.length, limit: f32::INFINITY };
        let segments: Vec<RaySegment> = beyond.iter().map(segment_of).collect();
        let hits = march(ctx, &segments);
        let mut arriving: Vec<(RaySegment, Hit)> = Vec::with_capacity(beyond.len());
        let mut results = segments.into_iter().zip(hits);
        beyond.retain(|_| {
            let end = results.next().and_then(|(segment, hit)| Some((segment, hit?)));
            arriving.extend(end);
            end.is_some()
        });
        let seed = |k: usize| beyond[k].sampler.unstratified_seed(0);
        let interactions = surface_interactions(ctx, &arriving, |k, blend| f32::choice(seed(k), blend));
        let mut ends = arriving.into_iter().zip(interactions);
        beyond.retain_mut(|path| {
            let Some(((_, hit), interaction)) = ends.next() else { return false };
            let is_crossed = is_crossed(ctx, path, &interaction);
            match is_crossed {
                true => cross(ctx, path, &interaction, hit.t),
                false => recorder.record(ctx, path, path.throughput, &interaction, 0, radiance[path.slot]),
            }
            is_crossed
        });
    }
    slots.into_iter().for_each(|slot| recorder.end(slot));
}

/// Path at the end of a segment.
struct Arrival {
    /// Index of the path.
    index: usize,
    hit: Hit,
    /// Throughput at the start of the segment.
    throughput: Vec3,
    end: SegmentEnd,
}

/// End of a segment.
enum SegmentEnd {
    /// Scattering event in the medium.
    Event,
    /// Surface, or the sky.
    Surface,
}

/// Passage of a path through a segment.
struct Passed {
    end: SegmentEnd,
    /// Light that the medium emits, and how far away on the segment, metres; `None` if it neither emits nor scatters.
    emitted: Option<(Vec3, f32)>,
}

/// Random numbers of a segment.
struct SegmentSamples {
    distance: [f32; 2],
    point: [f32; 2],
    choice: f32,
    light: [f32; 2],
}

/// Random numbers of the segments of paths behind this number of boundaries.
fn segment_samples(
    samplers: &[PixelSampler],
    surface_index: u32,
    crossing: u32,
) -> impl Iterator<Item = SegmentSamples> + use<> {
    let segment = surface_index + pair::SEGMENTS_PER_CROSSING * crossing;
    let of_pair =
        |pair: u32| PixelSampler::samples_2d(samplers, pair::PAIR_SEGMENT + pair::PAIRS_PER_SEGMENT * segment + pair);
    let samples = of_pair(pair::PAIR_DISTANCE)
        .into_iter()
        .zip(of_pair(pair::PAIR_POINT))
        .zip(of_pair(pair::PAIR_SEGMENT_CHOICE))
        .zip(of_pair(pair::PAIR_SEGMENT_LIGHT));
    samples.map(|(((distance, point), [choice, _]), light)| SegmentSamples { distance, point, choice, light })
}

/// Follows a path through the medium of a segment up to its hit: adds light that the medium emits, samples a light whose
/// light it scatters, and samples the scattering event. A path that escapes adds the light of the sky.
fn pass(
    ctx: &TraceContext,
    path: &mut Path,
    hit: Option<Hit>,
    surface_index: u32,
    samples: &SegmentSamples,
    radiance: &mut [Vec3],
    shadow_tests: &mut Vec<ShadowTest>,
) -> Passed {
    let length = hit.map_or(f32::INFINITY, |hit| hit.t);
    if hit.is_none() && ctx.config.media_are_bounded {
        // A ray that escapes is outside of all solids, even if it missed a surface on its way.
        path.medium = Medium::default();
    }
    let medium = path.medium.with_fog(&ctx.scene.media.fog);
    // Light that a ray hits counts as direct light of the previous surface.
    let bounces = surface_index.saturating_sub(1);
    let scatters = surface_index <= ctx.frame.bounces && medium.scatters();
    let mut emitted = scatters.then_some((Vec3::ZERO, 0.0));
    if medium.emits() {
        let light = clamped(ctx, path.throughput * emitted_radiance(&medium, length), bounces);
        radiance[path.slot] += light;
        emitted = Some((light, 0.5 * length.min(medium.extinction().max_element().recip()).min(ctx.frame.far)));
    }
    if scatters {
        // From inside a solid, its surface blocks all shadow rays to lights outside.
        if ctx.config.lights_in_solids || ctx.config.fast_caustics || !path.medium.is_displaced() {
            shadow_tests.extend(scattered_light(ctx, path, &medium, length, samples));
        }
        let (event, weight) = sample_distance(&medium, path.throughput, length, samples.distance);
        path.throughput *= weight;
        if let Some(t) = event {
            let t = hit.map_or(t, |hit| {
                let end = path.ray.origin + path.ray.direction * hit.t;
                let margin = SURFACE_MARGIN * ctx.frame.rounding * end.abs().max_element();
                t.min((hit.t - margin).max(0.5 * hit.t))
            });
            path.ray.origin += path.ray.direction * t;
            path.length += t;
            return Passed { end: SegmentEnd::Event, emitted };
        }
    } else {
        path.throughput *= transmittance(medium.extinction(), length);
    }
    if hit.is_none() {
        radiance[path.slot] += clamped(ctx, path.throughput * path.escaped_radiance(ctx), bounces);
    }
    Passed { end: SegmentEnd::Surface, emitted }
}

/// Light of one light that the medium of a segment scatters into a path, before visibility.
fn scattered_light(
    ctx: &TraceContext,
    path: &Path,
    medium: &Medium,
    length: f32,
    samples: &SegmentSamples,
) -> Option<ShadowTest> {
    let ray = &path.ray;
    let point = sample_point(ctx, ray, length, medium, path.throughput, samples.choice, samples.point)?;
    let p = ray.origin + ray.direction * point.distance;
    let mut light = light_sampling::sample_direction(ctx, &point.light, p, samples.light)?;
    // Rays that hit the light assume the probability of choosing it at their origin, whatever it is for a segment.
    if light.pdf > 0.0 {
        light.pdf *= light_sampling::light_pmf(ctx.scene, point.light.index, p, None) / point.light.pmf;
    }
    let phase = phase_function(medium.anisotropy(), ray.direction.dot(light.direction));
    let remaining = (-medium.extinction() * point.distance).exp();
    let radiance = path.throughput * medium.scattering * remaining * (phase / point.pdf) * light.irradiance;
    (radiance.max_element() > 0.0).then(|| ShadowTest {
        path_length: LENGTH_IN_MEDIUM,
        ..ShadowTest::new(ctx, path, p, &light, (radiance, phase))
    })
}

/// Samples the next ray of a path at a scattering event in a medium. `None` ends the path.
pub(super) fn scatter(
    ctx: &TraceContext,
    path: &mut Path,
    surface_index: u32,
    direction: [f32; 2],
    roulette: f32,
) -> Option<()> {
    let anisotropy = path.medium.with_fog(&ctx.scene.media.fog).anisotropy();
    let incoming = path.ray.direction;
    let direction = sample_phase(anisotropy, incoming, direction);
    if !path.survives(surface_index, roulette) {
        return None;
    }
    path.previous_vertex = path.ray.origin;
    path.previous_normal = None;
    path.length = LENGTH_IN_MEDIUM;
    path.ray.direction = direction;
    path.scatter_pdf = phase_function(anisotropy, incoming.dot(direction));
    path.lights_are_counted = false;
    path.met_photons = false;
    Some(())
}
