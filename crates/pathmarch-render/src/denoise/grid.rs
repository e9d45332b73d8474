//! Box filters over the pixels of a picture.
//!
//! **Idea.** A sum over a square is a sum over a row, then over a column, each updated from pixel to pixel, so that the
//! cost does not depend on the radius. Running sums of a row start anew every [`RESTART`] pixels, so that rounding does
//! not add up.

use rayon::prelude::*;
use std::ops::{Add, Mul, Sub};

/// Pixels after which a running sum of a row starts anew.
const RESTART: usize = 128;
/// Least number of rows for a thread.
const MIN_ROWS: usize = 8;
/// Least total weight of a mean.
const MIN_WEIGHT: f32 = 1e-12;

/// Width and height of a picture, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub(super) width: usize,
    pub(super) height: usize,
}

/// Value that can be summed.
pub(super) trait Summable:
    Copy + Send + Sync + Default + Add<Output = Self> + Sub<Output = Self> + Mul<f32, Output = Self>
{
}
impl<T> Summable for T where T: Copy + Send + Sync + Default + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T> {}

impl Grid {
    /// Sums over the squares with side `2 * radius + 1` around all pixels, clipped at the border of the picture.
    pub(super) fn box_sums<T: Summable>(self, values: &[T], radius: usize) -> Vec<T> {
        let mut rows = vec![T::default(); values.len()];
        rows.par_chunks_mut(self.width)
            .zip(values.par_chunks(self.width))
            .for_each(|(sums, row)| sum_row(row, radius, sums));
        let mut sums = vec![T::default(); values.len()];
        let band = self.height.div_ceil(2 * rayon::current_num_threads()).max(MIN_ROWS);
        let bands = sums.par_chunks_mut(band * self.width).enumerate();
        bands.for_each(|(index, sums)| self.sum_columns(&rows, radius, index * band, sums));
        sums
    }

    /// Sums over the columns of `rows`, for the rows from `first` on that `sums` has room for.
    fn sum_columns<T: Summable>(self, rows: &[T], radius: usize, first: usize, sums: &mut [T]) {
        let Self { width, height } = self;
        let row = |y: usize| &rows[y * width..][..width];
        let mut running = vec![T::default(); width];
        for y in first.saturating_sub(radius)..(first + radius).min(height) {
            running.iter_mut().zip(row(y)).for_each(|(sum, value)| *sum = *sum + *value);
        }
        for (y, sums) in (first..).zip(sums.chunks_mut(width)) {
            if y + radius < height {
                running.iter_mut().zip(row(y + radius)).for_each(|(sum, value)| *sum = *sum + *value);
            }
            sums.copy_from_slice(&running);
            if y >= radius {
                running.iter_mut().zip(row(y - radius)).for_each(|(sum, value)| *sum = *sum - *value);
            }
        }
    }

    /// Weighted means over the same squares; zero where all weights are zero.
    pub(super) fn box_means<T: Summable>(self, values: &[T], weights: &[f32], radius: usize) -> Vec<T> {
        // Values without weight may be anything, NaN included.
        let weighted = |(value, weight): (&T, &f32)| if *weight > 0.0 { *value * *weight } else { T::default() };
        let weighted: Vec<T> = values.par_iter().zip(weights).map(weighted).collect();
        let totals = self.box_sums(weights, radius).into_par_iter();
        let mean = |(sum, total): (T, f32)| if total > MIN_WEIGHT { sum * total.recip() } else { T::default() };
        self.box_sums(&weighted, radius).into_par_iter().zip(totals).map(mean).collect()
    }
}

/// Sums of a row over `radius` pixels on both sides.
fn sum_row<T: Summable>(row: &[T], radius: usize, sums: &mut [T]) {
    for (start, sums) in (0..row.len()).step_by(RESTART).zip(sums.chunks_mut(RESTART)) {
        let before = &row[start.saturating_sub(radius)..(start + radius).min(row.len())];
        let mut running = before.iter().fold(T::default(), |sum, value| sum + *value);
        for (x, sum) in (start..).zip(sums) {
            if let Some(value) = row.get(x + radius) {
                running = running + *value;
            }
            *sum = running;
            if x >= radius {
                running = running - row[x - radius];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums by definition.
    fn slow_sums(grid: Grid, values: &[f32], radius: i64) -> Vec<f32> {
        let near = |a: usize, b: usize| (a as i64 - b as i64).abs() <= radius;
        let sum = |index: usize| {
            let (x, y) = (index % grid.width, index / grid.width);
            let others = values.iter().enumerate();
            others.filter(|(k, _)| near(k % grid.width, x) && near(k / grid.width, y)).map(|(_, value)| value).sum()
        };
        (0..values.len()).map(sum).collect()
    }

    #[test]
    fn sums_are_those_of_the_definition() {
        for (width, height) in [(1, 1), (5, 3), (300, 2), (1, 40), (37, 29)] {
            let grid = Grid { width, height };
            let values: Vec<f32> = (0..width * height).map(|k| ((k * 7919) % 64) as f32).collect();
            for radius in [0, 1, 4, 50] {
                let expected = slow_sums(grid, &values, radius as i64);
                assert_eq!(grid.box_sums(&values, radius), expected, "{width}x{height}, radius {radius}");
            }
        }
    }

    #[test]
    fn means_ignore_values_without_weight() {
        let grid = Grid { width: 3, height: 1 };
        assert_eq!(grid.box_means(&[2.0, f32::NAN, 4.0], &[1.0, 0.0, 1.0], 1), [2.0, 3.0, 4.0]);
        assert_eq!(grid.box_means(&[2.0, 100.0, 4.0], &[0.0; 3], 1), [0.0; 3]);
    }
}
