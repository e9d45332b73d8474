//! Modes of a picture: path tracing, a preview without noise, and views of auxiliary quantities.
//!
//! **Idea.** Every mode computes a colour for each *sample* of a pixel, and the film sums these colours. Sample ranges,
//! antialiasing by jitter, files and both backends are therefore the same for all modes. Only [`Mode::Variance`] is a
//! function of sums instead of a mean of colours: its film contains sums of luminance and of its square. [`Mode::picture`]
//! is the only function that converts films to pictures.
//!
//! **Colours.** [`Mode::Path`] and [`Mode::Preview`] are radiance, to be shown with an exposure and a tone curve. The others
//! are display colours: the sRGB curve alone ([`Mode::display`]) maps their linear values to the intended codes, so that a
//! normal n has the codes (n + 1)/2. EXR files contain the linear values.
//!
//! **Source.** [`heat`] is Turbo (Mikhailov 2019, "Turbo, An Improved Rainbow Colormap for Visualization", Google AI Blog),
//! in the polynomial of degree five fitted by Ruofei Du. Colours of indices: hues a golden ratio apart (Ankerl 2009, "How to
//! Generate Random Colors Programmatically"), here in Oklab (Ottosson 2020) so that they appear equally light.

use crate::output::film::Film;
use crate::output::image::Picture;
use crate::output::tonemap::{Display, Tonemap, decoded};
use pathmarch_field::number::Real;
use pathmarch_field::wgsl::Function;
use pathmarch_scene::Camera;
use std::f32::consts::TAU;

/// Quantity that a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Radiance by path tracing.
    #[default]
    Path,
    /// Approximate radiance without noise: direct light, soft shadows, ambient occlusion, one reflection.
    Preview,
    /// Albedo of the material.
    Albedo,
    /// Surface normal in world space.
    Normal,
    /// Distance from the camera along its axis.
    Depth,
    /// Colour of the object's index.
    ObjectId,
    /// Colour of the material's index.
    MaterialId,
    /// Number of field evaluations of the camera ray.
    Steps,
    /// Violations of the field's Lipschitz constant.
    Violations,
    /// Relative standard error of the path-traced pixel.
    Variance,
}

impl Mode {
    /// All modes, in menu order.
    pub const ALL: [Self; 10] = [
        Self::Path,
        Self::Preview,
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::ObjectId,
        Self::MaterialId,
        Self::Steps,
        Self::Violations,
        Self::Variance,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::Preview => "preview",
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::ObjectId => "object-id",
            Self::MaterialId => "material-id",
            Self::Steps => "steps",
            Self::Violations => "violations",
            Self::Variance => "variance",
        }
    }

    /// Help text, one line.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Path => "Radiance by path tracing.",
            Self::Preview => {
                "Approximate radiance without noise: direct light, soft shadows, ambient occlusion, one reflection."
            }
            Self::Albedo => "Albedo of the material; for an emitter, its radiance clipped to 1.",
            Self::Normal => "Surface normal in world space: red x, green y, blue z, from -1 to 1.",
            Self::Depth => "Distance along the camera's axis: white near, grey at the target, black far away.",
            Self::ObjectId => "A colour for each object.",
            Self::MaterialId => "A colour for each material.",
            Self::Steps => "Field evaluations of the camera ray: blue few, red 256; black none.",
            Self::Violations => {
                "Excess of the field's slope over its Lipschitz constant: grey none, green 10 %, red 4 times."
            }
            Self::Variance => "Relative standard error of the path-traced pixel: blue 0.1 %, green 3 %, red 100 %.",
        }
    }

    /// Mode of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// True if samples are noisy paths, so that a picture needs many of them.
    pub fn traces_paths(self) -> bool {
        matches!(self, Self::Path | Self::Variance)
    }

    /// Number of samples of each pixel, if path tracing takes `samples`.
    pub fn samples(self, samples: u32) -> u32 {
        /// Samples of a pixel that make edges smooth.
        const ANTIALIASING: u32 = 16;
        if self.traces_paths() { samples } else { ANTIALIASING }
    }

    /// Tone curve and exposure of the mode: `display` for radiance, the sRGB curve alone for display colours.
    pub fn display(self, display: Display) -> Display {
        match self {
            Self::Path | Self::Preview => display,
            _ => Display { tonemap: Tonemap::Srgb, exposure_stops: 0.0 },
        }
    }

    /// True if pictures of this camera have the exposure that suits them: they show radiance, and the camera does not fix it.
    pub fn has_auto_exposure(self, camera: &Camera) -> bool {
        camera.auto_exposure && matches!(self, Self::Path | Self::Preview)
    }

    /// Picture of a film of this mode, linear Rec. 709.
    pub fn picture(self, film: &Film) -> Picture {
        if self != Self::Variance {
            return film.mean();
        }
        let error = |([sum, square, _], samples): ([f32; 3], u32)| uncertainty(sum, square, samples);
        let pixels = film.sums.iter().copied().zip(film.sample_counts()).map(error).collect();
        Picture { width: film.width, height: film.height, pixels }
    }
}

