//! Light of the sky: a constant, a gradient or an environment map.
//!
//! An environment map is sampled like other lights, in proportion to its luminance (Pharr, Jakob and Humphreys,
//! "Physically Based Rendering", 4th ed. 2023, section 12.5). One alias table chooses the row, and one table for each
//! row chooses the column. Cells lie *between* the centres of texels, where radiance is bilinear. The probability of a
//! cell is proportional to the mean of its four corners times its solid angle; within a cell, samples are uniform. So
//! the pdf of a direction is proportional to the mean of the four texels around it. Constants and gradients are not
//! sampled: BSDF sampling is as good where light arrives from everywhere.

use super::light::luminance;
use crate::sampling::alias_table::{self, Cell};
use glam::Vec3;
use pathmarch_scene::{Environment, Scene, Sky};
use std::f32::consts::{PI, TAU};

/// Sky with its sampling tables.
#[derive(Clone, Debug)]
pub(crate) struct SkyLight {
    source: Sky,
    distribution: Option<EnvironmentDistribution>,
    /// Pdf of a direction divided by the mean luminance of the four texels around it, the choice of the light included.
    pdf_scale: f32,
}

/// Sampled direction of the environment map.
pub(crate) struct EnvironmentSample {
    /// Unit vector in world space.
    pub(crate) direction: Vec3,
    /// Radiance, W/(m² sr).
    pub(crate) radiance: Vec3,
    /// Pdf over solid angle, the choice of the light included.
    pub(crate) pdf: f32,
}

/// Sampling tables of an environment map: `width` columns and `height + 1` rows of cells.
#[derive(Clone, Debug)]
struct EnvironmentDistribution {
    /// Alias table of the rows.
    rows: Vec<Cell>,
    /// Alias tables of the columns, row by row.
    columns: Vec<Cell>,
    /// Integral of luminance over all directions.
    integral: f64,
}

impl SkyLight {
    pub(crate) fn new(scene: &Scene) -> Self {
        let distribution = match &scene.sky {
            Sky::Map(environment) => EnvironmentDistribution::new(environment),
            _ => None,
        };
        Self { source: scene.sky.clone(), distribution, pdf_scale: 0.0 }
    }

    /// Mean irradiance of the environment map, W/m², its weight in the choice of lights; 0 for a sky that is not
    /// sampled.
    pub(crate) fn sampled_power(&self) -> f32 {
        self.distribution.as_ref().map_or(0.0, |distribution| 0.5 * distribution.integral as f32)
    }

    /// Sets the probability of choosing the environment map among the lights.
    pub(crate) fn set_probability(&mut self, probability: f32) {
        self.pdf_scale = self
            .distribution
            .as_ref()
            .map_or(0.0, |distribution| (f64::from(probability) / distribution.integral) as f32);
    }

    /// Pdf of a direction divided by the mean luminance of the four texels around it, the choice of the light included.
    pub(crate) fn pdf_scale(&self) -> f32 {
        self.pdf_scale
    }

    /// Radiance of a direction, W/(m² sr), and the pdf of light sampling over solid angle; no pdf for a sky that is not
    /// sampled.
    #[inline]
    pub(crate) fn radiance(&self, direction: Vec3) -> (Vec3, Option<f32>) {
        match &self.source {
            Sky::Map(environment) if self.pdf_scale > 0.0 => {
                let (radiance, luminance) = bilinear_lookup(environment, direction);
                (radiance, Some(self.pdf_scale * luminance))
            }
            source => (Vec3::from(source.radiance(direction.into())), None),
        }
    }

    /// Samples a direction of the environment map in proportion to its luminance.
    pub(crate) fn sample(&self, [u, v]: [f32; 2]) -> Option<EnvironmentSample> {
        let (Sky::Map(environment), Some(distribution)) = (&self.source, &self.distribution) else { return None };
        let (width, height) = (environment.width as usize, environment.height as f32);
        let (row, v_in_row) = alias_table::sample(&distribution.rows, v);
        let (column, u_in_column) = alias_table::sample(&distribution.columns[row * width..(row + 1) * width], u);
        let top = PI * (row as f32 - 0.5).max(0.0) / height;
        let bottom = PI * (row as f32 + 0.5).min(height) / height;
        let (q_top, q_bottom) = ((0.5 * top).sin().powi(2), (0.5 * bottom).sin().powi(2));
        // (1 - cosine)/2 of the polar angle: uniform over the sphere, and exact near the zenith.
        let q = q_top + (q_bottom - q_top) * v_in_row;
        let (sine, cosine) = (TAU * (column as f32 + 0.5 + u_in_column) / width as f32).sin_cos();
        let radius = 2.0 * (q * (1.0 - q)).max(0.0).sqrt();
        let (x, y, z) = (radius * sine, 1.0 - 2.0 * q, -radius * cosine);
        let (sin_rotation, cos_rotation) = environment.rotate.rem_euclid(360.0).to_radians().sin_cos();
        let direction =
            Vec3::new(x * cos_rotation + z * sin_rotation, y, z * cos_rotation - x * sin_rotation).normalize();
        let (radiance, luminance) = bilinear_lookup(environment, direction);
        Some(EnvironmentSample { direction, radiance, pdf: self.pdf_scale * luminance })
    }

    /// Alias tables of the environment map's rows and columns; empty for other skies.
    pub(crate) fn alias_tables(&self) -> impl Iterator<Item = &Cell> {
        self.distribution.iter().flat_map(|distribution| distribution.rows.iter().chain(&distribution.columns))
    }

