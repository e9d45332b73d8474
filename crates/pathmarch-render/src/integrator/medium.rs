//! Absorbing media inside solids (Beer-Lambert law).

use crate::wgsl::shared_constants;
use glam::Vec3;

shared_constants! {
    /// Length of an escaping ray for absorption, metres.
    pub(super) const UNBOUNDED_LENGTH: f32 = 1e9;
}

/// Transmittance of a medium over a length in metres; `medium` is the absorption coefficient, per metre.
#[inline]
pub(crate) fn transmittance(medium: Vec3, length: f32) -> Vec3 {
    (-medium * length.min(UNBOUNDED_LENGTH)).exp()
}

/// Absorption coefficient beyond a surface that a path crosses, per metre. Coefficients add up where solids overlap.
#[inline]
pub(crate) fn medium_beyond(medium: Vec3, absorption: Vec3, inside: bool) -> Vec3 {
    (if inside { medium - absorption } else { medium + absorption }).max(Vec3::ZERO)
}
