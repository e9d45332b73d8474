//! Means of the past after a change of the scene, in which they may show other light.
//!
//! **Idea.** (1) The past of a pixel is multiplied by the ratio of the sums of new samples and of their past over the pixels
//! of its surface in a square. So light that moves, dims or changes its colour does not lag where it changes smoothly.
//! (2) After that, new samples and past differ in 3x3 pixels by their noise alone, with a mean near zero. What this mean has
//! beyond one standard error is an error of the past, as where the edge of a shadow moves, and the past counts as many
//! samples as make the expected squared error least.
//!
//! **Source.** Temporal gradients: Schied et al. 2018, "Gradient Estimation for Real-Time Adaptive Temporal Filtering",
//! which trace some samples of the last picture again; here the samples are compared with the means of the past. The number
//! of samples: the gain of Kalman 1960, "A New Approach to Linear Filtering and Prediction Problems".

use super::means::{Found, Means, PixelMean, luminances};
use super::planes::{Place, Planes, SQUARE_OF_3, by_eight, sums_where};
use super::surfaces::{MIN_NORMAL_COSINE, SurfacePlanes, Vectors};
use crate::wgsl::shared_constants;
use glam::Vec3;
use pathmarch_field::number::Mask8;
use wide::f32x8;

shared_constants! {
    /// Half the side of the square over which the light of new samples is compared with that of the past, pixels.
    const LIGHT_RADIUS: i32 = 7;
    /// Least number of pixels by which the past is scaled.
    const MIN_SCALED_PIXELS: f32 = 6.0;
    /// Largest factor of the past.
    const MAX_LIGHT_FACTOR: f32 = 5.0;
    /// Least irradiance that the past is divided by.
    const MIN_PAST_LIGHT: f32 = 1e-9;
    /// Least number of pixels whose differences show their noise.
    const MIN_COMPARED_PIXELS: f32 = 4.0;
    /// Standard deviation that counts as rounding, in luminances of the past.
    const LIGHT_ROUNDING: f32 = 1e-4;
}

/// Joins new samples of the irradiance with the past that `find` finds for eight pixels; `alone` gives the means of their new
/// samples.
pub(super) fn joined(
    surfaces: &SurfacePlanes,
    irradiance: &[Vec3],
    find: impl Fn(Place) -> Found + Sync,
    alone: impl Fn(Place) -> Means + Sync,
) -> Vec<PixelMean> {
    let grid = surfaces.grid;
    let found = by_eight(grid, |place| find(place).or(Found::NONE).means.each());
    let show_one_side = |here: Place, there: Place| surfaces.show_one_side(here, there, MIN_NORMAL_COSINE);
    let light = |index: usize| {
        let (new, PixelMean { irradiance: old, length, .. }) = (irradiance[index], found[index]);
        if length > 0.0 { [new.x, new.y, new.z, old.x, old.y, old.z, 1.0] } else { [0.0; 7] }
    };
    let light = sums_where(grid, LIGHT_RADIUS, light, show_one_side);
    // Factors of the past, differences of new samples from what it is then, and 1 where there is one.
    let scaled: Planes<5> = Planes::of_eight(grid, |place| {
        let factor = factors(light.lanes(place));
        let past = Means::gathered(&found, place.indices(grid));
        let new = luminances(alone(place).irradiance);
        let has_past = past.length.simd_gt(f32x8::ZERO);
        let difference = has_past & (new - luminances(past.irradiance.times(factor)));
        [factor.x, factor.y, factor.z, difference, has_past & f32x8::ONE]
    });
    by_eight(grid, |place| {
        let [r, g, b, difference, has_past] = scaled.lanes(place);
        let past = Means::gathered(&found, place.indices(grid)).scaled(Vectors::new(r, g, b));
        let (mut sums, mut squares, mut count) = (difference, difference * difference, has_past);
        for &(dx, dy) in &SQUARE_OF_3 {
            let Some(there) = place.moved(grid, dx, dy) else { continue };
            let shared = show_one_side(place, there);
            let difference = shared & scaled.load(3, there);
            sums += difference;
            squares += difference * difference;
            count += shared & scaled.load(4, there);
        }
        let length = plausible_length(&past, [sums, squares, count]);
        let found = Found { means: Means { length, ..past }, mask: has_past.simd_gt(f32x8::ZERO) };
        found.joined(alone(place)).each()
    })
}

/// Factors of the past from these sums over pixels: new light and past light, red, green and blue each, and 1.
#[inline(always)]
fn factors([r, g, b, old_r, old_g, old_b, count]: [f32x8; 7]) -> Vectors {
    let ratio = |new: f32x8, old: f32x8| {
        (new / old.fast_max(f32x8::splat(MIN_PAST_LIGHT))).fast_min(f32x8::splat(MAX_LIGHT_FACTOR))
    };
    let ratios = Vectors::new(ratio(r, old_r), ratio(g, old_g), ratio(b, old_b));
    let are_known = Mask8(count.simd_ge(f32x8::splat(MIN_SCALED_PIXELS)));
    Vectors::select(are_known, ratios, Vectors::splat(f32x8::ONE))
}

