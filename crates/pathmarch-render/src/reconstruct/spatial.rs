//! Spatial filter: an à-trous filter along surfaces, and the spreading of fireflies.

use super::luminance;
use super::temporal::{History, PixelMean};
use crate::integrator::guides::{Guide, GuideClass};
use crate::scene::light::LUMINANCE_WEIGHTS;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use wide::f32x8;

/// Distances between the taps of the filter, pixels, one for each pass.
pub(super) const STEPS: [i32; 3] = [1, 3, 7];

shared_constants! {
    /// Samples of a history that make its own variance trustworthy.
    const TRUSTED_SAMPLES: f32 = 4.0;
    /// Half the side of the square in which the variance of a young history is estimated, pixels.
    const VARIANCE_RADIUS: i32 = 2;
    /// Difference of luminance, in standard deviations, at which the weight ends.
    const LUMINANCE_REACH: f32 = 3.0;
    /// Distance from a plane, in sides of a pixel for each pixel between the taps, at which the weight ends.
    const PLANE_REACH: f32 = 1.0;
    /// Luminance above the mean of the neighbours, in such means, from which on a single sample is a firefly. The mean of
    /// several samples is one from that divided by the root of their number on.
    const FIREFLY: f32 = 3.0;
    /// Half the side of the square that takes the energy of a firefly, pixels.
    const FIREFLY_RADIUS: i32 = 2;
    /// Half the side of the square that decides which luminance is plausible, pixels.
    const PLAUSIBLE_RADIUS: i32 = 2;
    /// Standard deviations of single samples by which a mean may differ from that of the square: three standard errors.
    const PLAUSIBLE_REACH: f32 = 0.6;
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

    /// Pixels of the square around a pixel, without itself.
    fn around(self, x: i32, y: i32, radius: i32) -> impl Iterator<Item = usize> {
        square_around(radius).filter_map(move |(dx, dy)| self.index(x + dx, y + dy))
    }
}

/// Offsets to the pixels of the square around a pixel, without itself.
fn square_around(radius: i32) -> impl Iterator<Item = (i32, i32)> {
    let square = (-radius..=radius).flat_map(move |dy| (-radius..=radius).map(move |dx| (dx, dy)));
    square.filter(|offset| *offset != (0, 0))
}

/// Surfaces of eight adjoining pixels, as the filter compares them.
struct Surfaces {
    position: [f32x8; 3],
    /// Sides of a pixel at these distances, metres.
    pixel: f32x8,
    normal: [f32x8; 3],
    seen_normal: [f32x8; 3],
    /// Equal on pixels that may share their light; [`UNFILTERED`] for those without noise.
    surface: f32x8,
}

/// Surface of pixels without noise, and of those beyond the picture.
const UNFILTERED: f32 = -1.0;

