//! Spreading of fireflies: single samples far above their neighbours.

use super::luminance;
use super::planes::{Place, Planes, SQUARE_OF_3, square_around};
use super::surfaces::{SurfacePlanes, are_of, class_of};
use crate::integrator::guides::GuideClass;
use crate::intersect::ray::set_bits;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use wide::f32x8;

shared_constants! {
    /// Luminance above the mean of the neighbours, in such means, from which on a single sample is a firefly. The mean of
    /// several samples is one from that divided by the root of their number on.
    const FIREFLY: f32 = 3.0;
    /// Half the side of the square that takes the energy of a firefly, pixels.
    const FIREFLY_RADIUS: i32 = 2;
    /// Least cosine between the normals of a firefly and of those.
    const MIN_FIREFLY_COSINE: f32 = 0.7;
}

/// Offsets to the pixels of that square.
const SQUARE: [(i32, i32); 24] = square_around(FIREFLY_RADIUS);

/// Firefly in a picture.
struct Firefly {
    /// Index of its pixel.
    index: usize,
    /// Light above its limit.
    excess: Vec3,
    /// Pixels that take this light: bits of [`SQUARE`].
    takers: u32,
}

/// Planes of a picture that are searched for fireflies.
struct Search<'a> {
    surfaces: &'a SurfacePlanes,
    luminances: &'a Planes<1>,
    /// Limit of a pixel, in means of the pixels around it.
    limit: f32,
}

/// Adjoining pixels around a place that show its surfaces: the mask of each offset of [`SQUARE`], and the limits of the
/// pixels in the middle; 0 without light around them.
struct Around {
    masks: [u32; 24],
    limits: f32x8,
}

impl Search<'_> {
    /// Mask of those of eight pixels that are brighter than all next to them. Most are not.
    #[inline(always)]
    fn peaks(&self, place: Place) -> f32x8 {
        let mut most = f32x8::splat(-1.0);
        for &(dx, dy) in &SQUARE_OF_3 {
            if let Some(there) = place.moved(self.surfaces.grid, dx, dy) {
                most = most.fast_max(self.luminances.load(0, there));
            }
        }
        self.luminances.load(0, place).simd_gt(most)
    }

    #[inline(always)]
    fn around(&self, place: Place) -> Around {
        let (part, normal) = (self.surfaces.part(place), self.surfaces.seen_normal(place));
        let is_glass = are_of(part, GuideClass::Glass);
        let (mut masks, mut sum, mut count) = ([0; 24], f32x8::ZERO, f32x8::ZERO);
        for (mask, &(dx, dy)) in masks.iter_mut().zip(&SQUARE) {
            let Some(there) = place.moved(self.surfaces.grid, dx, dy) else { continue };
            let faces = normal.dot(self.surfaces.seen_normal(there)).simd_gt(f32x8::splat(MIN_FIREFLY_COSINE));
            let shares = part.simd_eq(self.surfaces.part(there)) & (is_glass | faces);
            sum += shares & self.luminances.load(0, there);
            count += shares & f32x8::ONE;
            *mask = shares.to_bitmask();
        }
        Around { masks, limits: sum * self.limit / count.fast_max(f32x8::ONE) }
    }

    /// Fireflies among eight pixels.
    fn fireflies(&self, place: Place, irradiance: &[Vec3], found: &mut Vec<Firefly>) {
        let has_noise = class_of(self.surfaces.part(place)).simd_ge(f32x8::splat(GuideClass::Glass as u32 as f32));
        let peaks = self.peaks(place) & has_noise;
        if peaks.none() {
            return;
        }
        let Around { masks, limits } = self.around(place);
        let lights = self.luminances.load(0, place);
        // Without light around it, nothing tells a firefly from the only lit pixel.
        let are_above = peaks & limits.simd_gt(f32x8::ZERO) & lights.simd_gt(limits);
        let (limits, lights, indices) = (limits.to_array(), lights.to_array(), place.indices(self.surfaces.grid));
        for lane in set_bits(are_above.to_bitmask()) {
            let index = indices[lane];
            let takers = masks.iter().enumerate().map(|(k, mask)| (mask >> lane & 1) << k).sum();
            found.push(Firefly { index, excess: irradiance[index] * (1.0 - limits[lane] / lights[lane]), takers });
        }
    }
}

/// Limits means of so many samples that are far above their neighbours, and gives what is above to the neighbours on the
/// same surface.
pub(super) fn spread_fireflies(surfaces: &SurfacePlanes, samples: f32, irradiance: &mut [Vec3]) {
    let grid = surfaces.grid;
    let luminances = &Planes::new(grid, [-1.0], |index| [luminance(irradiance[index])]);
    let search = Search { surfaces, luminances, limit: 1.0 + FIREFLY / samples.sqrt() };
    let light = &*irradiance;
    let in_row = |row: i32| {
        let mut found = Vec::new();
        grid.places(row).for_each(|place| search.fireflies(place, light, &mut found));
        found
    };
    let found: Vec<Firefly> = (0..grid.height).into_par_iter().with_min_len(8).flat_map_iter(in_row).collect();
    for Firefly { index, excess, takers } in found {
        irradiance[index] -= excess;
        let share = excess / takers.count_ones() as f32;
        for k in set_bits(takers) {
            let (dx, dy) = SQUARE[k];
            irradiance[(index as i32 + dy * grid.width + dx) as usize] += share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::guides::Guide;
    use crate::scene::FrameUniforms;
    use bytemuck::Zeroable;

    #[test]
    fn fireflies_keep_their_energy() {
        let guide = Guide { class: GuideClass::Surface, normal: Vec3::Y, seen_normal: Vec3::Y, ..Guide::NONE };
        let guides = vec![guide; 49];
        let mut irradiance = vec![Vec3::splat(0.5); 49];
        irradiance[24] = Vec3::new(100.0, 50.0, 25.0);
        let sum: Vec3 = irradiance.iter().sum();
        let frame = FrameUniforms { width: 7, height: 7, ..FrameUniforms::zeroed() };
        spread_fireflies(&SurfacePlanes::new(&frame, &guides, false), 1.0, &mut irradiance);
        let after: Vec3 = irradiance.iter().sum();
        assert!((sum - after).abs().max_element() < 1e-3, "{sum} {after}");
        assert!(luminance(irradiance[24]) < 2.1 && irradiance[0] == Vec3::splat(0.5), "{}", irradiance[24]);
        assert!(irradiance[23].x > 1.0);
    }
}
