//! Regression: planes through the irradiance of a window, in the space of the features.
//!
//! **Idea.** Around a centre, irradiance is nearly a linear function of position in the picture, position in space,
//! normal and albedo. A weighted least-squares fit over a window finds the function, which predicts the pixels of the
//! window. Weights fall with the distance of the features, and with that of the irradiance where a former
//! [`Stage`] has filtered it already. The weights of one half come from the other one, so that they do not depend on the
//! noise that they weight. Centres are a few pixels apart, and each pixel is the mean of the predictions of all centres
//! around it; pixels that hardly any of them resembles have a fit of their own.
//!
//! **Source.** First-order regression with cross-filtered halves and collaborative prediction: Bitterli et al. 2016,
//! "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings". There every pixel is a centre,
//! and weights are those of non-local means; here they compare irradiance that is filtered already, which costs a
//! fraction of it.
//!
//! **Cost.** Multiplications in proportion to window over centres, times the square of the number of terms.

use super::grid::Grid;
use super::normal_equations::{Coefficients, NormalEquations, Terms};
use super::signal::{PixelClass, Signal, Surface, mean_channel};
use glam::Vec3;
use rayon::prelude::*;

/// Fits of one radius.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    /// Radius of the window, pixels.
    pub(super) radius: usize,
    /// Distance between centres, pixels.
    pub(super) stride: usize,
}

/// Weight of the squared distance of unit normals.
const NORMAL_WEIGHT: f32 = 4.0;
/// Weight of the squared distance from the plane of the surface, in radii of the window.
const PLANE_WEIGHT: f32 = 4.0;
/// Weight of the squared distance in space, in radii of the window.
const POSITION_WEIGHT: f32 = 0.05;
/// Weight of the squared difference of material hashes.
const MATERIAL_WEIGHT: f32 = 100.0;
/// Relative difference of irradiance that counts as much as a standard deviation.
const IRRADIANCE_FLOOR: f32 = 0.05;
/// Distance of features at which a weight ends.
const MAX_DISTANCE: f32 = 6.0;
/// Half the side of the square in which the variance of irradiance is estimated, pixels.
const VARIANCE_RADIUS: usize = 3;
/// Sum of weights of predictions below which a pixel gets a fit of its own.
const MIN_PREDICTION: f32 = 0.3;

/// Filtered irradiance of a former stage.
pub(super) struct Pilot {
    halves: [Vec<Vec3>; 2],
    /// Variance of a half, mean of the channels.
    variances: Vec<f32>,
}

impl Pilot {
    pub(super) fn new(signal: &Signal, halves: [Vec<Vec3>; 2]) -> Self {
        let both = halves[0].par_iter().zip(&halves[1]);
        let squares: Vec<f32> = both.map(|(a, b)| 0.5 * mean_channel((*a - *b) * (*a - *b))).collect();
        let variances = signal.grid.box_means(&squares, &signal.weights, VARIANCE_RADIUS);
        Self { halves, variances }
    }

    pub(super) fn into_halves(self) -> [Vec<Vec3>; 2] {
        self.halves
    }

    /// Squared distance of two pixels in standard deviations, in one half.
    #[inline(always)]
    fn distance(&self, half: usize, a: usize, b: usize) -> f32 {
        let (value_a, value_b) = (self.halves[half][a], self.halves[half][b]);
        let difference = value_a - value_b;
        let floor = 0.5 * IRRADIANCE_FLOOR * mean_channel(value_a + value_b);
        let variance = self.variances[a] + self.variances[b] + floor * floor;
        mean_channel(difference * difference) / variance.max(f32::MIN_POSITIVE)
    }
}

/// Pixel of a window.
struct Tap {
    index: usize,
    terms: Terms,
    /// Weights in the fits of both halves.
    weights: [f32; 2],
    /// False for a pixel that is only predicted.
    is_fitted: bool,
}

/// Sums of the weighted predictions of a pixel, and of their weights, for both halves.
type Predictions = [[f32; 4]; 2];

