//! Image metrics against a reference: relMSE, MSE, means and FLIP.
//!
//! **Idea.** relMSE = mean over pixels and channels of (i - r)² / (r² + 0.01). It measures Monte Carlo noise with equal weight
//! in dark and bright parts; one over relMSE times the render time is the efficiency of an unbiased renderer. Means
//! distinguish bias from noise. FLIP ([`flip`](mod@flip)) predicts the visible difference.
//!
//! **Source.** relMSE after Rousselle, Knaus, Zwicker, "Adaptive Sampling and Reconstruction using Greedy Error
//! Minimization", SIGGRAPH Asia 2011, with the constant of the reference pictures.
//!
//! **Bad pixels.** A NaN must not count as a small error. [`relmse`], [`mse`] and [`flip()`](flip::flip) refuse pictures with
//! NaN or infinity. [`compare`] counts these pixels, excludes them from relMSE, MSE and the means, and assigns them the largest
//! FLIP error, 1.
//!
//! **Cost.** Linear in the number of pixels; FLIP dominates.

pub mod flip;

use crate::output::image::{Picture, PictureKind};

/// Constant added to the squared reference in relMSE, so that black does not divide by zero.
pub(crate) const RELMSE_EPSILON: f64 = 0.01;

/// Reason why two pictures cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MetricError {
    /// The pictures have different sizes.
    #[error(
        "the picture is {width}x{height} and the reference {reference_width}x{reference_height}; \
         render or scale one to the size of the other"
    )]
    SizeMismatch {
        /// Width of the picture.
        width: u32,
        /// Height of the picture.
        height: u32,
        /// Width of the reference.
        reference_width: u32,
        /// Height of the reference.
        reference_height: u32,
    },
    /// The pictures have no pixels.
    #[error("the pictures have no pixels; there is nothing to compare")]
    Empty,
    /// Some pixels are NaN or infinite.
    #[error(
        "{image} pixels of the picture and {reference} of the reference are NaN or infinite; \
         find their cause before you trust any figure"
    )]
    NonFinite {
        /// Number of such pixels in the picture.
        image: u64,
        /// Number of such pixels in the reference.
        reference: u64,
    },
}

/// Result of [`compare`].
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// relMSE: mean of (i - r)² / (r² + 0.01).
    pub relmse: f64,
    /// MSE: mean of (i - r)².
    pub mse: f64,
    /// Mean FLIP error, 0 (no visible difference) to 1.
    pub flip: f64,
    /// Mean colour of the picture.
    pub image_mean: [f64; 3],
    /// Mean colour of the reference.
    pub reference_mean: [f64; 3],
    /// Number of pixels of the picture that are NaN or infinite.
    pub image_non_finite: u64,
    /// Number of pixels of the reference that are NaN or infinite.
    pub reference_non_finite: u64,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

/// Compares a picture with a reference by FLIP (`Ldr`) or HDR-FLIP (`Hdr`) and the other metrics. The module documentation
/// describes the treatment of pixels that are NaN or infinite.
///
/// # Errors
/// [`MetricError::SizeMismatch`], [`MetricError::Empty`].
pub fn compare(image: &Picture, reference: &Picture, kind: PictureKind) -> Result<Comparison, MetricError> {
    check_sizes(image, reference)?;
    let (mut relmse, mut mse, mut finite) = (0.0, 0.0, 0u64);
    let (mut image_mean, mut reference_mean) = ([0.0; 3], [0.0; 3]);
    for (pixel, expected) in image.pixels.iter().zip(&reference.pixels) {
        if !is_finite(pixel) || !is_finite(expected) {
            continue;
        }
        finite += 1;
        for channel in 0..3 {
            let (i, r) = (f64::from(pixel[channel]), f64::from(expected[channel]));
            relmse += relative_square(i, r);
            mse += (i - r) * (i - r);
            image_mean[channel] += i;
            reference_mean[channel] += r;
        }
    }
    let pixels = finite.max(1) as f64;
    let worst = if finite == 0 { f64::INFINITY } else { 0.0 };
    Ok(Comparison {
        relmse: relmse / (3.0 * pixels) + worst,
        mse: mse / (3.0 * pixels) + worst,
        flip: flip::error_map(image, reference, kind).mean(),
        image_mean: image_mean.map(|sum| sum / pixels),
        reference_mean: reference_mean.map(|sum| sum / pixels),
        image_non_finite: image.non_finite(),
        reference_non_finite: reference.non_finite(),
        width: image.width,
        height: image.height,
    })
}

