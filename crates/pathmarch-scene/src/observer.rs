//! The CIE 1931 observer: colours of wavelengths.
//!
//! **Source.** Sums of lobes: Wyman et al. 2013, section 2.2. Matrix: ITU-R BT.709, white point D65.

use glam::{Mat3, Vec3};

/// Lobe of a colour matching function: a Gaussian with a standard deviation for each side.
pub(crate) struct Lobe {
    /// Channel of XYZ.
    pub(crate) channel: usize,
    pub(crate) height: f32,
    /// Wavelength of its peak, nanometres.
    pub(crate) peak: f32,
    /// Standard deviations below and above the peak, nanometres.
    pub(crate) deviations: [f32; 2],
}

const fn lobe(channel: usize, height: f32, peak: f32, deviations: [f32; 2]) -> Lobe {
    Lobe { channel, height, peak, deviations }
}

/// The lobes of all three functions.
pub(crate) const LOBES: [Lobe; 7] = [
    lobe(0, 1.056, 599.8, [37.9, 31.0]),
    lobe(0, 0.362, 442.0, [16.0, 26.7]),
    lobe(0, -0.065, 501.1, [20.4, 26.2]),
    lobe(1, 0.821, 568.8, [46.9, 40.5]),
    lobe(1, 0.286, 530.9, [16.3, 31.1]),
    lobe(2, 1.217, 437.0, [11.8, 36.0]),
    lobe(2, 0.681, 459.0, [26.0, 13.8]),
];

/// Columns of the matrix from XYZ to linear Rec. 709.
pub(crate) const REC709_FROM_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(3.2406, -0.9689, 0.0557),
    Vec3::new(-1.5372, 1.8758, -0.2040),
    Vec3::new(-0.4986, 0.0415, 1.0570),
);

/// XYZ of light of a wavelength, in nanometres.
pub(crate) fn xyz(wavelength: f32) -> Vec3 {
    let mut xyz = Vec3::ZERO;
    for Lobe { channel, height, peak, deviations: [below, above] } in LOBES {
        let t = (wavelength - peak) / if wavelength < peak { below } else { above };
        xyz[channel] += height * (-0.5 * t * t).exp();
    }
    xyz
}
