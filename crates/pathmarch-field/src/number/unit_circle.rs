//! Points on the unit circle.

use super::Real;
use std::f32::consts::PI;

/// Cosine and sine of `turn` full turns, 0 to 1, each to 1e-6 in `f32`.
///
/// Idea: polynomials in the square give the sine and the cosine of half of the angle, less a quarter turn, which is within a
/// quarter turn; the formulas for a double angle give the rest. There is no quadrant to choose. The coefficients are those of
/// the least greatest error. A path needs one or two such points at each surface.
#[inline(always)]
pub fn unit_circle<N: Real>(turn: N) -> [N; 2] {
    let polynomial = |x: N, coefficients: [f32; 5]| {
        let [mut sum, rest @ ..] = coefficients.map(N::constant);
        for coefficient in rest {
            sum = sum * x + coefficient;
        }
        sum
    };
    let v = turn - N::constant(0.5);
    let square = v * v;
    let sine = v * polynomial(square, [0.077_220_09, -0.598_045_2, 2.550_031_4, -5.167_707, PI]);
    let cosine = polynomial(square, [0.219_696_69, -1.331_880_1, 4.058_412, -4.934_793, 1.0]);
    let twice = sine + sine;
    [twice * sine - N::one(), -twice * cosine]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_those_of_cosine_and_sine() {
        for k in 0..=100_000 {
            let turn = k as f32 / 100_000.0;
            let [cosine, sine] = unit_circle(turn).map(f64::from);
            let angle = std::f64::consts::TAU * f64::from(turn);
            let error = (cosine - angle.cos()).abs().max((sine - angle.sin()).abs());
            assert!(error < 1e-6, "{turn}: {error:e}");
        }
    }
}
