//! Lights, sampled at every hit (next-event estimation; Kajiya 1986, "The Rendering Equation"): points, suns, every
//! object that emits, and the sky where it is a picture.
//!
//! One light is chosen for each hit through an alias table, with a probability after its
//! irradiance at the middle of the scene, so that the choice among many costs what one does. A sphere is sampled uniformly in the
//! cone it fills (Shirley, Wang and Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting Calculations"), a
//! rectangle, a disc and the visible faces of a box by area; any other shape by the cone of its bounding sphere, where the
//! ray then meets it or not. The same lights are found by scattered rays; both are weighed by the power heuristic (Veach
//! and Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering").

use super::alias;
use super::basis::basis;
use super::sky::{EnvironmentSample, Sky};
use crate::frame::Prepared;
use crate::settings::LightSearch;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pathmarch_field::{Emitter, Field};
use pathmarch_scene::{Light, Scene};
use std::f32::consts::{PI, TAU};

/// A light as both backends read it; the layout is that of `Light` in `lights.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LightRecord {
    /// Middle of the light, or the unit direction towards the sun.
    pub(super) place: [f32; 3],
    /// One of the constants below.
    pub(super) kind: u32,
    /// A point's intensity, the sun's irradiance on a surface facing it, or an object's radiance.
    pub(super) power: [f32; 3],
    /// Probability of being chosen.
    pub(super) probability: f32,
    /// The alias table: below this share of its cell the cell is this light, above it is the alias.
    threshold: f32,
    alias: u32,
    /// The leaf of the field that emits.
    pub(super) leaf: u32,
    /// 1 - cosine of the sun's angular radius; radius of a sphere, a disc or the bounding sphere.
    pub(super) extent: f32,
    /// Half edges along the local axes; of a sheet, y is the unit vector it faces.
    pub(super) x: [f32; 3],
    /// Sharpness of shadows from near misses; 0 for shadows as they are.
    pub(crate) penumbra: f32,
    pub(super) y: [f32; 3],
    /// Of a rectangle or a disc.
    area: f32,
    pub(super) z: [f32; 3],
    /// One over the probability.
    rarity: f32,
}

impl LightRecord {
    /// The leaf of the field that emits, for a light that is one.
    pub(crate) fn emitting_leaf(&self) -> Option<u32> {
        (self.kind > SUN && self.kind != ENVIRONMENT).then_some(self.leaf)
    }

    /// Its kind, the index into [`KIND_NAMES`].
    pub(crate) fn kind(&self) -> u32 {
        self.kind
    }

    /// Whether it is a sun.
    pub(crate) fn is_sun(&self) -> bool {
        self.kind == SUN
    }
}

pub(super) const POINT: u32 = 0;
pub(super) const SUN: u32 = 1;
pub(super) const SPHERE: u32 = 2;
pub(super) const RECT: u32 = 3;
pub(super) const DISC: u32 = 4;
pub(super) const BOX: u32 = 5;
/// Somewhere in a bounding sphere.
pub(super) const BOUNDED: u32 = 6;
/// The sky's picture.
pub(super) const ENVIRONMENT: u32 = 7;

/// The names of the kinds in the constants of the kernel, in their order.
pub(crate) const KIND_NAMES: [&str; 8] = ["POINT", "SUN", "SPHERE", "RECT", "DISC", "BOX", "BOUNDED", "ENVIRONMENT"];

/// Light that arrives at a point if nothing is in its way.
pub(crate) struct LightSample {
    /// Unit vector towards the light.
    pub(crate) direction: Vec3,
    /// Metres up to which nothing may be in the way; infinite for the sun and for [`target`](Self::target).
    pub(crate) distance: f32,
    /// Irradiance on a surface facing this direction, divided by the probability of the sample.
    pub(crate) irradiance: Vec3,
    /// Density of the sample over solid angle; zero for lights that no ray finds.
    pub(crate) pdf: f32,
    /// The leaf that the ray must meet, for a light that it may miss.
    pub(crate) target: Option<u32>,
    /// Sharpness of shadows from near misses; 0 for shadows as they are.
    pub(crate) penumbra: f32,
    /// How much the sample counts where paths find the light, too.
    pub(crate) weight: f32,
}