/// Samples that the past counts, from these sums over the differences of new samples from it: they, their squares and 1.
#[inline(always)]
fn plausible_length(past: &Means, [sum, squares, count]: [f32x8; 3]) -> f32x8 {
    let mean = sum / count;
    let around = (squares - mean * sum) / (count - 1.0).fast_max(f32x8::ONE);
    let [old, square] = past.moments;
    let own = square - old * old;
    let rounding = old * LIGHT_ROUNDING;
    let variance = count.simd_ge(f32x8::splat(MIN_COMPARED_PIXELS)).select(around, own).fast_max(rounding * rounding);
    let error = (mean * mean - variance / count).fast_max(f32x8::ZERO);
    let length = past.length * variance / (error * past.length + variance);
    error.simd_gt(f32x8::ZERO).select(length, past.length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrator::guides::{Guide, GuideClass};
    use crate::reconstruct::luminance;
    use crate::scene::FrameUniforms;
    use bytemuck::Zeroable;

    /// Means of a picture of 40x30 pixels after a change of the scene. Columns have normals, pixels have a past of six samples and
    /// new light, by column and row.
    fn after_a_change(
        normal: impl Fn(usize) -> Vec3,
        past: impl Fn(usize, usize) -> Vec3,
        new: impl Fn(usize, usize) -> Vec3,
    ) -> Vec<PixelMean> {
        let pixels = || (0..1200).map(|index| (index % 40, index / 40));
        let guide = |normal: Vec3| Guide { class: GuideClass::Surface, normal, seen_normal: normal, ..Guide::NONE };
        let guides: Vec<Guide> = pixels().map(|(x, _)| guide(normal(x))).collect();
        let frame = FrameUniforms { width: 40, height: 30, ..FrameUniforms::zeroed() };
        let surfaces = SurfacePlanes::new(&frame, &guides, false);
        let mean = |irradiance: Vec3, length: f32| {
            let mean = luminance(irradiance);
            PixelMean { irradiance, length, moments: [mean, 1.25 * mean * mean], before: [0.0; 2] }
        };
        let old: Vec<PixelMean> = pixels().map(|(x, y)| mean(past(x, y), 6.0)).collect();
        let irradiance: Vec<Vec3> = pixels().map(|(x, y)| new(x, y)).collect();
        let alone: Vec<PixelMean> = irradiance.iter().map(|irradiance| mean(*irradiance, 1.0)).collect();
        let means = |means: &[PixelMean], place: Place| Means::gathered(means, place.indices(surfaces.grid));
        let find = |place: Place| Found { means: means(&old, place), mask: f32x8::ZERO.simd_eq(f32x8::ZERO) };
        joined(&surfaces, &irradiance, find, |place| means(&alone, place))
    }

    /// Normal of a wall.
    fn flat(_: usize) -> Vec3 {
        Vec3::Z
    }

    /// Noise of a pixel, -1 or 1, which has little pattern.
    fn noise(x: usize, y: usize) -> f32 {
        let hash = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
        if (hash.wrapping_mul(0xc2b2_ae3d) >> 17) & 1 == 0 { -1.0 } else { 1.0 }
    }

    #[test]
    fn the_past_follows_light_that_changes_everywhere() {
        let past = |x: usize, _: usize| Vec3::splat(1.0 + 0.05 * x as f32);
        let tint = Vec3::new(0.25, 0.5, 1.5);
        let means = after_a_change(flat, past, |x, y| past(x, y) * tint);
        for (index, mean) in means.iter().enumerate() {
            let truth = past(index % 40, 0) * tint;
            assert!((mean.irradiance - truth).abs().max_element() < 1e-4, "{} {truth}", mean.irradiance);
            assert_eq!(mean.length, 7.0);
            // The noise of the past is in proportion to its light.
            let [first, square] = mean.moments;
            assert!((square / (first * first) - 1.25).abs() < 0.01, "{first} {square}");
        }
    }

    #[test]
    fn noise_alone_keeps_most_of_the_past() {
        let means = after_a_change(flat, |_, _| Vec3::ONE, |x, y| Vec3::splat(1.0 + 0.9 * noise(x, y)));
        let length = means.iter().map(|mean| mean.length).sum::<f32>() / 1200.0;
        assert!(length > 5.0, "{length}");
        // Samples alone deviate by 0.9.
        let square = means.iter().map(|mean| (mean.irradiance.x - 1.0).powi(2)).sum::<f32>() / 1200.0;
        assert!(square.sqrt() < 0.45, "{}", square.sqrt());
    }

    #[test]
    fn shadows_are_where_they_are_now() {
        let lit = |edge: usize| move |x: usize, _: usize| if x < edge { Vec3::ONE } else { Vec3::splat(0.2) };
        let means = after_a_change(flat, lit(24), lit(20));
        for (index, mean) in means.iter().enumerate() {
            let (x, truth) = (index % 40, lit(20)(index % 40, 0).x);
            let error = (mean.irradiance.x - truth).abs();
            // Beside the edge, where some of the nine pixels have changed and others have not, it is less than half of the change.
            let most = if (19..=24).contains(&x) { 0.4 } else { 0.06 };
            assert!(error < most, "{x}: {} {truth}", mean.irradiance.x);
            // Without comparison, six of seven parts of the light that the pixel had would be left.
            assert!(!(21..23).contains(&x) || mean.length < 1.5, "{x}: {}", mean.length);
        }
    }

    #[test]
    fn surfaces_are_compared_apart() {
        // One side of an edge gets darker, the other brighter.
        let light = |x: usize| if x < 20 { 0.5 } else { 2.0 };
        let normal = |x: usize| if x < 20 { Vec3::Z } else { Vec3::X };
        let means = after_a_change(normal, |_, _| Vec3::ONE, |x, _| Vec3::splat(light(x)));
        for (index, mean) in means.iter().enumerate() {
            let error = (mean.irradiance.x - light(index % 40)).abs();
            assert!(error < 1e-5 && mean.length == 7.0, "{index}: {}", mean.irradiance);
        }
    }
}
