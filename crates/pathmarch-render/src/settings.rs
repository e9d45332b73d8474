//! Settings of a picture: size, samples, sampler and limits.

use crate::error::RenderError;
use crate::mode::Mode;
use crate::output::image::MAX_SIDE;
use crate::output::parts::Rect;
use crate::preview_steps::PreviewSteps;
use pathmarch_scene::{Camera, Caustics, DirectLighting, RenderSettings, Sampler, Scene, settings};

/// Largest number of bounces of a path.
pub const MAX_BOUNCES: u32 = settings::BOUNCES.1;

/// Largest number of paths that share a camera ray.
pub const MAX_SPLITTING: u32 = 8;

/// Largest number of light samples at the first surface of a path.
pub const MAX_LIGHT_SAMPLES: u32 = 8;

/// Largest number of rays that leave the first surface of a path.
pub const MAX_INDIRECT_SAMPLES: u32 = 8;
/// Largest number of light paths of each sample.
pub const MAX_LIGHT_PATHS: u32 = 1 << 20;

/// Settings of one picture. On one adapter, a picture is a pure function of the scene and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height, each from 1 to [`MAX_SIDE`] pixels.
    pub size: [u32; 2],
    /// Samples of each pixel, at least 1.
    pub samples: u32,
    /// Number of samples of the whole picture, if these are a part of it; the splitting suits the whole.
    pub whole_samples: Option<u32>,
    /// Index of the first sample. Films of adjoining ranges add up to the film of the whole range.
    pub first_sample: u32,
    /// Scattering events after the first hit, from 0 (emitted and direct light only) to [`MAX_BOUNCES`].
    pub bounces: u32,
    /// Seed of the sampler; pictures of different seeds have independent noise.
    pub seed: u32,
    /// Generator of the sample points.
    pub sampler: Sampler,
    /// Treatment of light that passes through clear glass.
    pub caustics: Caustics,
    /// Largest radiance of an indirect contribution, W/(m² sr), above 0; `None` for no limit.
    pub clamp: Option<f32>,
    /// Distance from a surface at which a ray hits it, above 0; in pixels, projected to that point of the path.
    pub detail: f32,
    /// Estimator of direct light.
    pub direct_lighting: DirectLighting,
    /// Index of a camera of the scene.
    pub camera: usize,
    /// Camera that replaces the scene's.
    pub viewpoint: Option<Camera>,
    /// Quantity that the picture shows.
    pub mode: Mode,
    /// Steps of [`Mode::Preview`].
    pub preview_steps: PreviewSteps,
    /// Number of paths that share a camera ray, from 1 to [`MAX_SPLITTING`]; `None` for the number that converges soonest. All
    /// are unbiased. Applies to [`Mode::Path`].
    pub splitting: Option<u32>,
    /// Number of light samples at the first surface of a path, from 1 to [`MAX_LIGHT_SAMPLES`]; `None` for the number that converges
    /// soonest. All are unbiased. Applies to [`Mode::Path`], to scenes without fog, media and priorities.
    pub light_samples: Option<u32>,
    /// Number of rays that leave the first surface of a path, from 1 to [`MAX_INDIRECT_SAMPLES`], each with a path of its own
    /// behind it; `None` for the number that converges soonest. All are unbiased. Applies where `light_samples` does, without
    /// `splitting` and `path_reuse`; on software adapters that end loops, only to fields without loops.
    pub indirect_samples: Option<u32>,
    /// Whether pixels share the light that their paths find at second surfaces; `None` where the picture then converges
    /// sooner. Unbiased. Applies to [`Mode::Path`] without `crop` and `clamp`, to scenes without media, bump maps and traced or
    /// fast caustics; on software adapters that end loops, only to fields without loops.
    pub path_reuse: Option<bool>,
    /// Number of light paths of each sample with traced caustics, from 1 to [`MAX_LIGHT_PATHS`]; `None` for the number that
    /// converges soonest. Samples that share a camera ray share the light paths.
    pub light_paths: Option<u32>,
    /// Whether pixels at the edges of emitters have further camera rays, which make them smooth sooner; `None` in pictures that
    /// are large enough. Unbiased. Applies to [`Mode::Path`], to scenes without fog, media and priorities, to stills and
    /// moments without motion blur.
    pub emitter_edges: Option<bool>,
    /// Pixels to render; the film has only these. `None` for all. For stills; live pictures ignore it.
    pub crop: Option<Rect>,
}

