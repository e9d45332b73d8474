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

/// Number of paths of a picture.
pub(super) fn path_count(picture: &FrameUniforms, samples: u32) -> f64 {
    picture.size().map(f64::from).iter().product::<f64>() * f64::from(samples)
}

/// Cost of counted rays, in rays.
pub(super) fn cost(counters: &RayCounters) -> f64 {
    let total = counters.total();
    total.rays as f64 + EVALUATION_COST * total.evaluations as f64
}
