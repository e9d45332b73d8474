//! Samples of a picture: a part of a film, or two halves for `--denoise`.

use pathmarch_render::denoise::{Denoiser, HalfBuffers};
use pathmarch_render::film::Film;
use pathmarch_render::parts::FilmPart;
use pathmarch_render::{Job, RenderError, Settings};

/// Samples of a picture.
pub(super) enum Samples {
    /// Of a picture that is not denoised.
    Part(FilmPart),
    /// In two halves, for this denoiser.
    Halves(HalfBuffers, Denoiser),
}

impl Samples {
    /// No samples yet.
    pub(super) fn new(settings: &Settings, denoiser: Option<Denoiser>) -> Self {
        match denoiser {
            None => Self::Part(FilmPart::new(settings.rect())),
            Some(denoiser) => Self::Halves(HalfBuffers::new(settings), denoiser),
        }
    }

    /// The samples that [`parts`](Self::parts) had; `None` if their number is wrong.
    pub(super) fn of(parts: Vec<FilmPart>, settings: &Settings, denoiser: Option<Denoiser>) -> Option<Self> {
        Some(match denoiser {
            None => Self::Part(<[FilmPart; 1]>::try_from(parts).ok().map(|[part]| part)?),
            Some(denoiser) => Self::Halves(HalfBuffers::of(parts.try_into().ok()?, settings), denoiser),
        })
    }

    /// The samples as parts of a film, to be kept.
    pub(super) fn parts(&self) -> &[FilmPart] {
        match self {
            Self::Part(part) => std::slice::from_ref(part),
            Self::Halves(halves, _) => halves.parts(),
        }
    }

    /// Renders until the job has all its samples or `stop` returns true, as [`Job::record`] does.
    pub(super) fn record(
        &mut self,
        job: &mut Job,
        stop: impl Fn(f64) -> bool,
        progress: impl FnMut(f64),
    ) -> Result<(), RenderError> {
        match self {
            Self::Part(part) => job.record(part, stop, progress),
            Self::Halves(halves, _) => job.record(halves, stop, progress),
        }
    }

    /// Number of samples.
    pub(super) fn count(&self) -> u32 {
        self.parts().iter().map(|part| part.samples().count()).sum()
    }

    /// Film of all samples.
    pub(super) fn film(&self) -> Film {
        match self {
            Self::Part(part) => part.film(),
            Self::Halves(halves, _) => halves.film(),
        }
    }
}
