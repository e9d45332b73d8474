//! Spatial filter: an à-trous filter along surfaces, and the spreading of fireflies.

use super::luminance;
use super::temporal::History;
use crate::integrator::guides::{Guide, GuideClass};
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;

/// Distances between the taps of the filter, pixels, one for each pass.
pub(super) const STEPS: [i32; 3] = [1, 3, 7];

shared_constants! {
    /// Samples of a history that make its own variance trustworthy.
    const TRUSTED_SAMPLES: f32 = 4.0;
    /// Half the side of the square in which the variance of a young history is estimated, pixels.
    const VARIANCE_RADIUS: i32 = 2;
    /// Difference of luminance, in standard deviations, at which the weight ends.
    const LUMINANCE_REACH: f32 = 4.0;
    /// Distance from a plane, in sides of a pixel for each pixel between the taps, at which the weight ends.
    const PLANE_REACH: f32 = 1.0;
    /// Luminance, in means of the neighbours, above which a sample is a firefly.
    const FIREFLY: f32 = 6.0;
    /// Half the side of the square that takes the energy of a firefly, pixels.
    const FIREFLY_RADIUS: i32 = 2;
    /// Half the side of the square that decides which luminance is plausible, pixels.
    const PLAUSIBLE_RADIUS: i32 = 2;
    /// Standard deviations of single samples by which a mean may differ from that of the square: three standard errors.
    const PLAUSIBLE_REACH: f32 = 0.6;
}

/// Surface of a pixel, as the filter compares it.
#[derive(Clone, Copy)]
struct FilterGuide {
    position: Vec3,
    /// Side of a pixel at this distance, metres.
    pixel: f32,
    normal: Vec3,
    seen_normal: Vec3,
    /// Equal on pixels that may share their light; [`UNFILTERED`] for those without noise.
    surface: u32,
}

/// Surface of pixels without noise.
const UNFILTERED: u32 = u32::MAX;

impl FilterGuide {
    fn new(guide: &Guide, pixel: f32) -> Self {
        let surface = match guide.class {
            GuideClass::Sky | GuideClass::Emitter => UNFILTERED,
            GuideClass::Surface => 2 * guide.object,
            // Pixels of glass share light if they show one object.
            GuideClass::Glass => 2 * guide.seen_object + 1,
        };
        let Guide { position, normal, seen_normal, length, .. } = *guide;
        Self { position, pixel: pixel * length, normal, seen_normal, surface }
    }

    /// Weight of two pixels, `distance` pixels apart, as parts of one smooth surface; the same for both.
    #[inline]
    fn similarity(&self, other: &Self, distance: f32) -> f32 {
        if self.surface != other.surface || self.surface == UNFILTERED {
            return 0.0;
        }
        let apart = self.position - other.position;
        let along = self.normal.dot(apart).abs().max(other.normal.dot(apart).abs());
        let plane = 1.0 - along / (PLANE_REACH * distance * self.pixel.max(other.pixel));
        if plane <= 0.0 {
            return 0.0;
        }
        let cosine = self.seen_normal.dot(other.seen_normal).max(0.0);
        let fourth = cosine * cosine * cosine * cosine;
        plane * fourth * fourth * fourth
    }
}

/// Size of a picture that a filter walks over.
#[derive(Clone, Copy)]
struct Grid {
    width: i32,
    height: i32,
}

impl Grid {
    fn new(size: [u32; 2]) -> Self {
        Self { width: size[0] as i32, height: size[1] as i32 }
    }

    /// Index of a pixel; `None` outside.
    #[inline]
    fn index(self, x: i32, y: i32) -> Option<usize> {
        ((0..self.width).contains(&x) && (0..self.height).contains(&y)).then(|| (y * self.width + x) as usize)
    }

    /// Values of a function of all pixels (x, y).
    fn map<T: Send>(self, value: impl Fn(i32, i32) -> T + Sync) -> Vec<T> {
        let count = (self.width * self.height) as usize;
        let of = |index: usize| value(index as i32 % self.width, index as i32 / self.width);
        (0..count).into_par_iter().with_min_len(1024).map(of).collect()
    }

