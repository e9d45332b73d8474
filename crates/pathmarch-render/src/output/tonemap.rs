//! Tone mapping: unbounded linear radiance to sRGB codes in 0..=1.
//!
//! **Idea.** Radiance is unbounded; a display shows 0 to 1. [`Tonemap::Agx`] compresses like photographic film: bright colours
//! fade to white and nothing clips. [`Tonemap::Neutral`] preserves base colours and compresses highlights only.
//! [`Tonemap::Srgb`] clips. All return sRGB codes (IEC 61966-2-1), ready to be rounded to 8 bits.
//!
//! **Source.** AgX: Troy Sobotka, 2022, in the closed form fitted by Benjamin Wrensch, "Minimal AgX Implementation", 2023
//! (base look). Its curve returns codes for a display of pure power 2.2. We decode them with that power and encode the light
//! with the sRGB curve, as does a fragment shader that writes to an sRGB target. The result differs from the codes by up to
//! 0.035, most in the darkest shadows. Neutral: Khronos, "PBR Neutral Tone Mapper", 2024.
//!
//! **Bad pixels.** NaN and negative radiance count as 0, infinity as a very bright colour. The result is always finite.
//!
//! **One source.** The curves are generic over [`Real`]: one function computes a pixel of a file, eight pixels in SIMD lanes
//! for the window, and the WGSL of the display pass.
//!
//! **Cost.** Nine logarithms and exponentials a pixel for AgX: 90 ms a megapixel on one core, without SIMD.

use pathmarch_field::number::Real;
use pathmarch_field::wgsl::Function;
pub use pathmarch_scene::Tonemap;
use rayon::prelude::*;
use wide::f32x8;

/// Maps linear Rec. 709 radiance, exposure already applied, to sRGB codes in 0..=1.
pub fn map(tonemap: Tonemap, linear: [f32; 3]) -> [f32; 3] {
    codes(tonemap, linear)
}

/// [`map`] over any number type: one pixel, eight pixels, or WGSL.
fn codes<N: Real>(tonemap: Tonemap, linear: [N; 3]) -> [N; 3] {
    let linear = linear.map(sanitized);
    match tonemap {
        Tonemap::Agx => agx(linear),
        Tonemap::Neutral => neutral(linear),
        Tonemap::Srgb => linear,
    }
    .map(encoded)
}

/// Every curve as a WGSL function `NAME_codes(linear: vec4f) -> vec4f`, and `codes(tonemap, linear)`, which chooses a curve
/// by its index in [`Tonemap::ALL`].
pub(crate) fn wgsl() -> String {
    let mut text = String::new();
    let mut choice = String::new();
    for (k, tonemap) in Tonemap::ALL.into_iter().enumerate() {
        let name = format!("{}_codes", tonemap.name());
        choice += &format!("    if tonemap == {k}u {{\n        return {name}(linear);\n    }}\n");
        let doc = format!("Linear radiance to sRGB codes by the curve `{}`.", tonemap.name());
        let function = Function { name, doc, parameters: vec![("linear", "vec4f")] };
        text += &function.print(&|inputs| {
            let [r, g, b] = codes(tonemap, [inputs[0], inputs[1], inputs[2]]);
            vec![r, g, b, inputs[3]]
        });
        text.push('\n');
    }
    text + &format!("fn codes(tonemap: u32, linear: vec4f) -> vec4f {{\n{choice}    return linear;\n}}\n")
}

/// Tone curve and exposure for the display of a linear picture.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Display {
    /// Tone curve.
    pub tonemap: Tonemap,
    /// Exposure, stops: radiance is multiplied by two to this power before the curve.
    pub exposure_stops: f32,
}

impl Display {
    /// Maps linear Rec. 709 radiance to sRGB codes in 0..=1.
    pub fn encode(&self, linear: [f32; 3]) -> [f32; 3] {
        map(self.tonemap, linear.map(|channel| channel * self.gain()))
    }

