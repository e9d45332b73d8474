//! Film: accumulated sums of radiance, and their mean.
//!
//! **Idea.** A pixel is the mean of its samples. The film stores the *sum* and the count instead of the mean, so that films of
//! adjoining sample ranges (0..64 and 64..128) add up to the film of the whole range. Samples that are NaN, infinite or beyond
//! 1e30 are rejected: neither the sum nor the count includes them.
//!
//! **Source.** The box-filtered film of any Monte Carlo renderer; Pharr, Jakob, Humphreys, *Physically Based Rendering*,
//! 4th edition 2023, section 5.4. A sample contributes to its own pixel only (no reconstruction filter wider than a pixel),
//! so that pixels are independent.
//!
//! **Cost.** Twelve bytes a pixel, and four more once a sample was rejected, or with adaptive sampling. A sum in 32-bit floats of `n` samples of similar
//! size has a relative error of about `sqrt(n) * 6e-8`: 1.5e-5 at 65,536 samples, far below their noise.

use crate::output::image::Picture;
use glam::Vec3;

/// Accumulated radiance: one sum for each pixel and channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Number of samples of every pixel, rejected ones included; with adaptive sampling the largest number.
    pub samples: u32,
    /// Sums of linear Rec. 709 radiance, W/(m² sr), over the samples; `width * height` pixels, the top row first.
    pub sums: Vec<[f32; 3]>,
    /// Number of rejected samples of each pixel; empty if no sample was rejected.
    rejected: Vec<u32>,
    /// Number of samples that each pixel lacks, because adaptive sampling has left them out; empty if no pixel lacks any.
    skipped: Vec<u32>,
}

/// True for a sample that the film accepts: the same test as in the kernel. Comparisons with NaN are false.
pub(crate) fn is_kept(value: Vec3) -> bool {
    value.cmpge(Vec3::ZERO).all() && value.cmplt(Vec3::splat(1e30)).all()
}

/// The sample, or zero if the film rejects it.
pub(crate) fn kept(value: Vec3) -> Vec3 {
    if is_kept(value) { value } else { Vec3::ZERO }
}

/// Reason why two films cannot be added.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// The films have different sizes.
    #[error(
        "cannot add a film of {other_width}x{other_height} to one of {width}x{height}; render both parts at the same size"
    )]
    SizeMismatch {
        /// Width of the film added to.
        width: u32,
        /// Height of the film added to.
        height: u32,
        /// Width of the added film.
        other_width: u32,
        /// Height of the added film.
        other_height: u32,
    },
    /// The sum of the sample counts overflows.
    #[error("cannot add {other_samples} samples to a film of {samples}; the limit is {limit}", limit = u32::MAX)]
    TooManySamples {
        /// Samples in the film added to.
        samples: u32,
        /// Samples in the added film.
        other_samples: u32,
    },
}

