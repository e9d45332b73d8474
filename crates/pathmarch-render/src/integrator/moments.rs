//! Moments of path-traced luminance, for error estimates. The film sums them;
//! [`Mode::picture`](crate::Mode::picture) turns the sums into colours.

use super::path;
use crate::scene::TraceContext;
use crate::scene::light::luminance;
use glam::Vec3;

/// Luminance of one path through each of these pixels, and its square.
pub(crate) fn moments(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let luminances = path::trace(ctx, pixels, sample, 1).into_iter().map(|radiance| luminance(radiance.into()));
    luminances.map(|luminance| Vec3::new(luminance, luminance * luminance, 0.0)).collect()
}
