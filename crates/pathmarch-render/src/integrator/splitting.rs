//! Splitting: paths that share a camera ray.
//!
//! Where most of the noise is indirect light, a new camera ray for each path finds the same surface again. Instead k samples
//! in a row start at the surface that one ray hit. They differ in their random numbers from there on, and each is a path of
//! its own, so that the picture is the same for any k. In a kernel, a lane whose path has ended takes the next one of its ray,
//! and does not wait for its neighbours. [`splitting_choice`](super::splitting_choice) chooses k.

use crate::wgsl::shared_constants;

shared_constants! {
    /// The first samples of a pixel have rays of their own, for smooth edges of pictures that are stopped early, too.
    pub(super) const OWN_RAYS: u32 = 16;
}

/// The ray of the camera that a sample belongs to; its twin is in `splitting.wgsl`.
pub(crate) fn ray_of(sample: u32, splitting: u32) -> u32 {
    let shared = sample.saturating_sub(OWN_RAYS);
    sample - shared + shared / splitting
}

/// How many samples from this one on belong to the same ray, of so many that are left.
pub(crate) fn together(sample: u32, splitting: u32, left: u32) -> u32 {
    let shares = sample.checked_sub(OWN_RAYS).map_or(1, |shared| splitting - shared % splitting);
    shares.min(left)
}
