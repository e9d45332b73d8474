//! From samples to a picture file: what the command line and the window share, so that both write the same.

use pathmarch_render::aov::{self, Layer};
use pathmarch_render::film::Film;
use pathmarch_render::image::{self, Provenance};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Job, RenderError, Settings, scene_hash};
use std::path::Path;

/// Renders until there are as many `samples` as asked for, or `stop` says so; tells how far it is after each slice.
/// Both are given the samples done.
///
/// # Errors
/// Those of [`Job::advance`].
pub fn accumulate(
    job: &mut Job,
    samples: u32,
    stop: impl Fn(f64) -> bool,
    mut progress: impl FnMut(f64),
) -> Result<(), RenderError> {
    while job.samples_done() < f64::from(samples) && !stop(job.samples_done()) {
        job.advance(samples)?;
        progress(job.samples_done());
    }
    Ok(())
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