/// Fits of a stage.
pub(super) struct Regression<'a> {
    pub(super) signal: &'a Signal,
    /// Irradiance to fit.
    pub(super) halves: &'a [Vec<Vec3>; 2],
    pub(super) pilot: Option<&'a Pilot>,
    pub(super) stage: Stage,
}

impl Regression<'_> {
    /// Filtered halves.
    pub(super) fn filtered(&self) -> [Vec<Vec3>; 2] {
        let predictions = self.predictions();
        let value = |index: usize| self.filtered_pixel(index, &predictions[index]);
        let pixels: Vec<[Vec3; 2]> = (0..predictions.len()).into_par_iter().map(value).collect();
        [0, 1].map(|half: usize| pixels.par_iter().map(|pixel| pixel[half]).collect())
    }

    /// Both halves of a pixel with these predictions.
    fn filtered_pixel(&self, index: usize, predictions: &Predictions) -> [Vec3; 2] {
        let needs_fit = |[.., weight]: &[f32; 4]| *weight < MIN_PREDICTION;
        let own = match self.signal.surfaces[index].class {
            PixelClass::Source => None,
            _ if predictions.iter().any(needs_fit) => self.fit(index, &mut Vec::new()),
            _ => None,
        };
        [0, 1].map(|half: usize| {
            let [r, g, b, weight] = predictions[half];
            let (mut sum, mut total) = (Vec3::new(r, g, b), weight);
            if let Some(own) = own.as_ref().map(|own| &own[half]).filter(|_| needs_fit(&predictions[half])) {
                // The constant term is the prediction of the centre.
                let [r, g, b, _] = own[0];
                sum += Vec3::new(r, g, b);
                total += 1.0;
            }
            if total > 0.0 { sum / total } else { self.halves[half][index] }
        })
    }

    /// Predictions of all centres for all pixels. Bands of rows are computed apart, since windows overlap.
    fn predictions(&self) -> Vec<Predictions> {
        let Grid { width, height } = self.signal.grid;
        let Stage { radius, stride } = self.stage;
        let band = height.div_ceil(4 * rayon::current_num_threads()).next_multiple_of(stride);
        let bands: Vec<(usize, Vec<Predictions>)> = (0..height)
            .step_by(band)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|first| {
                let (top, bottom) = (first.saturating_sub(radius), (first + band + radius).min(height));
                let mut predictions = vec![Predictions::default(); (bottom - top) * width];
                self.predict_band(first..(first + band).min(height), top * width, &mut predictions);
                (top, predictions)
            })
            .collect();
        let mut all = vec![Predictions::default(); width * height];
        for (top, band) in bands {
            all[top * width..].par_iter_mut().zip(band).for_each(|(sums, more)| {
                sums.as_flattened_mut().iter_mut().zip(more.as_flattened()).for_each(|(sum, more)| *sum += more);
            });
        }
        all
    }

    /// Adds the predictions of the centres in some rows; `start` is the index of the first pixel of `predictions`.
    fn predict_band(&self, rows: std::ops::Range<usize>, start: usize, predictions: &mut [Predictions]) {
        let Stage { stride, .. } = self.stage;
        let mut taps = Vec::new();
        let centres = |from: usize, to: usize| (from..to).skip((stride / 2).min(to - from - 1)).step_by(stride);
        for y in centres(rows.start, rows.end) {
            for x in centres(0, self.signal.grid.width) {
                let Some(fits) = self.fit(y * self.signal.grid.width + x, &mut taps) else { continue };
                for tap in &taps {
                    let sums = &mut predictions[tap.index - start];
                    for half in 0..2 {
                        add_prediction(&fits[half], &tap.terms, tap.weights[half], &mut sums[half]);
                    }
                }
            }
        }
    }

    /// Fits of both halves around a centre, and the pixels of its window. `None` if no pixel can be fitted.
    fn fit(&self, centre: usize, taps: &mut Vec<Tap>) -> Option<[Coefficients; 2]> {
        self.collect_taps(centre, taps);
        let mut equations = [NormalEquations::default(), NormalEquations::default()];
        for tap in taps.iter().filter(|tap| tap.is_fitted) {
            for ((equations, weight), half) in equations.iter_mut().zip(tap.weights).zip(self.halves) {
                equations.add(&tap.terms, weight, half[tap.index]);
            }
        }
        let [first, second] = equations;
        Some([first.solve()?, second.solve()?])
    }

    /// Pixels of the window around a centre with weights above zero.
    fn collect_taps(&self, centre: usize, taps: &mut Vec<Tap>) {
        taps.clear();
        let here = &self.signal.surfaces[centre];
        if here.class == PixelClass::Source {
            return;
        }
        let Grid { width, height } = self.signal.grid;
        let radius = self.stage.radius;
        let (x, y) = (centre % width, centre / width);
        let inverse_radius = 1.0 / radius as f32;
        // The window ends one pixel beyond its radius.
        let shrink = (radius as f32 / (radius as f32 + 1.0)).powi(2);
        let inverse_length = 1.0 / (radius as f32 * here.footprint).max(f32::MIN_POSITIVE);
        for yy in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            for xx in x.saturating_sub(radius)..(x + radius + 1).min(width) {
                let index = yy * width + xx;
                let there = &self.signal.surfaces[index];
                let (dx, dy) = ((xx as f32 - x as f32) * inverse_radius, (yy as f32 - y as f32) * inverse_radius);
                let window = 1.0 - (dx * dx + dy * dy) * shrink;
                if window <= 0.0 || there.class == PixelClass::Source {
                    continue;
                }
                let offset = (there.position - here.position) * inverse_length;
                let distance = feature_distance(here, there, offset);
                if distance >= MAX_DISTANCE {
                    continue;
                }
                let weights = self.weights(centre, index, window, distance);
                if weights == [0.0; 2] {
                    continue;
                }
                let normal = there.normal - here.normal;
                let albedo = mean_channel(there.albedo - here.albedo);
                let terms = [1.0, dx, dy, normal.x, normal.y, normal.z, offset.x, offset.y, offset.z, albedo, 0.0, 0.0];
                taps.push(Tap { index, terms, weights, is_fitted: there.class == PixelClass::Surface });
            }
        }
    }

    /// Weights of a pixel in the fits of both halves, each from the pilot of the other half.
    #[inline(always)]
    fn weights(&self, centre: usize, index: usize, window: f32, distance: f32) -> [f32; 2] {
        let Some(pilot) = self.pilot else { return [window * falloff(distance); 2] };
        [1, 0].map(|other| window * falloff(distance + pilot.distance(other, centre, index)))
    }
}

