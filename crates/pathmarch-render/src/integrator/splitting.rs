//! Splitting: paths that share a camera ray.
//!
//! Where most of the noise is indirect light, a new camera ray for each path hits the same surface again. Instead, k
//! consecutive samples start at the hit of one camera ray. Each is a path with its own random numbers from there on, so
//! that the expected picture is the same for any k. In a kernel, a lane whose path has ended takes the next path of its
//! camera ray and does not wait for its neighbours. [`splitting_choice`](super::splitting_choice) chooses k.

use crate::wgsl::shared_constants;

shared_constants! {
    /// Number of first samples of a pixel with a camera ray each, so that pictures that are stopped early have smooth
    /// edges.
    pub(crate) const UNSPLIT_SAMPLES: u32 = 16;
}

/// Index of the camera ray of a sample.
pub(crate) fn camera_ray_index(sample: u32, splitting: u32) -> u32 {
    let shared = sample.saturating_sub(UNSPLIT_SAMPLES);
    sample - shared + shared / splitting
}

/// Number of samples from `sample` on with the same camera ray, at most `remaining`.
pub(crate) fn samples_sharing_ray(sample: u32, splitting: u32, remaining: u32) -> u32 {
    let count = sample.checked_sub(UNSPLIT_SAMPLES).map_or(1, |shared| splitting - shared % splitting);
    count.min(remaining)
}
