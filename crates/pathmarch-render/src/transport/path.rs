//! The estimator: unidirectional path tracing with next-event estimation (Kajiya 1986; Carvalho 2020, chapter 4).
//!
//! A path scatters at most `bounces + 1` times, the first time at the surface the camera sees. At every surface that
//! scatters in more than single directions a light is sampled: points, suns, emitting surfaces, the environment. The path
//! meets all of these but points and suns without size, too, and both ways are weighed by multiple importance sampling. A constant or gradient
//! sky is found by the path alone. Beyond the fourth bounce a path goes on with the probability of its throughput (Russian
//! roulette; Arvo and Kirk 1990). Unbiased but for the march (its tolerance of a tenth of a pixel, its steps, its end), unless `clamp`,
//! `caustics "fast"` or a `penumbra` is set.
//!
//! Clear solids: a surface that transmits starts the path on its other side. What the medium absorbs is added where a path
//! enters a solid and taken off where it leaves it, so that solids may lie in one another.
//!
//! Here the paths of a tile go side by side, one surface at a time: march all, shade each, march all shadow rays.

use super::basis::basis;
use super::camera::{Ray, camera_ray};
use super::lights;
use super::march::{Hit, March, march, rounding_at, start_offset};
use super::paint::Painted;
use super::random::{Random, pair};
use super::shadow::{self, Connection};
use super::splitting::ray_of;
use crate::frame::{DELTA, DIRECT, EMITS, LIGHT_SHIFT, Prepared, SHEET, TRANSMITS};
use glam::Vec3;
use pathmarch_field::graph::{Batch, Surface};
use pathmarch_field::number::Vec3 as FieldVec3;
use std::iter::repeat_n;
use wide::f32x8;

#[derive(Clone)]
struct Path {
    slot: usize,
    random: Random,
    ray: Ray,
    /// Where the lights of the last surface were seen from.
    reference: Vec3,
    throughput: Vec3,
    length: f32,
    /// Length of the last ray.
    last: f32,
    /// The leaf that it met, if that has a closed form.
    direct: Option<u32>,
    /// Density of the ray's direction over solid angle; 0 for a single direction.
    scatter_pdf: f32,
    /// What the medium that the path is in absorbs, per metre.
    medium: Vec3,
    /// Whether the path went straight through clear glass, as shadow rays do, since it last sampled a light.
    passing: bool,
    /// Square of the refractive index where the path is.
    index_square: f32,
}

/// What a medium leaves of light over a length.
pub(super) fn left_after(medium: Vec3, length: f32) -> Vec3 {
    (-medium * length.min(1e9)).exp()
}

/// The medium beyond a surface that the path passes.
pub(super) fn medium_beyond(medium: Vec3, absorption: Vec3, inside: bool) -> Vec3 {
    (if inside { medium - absorption } else { medium + absorption }).max(Vec3::ZERO)
}

/// A contribution of light after this many bounces, within the limit that is set.
fn limited(prepared: &Prepared, contribution: Vec3, bounces: u32) -> Vec3 {
    if bounces == 0 {
        return contribution;
    }
    contribution * (prepared.frame.clamp / contribution.max_element().max(prepared.frame.clamp))
}

/// The radiance of so many samples from this one on of each of these pixels, those of a pixel in a row; more than one only
/// where they share a ray of the camera.
pub(crate) fn trace(prepared: &Prepared, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
    let frame = &prepared.frame;
    let shared = ray_of(first, prepared.features.splitting);
    let rays = pixels.iter().map(|&(x, y)| {
        let random = Random::of(frame, x, y, shared);
        (camera_ray(frame, x, y, random), random)
    });
    if prepared.features.splitting == 1 {
        return radiance_along(prepared, rays);
    }
    let (paths, mut radiance) = start(prepared, rays);
    let reached = arrive(prepared, paths, 0, &mut radiance);
    let mut radiance: Vec<Vec3> = radiance.iter().flat_map(|&ended| repeat_n(ended, samples as usize)).collect();
    let split = reached.iter().flat_map(|(path, near)| {
        (0..samples).map(|k| {
            let (slot, random) = (path.slot * samples as usize + k as usize, path.random.of_sample(first + k));
            (Path { slot, random, ..path.clone() }, near.clone())
        })
    });
    go_on(prepared, split.collect(), &mut radiance);
    radiance
}