    /// [`encode`](Self::encode) in 8 bits, rounded to nearest.
    pub fn encode_8bit(&self, linear: [f32; 3]) -> [u8; 3] {
        self.encode(linear).map(|code| (code * 255.0).round() as u8)
    }

    /// [`encode_8bit`](Self::encode_8bit) of a picture, on all cores: red, green, blue and 255 for each pixel.
    pub fn encode_rgba<Colour: Copy + Into<[f32; 3]> + Sync>(&self, linear: &[Colour]) -> Vec<u8> {
        /// Pixels of a task.
        const TASK: usize = 8 * 256;
        let mut codes = vec![255; 4 * linear.len()];
        codes.par_chunks_mut(4 * TASK).zip(linear.par_chunks(TASK)).for_each(|(codes, colours)| {
            for (codes, colours) in codes.chunks_mut(4 * 8).zip(colours.chunks(8)) {
                let lanes =
                    |k: usize| f32x8::new(std::array::from_fn(|i| colours.get(i).map_or(0.0, |c| (*c).into()[k])));
                let shown = self.encode_lanes([lanes(0), lanes(1), lanes(2)]).map(f32x8::to_array);
                for (i, code) in codes.chunks_mut(4).enumerate() {
                    for channel in 0..3 {
                        code[channel] = (shown[channel][i] * 255.0).round() as u8;
                    }
                }
            }
        });
        codes
    }

    /// [`encode`](Self::encode) for eight pixels in SIMD lanes.
    fn encode_lanes(&self, linear: [f32x8; 3]) -> [f32x8; 3] {
        let gain = f32x8::splat(self.gain());
        codes(self.tonemap, linear.map(|channel| channel * gain))
    }

    /// Factor of radiance before the curve.
    pub(crate) fn gain(&self) -> f32 {
        self.exposure_stops.exp2()
    }
}

/// sRGB curve (IEC 61966-2-1): encodes linear light as a code. Clamps to 0..=1; NaN becomes 0.
pub fn srgb_encode(linear: f32) -> f32 {
    encoded(linear)
}

fn encoded<N: Real>(linear: N) -> N {
    let linear = sanitized(linear).min(N::one());
    let curved = N::constant(1.055) * power(linear, 1.0 / 2.4) - N::constant(0.055);
    N::select(N::constant(0.003_130_8).lt(linear), curved, N::constant(12.92) * linear)
}

/// Inverse of [`srgb_encode`]: decodes a code in 0..=1 to linear light.
pub fn srgb_decode(code: f32) -> f32 {
    decoded(code)
}

/// [`srgb_decode`] over any number type.
pub(crate) fn decoded<N: Real>(code: N) -> N {
    let code = sanitized(code).min(N::one());
    let curved = power((code + N::constant(0.055)) * N::constant(1.0 / 1.055), 2.4);
    N::select(N::constant(0.040_45).lt(code), curved, code * N::constant(1.0 / 12.92))
}

/// Power of `x`, which is not negative; sanitized also at zero, whose logarithm is not.
fn power<N: Real>(x: N, exponent: f32) -> N {
    let least = N::constant(1e-20);
    N::select(x.lt(least), N::zero(), x.max(least).pow(N::constant(exponent)))
}

/// Largest radiance that the curves map; safe to multiply.
const MAX_RADIANCE: f32 = 1e18;

/// Replaces NaN and negative values by 0, and clamps to [`MAX_RADIANCE`].
fn sanitized<N: Real>(channel: N) -> N {
    // NaN compares false.
    N::select(N::zero().lt(channel), channel.min(N::constant(MAX_RADIANCE)), N::zero())
}

/// Matrices (rows) from Rec. 709 to the AgX working space, and back.
const AGX_INSET: [[f32; 3]; 3] = [
    [0.842_479_06, 0.078_433_6, 0.079_223_745],
    [0.042_328_224, 0.878_468_64, 0.079_166_13],
    [0.042_375_655, 0.078_433_6, 0.879_143],
];
const AGX_OUTSET: [[f32; 3]; 3] = [
    [1.196_879, -0.098_020_88, -0.099_029_74],
    [-0.052_896_85, 1.151_903_1, -0.098_961_18],
    [-0.052_971_635, -0.098_043_45, 1.151_073_7],
];
/// Range of the curve in log2 of radiance: from ten stops below middle grey (0.18) to six and a half above.
const AGX_MIN_LOG2: f32 = -12.473_93;
const AGX_MAX_LOG2: f32 = 4.026_069;

