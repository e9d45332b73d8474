//! Rectangles of a picture's samples, traced on the CPU in any order.

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::error::RenderError;
use crate::output::film::Film;
use crate::output::parts::Rect;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;

/// Tracer of any rectangle and range of samples of a picture, for programs that distribute the work themselves, such as a page with
/// workers. Films of the same pixels add up to the picture of a [`Job`](super::Job) with the same settings; camera rays
/// are shared only if [`Settings::splitting`] says so.
pub struct TileTracer {
    scene: Arc<Scene>,
    settings: Settings,
    input: RenderInput,
}

impl TileTracer {
    /// Tracer of a scene.
    ///
    /// # Errors
    /// [`RenderError::Settings`] if settings are out of range.
    pub fn new(scene: Arc<Scene>, settings: Settings) -> Result<Self, RenderError> {
        settings.check(&scene)?;
        let input = RenderInput::new(&scene, &settings);
        Ok(Self { scene, settings, input })
    }

    /// Settings of the picture.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Changes size, viewpoint, mode and limits; tables of the scene are kept where they do not depend on them.
    ///
    /// # Errors
    /// [`RenderError::Settings`] if settings are out of range; the old ones stay.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), RenderError> {
        settings.check(&self.scene)?;
        let same_kernel =
            Settings { size: self.settings.size, viewpoint: self.settings.viewpoint.clone(), ..settings.clone() };
        if same_kernel != self.settings || !self.input.reframe(&self.scene, &settings) {
            self.input = RenderInput::new(&self.scene, &settings);
        }
        self.settings = settings;
        Ok(())
    }

    /// Sums of `samples` samples from index `first` on, of the pixels in `rect`.
    ///
    /// # Errors
    /// [`RenderError::Settings`] if the rectangle is empty or exceeds the picture.
    pub fn trace(&self, rect: Rect, first: u32, samples: u32) -> Result<Film, RenderError> {
        let part = Settings { crop: Some(rect), first_sample: first, samples, ..self.settings.clone() };
        part.check(&self.scene)?;
        let mut job = CpuJob::new(self.input.clone(), first).cropped(rect);
        while job.film().samples < samples {
            job.advance(samples);
        }
        Ok(job.take())
    }
}
