//! Probes: a few paths of a picture that tell how to render it. They count operations and measure no time, so that the same
//! picture is always rendered in the same way.

use super::path;
use crate::metrics::RELMSE_EPSILON;
use crate::ray_stats::RayCounters;
use crate::sampling::sobol::hash;
use crate::scene::{FrameUniforms, TraceContext};
use glam::DVec3;
use pathmarch_scene::Sampler;

/// Largest variance of a pixel of a probe, relative to the square of its own mean, so that none dominates.
pub(super) const MAX_VARIANCE: f64 = 10.0;

/// Cost of an evaluation of the field relative to a ray and its shading.
const EVALUATION_COST: f64 = 0.25;

/// Frame of a probe: other random numbers than those of the picture, and independent ones.
pub(super) fn frame_of(picture: &FrameUniforms) -> FrameUniforms {
    FrameUniforms { seed: hash(picture.seed), sampler: Sampler::Independent as u32, ..*picture }
}

/// Pixels of a picture, one at random in each cell of a grid of this many columns and rows.
pub(super) fn pixels(picture: &FrameUniforms, [columns, rows]: [u32; 2]) -> Vec<(u32, u32)> {
    let [width, height] = picture.size();
    let pixel = |k: u32| {
        let jittered = |cell: u32, cells: u32, length: u32, dimension: u32| {
            let within = f64::from(hash(2 * k + dimension)) / f64::from(u32::MAX);
            let place = (f64::from(cell) + within) / f64::from(cells) * f64::from(length);
            (place as u32).min(length - 1)
        };
        (jittered(k % columns, columns, width, 0), jittered(k / columns, rows, height, 1))
    };
    (0..columns * rows).map(pixel).collect()
}

/// Number of paths of a picture.
pub(super) fn path_count(picture: &FrameUniforms, samples: u32) -> f64 {
    picture.size().map(f64::from).iter().product::<f64>() * f64::from(samples)
}

/// Cost of counted rays, in rays.
pub(super) fn cost(counters: &RayCounters) -> f64 {
    let total = counters.total();
    total.rays as f64 + EVALUATION_COST * total.evaluations as f64
}

/// Mean and variance of the samples of a pixel, by channel.
pub(super) struct Noise {
    pub(super) mean: DVec3,
    pub(super) variance: DVec3,
}

/// Noise of one of this number of successive samples of each of these pixels: their mean has the variance over the number. It is
/// that between two seeds, so that the order in the samples of a pixel and its neighbours counts.
pub(super) fn noise(ctx: &TraceContext, pixels: &[(u32, u32)], samples: u32) -> Vec<Noise> {
    let means = [1, 2].map(|seed| {
        let frame = FrameUniforms { seed: hash(ctx.frame.seed ^ seed), ..*ctx.frame };
        let ctx = TraceContext { frame: &frame, ..*ctx };
        let mut sums = vec![DVec3::ZERO; pixels.len()];
        for sample in 0..samples {
            for (sum, value) in sums.iter_mut().zip(path::trace(&ctx, pixels, sample, 1)) {
                *sum += value.as_dvec3();
            }
        }
        sums.into_iter().map(|sum| sum / f64::from(samples)).collect::<Vec<_>>()
    });
    let [a, b] = &means;
    let noise_of_pixel = |(a, b): (&DVec3, &DVec3)| Noise {
        mean: 0.5 * (a + b),
        variance: 0.5 * f64::from(samples) * (a - b) * (a - b),
    };
    a.iter().zip(b).map(noise_of_pixel).collect()
}

/// Variance of pixels relative to the squares of these radiances, as in relMSE, summed; at most `most` for a pixel and channel.
pub(super) fn relative_variance(pixels: &[Noise], radiance: &[DVec3], most: f64) -> f64 {
    let of_pixel = |(noise, radiance): (&Noise, &DVec3)| {
        let relative = noise.variance / (*radiance * *radiance + RELMSE_EPSILON);
        // Ignore values that are not finite.
        relative.to_array().into_iter().filter(|value| value.is_finite()).map(|value| value.min(most)).sum::<f64>()
    };
    pixels.iter().zip(radiance).map(of_pixel).sum()
}

/// Variance of pixels relative to the squares of their own means.
pub(super) fn own_variance(pixels: &[Noise]) -> f64 {
    let own: Vec<DVec3> = pixels.iter().map(|noise| noise.mean).collect();
    relative_variance(pixels, &own, MAX_VARIANCE)
}
