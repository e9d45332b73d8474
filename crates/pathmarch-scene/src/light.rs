//! Lights that are not objects.

/// A light without geometry in the distance field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Distant light.
    Sun {
        /// Unit vector towards the sun.
        direction: [f32; 3],
        /// Irradiance of a surface that faces the sun, W/m².
        irradiance: [f32; 3],
        /// Apparent diameter, degrees, 0 to 180; 0 is parallel light.
        angle: f32,
        /// Approximates soft shadows of a light without size: light that passes a surface within the angle 1/penumbra
        /// (radians) of it is dimmed, judged by the nearest misses of the march (Quilez 2010). Above 0; larger is
        /// sharper. `None` leaves shadows as they are.
        penumbra: Option<f32>,
    },
    /// Light from a point, the same in every direction.
    Point {
        /// Position, metres.
        at: [f32; 3],
        /// Radiant intensity, W/sr.
        intensity: [f32; 3],
        /// As `penumbra` of the sun.
        penumbra: Option<f32>,
    },
    /// Light from a point in a cone.
    Spot {
        /// Position, metres.
        at: [f32; 3],
        /// Unit vector along the axis of the cone, away from the light.
        direction: [f32; 3],
        /// Radiant intensity on the axis, W/sr.
        intensity: [f32; 3],
        /// Full angle of the cone, degrees, above 0 and up to 180.
        cone: f32,
        /// Soft share of the cone, from 0, a hard edge, to 1.
        blend: f32,
        /// As `penumbra` of the sun.
        penumbra: Option<f32>,
    },
}

impl Light {
    /// Position, metres; `None` for a sun.
    pub fn position(&self) -> Option<[f32; 3]> {
        match *self {
            Self::Point { at, .. } | Self::Spot { at, .. } => Some(at),
            Self::Sun { .. } => None,
        }
    }

    /// Irradiance of a sun, W/m²; radiant intensity of others, W/sr.
    pub fn power(&self) -> [f32; 3] {
        match *self {
            Self::Sun { irradiance, .. } => irradiance,
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
        }
    }
}

/// Cosines of the angles from the axis at which a spot light ends, and up to which it has its full intensity. In between, the
/// intensity is a smoothstep of the cosine (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th ed. 2023, section
/// 12.2.1); `blend` is that of Blender's Cycles. `cone` in degrees.
pub fn spot_cosines(cone: f32, blend: f32) -> [f32; 2] {
    let outer = (0.5 * cone).to_radians().cos();
    [outer, outer + (1.0 - outer) * blend]
}

/// Lumens of a watt of light: the efficacy at 555 nm, which Blender and importers of glTF take for all light, so that a light of
/// so many lumens has the same radiance in these programs.
pub const LUMENS_OF_WATT: f32 = 683.0;
