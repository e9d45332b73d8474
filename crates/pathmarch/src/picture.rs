//! From samples to a picture file: what the command line and the window share, so that both write the same.

use pathmarch_render::aov::{self, Layer};
use pathmarch_render::film::Film;
use pathmarch_render::image::{self, Provenance};
use pathmarch_render::pathmarch_scene::{Animation, Scene};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Job, Mode, MotionError, MovingJob, RenderError, Renderer, Settings, Shutter, scene_hash};
use std::path::Path;

/// A picture being rendered, with the shutter open for a moment or for longer.
pub enum Exposure {
    /// Of one moment.
    Still(Box<Job>),
    /// Of the time that the shutter is open.
    Moving(Box<MovingJob>),
}

impl Exposure {
    /// Begins a picture. What traces no paths shows the moment at which the shutter opens.
    ///
    /// # Errors
    /// Those of [`Renderer::start`].
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

    /// Renders until there are as many `samples` as asked for, or `stop` says so; tells how far it is after each slice.
    /// Both are given the samples done. The animation is that of the scene.
    ///
    /// # Errors
    /// Those of [`Job::advance`] and [`MovingJob::advance`].
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

    /// The picture so far.
    ///
    /// # Errors
    /// Those of [`Job::film`].
    pub fn film(&mut self) -> Result<Film, MotionError> {
        match self {
            Self::Still(job) => Ok(job.film()?),
            Self::Moving(job) => job.film(),
        }
    }
}

/// A film, and what it shows.
pub struct Rendered<'a> {
    /// The scene it is of.
    pub scene: &'a Scene,
    /// What it was rendered with.
    pub settings: &'a Settings,
    /// The samples.
    pub film: &'a Film,
    /// The name of the backend.
    pub backend: String,
    /// The name of the adapter.
    pub adapter: String,
}

impl Rendered<'_> {
    /// Writes the picture in the format that the name of the file asks for, with these layers and where it comes from.
    ///
    /// # Errors
    /// In words: what [`image::save_with`] and [`aov::render`] fail with.
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
