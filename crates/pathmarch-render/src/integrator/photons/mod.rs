//! Caustics: light that mirrors, metal and glass reflect or refract onto others, by light paths and photon maps (Jensen
//! 1996, "Global Illumination using Photon Maps").
//!
//! A path from the camera finds a caustic only if it hits the light by chance, and never that of a light without size.
//! So with `caustics "traced"`, paths also start at the lights ([`emission`]), aimed at the bounds of objects with a
//! *focusing* surface: metal or glass up to a roughness of 0.3. They end at the first surface that is not focusing
//! ([`light_path`]). If they met a focusing one before, that end is a photon of the [photon
//! map](crate::scene::photon_map). Camera paths add the photons around each surface that is not focusing, so that
//! caustics are seen directly, in mirrors, through glass and in indirect light.
//!
//! **Every path is counted once.** A camera path that has met photons, and only focusing surfaces since, ignores all
//! lights at which light paths start. Those are all but the sky, objects sampled by their bounding sphere, and lamps
//! within glass.
//!
//! **Bias.** A photon is spread over a disc of a few pixels, which blurs the caustic. Each sample has its own map with
//! smaller discs, so that the blur vanishes as samples add up (Knaus and Zwicker 2011, "Progressive Photon Mapping: A
//! Probabilistic Approach"); it ends at half a pixel, below the pixel filter.
//!
//! **Limits.** Caustics of rougher surfaces, of `principled` metal and glass, and light that media scatter on its way
//! are found by camera paths alone. A camera path and a photon that both disperse have a wavelength each.
//!
//! **Cost.** Each sample has light paths, on the CPU on both backends: half as many as the picture has pixels, or [as many as
//! pay](path_count_choice). Scenes without focusing surfaces pay nothing.

pub(crate) mod emission;
mod light_path;
pub(crate) mod path_count_choice;

use crate::scene::{PhotonMap, TraceContext};
use crate::settings::MAX_LIGHT_PATHS;
use emission::Emission;

/// Pixels for each light path where nothing chooses the number.
const PIXELS_PER_PATH: u32 = 2;
/// Smallest number of light paths of a sample, unless the settings tell the number.
const MIN_LIGHT_PATHS: u32 = 1 << 12;

/// Number of light paths of each sample of a picture of this size, unless it is chosen.
pub(crate) fn default_path_count([width, height]: [u32; 2]) -> u32 {
    (width.saturating_mul(height) / PIXELS_PER_PATH).clamp(MIN_LIGHT_PATHS, MAX_LIGHT_PATHS / 2)
}

/// Photon map of the sample with this index, of `count` light paths.
pub(crate) fn photon_map(ctx: &TraceContext, emission: &Emission, sample: u32, count: u32) -> PhotonMap {
    PhotonMap::new(ctx.frame, light_path::photons(ctx, emission, sample, count), sample)
}