    /// Environment map; `None` for other skies.
    pub(crate) fn environment(&self) -> Option<&Environment> {
        match &self.source {
            Sky::Map(environment) => Some(environment),
            _ => None,
        }
    }

    /// Radiance of a sky that is the same in all directions, W/(m² sr).
    #[inline]
    pub(crate) fn constant(&self) -> Option<[f32; 3]> {
        match self.source {
            Sky::Constant(radiance) => Some(radiance),
            _ => None,
        }
    }

    /// Reports whether the sky is a gradient.
    pub(crate) fn is_gradient(&self) -> bool {
        matches!(self.source, Sky::Gradient { .. })
    }
}

/// Radiance of a direction, W/(m² sr), and the mean luminance of the four texels around it.
fn bilinear_lookup(environment: &Environment, direction: Vec3) -> (Vec3, f32) {
    let (radiance, corners) = environment.around(direction.into());
    (radiance.into(), 0.25 * corners.map(luminance).iter().sum::<f32>())
}

impl EnvironmentDistribution {
    /// Builds the tables; `None` for a black map.
    fn new(environment: &Environment) -> Option<Self> {
        let (width, height) = (environment.width as usize, environment.height as usize);
        let luminance_at =
            |column: usize, row: usize| f64::from(luminance(environment.texels[row * width + column % width]));
        let mut rows = Vec::with_capacity(height + 1);
        let mut columns = Vec::with_capacity((height + 1) * width);
        for row in 0..=height {
            let (upper, lower) = (row.saturating_sub(1), row.min(height - 1));
            let weights: Vec<f64> = (0..width)
                .map(|c| {
                    0.25 * (luminance_at(c, upper)
                        + luminance_at(c + 1, upper)
                        + luminance_at(c, lower)
                        + luminance_at(c + 1, lower))
                })
                .collect();
            let cos_polar = |row: f64| (std::f64::consts::PI * row.clamp(0.0, height as f64) / height as f64).cos();
            let cos_extent = cos_polar(row as f64 - 0.5) - cos_polar(row as f64 + 0.5);
            rows.push(weights.iter().sum::<f64>() * cos_extent * std::f64::consts::TAU / width as f64);
            columns.extend(alias_table::table(&weights));
        }
        let integral = rows.iter().sum::<f64>();
        (integral > 0.0 && integral.is_finite()).then(|| Self { rows: alias_table::table(&rows), columns, integral })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::sobol::PixelSampler;
    use std::sync::Arc;

    fn sky() -> SkyLight {
        let (width, height) = (16, 8);
        let texels = (0..width * height)
            .map(|k| if k == 37 { [90.0, 80.0, 70.0] } else { [0.1 * (k % 7) as f32, 0.2, 0.05 * (k / 16) as f32] })
            .collect();
        let source = Sky::Map(Arc::new(Environment { width, height, texels, rotate: 70.0 }));
        let Sky::Map(environment) = &source else { unreachable!() };
        let distribution = EnvironmentDistribution::new(environment);
        let mut sky = SkyLight { source, distribution, pdf_scale: 0.0 };
        sky.set_probability(1.0);
        sky
    }

    /// Compares counts of samples with the integral of the pdf, in the cells of a grid that differs from the map's.
    #[test]
    fn directions_follow_their_pdf() {
        let sky = sky();
        let Sky::Map(environment) = &sky.source else { unreachable!() };
        const N: u32 = 200_000;
        let bin = |d: Vec3| {
            let azimuth = (d.z.atan2(d.x) / TAU).rem_euclid(1.0);
            (((0.5 * (d.y + 1.0) * 10.0) as usize).min(9), ((azimuth * 20.0) as usize).min(19))
        };
        let mut counted = [[0.0f64; 20]; 10];
        let mut estimate = 0.0f64;
        for k in 0..N {
            let sample = sky.sample(PixelSampler::new(1, 2, k, 3).sample_2d(0)).expect("a picture");
            assert!((sample.direction.length() - 1.0).abs() < 1e-5 && sample.pdf > 0.0);
            let (row, column) = bin(sample.direction);
            counted[row][column] += 1.0 / f64::from(N);
            estimate += f64::from(luminance(sample.radiance.into()) / sample.pdf) / f64::from(N);
        }
        let integral = sky.distribution.as_ref().expect("a picture").integral;
        // The cells of this map are wide, so that bilinear radiance differs a little from the mean of its corners.
        assert!((estimate / integral - 1.0).abs() < 0.03, "{estimate} {integral}");
        let mut expected = [[0.0f64; 20]; 10];
        const FINE: usize = 1000;
        for k in 0..FINE * FINE {
            let y = 2.0 * (k / FINE) as f32 / FINE as f32 - 1.0 + 1.0 / FINE as f32;
            let (sine, cosine) = (TAU * ((k % FINE) as f32 + 0.5) / FINE as f32).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            let d = Vec3::new(radius * cosine, y, radius * sine);
            let (row, column) = bin(d);
            expected[row][column] +=
                f64::from(sky.pdf_scale * bilinear_lookup(environment, d).1) * 4.0 * std::f64::consts::PI
                    / (FINE * FINE) as f64;
        }
        for (counted, expected) in counted.iter().flatten().zip(expected.iter().flatten()) {
            assert!((counted - expected).abs() < 0.002 + 0.03 * expected, "{counted} {expected}");
        }
    }
}
