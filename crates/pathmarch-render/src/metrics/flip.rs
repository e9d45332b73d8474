//! FLIP: perceived difference of each pixel when flipping between two pictures, from 0 (none) to 1.
//!
//! **Idea.** Two pipelines. *Colour*: filter both pictures by the contrast sensitivity of the eye at the viewing distance
//! (separate filters for lightness, red-green and blue-yellow), convert to CIELab with less chroma in the dark (Hunt effect),
//! compute the HyAB distance, compress. *Features*: compare the strengths of edges (first derivatives of a Gaussian) and
//! points (second derivatives) in lightness. A feature difference amplifies the colour difference: `colour ^ (1 - feature)`.
//!
//! HDR-FLIP: tone-map both pictures at exposures one stop or less apart and keep the largest error of each pixel. The
//! exposures range from the one that just shows the brightest pixel of the reference to the one that shows its median.
//!
//! **Source.** Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: A Difference Evaluator for
//! Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. (HPG) 2020. Andersson, Nilsson, Shirley, Akenine-Möller,
//! "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics Short Papers 2021. Tone curve: Narkowicz, "ACES
//! Filmic Tone Mapping Curve", 2016.
//!
//! **Differences.** The results are the same: the means of ten pairs agree with NVIDIA's `flip-evaluator` 1.7 within 1e-4. All
//! filters run as two one-dimensional passes: Gaussians and their axis derivatives are separable, and the blue-yellow
//! filter is a sum of two Gaussians. The papers do not define a reference without light; it is compared at exposure 0.
//!
//! **Cost.** About 270 multiply-adds for each pixel, picture and exposure, on all cores.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::{MetricError, check_finite, check_sizes, is_finite};
use crate::output::image::{Picture, PictureKind};

/// Pixels per degree of the visual field, 67.02: a display 0.7 m wide with 3840 pixels, viewed from 0.7 m.
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;

/// FLIP error of every pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Error of each pixel in 0..=1, the top row first.
    pub errors: Vec<f32>,
}

impl ErrorMap {
    /// Mean error, the usual figure for the whole picture.
    pub fn mean(&self) -> f64 {
        self.errors.iter().map(|&error| f64::from(error)).sum::<f64>() / self.errors.len().max(1) as f64
    }
}

/// FLIP error of a picture against a reference: FLIP for `Ldr` (linear light, clamped to 0..=1), HDR-FLIP for `Hdr`.
/// Negative radiance counts as 0.
///
/// # Errors
/// [`MetricError`]: different sizes, no pixels, pixels that are NaN or infinite.
pub fn flip(image: &Picture, reference: &Picture, kind: PictureKind) -> Result<ErrorMap, MetricError> {
    check_sizes(image, reference)?;
    check_finite(image, reference)?;
    Ok(error_map(image, reference, kind))
}

/// FLIP error of pictures of equal size, as [`flip`](self::flip). A pixel that is NaN or infinite in either picture has error
/// 1 and does not affect its neighbours.
pub(super) fn error_map(image: &Picture, reference: &Picture, kind: PictureKind) -> ErrorMap {
    let pairs = image.pixels.iter().zip(&reference.pixels).enumerate();
    let non_finite: Vec<usize> =
        pairs.filter(|(_, (p, q))| !is_finite(p) || !is_finite(q)).map(|(index, _)| index).collect();
    if non_finite.is_empty() {
        return error_map_of_finite(image, reference, kind);
    }
    let (mut image, mut reference) = (image.clone(), reference.clone());
    for &index in &non_finite {
        image.pixels[index] = [0.0; 3];
        reference.pixels[index] = [0.0; 3];
    }
    let mut map = error_map_of_finite(&image, &reference, kind);
    for index in non_finite {
        map.errors[index] = 1.0;
    }
    map
}

fn error_map_of_finite(image: &Picture, reference: &Picture, kind: PictureKind) -> ErrorMap {
    let filters = Filters::new(PIXELS_PER_DEGREE);
    let mut errors = vec![0.0f32; image.pixels.len()];
    let mut accumulate = |light: &(dyn Fn(f32) -> f32 + Sync)| {
        let (tested, expected) = (filters.apply(image, light), filters.apply(reference, light));
        errors.par_iter_mut().enumerate().for_each(|(index, error)| {
            *error = error.max(tested.difference(&expected, index));
        });
    };
    match kind {
        PictureKind::Ldr => accumulate(&|channel| channel.clamp(0.0, 1.0)),
        PictureKind::Hdr => {
            for exposure_stops in exposures(reference) {
                let gain = exposure_stops.exp2();
                accumulate(&|channel| aces(channel.max(0.0) * gain));
            }
        }
    }
    ErrorMap { width: image.width, height: image.height, errors }
}

