//! Moments of the luminance of paths, for error estimates. The film sums them, and
//! [`Mode::picture`](crate::Mode::picture) maps the sums to colours.

use super::packets;
use crate::scene::TraceContext;
use crate::scene::light::luminance;
use glam::Vec3;

/// Luminance of one path through each of these pixels, and its square. The third channel is 0.
pub(crate) fn moments(ctx: &TraceContext, pixels: &[(u32, u32)], sample: u32) -> Vec<Vec3> {
    let luminances = packets::trace(ctx, pixels, sample, 1).into_iter().map(|radiance| luminance(radiance.into()));
    luminances.map(|luminance| Vec3::new(luminance, luminance * luminance, 0.0)).collect()
}
