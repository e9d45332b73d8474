//! Denoising of final pictures: the noise of path tracing is filtered out, guided by features of the surfaces.
//!
//! **Idea.** (1) `halves`: the samples are recorded in two halves with independent noise. (2) `features`: albedo, normal
//! and position of the surfaces that are seen, also in mirrors and through glass. (3) `signal`: radiance divided by the
//! albedo, so that textures are not blurred. (4) `outliers`: fireflies are limited. (5) `regression`: planes in the space
//! of the features are fitted through windows, first small ones, then large ones whose weights compare the result of
//! the first. (6) `residual`: what the filter has removed and both halves show is no noise, and is added back; so is the
//! mean over large squares, so that no light is lost. (7) `temporal`: in a sequence, the irradiance is averaged with that
//! of the frame before at the same points, and `front` does so at edges. (8) `compose`: back to radiance. All of it runs on the CPU, whichever backend
//! has rendered the picture.
//!
//! **Source.** Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings";
//! Rousselle, Manzi, Zwicker 2013, "Robust Denoising using Feature and Color Information". They choose among filters by
//! an estimate of the error; here one filter is followed by a Wiener filter of its residual, at several scales.
//!
//! **Limits.** With depth of field and motion blur, features have noise
//! of their own, and the filter removes less.
//!
//! **Cost.** 1.0 s of one core for 640x360 pixels, and [`features::FEW_RAYS`] or more camera rays a pixel.

mod compose;
pub mod features;
mod front;
mod grid;
pub mod halves;
mod normal_equations;
#[cfg_attr(target_family = "wasm", path = "no_oidn.rs")]
mod oidn;
mod outliers;
mod regression;
mod residual;
mod signal;
mod temporal;

pub use crate::output::half_films::HalfFilms;
use crate::output::half_films::Means;
use crate::output::image::Picture;
pub use features::Features;
use front::{Composed, Fronts};
use glam::Vec3;
pub use halves::HalfBuffers;
pub use oidn::LIBRARY_VARIABLE;
use rayon::prelude::*;
use regression::{Pilot, Regression, Stage};
use signal::Signal;
use temporal::{Filtered, Past};

/// Stages of the regression: small windows for a first estimate, then large ones.
const STAGES: [Stage; 2] = [Stage { radius: 4, stride: 3 }, Stage { radius: 12, stride: 6 }];

/// Mean relative variances of a picture up to which it stays as it is, and from which on it is filtered entirely.
const FILTERED_NOISE: [f32; 2] = [1e-4, 4e-4];

/// Method of denoising.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Denoiser {
    /// Regression on features; part of this crate.
    #[default]
    Regression,
    /// Intel Open Image Denoise, where its library is installed.
    Oidn,
}

impl Denoiser {
    /// All denoisers, the default first.
    pub const ALL: [Self; 2] = [Self::Regression, Self::Oidn];

    /// Name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Regression => "regression",
            Self::Oidn => "oidn",
        }
    }

    /// Help text, one line.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Regression => "Regression on features of the surfaces.",
            Self::Oidn => "Intel Open Image Denoise, if its library is installed.",
        }
    }

    /// Denoiser of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|denoiser| denoiser.name() == name)
    }

    /// Checks that the denoiser is available, before a picture is rendered for it.
    ///
    /// # Errors
    /// [`DenoiseError::NoLibrary`] if its library is not installed.
    pub fn check(self) -> Result<(), DenoiseError> {
        match self {
            Self::Regression => Ok(()),
            Self::Oidn => oidn::Library::open().map(|_| ()),
        }
    }

    /// Denoised picture, linear Rec. 709 radiance.
    ///
    /// # Errors
    /// [`DenoiseError`] if features and samples are of different sizes, or if the library is missing or fails.
    pub fn denoise(self, samples: impl Into<HalfFilms>, features: &Features) -> Result<Picture, DenoiseError> {
        let samples = &samples.into();
        check_size(samples, features)?;
        let colours = match self {
            Self::Regression => regression(samples, features, None).0,
            Self::Oidn => with_oidn(samples, features)?,
        };
        Ok(picture(samples, colours))
    }
}

/// Denoises the frames of a sequence one after the other, each with the help of those before, so that the rest of the
/// noise does not flicker.
///
/// The first frame is that of [`Denoiser::Regression`]. Later ones are averaged with the past along the motion of camera
/// and objects, where it shows the same points in the same light.
#[derive(Debug, Default)]
pub struct SequenceDenoiser {
    past: Option<PastFrame>,
}

impl SequenceDenoiser {
    /// Denoiser of a sequence of which no frame is known.
    pub fn new() -> Self {
        Self::default()
    }

    /// True if the next frame has one before it.
    pub fn has_past(&self) -> bool {
        self.past.is_some()
    }

    /// Forgets all frames: the next one starts anew.
    pub fn forget(&mut self) {
        self.past = None;
    }

    /// Denoised picture of the next frame, linear Rec. 709 radiance. A frame of another size than the last one starts anew.
    ///
    /// # Errors
    /// [`DenoiseError::SizeMismatch`] if features and samples are of different sizes; the past is kept.
    pub fn denoise(&mut self, samples: impl Into<HalfFilms>, features: &Features) -> Result<Picture, DenoiseError> {
        let samples = &samples.into();
        check_size(samples, features)?;
        let (colours, past) = regression(samples, features, self.past.as_ref());
        self.past = Some(past);
        Ok(picture(samples, colours))
    }
}