// ---- HDR: tone curve and exposures -----------------------------------------------------------------------------------

/// Narkowicz's fit of the ACES curve, (a x² + b x) / (c x² + d x + e); the terms include his exposure of 0.6.
const ACES: [f32; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];
/// Display value at which a luminance counts as just visible.
const VISIBLE: f32 = 0.85;

fn aces(x: f32) -> f32 {
    let [a, b, c, d, e] = ACES;
    // Beyond this the curve exceeds 1, and the squares would overflow.
    let x = x.min(1e6);
    ((a * x + b) * x / ((c * x + d) * x + e)).clamp(0.0, 1.0)
}

/// Exposures of HDR-FLIP, stops.
fn exposures(reference: &Picture) -> Vec<f32> {
    let [a, b, c, d, e] = ACES;
    // Positive root of aces(x) = VISIBLE.
    let (square, linear, constant) = (a - VISIBLE * c, b - VISIBLE * d, -VISIBLE * e);
    let visible_at = (-linear + (linear * linear - 4.0 * square * constant).sqrt()) / (2.0 * square);

    let clamped = reference.pixels.iter().map(|pixel| pixel.map(|channel| channel.max(0.0)));
    let mut luminances: Vec<f32> = clamped.map(luminance).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    let brightest = luminances.last().copied().unwrap_or(0.0);
    if brightest <= 0.0 {
        return vec![0.0];
    }
    let middle = luminances.len() / 2;
    let median = if luminances.len() % 2 == 1 {
        luminances[middle]
    } else {
        0.5 * (luminances[middle - 1] + luminances[middle])
    };
    // No exposure shows a median of 0; NVIDIA's implementation uses the same lower limit.
    let start = (visible_at / brightest.max(f32::EPSILON)).log2();
    let stop = (visible_at / median.max(f32::EPSILON)).log2().max(start);
    let count = (stop - start).ceil().max(2.0) as usize;
    (0..count).map(|index| start + (stop - start) * index as f32 / (count - 1) as f32).collect()
}

// ---- Colour ----------------------------------------------------------------------------------------------------------

/// Linear Rec. 709 to CIE XYZ (rows), from the primaries and the white point D65 of Rec. 709.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_390_8, 0.357_584_33, 0.180_480_8],
    [0.212_639, 0.715_168_65, 0.072_192_32],
    [0.019_330_818, 0.119_194_78, 0.950_532_14],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383_2, -0.498_610_76],
    [-0.969_243_65, 1.875_967_5, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];
/// XYZ of Rec. 709 white.
const WHITE: [f32; 3] = [0.950_455_9, 1.0, 1.089_057_8];

/// Exponent of the colour difference.
const COLOUR_EXPONENT: f32 = 0.7;
/// Differences below this fraction of the largest one map to errors below [`KNEE_ERROR`].
const KNEE_DIFFERENCE: f32 = 0.4;
/// Error at the knee of the compression.
const KNEE_ERROR: f32 = 0.95;
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f32 = 0.5;

