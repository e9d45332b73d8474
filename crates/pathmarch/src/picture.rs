//! Rendering to a picture file, shared by command line and window, so that both write the same.

use pathmarch_render::aov::{self, Layer};
use pathmarch_render::film::Film;
use pathmarch_render::image::{self, Provenance};
use pathmarch_render::pathmarch_scene::{Animation, Scene};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Job, Mode, MotionError, MovingJob, RenderError, Renderer, Settings, Shutter, scene_hash};
use std::path::Path;

/// A render in progress, with or without motion blur.
pub enum RenderTask {
    /// The scene at one time.
    Still(Box<Job>),
    /// The scene over the time that the shutter is open.
    Moving(Box<MovingJob>),
}

impl RenderTask {
    /// Starts a render. Modes other than `path` show the time at which the shutter opens.
    ///
    /// # Errors
    /// Fails as [`Renderer::start`] does.
    pub fn start(
        renderer: &mut Renderer,
        scene: &Scene,
        settings: &Settings,
        shutter: Shutter,
    ) -> Result<Self, RenderError> {
        if shutter.seconds > 0.0 && scene.animated && settings.mode == Mode::Path {
            return Ok(Self::Moving(Box::new(MovingJob::new(settings, shutter))));
        }
        Ok(Self::Still(Box::new(renderer.start(scene, settings)?)))
    }

    /// Renders until all `samples` are done or `stop` returns true; calls `progress` after each slice. Both get the
    /// number of samples done. `animation` belongs to the scene.
    ///
    /// # Errors
    /// Fails as [`Job::advance`] and [`MovingJob::advance`] do.
    pub fn accumulate(
        &mut self,
        renderer: &mut Renderer,
        animation: &mut Animation,
        samples: u32,
        stop: impl Fn(f64) -> bool,
        mut progress: impl FnMut(f64),
    ) -> Result<(), MotionError> {
        while self.samples_done() < f64::from(samples) && !stop(self.samples_done()) {
            match self {
                Self::Still(job) => job.advance(samples)?,
                Self::Moving(job) => job.advance(renderer, animation)?,
            }
            progress(self.samples_done());
        }
        Ok(())
    }

    fn samples_done(&self) -> f64 {
        match self {
            Self::Still(job) => job.samples_done(),
            Self::Moving(job) => job.samples_done(),
        }
    }

    /// Picture so far.
    ///
    /// # Errors
    /// Fails as [`Job::film`] does.
    pub fn film(&mut self) -> Result<Film, MotionError> {
        match self {
            Self::Still(job) => Ok(job.film()?),
            Self::Moving(job) => job.film(),
        }
    }
}

/// A film with everything its file records.
pub struct Rendered<'a> {
    /// Scene of the film.
    pub scene: &'a Scene,
    /// Settings of the film.
    pub settings: &'a Settings,
    /// Samples.
    pub film: &'a Film,
    /// Name of the backend.
    pub backend: String,
    /// Name of the adapter.
    pub adapter: String,
}

impl Rendered<'_> {
    /// Writes the picture with layers and provenance; the file extension selects the format.
    ///
    /// # Errors
    /// Fails with a message if [`image::save_with`] or [`aov::render`] fail.
    pub fn write(&self, output: &Path, display: &Display, layers: &[Layer]) -> Result<(), String> {
        let mut channels = Vec::new();
        if !layers.is_empty() {
            let aovs = aov::render(self.scene, self.settings).map_err(|error| error.to_string())?;
            channels.extend(layers.iter().flat_map(|layer| layer.channels(&aovs, self.film)));
        }
        let provenance = Provenance {
            scene_hash: scene_hash(self.scene),
            samples: self.film.samples,
            first_sample: self.settings.first_sample,
            seed: self.settings.seed,
            bounces: self.settings.bounces,
            mode: self.settings.mode.name().to_owned(),
            adapter: self.adapter.clone(),
            backend: self.backend.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let picture = self.settings.mode.picture(self.film);
        image::save_with(output, &picture, channels, display, &provenance).map_err(|error| error.to_string())
    }
}
