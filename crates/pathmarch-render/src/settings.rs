//! What to render of a scene, and how well.

use pathmarch_scene::Scene;

/// The largest number of bounces a path may have.
pub const MAX_BOUNCES: u32 = 64;

/// Size, samples and limits of one picture. A picture is a pure function of the scene and these on one adapter.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Samples for each pixel.
    pub samples: u32,
    /// Index of the first sample: ranges rendered apart add up to the whole.
    pub first_sample: u32,
    /// Scattering events after the first hit; 0 is emitted and direct light only.
    pub bounces: u32,
    /// Pictures of different seeds have independent noise.
    pub seed: u32,
    /// Index into the scene's cameras.
    pub camera: usize,
}

impl Settings {
    /// What the scene itself asks for, seen by its first camera, seed 0.
    pub fn of(scene: &Scene) -> Self {
        Self {
            size: [scene.render.size.0, scene.render.size.1],
            samples: scene.render.samples,
            first_sample: 0,
            bounces: scene.render.bounces,
            seed: 0,
            camera: 0,
        }
    }
}
