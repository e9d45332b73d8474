//! Open Image Denoise where there are no shared libraries: never installed.

use super::DenoiseError;
use glam::Vec3;

/// Environment variable with the path of the library.
pub const LIBRARY_VARIABLE: &str = "OIDN_LIBRARY";

/// Images of a picture of one size, the top row first.
pub(super) struct Images<'a> {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Noisy radiance.
    pub(super) colour: &'a [Vec3],
    /// Albedo, 0 to 1.
    pub(super) albedo: &'a [Vec3],
    /// Normals, of length up to 1.
    pub(super) normal: &'a [Vec3],
}

/// Loaded library.
pub(super) enum Library {}

impl Library {
    /// Reports that browsers load no libraries.
    pub(super) fn open() -> Result<Self, DenoiseError> {
        Err(DenoiseError::NoLibrary { names: Vec::new(), reason: "browsers load no libraries".to_owned() })
    }

    /// Denoised radiance.
    pub(super) fn filter(&self, images: &Images) -> Result<Vec<Vec3>, DenoiseError> {
        let Images { width: _, height: _, colour: _, albedo: _, normal: _ } = images;
        match *self {}
    }
}
