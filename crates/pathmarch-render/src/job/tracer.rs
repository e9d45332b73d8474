//! A picture being rendered, by one backend or the other: what pictures for files and live pictures share.

use crate::backend::cpu::CpuJob;
use crate::backend::gpu::GpuJob;
use crate::error::RenderError;
use crate::output::film::Film;

/// A picture being rendered.
pub(crate) enum Tracer {
    /// On a GPU.
    Gpu(Box<GpuJob>),
    /// On the CPU.
    Cpu(Box<CpuJob>),
}

impl Tracer {
    /// Samples of every pixel that are done or on their way, with a fraction for one that is begun.
    pub(crate) fn samples_done(&self) -> f64 {
        match self {
            Self::Gpu(job) => job.samples_done(),
            Self::Cpu(job) => job.samples_done(),
        }
    }

    /// Does a slice of the work towards `samples` samples: a submission on a GPU, one sample of every pixel (or those
    /// that share a ray of the camera) on the CPU.
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

    /// Whether every pixel has as many samples.
    fn is_whole(&self) -> bool {
        match self {
            Self::Gpu(job) => job.is_whole(),
            Self::Cpu(job) => job.is_whole(),
        }
    }

    /// The picture so far; finishes samples that are begun.
    pub(crate) fn film(&mut self) -> Result<Film, RenderError> {
        while !self.is_whole() {
            self.advance(self.samples_done() as u32 + 1)?;
        }
        match self {
            Self::Gpu(job) => job.film(),
            Self::Cpu(job) => Ok(job.film().clone()),
        }
    }
}