    /// Pixels of the square around a pixel, without itself.
    fn around(self, x: i32, y: i32, radius: i32) -> impl Iterator<Item = usize> {
        let square = (-radius..=radius).flat_map(move |dy| (-radius..=radius).map(move |dx| (dx, dy)));
        square.filter(|offset| *offset != (0, 0)).filter_map(move |(dx, dy)| self.index(x + dx, y + dy))
    }
}

/// Irradiance of a pixel while it is filtered.
#[derive(Clone, Copy)]
struct Estimate {
    irradiance: Vec3,
    /// Variance of the luminance.
    variance: f32,
    luminance: f32,
}

/// Filtered irradiance.
pub(super) fn filter(history: &History) -> Vec<Vec3> {
    let grid = Grid::new(history.frame.size());
    let guides: Vec<FilterGuide> =
        history.guides.par_iter().map(|guide| FilterGuide::new(guide, history.frame.pixel)).collect();
    let mut estimates = grid.map(|x, y| {
        let index = (y * grid.width + x) as usize;
        let irradiance = history.irradiance[index];
        let variance = if guides[index].surface == UNFILTERED { 0.0 } else { variance(grid, history, &guides, x, y) };
        Estimate { irradiance, variance, luminance: luminance(irradiance) }
    });
    for step in STEPS {
        estimates = grid.map(|x, y| filtered(grid, &guides, &estimates, x, y, step));
    }
    estimates.into_iter().map(|estimate| estimate.irradiance).collect()
}

/// One pass at a pixel.
fn filtered(grid: Grid, guides: &[FilterGuide], estimates: &[Estimate], x: i32, y: i32, step: i32) -> Estimate {
    let centre = (y * grid.width + x) as usize;
    let (here, guide) = (estimates[centre], &guides[centre]);
    // Pixels that saw no light yet take what their neighbours give: otherwise these would lose it.
    if guide.surface == UNFILTERED {
        return here;
    }
    let (mut sum, mut variances, mut total) = (here.irradiance, here.variance, 1.0);
    for dy in -1..=1 {
        for dx in -1..=1 {
            let Some(index) = grid.index(x + step * dx, y + step * dy).filter(|index| *index != centre) else {
                continue;
            };
            let surface = guide.similarity(&guides[index], step as f32);
            if surface <= 0.0 {
                continue;
            }
            let there = &estimates[index];
            // The same for both, so that each gives the other as much as it takes.
            let deviation = (here.variance + there.variance).sqrt();
            let difference = (here.luminance - there.luminance).abs() / (LUMINANCE_REACH * deviation + 1e-6);
            let kernel = if dx == 0 || dy == 0 { 0.5 } else { 0.25 };
            let weight = kernel * surface * (1.0 - difference).max(0.0);
            sum += there.irradiance * weight;
            variances += there.variance * weight * weight;
            total += weight;
        }
    }
    let irradiance = sum / total;
    Estimate { irradiance, variance: variances / (total * total), luminance: luminance(irradiance) }
}

/// Variance of the mean of a pixel. That of a young history is taken from its neighbours on the same surface.
fn variance(grid: Grid, history: &History, guides: &[FilterGuide], x: i32, y: i32) -> f32 {
    let centre = (y * grid.width + x) as usize;
    let [mut mean, mut square] = history.moments[centre];
    let length = history.length[centre];
    if length < TRUSTED_SAMPLES {
        let mut total = 1.0;
        for index in grid.around(x, y, VARIANCE_RADIUS) {
            let weight = guides[centre].similarity(&guides[index], VARIANCE_RADIUS as f32);
            mean += history.moments[index][0] * weight;
            square += history.moments[index][1] * weight;
            total += weight;
        }
        (mean, square) = (mean / total, square / total);
    }
    (square - mean * mean).max(0.0) / length
}

