//! What lies beyond the scene.

use glam::Vec3;
use pathmarch_scene::Scene;

/// The sky as the CPU backend reads it.
#[derive(Clone, Debug)]
pub(crate) struct Sky {
    pub(crate) colour: Vec3,
}

/// A direction drawn from the sky's picture.
pub(crate) struct EnvironmentSample {
    pub(crate) direction: Vec3,
    pub(crate) radiance: Vec3,
    /// Over solid angle.
    pub(crate) pdf: f32,
}

impl Sky {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self { colour: Vec3::from(scene.sky) }
    }
    /// Radiance that a ray of this density found, weighed.
    pub(crate) fn found(&self, _direction: Vec3, _scatter_pdf: f32) -> Vec3 {
        self.colour
    }
    /// Radiance of a sky that is not sampled as a light.
    pub(crate) fn not_sampled(&self, _direction: Vec3) -> Vec3 {
        self.colour
    }
    pub(crate) fn sample(&self, _position: [f32; 2]) -> Option<EnvironmentSample> {
        None
    }
}
