//! Signal of the filter: irradiance of both halves, and the mean features of each pixel.

use super::features::{Features, PixelFeatures};
use super::grid::Grid;
use crate::output::half_films::HalfFilms;
use glam::Vec3;
use rayon::prelude::*;

/// Least albedo to divide by.
const MIN_ALBEDO: f32 = 0.01;

/// Class of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PixelClass {
    /// All its rays reach surfaces that scatter light: it is filtered.
    Surface,
    /// Some of its rays reach light sources or the sky: it is predicted from its neighbours.
    Mixed,
    /// It has no surface that scatters light, so that it has no noise but that of edges.
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
    /// Means of sums over `rays` rays; `pixel` is the side of a pixel at a distance of one metre.
    fn new(sums: &PixelFeatures, rays: f32, pixel: f32) -> Self {
        let scale = sums.surfaces.max(1.0).recip();
        let mut surface = Self {
            class: PixelClass::Surface,
            albedo: (sums.albedo / rays).max(Vec3::splat(MIN_ALBEDO)),
            emission: sums.emission / rays,
            normal: sums.normal * scale,
            position: sums.position * scale,
            footprint: sums.length * scale * pixel,
            material: sums.material * scale,
        };
        let finite = surface.position.is_finite() && surface.albedo.is_finite() && surface.emission.is_finite();
        if sums.surfaces == 0.0 || !finite {
            surface.class = PixelClass::Source;
        } else if surface.emission != Vec3::ZERO {
            surface.class = PixelClass::Mixed;
        }
        surface
    }
}

/// Irradiance and features of a picture.
pub(super) struct Signal {
    pub(super) grid: Grid,
    pub(super) surfaces: Vec<Surface>,
    /// Weight of each pixel in means: 1 for [`PixelClass::Surface`], else 0.
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
}

impl Signal {
    /// Signal of a picture with these features.
    pub(super) fn new(buffers: &HalfFilms, features: &Features) -> Self {
        let (rays, pixel, rect) = (2.0 * features.rays as f32, features.pixel, buffers.rect());
        let halves = features.halves[0].par_iter().zip(&features.halves[1]);
        let surfaces: Vec<Surface> = halves
            .map(|(first, second)| {
                let mut sums = *first;
                sums += *second;
                Surface::new(&sums, rays, pixel)
            })
            .collect();
        let is_surface = |surface: &Surface| f32::from(u8::from(surface.class == PixelClass::Surface));
        let weights = surfaces.par_iter().map(is_surface).collect();
        let means = buffers.means();
        let irradiance = |radiance: &[Vec3]| -> Vec<Vec3> {
            let pixels = radiance.par_iter().zip(&surfaces);
            pixels.map(|(radiance, surface)| (*radiance - surface.emission) / surface.albedo).collect()
        };
        Self {
            grid: Grid { width: rect.width as usize, height: rect.height as usize },
            weights,
            halves: [irradiance(&means.halves[0]), irradiance(&means.halves[1])],
            whole: irradiance(&means.whole),
            radiance: means.whole,
            share: means.first_share,
            surfaces,
        }
    }

    /// True if the halves are independent; false for a single sample, which is in one of them.
    pub(super) fn has_two_halves(&self) -> bool {
        self.share > 0.0 && self.share < 1.0
    }
}

/// Mean of the channels.
#[inline(always)]
pub(super) fn mean_channel(colour: Vec3) -> f32 {
    (colour.x + colour.y + colour.z) * (1.0 / 3.0)
}
