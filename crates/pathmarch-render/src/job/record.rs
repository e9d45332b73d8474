//! Recording of a job's samples in a part of a film, or in half buffers.

use super::tracer::TakenFilm;
use super::{Job, Work};
use crate::error::RenderError;
use crate::output::film::Film;
use crate::output::parts::{Rect, SampleRecorder};

/// Sums that were taken from a tracer, and the index of their first sample.
struct Taken {
    first: u32,
    film: TakenFilm,
}

impl Job {
    /// Renders until the job has all its samples or `stop` returns true, and records them in `recorder`; calls `progress` after each
    /// slice. Both receive the number of samples of this job that are done. It then has all samples so far, and the next call goes on.
    ///
    /// # Errors
    /// Those of [`advance`](Self::advance).
    pub fn record(
        &mut self,
        recorder: &mut impl SampleRecorder,
        stop: impl Fn(f64) -> bool,
        mut progress: impl FnMut(f64),
    ) -> Result<(), RenderError> {
        let (first, samples) = (self.settings.first_sample, self.settings.samples);
        let mut reading: Option<Taken> = None;
        while self.taken < samples && !stop(self.samples_done()) {
            let goal = (recorder.end_of_sum(first + self.taken) - first).min(samples);
            self.advance(goal)?;
            progress(self.samples_done());
            if self.samples_done() >= f64::from(goal) {
                // While one film is read back, the next is rendered.
                let taken = self.take()?;
                self.put(recorder, reading.replace(taken))?;
            }
        }
        self.put(recorder, reading)?;
        while !self.is_whole() {
            self.advance(self.samples_done() as u32 + 1)?;
        }
        let taken = self.take()?;
        self.put(recorder, Some(taken))
    }

    /// Number of paths that share a camera ray.
    pub fn splitting(&self) -> u32 {
        match &self.work {
            Work::Still(tracer) => tracer.config().splitting,
            Work::Moving(_) => 1,
        }
    }

    /// Number of light samples at the first surface of a path, see
    /// [`Settings::light_samples`](crate::Settings::light_samples).
    pub fn light_samples(&self) -> u32 {
        match &self.work {
            Work::Still(tracer) => tracer.config().light_samples,
            Work::Moving(_) => self.settings.light_samples.unwrap_or(1),
        }
    }

    /// Number of rays that leave the first surface of a path, see
    /// [`Settings::indirect_samples`](crate::Settings::indirect_samples).
    pub fn indirect_samples(&self) -> u32 {
        match &self.work {
            Work::Still(tracer) => tracer.config().indirect_samples,
            Work::Moving(_) => self.settings.indirect_samples.unwrap_or(1),
        }
    }

    /// Number of light paths of each sample, see [`Settings::light_paths`](crate::Settings::light_paths); `None` without traced
    /// caustics.
    pub fn light_paths(&self) -> Option<u32> {
        match &self.work {
            Work::Still(tracer) => tracer.light_paths(),
            Work::Moving(_) => self.settings.light_paths,
        }
    }

    /// True if pixels share light, see [`Settings::path_reuse`](crate::Settings::path_reuse).
    pub fn reuses_paths(&self) -> bool {
        matches!(&self.work, Work::Still(tracer) if tracer.config().path_reuse)
    }

    /// True if pixels at the edges of emitters have further camera rays, see
    /// [`Settings::emitter_edges`](crate::Settings::emitter_edges).
    pub fn traces_emitter_edges(&self) -> bool {
        matches!(&self.work, Work::Still(tracer) if tracer.traces_edges())
    }

    pub(super) fn is_whole(&self) -> bool {
        match &self.work {
            Work::Still(tracer) => tracer.is_whole(),
            Work::Moving(motion) => motion.is_whole(),
        }
    }

    /// Records the samples since the last call, which must be whole.
    pub(super) fn put_samples(&mut self, recorder: &mut impl SampleRecorder) -> Result<(), RenderError> {
        let taken = self.take()?;
        self.put(recorder, Some(taken))
    }

    /// Takes further samples only in these rectangles, as [`Tracer::restrict`](super::tracer::Tracer::restrict) does.
    pub(super) fn restrict(&mut self, rects: Vec<Rect>) {
        match &mut self.work {
            Work::Still(tracer) => tracer.restrict(rects),
            Work::Moving(motion) => motion.restrict(rects),
        }
    }

    /// Takes the sums since the last call.
    fn take(&mut self) -> Result<Taken, RenderError> {
        let first = self.settings.first_sample + self.taken;
        let done = self.samples_done() as u32;
        let film = match &mut self.work {
            Work::Still(tracer) => tracer.take()?,
            Work::Moving(motion) => TakenFilm::Film(motion.take()?),
        };
        self.taken = done;
        Ok(Taken { first, film })
    }

    fn put(&mut self, recorder: &mut impl SampleRecorder, taken: Option<Taken>) -> Result<(), RenderError> {
        let Some(Taken { first, film }) = taken else { return Ok(()) };
        let film: Film = match (&mut self.work, film) {
            (Work::Still(tracer), film) => tracer.finish(film)?,
            (Work::Moving(_), TakenFilm::Film(film)) => film,
            (Work::Moving(_), TakenFilm::Copy(_)) => return Ok(()),
        };
        recorder.record(first, film);
        Ok(())
    }
}