/// The radiance along each of these rays, which start where the camera is or in the same medium.
pub(super) fn radiance_along(prepared: &Prepared, rays: impl Iterator<Item = (Ray, Random)>) -> Vec<Vec3> {
    let (paths, mut radiance) = start(prepared, rays);
    let reached = arrive(prepared, paths, 0, &mut radiance);
    go_on(prepared, reached, &mut radiance);
    radiance
}

/// The paths that begin with these rays, and the radiance of each so far.
fn start(prepared: &Prepared, rays: impl Iterator<Item = (Ray, Random)>) -> (Vec<Path>, Vec<Vec3>) {
    let paths: Vec<Path> = rays
        .enumerate()
        .map(|(slot, (ray, random))| Path {
            slot,
            random,
            ray,
            reference: ray.origin,
            throughput: Vec3::ONE,
            length: 0.0,
            last: 0.0,
            direct: None,
            scatter_pdf: 0.0,
            medium: Vec3::from(prepared.frame.medium),
            passing: false,
            index_square: 1.0,
        })
        .collect();
    let radiance = vec![Vec3::ZERO; paths.len()];
    (paths, radiance)
}

/// Follows paths from the surfaces that they have reached to their ends.
fn go_on(prepared: &Prepared, mut reached: Vec<(Path, Near)>, radiance: &mut [Vec3]) {
    for surface_index in 0.. {
        if reached.is_empty() {
            break;
        }
        let mut connections = Vec::with_capacity(reached.len());
        let drawn = drawn(prepared, &reached, surface_index);
        let paths = reached
            .into_iter()
            .zip(drawn)
            .filter_map(|((path, near), drawn)| {
                shade(prepared, path, &near, &drawn, surface_index, radiance, &mut connections)
            })
            .collect();
        for (slot, arriving) in shadow::arriving(prepared, connections) {
            radiance[slot] += limited(prepared, arriving, surface_index);
        }
        reached = arrive(prepared, paths, surface_index + 1, radiance);
    }
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
fn drawn(prepared: &Prepared, reached: &[(Path, Near)], surface_index: u32) -> impl Iterator<Item = Drawn> + use<> {
    let randoms: Vec<Random> = reached.iter().map(|(path, _)| path.random).collect();
    let of = |number: u32| Random::pairs(&randoms, pair::SURFACE + pair::PER_SURFACE * surface_index + number);
    let lobes = if prepared.features.chooses_lobes { of(pair::LOBE) } else { vec![[0.0; 2]; randoms.len()] };
    let numbers = of(pair::CHOICE).into_iter().zip(of(pair::LIGHT)).zip(of(pair::SCATTER)).zip(lobes);
    numbers.map(|(((choice, light), scatter), [lobe, _])| Drawn { choice, light, scatter, lobe })
}

/// Follows the rays of paths to their next surface, after so many; those that meet none end.
fn arrive(prepared: &Prepared, paths: Vec<Path>, surface_index: u32, radiance: &mut [Vec3]) -> Vec<(Path, Near)> {
    let march_of = |path: &Path| March { ray: path.ray, before: path.length, limit: f32::INFINITY };
    let marches: Vec<March> = paths.iter().map(march_of).collect();
    let hits = march(prepared, &marches);
    let mut reached = Vec::with_capacity(paths.len());
    for (mut path, hit) in paths.into_iter().zip(hits) {
        if prepared.features.absorption {
            path.throughput *= left_after(path.medium, hit.map_or(f32::INFINITY, |hit| hit.t));
        }
        match hit {
            Some(Hit { t, direct }) => {
                path.length += t;
                path.last = t;
                path.direct = direct;
                path.ray.origin += path.ray.direction * t;
                reached.push(path);
            }
            None => {
                let contribution = path.throughput * beyond(prepared, &path);
                // Light that a ray meets fell on the surface before.
                radiance[path.slot] += limited(prepared, contribution, surface_index.saturating_sub(1));
            }
        }
    }
    let surfaces = surfaces(prepared, &reached, surface_index);
    reached.into_iter().zip(surfaces).collect()
}

/// Radiance from beyond the scene, weighed where it is sampled as a light, too.
fn beyond(prepared: &Prepared, path: &Path) -> Vec3 {
    let direction = path.ray.direction;
    if path.passing {
        return prepared.sky.not_sampled(direction);
    }
    prepared.sky.found(prepared.features.light_search, direction, path.scatter_pdf)
        + lights::suns_found(prepared, direction, path.scatter_pdf)
}

#[derive(Clone)]
pub(crate) struct Near {
    pub(crate) distance: f32,
    pub(crate) gradient: Vec3,
    pub(crate) leaf: usize,
}

/// The surface that each path met, eight at a time.
fn surfaces(prepared: &Prepared, paths: &[Path], surface_index: u32) -> Vec<Near> {
    let mut result = Vec::with_capacity(paths.len());
    for chunk in paths.chunks(8) {
        let points = std::array::from_fn(|k| chunk.get(k).map_or(Vec3::ZERO, |path| path.ray.origin));
        let seeds = std::array::from_fn(|k| chunk.get(k).map_or(0, |path| path.random.loose(surface_index)));
        let direct = std::array::from_fn(|k| Hit::met(chunk.get(k).unwrap_or(&chunk[0]).direct));
        let surface = |p| prepared.field.surface_met(p, f32x8::from(direct), &|index| f32x8::choice(seeds, index));
        result.extend(near(points, surface).into_iter().take(chunk.len()));
    }
    result
}

/// What `surface` says of eight points.
pub(crate) fn near(points: [Vec3; 8], surface: impl Fn(FieldVec3<f32x8>) -> Surface<f32x8>) -> [Near; 8] {
    let lane = |value: fn(Vec3) -> f32| f32x8::from(points.map(value));
    let Surface { field, leaf } = surface(FieldVec3::new(lane(|p| p.x), lane(|p| p.y), lane(|p| p.z)));
    let (x, y, z) = (field.gradient.x.to_array(), field.gradient.y.to_array(), field.gradient.z.to_array());
    let (distance, leaf) = (field.value.to_array(), leaf.to_array());
    std::array::from_fn(|k| Near {
        distance: distance[k],
        gradient: Vec3::new(x[k], y[k], z[k]),
        leaf: leaf[k] as usize,
    })
}

/// The normal on the side that a ray which ends here after `length` metres comes from.
pub(crate) fn facing(prepared: &Prepared, near: &Near, outward: Vec3, ray: &Ray, length: f32) -> Vec3 {
    let leaf = &prepared.leaves[near.leaf];
    let off = rounding_at(&prepared.frame, ray.origin, Vec3::from(leaf.at));
    // On the surface but for rounding, the side is the one the ray comes from; else the field says it.
    let on_surface = leaf.flags & DIRECT != 0 || near.distance.abs() <= off + prepared.frame.rounding * length;
    let inside = if on_surface { outward.dot(ray.direction) > 0.0 } else { near.distance < 0.0 };
    if inside { -outward } else { outward }
}

/// What happens at a surface; gives the path's continuation, if it has one.
fn shade(
    prepared: &Prepared,
    path: Path,
    near: &Near,
    drawn: &Drawn,
    surface_index: u32,
    radiance: &mut [Vec3],
    connections: &mut Vec<Connection>,
) -> Option<Path> {
    let frame = &prepared.frame;
    let steepness = near.gradient.length().max(1e-6);
    let outward = near.gradient / steepness;
    let leaf = &prepared.leaves[near.leaf];
    let reached = path.ray.origin;
    let off = rounding_at(frame, reached, Vec3::from(leaf.at));
    let normal = facing(prepared, near, outward, &path.ray, path.last);
    let inside = normal.dot(outward) < 0.0;
    let material = &prepared.materials[leaf.material as usize];
    if material.flags & EMITS != 0 {
        let light = leaf.flags >> LIGHT_SHIFT;
        let seen = leaf.flags & SHEET == 0 || normal.dot(Vec3::from(leaf.facing)) > 0.0;
        // Shadow rays have brought it already.
        let counted = path.passing && light > 0;
        if seen && !counted {
            let mut weight = 1.0;
            if light > 0 {
                let cosine = normal.dot(path.ray.direction).abs();
                let light_pdf = lights::pdf(&prepared.lights[light as usize - 1], path.reference, reached, cosine);
                weight = lights::met_weight(prepared.features.light_search, path.scatter_pdf, light_pdf);
            }
            let contribution = path.throughput * Vec3::from(material.emission) * weight;
            radiance[path.slot] += limited(prepared, contribution, surface_index.saturating_sub(1));
        }
        return None;
    }
    if surface_index > frame.bounces {
        return None;
    }
    let bsdf = prepared.bsdfs[leaf.material as usize]?;
    let p = reached - outward * (near.distance / steepness);
    let painted = Painted::new(prepared, near.leaf, p, outward, path.length);
    let own = painted.as_ref().map(|painted| painted.numbers(&material.numbers));
    let numbers = own.as_ref().unwrap_or(&material.numbers);
    // What light sees; that of the shape says on which side a direction is.
    let shaded = painted.map_or(normal, |painted| painted.normal(outward, normal, -path.ray.direction));
    let crosses = |wi: Vec3, direction: Vec3| prepared.features.bump && (wi.z < 0.0) != (direction.dot(normal) < 0.0);
    let away = normal * start_offset(off, near.distance / steepness);
    let world_from_local = basis(shaded);
    let local_from_world = world_from_local.transpose();
    let back = local_from_world * -path.ray.direction;
    // Where the field is so rough that its normal looks away from the ray, the surface is met from the mirrored direction.
    let wo = back.with_z(back.z.abs().max(1e-5));
    let transmits = material.flags & TRANSMITS != 0;
    let beyond = medium_beyond(path.medium, Vec3::from(material.absorption), inside);
    let [choose_light, go_on] = drawn.choice;
    let mut reference = path.reference;
    if material.flags & DELTA == 0 {
        reference = if transmits { p } else { p + away };
        if let Some(light) = lights::sample(prepared, reference, choose_light, drawn.light) {
            let wi = local_from_world * light.direction;
            let below = wi.z < 0.0;
            if (wi.z > 0.0 || transmits) && !crosses(wi, light.direction) {
                let scattering = (bsdf.eval)(numbers, wo, wi, inside);
                if scattering.value.max_element() > 0.0 {
                    connections.push(Connection {
                        slot: path.slot,
                        radiance: path.throughput * scattering.value * light.irradiance,
                        scatter_pdf: scattering.pdf,
                        ray: Ray { origin: p + if below { -away } else { away }, direction: light.direction },
                        light,
                        before: path.length,
                        medium: if below { beyond } else { path.medium },
                        seed: path.random.loose(surface_index),
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
    let mut throughput = path.throughput * scattered.weight;
    let index_square = path.index_square * scattered.eta * scattered.eta;
    if surface_index > 4 {
        let survival = (throughput.max_element() * index_square).min(1.0);
        if go_on >= survival {
            return None;
        }
        throughput /= survival;
    }
    let below = scattered.wi.z < 0.0;
    let straight = scattered.pdf == 0.0 && below && (path.passing || path.scatter_pdf > 0.0);
    Some(Path {
        ray: Ray { origin: p + if below { -away } else { away }, direction },
        reference,
        throughput,
        scatter_pdf: scattered.pdf,
        medium: if below { beyond } else { path.medium },
        passing: prepared.features.fast_caustics && straight,
        index_square,
        ..path
    })
}
