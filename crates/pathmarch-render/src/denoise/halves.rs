//! Half buffers: the samples of a picture in two halves with independent noise.
//!
//! **Idea.** A film is read after blocks of samples, each about an eighth as long as all before it, so that the number of
//! samples need not be known in advance. Each block goes to the half that has fewer samples.
//!
//! **Source.** Rousselle, Knaus, Zwicker 2012, "Adaptive Rendering with Non-Local Means Filtering", section 4.

use crate::error::RenderError;
use crate::job::Job;
use crate::output::film::Film;
use glam::Vec3;

/// Samples of a block are a multiple of this from [`ALIGNED_FROM`] on, so that paths that share a camera ray stay
/// together.
const ALIGNMENT: u32 = 8;
/// Number of samples from which on blocks are aligned.
const ALIGNED_FROM: u32 = 16;

/// A film and one half of its samples.
#[derive(Clone, Debug)]
pub struct HalfBuffers {
    /// All samples.
    whole: Film,
    /// Sums of the samples of the first half.
    first_sums: Vec<[f32; 3]>,
    /// Numbers of samples of the first half.
    first_counts: Vec<u32>,
    first_samples: u32,
}

/// Means of the samples of each pixel.
pub struct Means {
    /// Means of both halves; of all samples where a half has none.
    pub halves: [Vec<Vec3>; 2],
    /// Means of all samples.
    pub whole: Vec<Vec3>,
    /// Share of the first half in all samples.
    pub first_share: f32,
}

impl HalfBuffers {
    /// Buffers of a film without samples.
    pub fn new(width: u32, height: u32) -> Self {
        let whole = Film::new(width, height);
        let (first_sums, first_counts) = (whole.sums.clone(), vec![0; whole.sums.len()]);
        Self { whole, first_sums, first_counts, first_samples: 0 }
    }

    /// Renders until a job has all its samples or `stop` returns true, as [`Job::run`] does, and records both halves.
    ///
    /// # Errors
    /// Those of [`Job::advance`].
    pub fn run(
        &mut self,
        job: &mut Job,
        stop: impl Fn(f64) -> bool,
        mut progress: impl FnMut(f64),
    ) -> Result<(), RenderError> {
        let samples = job.settings().samples;
        while job.samples_done() < f64::from(samples) && !stop(job.samples_done()) {
            let end = self.block_end();
            job.advance(end)?;
            progress(job.samples_done());
            if job.samples_done() >= f64::from(end.min(samples)) {
                self.record(job.film()?);
            }
        }
        self.record(job.film()?);
        Ok(())
    }

    /// Number of samples at the end of the current block.
    fn block_end(&self) -> u32 {
        let done = self.whole.samples;
        let end = done + (done / ALIGNMENT).max(1);
        if end <= ALIGNED_FROM { end } else { end.next_multiple_of(ALIGNMENT) }
    }

    /// Records a film that has more samples than at the last call; the new ones are a block.
    pub fn record(&mut self, film: Film) {
        let block = film.samples - self.whole.samples;
        if 2 * self.first_samples <= self.whole.samples {
            self.first_samples += block;
            for (first, (sum, before)) in self.first_sums.iter_mut().zip(film.sums.iter().zip(&self.whole.sums)) {
                *first = std::array::from_fn(|k| first[k] + (sum[k] - before[k]));
            }
            let counts = film.sample_counts().into_iter().zip(self.whole.sample_counts());
            self.first_counts.iter_mut().zip(counts).for_each(|(first, (all, before))| *first += all - before);
        }
        self.whole = film;
    }

    /// All samples.
    pub fn film(&self) -> &Film {
        &self.whole
    }

    /// Means of both halves and of all samples.
    pub fn means(&self) -> Means {
        let counts = self.whole.sample_counts();
        let mean = |sum: Vec3, count: u32| (count > 0).then(|| sum / count as f32);
        let pixels = self.whole.sums.iter().zip(&self.first_sums).zip(counts.iter().zip(&self.first_counts));
        let (mut first, mut second, mut whole) = (Vec::new(), Vec::new(), Vec::new());
        for ((&sum, &first_sum), (&count, &first_count)) in pixels {
            let (sum, first_sum) = (Vec3::from(sum), Vec3::from(first_sum));
            let all = mean(sum, count).unwrap_or_default();
            first.push(mean(first_sum, first_count).unwrap_or(all));
            second.push(mean(sum - first_sum, count - first_count).unwrap_or(all));
            whole.push(all);
        }
        let first_share = self.first_samples as f32 / self.whole.samples.max(1) as f32;
        Means { halves: [first, second], whole, first_share }
    }
}