/// Relative standard error of the mean of `samples` values, from their sum and the sum of their squares. Returns 0 if all are
/// 0, and infinity for fewer than two samples.
pub fn relative_error(sum: f32, square: f32, samples: u32) -> f64 {
    if samples < 2 {
        return f64::INFINITY;
    }
    let (n, sum) = (f64::from(samples), f64::from(sum));
    if sum <= 0.0 {
        return 0.0;
    }
    let mean = sum / n;
    // Rounding of the sums may make the difference slightly negative.
    let variance = ((f64::from(square) / n - mean * mean) * (n / (n - 1.0))).max(0.0);
    (variance / n).sqrt() / mean
}

/// Colour of the relative error over three decades, up to 1; black for pixels without light.
fn uncertainty(sum: f32, square: f32, samples: u32) -> [f32; 3] {
    if sum <= 0.0 {
        return [0.0; 3];
    }
    heat(1.0 + relative_error(sum, square, samples).max(1e-9).log10() as f32 / 3.0)
}

/// [`uncertainty`] in single precision, over any number type, for the display.
pub(crate) fn uncertainty_of<N: Real>(sum: N, square: N, samples: N) -> [N; 3] {
    let (one, least) = (N::one(), N::constant(1e-9));
    let n = samples.max(one);
    let mean = sum / n;
    let variance = (square / n - mean * mean).max(N::zero()) / (n - one).max(N::constant(0.5));
    let error = (variance.sqrt() / mean.max(N::constant(1e-30))).max(least);
    let colour = heat_of(one + error.ln() * N::constant(1.0 / (3.0 * std::f32::consts::LN_10)));
    let too_few = heat(1.0).map(N::constant);
    std::array::from_fn(|k| {
        let known = N::select(samples.lt(N::constant(1.5)), too_few[k], colour[k]);
        N::select(N::zero().lt(sum), known, N::zero())
    })
}

/// `uncertainty(sums: vec4f) -> vec4f` in WGSL; x is the sum of luminance, y that of its square, w the number of samples.
pub(crate) fn uncertainty_wgsl() -> String {
    let function = Function {
        name: "uncertainty".to_owned(),
        doc: "Colour of the relative standard error of a pixel.".to_owned(),
        parameters: vec![("sums", "vec4f")],
    };
    function.print(&|inputs| {
        let [r, g, b] = uncertainty_of(inputs[0], inputs[1], inputs[3]);
        vec![r, g, b, inputs[3]]
    })
}

/// Colour map of values from 0 to 1: dark blue, green, dark red; linear Rec. 709.
pub(crate) fn heat(value: f32) -> [f32; 3] {
    heat_of(value)
}

fn heat_of<N: Real>(value: N) -> [N; 3] {
    const RED: [f32; 6] = [0.135_721_38, 4.615_392_6, -42.660_324, 132.131_08, -152.942_39, 59.286_38];
    const GREEN: [f32; 6] = [0.091_402_61, 2.194_188_4, 4.842_966_6, -14.185_033, 4.277_298_6, 2.829_566];
    const BLUE: [f32; 6] = [0.106_673_3, 12.641_946, -60.582_05, 110.362_77, -89.903_11, 27.348_25];
    let x = value.clamp(N::zero(), N::one());
    [RED, GREEN, BLUE]
        .map(|curve| decoded(curve.into_iter().rev().fold(N::zero(), |sum, factor| sum * x + N::constant(factor))))
}

