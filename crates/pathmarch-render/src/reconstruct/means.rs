//! Means of pixels, and how new samples join them.

use super::surfaces::Vectors;
use super::{PixelHistory, luminance};
use crate::intersect::ray::transposed;
use crate::scene::light::LUMINANCE_WEIGHTS;
use glam::Vec3;
use pathmarch_field::number::Mask8;
use wide::f32x8;

/// Mean of a pixel.
#[derive(Clone, Copy, Default)]
#[repr(C)]
pub(super) struct PixelMean {
    pub(super) irradiance: Vec3,
    /// Number of samples in the mean.
    pub(super) length: f32,
    /// Means of the luminance and of its square, over samples.
    pub(super) moments: [f32; 2],
    /// Position in the last picture of what is in the middle of the pixel, pixels of that picture from its top left corner; missing
    /// numbers where it was hidden.
    pub(super) before: [f32; 2],
}

/// Means of eight pixels.
#[derive(Clone, Copy)]
pub(super) struct Means {
    pub(super) irradiance: Vectors,
    pub(super) length: f32x8,
    pub(super) moments: [f32x8; 2],
    pub(super) before: [f32x8; 2],
}

/// New samples of each pixel.
pub(super) struct Samples<'a> {
    /// Means of the irradiance.
    pub(super) irradiance: &'a [Vec3],
    /// Number of samples in each mean.
    pub(super) count: f32,
}

impl PixelMean {
    /// A mean from its numbers, in their order in memory.
    fn from_row([r, g, b, length, mean, square, x, y]: [f32; 8]) -> Self {
        Self { irradiance: Vec3::new(r, g, b), length, moments: [mean, square], before: [x, y] }
    }

    /// History of the pixel.
    pub(super) fn history(&self) -> PixelHistory {
        let is_known = !self.before[0].is_nan();
        PixelHistory { before: is_known.then_some(self.before), length: self.length }
    }

    #[inline(always)]
    fn row(&self) -> [f32; 8] {
        let &Self { irradiance, length, moments: [mean, square], before: [x, y] } = self;
        [irradiance.x, irradiance.y, irradiance.z, length, mean, square, x, y]
    }
}

impl Means {
    /// Means of these numbers: red, green, blue, length, mean, square and the earlier position.
    #[inline(always)]
    fn from_lanes([r, g, b, length, mean, square, x, y]: [f32x8; 8]) -> Self {
        Self { irradiance: Vectors::new(r, g, b), length, moments: [mean, square], before: [x, y] }
    }

    /// Means of the pixels of these indices.
    #[inline(always)]
    pub(super) fn gathered(means: &[PixelMean], indices: [usize; 8]) -> Self {
        Self::from_lanes(transposed(indices.map(|index| means[index].row())))
    }

    /// The means, one by one.
    #[inline(always)]
    pub(super) fn each(self) -> [PixelMean; 8] {
        let Self { irradiance: Vectors { x: r, y: g, z: b }, length, moments: [mean, square], before: [x, y] } = self;
        f32x8::transpose([r, g, b, length, mean, square, x, y]).map(|row| PixelMean::from_row(row.to_array()))
    }

    /// Means of new samples alone of the pixels of these indices; `square` gives that of the luminance of several samples
    /// from the index and their luminance.
    #[inline(always)]
    pub(super) fn alone(new: &Samples, indices: [usize; 8], square: impl Fn(usize, f32) -> f32) -> Self {
        let row = |index: usize| {
            let irradiance = new.irradiance[index];
            let mean = luminance(irradiance);
            // Fireflies of a single sample have been spread.
            let square = if new.count > 1.0 { square(index, mean) } else { mean * mean };
            [irradiance.x, irradiance.y, irradiance.z, new.count, mean, square, f32::NAN, f32::NAN]
        };
        Self::from_lanes(transposed(indices.map(row)))
    }

    /// These, in light that is multiplied by factors of its channels.
    #[inline(always)]
    pub(super) fn scaled(self, factors: Vectors) -> Self {
        let irradiance = self.irradiance.times(factors);
        self.in_light(irradiance, luminances(irradiance) / luminances(self.irradiance).fast_max(f32x8::splat(1e-9)))
    }

    /// These with another irradiance, whose luminance is theirs multiplied by a factor.
    #[inline(always)]
    fn in_light(self, irradiance: Vectors, factor: f32x8) -> Self {
        let moments = [self.moments[0] * factor, self.moments[1] * factor * factor];
        Self { irradiance, moments, ..self }
    }

    /// These where the mask is set, else others.
    #[inline(always)]
    fn select(self, mask: f32x8, others: Self) -> Self {
        let pair = |a: [f32x8; 2], b: [f32x8; 2]| [mask.select(a[0], b[0]), mask.select(a[1], b[1])];
        Self {
            irradiance: Vectors::select(Mask8(mask), self.irradiance, others.irradiance),
            length: mask.select(self.length, others.length),
            moments: pair(self.moments, others.moments),
            before: pair(self.before, others.before),
        }
    }
}

/// Means of the past of eight pixels, and the mask of those that have one.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub(super) means: Means,
    pub(super) mask: f32x8,
}

impl Found {
    /// No past.
    pub(super) const NONE: Self = {
        let nothing = Vectors::new(f32x8::ZERO, f32x8::ZERO, f32x8::ZERO);
        let means =
            Means { irradiance: nothing, length: f32x8::ZERO, moments: [f32x8::ZERO; 2], before: [f32x8::ZERO; 2] };
        Self { means, mask: f32x8::ZERO }
    };

    /// These, and others where there are none.
    #[inline(always)]
    pub(super) fn or(self, others: Self) -> Self {
        Self { means: self.means.select(self.mask, others.means), mask: self.mask | others.mask }
    }

    /// These with a luminance within limits, if they have any, and with at most so many samples.
    #[inline(always)]
    pub(super) fn limited(self, limits: Option<[f32x8; 2]>, max_length: f32x8) -> Self {
        let Self { mut means, mask } = self;
        if let Some([least, most]) = limits {
            let old = luminances(means.irradiance);
            let clamped = old.fast_max(least).fast_min(most);
            let factor = clamped / old.fast_max(f32x8::splat(1e-9));
            means = means.in_light(means.irradiance * factor, factor);
            // The less of it is plausible, the fewer samples it is worth.
            let agreement = (clamped.fast_min(old) + 1e-9) / (clamped.fast_max(old) + 1e-9);
            means.length *= agreement * agreement;
        }
        means.length = means.length.fast_min(max_length);
        Self { means, mask }
    }

    /// Joins the means of the past with those of new samples.
    #[inline(always)]
    pub(super) fn joined(self, new: Means) -> Means {
        let old = self.means;
        let share = new.length / (new.length + old.length);
        let mean = |old: f32x8, new: f32x8| old + (new - old) * share;
        let joined = Means {
            irradiance: old.irradiance + (new.irradiance - old.irradiance) * share,
            length: new.length + old.length,
            moments: [mean(old.moments[0], new.moments[0]), mean(old.moments[1], new.moments[1])],
            before: old.before,
        };
        joined.select(self.mask, new)
    }
}

/// Luminances of linear Rec. 709 colours.
#[inline(always)]
pub(super) fn luminances(colour: Vectors) -> f32x8 {
    let [r, g, b] = LUMINANCE_WEIGHTS;
    colour.x * r + colour.y * g + colour.z * b
}
