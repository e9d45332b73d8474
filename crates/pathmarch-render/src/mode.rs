//! What a pixel shows: light, a quick look, or a view of what the renderer knows.
//!
//! **Idea.** Every mode gives each *sample* of a pixel a colour, and the film sums colours, whatever they mean: sample
//! ranges, antialiasing by jitter, files and both backends are the same for all. Only [`Mode::Variance`] is a function of
//! sums rather than a mean of colours: its film holds sums of luminance and of its square, and [`Mode::picture`] is the one
//! place that turns a film into what it shows.
//!
//! **Colours.** [`Mode::Path`] and [`Mode::Preview`] are radiance, for exposure and a tone curve. The others are colours to
//! look at: their linear values are such that the sRGB curve alone ([`Mode::display`]) gives the codes meant, so that a
//! normal n has the codes (n + 1)/2. EXR files hold the linear values.
//!
//! **Source.** [`heat`] is Turbo (Mikhailov 2019, "Turbo, An Improved Rainbow Colormap for Visualization", Google AI Blog),
//! in the polynomial of degree five fitted by Ruofei Du. Colours of numbers: hues a golden ratio apart (Ankerl 2009, "How to
//! Generate Random Colors Programmatically"), here in Oklab (Ottosson 2020) so that they look equally light.

use crate::output::film::Film;
use crate::output::image::Picture;
use crate::output::tonemap::{Display, Tonemap, decoded};
use pathmarch_field::number::Real;
use pathmarch_field::wgsl::Function;
use std::f32::consts::TAU;

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Mode {
    /// Light as it is: path tracing.
    #[default]
    Path,
    /// A quick look without noise: direct light, penumbrae, ambient occlusion, one reflection.
    Preview,
    /// The colour of the material.
    Albedo,
    /// Where the surface faces.
    Normal,
    /// How far the surface is from the camera.
    Depth,
    /// A colour for each object.
    ObjectId,
    /// A colour for each material.
    MaterialId,
    /// How often the camera's ray evaluated the field.
    Steps,
    /// Where the field changes faster than it may.
    Violations,
    /// How uncertain the path-traced pixel still is.
    Variance,
}

impl Mode {
    /// Every one, in the order of a menu.
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

    /// Its name on the command line.
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

    /// One line for people.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Path => "Light as it is: path tracing.",
            Self::Preview => {
                "A quick look without noise: direct light, soft shadows, ambient occlusion, one reflection."
            }
            Self::Albedo => "The colour of the material; of a lamp, its radiance clipped to 1.",
            Self::Normal => "Where the surface faces in the world: red x, green y, blue z, from -1 to 1.",
            Self::Depth => "Distance along the camera's axis: white near, grey at the target, black far away.",
            Self::ObjectId => "A colour for each object.",
            Self::MaterialId => "A colour for each material.",
            Self::Steps => "Evaluations of the field by the camera's ray: blue few, red 256; black where none.",
            Self::Violations => {
                "Where the field changes faster than its Lipschitz constant allows: grey not, green by 10 %, red by 4 times."
            }
            Self::Variance => "Relative standard error of the path-traced pixel: blue 0.1 %, green 3 %, red 100 %.",
        }
    }

    /// The one of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mode| mode.name() == name)
    }

    /// Whether samples are paths, so that many of them are needed.
    pub fn traces_paths(self) -> bool {
        matches!(self, Self::Path | Self::Variance)
    }

    /// Samples that a mode needs where the scene asks for `samples` of paths.
    pub fn samples(self, samples: u32) -> u32 {
        /// Enough positions in a pixel for smooth edges.
        const ANTIALIASING: u32 = 16;
        if self.traces_paths() { samples } else { ANTIALIASING }
    }

    /// What stands between its picture and a screen, where `display` is meant for radiance.
    pub fn display(self, display: Display) -> Display {
        match self {
            Self::Path | Self::Preview => display,
            _ => Display { tonemap: Tonemap::Srgb, exposure_stops: 0.0 },
        }
    }

    /// What a film of this mode shows, linear Rec. 709.
    pub fn picture(self, film: &Film) -> Picture {
        if self != Self::Variance {
            return film.mean();
        }
        let error = |([sum, square, _], samples): ([f32; 3], u32)| uncertainty(sum, square, samples);
        let pixels = film.sums.iter().copied().zip(film.sample_counts()).map(error).collect();
        Picture { width: film.width, height: film.height, pixels }
    }
}

/// The relative standard error of a mean of `samples` values, from their sum and the sum of their squares: 0 where all are 0,
/// infinite where too few are known.
pub fn relative_error(sum: f32, square: f32, samples: u32) -> f64 {
    if samples < 2 {
        return f64::INFINITY;
    }
    let (n, sum) = (f64::from(samples), f64::from(sum));
    if sum <= 0.0 {
        return 0.0;
    }
    let mean = sum / n;
    // Rounding of the sums may leave a little less than nothing.
    let variance = ((f64::from(square) / n - mean * mean) * (n / (n - 1.0))).max(0.0);
    (variance / n).sqrt() / mean
}

/// The colour of that error: three powers of ten, up to 1. Black where no light has come.
fn uncertainty(sum: f32, square: f32, samples: u32) -> [f32; 3] {
    if sum <= 0.0 {
        return [0.0; 3];
    }
    heat(1.0 + relative_error(sum, square, samples).max(1e-9).log10() as f32 / 3.0)
}

/// [`uncertainty`] in single precision, over any number: for the screen.
pub(crate) fn uncertainty_shown<N: Real>(sum: N, square: N, samples: N) -> [N; 3] {
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

/// `uncertainty(sums: vec4f) -> vec4f` in WGSL: luminance, its square and, fourth, the number of samples.
pub(crate) fn uncertainty_wgsl() -> String {
    let function = Function {
        name: "uncertainty".to_owned(),
        doc: "The colour of the relative standard error of a pixel.".to_owned(),
        parameters: vec![("sums", "vec4f")],
    };
    function.print(&|inputs| {
        let [r, g, b] = uncertainty_shown(inputs[0], inputs[1], inputs[3]);
        vec![r, g, b, inputs[3]]
    })
}

/// A number from 0 to 1 as a colour from dark blue over green to dark red; linear Rec. 709.
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

/// A colour for a number, unlike those of the numbers around it; linear Rec. 709.
pub(crate) fn colour_of_number(number: u32) -> [f32; 3] {
    // Neighbours are a golden section of the circle apart; lightness and strength tell those of like hue.
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
    fn colours_of_numbers_differ_and_are_seen() {
        let codes = |number| colour_of_number(number).map(crate::output::tonemap::srgb_encode);
        let distance = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
        for a in 0..64 {
            assert!(codes(a).iter().sum::<f32>() > 0.5, "{a}");
            for b in 0..a {
                assert!(distance(codes(a), codes(b)) > 0.05, "{a} {b} {:?} {:?}", codes(a), codes(b));
            }
            // The next ones are told apart at a glance.
            for b in a + 1..a + 4 {
                assert!(distance(codes(a), codes(b)) > 0.2, "{a} {b} {:?} {:?}", codes(a), codes(b));
            }
        }
    }

    #[test]
    fn heat_goes_from_blue_to_red() {
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
