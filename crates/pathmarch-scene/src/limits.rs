//! Ranges of the settings of cameras and of rendering: one source for the scene language and for programs that override its
//! settings.

pub use crate::language::arguments::Range;

/// Exposure, stops.
pub const EXPOSURE: Range = Range::from_to(-100.0, 100.0);
/// Largest radiance of a contribution of light that bounced, W/(m² sr).
pub const CLAMP: Range = Range::POSITIVE;
/// Distance from a surface at which a ray ends, pixels as seen.
pub const DETAIL: Range = Range::from_to(0.001, 10.0);
/// Frames in a second.
pub const FPS: Range = Range { max: 1000.0, ..Range::POSITIVE };
/// Part of a frame's time for which the shutter is open.
pub const SHUTTER: Range = Range::from_to(0.0, 1.0);
/// Width and height of a picture, pixels: the least and the most.
pub const SIDE: (u32, u32) = (1, 16_384);
/// Samples for each pixel: the least and the most.
pub const SAMPLES: (u32, u32) = (1, 1_000_000);
/// Scattering events after the first hit: the least and the most.
pub const BOUNCES: (u32, u32) = (0, 64);
