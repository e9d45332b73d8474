//! Rendering to a picture file, shared by command line and window, so that both write the same.

use pathmarch_render::aov::{self, Layer};
use pathmarch_render::denoise::Denoiser;
use pathmarch_render::film::Film;
use pathmarch_render::image::{self, Channel, ChannelValues, ImageFormat, Picture, Provenance};
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
    /// Denoised picture of the film, if there is one.
    pub denoised: Option<Denoised>,
}

/// Denoised picture, with its denoiser.
pub struct Denoised {
    pub denoiser: Denoiser,
    /// True if it is averaged with the frame before.
    pub is_joined: bool,
    pub picture: Picture,
}

impl Denoised {
    /// Name of the method, as files record it.
    fn name(&self) -> String {
        let temporal = if self.is_joined { ", temporal" } else { "" };
        format!("{}{temporal}", self.denoiser.name())
    }
}

/// Layer of the picture before it was denoised.
fn noisy_channels(noisy: &Picture) -> impl Iterator<Item = Channel> {
    ['R', 'G', 'B'].into_iter().enumerate().map(|(k, part)| Channel {
        name: format!("noisy.{part}"),
        values: ChannelValues::F32(noisy.pixels.iter().map(|pixel| pixel[k]).collect()),
    })
}

impl Rendered<'_> {
    /// Writes the picture with layers and provenance; the file extension selects the format. Beside other layers, a
    /// denoised picture has one with the mean of its samples.
    ///
    /// # Errors
    /// Fails with a message if [`image::encode`] or [`aov::render`] fail, or the file cannot be written.
    pub fn write(&self, output: &Path, display: &Display, layers: &[Layer]) -> Result<(), String> {
        let format = ImageFormat::from_path(output).map_err(|error| error.to_string())?;
        image::check_writable(output).map_err(|error| error.to_string())?;
        let bytes = self.encode(output, format, display, layers)?;
        image::write_file(output, &bytes).map_err(|error| error.to_string())
    }

    /// Bytes of the file that [`write`](Self::write) would write; errors name `path`.
    ///
    /// # Errors
    /// Fails with a message if [`image::encode`] or [`aov::render`] fail.
    pub fn encode(
        &self,
        path: &Path,
        format: ImageFormat,
        display: &Display,
        layers: &[Layer],
    ) -> Result<Vec<u8>, String> {
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
            denoiser: self.denoised.as_ref().map(Denoised::name),
        };
        let mean = self.settings.mode.picture(self.film);
        if self.denoised.is_some() && !layers.is_empty() {
            channels.extend(noisy_channels(&mean));
        }
        let picture = self.denoised.as_ref().map_or(&mean, |denoised| &denoised.picture);
        image::encode(path, format, picture, channels, display, &provenance).map_err(|error| error.to_string())
    }
}
