//! Probes: a few paths of a picture that tell how to render it. They count operations and measure no time, so that the same
//! picture is always rendered in the same way.

use crate::ray_stats::RayCounters;
use crate::sampling::sobol::hash;
use crate::scene::FrameUniforms;
use pathmarch_scene::Sampler;

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