/// 1 - cos(angle/2) of an apparent diameter in degrees, without cancellation.
fn one_minus_cosine(diameter_degrees: f32) -> f32 {
    let half = 0.25 * diameter_degrees.to_radians();
    2.0 * half.sin() * half.sin()
}

/// Luminance of linear Rec. 709.
pub(crate) fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The records of a scene's lights, of which the sky learns its probability; `centre` and `radius` say where the scene is.
pub(crate) fn records(scene: &Scene, sky: &mut Sky, centre: Vec3, radius: f32) -> Vec<LightRecord> {
    let mut records = Vec::new();
    let mut weights = Vec::new();
    let falloff = |place: Vec3| place.distance_squared(centre).max(radius * radius).max(1e-12);
    for light in &scene.lights {
        let record = match *light {
            Light::Point { at, intensity, penumbra } => {
                weights.push(luminance(intensity) / falloff(Vec3::from(at)));
                let penumbra = penumbra.unwrap_or(0.0);
                LightRecord { place: at, kind: POINT, power: intensity, penumbra, ..LightRecord::zeroed() }
            }
            Light::Sun { direction, irradiance, angle, penumbra } => {
                weights.push(luminance(irradiance));
                let place = Vec3::from(direction).normalize_or(Vec3::Y).into();
                // Near misses stand for the disc's size.
                let extent = if penumbra.is_some() { 0.0 } else { one_minus_cosine(angle) };
                let penumbra = penumbra.unwrap_or(0.0);
                LightRecord { place, kind: SUN, power: irradiance, extent, penumbra, ..LightRecord::zeroed() }
            }
        };
        records.push(record);
    }
    for leaf in 0..scene.field.leaves().len() {
        let material = &scene.materials[scene.field.leaves()[leaf].tag as usize];
        if material.emits()
            && let Some((record, area)) = surface_record(&scene.field, leaf, material.emission())
        {
            records.push(record);
            weights.push(luminance(record.power) * area / falloff(Vec3::from(record.place)));
        }
    }
    if sky.sampled_power() > 0.0 {
        records.push(LightRecord { kind: ENVIRONMENT, ..LightRecord::zeroed() });
        weights.push(sky.sampled_power());
    }
    let mut weighed: Vec<_> = records.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0).collect();
    // Suns come first: rays that leave the scene look for them.
    weighed.sort_by_key(|(record, _)| !record.is_sun());
    let weights: Vec<f64> = weighed.iter().map(|(_, weight)| f64::from(*weight)).collect();
    let total: f64 = weights.iter().sum();
    let cells = alias::table(&weights).into_iter();
    let records = weighed.into_iter().zip(cells).map(|((record, weight), (threshold, alias))| LightRecord {
        probability: (f64::from(weight) / total) as f32,
        rarity: (total / f64::from(weight)) as f32,
        threshold,
        alias,
        ..record
    });
    let records: Vec<_> = records.collect();
    if let Some(record) = records.iter().find(|record| record.kind == ENVIRONMENT) {
        sky.set_probability(record.probability);
    }
    records
}

