//! What lies beyond the scene: a constant, a gradient, or a picture of radiance.
//!
//! A picture is a light like others: a direction is drawn from it in proportion to its luminance (Pharr, Jakob and
//! Humphreys, "Physically Based Rendering", 4th ed. 2023, section 12.5), by two alias tables: one for the row, one in each
//! row for the column. What is drawn are the cells *between* the centres of texels, in which radiance is bilinear, each by
//! the mean of its four corners times its solid angle and uniformly within; so the density of a direction is the mean of
//! the four texels that its radiance is mixed of, over one number. Constants and gradients are found by the path alone,
//! which is as good where light comes from everywhere.

use super::alias::{self, Alias};
use super::lights::{luminance, met_weight};
use crate::settings::LightSearch;
use glam::Vec3;
use pathmarch_scene::{Environment, Scene, Sky as Source};
use std::f32::consts::{PI, TAU};

/// The sky as the CPU backend reads it.
#[derive(Clone, Debug)]
pub(crate) struct Sky {
    source: Source,
    cells: Option<Cells>,
    /// Density of a direction over the mean luminance of the four texels around it, the choice of the light included.
    density: f32,
}

/// A direction drawn from the sky's picture.
pub(crate) struct EnvironmentSample {
    pub(crate) direction: Vec3,
    pub(crate) radiance: Vec3,
    /// Over solid angle, the choice of the light included.
    pub(crate) pdf: f32,
}

/// The cells of a picture: `width` columns, `height + 1` rows.
#[derive(Clone, Debug)]
struct Cells {
    rows: Vec<Alias>,
    columns: Vec<Alias>,
    /// Integral of luminance over all directions.
    total: f64,
}

impl Sky {
    pub(crate) fn new(scene: &Scene) -> Self {
        let cells = match &scene.sky {
            Source::Map(environment) => Cells::new(environment),
            _ => None,
        };
        Self { source: scene.sky.clone(), cells, density: 0.0 }
    }

    /// Which of three forms it has; the numbers are those in `sky.wgsl`.
    pub(crate) fn form(&self) -> u32 {
        match self.source {
            Source::Constant(_) => 0,
            Source::Gradient { .. } => 1,
            Source::Map(_) => 2,
        }
    }

    /// Irradiance that the picture gives on average, for the choice among lights; 0 where it is not sampled.
    pub(crate) fn sampled_power(&self) -> f32 {
        self.cells.as_ref().map_or(0.0, |cells| 0.5 * cells.total as f32)
    }

    /// With what probability it is chosen among the lights.
    pub(crate) fn set_probability(&mut self, probability: f32) {
        self.density = self.cells.as_ref().map_or(0.0, |cells| (f64::from(probability) / cells.total) as f32);
    }

    pub(crate) fn density(&self) -> f32 {
        self.density
    }

    /// Radiance that a ray of this density found, weighed.
    pub(crate) fn found(&self, search: LightSearch, direction: Vec3, scatter_pdf: f32) -> Vec3 {
        match &self.source {
            Source::Map(environment) if self.density > 0.0 => {
                let (radiance, around) = around(environment, direction);
                radiance * met_weight(search, scatter_pdf, self.density * around)
            }
            source => Vec3::from(source.radiance(direction.into())),
        }
    }

    /// Radiance of a sky that is not sampled as a light.
    pub(crate) fn not_sampled(&self, direction: Vec3) -> Vec3 {
        if self.density > 0.0 { Vec3::ZERO } else { Vec3::from(self.source.radiance(direction.into())) }
    }

    /// A direction of the picture, in proportion to its luminance.
    pub(crate) fn sample(&self, [u, v]: [f32; 2]) -> Option<EnvironmentSample> {
        let (Source::Map(environment), Some(cells)) = (&self.source, &self.cells) else { return None };
        let (width, height) = (environment.width as usize, environment.height as f32);
        let (row, down) = alias::draw(&cells.rows, v);
        let (column, across) = alias::draw(&cells.columns[row * width..(row + 1) * width], u);
        let top = PI * (row as f32 - 0.5).max(0.0) / height;
        let bottom = PI * (row as f32 + 0.5).min(height) / height;
        let (high, low) = ((0.5 * top).sin().powi(2), (0.5 * bottom).sin().powi(2));
        // Half of one minus the cosine: uniform over the sphere, and exact close to straight up.
        let q = high + (low - high) * down;
        let (sine, cosine) = (TAU * (column as f32 + 0.5 + across) / width as f32).sin_cos();
        let radius = 2.0 * (q * (1.0 - q)).max(0.0).sqrt();
        let (x, y, z) = (radius * sine, 1.0 - 2.0 * q, -radius * cosine);
        let (s, c) = environment.rotate.rem_euclid(360.0).to_radians().sin_cos();
        let direction = Vec3::new(x * c + z * s, y, z * c - x * s).normalize();
        let (radiance, around) = around(environment, direction);
        Some(EnvironmentSample { direction, radiance, pdf: self.density * around })
    }

