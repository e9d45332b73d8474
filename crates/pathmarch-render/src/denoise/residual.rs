//! Residual: what the filter has removed, and which part of it was no noise.
//!
//! **Idea.** The means of the residual over squares are noise that shrinks with the square, plus the bias of the filter.
//! The residuals of the two halves, each against the filtered *other* half, have independent noise, so that the mean
//! of their product is the square of the bias alone. Its share in the mean square of the residual is the gain of a
//! Wiener filter: the part of the residual that is added back. This is done with squares of falling size. The largest
//! squares are added back entirely, so that no light is lost, that of outliers included; the smallest are single pixels,
//! so that a picture that has converged stays as it is.
//!
//! **Source.** Residuals added back: "twicing", Tukey 1977, "Exploratory Data Analysis". Gain from independent buffers:
//! after Rousselle, Knaus, Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", section 4, where they
//! choose between filters.

use super::signal::{Signal, mean_channel};
use glam::Vec3;
use rayon::prelude::*;

/// Half the sides of the squares, pixels.
const RADII: [usize; 5] = [48, 16, 5, 2, 0];
/// Gain up to which nothing is added back: products of noise have a mean of zero, but are not all zero.
const MIN_GAIN: f32 = 0.25;
/// Half the side of the square that a gain is estimated in, in radii.
const GAIN_RADII: usize = 5;
/// Least half side of that square, pixels.
const MIN_GAIN_RADIUS: usize = 4;

/// Irradiance of all samples, from that of the filtered halves and the residual. Gains are estimated if the halves are
/// independent.
pub(super) fn restored(signal: &Signal, mut filtered: [Vec<Vec3>; 2], independent: bool) -> Vec<Vec3> {
    let weights: Vec<f32> =
        signal.surfaces.par_iter().zip(&signal.weights).map(|(surface, weight)| weight * mean_channel(surface.albedo)).collect();
    let both = filtered[0].par_iter().zip(&filtered[1]);
    let mut result: Vec<Vec3> = both.map(|(a, b)| b.lerp(*a, signal.share)).collect();
    for (level, radius) in RADII.into_iter().enumerate() {
        let mean_residual = |from: &[Vec3], of: &[Vec3]| {
            let residual: Vec<Vec3> = from.par_iter().zip(of).map(|(from, of)| *from - *of).collect();
            if radius == 0 { residual } else { signal.grid.box_means(&residual, &weights, radius) }
        };
        let residual = mean_residual(&signal.whole, &result);
        let mut addition = residual;
        if level > 0 && independent {
            let halves =
                [mean_residual(&signal.halves[0], &filtered[1]), mean_residual(&signal.halves[1], &filtered[0])];
            let gains = gains(signal, &weights, radius, &addition, &halves);
            addition.par_iter_mut().zip(gains).for_each(|(addition, gain)| *addition *= gain);
        } else if level > 0 {
            break;
        }
        for values in filtered.iter_mut().chain([&mut result]) {
            values.par_iter_mut().zip(&addition).for_each(|(value, addition)| *value += *addition);
        }
    }
    result
}

/// Share of bias in the residual, 0 to 1, from the residuals of both halves.
fn gains(signal: &Signal, weights: &[f32], radius: usize, residual: &[Vec3], halves: &[Vec<Vec3>; 2]) -> Vec<f32> {
    let square = (GAIN_RADII * radius).max(MIN_GAIN_RADIUS);
    let products: Vec<f32> = halves[0].par_iter().zip(&halves[1]).map(|(a, b)| mean_channel(*a * *b)).collect();
    let squares: Vec<f32> = residual.par_iter().map(|residual| mean_channel(*residual * *residual)).collect();
    let products = signal.grid.box_means(&products, weights, square);
    let squares = signal.grid.box_means(&squares, weights, square);
    let gain = |(product, square): (f32, f32)| {
        let gain = (product / square.max(f32::MIN_POSITIVE) - MIN_GAIN) / (1.0 - MIN_GAIN);
        // NaN becomes 0.
        gain.max(0.0).min(1.0)
    };
    products.into_par_iter().zip(squares).map(gain).collect()
}