/// The record of a leaf that emits, and the area it shows to a side; `None` where it has no end.
fn surface_record(field: &Field, index: usize, radiance: [f32; 3]) -> Option<(LightRecord, f32)> {
    let leaf = &field.leaves()[index];
    let [x, y, z] = leaf.pose.axes.map(|axis| Vec3::from(axis) * (0.5 * leaf.pose.scale));
    // What is combined with other shapes may lack parts of its surface.
    let whole = field.is_analytic_object(index);
    let form = if whole { leaf.shape.emitter(&leaf.params) } else { Emitter::Bounded };
    let facing = Vec3::from(leaf.pose.axes[1]);
    let none = Vec3::ZERO;
    let (kind, place, extent, [x, y, z], area) = match form {
        Emitter::Sphere(radius) => {
            let radius = radius * leaf.pose.scale;
            (SPHERE, Vec3::from(leaf.pose.at), radius, [none; 3], PI * radius * radius)
        }
        Emitter::Rect([a, b]) => {
            let (x, z) = (x * a, z * b);
            (RECT, Vec3::from(leaf.pose.at), 0.0, [x, facing, z], 4.0 * x.length() * z.length())
        }
        Emitter::Disc(radius) => {
            let axes = [Vec3::from(leaf.pose.axes[0]), facing, Vec3::from(leaf.pose.axes[2])];
            let radius = radius * leaf.pose.scale;
            (DISC, Vec3::from(leaf.pose.at), radius, axes, PI * radius * radius)
        }
        Emitter::Box([a, b, c]) => {
            let (x, y, z) = (x * a, y * b, z * c);
            let (a, b, c) = (x.length(), y.length(), z.length());
            (BOX, Vec3::from(leaf.pose.at), 0.0, [x, y, z], 2.0 * (a * b + b * c + c * a))
        }
        Emitter::Bounded => {
            let bounds = field.leaf_bounds(index);
            if !bounds.is_finite() {
                return None;
            }
            let (min, max) = (Vec3::from(bounds.min), Vec3::from(bounds.max));
            // What blends carry beyond this sphere is met by the path alone.
            let radius = 0.5 * (max - min).length() * 1.001;
            (BOUNDED, (min + max) * 0.5, radius, [none; 3], PI * radius * radius)
        }
    };
    let record = LightRecord {
        place: place.into(),
        kind,
        power: radiance,
        leaf: index as u32,
        extent,
        area: if matches!(kind, RECT | DISC) { area } else { 0.0 },
        x: x.into(),
        y: y.into(),
        z: z.into(),
        ..LightRecord::zeroed()
    };
    Some((record, area))
}

/// Chooses a light with `choice` and a point on it with `position`, as seen from `p`.
pub(crate) fn sample(prepared: &Prepared, p: Vec3, choice: f32, position: [f32; 2]) -> Option<LightSample> {
    let records = &prepared.lights;
    let cell = choice * records.len() as f32;
    let mut index = (cell as usize).min(records.len().checked_sub(1)?);
    if cell - index as f32 >= records[index].threshold {
        index = records[index].alias as usize;
    }
    let light = &records[index];
    let place = Vec3::from(light.place);
    let power = Vec3::from(light.power) * light.rarity;
    let sample = |direction, distance, irradiance, pdf, target| {
        let pdf = pdf * light.probability;
        Some(LightSample { direction, distance, irradiance, pdf, target, penumbra: light.penumbra, weight: 1.0 })
    };
    match light.kind {
        POINT => {
            let offset = place - p;
            let distance = offset.length();
            let inverse = 1.0 / distance;
            sample(offset * inverse, distance, power * (inverse * inverse), 0.0, None)
        }
        SUN => {
            let direction = cone_direction(place, light.extent, position);
            // Radiance times the solid angle: the irradiance over the mean cosine of the disc's directions.
            let pdf = if light.extent > 0.0 { 1.0 / (TAU * light.extent) } else { 0.0 };
            sample(direction, f32::INFINITY, power * (2.0 / (2.0 - light.extent)), pdf, None)
        }
        ENVIRONMENT => {
            let EnvironmentSample { direction, radiance, pdf } = prepared.sky.sample(position)?;
            // The density holds the choice of the light already.
            sample(direction, f32::INFINITY, radiance / pdf, pdf / light.probability, None)
        }
        SPHERE | BOUNDED => {
            let offset = place - p;
            let open = cone_of_sphere(offset.length_squared(), light.extent);
            let direction = cone_direction(offset.normalize_or(Vec3::Y), open, position);
            let pdf = 1.0 / (TAU * open);
            let (distance, target) = if light.kind == BOUNDED {
                (f32::INFINITY, Some(light.leaf))
            } else {
                (sphere_entry(offset, direction, light.extent), None)
            };
            sample(direction, distance * SHORT_OF_LIGHT, power * (TAU * open), pdf, target)
        }
        _ => {
            let (point, normal, area) = point_on(light, p, position);
            let offset = point - p;
            let square = offset.length_squared();
            let distance = square.sqrt();
            let direction = offset * (1.0 / distance);
            let cosine = if light.kind == BOX { normal.dot(direction).abs() } else { -normal.dot(direction) };
            if cosine <= 0.0 {
                return None;
            }
            let solid_angle = area * cosine / square;
            sample(direction, distance * SHORT_OF_LIGHT, power * solid_angle, 1.0 / solid_angle, None)
        }
    }
}

