//! Picture that one of the backends renders. Still, moving and live pictures share it.

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{FilmCopy, GpuJob};
use crate::error::RenderError;
use crate::mode::Mode;
use crate::output::film::Film;
use crate::output::parts::Rect;
use crate::output::tonemap::Display;
use crate::scene::KernelConfig;
use std::time::Duration;

/// Picture being rendered.
pub(crate) enum Tracer {
    /// On a GPU.
    Gpu(Box<GpuJob>),
    /// On the CPU.
    Cpu(Box<CpuJob>),
}

impl Tracer {
    /// Samples of every pixel that are done or submitted, with a fraction for one that is begun.
    pub(crate) fn samples_done(&self) -> f64 {
        match self {
            Self::Gpu(job) => job.samples_done(),
            Self::Cpu(job) => job.samples_done(),
        }
    }

    /// Renders a slice of the work towards `samples` samples: a submission on a GPU, one sample of every pixel (or those
    /// that share a camera ray) on the CPU.
    pub(crate) fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        match self {
            Self::Gpu(job) => job.advance(samples),
            Self::Cpu(job) => {
                if job.samples_done() < f64::from(samples) {
                    job.advance(samples);
                }
                Ok(())
            }
        }
    }

    /// Renders for about `budget` on the CPU, or one submission towards `samples` samples on a GPU.
    pub(crate) fn advance_for(&mut self, budget: Duration, samples: u32) -> Result<(), RenderError> {
        match self {
            Self::Gpu(job) => job.advance(samples),
            Self::Cpu(job) => {
                job.advance_for(budget);
                Ok(())
            }
        }
    }

    /// Waits for all that is submitted.
    pub(crate) fn wait(&mut self) -> Result<(), RenderError> {
        match self {
            Self::Gpu(job) => job.wait(),
            Self::Cpu(_) => Ok(()),
        }
    }

    /// Starts again with an input of the same scene and kernel, from this sample on; returns false if that needs a new tracer.
    pub(crate) fn reframe(&mut self, input: &RenderInput, first_sample: u32) -> Result<bool, RenderError> {
        match self {
            Self::Gpu(job) => job.reframe(&input.frame, first_sample),
            Self::Cpu(job) => {
                job.reframe(input, first_sample);
                Ok(true)
            }
        }
    }

    /// True if every pixel has the same number of samples.
    pub(crate) fn is_whole(&self) -> bool {
        match self {
            Self::Gpu(job) => job.is_whole(),
            Self::Cpu(job) => job.is_whole(),
        }
    }

    /// Configuration of the estimator.
    pub(crate) fn config(&self) -> &KernelConfig {
        match self {
            Self::Gpu(job) => job.config(),
            Self::Cpu(job) => job.config(),
        }
    }

    /// Number of light paths of each sample, with traced caustics.
    pub(crate) fn light_paths(&self) -> Option<u32> {
        match self {
            Self::Gpu(job) => job.light_paths(),
            Self::Cpu(job) => job.light_paths(),
        }
    }

    /// True if edges of emitters have further camera rays.
    pub(crate) fn traces_edges(&self) -> bool {
        match self {
            Self::Gpu(job) => job.traces_edges(),
            Self::Cpu(job) => job.traces_edges(),
        }
    }

    /// Film so far; finishes samples that are begun.
    pub(crate) fn film(&mut self) -> Result<Film, RenderError> {
        while !self.is_whole() {
            self.advance(self.samples_done() as u32 + 1)?;
        }
        match self {
            Self::Gpu(job) => job.film(),
            Self::Cpu(job) => Ok(job.film().clone()),
        }
    }

    /// Takes the film so far, which must be whole, and starts a new one at the next sample. On a GPU it does not wait.
    pub(crate) fn take(&mut self) -> Result<TakenFilm, RenderError> {
        match self {
            Self::Gpu(job) => job.take().map(TakenFilm::Copy),
            Self::Cpu(job) => Ok(TakenFilm::Film(job.take())),
        }
    }

    /// Waits for a film that was taken.
    pub(crate) fn finish(&mut self, taken: TakenFilm) -> Result<Film, RenderError> {
        match (self, taken) {
            (Self::Gpu(job), TakenFilm::Copy(copy)) => job.finish(copy),
            (_, TakenFilm::Film(film)) => Ok(film),
            (Self::Cpu(_), TakenFilm::Copy(_)) => Err(RenderError::Settings("a film of another backend".to_owned())),
        }
    }

    /// Takes further samples only in these rectangles, whose corners are multiples of 16 pixels from that of the picture. The
    /// film's other pixels lack these samples. It must be whole.
    pub(crate) fn restrict(&mut self, rects: Vec<Rect>) {
        match self {
            Self::Gpu(job) => job.restrict(rects),
            Self::Cpu(job) => job.restrict(&rects),
        }
    }

    /// Tone-maps the film so far: red, green, blue and 255 for each pixel.
    pub(crate) fn show(&mut self, display: &Display, mode: Mode) -> Result<Vec<u8>, RenderError> {
        match self {
            Self::Gpu(job) => job.show(display, mode),
            Self::Cpu(job) => Ok(job.show(display, mode)),
        }
    }
}

/// Film that a tracer has finished.
pub(crate) enum TakenFilm {
    Film(Film),
    /// Film that is being read back.
    Copy(FilmCopy),
}