impl Settings {
    /// Settings of the scene itself: its first camera, seed 0.
    pub fn of(scene: &Scene) -> Self {
        Self::from(&scene.render)
    }

    /// Camera of the picture.
    ///
    /// # Panics
    /// If there is no [`viewpoint`](Self::viewpoint) and the scene has no camera of this index.
    pub fn camera_of<'a>(&'a self, scene: &'a Scene) -> &'a Camera {
        self.viewpoint.as_ref().unwrap_or_else(|| &scene.cameras[self.camera])
    }

    /// Pixels that are rendered: the crop, or all.
    pub fn rect(&self) -> Rect {
        self.crop.unwrap_or(Rect::of(self.size))
    }

    /// Checks the settings for a scene.
    ///
    /// # Errors
    /// [`RenderError::Settings`] names the setting that is out of range, and the range.
    pub fn check(&self, scene: &Scene) -> Result<(), RenderError> {
        let fail = |message: String| Err(RenderError::Settings(message));
        let [width, height] = self.size;
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return fail(format!("the size is {width}x{height} pixels; width and height must be from 1 to {MAX_SIDE}"));
        }
        if self.samples == 0 || self.first_sample.checked_add(self.samples).is_none() {
            return fail(format!(
                "there are {} samples from index {}; use at least one, and indices below 2³²",
                self.samples, self.first_sample
            ));
        }
        if let Some(crop) = self.crop.filter(|crop| crop.pixels() == 0 || !Rect::of(self.size).contains(crop)) {
            return fail(format!("the crop {crop} is not within the picture, {width}x{height} pixels"));
        }
        if !(self.detail > 0.0 && self.detail.is_finite()) {
            return fail(format!("the detail is {} pixels; it must be finite and above 0", self.detail));
        }
        if self.bounces > MAX_BOUNCES {
            return fail(format!("there are {} bounces; use at most {MAX_BOUNCES}", self.bounces));
        }
        if self.splitting.is_some_and(|paths| !(1..=MAX_SPLITTING).contains(&paths)) {
            return fail(format!(
                "the splitting is {}; it must be from 1 to {MAX_SPLITTING}",
                self.splitting.unwrap_or_default()
            ));
        }
        if self.light_samples.is_some_and(|samples| !(1..=MAX_LIGHT_SAMPLES).contains(&samples)) {
            return fail(format!(
                "there are {} light samples; there must be from 1 to {MAX_LIGHT_SAMPLES}",
                self.light_samples.unwrap_or_default()
            ));
        }
        if self.indirect_samples.is_some_and(|samples| !(1..=MAX_INDIRECT_SAMPLES).contains(&samples)) {
            return fail(format!(
                "there are {} indirect samples; there must be from 1 to {MAX_INDIRECT_SAMPLES}",
                self.indirect_samples.unwrap_or_default()
            ));
        }
        if self.light_paths.is_some_and(|paths| !(1..=MAX_LIGHT_PATHS).contains(&paths)) {
            return fail(format!(
                "there are {} light paths; there must be from 1 to {MAX_LIGHT_PATHS}",
                self.light_paths.unwrap_or_default()
            ));
        }
        if self.viewpoint.is_none() && self.camera >= scene.cameras.len() {
            return fail(format!("there is no camera of index {}; the scene has {}", self.camera, scene.cameras.len()));
        }
        Ok(())
    }
}

impl From<&RenderSettings> for Settings {
    /// Path tracing from the first camera with these settings, seed 0.
    fn from(render: &RenderSettings) -> Self {
        Self {
            size: [render.size.0, render.size.1],
            samples: render.samples,
            whole_samples: None,
            first_sample: 0,
            bounces: render.bounces,
            seed: 0,
            sampler: render.sampler,
            caustics: render.caustics,
            clamp: render.clamp,
            detail: render.detail,
            direct_lighting: render.estimator,
            camera: 0,
            viewpoint: None,
            mode: Mode::Path,
            preview_steps: PreviewSteps::default(),
            splitting: None,
            light_samples: None,
            indirect_samples: None,
            light_paths: None,
            path_reuse: None,
            emitter_edges: None,
            crop: None,
        }
    }
}