/// A shadow ray ends this share of the way to a light's surface, so as not to meet the light itself.
const SHORT_OF_LIGHT: f32 = 0.9999;

/// 1 - cosine of the half angle of the cone that a sphere fills from a point at this squared distance from its middle; 2,
/// all directions, from within.
fn cone_of_sphere(square: f32, radius: f32) -> f32 {
    let sine_square = radius * radius / square.max(1e-30);
    if sine_square >= 1.0 { 2.0 } else { sine_square / (1.0 + (1.0 - sine_square).sqrt()) }
}

/// Uniform in the cone about `axis` that is this open, 1 - cosine of its half angle.
fn cone_direction(axis: Vec3, open: f32, position: [f32; 2]) -> Vec3 {
    let below = open * position[0];
    let sine = (below * (2.0 - below)).max(0.0).sqrt();
    let (s, c) = (TAU * position[1]).sin_cos();
    (basis(axis) * Vec3::new(sine * c, sine * s, 1.0 - below)).normalize()
}

/// Metres to where a ray that meets it meets a sphere whose middle is at `offset`.
fn sphere_entry(offset: Vec3, direction: Vec3, radius: f32) -> f32 {
    let along = offset.dot(direction);
    let across = offset - direction * along;
    let half_chord = (radius * radius - across.length_squared()).max(0.0).sqrt();
    if along > half_chord { along - half_chord } else { along + half_chord }
}

/// A uniform point on the part of a light that may be seen from `p`, its normal, and that part's area.
fn point_on(light: &LightRecord, p: Vec3, [u, v]: [f32; 2]) -> (Vec3, Vec3, f32) {
    let place = Vec3::from(light.place);
    let [x, y, z] = [light.x, light.y, light.z].map(Vec3::from);
    match light.kind {
        RECT => {
            let point = place + x * (2.0 * u - 1.0) + z * (2.0 * v - 1.0);
            (point, y, light.area)
        }
        DISC => {
            let radius = light.extent * u.sqrt();
            let (s, c) = (TAU * v).sin_cos();
            (place + x * (radius * c) + z * (radius * s), y, light.area)
        }
        _ => {
            let (areas, total) = box_areas(light, p);
            let offset = p - place;
            let mut u = u * (areas[0] + areas[1] + areas[2]);
            let k = if u < areas[0] {
                0
            } else if u < areas[0] + areas[1] {
                1
            } else {
                2
            };
            u = ((u - areas[..k].iter().sum::<f32>()) / areas[k].max(1e-30)).clamp(0.0, 1.0);
            let axes = [x, y, z];
            let (axis, a, b) = (axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]);
            let along = offset.dot(axis) / axis.length_squared();
            // From within, either side; from without, the side that is seen.
            let mut side = if along < 0.0 { -1.0 } else { 1.0 };
            if along.abs() < 1.0 {
                side = if u < 0.5 { -1.0 } else { 1.0 };
                u = (2.0 * u).fract();
            }
            (place + axis * side + a * (2.0 * u - 1.0) + b * (2.0 * v - 1.0), axis.normalize() * side, total)
        }
    }
}

/// Area of a face of a box across each axis, zero where none is seen from `p`, and of all that are seen.
fn box_areas(light: &LightRecord, p: Vec3) -> ([f32; 3], f32) {
    let [x, y, z] = [light.x, light.y, light.z].map(Vec3::from);
    let offset = p - Vec3::from(light.place);
    let areas = [4.0 * y.length() * z.length(), 4.0 * z.length() * x.length(), 4.0 * x.length() * y.length()];
    let seen = [x, y, z].map(|axis| offset.dot(axis).abs() > axis.length_squared());
    if !seen.contains(&true) {
        return (areas, 2.0 * (areas[0] + areas[1] + areas[2]));
    }
    let areas: [f32; 3] = std::array::from_fn(|k| if seen[k] { areas[k] } else { 0.0 });
    (areas, areas[0] + areas[1] + areas[2])
}

