//! Worker that traces whole pictures on the GPU of the browser.

use crate::view::View;
use pathmarch_render::pathmarch_scene::{Document, Moment};
use pathmarch_render::{Mode, WebGpu, WebGpuJob};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use wasm_bindgen::prelude::*;

/// Tracer of whole pictures. After an error another must be opened.
#[wasm_bindgen]
pub struct GpuTracer {
    gpu: WebGpu,
    document: Document,
    /// Pictures of the present text: path-traced, and preview.
    jobs: HashMap<Mode, WebGpuJob>,
    mode: Mode,
}

#[wasm_bindgen]
impl GpuTracer {
    /// Opens the GPU.
    ///
    /// # Errors
    /// If the browser has none.
    pub async fn open(name: String, text: String) -> Result<Self, JsError> {
        let gpu = WebGpu::open().await?;
        Ok(Self { gpu, document: Document::new(name, text), jobs: HashMap::new(), mode: Mode::Path })
    }

    /// Name of the GPU.
    pub fn name(&self) -> String {
        self.gpu.name().to_owned()
    }

    /// Replaces the text, and sets the moment in seconds.
    pub fn set_text(&mut self, text: String, seconds: f64) {
        self.jobs.clear();
        self.document.replace_text(text, "", None);
        let fps = self.document.last_good().map_or(24.0, |scene| scene.render.fps);
        self.document.set_moment(Moment::of_seconds(seconds, fps));
    }

    /// Sets camera, size and mode from JSON, and starts the picture again.
    ///
    /// # Errors
    /// If the text has mistakes, settings are out of range, or the GPU refuses.
    pub fn set_view(&mut self, json: &str) -> Result<(), JsError> {
        let scene = self.document.scene().map_err(|error| JsError::new(&error.to_string()))?;
        let settings = serde_json::from_str::<View>(json)?.settings(scene)?;
        self.mode = settings.mode;
        match self.jobs.entry(settings.mode) {
            Entry::Occupied(mut job) => {
                if !job.get_mut().reframe(&settings)? {
                    *job.get_mut() = self.gpu.start(scene.clone(), settings)?;
                }
            }
            Entry::Vacant(place) => drop(place.insert(self.gpu.start(scene.clone(), settings)?)),
        }
        Ok(())
    }

    /// Renders for some milliseconds, at least one sample, towards `samples`. Returns the sums of all samples so far: red,
    /// green and blue of each pixel, and last the number of samples.
    ///
    /// # Errors
    /// If there is no view, or the GPU fails.
    pub async fn trace(&mut self, samples: u32, milliseconds: f64) -> Result<Vec<f32>, JsError> {
        let job = self.jobs.get_mut(&self.mode).ok_or_else(|| JsError::new("set a view first"))?;
        let began = web_time::Instant::now();
        while job.samples_done() < 1.0
            || (job.samples_done() < f64::from(samples) && began.elapsed().as_secs_f64() * 1000.0 < milliseconds)
        {
            job.advance(samples).await?;
        }
        let film = job.film().await?;
        let mut sums = film.sums.into_flattened();
        sums.push(film.samples as f32);
        Ok(sums)
    }
}
