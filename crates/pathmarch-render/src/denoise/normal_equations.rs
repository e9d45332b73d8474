//! Normal equations of a weighted least-squares fit of three channels, solved by Cholesky decomposition.

use glam::Vec3;

/// Number of terms of the linear function; a multiple of four, for SIMD.
pub(super) const TERMS: usize = 12;
/// Number of terms in use; the others are zero.
const USED_TERMS: usize = 10;
/// Ridge relative to the sum of weights: where features hardly vary, slopes are zero instead of noise.
const RIDGE: f32 = 3e-4;
/// Least pivot relative to the sum of weights.
const MIN_PIVOT: f32 = 1e-6;

/// Least sum of weights of a fit.
const MIN_TOTAL: f32 = 1e-3;

/// Terms of the linear function at a pixel; the first is 1.
pub(super) type Terms = [f32; TERMS];
/// Coefficients of each term for the three channels; the last column is that of the constant 1.
pub(super) type Coefficients = [[f32; 4]; TERMS];

/// Sums of the weighted products of terms with each other and with the values.
#[derive(Default)]
pub(super) struct NormalEquations {
    matrix: [Terms; USED_TERMS],
    right_sides: [Terms; 3],
}

impl NormalEquations {
    /// Adds a pixel.
    #[inline(always)]
    pub(super) fn add(&mut self, terms: &Terms, weight: f32, value: Vec3) {
        for (row, term) in self.matrix.iter_mut().zip(terms) {
            let scale = weight * term;
            (0..TERMS).for_each(|k| row[k] += scale * terms[k]);
        }
        for (side, value) in self.right_sides.iter_mut().zip(value.to_array()) {
            let scale = weight * value;
            (0..TERMS).for_each(|k| side[k] += scale * terms[k]);
        }
    }

    /// Coefficients of the fit; `None` if hardly anything was added.
    pub(super) fn solve(mut self) -> Option<Coefficients> {
        let total = self.matrix[0][0];
        if total.is_nan() || total <= MIN_TOTAL {
            return None;
        }
        self.decompose(total);
        let [r, g, b] = self.right_sides.map(|side| self.substitute(side));
        let mut coefficients: Coefficients = std::array::from_fn(|k| [r[k], g[k], b[k], 0.0]);
        coefficients[0][3] = 1.0;
        Some(coefficients)
    }

    /// Replaces the lower triangle by its Cholesky factor.
    fn decompose(&mut self, total: f32) {
        let matrix = &mut self.matrix;
        for i in 0..USED_TERMS {
            if i > 0 {
                matrix[i][i] += RIDGE * total;
            }
            for j in 0..=i {
                let product: f32 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
                let rest = matrix[i][j] - product;
                matrix[i][j] = if i == j { rest.max(MIN_PIVOT * total).sqrt() } else { rest / matrix[j][j] };
            }
        }
    }

    /// Solution for a right side, by forward and backward substitution.
    fn substitute(&self, mut side: Terms) -> Terms {
        let matrix = &self.matrix;
        for i in 0..USED_TERMS {
            let product: f32 = (0..i).map(|k| matrix[i][k] * side[k]).sum();
            side[i] = (side[i] - product) / matrix[i][i];
        }
        for i in (0..USED_TERMS).rev() {
            let product: f32 = (i + 1..USED_TERMS).map(|k| matrix[k][i] * side[k]).sum();
            side[i] = (side[i] - product) / matrix[i][i];
        }
        side
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Terms of a pixel: pseudo-random numbers.
    fn terms(pixel: u32) -> Terms {
        std::array::from_fn(|k| match k {
            0 => 1.0,
            1..USED_TERMS => (pixel * 7919 + 104_729 * k as u32 * (pixel + 3)) as f32 % 1.0e4 / 5.0e3 - 1.0,
            _ => 0.0,
        })
    }

    #[test]
    fn linear_functions_are_found() {
        let truth: Terms = std::array::from_fn(|k| if k < USED_TERMS { k as f32 - 3.5 } else { 0.0 });
        let mut equations = NormalEquations::default();
        for pixel in 0..400 {
            let terms = terms(pixel);
            let value: f32 = (0..TERMS).map(|k| truth[k] * terms[k]).sum();
            equations.add(&terms, 0.5 + (pixel % 3) as f32, Vec3::new(value, 2.0 * value, 0.0));
        }
        let coefficients = equations.solve().expect("with weights");
        for k in 0..USED_TERMS {
            let [r, g, b, _] = coefficients[k];
            assert!((r - truth[k]).abs() < 0.02, "{k}: {r} for {}", truth[k]);
            assert!((g - 2.0 * truth[k]).abs() < 0.04 && b.abs() < 1e-5);
        }
    }

    #[test]
    fn features_that_do_not_vary_have_no_slope() {
        let mut equations = NormalEquations::default();
        for value in [1.0, 3.0] {
            let mut terms = Terms::default();
            terms[0] = 1.0;
            equations.add(&terms, 1.0, Vec3::splat(value));
        }
        let [constant, slopes @ ..] = equations.solve().expect("with weights");
        assert!((constant[0] - 2.0).abs() < 1e-5, "{constant:?}");
        assert!(slopes.iter().all(|slope| slope[0].abs() < 1e-5), "{slopes:?}");
        assert!(NormalEquations::default().solve().is_none());
    }
}