/// Density over solid angle, the choice of the light included, with which [`sample`] gives the direction from `p` in
/// which a ray met the light at `reached`, at this cosine to its normal.
pub(crate) fn pdf(light: &LightRecord, p: Vec3, reached: Vec3, cosine: f32) -> f32 {
    let t = p.distance(reached);
    let area = match light.kind {
        SPHERE | BOUNDED => {
            let offset = Vec3::from(light.place) - p;
            let open = cone_of_sphere(offset.length_squared(), light.extent);
            // A blend may carry the light's material beyond its sphere.
            let outside = light.kind == BOUNDED && (reached - p).dot(offset) < (1.0 - open) * t * offset.length();
            return if outside { 0.0 } else { light.probability / (TAU * open) };
        }
        RECT | DISC => light.area,
        BOX => box_areas(light, p).1,
        _ => return 0.0,
    };
    light.probability * t * t / (area * cosine.max(1e-6))
}

/// The power heuristic: how much a sample of density `a` counts where another strategy has density `b`.
fn heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / a.max(1e-30);
    1.0 / (1.0 + ratio * ratio)
}

/// Weight of light that a ray of density `scatter_pdf` met, where lights are sampled with `light_pdf`; all of it counts
/// where the ray was of a single direction or no light was sampled.
pub(crate) fn met_weight(search: LightSearch, scatter_pdf: f32, light_pdf: f32) -> f32 {
    match search {
        _ if scatter_pdf <= 0.0 => 1.0,
        LightSearch::Both => heuristic(scatter_pdf, light_pdf),
        LightSearch::Sampled => 0.0,
        LightSearch::Met => 1.0,
    }
}

/// Weight of a light sampled with density `light_pdf`, where rays are of density `scatter_pdf`; all of it counts where no
/// ray meets the light.
pub(crate) fn sampled_weight(search: LightSearch, light_pdf: f32, scatter_pdf: f32) -> f32 {
    match search {
        _ if light_pdf <= 0.0 => 1.0,
        LightSearch::Both => heuristic(light_pdf, scatter_pdf),
        LightSearch::Sampled => 1.0,
        LightSearch::Met => 0.0,
    }
}