    /// The alias tables as the kernel reads them.
    pub(crate) fn tables(&self) -> Vec<u32> {
        let Some(cells) = &self.cells else { return Vec::new() };
        cells.rows.iter().chain(&cells.columns).flat_map(|&(threshold, alias)| [threshold.to_bits(), alias]).collect()
    }

    /// The picture as the kernel reads it.
    pub(crate) fn texels(&self) -> Vec<[f32; 4]> {
        match &self.source {
            Source::Map(environment) => environment.texels.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect(),
            _ => Vec::new(),
        }
    }
}

/// Radiance of a direction, and the mean luminance of the four texels around it.
fn around(environment: &Environment, direction: Vec3) -> (Vec3, f32) {
    let (radiance, corners) = environment.around(direction.into());
    (radiance.into(), 0.25 * corners.map(luminance).iter().sum::<f32>())
}

impl Cells {
    /// `None` where all is black.
    fn new(environment: &Environment) -> Option<Self> {
        let (width, height) = (environment.width as usize, environment.height as usize);
        let at = |column: usize, row: usize| f64::from(luminance(environment.texels[row * width + column % width]));
        let mut rows = Vec::with_capacity(height + 1);
        let mut columns = Vec::with_capacity((height + 1) * width);
        for row in 0..=height {
            let (upper, lower) = (row.saturating_sub(1), row.min(height - 1));
            let weights: Vec<f64> = (0..width)
                .map(|c| 0.25 * (at(c, upper) + at(c + 1, upper) + at(c, lower) + at(c + 1, lower)))
                .collect();
            let edge = |row: f64| (std::f64::consts::PI * row.clamp(0.0, height as f64) / height as f64).cos();
            let band = edge(row as f64 - 0.5) - edge(row as f64 + 0.5);
            rows.push(weights.iter().sum::<f64>() * band * std::f64::consts::TAU / width as f64);
            columns.extend(alias::table(&weights));
        }
        let total = rows.iter().sum::<f64>();
        (total > 0.0 && total.is_finite()).then(|| Self { rows: alias::table(&rows), columns, total })
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;
    use std::sync::Arc;

    fn sky() -> Sky {
        let (width, height) = (16, 8);
        let texels = (0..width * height)
            .map(|k| if k == 37 { [90.0, 80.0, 70.0] } else { [0.1 * (k % 7) as f32, 0.2, 0.05 * (k / 16) as f32] })
            .collect();
        let source = Source::Map(Arc::new(Environment { width, height, texels, rotate: 70.0 }));
        let Source::Map(environment) = &source else { unreachable!() };
        let cells = Cells::new(environment);
        let mut sky = Sky { source, cells, density: 0.0 };
        sky.set_probability(1.0);
        sky
    }

    /// Samples fall where the density says, cell by cell of a grid that is not that of the picture.
    #[test]
    fn directions_are_of_the_density_they_claim() {
        let sky = sky();
        let Source::Map(environment) = &sky.source else { unreachable!() };
        const N: u32 = 200_000;
        let bin = |d: Vec3| {
            let turn = (d.z.atan2(d.x) / TAU).rem_euclid(1.0);
            (((0.5 * (d.y + 1.0) * 10.0) as usize).min(9), ((turn * 20.0) as usize).min(19))
        };
        let mut counted = [[0.0f64; 20]; 10];
        let mut integral = 0.0f64;
        for k in 0..N {
            let sample = sky.sample(Random::new(1, 2, k, 3).pair(0)).expect("a picture");
            assert!((sample.direction.length() - 1.0).abs() < 1e-5 && sample.pdf > 0.0);
            let (row, column) = bin(sample.direction);
            counted[row][column] += 1.0 / f64::from(N);
            integral += f64::from(luminance(sample.radiance.into()) / sample.pdf) / f64::from(N);
        }
        let total = sky.cells.as_ref().expect("a picture").total;
        // Bilinear radiance differs a little from the mean of its corners, over the wide cells of this picture.
        assert!((integral / total - 1.0).abs() < 0.03, "{integral} {total}");
        let mut expected = [[0.0f64; 20]; 10];
        const FINE: usize = 1000;
        for k in 0..FINE * FINE {
            let y = 2.0 * (k / FINE) as f32 / FINE as f32 - 1.0 + 1.0 / FINE as f32;
            let (sine, cosine) = (TAU * ((k % FINE) as f32 + 0.5) / FINE as f32).sin_cos();
            let radius = (1.0 - y * y).sqrt();
            let d = Vec3::new(radius * cosine, y, radius * sine);
            let (row, column) = bin(d);
            expected[row][column] +=
                f64::from(sky.density * around(environment, d).1) * 4.0 * std::f64::consts::PI / (FINE * FINE) as f64;
        }
        for (counted, expected) in counted.iter().flatten().zip(expected.iter().flatten()) {
            assert!((counted - expected).abs() < 0.002 + 0.03 * expected, "{counted} {expected}");
        }
    }
}
