//! Exposure that suits a picture.
//!
//! **Source.** The geometric mean becomes middle grey (Reinhard et al. 2002). **Cost.** Linear in the pixels.

use super::film::Film;

/// Luminance of the mean after exposure: middle grey.
const MIDDLE_GREY: f64 = 0.18;
/// Luminance after exposure from which a pixel is nearly white with every tone curve.
const WHITE: f64 = 4.0;
/// Luminance after exposure up to which a pixel is nearly black.
const BLACK: f64 = 0.003;

/// Exposure in stops, to a tenth, that gives a picture the geometric mean of middle grey; `None` of a black picture. Pixels that
/// are black do not count.
pub fn suitable_stops(film: &Film) -> Option<f32> {
    let (mut sum, mut count) = (0.0_f64, 0_u32);
    for luminance in luminances(film).filter(|luminance| *luminance > 1e-9) {
        sum += luminance.ln();
        count += 1;
    }
    let mean = (sum / f64::from(count.max(1))).exp();
    (count > 0).then(|| ((MIDDLE_GREY / mean).log2() * 10.0).round() as f32 / 10.0)
}

/// Fault of a picture's exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ExposureFault {
    /// At least half of the picture is nearly white; the share of it.
    Over(f64),
    /// All but a thousandth of the picture is nearly black.
    Under,
}

/// Fault of a picture that is displayed with this exposure in stops; `None` of a usual one, and of one that is wholly black.
pub fn exposure_fault(film: &Film, stops: f32) -> Option<ExposureFault> {
    let factor = f64::from(stops).exp2();
    let (mut all, mut white, mut black, mut lit) = (0.0, 0.0, 0.0, false);
    for luminance in luminances(film).map(|luminance| luminance * factor) {
        all += 1.0;
        white += f64::from(u8::from(luminance >= WHITE));
        black += f64::from(u8::from(luminance <= BLACK));
        lit |= luminance > 0.0;
    }
    match () {
        () if 2.0 * white >= all && lit => Some(ExposureFault::Over(white / all)),
        () if black >= 0.999 * all && lit => Some(ExposureFault::Under),
        () => None,
    }
}

/// Luminances of the pixels that are finite.
fn luminances(film: &Film) -> impl Iterator<Item = f64> {
    let luminance = |[r, g, b]: [f32; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    film.mean().pixels.into_iter().map(luminance).filter(|luminance| luminance.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(value: f32) -> Film {
        let mut film = Film::new(4, 2);
        film.samples = 2;
        // Two samples of half of it each in six pixels; the others are black.
        film.sums.iter_mut().take(6).for_each(|sum| *sum = [2.0 * value; 3]);
        film
    }

    #[test]
    fn a_grey_picture_becomes_middle_grey() {
        assert_eq!(suitable_stops(&film(0.045)), Some(2.0));
        assert_eq!(suitable_stops(&film(0.0)), None);
    }

    #[test]
    fn wrong_exposures_are_found() {
        assert_eq!(exposure_fault(&film(0.18), 0.0), None);
        assert_eq!(exposure_fault(&film(0.18), 6.0), Some(ExposureFault::Over(0.75)));
        assert_eq!(exposure_fault(&film(0.18), -8.0), Some(ExposureFault::Under));
        assert_eq!(exposure_fault(&film(0.0), 0.0), None);
    }
}