/// Radiance of the suns' discs in the direction of a ray of this density, weighed.
pub(crate) fn suns_found(prepared: &Prepared, direction: Vec3, scatter_pdf: f32) -> Vec3 {
    let mut radiance = Vec3::ZERO;
    for light in &prepared.lights[..prepared.frame.sun_count as usize] {
        let x = light.extent;
        // |a - b|²/2 = 1 - cosine of the angle between unit vectors, without cancellation.
        if 0.5 * (direction - Vec3::from(light.place)).length_squared() < x {
            let weight = met_weight(prepared.features.light_search, scatter_pdf, light.probability / (TAU * x));
            // Irradiance / (π sin²) of the disc facing a surface: sin² = x(2 - x).
            radiance += Vec3::from(light.power) * (weight / (PI * x * (2.0 - x)));
        }
    }
    radiance
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    fn prepared(lights: &str) -> Prepared {
        let text = format!("pathmarch 1\ncamera {{ position 0 0 4; target 0 0 0 }}\n{lights}");
        let scene = Scene::parse("test.kdl", &text).expect("a valid scene");
        Prepared::new(&scene, &crate::Settings::of(&scene))
    }

    /// Every kind of surface that emits, seen from near, far, aside and within.
    #[test]
    fn a_lights_density_is_the_one_it_is_sampled_with() {
        let shapes = ["sphere 0.5", "rect 1 0.6", "disc 0.4", "box 0.5 0.8 0.3", "torus 0.4 0.1"];
        for shape in shapes {
            let scene = prepared(&format!(
                "material \"lamp\" {{ emit 1 }}\nobject \"lamp\" material=\"lamp\" {{ {shape} {{ rotate 20 30 40; scale 1.3; at 0.2 0.1 0 }} }}"
            ));
            let [light] = scene.lights.as_slice() else { panic!("one light") };
            for p in [Vec3::new(0.0, 2.0, 0.3), Vec3::new(-1.0, 0.4, 0.9), Vec3::new(20.0, 30.0, 1.0)] {
                let mut weight = 0.0;
                let n = 4000;
                for k in 0..n {
                    let u = Random::new(0, 0, k, 1).pair(0);
                    let Some(sample) = sample(&scene, p, 0.5, u) else { continue };
                    let direction =
                        pathmarch_field::number::Vec3::new(sample.direction.x, sample.direction.y, sample.direction.z);
                    let origin = pathmarch_field::number::Vec3::new(p.x, p.y, p.z);
                    let (t, _) = scene.field.analytic_hit(origin, direction);
                    if sample.target.is_none() {
                        assert!(
                            (t * SHORT_OF_LIGHT / sample.distance - 1.0).abs() < 2e-3,
                            "{shape}: {t} {}",
                            sample.distance
                        );
                        let hit = p + sample.direction * t;
                        let surface = scene
                            .field
                            .surface(pathmarch_field::number::Vec3::new(hit.x, hit.y, hit.z), 0)
                            .field
                            .gradient;
                        let normal = Vec3::new(surface.x, surface.y, surface.z).normalize();
                        let cosine = normal.dot(sample.direction).abs();
                        if cosine > 0.05 && light.kind != BOX {
                            let density = pdf(light, p, hit, cosine);
                            assert!((density / sample.pdf - 1.0).abs() < 0.02, "{shape}: {density} {}", sample.pdf);
                        }
                    }
                    weight += 1.0 / (sample.pdf * n as f32);
                }
                // The mean of 1/density is the solid angle, at most all directions.
                assert!(weight > 0.0 && weight < 4.0 * PI, "{shape}: {weight}");
            }
        }
    }

    #[test]
    fn lights_are_chosen_by_their_power() {
        let points = [1.0, 2.0, 5.0, 0.0, 12.0].map(|i| format!("point {{ at 0 10 0; intensity {i} }}\n"));
        let prepared = prepared(&points.concat());
        let records = &prepared.lights;
        assert_eq!(records.len(), 4, "a light without power is left out");
        let mut counts = [0.0f32; 4];
        let n = 20_000;
        for k in 0..n {
            let sample =
                sample(&prepared, Vec3::ZERO, (k as f32 + 0.5) / n as f32, [0.5; 2]).expect("there are lights");
            // Every choice gives the same product of power over probability.
            assert!((sample.irradiance.x * 100.0 - 20.0).abs() < 1e-3);
            let cell = (k as f32 + 0.5) / n as f32 * 4.0;
            let index = cell as usize;
            let chosen =
                if cell - index as f32 >= records[index].threshold { records[index].alias as usize } else { index };
            counts[chosen] += 1.0 / n as f32;
        }
        for (count, expected) in counts.iter().zip([0.05, 0.1, 0.25, 0.6]) {
            assert!((count - expected).abs() < 1e-3, "{counts:?}");
        }
    }

    #[test]
    fn the_suns_disc_integrates_to_its_irradiance() {
        let prepared = prepared("sun { direction 0 1 0; irradiance 3; angle 10 }");
        // Cosine-distributed directions: the mean of π L estimates the irradiance.
        let n = 400_000;
        let mut sum = 0.0;
        for k in 0..n {
            let [u, v] = Random::new(0, 0, k, 1).pair(0);
            let (sine, cosine) = (TAU * v).sin_cos();
            let direction = Vec3::new(u.sqrt() * sine, (1.0 - u).sqrt(), u.sqrt() * cosine);
            sum += PI * suns_found(&prepared, direction, 0.0).x / n as f32;
        }
        assert!((sum - 3.0).abs() < 0.05, "{sum}");
    }
}
