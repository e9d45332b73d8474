//! The estimator: unidirectional path tracing with next-event estimation (Kajiya 1986; Carvalho 2020, chapter 4).
//!
//! A path scatters at most `bounces + 1` times, the first time at the surface the camera sees. At every surface the
//! light of points, suns and emitting surfaces is sampled; the path finds the latter, too, and both ways are weighed by
//! multiple importance sampling. The sky is found by the path itself. Beyond the
//! fourth bounce a path goes on with the probability of its throughput (Russian roulette; Arvo and Kirk 1990). Unbiased
//! but for the march's tolerance, a tenth of a pixel.
//!
//! Here the paths of a tile go side by side, one surface at a time: march all, shade each, march all shadow rays.

use super::camera::{Ray, camera_ray};
use super::diffuse::cosine_direction;
use super::lights;
use super::march::{March, START_OFFSET, direct_tolerance, march, tolerance};
use super::random::{Random, pair};
use crate::frame::{DIRECT, LIGHT_SHIFT, Prepared, SHEET};
use glam::Vec3;
use pathmarch_field::graph::Surface;
use pathmarch_field::number::Vec3 as FieldVec3;
use std::f32::consts::PI;
use wide::f32x8;

struct Path {
    slot: usize,
    random: Random,
    ray: Ray,
    throughput: Vec3,
    length: f32,
    /// Length of the last ray.
    last: f32,
    /// Density of the ray's direction over solid angle.
    scatter_pdf: f32,
}

/// Light on its way from a source that may be hidden.
struct Connection {
    slot: usize,
    radiance: Vec3,
    march: March,
    /// The leaf that the ray must meet, for a light that it may miss.
    target: Option<u32>,
    seed: u32,
}

/// The radiance of one sample of each of these pixels.
pub(crate) fn trace(prepared: &Prepared, pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let frame = &prepared.frame;
    let mut radiance = vec![Vec3::ZERO; pixels.len()];
    let mut paths: Vec<Path> = pixels
        .iter()
        .enumerate()
        .map(|(slot, &(x, y))| {
            let random = Random::of(frame, x, y, sample);
            Path {
                slot,
                random,
                ray: camera_ray(frame, x, y, random),
                throughput: Vec3::ONE,
                length: 0.0,
                last: 0.0,
                scatter_pdf: 0.0,
            }
        })
        .collect();
    for surface_index in 0..=frame.bounces + 1 {
        if paths.is_empty() {
            break;
        }
        let marches: Vec<March> =
            paths.iter().map(|path| March { ray: path.ray, before: path.length, limit: f32::INFINITY }).collect();
        let hits = march(&prepared.field, frame, &marches);
        let mut reached = Vec::with_capacity(paths.len());
        for (mut path, hit) in paths.into_iter().zip(hits) {
            match hit {
                Some(t) => {
                    path.length += t;
                    path.last = t;
                    path.ray.origin += path.ray.direction * t;
                    reached.push(path);
                }
                None => {
                    let mut beyond = Vec3::from(frame.sky);
                    if surface_index == 0 {
                        beyond += lights::sun_radiance(&prepared.lights, path.ray.direction);
                    }
                    radiance[path.slot] += path.throughput * beyond;
                }
            }
        }
        let surfaces = surfaces(prepared, &reached, surface_index);
        let mut connections = Vec::with_capacity(reached.len());
        paths = reached
            .into_iter()
            .zip(surfaces)
            .filter_map(|(path, surface)| {
                shade(prepared, path, &surface, surface_index, &mut radiance, &mut connections)
            })
            .collect();
        let shadows: Vec<March> = connections.iter().map(|connection| connection.march).collect();
        for (connection, blocked) in connections.iter().zip(march(&prepared.field, frame, &shadows)) {
            if shines(prepared, connection, blocked) {
                radiance[connection.slot] += connection.radiance;
            }
        }
    }
    radiance
}

/// Whether light arrives along a shadow ray that met something after `obstacle` metres, or nothing.
fn shines(prepared: &Prepared, connection: &Connection, obstacle: Option<f32>) -> bool {
    let (Some(target), Some(t)) = (connection.target, obstacle) else {
        return connection.target.is_none() && obstacle.is_none();
    };
    let Ray { origin, direction } = connection.march.ray;
    let p = origin + direction * t;
    let met = prepared.field.surface(FieldVec3::new(p.x, p.y, p.z), connection.seed);
    let leaf = &prepared.leaves[met.leaf as usize];
    met.leaf as u32 == target && (leaf.flags & SHEET == 0 || direction.dot(Vec3::from(leaf.facing)) < 0.0)
}

