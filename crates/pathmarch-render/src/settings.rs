//! What to render of a scene, and how well.

use crate::mode::Mode;
use pathmarch_scene::{Camera, Caustics, Sampler, Scene};

/// The largest number of bounces a path may have.
pub const MAX_BOUNCES: u32 = 64;

/// The largest number of paths that may share a ray of the camera.
pub const MAX_SPLITTING: u32 = 8;

/// How the light of what paths can meet, that is of all lights but points, is found. All ways converge to the same
/// picture; the others are there to be compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSearch {
    /// Lights are sampled and met by chance, weighed by multiple importance sampling.
    #[default]
    Both,
    /// Lights are sampled at every surface that scatters in more than single directions.
    Sampled,
    /// Lights are met by chance.
    Met,
}

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
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// What becomes of light that goes through clear glass.
    pub caustics: Caustics,
    /// The largest radiance of a contribution of light that bounced, W/(m² sr), above 0; none where absent.
    pub clamp: Option<f32>,
    /// How near to a surface a ray ends, pixels as seen along the path so far, above 0.
    pub detail: f32,
    /// How lights are found.
    pub light_search: LightSearch,
    /// Index into the scene's cameras.
    pub camera: usize,
    /// A camera that is not in the scene, in place of the scene's.
    pub viewpoint: Option<Camera>,
    /// What the picture shows.
    pub mode: Mode,
    /// Paths that share a ray of the camera, from 1 to [`MAX_SPLITTING`]; where absent, as many as make the picture converge
    /// soonest. All are unbiased. Only of pictures of light.
    pub splitting: Option<u32>,
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
            sampler: scene.render.sampler,
            caustics: scene.render.caustics,
            clamp: scene.render.clamp,
            detail: scene.render.detail,
            light_search: LightSearch::Both,
            camera: 0,
            viewpoint: None,
            mode: Mode::Path,
            splitting: None,
        }
    }

    /// Where the picture is taken from.
    ///
    /// # Panics
    /// Without a [`viewpoint`](Self::viewpoint), where the scene has no camera of this index.
    pub fn camera_of<'a>(&'a self, scene: &'a Scene) -> &'a Camera {
        self.viewpoint.as_ref().unwrap_or_else(|| &scene.cameras[self.camera])
    }
}
