//! Signal of the filter: irradiance of both halves, and the mean features of each pixel.

use super::features::{Features, PixelFeatures};
use super::grid::Grid;
use super::halves::HalfBuffers;
use glam::Vec3;
use rayon::prelude::*;

/// Least albedo to divide by.
const MIN_ALBEDO: f32 = 0.01;
/// Relative difference of the emission of both halves of the rays from which on a pixel shows different light sources.
const MIN_EMISSION_DIFFERENCE: f32 = 0.02;

/// Class of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PixelClass {
    /// All its rays reach surfaces that scatter light: it is filtered.
    Surface,
    /// Some of its rays reach light sources or the sky: it is predicted from its neighbours.
    Mixed,
    /// Its rays reach different light sources, through glass, a lens or at an edge.
    MixedSource,
    /// All its rays reach one light source or the sky: it has no noise.
    Source,
}

/// Mean features of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) class: PixelClass,
    /// Albedo, 0 for rays to light sources; at least [`MIN_ALBEDO`].
    pub(super) albedo: Vec3,
    /// Radiance of light sources.
    pub(super) emission: Vec3,
    pub(super) normal: Vec3,
    /// Position in world space, metres.
    pub(super) position: Vec3,
    /// Side of the pixel, projected to the surface, metres.
    pub(super) footprint: f32,
    /// Hash of the material, 0 to 1.
    pub(super) material: f32,
}

impl Surface {
    /// Means of sums over both halves of `rays` rays; `pixel` is the side of a pixel at a distance of one metre.
    fn new(halves: [&PixelFeatures; 2], rays: f32, pixel: f32) -> Self {
        let mut sums = *halves[0];
        sums += *halves[1];
        let scale = sums.surfaces.max(1.0).recip();
        let mut surface = Self {
            class: PixelClass::Surface,
            albedo: (sums.albedo / (2.0 * rays)).max(Vec3::splat(MIN_ALBEDO)),
            emission: sums.emission / (2.0 * rays),
            normal: sums.normal * scale,
            position: sums.position * scale,
            footprint: sums.length * scale * pixel,
            material: sums.material * scale,
        };
        let finite = surface.position.is_finite() && surface.albedo.is_finite() && surface.emission.is_finite();
        let difference = mean_channel((halves[0].emission - halves[1].emission).abs());
        surface.class = match () {
            () if !finite => PixelClass::Source,
            () if sums.surfaces > 0.0 && surface.emission == Vec3::ZERO => PixelClass::Surface,
            () if sums.surfaces > 0.0 => PixelClass::Mixed,
            () if difference > MIN_EMISSION_DIFFERENCE * mean_channel(sums.emission) => PixelClass::MixedSource,
            () => PixelClass::Source,
        };
        surface
    }

    /// Surface without features, that is fitted if `is_fitted`.
    fn without_features(is_fitted: bool) -> Self {
        Self {
            class: if is_fitted { PixelClass::Surface } else { PixelClass::Source },
            albedo: Vec3::ONE,
            emission: Vec3::ZERO,
            normal: Vec3::ZERO,
            position: Vec3::ZERO,
            footprint: 1.0,
            material: 0.0,
        }
    }
}

/// Irradiance and features of a picture.
pub(super) struct Signal {
    pub(super) grid: Grid,
    pub(super) surfaces: Vec<Surface>,
    /// Weight of each pixel in means.
    pub(super) weights: Vec<f32>,
    /// Radiance divided by the albedo, of both halves of the samples. Called irradiance, though it is so only for
    /// diffuse surfaces, and without the factor π.
    pub(super) halves: [Vec<Vec3>; 2],
    /// Irradiance of all samples.
    pub(super) whole: Vec<Vec3>,
    /// Radiance of all samples.
    pub(super) radiance: Vec<Vec3>,
    /// Share of the first half in all samples.
    pub(super) share: f32,
    /// True for all surfaces of a picture; false for [`Signal::of_mixed_pixels`].
    pub(super) is_whole_picture: bool,
}

impl Signal {
    /// Signal of a picture with these features.
    pub(super) fn new(buffers: &HalfBuffers, features: &Features) -> Self {
        let film = buffers.film();
        let halves = features.halves[0].par_iter().zip(&features.halves[1]);
        let surface = |(first, second)| Surface::new([first, second], features.rays as f32, features.pixel);
        let surfaces: Vec<Surface> = halves.map(surface).collect();
        let means = buffers.means();
        let irradiance = |radiance: &[Vec3]| -> Vec<Vec3> {
            let pixels = radiance.par_iter().zip(&surfaces);
            pixels.map(|(radiance, surface)| (*radiance - surface.emission) / surface.albedo).collect()
        };
        Self {
            grid: Grid { width: film.width as usize, height: film.height as usize },
            weights: weights_of(&surfaces),
            halves: [irradiance(&means.halves[0]), irradiance(&means.halves[1])],
            whole: irradiance(&means.whole),
            radiance: means.whole,
            share: means.first_share,
            surfaces,
            is_whole_picture: true,
        }
    }

    /// Radiance of the pixels of class [`PixelClass::Mixed`] and [`PixelClass::MixedSource`], as the irradiance of
    /// surfaces without features.
    pub(super) fn of_mixed_pixels(&self) -> Self {
        let is_mixed = |surface: &Surface| matches!(surface.class, PixelClass::Mixed | PixelClass::MixedSource);
        let radiance = |irradiance: &[Vec3]| -> Vec<Vec3> {
            let pixels = irradiance.par_iter().zip(&self.surfaces);
            pixels.map(|(irradiance, surface)| *irradiance * surface.albedo + surface.emission).collect()
        };
        let surfaces: Vec<Surface> =
            self.surfaces.par_iter().map(|surface| Surface::without_features(is_mixed(surface))).collect();
        Self {
            grid: self.grid,
            weights: weights_of(&surfaces),
            halves: [radiance(&self.halves[0]), radiance(&self.halves[1])],
            whole: self.radiance.clone(),
            radiance: self.radiance.clone(),
            share: self.share,
            surfaces,
            is_whole_picture: false,
        }
    }

    /// True if the halves are independent; false for a single sample, which is in one of them.
    pub(super) fn has_two_halves(&self) -> bool {
        self.share > 0.0 && self.share < 1.0
    }
}

/// 1 for pixels of class [`PixelClass::Surface`], else 0.
fn weights_of(surfaces: &[Surface]) -> Vec<f32> {
    surfaces.par_iter().map(|surface| f32::from(u8::from(surface.class == PixelClass::Surface))).collect()
}

/// Mean of the channels.
#[inline(always)]
pub(super) fn mean_channel(colour: Vec3) -> f32 {
    (colour.x + colour.y + colour.z) * (1.0 / 3.0)
}
