//! Spreading of fireflies: single samples far above their neighbours.

use super::luminance;
use super::planes::{Grid, MARGIN, Place, Planes, square_around};
use crate::integrator::guides::{Guide, GuideClass};
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
}

/// Columns of those of eight pixels that are brighter than all next to them.
fn peaks(grid: Grid, luminances: &Planes<1>, place: Place) -> impl Iterator<Item = i32> + use<> {
    let here = luminances.load(0, place);
    let others = square_around(1).filter_map(|(dx, dy)| place.moved(grid, dx, dy));
    let most = others.fold(f32x8::splat(-1.0), |most, other| most.max(luminances.load(0, other)));
    let is_peak = here.simd_gt(most).to_bitmask();
    let first = place.column - MARGIN as i32;
    (0..8).filter(move |lane| is_peak & (1 << lane) != 0).map(move |lane| first + lane)
}

/// Limits means of so many samples that are far above their neighbours, and gives what is above to the neighbours on the
/// same surface.
pub(super) fn spread_fireflies(size: [u32; 2], guides: &[Guide], samples: f32, irradiance: &mut [Vec3]) {
    let grid = Grid::new(size);
    let luminances = Planes::new(grid, [-1.0], |index| [luminance(irradiance[index])]);
    let shares = |centre: usize, index: &usize| {
        let (a, b) = (&guides[centre], &guides[*index]);
        let is_glass = a.class == GuideClass::Glass;
        a.class == b.class && a.object == b.object && (is_glass || a.seen_normal.dot(b.seen_normal) > 0.7)
    };
    let excess = |x: i32, y: i32| -> Option<(usize, Vec3)> {
        let centre = (y * grid.width + x) as usize;
        if matches!(guides[centre].class, GuideClass::Sky | GuideClass::Emitter) {
            return None;
        }
        let light = luminance(irradiance[centre]);
        let (mut sum, mut count) = (0.0, 0.0);
        for index in grid.around(x, y, FIREFLY_RADIUS).filter(|index| shares(centre, index)) {
            sum += luminance(irradiance[index]);
            count += 1.0;
        }
        let limit = (1.0 + FIREFLY / samples.sqrt()) * sum / f32::max(count, 1.0);
        // Without light around it, nothing tells a firefly from the only lit pixel.
        (sum > 0.0 && light > limit).then(|| (centre, irradiance[centre] * (1.0 - limit / light)))
    };
    // Most pixels are not above all of the next ones, let alone of those on the same surface.
    let (luminances, excess) = (&luminances, &excess);
    let in_row = |y: i32| {
        let peaks = (0..grid.width as usize).step_by(8).flat_map(move |x| peaks(grid, luminances, Place::new(x, y)));
        peaks.filter_map(move |x| excess(x, y))
    };
    let found: Vec<(usize, Vec3)> = (0..grid.height).into_par_iter().with_min_len(8).flat_map_iter(in_row).collect();
    for (centre, excess) in found {
        let (x, y) = (centre as i32 % grid.width, centre as i32 / grid.width);
        let takers: Vec<usize> = grid.around(x, y, FIREFLY_RADIUS).filter(|index| shares(centre, index)).collect();
        irradiance[centre] -= excess;
        for &taker in &takers {
            irradiance[taker] += excess / takers.len() as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fireflies_keep_their_energy() {
        let guide = Guide { class: GuideClass::Surface, normal: Vec3::Y, seen_normal: Vec3::Y, ..Guide::NONE };
        let guides = vec![guide; 49];
        let mut irradiance = vec![Vec3::splat(0.5); 49];
        irradiance[24] = Vec3::new(100.0, 50.0, 25.0);
        let sum: Vec3 = irradiance.iter().sum();
        spread_fireflies([7, 7], &guides, 1.0, &mut irradiance);
        let after: Vec3 = irradiance.iter().sum();
        assert!((sum - after).abs().max_element() < 1e-3, "{sum} {after}");
        assert!(luminance(irradiance[24]) < 2.1 && irradiance[0] == Vec3::splat(0.5), "{}", irradiance[24]);
        assert!(irradiance[23].x > 1.0);
    }
}
