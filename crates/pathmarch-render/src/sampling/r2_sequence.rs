//! What stands for random numbers in modes without noise: sequences that are the same for every pixel and seed.
//!
//! **Idea.** A sample's position in its pixel is a point of a sequence of low discrepancy that begins at the pixel's centre:
//! one sample is a complete picture, and every further one refines its edges. All pixels share it, so that nothing is
//! grainy. The lens is a point. Where a smooth operator blends two materials, the heavier one shows in the first
//! sample; the thresholds of the following ones spread evenly, so that the mean goes to the blend.
//!
//! **Source.** Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences" (R2): multiples of the inverse of
//! the plastic number and of its square; thresholds are multiples of the golden section.

use super::sobol::unit;

/// Where the camera's ray of a sample passes its pixel, from the pixel's top left corner.
pub(crate) fn position(sample: u32) -> [f32; 2] {
    [3_242_174_889, 2_447_445_413].map(|step| unit(sample.wrapping_mul(step).wrapping_add(0x8000_0000)))
}

/// The weight above which the second material of a blend shows as the heavier one.
pub(crate) const HEAVIER: f32 = 0.5;

/// The weight above which the second material of the blend `index` shows in a sample.
pub(crate) fn threshold(sample: u32, index: u32) -> f32 {
    let step = 2_654_435_769u32.wrapping_mul(2 * index + 1);
    unit(sample.wrapping_mul(step).wrapping_add(0x8000_0000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_sample_is_in_the_middle_and_all_fill_the_pixel() {
        assert_eq!((position(0), threshold(0, 0), threshold(0, 7)), ([0.5; 2], 0.5, 0.5));
        let mut cells = [false; 16];
        for sample in 0..32 {
            let [x, y] = position(sample).map(|v| (v * 4.0) as usize);
            cells[4 * y + x] = true;
        }
        assert!(cells.iter().all(|&hit| hit), "{cells:?}");
        for index in 0..4 {
            let mean = (0..64).map(|sample| threshold(sample, index)).sum::<f32>() / 64.0;
            assert!((mean - 0.5).abs() < 0.03, "{index}: {mean}");
        }
    }
}