/// Least and largest luminance that the mean of each pixel may have, judged from the samples around it.
pub(super) fn plausible_luminances(size: [u32; 2], irradiance: &[Vec3]) -> Vec<[f32; 2]> {
    let grid = Grid::new(size);
    let luminances: Vec<f32> = irradiance.par_iter().map(|colour| luminance(*colour)).collect();
    grid.map(|x, y| {
        let here = luminances[(y * grid.width + x) as usize];
        let (mut sum, mut squares, mut count) = (here, here * here, 1.0);
        for index in grid.around(x, y, PLAUSIBLE_RADIUS) {
            sum += luminances[index];
            squares += luminances[index] * luminances[index];
            count += 1.0;
        }
        let mean = sum / count;
        let reach = PLAUSIBLE_REACH * (squares / count - mean * mean).max(0.0).sqrt();
        [(mean - reach).max(0.0), mean + reach]
    })
}

/// Limits samples that are far above their neighbours, and gives what is above to the neighbours on the same surface.
pub(super) fn spread_fireflies(size: [u32; 2], guides: &[Guide], irradiance: &mut [Vec3]) {
    let grid = Grid::new(size);
    let luminances: Vec<f32> = irradiance.par_iter().map(|colour| luminance(*colour)).collect();
    let shares = |centre: usize, index: &usize| {
        let (a, b) = (&guides[centre], &guides[*index]);
        a.class == b.class && a.object == b.object && a.seen_normal.dot(b.seen_normal) > 0.7
    };
    let excess = |x: i32, y: i32| -> Option<(usize, Vec3)> {
        let centre = (y * grid.width + x) as usize;
        let light = luminances[centre];
        // Most pixels are not above all of the next ones, let alone of those on the same surface.
        if grid.around(x, y, 1).any(|index| luminances[index] >= light)
            || matches!(guides[centre].class, GuideClass::Sky | GuideClass::Emitter)
        {
            return None;
        }
        let (mut sum, mut count) = (0.0, 0.0);
        for index in grid.around(x, y, FIREFLY_RADIUS).filter(|index| shares(centre, index)) {
            sum += luminances[index];
            count += 1.0;
        }
        let limit = FIREFLY * sum / f32::max(count, 1.0);
        // Without light around it, nothing tells a firefly from the only lit pixel.
        (sum > 0.0 && light > limit).then(|| (centre, irradiance[centre] * (1.0 - limit / light)))
    };
    let found: Vec<(usize, Vec3)> = grid.map(excess).into_iter().flatten().collect();
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
        spread_fireflies([7, 7], &guides, &mut irradiance);
        let after: Vec3 = irradiance.iter().sum();
        assert!((sum - after).abs().max_element() < 1e-3, "{sum} {after}");
        assert!(luminance(irradiance[24]) < 3.1 && irradiance[0] == Vec3::splat(0.5), "{}", irradiance[24]);
        assert!(irradiance[23].x > 1.0);
    }

    #[test]
    fn similarity_is_symmetric_and_ends_at_edges() {
        let at = |x: f32, normal: Vec3, object: u32| {
            let position = Vec3::new(x, 0.3 * x * x, 0.0);
            let (length, seen_object) = (4.0 + x, object);
            FilterGuide::new(
                &Guide {
                    position,
                    normal,
                    seen_normal: normal,
                    length,
                    object,
                    seen_object,
                    class: GuideClass::Surface,
                    ..Guide::NONE
                },
                0.01,
            )
        };
        let tilted = Vec3::new(0.2, 1.0, 0.0).normalize();
        let (a, b) = (at(0.0, Vec3::Y, 3), at(0.05, tilted, 3));
        assert!(a.similarity(&b, 1.0) > 0.3);
        assert_eq!(a.similarity(&b, 1.0), b.similarity(&a, 1.0));
        assert_eq!(a.similarity(&at(0.05, tilted, 4), 1.0), 0.0);
        assert_eq!(a.similarity(&at(0.05, Vec3::X, 3), 1.0), 0.0);
        assert_eq!(a.similarity(&at(2.0, Vec3::Y, 3), 1.0), 0.0);
    }
}
