//! Participating media: absorption, scattering and emission between surfaces.

/// Homogeneous medium, per metre. Colours are linear Rec. 709, 0 or more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Medium {
    /// Absorption coefficient, 1/m.
    pub absorption: [f32; 3],
    /// Scattering coefficient, 1/m.
    pub scattering: [f32; 3],
    /// Mean cosine of scattering angles (Henyey and Greenstein 1941), -1 to 1 without the ends: 0 scatters alike in all
    /// directions, values above 0 scatter forwards.
    pub anisotropy: f32,
    /// Radiance that a metre of it adds to light, W/(m³ sr).
    pub emission: [f32; 3],
}

impl Medium {
    /// Medium that changes no light.
    pub const VACUUM: Self = Self { absorption: [0.0; 3], scattering: [0.0; 3], anisotropy: 0.0, emission: [0.0; 3] };

    /// True if it scatters light.
    pub fn scatters(&self) -> bool {
        self.scattering.iter().any(|&v| v > 0.0)
    }
    /// True if it absorbs light.
    pub fn absorbs(&self) -> bool {
        self.absorption.iter().any(|&v| v > 0.0)
    }
    /// True if it emits light.
    pub fn emits(&self) -> bool {
        self.emission.iter().any(|&v| v > 0.0)
    }
}