/// Mean over pixels and channels of (i - r)² / (r² + 0.01).
///
/// # Errors
/// [`MetricError`]: different sizes, no pixels, pixels that are NaN or infinite.
pub fn relmse(image: &Picture, reference: &Picture) -> Result<f64, MetricError> {
    mean_of(image, reference, relative_square)
}

/// Mean over pixels and channels of (i - r)².
///
/// # Errors
/// Those of [`relmse`].
pub fn mse(image: &Picture, reference: &Picture) -> Result<f64, MetricError> {
    mean_of(image, reference, |i, r| (i - r) * (i - r))
}

/// Mean colour over all pixels; NaN if any pixel is NaN.
pub fn mean_colour(picture: &Picture) -> [f64; 3] {
    picture.mean_colour()
}

/// Picture of the means of square blocks of `side` pixels. It shows bias that the noise of single pixels hides. Blocks at the
/// right and the bottom may be smaller; `side` 0 counts as 1.
pub fn block_means(picture: &Picture, side: u32) -> Picture {
    let side = side.max(1);
    Picture::from_fn(picture.width.div_ceil(side), picture.height.div_ceil(side), |block_x, block_y| {
        let xs = block_x * side..(block_x * side + side).min(picture.width);
        let ys = block_y * side..(block_y * side + side).min(picture.height);
        let count = f64::from(xs.end - xs.start) * f64::from(ys.end - ys.start);
        let mut sum = [0.0; 3];
        for y in ys {
            let row = y as usize * picture.width as usize;
            for pixel in &picture.pixels[row + xs.start as usize..row + xs.end as usize] {
                for channel in 0..3 {
                    sum[channel] += f64::from(pixel[channel]);
                }
            }
        }
        sum.map(|channel: f64| (channel / count) as f32)
    })
}

fn relative_square(i: f64, r: f64) -> f64 {
    (i - r) * (i - r) / (r * r + RELMSE_EPSILON)
}

fn mean_of(image: &Picture, reference: &Picture, error: impl Fn(f64, f64) -> f64) -> Result<f64, MetricError> {
    check_sizes(image, reference)?;
    check_finite(image, reference)?;
    let values = image.pixels.iter().flatten().zip(reference.pixels.iter().flatten());
    let sum: f64 = values.map(|(&i, &r)| error(f64::from(i), f64::from(r))).sum();
    Ok(sum / (3.0 * image.pixels.len() as f64))
}

fn is_finite(pixel: &[f32; 3]) -> bool {
    pixel.iter().all(|channel| channel.is_finite())
}

fn check_sizes(image: &Picture, reference: &Picture) -> Result<(), MetricError> {
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(MetricError::SizeMismatch {
            width: image.width,
            height: image.height,
            reference_width: reference.width,
            reference_height: reference.height,
        });
    }
    if image.pixels.is_empty() { Err(MetricError::Empty) } else { Ok(()) }
}

