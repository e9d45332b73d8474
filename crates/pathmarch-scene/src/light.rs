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
}
