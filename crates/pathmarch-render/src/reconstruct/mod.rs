//! Reconstruction: a clean picture from few samples of a moving scene.
//!
//! **Idea.** Radiance is divided by the albedo of the guide, so that textures are not blurred; the result is called
//! irradiance here. (1) `temporal`: every pixel finds its point in the last picture and continues the mean of the pixels
//! there, if they show the same point. (2) `spatial`: neighbours on the same surface are
//! averaged over a footprint that shrinks as the mean gets surer. (3) `antialiasing`: the picture is averaged with the
//! last one. (4) Once nothing moves, the plain mean of a film that was started there takes over, and the picture is then
//! the one that a still render gives.
//!
//! **Source.** Reprojection and edge-stopping filters guided by variance: Schied et al. 2017, "Spatiotemporal
//! Variance-Guided Filtering". Division by the albedo and an à-trous filter: Dammertz et al. 2010, "Edge-Avoiding À-Trous
//! Wavelet Transform for fast Global Illumination Filtering". Here the weights of the filter are symmetric, so that it
//! moves no energy out of highlights; the point in the last picture is validated by its position in space instead of a
//! depth, and pictures of different sizes share their history.
//!
//! **Limits.** Runs on the CPU backend. `motion` is that of rigid objects; shapes that deform start anew where the point
//! was not on the surface before. Reflections on rough surfaces and what is seen through glass move with the surface.
//!
//! **Cost.** On two cores 11 to 15 ms for 320x180 pixels.

mod antialiasing;
mod motion;
mod sequence;
mod spatial;
mod temporal;

use crate::integrator::guides::{Guide, GuideClass};
use crate::scene::{FrameUniforms, RenderScene, light};
use antialiasing::{Last, ShownPicture, antialiased};
use glam::Vec3;
use motion::{Motion, Poses};
use rayon::prelude::*;
pub use sequence::{Frame, Sequence};
use std::sync::Arc;
use temporal::{History, Samples};

/// Number of samples of a still picture from which on it is shown as it is.
const FILM_SAMPLES: u32 = 128;
/// Least albedo to divide by.
const MIN_ALBEDO: f32 = 0.04;
/// Longest history of an unchanged scene, samples.
const MAX_HISTORY: f32 = 24.0;
/// Longest history after a change of the scene, samples. It is also clamped to the new light around each pixel.
const MAX_HISTORY_OF_CHANGED_SCENE: f32 = 6.0;

/// Result of a film.
struct Reconstructed {
    poses: Poses,
    history: History,
    shown: ShownPicture,
}

/// State between the pictures of a sequence.
#[derive(Default)]
pub(crate) struct Reconstruction {
    /// Result before the present film.
    past: Option<Reconstructed>,
    /// Result of the present film.
    present: Option<Reconstructed>,
    /// Longest history, samples.
    max_history: f32,
    /// True if the scene has changed since `past`.
    scene_changed: bool,
}

impl Reconstruction {
    /// Starts another film: of another view, size or moment, or of a changed scene.
    pub(crate) fn start_film(&mut self, scene_changed: bool) {
        if let Some(present) = self.present.take() {
            self.past = Some(present);
            (self.max_history, self.scene_changed) = (MAX_HISTORY, false);
        }
        if scene_changed {
            (self.max_history, self.scene_changed) = (MAX_HISTORY_OF_CHANGED_SCENE, true);
        }
    }

    /// Linear picture of a film with `samples` samples of each pixel and these means. `film_weight` is the weight of the
    /// means themselves, 0 to 1.
    pub(crate) fn picture(
        &mut self,
        scene: &RenderScene,
        frame: &FrameUniforms,
        guides: &Arc<Vec<Guide>>,
        means: &[Vec3],
        samples: u32,
        film_weight: f32,
    ) -> Vec<Vec3> {
        let divided = means.par_iter().zip(guides.par_iter()).map(|(mean, guide)| *mean / divisor(guide));
        let mut irradiance: Vec<Vec3> = divided.collect();
        if samples == 1 {
            spatial::spread_fireflies(frame.size(), guides, &mut irradiance);
        }
        let (past, max_length) = (self.past.as_ref(), self.max_history * (1.0 - film_weight));
        let poses = Poses::new(scene);
        let changed_past = past.filter(|_| self.scene_changed);
        let motion = changed_past.map_or_else(Motion::default, |past| Motion::new(&past.poses, &poses));
        let past_history = past.map(|past| (&past.history, &motion));
        let limits = self.scene_changed.then(|| spatial::plausible_luminances(frame.size(), &irradiance));
        let new = Samples { irradiance: &irradiance, count: samples as f32 };
        let history = History::new(frame, guides, new, past_history, max_length, limits.as_deref());
        let multiplied = spatial::filter(&history).into_par_iter().zip(guides.par_iter());
        let clean: Vec<Vec3> = multiplied.map(|(irradiance, guide)| irradiance * divisor(guide)).collect();
        let shown = ShownPicture {
            frame: *frame,
            colours: antialiased(
                frame,
                guides,
                &clean,
                past.map(|past| Last { picture: &past.shown, history: &past.history, motion: &motion }),
            ),
        };
        let picture = shown.colours.iter().zip(means).map(|(colour, mean)| colour.lerp(*mean, film_weight)).collect();
        self.present = Some(Reconstructed { poses, history, shown });
        picture
    }
}

/// Weight of a still film of `samples` samples, of which `target` are wanted.
pub(crate) fn film_weight(samples: u32, target: u32) -> f32 {
    if samples >= target.min(FILM_SAMPLES) {
        return 1.0;
    }
    let done = samples.saturating_sub(1) as f32 / (FILM_SAMPLES - 1) as f32;
    // Noise falls with the root of the samples only: the film may take over late.
    done * done
}

/// Factor between radiance and irradiance.
fn divisor(guide: &Guide) -> Vec3 {
    match guide.class {
        GuideClass::Sky | GuideClass::Glass => Vec3::ONE,
        GuideClass::Emitter | GuideClass::Surface => guide.albedo.max(Vec3::splat(MIN_ALBEDO)),
    }
}

/// Luminance of a linear Rec. 709 colour.
fn luminance(colour: Vec3) -> f32 {
    light::luminance(colour.into())
}