impl Film {
    /// Film without samples; every sum is zero.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Film { width, height, samples: 0, sums: vec![[0.0; 3]; pixels], rejected: Vec::new(), skipped: Vec::new() }
    }

    /// Counts `samples` rejected samples of a pixel, which its sum does not include.
    ///
    /// # Panics
    /// If there is no pixel of this index.
    pub fn count_rejected(&mut self, pixel: usize, samples: u32) {
        if samples > 0 {
            self.rejected.resize(self.sums.len(), 0);
            self.rejected[pixel] += samples;
        }
    }

    /// Counts `samples` samples of a pixel that were not taken.
    pub(crate) fn count_skipped(&mut self, pixel: usize, samples: u32) {
        if samples > 0 {
            self.skipped.resize(self.sums.len(), 0);
            self.skipped[pixel] += samples;
        }
    }

    /// Number of rejected samples: NaN, infinite or beyond 1e30. Any value but 0 is a bug to report.
    pub fn non_finite(&self) -> u64 {
        self.rejected.iter().copied().map(u64::from).sum()
    }

    /// Number of samples in each pixel's sum.
    pub fn sample_counts(&self) -> Vec<u32> {
        let mut counts = vec![self.samples; self.sums.len()];
        for missing in [&self.rejected, &self.skipped] {
            for (count, missing) in counts.iter_mut().zip(missing) {
                *count = count.saturating_sub(*missing);
            }
        }
        counts
    }

    /// Mean of the samples of each pixel; black for pixels without samples.
    pub fn mean(&self) -> Picture {
        let mean = |(sum, count): (&[f32; 3], u32)| {
            let scale = 1.0 / f64::from(count.max(1));
            sum.map(|channel| (f64::from(channel) * scale) as f32)
        };
        let pixels = self.sums.iter().zip(self.sample_counts()).map(mean).collect();
        Picture { width: self.width, height: self.height, pixels }
    }

    /// Adds the samples of another film of the same size. The caller ensures that their sample ranges do not overlap.
    ///
    /// # Errors
    /// [`FilmError`] if the sizes differ or the sample count overflows; this film is then unchanged.
    pub fn add(&mut self, other: &Film) -> Result<(), FilmError> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(FilmError::SizeMismatch {
                width: self.width,
                height: self.height,
                other_width: other.width,
                other_height: other.height,
            });
        }
        self.samples = self
            .samples
            .checked_add(other.samples)
            .ok_or(FilmError::TooManySamples { samples: self.samples, other_samples: other.samples })?;
        for (pixel, &samples) in other.rejected.iter().enumerate() {
            self.count_rejected(pixel, samples);
        }
        for (pixel, &samples) in other.skipped.iter().enumerate() {
            self.count_skipped(pixel, samples);
        }
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            for channel in 0..3 {
                sum[channel] += more[channel];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Film of a sample range; sample `s` of pixel `i` is the exactly representable value `i + s / 4`.
    fn film_of(range: std::ops::Range<u32>) -> Film {
        let mut film = Film::new(5, 3);
        for sample in range {
            for (index, sum) in film.sums.iter_mut().enumerate() {
                let value = index as f32 + sample as f32 / 4.0;
                *sum = [sum[0] + value, sum[1] + 2.0 * value, sum[2] + 0.5 * value];
            }
            film.samples += 1;
        }
        film
    }

    #[test]
    fn sample_ranges_add_up_to_the_whole() {
        let mut parts = film_of(0..3);
        parts.add(&film_of(3..8)).expect("equal sizes");
        assert_eq!(parts, film_of(0..8));
        assert_eq!(parts.mean().pixels[4], [4.875, 9.75, 2.4375]);
    }

    #[test]
    fn the_mean_excludes_rejected_samples() {
        let mut whole = Film::new(3, 1);
        for (rejected, sum) in [([1, 0, 2], [3.0, 8.0, 0.0]), ([0, 0, 2], [6.0, 4.0, 0.0])] {
            let mut part = Film::new(3, 1);
            part.samples = 2;
            for pixel in 0..3 {
                part.count_rejected(pixel, rejected[pixel]);
                part.sums[pixel] = [sum[pixel]; 3];
            }
            whole.add(&part).expect("equal sizes");
        }
        assert_eq!((whole.samples, whole.non_finite()), (4, 5));
        assert_eq!(whole.sample_counts(), [3, 4, 0]);
        assert_eq!(whole.mean().pixels, [[3.0; 3], [3.0; 3], [0.0; 3]]);
    }

    #[test]
    fn the_mean_of_an_empty_film_is_black() {
        let picture = Film::new(4, 2).mean();
        assert_eq!((picture.width, picture.height), (4, 2));
        assert_eq!(picture.pixels, vec![[0.0; 3]; 8]);
    }

    #[test]
    fn films_of_other_sizes_are_refused_and_named() {
        let mut film = Film::new(4, 2);
        let message = film.add(&Film::new(2, 4)).expect_err("sizes differ").to_string();
        assert!(message.contains("2x4") && message.contains("4x2"), "{message}");
        film.samples = u32::MAX;
        let mut other = Film::new(4, 2);
        other.samples = 1;
        assert!(matches!(film.add(&other), Err(FilmError::TooManySamples { .. })));
        assert_eq!(film.samples, u32::MAX);
    }
}
