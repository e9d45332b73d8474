//! Composition: radiance of the picture from filtered irradiance.
//!
//! **Idea.** Surfaces are irradiance times albedo. A pixel at the edge of a light source or of the sky has two estimates:
//! its samples, which know their own share of the light, and the prediction of its features, which has less noise of
//! the surface. Each is weighted by the inverse of its variance, from the two halves. At last, each channel is scaled by
//! the small factor that gives the picture the mean of its samples, which is unbiased.

use super::features::Features;
use super::signal::{PixelClass, Signal, mean_channel};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Half the side of the square in which the variances of edges are estimated, pixels.
const VARIANCE_RADIUS: usize = 2;

/// Radiance of a picture, before [`keep_energy`].
pub(super) fn composed(signal: &Signal, features: &Features, irradiance: &[Vec3]) -> Vec<Vec3> {
    let sample_weights = sample_weights(signal, features, irradiance);
    let colour = |(index, irradiance): (usize, &Vec3)| {
        let (surface, samples) = (&signal.surfaces[index], signal.radiance[index]);
        let predicted = surface.emission + surface.albedo * irradiance.max(Vec3::ZERO);
        let colour = match surface.class {
            PixelClass::Surface => predicted,
            PixelClass::Mixed => predicted.lerp(samples, sample_weights[index]),
            PixelClass::Source => samples,
        };
        if colour.is_finite() { colour } else { samples }
    };
    irradiance.par_iter().enumerate().map(colour).collect()
}

/// Scales colours so that each channel has the mean of the samples.
pub(super) fn keep_energy(signal: &Signal, colours: &mut [Vec3]) {
    let scale = energy_scale(&signal.radiance, colours);
    colours.par_iter_mut().for_each(|colour| *colour *= scale);
}

/// Weight of the samples against the prediction, for mixed pixels.
fn sample_weights(signal: &Signal, features: &Features, irradiance: &[Vec3]) -> Vec<f32> {
    let is_mixed = |surface: &super::signal::Surface| f32::from(u8::from(surface.class == PixelClass::Mixed));
    let weights: Vec<f32> = signal.surfaces.par_iter().map(is_mixed).collect();
    let sample_variance = |index: usize| {
        let difference = (signal.halves[0][index] - signal.halves[1][index]) * signal.surfaces[index].albedo;
        signal.share * (1.0 - signal.share) * mean_channel(difference * difference)
    };
    let predicted_variance = |index: usize| {
        let [first, second] = [0, 1].map(|half: usize| &features.halves[half][index]);
        let difference = first.emission - second.emission + (first.albedo - second.albedo) * irradiance[index];
        0.25 * mean_channel(difference * difference) / (features.rays * features.rays) as f32
    };
    let smooth = |variance: &(dyn Fn(usize) -> f32 + Sync)| {
        let values: Vec<f32> = (0..irradiance.len()).into_par_iter().map(variance).collect();
        signal.grid.box_means(&values, &weights, VARIANCE_RADIUS)
    };
    let (of_samples, of_predictions) = (smooth(&sample_variance), smooth(&predicted_variance));
    let weight = |(samples, predictions): (f32, f32)| {
        let total = samples + predictions;
        if total > 0.0 { predictions / total } else { 1.0 }
    };
    of_samples.into_iter().zip(of_predictions).map(weight).collect()
}

/// Factor of each channel that gives colours the mean of the samples; 1 where there is none.
fn energy_scale(samples: &[Vec3], colours: &[Vec3]) -> Vec3 {
    let total = |colours: &[Vec3]| colours.par_iter().map(|colour| colour.as_dvec3()).sum::<DVec3>();
    let (samples, colours) = (total(samples), total(colours));
    Vec3::from_array(std::array::from_fn(|k| match samples[k] / colours[k] {
        scale if scale > 0.0 && scale.is_finite() => scale as f32,
        _ => 1.0,
    }))
}