fn check_finite(image: &Picture, reference: &Picture) -> Result<(), MetricError> {
    match (image.non_finite(), reference.non_finite()) {
        (0, 0) => Ok(()),
        (image, reference) => Err(MetricError::NonFinite { image, reference }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(value: f32) -> Picture {
        Picture::from_fn(24, 20, |_, _| [value, 2.0 * value, 0.0])
    }

    #[test]
    fn relmse_and_mse_have_their_known_values() {
        let (image, reference) = (constant(1.1), constant(1.0));
        let expected = (0.01 / 1.01 + 0.04 / 4.01) / 3.0;
        assert!((relmse(&image, &reference).expect("equal sizes") - expected).abs() < 1e-8);
        assert!((mse(&image, &reference).expect("equal sizes") - 0.05 / 3.0).abs() < 1e-8);
        assert_eq!(relmse(&reference, &reference), Ok(0.0));
        // Black is not divided by zero.
        assert!((relmse(&constant(0.1), &constant(0.0)).expect("equal sizes") - 5.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn noise_of_a_known_variance_has_that_relmse() {
        // Hash noise, uniform in 1 ± 0.5: variance 1/12, over 1.01.
        let noise = |x: u32, y: u32, channel: u32| {
            let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ channel.wrapping_mul(0xc2b2_ae3d);
            h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
            h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
            0.5 + ((h ^ (h >> 15)) >> 8) as f32 / (1 << 24) as f32
        };
        let image = Picture::from_fn(256, 256, |x, y| [0, 1, 2].map(|channel| noise(x, y, channel)));
        let reference = Picture::from_fn(256, 256, |_, _| [1.0; 3]);
        let found = relmse(&image, &reference).expect("equal sizes");
        assert!((found * 12.0 * 1.01 - 1.0).abs() < 0.02, "{found}");
    }

    #[test]
    fn block_means_average_whole_and_partial_blocks() {
        let picture = Picture::from_fn(40, 17, |x, y| [x as f32, y as f32, 1.0]);
        let blocks = block_means(&picture, 16);
        assert_eq!((blocks.width, blocks.height), (3, 2));
        assert_eq!(blocks.pixels[0], [7.5, 7.5, 1.0]);
        assert_eq!(blocks.pixels[2], [35.5, 7.5, 1.0]);
        assert_eq!(blocks.pixels[5], [35.5, 16.0, 1.0]);
        assert_eq!(block_means(&picture, 1), picture);
        assert_eq!(block_means(&picture, 0), picture);
        let mean = picture.mean_colour();
        assert_eq!(block_means(&picture, 64).pixels, vec![mean.map(|channel| channel as f32)]);
    }

    #[test]
    fn sizes_that_differ_are_an_error_that_names_both() {
        let message =
            compare(&Picture::new(4, 3), &Picture::new(5, 2), PictureKind::Hdr).expect_err("differ").to_string();
        assert!(message.contains("4x3") && message.contains("5x2"), "{message}");
        let empty = Picture::new(0, 0);
        assert_eq!(relmse(&empty, &empty), Err(MetricError::Empty));
        assert_eq!(compare(&empty, &empty, PictureKind::Ldr), Err(MetricError::Empty));
    }

    #[test]
    fn bad_pixels_are_counted_and_never_count_as_agreement() {
        let reference = constant(0.5);
        let mut image = reference.clone();
        image.pixels[7][1] = f32::NAN;
        image.pixels[99][2] = f32::INFINITY;
        assert_eq!(relmse(&image, &reference), Err(MetricError::NonFinite { image: 2, reference: 0 }));
        assert!(flip::flip(&image, &reference, PictureKind::Ldr).is_err());
        for kind in [PictureKind::Ldr, PictureKind::Hdr] {
            let found = compare(&image, &reference, kind).expect("equal sizes");
            assert_eq!((found.image_non_finite, found.reference_non_finite), (2, 0));
            assert_eq!((found.relmse, found.mse, found.image_mean), (0.0, 0.0, found.reference_mean));
            assert!((found.flip - 2.0 / 480.0).abs() < 1e-6, "{}", found.flip);
        }
        let broken = constant(f32::NAN);
        let found = compare(&broken, &broken, PictureKind::Hdr).expect("equal sizes");
        assert_eq!((found.flip, found.relmse, found.reference_non_finite), (1.0, f64::INFINITY, 480));
    }
}
