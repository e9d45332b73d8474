//! What to render of a scene, and how well.

use crate::error::RenderError;
use crate::mode::Mode;
use crate::output::image::MAX_SIDE;
use pathmarch_scene::{Camera, Caustics, Sampler, Scene};

/// The largest number of bounces a path may have.
pub const MAX_BOUNCES: u32 = 64;

/// The largest number of paths that may share a ray of the camera.
pub const MAX_SPLITTING: u32 = 8;

/// Sampling strategy for lights that rays can hit, all but points. All strategies converge to the same picture; the default has
/// the least noise, the others are for comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSearch {
    /// Light sampling and BSDF sampling, weighted by multiple importance sampling.
    #[default]
    Both,
    /// Light sampling at every surface whose BSDF is no delta distribution.
    Sampled,
    /// BSDF sampling: paths hit the lights.
    Hit,
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
    /// Sampling strategy for lights.
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

    /// Checks the settings for a scene.
    ///
    /// # Errors
    /// [`RenderError::Settings`] names the setting that is out of range, and the range.
    pub fn check(&self, scene: &Scene) -> Result<(), RenderError> {
        let fail = |message: String| Err(RenderError::Settings(message));
        let [width, height] = self.size;
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return fail(format!("a picture of {width}x{height} pixels: each side must be from 1 to {MAX_SIDE}"));
        }
        if self.samples == 0 || self.first_sample.checked_add(self.samples).is_none() {
            return fail(format!(
                "{} samples from {}: there must be some, below 2³² in all",
                self.samples, self.first_sample
            ));
        }
        if !(self.detail > 0.0 && self.detail.is_finite()) {
            return fail(format!("a detail of {} pixels: it must be above 0", self.detail));
        }
        if self.bounces > MAX_BOUNCES {
            return fail(format!("{} bounces: at most {MAX_BOUNCES}", self.bounces));
        }
        if self.splitting.is_some_and(|paths| !(1..=MAX_SPLITTING).contains(&paths)) {
            return fail(format!("a splitting of {:?}: it must be from 1 to {MAX_SPLITTING}", self.splitting));
        }
        if self.viewpoint.is_none() && self.camera >= scene.cameras.len() {
            return fail(format!("camera {} of {}", self.camera, scene.cameras.len()));
        }
        Ok(())
    }
}
