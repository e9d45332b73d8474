//! Dispersion: refractive indices that depend on the wavelength of light.
//!
//! **Idea.** A path chooses a wavelength, uniformly over the visible ones, at the first surface that disperses, and keeps it.
//! From then on its throughput has the colour of that wavelength. The colours of all wavelengths average to white, so that a scene
//! looks the same as without dispersion where all wavelengths go the same way.
//!
//! **Source.** Index: Cauchy's formula n = A + B/λ² (1836), with B from the Abbe number V = (n_d - 1) / (n_F - n_C). Colour: that of
//! `observer.rs`, in linear Rec. 709. Most pure wavelengths are outside of its gamut: their negative parts are
//! left out, so that a spectrum is a little paler than the real one.
//!
//! **Cost.** Noise in colours, which falls with the samples. Nothing without dispersion.

use crate::observer::{LOBES, Lobe, REC709_FROM_XYZ, xyz};
use glam::Vec3;
use std::fmt::Write;
use std::sync::LazyLock;

/// Shortest and longest wavelength of paths, nanometres.
const VISIBLE: [f32; 2] = [390.0, 720.0];
/// Wavelengths of Fraunhofer's lines F, d and C, nanometres.
const FRAUNHOFER: [f32; 3] = [486.13, 587.56, 656.27];

/// Wavelength of a uniform random number, nanometres.
#[inline]
pub fn wavelength(random: f32) -> f32 {
    VISIBLE[0] + (VISIBLE[1] - VISIBLE[0]) * random
}

/// Offset of refractive indices at a wavelength, in units of the difference between the lines F and C.
#[inline]
pub fn index_offset(wavelength: f32) -> f32 {
    (inverse_square(wavelength) - inverse_square(FRAUNHOFER[1]))
        / (inverse_square(FRAUNHOFER[0]) - inverse_square(FRAUNHOFER[2]))
}

/// 1/λ², 1/µm².
fn inverse_square(wavelength: f32) -> f32 {
    1e6 / (wavelength * wavelength)
}

/// Colour of light of a wavelength, linear Rec. 709. Its mean over random wavelengths is 1 in every channel.
#[inline]
pub fn colour(wavelength: f32) -> Vec3 {
    clipped_colour(wavelength) * *SCALE
}

/// Colour without the negative parts.
fn clipped_colour(wavelength: f32) -> Vec3 {
    (REC709_FROM_XYZ * xyz(wavelength)).max(Vec3::ZERO)
}

/// Factors that make the mean of all colours 1.
static SCALE: LazyLock<Vec3> = LazyLock::new(|| {
    const STEPS: u32 = 4096;
    let sum: Vec3 = (0..STEPS).map(|k| clipped_colour(wavelength((k as f32 + 0.5) / STEPS as f32))).sum();
    STEPS as f32 / sum
});

/// Index of refraction at an offset, given that at the line d and the difference between the lines F and C.
#[inline]
pub(super) fn dispersed_index(ior: f32, difference: f32, offset: f32) -> f32 {
    (ior + difference * offset).max(1.0)
}

/// Difference of the index between the lines F and C; none for an Abbe number of 0.
pub(super) fn index_difference(ior: f32, abbe: f32) -> f32 {
    if abbe > 0.0 { (ior - 1.0) / abbe } else { 0.0 }
}

/// The same functions in WGSL. `wavelength_offset` is that of the path at its current surface.
pub fn wgsl() -> String {
    let vector = |v: Vec3| format!("vec3f({:?}, {:?}, {:?})", v.x, v.y, v.z);
    let mut lobes = String::new();
    for Lobe { channel, height, peak, deviations: [below, above] } in LOBES {
        let channel = ["x", "y", "z"][channel];
        writeln!(lobes, "    xyz.{channel} += {height:?} * spectral_lobe(wavelength, {peak:?}, {below:?}, {above:?});")
            .expect("writing to a string");
    }
    let [x, y, z] = [0, 1, 2].map(|axis| vector(REC709_FROM_XYZ.col(axis)));
    let [shortest, longest] = VISIBLE;
    let [f, d, c] = FRAUNHOFER.map(inverse_square);
    format!(
        "// Dispersion. Printed from dispersion.rs.\n\n\
         /// Offset of refractive indices at the wavelength of the path.\n\
         var<private> wavelength_offset: f32;\n\n\
         fn dispersed_index(ior: f32, difference: f32) -> f32 {{\n    \
             return max(ior + difference * wavelength_offset, 1.0);\n}}\n\n\
         /// Index of the surface of the path, relative to what is outside, in scenes with nested dielectrics.\n\
         var<private> surface_index: f32;\n\n\
         /// Index of the solid at the surface of the path, relative to what is outside.\n\
         fn index_at_surface(ior: f32, difference: f32) -> f32 {{\n    \
             if NESTED_DIELECTRICS {{\n        return surface_index;\n    }}\n    \
             return dispersed_index(ior, difference);\n}}\n\n\
         fn wavelength_of(random: f32) -> f32 {{\n    return {shortest:?} + {:?} * random;\n}}\n\n\
         fn index_offset(wavelength: f32) -> f32 {{\n    \
             return (1e6 / (wavelength * wavelength) - {d:?}) / {:?};\n}}\n\n\
         fn spectral_lobe(wavelength: f32, peak: f32, below: f32, above: f32) -> f32 {{\n    \
             let t = (wavelength - peak) / select(above, below, wavelength < peak);\n    \
             return exp(-0.5 * t * t);\n}}\n\n\
         fn wavelength_colour(wavelength: f32) -> vec3f {{\n    var xyz = vec3f(0.0);\n{lobes}    \
             return {} * max(mat3x3f({x}, {y}, {z}) * xyz, vec3f(0.0));\n}}\n",
        longest - shortest,
        f - c,
        vector(*SCALE),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_wavelengths_together_are_white() {
        let count = 10_000;
        let mean: Vec3 = (0..count).map(|k| colour(wavelength((k as f32 + 0.5) / count as f32)) / count as f32).sum();
        assert!((mean - Vec3::ONE).abs().max_element() < 1e-3, "{mean}");
    }

    #[test]
    fn wavelengths_have_their_colours() {
        for (wavelength, channel) in [(460.0, 2), (530.0, 1), (630.0, 0)] {
            let colour = colour(wavelength);
            let largest = colour.max_position();
            assert_eq!(largest, channel, "{wavelength} nm is {colour}");
        }
    }

    #[test]
    fn offsets_are_those_of_the_definition() {
        let [f, d, c] = FRAUNHOFER.map(index_offset);
        assert!((f - c - 1.0).abs() < 1e-5 && d.abs() < 1e-6, "{f} {d} {c}");
        // Flint glass SF10 (Schott): n_d 1.72825, V 28.41, n_F 1.74648, n_C 1.72085; Cauchy's formula fits to 5e-4.
        let difference = index_difference(1.728_25, 28.41);
        let index = |offset| dispersed_index(1.728_25, difference, offset);
        assert!((index(f) - 1.746_48).abs() < 5e-4 && (index(c) - 1.720_85).abs() < 5e-4, "{} {}", index(f), index(c));
        assert!(index_difference(1.5, 0.0) == 0.0);
    }
}
