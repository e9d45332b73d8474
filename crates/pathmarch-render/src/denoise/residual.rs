//! Residual: what the filter has removed, and which part of it was no noise.
//!
//! **Idea.** The means of the residual over squares are noise that shrinks with the square, plus the bias of the filter.
//! The residuals of the two halves, each against the filtered *other* half, have independent noise, so that the mean
//! of their product is the square of the bias alone. Its share in the mean square of the residual is the gain of a
//! Wiener filter: the part of the residual that is added back. This is done with squares of falling size. The means over
//! the largest squares are added back entirely, so that no light is lost, that of outliers included; the smallest squares
//! are single pixels, so that a picture that has converged stays as it is.
//!
//! **Source.** Residuals added back: "twicing", Tukey 1977, "Exploratory Data Analysis". Gain from independent buffers:
//! after Rousselle, Knaus, Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", section 4, where they
//! choose between filters.

use super::signal::{Signal, Surface, mean_channel};
use glam::Vec3;
use rayon::prelude::*;

/// Half the sides of the squares, pixels.
const RADII: [usize; 5] = [48, 16, 5, 2, 0];
/// Gains up to which nothing is added back, and from which on they count in full: products of noise have a mean of zero,
/// but are not all zero.
const GAIN_RAMP: [f32; 2] = [0.2, 0.5];
/// Half the side of the square that a gain is estimated in, in radii.
const GAIN_RADII: usize = 5;
/// Least half side of that square, pixels.
const MIN_GAIN_RADIUS: usize = 4;

/// Irradiance of all samples from that of the filtered halves and the residual, which is added to the halves as well.
pub(super) fn restored(signal: &Signal, halves: &mut [Vec<Vec3>; 2]) -> Vec<Vec3> {
    let weight = |(surface, weight): (&Surface, &f32)| weight * mean_channel(surface.albedo);
    let weights: Vec<f32> = signal.surfaces.par_iter().zip(&signal.weights).map(weight).collect();
    let both = halves[0].par_iter().zip(&halves[1]);
    let mut whole: Vec<Vec3> = both.map(|(a, b)| b.lerp(*a, signal.share)).collect();
    let levels = if signal.has_two_halves() { &RADII[..] } else { &RADII[..1] };
    for (level, &radius) in levels.iter().enumerate() {
        let mean_residual = |from: &[Vec3], of: &[Vec3]| {
            let residual: Vec<Vec3> = from.par_iter().zip(of).map(|(from, of)| *from - *of).collect();
            if radius == 0 { residual } else { signal.grid.box_means(&residual, &weights, radius) }
        };
        let mut addition = mean_residual(&signal.whole, &whole);
        if level > 0 {
            let residuals =
                [mean_residual(&signal.halves[0], &halves[1]), mean_residual(&signal.halves[1], &halves[0])];
            let gains = gains(signal, &weights, radius, &addition, &residuals);
            addition.par_iter_mut().zip(gains).for_each(|(addition, gain)| *addition *= gain);
        }
        for values in halves.iter_mut().chain([&mut whole]) {
            values.par_iter_mut().zip(&addition).for_each(|(value, addition)| *value += *addition);
        }
    }
    whole
}

/// Share of bias in the residual, 0 to 1, from the residuals of both halves.
fn gains(signal: &Signal, weights: &[f32], radius: usize, residual: &[Vec3], halves: &[Vec<Vec3>; 2]) -> Vec<f32> {
    let square = (GAIN_RADII * radius).max(MIN_GAIN_RADIUS);
    let products: Vec<f32> = halves[0].par_iter().zip(&halves[1]).map(|(a, b)| mean_channel(*a * *b)).collect();
    let squares: Vec<f32> = residual.par_iter().map(|residual| mean_channel(*residual * *residual)).collect();
    let products = signal.grid.box_means(&products, weights, square);
    let squares = signal.grid.box_means(&squares, weights, square);
    let gain = |(product, square): (f32, f32)| {
        let gain = product / square.max(f32::MIN_POSITIVE);
        let trust = (gain - GAIN_RAMP[0]) / (GAIN_RAMP[1] - GAIN_RAMP[0]);
        // Clamping keeps NaN, the maximum removes it.
        (gain.clamp(0.0, 1.0) * trust.clamp(0.0, 1.0)).max(0.0)
    };
    products.into_par_iter().zip(squares).map(gain).collect()
}