struct Near {
    distance: f32,
    gradient: Vec3,
    leaf: usize,
}

/// The nearest surface at the end of each path, eight at a time.
fn surfaces(prepared: &Prepared, paths: &[Path], surface_index: u32) -> Vec<Near> {
    let mut result = Vec::with_capacity(paths.len());
    for chunk in paths.chunks(8) {
        let lane = |value: &dyn Fn(&Path) -> f32| f32x8::from(std::array::from_fn(|k| chunk.get(k).map_or(0.0, value)));
        let p = FieldVec3::new(
            lane(&|path| path.ray.origin.x),
            lane(&|path| path.ray.origin.y),
            lane(&|path| path.ray.origin.z),
        );
        let seeds = std::array::from_fn(|k| chunk.get(k).map_or(0, |path| path.random.loose(surface_index)));
        let Surface { field, leaf } = prepared.field.surface(p, seeds);
        let (x, y, z) = (field.gradient.x.to_array(), field.gradient.y.to_array(), field.gradient.z.to_array());
        let (distance, leaf) = (field.value.to_array(), leaf.to_array());
        result.extend((0..chunk.len()).map(|k| Near {
            distance: distance[k],
            gradient: Vec3::new(x[k], y[k], z[k]),
            leaf: leaf[k] as usize,
        }));
    }
    result
}

/// What happens at a surface; gives the path's continuation, if it has one.
fn shade(
    prepared: &Prepared,
    path: Path,
    near: &Near,
    surface_index: u32,
    radiance: &mut [Vec3],
    connections: &mut Vec<Connection>,
) -> Option<Path> {
    let frame = &prepared.frame;
    let steepness = near.gradient.length().max(1e-6);
    let outward = near.gradient / steepness;
    let leaf = &prepared.leaves[near.leaf];
    let reached = path.ray.origin;
    let off = direct_tolerance(frame, reached, Vec3::from(leaf.at));
    let is_direct = leaf.flags & DIRECT != 0;
    // On the surface but for rounding, the side is the one the ray comes from; else the field says it.
    let on_surface = is_direct || near.distance.abs() <= off + frame.rounding * path.last;
    let inside = if on_surface { outward.dot(path.ray.direction) > 0.0 } else { near.distance < 0.0 };
    let normal = if inside { -outward } else { outward };
    let material = &prepared.materials[leaf.material as usize];
    if material.emits != 0 {
        if leaf.flags & SHEET == 0 || normal.dot(Vec3::from(leaf.facing)) > 0.0 {
            let light = leaf.flags >> LIGHT_SHIFT;
            let mut weight = 1.0;
            if surface_index > 0 && light > 0 {
                let from = reached - path.ray.direction * path.last;
                let cosine = normal.dot(path.ray.direction).abs();
                let light_pdf = lights::pdf(&prepared.lights[light as usize - 1], from, path.last, cosine);
                weight = lights::weight(path.scatter_pdf, light_pdf);
            }
            radiance[path.slot] += path.throughput * Vec3::from(material.emission) * weight;
        }
        return None;
    }
    if surface_index > frame.bounces {
        return None;
    }
    let p = reached - outward * (near.distance / steepness);
    let start = START_OFFSET * if is_direct { off } else { tolerance(frame, p, path.length) };
    let origin = p + normal * start;
    let pairs = pair::SURFACE + pair::PER_SURFACE * surface_index;
    let [choose_light, go_on] = path.random.pair(pairs + pair::CHOICE);
    let albedo = Vec3::from(material.albedo);
    if let Some(light) = lights::sample(&prepared.lights, origin, choose_light, path.random.pair(pairs + pair::LIGHT)) {
        let cosine = normal.dot(light.direction);
        if cosine > 0.0 {
            let weight = if light.pdf > 0.0 { lights::weight(light.pdf, cosine / PI) } else { 1.0 };
            connections.push(Connection {
                slot: path.slot,
                radiance: path.throughput * albedo * light.irradiance * (weight * cosine / PI),
                target: light.target,
                seed: path.random.loose(surface_index),
                march: March {
                    ray: Ray { origin, direction: light.direction },
                    before: path.length,
                    limit: light.distance,
                },
            });
        }
    }
    let mut throughput = path.throughput * albedo;
    if surface_index > 4 {
        let survival = throughput.max_element().min(1.0);
        if go_on >= survival {
            return None;
        }
        throughput /= survival;
    }
    let direction = cosine_direction(normal, path.random.pair(pairs + pair::SCATTER));
    let scatter_pdf = normal.dot(direction) / PI;
    Some(Path { ray: Ray { origin, direction }, throughput, scatter_pdf, ..path })
}
