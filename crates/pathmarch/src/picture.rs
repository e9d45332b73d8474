//! Rendering to a picture file, shared by command line and window, so that both write the same.

use pathmarch_render::aov::{self, Layer};
use pathmarch_render::film::Film;
use pathmarch_render::image::{self, Provenance};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{BackendInfo, Settings, scene_hash};
use std::path::Path;

/// A film with everything its file records.
pub struct Rendered<'a> {
    /// Scene of the film.
    pub scene: &'a Scene,
    /// Settings of the film.
    pub settings: &'a Settings,
    /// Samples.
    pub film: &'a Film,
    /// Backend and adapter that rendered it.
    pub backend: &'a BackendInfo,
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
            adapter: self.backend.adapter.clone(),
            backend: self.backend.name.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        };
        let picture = self.settings.mode.picture(self.film);
        image::save_with(output, &picture, channels, display, &provenance).map_err(|error| error.to_string())
    }
}