/// A frame as the next one reads it.
#[derive(Debug)]
struct PastFrame {
    points: Past,
    fronts: Fronts,
}

/// Fails if samples and features are not of one picture.
fn check_size(samples: &HalfFilms, features: &Features) -> Result<(), DenoiseError> {
    match features.halves.iter().all(|half| half.len() == samples.rect().pixels()) {
        true => Ok(()),
        false => Err(DenoiseError::SizeMismatch),
    }
}

/// Picture of these colours, with the size of the samples.
fn picture(samples: &HalfFilms, colours: Vec<Vec3>) -> Picture {
    let rect = samples.rect();
    Picture { width: rect.width, height: rect.height, pixels: colours.into_iter().map(Into::into).collect() }
}

/// Failure of denoising.
#[derive(Debug, thiserror::Error)]
pub enum DenoiseError {
    /// Samples and features are not of the same picture.
    #[error("the features have another size than the picture; trace them with the same settings")]
    SizeMismatch,
    /// The library is not installed.
    #[error(
        "Open Image Denoise was not found: tried {}; install it (Debian: libopenimagedenoise), set {} to the path of the \
         library, or use the built-in denoiser ({reason})",
        names.join(", "), LIBRARY_VARIABLE
    )]
    NoLibrary {
        /// File names that were tried.
        names: Vec<String>,
        /// Messages of the operating system.
        reason: String,
    },
    /// The library failed.
    #[error("Open Image Denoise: {0}; use the built-in denoiser")]
    Library(String),
}

/// Radiance denoised by regression, joined with the frame before if there is one; and what the next frame needs of it.
fn regression(samples: &HalfFilms, features: &Features, past: Option<&PastFrame>) -> (Vec<Vec3>, PastFrame) {
    let signal = Signal::new(samples, features);
    let limited = outliers::limited(&signal);
    // A single sample tells nothing of its noise, so that no pilot can guide a second stage.
    let stages = if signal.has_two_halves() { &STAGES[..] } else { &STAGES[..1] };
    let mut pilot: Option<Pilot> = None;
    for &stage in stages {
        let regression = Regression { signal: &signal, halves: &limited, pilot: pilot.as_ref(), stage };
        pilot = Some(Pilot::new(&signal, regression.filtered()));
    }
    let mut halves = pilot.map_or(limited, Pilot::into_halves);
    let irradiance = residual::restored(&signal, &mut halves);
    let filtered = Filtered { signal: &signal, features, halves: &halves, irradiance };
    let joined = temporal::joined(filtered, past.map(|past| &past.points));
    let mut colours = compose::composed(&signal, features, &joined.irradiance);
    let composed = Composed { signal: &signal, features, halves: &halves, joined: &joined };
    let fronts = front::joined(&composed, &mut colours, past.map(|past| (&past.points, &past.fronts)));
    compose::keep_energy(&signal, &mut colours);
    let share = filtered_share(&samples.means());
    colours.par_iter_mut().zip(&signal.radiance).for_each(|(colour, sample)| *colour = sample.lerp(*colour, share));
    (colours, PastFrame { points: Past::new(signal, features, joined), fronts })
}

/// Share of the filtered picture in the result: 0 for a picture with so little noise that the filter may only harm it, 1
/// for one with noise.
fn filtered_share(means: &Means) -> f32 {
    let share = means.first_share;
    if share <= 0.0 || share >= 1.0 {
        return 1.0;
    }
    let halves = means.halves[0].par_iter().zip(&means.halves[1]).zip(&means.whole);
    let relative_variance = |((a, b), mean): ((&Vec3, &Vec3), &Vec3)| {
        let variance = (*a - *b) * (*a - *b) * (share * (1.0 - share));
        f64::from(signal::mean_channel(variance / (*mean * *mean + Vec3::splat(0.01))))
    };
    let noise = (halves.map(relative_variance).sum::<f64>() / means.whole.len().max(1) as f64) as f32;
    let filtered = (noise - FILTERED_NOISE[0]) / (FILTERED_NOISE[1] - FILTERED_NOISE[0]);
    if filtered.is_nan() { 1.0 } else { filtered.clamp(0.0, 1.0) }
}

/// Radiance denoised by Open Image Denoise.
fn with_oidn(samples: &HalfFilms, features: &Features) -> Result<Vec<Vec3>, DenoiseError> {
    let library = oidn::Library::open()?;
    let film = samples.film();
    let rays = 2.0 * features.rays as f32;
    let sums = features.halves[0].par_iter().zip(&features.halves[1]);
    let (albedo, normal): (Vec<Vec3>, Vec<Vec3>) = sums
        .map(|(a, b)| {
            let albedo = (a.albedo + b.albedo + a.emission + b.emission) / rays;
            (albedo.clamp(Vec3::ZERO, Vec3::ONE), (a.normal + b.normal) / rays)
        })
        .unzip();
    let colour: Vec<Vec3> = film.mean().pixels.into_iter().map(Vec3::from).collect();
    library.filter(&oidn::Images {
        width: film.width as usize,
        height: film.height as usize,
        colour: &colour,
        albedo: &albedo,
        normal: &normal,
    })
}