/// AgX, base look; returns linear light in 0..=1.
fn agx<N: Real>(linear: [N; 3]) -> [N; 3] {
    let log_encoded = transform(&AGX_INSET, linear).map(|channel| {
        let log2 = channel.max(N::constant(1e-20)).ln() * N::constant(std::f32::consts::LOG2_E);
        (log2.clamp(N::constant(AGX_MIN_LOG2), N::constant(AGX_MAX_LOG2)) - N::constant(AGX_MIN_LOG2))
            * N::constant(1.0 / (AGX_MAX_LOG2 - AGX_MIN_LOG2))
    });
    // Sigmoid, then codes in Rec. 709 for a display of power 2.2, then the light that this display emits.
    transform(&AGX_OUTSET, log_encoded.map(agx_sigmoid)).map(|code| power(code.clamp(N::zero(), N::one()), 2.2))
}

/// Wrensch's polynomial of degree six for the AgX contrast curve.
fn agx_sigmoid<N: Real>(x: N) -> N {
    [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32]
        .into_iter()
        .fold(N::zero(), |sum, coefficient| sum * x + N::constant(coefficient))
}

fn transform<N: Real>(rows: &[[f32; 3]; 3], v: [N; 3]) -> [N; 3] {
    rows.map(|row| N::constant(row[0]) * v[0] + N::constant(row[1]) * v[1] + N::constant(row[2]) * v[2])
}

