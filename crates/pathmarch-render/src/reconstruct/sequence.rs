//! Reconstructed sequences of pictures, for measurements and for programs without a window.

use super::{Reconstruction, film_weight};
use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::error::RenderError;
use crate::output::image::Picture;
use crate::settings::Settings;
use glam::Vec3;
use pathmarch_scene::Scene;
use std::sync::Arc;
use std::time::Instant;

/// Picture of a sequence.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Mean of the samples, linear Rec. 709.
    pub noisy: Picture,
    /// Reconstructed picture, linear Rec. 709.
    pub reconstructed: Picture,
    /// Time of path tracing, seconds.
    pub trace_seconds: f64,
    /// Time of reconstruction, seconds.
    pub reconstruct_seconds: f64,
}

/// Sequence of pictures, each reconstructed with the help of those before. Renders on the CPU.
#[derive(Default)]
pub struct Sequence {
    reconstruction: Reconstruction,
    scene: Option<Arc<Scene>>,
}

impl Sequence {
    /// Empty sequence.
    pub fn new() -> Self {
        Self::default()
    }

    /// Next picture: path-traced with the samples and the seed of the settings, then reconstructed. Give every picture
    /// another seed. The same [`Arc`] as before counts as an unchanged scene.
    ///
    /// # Errors
    /// [`RenderError::Settings`] if settings are out of range.
    pub fn render(&mut self, scene: &Arc<Scene>, settings: &Settings) -> Result<Frame, RenderError> {
        settings.check(scene)?;
        let changed = self.scene.as_ref().is_some_and(|before| !Arc::ptr_eq(before, scene));
        self.scene = Some(scene.clone());
        let input = RenderInput::new(scene, settings);
        let frame = input.frame;
        let began = Instant::now();
        let mut job = CpuJob::new(input, settings.first_sample).with_guides();
        while job.film().samples < settings.samples {
            job.advance(settings.samples);
        }
        let traced = Instant::now();
        self.reconstruction.start_film(changed);
        let noisy = job.film().mean();
        let pixels = match job.guides() {
            Some(guides) => {
                let weight = film_weight(settings.samples, u32::MAX);
                let means: Vec<Vec3> = noisy.pixels.iter().copied().map(Vec3::from).collect();
                let pixels =
                    self.reconstruction.picture(job.scene(), &frame, &guides, &means, settings.samples, weight);
                pixels.into_iter().map(Into::into).collect()
            }
            None => noisy.pixels.clone(),
        };
        Ok(Frame {
            reconstructed: Picture { pixels, ..noisy },
            noisy,
            trace_seconds: (traced - began).as_secs_f64(),
            reconstruct_seconds: traced.elapsed().as_secs_f64(),
        })
    }
}
