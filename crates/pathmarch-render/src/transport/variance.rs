//! Paths as what their uncertainty is computed of: luminance and its square, which the film sums.
//! [`Mode::picture`](crate::Mode::picture) makes colours of the sums.

use super::lights::luminance;
use super::path;
use crate::frame::Prepared;
use glam::Vec3;

/// Luminance and its square of one path through each of these pixels.
pub(crate) fn moments(prepared: &Prepared, pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let luminances = path::trace(prepared, pixels, sample, 1).into_iter().map(|radiance| luminance(radiance.into()));
    luminances.map(|luminance| Vec3::new(luminance, luminance * luminance, 0.0)).collect()
}
