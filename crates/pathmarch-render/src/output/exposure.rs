//! Exposure that suits a picture.
//!
//! **Source.** The geometric mean becomes middle grey (Reinhard et al. 2002). **Cost.** Linear in the pixels.

use super::film::Film;
use pathmarch_scene::Camera;
use pathmarch_scene::settings::EXPOSURE;

/// Luminance of the mean after exposure: middle grey.
const MIDDLE_GREY: f64 = 0.18;
/// Luminance after exposure from which a pixel is nearly white with every tone curve.
const WHITE: f64 = 4.0;
/// Luminance after exposure up to which a pixel is nearly black.
const BLACK: f64 = 0.003;

/// Cells in the width of a picture, at most. Their means have little noise even at one sample, so that a first picture gets
/// nearly the exposure of the last one.
const CELLS: usize = 48;

/// Exposure in stops, to a tenth, that suits a picture; `None` of a black one. The geometric mean of the luminances of its cells
/// becomes middle grey; cells that are black do not count. Within the range of a camera's exposure.
pub fn suitable_stops(film: &Film) -> Option<f32> {
    suitable_stops_of(film.width as usize, &film.mean().pixels)
}

/// [`suitable_stops`] of linear pixels, in rows of this width.
pub fn suitable_stops_of(width: usize, pixels: &[[f32; 3]]) -> Option<f32> {
    let side = width.div_ceil(CELLS).max(1);
    let columns = width.div_ceil(side);
    let mut cells = vec![(0.0_f64, 0_u32); columns * (pixels.len() / width.max(1)).div_ceil(side)];
    for (index, luminance) in pixels.iter().map(|pixel| luminance(*pixel)).enumerate() {
        let cell = index / width / side * columns + index % width / side;
        if let Some((sum, count)) = cells.get_mut(cell).filter(|_| luminance.is_finite()) {
            (*sum, *count) = (*sum + luminance, *count + 1);
        }
    }
    let means = cells.iter().map(|(sum, count)| sum / f64::from((*count).max(1))).filter(|mean| *mean > 1e-9);
    let (sum, count) = means.fold((0.0, 0_u32), |(sum, count), mean| (sum + mean.ln(), count + 1));
    let mean = (sum / f64::from(count.max(1))).exp();
    let stops = ((MIDDLE_GREY / mean).log2() * 10.0).round() as f32 / 10.0;
    (count > 0).then(|| stops.clamp(EXPOSURE.min, EXPOSURE.max))
}

/// Exposure of a picture of this camera, in stops: its own, or the one that suits the film. Without a film, or with a black one,
/// an automatic exposure is 0.
pub fn camera_stops(camera: &Camera, film: Option<&Film>) -> f32 {
    film.filter(|_| camera.auto_exposure).and_then(suitable_stops).unwrap_or(camera.exposure)
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
    film.mean().pixels.into_iter().map(luminance).filter(|luminance| luminance.is_finite())
}

fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
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
    fn noise_and_size_change_the_exposure_little() {
        // A gradient over three stops, of which a sample finds all of the light of eight pixels in one.
        let stops = |width: usize, noisy: bool| {
            let pixel = |index: usize| {
                let light = 0.1 * ((index % width) as f32 / width as f32 * 3.0).exp2();
                match (noisy, (index * 5) % 8) {
                    (false, _) => [light; 3],
                    (true, 0) => [8.0 * light; 3],
                    (true, _) => [0.0; 3],
                }
            };
            suitable_stops_of(width, &(0..width * width / 2).map(pixel).collect::<Vec<_>>()).expect("light")
        };
        let clean = stops(960, false);
        for (width, noisy) in [(960, true), (480, false), (480, true), (1000, false)] {
            assert!((stops(width, noisy) - clean).abs() <= 0.1, "{width} {noisy}: {}", stops(width, noisy));
        }
    }

    #[test]
    fn the_exposure_of_a_camera_may_follow_the_film() {
        let camera = pathmarch_scene::parts::camera([0.0, 0.0, 5.0], [0.0; 3]);
        let camera = Camera { exposure: 1.5, ..camera };
        assert_eq!(camera_stops(&camera, Some(&film(0.045))), 1.5);
        let auto = Camera { exposure: 0.0, auto_exposure: true, ..camera };
        assert_eq!(camera_stops(&auto, Some(&film(0.045))), 2.0);
        assert_eq!((camera_stops(&auto, Some(&film(0.0))), camera_stops(&auto, None)), (0.0, 0.0));
    }

    #[test]
    fn wrong_exposures_are_found() {
        assert_eq!(exposure_fault(&film(0.18), 0.0), None);
        assert_eq!(exposure_fault(&film(0.18), 6.0), Some(ExposureFault::Over(0.75)));
        assert_eq!(exposure_fault(&film(0.18), -8.0), Some(ExposureFault::Under));
        assert_eq!(exposure_fault(&film(0.0), 0.0), None);
    }
}
