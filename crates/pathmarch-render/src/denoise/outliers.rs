//! Outliers: fireflies, which would tilt the planes of the regression.
//!
//! **Idea.** A value of one half that is far above both halves around it, and above the other half of its own pixel, is
//! lowered. The mean of the smaller of both halves is a robust level. The energy is not lost: the
//! [residual](super::residual) returns it.
//!
//! **Source.** Comparison of independent buffers: Boughida and Boubekeur 2017, "Bayesian Collaborative Denoising for
//! Monte Carlo Rendering", section 4.2 (there of histograms of neighbours).

use super::signal::{Signal, mean_channel};
use glam::Vec3;
use rayon::prelude::*;

/// Half the side of the square around a pixel, pixels.
const RADIUS: usize = 4;
/// Mean absolute differences of the halves above the level at which a value is an outlier.
const REACH: f32 = 6.0;
/// Largest difference that counts, in units of the smaller half: otherwise outliers would raise their own limit.
const MAX_DIFFERENCE: f32 = 2.0;

/// Irradiance of both halves without outliers.
pub(super) fn limited(signal: &Signal) -> [Vec<Vec3>; 2] {
    let levels =
        [0, 1].map(|half: usize| -> Vec<f32> { signal.halves[half].par_iter().map(|c| mean_channel(*c)).collect() });
    let both = || levels[0].par_iter().zip(&levels[1]);
    let lower: Vec<f32> = both().map(|(a, b)| a.min(*b)).collect();
    let differences: Vec<f32> = both().map(|(a, b)| (a - b).abs().min(MAX_DIFFERENCE * a.min(*b).max(0.0))).collect();
    let mean_level = signal.grid.box_means(&lower, &signal.weights, RADIUS);
    let mean_difference = signal.grid.box_means(&differences, &signal.weights, RADIUS);
    [0, 1].map(|half: usize| {
        let limited = |(index, value): (usize, &Vec3)| {
            let limit = mean_level[index].max(lower[index]) + REACH * mean_difference[index];
            let level = levels[half][index];
            if level > limit && limit > 0.0 { *value * (limit / level) } else { *value }
        };
        signal.halves[half].par_iter().enumerate().map(limited).collect()
    })
}
