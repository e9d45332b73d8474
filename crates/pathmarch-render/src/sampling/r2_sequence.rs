//! Quasirandom numbers of the modes without noise: one sequence for all pixels and seeds.
//!
//! **Idea.** The position of a sample in its pixel is a point of a low-discrepancy sequence that starts at the centre
//! of the pixel. One sample is a complete picture, and every further sample refines its edges. All pixels share the
//! sequence, so that the picture has no noise. The camera is a pinhole. Where a smooth operator blends two materials,
//! the first sample uses the material with the larger weight. The thresholds of the following samples are evenly
//! distributed, so that the mean converges to the blend.
//!
//! **Source.** Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R2): positions are multiples of
//! the inverse of the plastic number and of its square; thresholds are multiples of the golden ratio.

use super::sobol::unit;
use crate::wgsl::shared_constants;

shared_constants! {
    /// Steps of the sequence along x and y, in parts of 2^32.
    const R2_STEP_X: u32 = 3_242_174_889;
    const R2_STEP_Y: u32 = 2_447_445_413;
}

/// Position of a sample in its pixel, in pixels from the top left corner.
pub(crate) fn sample_2d(sample: u32) -> [f32; 2] {
    point(sample, [0x8000_0000; 2])
}

/// Point of the sequence from this start, in parts of 2^32; both coordinates are from 0 to 1.
#[inline]
pub(crate) fn point(index: u32, start: [u32; 2]) -> [f32; 2] {
    let [x, y] = [R2_STEP_X, R2_STEP_Y].map(|step| index.wrapping_mul(step));
    [unit(x.wrapping_add(start[0])), unit(y.wrapping_add(start[1]))]
}

/// Blend weight above which the second material is the one with the larger weight.
pub(crate) const EQUAL_WEIGHTS: f32 = 0.5;

/// Blend weight above which a sample uses the second material of the blend `index`.
pub(crate) fn choice(sample: u32, index: u32) -> f32 {
    let step = 2_654_435_769u32.wrapping_mul(2 * index + 1);
    unit(sample.wrapping_mul(step).wrapping_add(0x8000_0000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sample_is_at_the_centre_and_all_fill_the_pixel() {
        assert_eq!((sample_2d(0), choice(0, 0), choice(0, 7)), ([0.5; 2], 0.5, 0.5));
        let mut cells = [false; 16];
        for sample in 0..32 {
            let [x, y] = sample_2d(sample).map(|v| (v * 4.0) as usize);
            cells[4 * y + x] = true;
        }
        assert!(cells.iter().all(|&hit| hit), "{cells:?}");
        for index in 0..4 {
            let mean = (0..64).map(|sample| choice(sample, index)).sum::<f32>() / 64.0;
            assert!((mean - 0.5).abs() < 0.03, "{index}: {mean}");
        }
    }
}
