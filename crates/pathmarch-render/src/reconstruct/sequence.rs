//! Reconstructed sequences of pictures, for measurements and for programs without a window.

use super::{PassTime, ReconstructOptions, Reconstruction, motions, upscaled_size};
use crate::Renderer;
use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::job::tracer::Tracer;
use crate::output::image::Picture;
use crate::settings::Settings;
use glam::Vec3;
use pathmarch_scene::Scene;
use std::sync::Arc;
use web_time::Instant;

/// Picture of a sequence.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Mean of the samples, linear Rec. 709.
    pub noisy: Picture,
    /// Reconstructed picture, linear Rec. 709; as large as asked for.
    pub reconstructed: Picture,
    /// Position of each pixel's point in the last picture, relative to the pixel: columns, rows, and 1 where that picture
    /// shows the point, else 0.
    pub motion: Picture,
    /// Number of samples in the mean of each pixel, in all channels.
    pub history_length: Picture,
    /// Time of path tracing, seconds.
    pub trace_seconds: f64,
    /// Time of reconstruction, seconds.
    pub reconstruct_seconds: f64,
    /// Passes of reconstruction; empty on GPUs without timestamps.
    pub passes: Vec<PassTime>,
}

/// Film of a sequence: its scene, its settings without the number of samples, and its tracer.
struct Film {
    scene: Arc<Scene>,
    settings: Settings,
    input: RenderInput,
    tracer: Tracer,
}

/// Sequence of pictures, each reconstructed with the help of those before.
pub struct Sequence {
    renderer: Renderer,
    options: ReconstructOptions,
    reconstruction: Reconstruction,
    film: Option<Film>,
    /// Size of the last film, pixels.
    last_size: [u32; 2],
}

impl Sequence {
    /// Empty sequence, which renders on the opened device of a renderer, or on the CPU if it has none. The buffer of the
    /// options has no effect.
    pub fn new(renderer: &Renderer, options: ReconstructOptions) -> Self {
        let reconstruction = Reconstruction { times_passes: true, ..Reconstruction::default() };
        let renderer = renderer.clone();
        Self { renderer, options, reconstruction, film: None, last_size: [1; 2] }
    }

    /// Next picture: path-traced with the samples and the seed of the settings, then reconstructed.
    ///
    /// Give every picture of a moving scene another [`first_sample`](Settings::first_sample) in order, and all of them one
    /// seed: then their samples complement each other. The same [`Arc`] as before counts as an unchanged scene. With more
    /// samples and otherwise unchanged settings, the samples that are there already are kept. Pixels share light if
    /// [`path_reuse`](Settings::path_reuse) says so, and do not if it leaves the choice.
    ///
    /// # Errors
    /// [`RenderError`] if settings are out of range, or the GPU refuses.
    pub fn render(&mut self, scene: &Arc<Scene>, settings: &Settings) -> Result<Frame, RenderError> {
        self.render_upscaled(scene, settings, settings.size)
    }

    /// Next picture, as [`render`](Self::render) does it, but shown at a larger size: at most twice that of the settings.
    ///
    /// # Errors
    /// [`RenderError`] if settings are out of range, or the GPU refuses.
    pub fn render_upscaled(
        &mut self,
        scene: &Arc<Scene>,
        settings: &Settings,
        size: [u32; 2],
    ) -> Result<Frame, RenderError> {
        settings.check(scene)?;
        let began = Instant::now();
        let mut film = self.film_of(scene, settings)?;
        while film.tracer.samples_done() < f64::from(settings.samples) {
            film.tracer.advance(settings.samples)?;
        }
        let noisy = film.tracer.film()?.mean();
        let traced = Instant::now();
        let means: Vec<Vec3> = noisy.pixels.iter().copied().map(Vec3::from).collect();
        let mut size = upscaled_size(settings.size, size);
        let shown = self.reconstruction.picture(&mut film.tracer, &film.input, &means, size, &self.options)?;
        let reconstruct_seconds = traced.elapsed().as_secs_f64();
        if shown.is_none() {
            // Shared camera rays have no guides.
            size = settings.size;
        }
        let pixels = shown.unwrap_or(means).into_iter().map(Into::into).collect();
        let histories = self.reconstruction.histories(&film.tracer)?;
        let passes = self.reconstruction.passes(&film.tracer);
        let motion = motions(&histories, settings.size, self.last_size);
        self.film = Some(film);
        let picture = |pixels: Vec<[f32; 3]>| Picture { pixels, ..noisy };
        Ok(Frame {
            motion: picture(motion),
            history_length: picture(histories.into_iter().map(|history| [history.length; 3]).collect()),
            reconstructed: Picture { width: size[0], height: size[1], pixels },
            noisy,
            trace_seconds: (traced - began).as_secs_f64(),
            reconstruct_seconds,
            passes,
        })
    }

    /// Film of these settings: the present one if it has fewer samples of the same picture.
    fn film_of(&mut self, scene: &Arc<Scene>, settings: &Settings) -> Result<Film, RenderError> {
        let one_sample = Settings { samples: 1, ..settings.clone() };
        let before = self.film.take();
        let changed = before.as_ref().is_some_and(|film| !Arc::ptr_eq(&film.scene, scene));
        self.last_size = before.as_ref().map_or(settings.size, |film| film.settings.size);
        let continued = |film: &Film| {
            !changed && film.settings == one_sample && film.tracer.samples_done() < f64::from(settings.samples)
        };
        if let Some(film) = before.filter(continued) {
            return Ok(film);
        }
        self.reconstruction.start_film(changed);
        let mut input = RenderInput::new(scene, settings).with_guides();
        input.config.path_reuse = settings.path_reuse == Some(true) && input.can_reuse_paths(settings);
        let tracer = self.renderer.trace_with_guides(&input, settings.first_sample)?;
        Ok(Film { scene: scene.clone(), settings: one_sample, input, tracer })
    }
}