/// Khronos PBR Neutral; returns linear light in 0..=1.
fn neutral<N: Real>(linear: [N; 3]) -> [N; 3] {
    /// Reflectance at normal incidence of a common dielectric, which the curve subtracts.
    const F90_OFFSET: f32 = 0.04;
    const COMPRESSION_START: f32 = 0.8 - F90_OFFSET;
    const DESATURATION: f32 = 0.15;

    let [r, g, b] = linear;
    let darkest = r.min(g).min(b);
    let full_offset = N::constant(F90_OFFSET);
    let offset = N::select(darkest.lt(N::constant(0.08)), darkest - N::constant(6.25) * darkest * darkest, full_offset);
    let base = linear.map(|channel| channel - offset);
    let peak = base[0].max(base[1]).max(base[2]);
    let start = N::constant(COMPRESSION_START);
    let room = N::constant(1.0 - COMPRESSION_START);
    // Shoulder; not used below its start.
    let over = peak.max(start);
    let new_peak = N::one() - room * room / (over + room - start);
    let white = N::one() - N::one() / (N::constant(DESATURATION) * (over - new_peak) + N::one());
    base.map(|channel| {
        let compressed = channel * (new_peak / over);
        N::select(peak.lt(start), channel, compressed + (new_peak - compressed) * white)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f32, expected: f32, tolerance: f32) {
        assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} ± {tolerance}");
    }

    #[test]
    fn srgb_has_its_known_values_and_inverts() {
        assert_near(map(Tonemap::Srgb, [0.5; 3])[0], 0.735_357, 1e-5);
        assert_near(map(Tonemap::Srgb, [0.18; 3])[1], 0.461_356, 1e-5);
        assert_eq!(map(Tonemap::Srgb, [-1.0, 0.0, 7.0])[..2], [0.0, 0.0]);
        assert_near(map(Tonemap::Srgb, [-1.0, 0.0, 7.0])[2], 1.0, 1e-6);
        for code in 0..=255 {
            let code = code as f32 / 255.0;
            assert_near(srgb_encode(srgb_decode(code)), code, 1e-6);
        }
    }

    #[test]
    fn agx_puts_middle_grey_in_the_middle_and_fades_bright_colours() {
        let grey = map(Tonemap::Agx, [0.18; 3]);
        assert_near(grey[0], 0.5005, 1e-3);
        assert_near(grey[0], grey[2], 1e-3);
        // Bright red fades to white; clipping would leave it pure.
        let bright_red = map(Tonemap::Agx, [16.0, 0.0, 0.0]);
        assert!(bright_red[0] > bright_red[1] + 0.05, "{bright_red:?}");
        assert!(bright_red[1] > 0.4, "{bright_red:?}");
        assert_near(map(Tonemap::Agx, [100.0; 3])[0], 1.0, 0.01);
        assert_eq!(map(Tonemap::Agx, [0.0; 3]), [0.0; 3]);
    }

    #[test]
    fn agx_agrees_with_the_published_steps() {
        // Steps of the published shader in 64-bit floats, by numpy: (0.7, 0.2, 0.05) to codes of power 2.2, then light, then
        // sRGB codes.
        let found = map(Tonemap::Agx, [0.7, 0.2, 0.05]);
        for (found, expected) in found.into_iter().zip(AGX_ORANGE) {
            assert_near(found, expected, 1e-4);
        }
    }
    const AGX_ORANGE: [f32; 3] = [0.767_632, 0.533_391, 0.338_817];

    #[test]
    fn neutral_is_the_identity_less_its_offset_below_the_shoulder() {
        for colour in [[0.5, 0.3, 0.1], [0.79, 0.2, 0.09], [0.08, 0.08, 0.6]] {
            let found = map(Tonemap::Neutral, colour).map(srgb_decode);
            for channel in 0..3 {
                assert_near(found[channel], colour[channel] - 0.04, 1e-5);
            }
        }
        // A channel at zero has no offset.
        assert_near(srgb_decode(map(Tonemap::Neutral, [0.7, 0.3, 0.0])[0]), 0.7, 1e-5);
        // The shoulder: peak 0.96 compresses to 1 - 0.24² / (0.96 + 0.24 - 0.76).
        assert_near(srgb_decode(map(Tonemap::Neutral, [1.0; 3])[0]), 1.0 - 0.0576 / 0.44, 1e-5);
    }

    #[test]
    fn every_curve_is_monotonic_in_grey_and_continuous() {
        for tonemap in Tonemap::ALL {
            let mut previous = 0.0;
            for step in 0..=4000 {
                let radiance = (step as f32 / 4000.0 * 30.0 - 20.0).exp2();
                let code = map(tonemap, [radiance; 3])[1];
                assert!(code >= previous - 1e-6, "{} falls at {radiance}", tonemap.name());
                assert!(code - previous < 0.02, "{} jumps at {radiance}", tonemap.name());
                previous = code;
            }
        }
    }

    #[test]
    fn bad_pixels_have_a_defined_result() {
        let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, -0.0, 1e-45, -3.0];
        for tonemap in Tonemap::ALL {
            for r in bad {
                for g in bad {
                    for exposure_stops in [0.0, 200.0, -200.0] {
                        let codes = Display { tonemap, exposure_stops }.encode([r, g, 0.5]);
                        assert!(codes.iter().all(|code| (0.0..=1.0).contains(code)), "{tonemap:?} {r} {g}: {codes:?}");
                    }
                }
            }
            assert_eq!(map(tonemap, [f32::NAN, -1.0, 0.0]), map(tonemap, [0.0; 3]));
        }
    }

    #[test]
    fn exposure_is_in_stops_and_names_parse() {
        let display = Display { tonemap: Tonemap::Srgb, exposure_stops: 2.0 };
        assert_eq!(display.encode([0.1; 3]), map(Tonemap::Srgb, [0.4; 3]));
        assert_eq!(display.encode_8bit([0.125, 0.25, 0.0]), [188, 255, 0]);
        for tonemap in Tonemap::ALL {
            assert_eq!(Tonemap::from_name(tonemap.name()), Some(tonemap));
        }
        assert_eq!(Tonemap::from_name("AgX"), None);
        assert_eq!(Tonemap::default(), Tonemap::Agx);
    }
}
