//! Light of the sky: a constant, a gradient, or an environment map.
//!
//! An environment map is sampled like other lights, in proportion to its luminance (Pharr, Jakob and Humphreys, "Physically
//! Based Rendering", 4th ed. 2023, section 12.5), by two alias tables: one for the row, one in each row for the column. The
//! samples choose cells *between* the centres of texels, in which radiance is bilinear, each in proportion to the mean of its
//! four corners times its solid angle, and uniformly within the cell. So the pdf of a direction is proportional to the mean of
//! the four texels around it. Constants and gradients are found by paths alone, which is as good where light comes from
//! everywhere.

use super::light::luminance;
use crate::sampling::alias_table::{self, Cell};
use glam::Vec3;
use pathmarch_scene::{Environment, Scene, Sky};
use std::f32::consts::{PI, TAU};

/// Sky with its sampling tables.
#[derive(Clone, Debug)]
pub(crate) struct SkyLight {
    source: Sky,
    cells: Option<Cells>,
    /// Pdf of a direction over the mean luminance of the four texels around it, the choice of the light included.
    density: f32,
}

/// Direction sampled from the environment map.
pub(crate) struct EnvironmentSample {
    pub(crate) direction: Vec3,
    pub(crate) radiance: Vec3,
    /// Over solid angle, the choice of the light included.
    pub(crate) pdf: f32,
}

/// Cells of an environment map: `width` columns, `height + 1` rows.
#[derive(Clone, Debug)]
struct Cells {
    rows: Vec<Cell>,
    columns: Vec<Cell>,
    /// Integral of luminance over all directions.
    total: f64,
}

impl SkyLight {
    pub(crate) fn new(scene: &Scene) -> Self {
        let cells = match &scene.sky {
            Sky::Map(environment) => Cells::new(environment),
            _ => None,
        };
        Self { source: scene.sky.clone(), cells, density: 0.0 }
    }

    /// Mean irradiance of the environment map, W/m², for the choice among lights; 0 where it is not sampled.
    pub(crate) fn sampled_power(&self) -> f32 {
        self.cells.as_ref().map_or(0.0, |cells| 0.5 * cells.total as f32)
    }

    /// Sets the probability with which it is chosen among the lights.
    pub(crate) fn set_probability(&mut self, probability: f32) {
        self.density = self.cells.as_ref().map_or(0.0, |cells| (f64::from(probability) / cells.total) as f32);
    }

    pub(crate) fn density(&self) -> f32 {
        self.density
    }

    /// Radiance of a direction, W/(m² sr), and the pdf with which light sampling chooses it, over solid angle; no pdf where
    /// the sky is not a light that is sampled.
    pub(crate) fn radiance(&self, direction: Vec3) -> (Vec3, Option<f32>) {
        match &self.source {
            Sky::Map(environment) if self.density > 0.0 => {
                let (radiance, around) = around(environment, direction);
                (radiance, Some(self.density * around))
            }
            source => (Vec3::from(source.radiance(direction.into())), None),
        }
    }

    /// Samples a direction of the environment map in proportion to its luminance.
    pub(crate) fn sample(&self, [u, v]: [f32; 2]) -> Option<EnvironmentSample> {
        let (Sky::Map(environment), Some(cells)) = (&self.source, &self.cells) else { return None };
        let (width, height) = (environment.width as usize, environment.height as f32);
        let (row, down) = alias_table::draw(&cells.rows, v);
        let (column, across) = alias_table::draw(&cells.columns[row * width..(row + 1) * width], u);
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

    /// Alias tables of the environment map's rows and columns; empty for other skies.
    pub(crate) fn alias_tables(&self) -> impl Iterator<Item = &Cell> {
        self.cells.iter().flat_map(|cells| cells.rows.iter().chain(&cells.columns))
    }

    /// Environment map, where the sky is one.
    pub(crate) fn environment(&self) -> Option<&Environment> {
        match &self.source {
            Sky::Map(environment) => Some(environment),
            _ => None,
        }
    }

    /// Whether the sky is a gradient.
    pub(crate) fn is_gradient(&self) -> bool {
        matches!(self.source, Sky::Gradient { .. })
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
            columns.extend(alias_table::table(&weights));
        }
        let total = rows.iter().sum::<f64>();
        (total > 0.0 && total.is_finite()).then(|| Self { rows: alias_table::table(&rows), columns, total })
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
        let cells = Cells::new(environment);
        let mut sky = SkyLight { source, cells, density: 0.0 };
        sky.set_probability(1.0);
        sky
    }

    /// Samples fall where the density says, cell by cell of a grid that is not that of the picture.
    #[test]
    fn directions_are_of_the_density_they_claim() {
        let sky = sky();
        let Sky::Map(environment) = &sky.source else { unreachable!() };
        const N: u32 = 200_000;
        let bin = |d: Vec3| {
            let turn = (d.z.atan2(d.x) / TAU).rem_euclid(1.0);
            (((0.5 * (d.y + 1.0) * 10.0) as usize).min(9), ((turn * 20.0) as usize).min(19))
        };
        let mut counted = [[0.0f64; 20]; 10];
        let mut integral = 0.0f64;
        for k in 0..N {
            let sample = sky.sample(PixelSampler::new(1, 2, k, 3).pair(0)).expect("a picture");
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
