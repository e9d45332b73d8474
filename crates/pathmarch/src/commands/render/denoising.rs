//! Rendering for `--denoise`: the samples in two halves, and the denoised picture.

use super::render_failure;
use crate::picture::Denoised;
use pathmarch_cli::Failure;
use pathmarch_render::denoise::{Denoiser, Features, HalfBuffers};
use pathmarch_render::film::Film;
use pathmarch_render::pathmarch_scene::{Animation, Scene};
use pathmarch_render::{Job, RenderError, Settings, Shutter};
use std::sync::Mutex;

/// Samples of a picture.
pub(super) enum Samples {
    /// Of a picture that is not denoised.
    Film(Film),
    /// In two halves, for this denoiser.
    Halves(HalfBuffers, Denoiser),
}

impl Samples {
    /// Renders a picture until it has all its samples or `stop` returns true.
    pub(super) fn render(
        job: &mut Job,
        denoiser: Option<Denoiser>,
        stop: impl Fn(f64) -> bool,
        progress: impl FnMut(f64),
    ) -> Result<Self, RenderError> {
        let Some(denoiser) = denoiser else {
            job.run(stop, progress)?;
            return Ok(Self::Film(job.film()?));
        };
        let [width, height] = job.settings().size;
        let mut halves = HalfBuffers::new(width, height);
        halves.run(job, stop, progress)?;
        Ok(Self::Halves(halves, denoiser))
    }

    /// All samples.
    pub(super) fn film(&self) -> &Film {
        match self {
            Self::Film(film) => film,
            Self::Halves(halves, _) => halves.film(),
        }
    }

    /// Denoised picture; `None` without a denoiser.
    pub(super) fn denoised(
        &self,
        animation: &Mutex<Animation>,
        scene: &Scene,
        settings: &Settings,
        shutter: Shutter,
    ) -> Result<Option<Denoised>, Failure> {
        let Self::Halves(halves, denoiser) = self else { return Ok(None) };
        let samples = halves.film().samples;
        let features = Features::trace_motion_blur(animation, scene, settings, shutter, samples);
        let picture = denoiser.denoise(halves, &features.map_err(render_failure)?).map_err(Failure::other)?;
        Ok(Some(Denoised { denoiser: *denoiser, picture }))
    }
}