fn transform(rows: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn luminance(rgb: [f32; 3]) -> f32 {
    transform(&XYZ_FROM_RGB, rgb)[1]
}

/// Converts linear RGB to YCxCz, which is CIELab without the cube root: lightness, red-green, blue-yellow.
fn ycxcz(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = transform(&XYZ_FROM_RGB, rgb);
    let (x, z) = (x / WHITE[0], z / WHITE[2]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn rgb_from_ycxcz([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    transform(&RGB_FROM_XYZ, [(y + cx / 500.0) * WHITE[0], y, (y - cz / 200.0) * WHITE[2]])
}

/// Converts linear RGB to CIELab with chroma scaled by lightness (Hunt effect).
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let root = |t: f32| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = transform(&XYZ_FROM_RGB, rgb);
    let [x, y, z] = [x / WHITE[0], y, z / WHITE[2]].map(root);
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// HyAB distance: city-block between lightness and chroma, Euclidean within chroma.
fn hyab(p: [f32; 3], q: [f32; 3]) -> f32 {
    (p[0] - q[0]).abs() + (p[1] - q[1]).hypot(p[2] - q[2])
}

/// Compresses a colour difference to 0..=1; small differences cover most of the range.
fn colour_error(distance: f32, largest: f32) -> f32 {
    let difference = distance.powf(COLOUR_EXPONENT);
    let knee = KNEE_DIFFERENCE * largest;
    if difference < knee {
        KNEE_ERROR / knee * difference
    } else {
        KNEE_ERROR + (difference - knee) / (largest - knee) * (1.0 - KNEE_ERROR)
    }
}

// ---- Filters ---------------------------------------------------------------------------------------------------------

/// One-dimensional, centred filter of odd length.
type Kernel = Vec<f32>;

/// Filters of one viewing distance.
struct Filters {
    /// Contrast sensitivity filters: a Gaussian each for lightness and red-green, a weighted sum of two for blue-yellow.
    lightness: Kernel,
    red_green: Kernel,
    blue_yellow: [(f32, Kernel); 2],
    /// Gaussian of the width of a feature, and its first and second derivative.
    smooth: Kernel,
    edge: Kernel,
    point: Kernel,
    /// Largest colour difference, that of green and blue, to the power of [`COLOUR_EXPONENT`].
    largest_difference: f32,
}

impl Filters {
    fn new(pixels_per_degree: f32) -> Self {
        // Gaussians a sqrt(π/b) exp(-π² d² / b), d in degrees; all are truncated at three deviations of b = 0.04.
        let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
        let gaussian = |b: f32| {
            let weight = |x: f32| (-(PI * x / pixels_per_degree).powi(2) / b).exp();
            (sampled(radius, weight), sampled(radius, weight).iter().sum::<f32>().powi(2))
        };
        let sum_of = |[(a1, b1), (a2, b2)]: [(f32, f32); 2]| {
            let ((kernel1, volume1), (kernel2, volume2)) = (gaussian(b1), gaussian(b2));
            let (weight1, weight2) = (a1 * (PI / b1).sqrt() * volume1, a2 * (PI / b2).sqrt() * volume2);
            let total = weight1 + weight2;
            [(weight1 / total, normalised(kernel1)), (weight2 / total, normalised(kernel2))]
        };

        let deviation = 0.5 * 0.082 * pixels_per_degree;
        let feature_radius = (3.0 * deviation).ceil();
        let gaussian_weight = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        let (green, blue) = (hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0]));
        Filters {
            lightness: normalised(gaussian(0.0047).0),
            red_green: normalised(gaussian(0.0053).0),
            blue_yellow: sum_of([(34.1, 0.04), (13.5, 0.025)]),
            smooth: normalised(sampled(feature_radius, gaussian_weight)),
            edge: normalised(sampled(feature_radius, |x| -x * gaussian_weight(x))),
            point: normalised(sampled(feature_radius, |x| {
                (x * x / (deviation * deviation) - 1.0) * gaussian_weight(x)
            })),
            largest_difference: hyab(green, blue).powf(COLOUR_EXPONENT),
        }
    }

    /// Filters a picture; `light` maps each channel to display light.
    fn apply(&self, picture: &Picture, light: &(dyn Fn(f32) -> f32 + Sync)) -> Filtered {
        let width = picture.width as usize;
        let count = picture.pixels.len();
        let [mut y, mut cx, mut cz] = [vec![0.0; count], vec![0.0; count], vec![0.0; count]];
        let rows = y.par_chunks_mut(width).zip(cx.par_chunks_mut(width)).zip(cz.par_chunks_mut(width));
        rows.zip(picture.pixels.par_chunks(width)).for_each(|(((y, cx), cz), pixels)| {
            for (column, &pixel) in pixels.iter().enumerate() {
                [y[column], cx[column], cz[column]] = ycxcz(pixel.map(light));
            }
        });

        let [(weight1, kernel1), (weight2, kernel2)] = &self.blue_yellow;
        let blurred = |plane: &[f32], kernel: &Kernel| along_columns(&along_rows(plane, width, kernel), width, kernel);
        let blurred_y = blurred(&y, &self.lightness);
        let blurred_cx = blurred(&cx, &self.red_green);
        let (blurred_cz1, blurred_cz2) = (blurred(&cz, kernel1), blurred(&cz, kernel2));
        let mut lab = vec![[0.0; 3]; count];
        lab.par_iter_mut().enumerate().for_each(|(i, lab)| {
            let blurred_cz = weight1 * blurred_cz1[i] + weight2 * blurred_cz2[i];
            let rgb = rgb_from_ycxcz([blurred_y[i], blurred_cx[i], blurred_cz]);
            *lab = hunt_lab(rgb.map(|channel| channel.clamp(0.0, 1.0)));
        });

        let smooth_along_rows = along_rows(&y, width, &self.smooth);
        let strength = |derivative: &Kernel| {
            let mut across = along_columns(&along_rows(&y, width, derivative), width, &self.smooth);
            let down = along_columns(&smooth_along_rows, width, derivative);
            // Lightness in 0..=1; the derivative of the offset 16 is zero.
            across.par_iter_mut().zip(down).for_each(|(a, d)| *a = (*a * *a + d * d).sqrt() / 116.0);
            across
        };
        let (edges, points) = (strength(&self.edge), strength(&self.point));
        Filtered { lab, edges, points, largest_difference: self.largest_difference }
    }
}

/// Filtered picture.
struct Filtered {
    /// Blurred, Hunt-adjusted CIELab.
    lab: Vec<[f32; 3]>,
    /// Strength of edges and of points in lightness.
    edges: Vec<f32>,
    points: Vec<f32>,
    largest_difference: f32,
}

impl Filtered {
    /// FLIP error of pixel `i` against the reference.
    fn difference(&self, expected: &Filtered, i: usize) -> f32 {
        let colour = colour_error(hyab(self.lab[i], expected.lab[i]), self.largest_difference);
        let edges = (self.edges[i] - expected.edges[i]).abs();
        let points = (self.points[i] - expected.points[i]).abs();
        let feature = (edges.max(points) / 2.0f32.sqrt()).powf(FEATURE_EXPONENT).min(1.0);
        colour.powf(1.0 - feature).clamp(0.0, 1.0)
    }
}

/// Samples a function at the integers from `-radius` to `radius`.
fn sampled(radius: f32, weight: impl Fn(f32) -> f32) -> Kernel {
    let radius = radius as i32;
    (-radius..=radius).map(|x| weight(x as f32)).collect()
}

/// Scales the positive weights to sum to 1 and the negative ones to -1; drops tails that are negligible in 32-bit floats.
fn normalised(mut kernel: Kernel) -> Kernel {
    let positive: f32 = kernel.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = -kernel.iter().filter(|weight| **weight < 0.0).sum::<f32>();
    for weight in &mut kernel {
        *weight /= if *weight > 0.0 { positive } else { negative.max(f32::MIN_POSITIVE) };
    }
    let radius = kernel.len() / 2;
    let tail = kernel.iter().take(radius).take_while(|weight| weight.abs() < 1e-8).count();
    kernel[tail..2 * radius + 1 - tail].to_vec()
}

/// Filters every row; pixels beyond the border repeat those on it.
fn along_rows(plane: &[f32], width: usize, kernel: &Kernel) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).zip(plane.par_chunks(width)).for_each_init(
        Vec::new,
        |padded: &mut Vec<f32>, (out, row)| {
            padded.clear();
            padded.resize(radius, row[0]);
            padded.extend_from_slice(row);
            padded.resize(width + 2 * radius, row[width - 1]);
            for (tap, &weight) in kernel.iter().enumerate() {
                add_scaled(out, &padded[tap..tap + width], weight);
            }
        },
    );
    out
}

/// Filters every column; pixels beyond the border repeat those on it.
fn along_columns(plane: &[f32], width: usize, kernel: &Kernel) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let last_row = (plane.len() / width).saturating_sub(1);
    let mut out = vec![0.0; plane.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for (tap, &weight) in kernel.iter().enumerate() {
            let row = (y + tap).saturating_sub(radius).min(last_row);
            add_scaled(out, &plane[row * width..(row + 1) * width], weight);
        }
    });
    out
}

fn add_scaled(out: &mut [f32], row: &[f32], weight: f32) {
    for (out, value) in out.iter_mut().zip(row) {
        *out += weight * value;
    }
}