fn dot(a: [f32x8; 3], b: [f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Surfaces {
    /// Weights of pairs of pixels, `distance` pixels apart, as parts of one smooth surface; the same for both.
    #[inline(always)]
    fn similarity(&self, other: &Self, distance: f32) -> f32x8 {
        let ([ax, ay, az], [bx, by, bz]) = (self.position, other.position);
        let apart = [ax - bx, ay - by, az - bz];
        let along = dot(self.normal, apart).abs().max(dot(other.normal, apart).abs());
        let plane = f32x8::ONE - along / (self.pixel.max(other.pixel) * (PLANE_REACH * distance));
        let cosine = dot(self.seen_normal, other.seen_normal).max(f32x8::ZERO);
        let square = cosine * cosine;
        let fourth = square * square;
        let same = self.surface.simd_eq(other.surface) & self.surface.simd_ge(f32x8::ZERO);
        same & (plane.max(f32x8::ZERO) * fourth * fourth * fourth)
    }
}

/// Number of pixels beside the rows of [`Planes`], at least the largest reach of the filter and eight more.
const MARGIN: usize = 16;

/// `N` numbers of all pixels, row by row: a plane of the row for each number, with a margin on both sides.
struct Planes<const N: usize> {
    stride: usize,
    numbers: Vec<f32>,
}

/// Place of eight adjoining pixels in planes: their row, and the column of the first with the margin.
#[derive(Clone, Copy)]
struct Place {
    row: i32,
    column: i32,
}

impl Place {
    fn new(x: usize, row: i32) -> Self {
        Self { row, column: (x + MARGIN) as i32 }
    }

    /// Place so many pixels further; `None` above and below the picture.
    #[inline(always)]
    fn moved(self, grid: Grid, dx: i32, dy: i32) -> Option<Self> {
        let row = self.row + dy;
        (0..grid.height).contains(&row).then_some(Self { row, column: self.column + dx })
    }
}

impl<const N: usize> Planes<N> {
    /// Planes that `fill` writes: it receives the planes of a row, each with its margins, and the row.
    fn filled(grid: Grid, fill: impl Fn(&mut [&mut [f32]; N], i32) + Sync) -> Self {
        let stride = grid.width as usize + 2 * MARGIN;
        let mut numbers = vec![0.0; N * stride * grid.height as usize];
        numbers.par_chunks_mut(N * stride).enumerate().with_min_len(8).for_each(|(row, planes)| {
            let mut planes = planes.chunks_mut(stride);
            fill(&mut std::array::from_fn(|_| planes.next().unwrap_or_default()), row as i32);
        });
        Self { stride, numbers }
    }

    /// Planes of a function of all pixels; the margins have these numbers.
    fn new(grid: Grid, margin: [f32; N], values: impl Fn(usize) -> [f32; N] + Sync) -> Self {
        Self::filled(grid, |planes, row| {
            for (plane, margin) in planes.iter_mut().zip(margin) {
                plane.fill(margin);
            }
            for x in 0..grid.width as usize {
                let numbers = values(row as usize * grid.width as usize + x);
                for (plane, number) in planes.iter_mut().zip(numbers) {
                    plane[MARGIN + x] = number;
                }
            }
        })
    }

    /// Planes of a function of eight adjoining pixels.
    fn of_eight(grid: Grid, values: impl Fn(Place) -> [f32x8; N] + Sync) -> Self {
        Self::filled(grid, |planes, row| {
            for x in (0..grid.width as usize).step_by(8) {
                for (plane, value) in planes.iter_mut().zip(values(Place::new(x, row))) {
                    plane[MARGIN + x..MARGIN + x + 8].copy_from_slice(&value.to_array());
                }
            }
        })
    }

    /// Number `k` of eight pixels.
    #[inline(always)]
    fn load(&self, k: usize, place: Place) -> f32x8 {
        let at = (place.row as usize * N + k) * self.stride + place.column as usize;
        f32x8::new(self.numbers[at..at + 8].try_into().unwrap_or([0.0; 8]))
    }

    /// Numbers of eight pixels.
    #[inline(always)]
    fn lanes(&self, place: Place) -> [f32x8; N] {
        // A loop is unrolled where `from_fn` becomes calls.
        let mut lanes = [f32x8::ZERO; N];
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane = self.load(k, place);
        }
        lanes
    }

    /// Number `k` of a row, without its margins.
    fn row(&self, grid: Grid, k: usize, row: usize) -> &[f32] {
        let start = (row * N + k) * self.stride + MARGIN;
        &self.numbers[start..start + grid.width as usize]
    }
}

/// Planes of the surfaces: position, pixel, normal, seen normal, surface.
struct SurfacePlanes(Planes<11>);

impl SurfacePlanes {
    fn new(grid: Grid, guides: &[Guide], pixel: f32, settles: bool) -> Self {
        let mut margin = [0.0; 11];
        (margin[3], margin[10]) = (1.0, UNFILTERED);
        Self(Planes::new(grid, margin, |index| {
            let guide = &guides[index];
            let surface = match guide.class {
                GuideClass::Sky | GuideClass::Emitter => UNFILTERED,
                // The mean of several surfaces is that of none.
                _ if settles && guide.is_mixed => UNFILTERED,
                GuideClass::Surface => (2 * guide.object) as f32,
                // Pixels of glass share light if they show one object.
                GuideClass::Glass => (2 * guide.seen_object + 1) as f32,
            };
            let ([px, py, pz], [nx, ny, nz]) = (guide.position.to_array(), guide.normal.to_array());
            let [sx, sy, sz] = guide.seen_normal.to_array();
            [px, py, pz, pixel * guide.length, nx, ny, nz, sx, sy, sz, surface]
        }))
    }

    #[inline(always)]
    fn at(&self, place: Place) -> Surfaces {
        let [px, py, pz, pixel, nx, ny, nz, sx, sy, sz, surface] = self.0.lanes(place);
        Surfaces { position: [px, py, pz], pixel, normal: [nx, ny, nz], seen_normal: [sx, sy, sz], surface }
    }
}

/// Irradiance and variance of the luminance of all pixels, while they are filtered.
type Estimates = Planes<4>;

/// Offsets to half of the eight taps of a pass, in steps, and their weights in the kernel; the others are opposite.
const HALF_OF_TAPS: [([i32; 2], f32); 4] = [([1, 0], 0.5), ([-1, 1], 0.25), ([0, 1], 0.5), ([1, 1], 0.25)];

/// Similarities of all pairs of pixels that a pass compares: of each pixel with half of its taps. They are symmetric.
struct PairWeights {
    step: i32,
    similarities: Planes<4>,
}

/// Pixels that are a tap of eight others, and the similarities of both.
struct Tap {
    place: Place,
    similarity: f32x8,
    kernel: f32,
}

impl PairWeights {
    fn new(grid: Grid, surfaces: &SurfacePlanes, step: i32) -> Self {
        let similarities = Planes::of_eight(grid, |place| {
            let surface = surfaces.at(place);
            let mut similarities = [f32x8::ZERO; 4];
            for (([dx, dy], _), similarity) in HALF_OF_TAPS.into_iter().zip(&mut similarities) {
                if let Some(other) = place.moved(grid, step * dx, step * dy) {
                    *similarity = surface.similarity(&surfaces.at(other), step as f32);
                }
            }
            similarities
        });
        Self { step, similarities }
    }

    /// Calls a function with all taps of eight pixels.
    #[inline(always)]
    fn for_taps(&self, grid: Grid, place: Place, mut visit: impl FnMut(Tap)) {
        for (k, ([dx, dy], kernel)) in HALF_OF_TAPS.into_iter().enumerate() {
            let [dx, dy] = [self.step * dx, self.step * dy];
            if let Some(other) = place.moved(grid, dx, dy) {
                visit(Tap { place: other, similarity: self.similarities.load(k, place), kernel });
            }
            if let Some(other) = place.moved(grid, -dx, -dy) {
                visit(Tap { place: other, similarity: self.similarities.load(k, other), kernel });
            }
        }
    }
}

/// Filtered radiance; `settles` if the film has samples enough to show edges.
pub(super) fn filter(history: &History, settles: bool) -> Vec<Vec3> {
    let grid = Grid::new(history.frame.size());
    let surfaces = SurfacePlanes::new(grid, &history.guides, history.frame.pixel, settles);
    let first = first_estimates(grid, history, &surfaces);
    let mut weights = PairWeights::new(grid, &surfaces, STEPS[0]);
    let mut estimates = Estimates::of_eight(grid, |place| with_smooth_variance(grid, &weights, &first, place));
    for step in STEPS {
        if step != weights.step {
            weights = PairWeights::new(grid, &surfaces, step);
        }
        estimates = Estimates::of_eight(grid, |place| filtered(grid, &weights, &estimates, place));
    }
    let mut colours = vec![Vec3::ZERO; history.guides.len()];
    let rows = colours.par_chunks_mut(grid.width as usize).zip(history.guides.par_chunks(grid.width as usize));
    rows.enumerate().with_min_len(8).for_each(|(row, (colours, guides))| {
        let [r, g, b] = [0, 1, 2].map(|k| estimates.row(grid, k, row));
        for (x, (colour, guide)) in colours.iter_mut().zip(guides).enumerate() {
            *colour = Vec3::new(r[x], g[x], b[x]) * guide.divisor();
        }
    });
    colours
}

/// One pass at eight pixels.
#[inline(always)]
fn filtered(grid: Grid, weights: &PairWeights, estimates: &Estimates, place: Place) -> [f32x8; 4] {
    let here = estimates.lanes(place);
    let luminance_here = lane_luminance(here);
    let [mut r, mut g, mut b, mut variance] = here;
    let mut total = f32x8::ONE;
    // Pixels that saw no light yet take what their neighbours give: otherwise these would lose it.
    weights.for_taps(grid, place, |Tap { place, similarity, kernel }| {
        let there = estimates.lanes(place);
        // The same for both, so that each gives the other as much as it takes.
        let deviation = (here[3] + there[3]).sqrt();
        let apart = (luminance_here - lane_luminance(there)).abs();
        let difference = apart / (deviation * LUMINANCE_REACH + f32x8::splat(1e-6));
        let weight = similarity * (f32x8::ONE - difference).max(f32x8::ZERO) * kernel;
        r += there[0] * weight;
        g += there[1] * weight;
        b += there[2] * weight;
        variance += there[3] * weight * weight;
        total += weight;
    });
    let share = f32x8::ONE / total;
    [r * share, g * share, b * share, variance * share * share]
}

/// Estimates of eight pixels, their variances averaged with those of the next pixels on the same surface: the variance of a
/// few samples is itself noisy.
#[inline(always)]
fn with_smooth_variance(grid: Grid, weights: &PairWeights, estimates: &Estimates, place: Place) -> [f32x8; 4] {
    let [r, g, b, mut variance] = estimates.lanes(place);
    let mut total = f32x8::ONE;
    weights.for_taps(grid, place, |Tap { place, similarity, .. }| {
        variance += estimates.load(3, place) * similarity;
        total += similarity;
    });
    [r, g, b, variance / total]
}

fn lane_luminance([r, g, b, _]: [f32x8; 4]) -> f32x8 {
    let [wr, wg, wb] = LUMINANCE_WEIGHTS;
    r * wr + g * wg + b * wb
}

/// Means of the history and their variances. That of a young history is taken from its neighbours on the same surface.
fn first_estimates(grid: Grid, history: &History, surfaces: &SurfacePlanes) -> Estimates {
    let means = Planes::new(grid, [0.0; 6], |index| {
        let PixelMean { irradiance: Vec3 { x: r, y: g, z: b }, length, moments: [mean, square], .. } =
            history.means[index];
        [r, g, b, mean, square, length]
    });
    Estimates::of_eight(grid, |place| {
        let [r, g, b, mut mean, mut square, length] = means.lanes(place);
        let surface = surfaces.at(place);
        let is_young = length.simd_lt(f32x8::splat(TRUSTED_SAMPLES));
        if is_young.any() {
            let (mut means_around, mut squares_around, mut total) = (mean, square, f32x8::ONE);
            for other in square_around(VARIANCE_RADIUS).filter_map(|(dx, dy)| place.moved(grid, dx, dy)) {
                let weight = surface.similarity(&surfaces.at(other), VARIANCE_RADIUS as f32);
                means_around += means.load(3, other) * weight;
                squares_around += means.load(4, other) * weight;
                total += weight;
            }
            mean = is_young.select(means_around / total, mean);
            square = is_young.select(squares_around / total, square);
        }
        let variance = (square - mean * mean).max(f32x8::ZERO) / length.max(f32x8::ONE);
        let is_filtered = surface.surface.simd_ge(f32x8::ZERO);
        [r, g, b, is_filtered & variance]
    })
}

/// Least and largest luminance that the mean of each pixel may have, judged from the samples around it.
pub(super) fn plausible_luminances(size: [u32; 2], irradiance: &[Vec3]) -> Vec<[f32; 2]> {
    let grid = Grid::new(size);
    let moments = Planes::new(grid, [0.0; 3], |index| {
        let luminance = luminance(irradiance[index]);
        [luminance, luminance * luminance, 1.0]
    });
    // Sums over squares are sums over columns of sums over rows.
    let sums = |moments: &Planes<3>, place: Place, [dx, dy]: [i32; 2]| {
        let mut sums = [f32x8::ZERO; 3];
        for k in -PLAUSIBLE_RADIUS..=PLAUSIBLE_RADIUS {
            let Some(there) = place.moved(grid, k * dx, k * dy) else { continue };
            for (sum, moment) in sums.iter_mut().zip(moments.lanes(there)) {
                *sum += moment;
            }
        }
        sums
    };
    let rows = Planes::of_eight(grid, |place| sums(&moments, place, [1, 0]));
    let limits = Planes::<2>::of_eight(grid, |place| {
        let [sum, squares, count] = sums(&rows, place, [0, 1]);
        let mean = sum / count;
        let reach = (squares / count - mean * mean).max(f32x8::ZERO).sqrt() * PLAUSIBLE_REACH;
        [(mean - reach).max(f32x8::ZERO), mean + reach]
    });
    let pairs = |row: usize| limits.row(grid, 0, row).iter().zip(limits.row(grid, 1, row));
    (0..grid.height as usize).flat_map(|row| pairs(row).map(|(&least, &most)| [least, most])).collect()
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

    #[test]
    fn similarity_is_symmetric_and_ends_at_edges() {
        let at = |x: f32, normal: Vec3, object: u32| {
            let position = Vec3::new(x, 0.3 * x * x, 0.0);
            let (length, seen_object, class) = (4.0 + x, object, GuideClass::Surface);
            let guide =
                Guide { position, normal, seen_normal: normal, length, object, seen_object, class, ..Guide::NONE };
            SurfacePlanes::new(Grid::new([1, 1]), &[guide], 0.01, false).at(Place::new(0, 0))
        };
        let similarity = |a: &Surfaces, b: &Surfaces| a.similarity(b, 1.0).to_array()[0];
        let tilted = Vec3::new(0.2, 1.0, 0.0).normalize();
        let (a, b) = (at(0.0, Vec3::Y, 3), at(0.05, tilted, 3));
        assert!(similarity(&a, &b) > 0.3);
        assert_eq!(similarity(&a, &b), similarity(&b, &a));
        assert_eq!(similarity(&a, &at(0.05, tilted, 4)), 0.0);
        assert_eq!(similarity(&a, &at(0.05, Vec3::X, 3)), 0.0);
        assert_eq!(similarity(&a, &at(2.0, Vec3::Y, 3)), 0.0);
    }
}