/// Squared distance of the features of two pixels; `offset` is that of their positions, in radii of the window.
#[inline(always)]
fn feature_distance(here: &Surface, there: &Surface, offset: Vec3) -> f32 {
    let plane = offset.dot(here.normal).abs().max(offset.dot(there.normal).abs());
    let material = there.material - here.material;
    NORMAL_WEIGHT * (there.normal - here.normal).length_squared()
        + PLANE_WEIGHT * plane * plane
        + POSITION_WEIGHT * offset.length_squared()
        + MATERIAL_WEIGHT * material * material
}

/// Approximation of exp(-distance) that ends at 16; 0 for NaN.
#[inline(always)]
fn falloff(distance: f32) -> f32 {
    let base = (1.0 - distance * (1.0 / 16.0)).max(0.0);
    let fourth = base * base * base * base;
    let eighth = fourth * fourth;
    eighth * eighth
}

/// Adds the prediction of a fit for a pixel, and its weight.
#[inline(always)]
fn add_prediction(fit: &Coefficients, terms: &Terms, weight: f32, sums: &mut [f32; 4]) {
    let mut value = [0.0; 4];
    for (coefficients, term) in fit.iter().zip(terms) {
        (0..4).for_each(|k| value[k] += coefficients[k] * term);
    }
    (0..4).for_each(|k| sums[k] += weight * value[k]);
}
