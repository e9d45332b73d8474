//! Pictures on the GPU of a browser, where nothing may wait.

use crate::backend::RenderInput;
use crate::backend::gpu::{GpuContext, GpuJob, LIVE};
use crate::error::RenderError;
use crate::output::film::Film;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;

/// Opened GPU of a browser. After an error, another must be opened.
pub struct WebGpu {
    context: Arc<GpuContext>,
}

impl WebGpu {
    /// Opens the GPU that the browser prefers.
    ///
    /// # Errors
    /// [`RenderError`] if there is none, or it is refused.
    pub async fn open() -> Result<Self, RenderError> {
        Ok(Self { context: Arc::new(GpuContext::open_async().await?) })
    }

    /// Name of the GPU, as far as the browser reveals it.
    pub fn name(&self) -> &str {
        &self.context.description.name
    }

    /// Starts a picture.
    ///
    /// # Errors
    /// [`RenderError`] if settings are out of range, or the GPU refuses.
    pub fn start(&self, scene: Arc<Scene>, settings: Settings) -> Result<WebGpuJob, RenderError> {
        settings.check(&scene)?;
        let input = RenderInput::new(&scene, &settings);
        let job = GpuJob::new(self.context.clone(), &input, settings.first_sample, LIVE)?;
        Ok(WebGpuJob { scene, settings, input, job })
    }
}

/// Picture being rendered on the GPU of a browser.
pub struct WebGpuJob {
    scene: Arc<Scene>,
    settings: Settings,
    input: RenderInput,
    job: GpuJob,
}

impl WebGpuJob {
    /// Starts again with another size or viewpoint. Returns false if that needs another job; this one is useless then.
    ///
    /// # Errors
    /// [`RenderError`] if settings are out of range, or the GPU has failed.
    pub fn reframe(&mut self, settings: &Settings) -> Result<bool, RenderError> {
        settings.check(&self.scene)?;
        let (size, viewpoint) = (self.settings.size, self.settings.viewpoint.clone());
        let same_kernel = Settings { size, viewpoint, ..settings.clone() } == self.settings;
        if !same_kernel || !self.input.reframe(&self.scene, settings) {
            return Ok(false);
        }
        self.settings = settings.clone();
        self.job.reframe(&self.input.frame, settings.first_sample)
    }

    /// Submits work of about 10 ms towards `samples` samples, and waits for it.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub async fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        self.job.advance_async(samples).await
    }

    /// Samples of every pixel that are done, with a fraction for one that is begun.
    pub fn samples_done(&self) -> f64 {
        self.job.samples_done()
    }

    /// Film so far, with whole samples.
    ///
    /// # Errors
    /// [`RenderError::Device`] if the GPU fails.
    pub async fn film(&mut self) -> Result<Film, RenderError> {
        while !self.job.is_whole() {
            self.job.advance_async(self.job.samples_done() as u32 + 1).await?;
        }
        self.job.film_async().await
    }
}
