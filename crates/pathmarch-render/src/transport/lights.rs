//! Lights without a surface: points and the sun, sampled at every hit (next-event estimation; Kajiya 1986, "The
//! Rendering Equation"). One light is chosen for each hit through an alias table (Walker 1977; Vose 1991), with a
//! probability after its irradiance at the middle of the scene, so that many lights cost what one does.

use super::diffuse::basis;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use pathmarch_scene::Light;
use std::f32::consts::{PI, TAU};

/// A light as both backends read it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct LightRecord {
    /// A point's position, or the unit direction towards the sun.
    place: [f32; 3],
    /// 1 - cosine of the sun's angular radius, 0 for parallel light; -1 marks a point.
    one_minus_cosine: f32,
    /// A point's intensity, or the sun's irradiance on a surface facing it.
    power: [f32; 3],
    /// Probability of being chosen.
    probability: f32,
    /// The alias table: below this share of its cell the cell is this light, above it is the alias.
    threshold: f32,
    alias: u32,
    padding: [u32; 2],
}

/// Light that arrives at a point if nothing is in its way.
pub(crate) struct LightSample {
    /// Unit vector towards the light.
    pub(crate) direction: Vec3,
    /// Metres to it; infinite for the sun.
    pub(crate) distance: f32,
    /// Irradiance on a surface facing this direction, divided by the probability of the sample.
    pub(crate) irradiance: Vec3,
}

const POINT: f32 = -1.0;

/// 1 - cos(angle/2) of an apparent diameter in degrees, without cancellation.
fn one_minus_cosine(diameter_degrees: f32) -> f32 {
    let half = 0.25 * diameter_degrees.to_radians();
    2.0 * half.sin() * half.sin()
}

/// The records of a scene's lights; `centre` and `radius` say where the scene is.
pub(crate) fn records(lights: &[Light], centre: Vec3, radius: f32) -> Vec<LightRecord> {
    let mut records = Vec::new();
    let mut weights = Vec::new();
    for light in lights {
        let (place, one_minus_cosine, power, weight) = match light {
            Light::Point { at, intensity } => {
                let distance = Vec3::from(*at).distance(centre).max(radius).max(1e-6);
                (*at, POINT, *intensity, luminance(*intensity) / (distance * distance))
            }
            Light::Sun { direction, irradiance, angle } => {
                let direction = Vec3::from(*direction).normalize_or(Vec3::Y);
                (direction.into(), one_minus_cosine(*angle), *irradiance, luminance(*irradiance))
            }
        };
        if weight > 0.0 {
            weights.push(weight);
            records.push(LightRecord {
                place,
                one_minus_cosine,
                power,
                probability: 1.0,
                threshold: 1.0,
                alias: 0,
                padding: [0; 2],
            });
        }
    }
    build_alias_table(&mut records, &weights);
    records
}

fn luminance([r, g, b]: [f32; 3]) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Vose's method: cells of less than the mean are filled up by cells of more.
fn build_alias_table(records: &mut [LightRecord], weights: &[f32]) {
    let total: f64 = weights.iter().map(|&w| f64::from(w)).sum();
    let count = records.len() as f64;
    let mut shares: Vec<f64> = weights.iter().map(|&w| f64::from(w) / total * count).collect();
    for (record, share) in records.iter_mut().zip(&shares) {
        record.probability = (share / count) as f32;
    }
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..shares.len()).partition(|&k| shares[k] < 1.0);
    while let (Some(&low), Some(&high)) = (small.last(), large.last()) {
        small.pop();
        records[low].threshold = shares[low] as f32;
        records[low].alias = high as u32;
        shares[high] -= 1.0 - shares[low];
        if shares[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
    for rest in small.into_iter().chain(large) {
        records[rest].threshold = 1.0;
    }
}

/// Chooses a light with `choice` and a point on it with `position`, as seen from `p`.
pub(crate) fn sample(records: &[LightRecord], p: Vec3, choice: f32, position: [f32; 2]) -> Option<LightSample> {
    let cell = choice * records.len() as f32;
    let mut index = (cell as usize).min(records.len().checked_sub(1)?);
    if cell - index as f32 >= records[index].threshold {
        index = records[index].alias as usize;
    }
    let light = &records[index];
    let power = Vec3::from(light.power) / light.probability;
    if light.one_minus_cosine == POINT {
        let offset = Vec3::from(light.place) - p;
        let square = offset.length_squared();
        let distance = square.sqrt();
        return Some(LightSample { direction: offset / distance, distance, irradiance: power / square });
    }
    let towards = Vec3::from(light.place);
    // Uniform over the disc's solid angle: u = 0 is the middle.
    let below = light.one_minus_cosine * position[0];
    let sine = (below * (2.0 - below)).max(0.0).sqrt();
    let (s, c) = (TAU * position[1]).sin_cos();
    let (tangent, bitangent) = basis(towards);
    let direction = (tangent * (sine * c) + bitangent * (sine * s) + towards * (1.0 - below)).normalize();
    // Radiance times the solid angle: the irradiance over the mean cosine of the disc's directions.
    let irradiance = power * (2.0 / (2.0 - light.one_minus_cosine));
    Some(LightSample { direction, distance: f32::INFINITY, irradiance })
}

/// Radiance of the suns' discs in a direction, for rays that see them.
pub(crate) fn sun_radiance(records: &[LightRecord], direction: Vec3) -> Vec3 {
    let mut radiance = Vec3::ZERO;
    for light in records.iter().filter(|light| light.one_minus_cosine > 0.0) {
        // |a - b|²/2 = 1 - cosine of the angle between unit vectors, without cancellation.
        if 0.5 * (direction - Vec3::from(light.place)).length_squared() < light.one_minus_cosine {
            // Irradiance / (π sin²) of the disc facing a surface: sin² = x(2 - x).
            let x = light.one_minus_cosine;
            radiance += Vec3::from(light.power) / (PI * x * (2.0 - x));
        }
    }
    radiance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_chosen_by_their_power() {
        let lights: Vec<Light> = [1.0, 2.0, 5.0, 0.0, 12.0]
            .iter()
            .map(|&i| Light::Point { at: [0.0, 10.0, 0.0], intensity: [i; 3] })
            .collect();
        let records = records(&lights, Vec3::ZERO, 1.0);
        assert_eq!(records.len(), 4, "a light without power is left out");
        let mut counts = [0.0f32; 4];
        let n = 20_000;
        for k in 0..n {
            let sample = sample(&records, Vec3::ZERO, (k as f32 + 0.5) / n as f32, [0.5; 2]).expect("there are lights");
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
        let records =
            records(&[Light::Sun { direction: [0.0, 1.0, 0.0], irradiance: [3.0; 3], angle: 10.0 }], Vec3::ZERO, 1.0);
        // Cosine-distributed directions: the mean of π L estimates the irradiance.
        let n = 400_000;
        let mut sum = 0.0;
        for k in 0..n {
            let u = super::super::random::Random::new(0, 0, k, 1).pair(0);
            sum += PI * sun_radiance(&records, super::super::diffuse::cosine_direction(Vec3::Y, u)).x / n as f32;
        }
        assert!((sum - 3.0).abs() < 0.05, "{sum}");
    }
}