/// Colour of an index, unlike the colours of adjoining indices; linear Rec. 709.
pub(crate) fn index_colour(number: u32) -> [f32; 3] {
    // Adjoining hues are a golden section of the circle apart; lightness and chroma distinguish similar hues.
    let hue = TAU * (number as f32 * 0.618_034 + 0.08).fract();
    let lightness = [0.75, 0.55, 0.66, 0.85][((number / 3 + number / 8) % 4) as usize];
    let chroma = [0.15, 0.11][(number / 2 % 2) as usize];
    let (a, b) = (chroma * hue.cos(), chroma * hue.sin());
    // Oklab to linear Rec. 709.
    let [l, m, s] = [
        lightness + 0.396_337_78 * a + 0.215_803_76 * b,
        lightness - 0.105_561_346 * a - 0.063_854_17 * b,
        lightness - 0.089_484_18 * a - 1.291_485_5 * b,
    ]
    .map(|root| root * root * root);
    [
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_93 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    ]
    .map(|channel: f32| channel.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_one_to_one() {
        for mode in Mode::ALL {
            assert_eq!(Mode::from_name(mode.name()), Some(mode));
            assert!(mode.doc().ends_with('.'));
        }
        assert_eq!((Mode::from_name("Path"), Mode::default()), (None, Mode::Path));
        assert_eq!(Mode::from_name(crate::output::image::UNNAMED_MODE), Some(Mode::Path));
    }

    #[test]
    fn colours_of_indices_differ_and_are_visible() {
        let codes = |number| index_colour(number).map(crate::output::tonemap::srgb_encode);
        let distance = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
        for a in 0..64 {
            assert!(codes(a).iter().sum::<f32>() > 0.5, "{a}");
            for b in 0..a {
                assert!(distance(codes(a), codes(b)) > 0.05, "{a} {b} {:?} {:?}", codes(a), codes(b));
            }
            // Adjoining indices differ at a glance.
            for b in a + 1..a + 4 {
                assert!(distance(codes(a), codes(b)) > 0.2, "{a} {b} {:?} {:?}", codes(a), codes(b));
            }
        }
    }

    #[test]
    fn the_colour_map_goes_from_blue_to_red() {
        let [cold, middle, hot] = [0.12, 0.5, 0.9].map(heat);
        assert!(cold[2] > cold[0] && cold[2] > cold[1]);
        assert!(middle[1] > middle[0] && middle[1] > middle[2]);
        assert!(hot[0] > hot[1] && hot[0] > hot[2]);
        assert_eq!((heat(-1.0), heat(7.0)), (heat(0.0), heat(1.0)));
    }

    #[test]
    fn the_error_of_a_mean_is_that_of_statistics() {
        // 1, 2, 3, 4: mean 2.5, variance 5/3, error of the mean sqrt(5/12).
        assert!((relative_error(10.0, 30.0, 4) - (5.0f64 / 12.0).sqrt() / 2.5).abs() < 1e-9);
        assert_eq!(relative_error(8.0, 16.0, 4), 0.0);
        assert_eq!(relative_error(0.0, 0.0, 4), 0.0);
        assert_eq!(relative_error(1.0, 1.0, 1), f64::INFINITY);
        let mut film = Film::new(3, 1);
        (film.samples, film.sums) = (4, vec![[10.0, 30.0, 0.0], [0.0; 3], [8.0, 16.0, 0.0]]);
        let picture = Mode::Variance.picture(&film);
        assert_eq!(picture.pixels, [heat(1.0 + 0.258_198_9_f32.log10() / 3.0), [0.0; 3], heat(0.0)]);
        assert_eq!(Mode::Path.picture(&film), film.mean());
    }
}
