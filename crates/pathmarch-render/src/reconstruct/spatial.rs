//! Spatial filter: an à-trous filter along surfaces.

use super::planes::{Grid, Place, Planes, square_around};
use super::reflections::Image;
use super::temporal::{History, PixelMean};
use crate::integrator::guides::{Guide, GuideClass};
use crate::integrator::medium_light::MEDIUM_REACH;
use crate::scene::light::LUMINANCE_WEIGHTS;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use wide::f32x8;

/// Distances between the taps of the filter, pixels, one for each pass.
pub(super) const STEPS: [i32; 2] = [1, 3];

shared_constants! {
    /// Samples of a history that make its own variance trustworthy.
    const TRUSTED_SAMPLES: f32 = 4.0;
    /// Half the side of the square in which the variance of a young history is estimated, pixels.
    const VARIANCE_RADIUS: i32 = 2;
    /// Difference of luminance, in standard deviations, at which the weight ends for direct light, which has sharp shadows.
    pub(super) const DIRECT_REACH: f32 = 2.0;
    /// The same for indirect light and for that of facets.
    pub(super) const SMOOTH_REACH: f32 = 3.0;
    /// Distance of the normals of points that share the light of facets, in alphas, at which the weight ends.
    const TURN_REACH: f32 = 1.0;
    /// Distance from a plane, in sides of a pixel for each pixel between the taps, at which the weight ends.
    const PLANE_REACH: f32 = 1.0;
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

/// Planes of the surfaces: position, pixel, normal, seen normal, surface.
struct SurfacePlanes(Planes<11>);

impl SurfacePlanes {
    fn new(grid: Grid, guides: &[Guide], pixel: f32, settles: bool) -> Self {
        let mut margin = [0.0; 11];
        (margin[3], margin[10]) = (1.0, UNFILTERED);
        Self(Planes::new(grid, margin, |index| {
            let guide = &guides[index];
            let behind_medium = u32::from(guide.has_medium());
            let surface = match guide.class {
                GuideClass::Sky | GuideClass::Emitter => UNFILTERED,
                // The mean of several surfaces is that of none.
                _ if settles && guide.is_mixed => UNFILTERED,
                GuideClass::Surface => (4 * guide.object + behind_medium) as f32,
                // Pixels of glass share light if they show one object.
                GuideClass::Glass => (4 * guide.seen_object + 2 + behind_medium) as f32,
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

/// Largest distances at which the light of facets is shared, metres, see [`Image::reach`], [`NO_FACETS`] where there are none;
/// largest distances of normals; depths of surfaces in media, [`NO_MEDIUM`] where there are none.
struct Reaches(Planes<3>);

/// Reach of pixels without facets.
const NO_FACETS: f32 = -1.0;
/// Depth of surfaces without a medium in front of them.
const NO_MEDIUM: f32 = -1.0;

impl Reaches {
    fn new(grid: Grid, guides: &[Guide], images: &[Image]) -> Self {
        Self(Planes::new(grid, [NO_FACETS, 1.0, NO_MEDIUM], |index| match &guides[index] {
            guide if guide.has_medium() => [NO_FACETS, 1.0, images[index].reach],
            guide if guide.has_facets() => [images[index].reach, TURN_REACH * guide.reflected.alpha, NO_MEDIUM],
            _ => [NO_FACETS, 1.0, NO_MEDIUM],
        }))
    }

    /// True if one of eight pixels has facets or a medium.
    #[inline(always)]
    fn has_any(&self, place: Place) -> bool {
        self.0.load(0, place).max(self.0.load(2, place)).simd_ge(f32x8::ZERO).any()
    }

    /// Weights of pairs of pixels that share light of facets or media, from their similarities; the same for both.
    #[inline(always)]
    fn weights(&self, similarity: f32x8, [a, b]: [&Surfaces; 2], [here, there]: [Place; 2]) -> f32x8 {
        let ([ax, ay, az], [bx, by, bz]) = (a.position, b.position);
        let apart = [ax - bx, ay - by, az - bz];
        let least = self.0.load(0, here).min(self.0.load(0, there));
        let reach = least + a.pixel.max(b.pixel);
        let ([ax, ay, az], [bx, by, bz]) = (a.normal, b.normal);
        let turned = [ax - bx, ay - by, az - bz];
        let turn_reach = self.0.load(1, here).min(self.0.load(1, there));
        let share = f32x8::ONE - dot(apart, apart) / (reach * reach) - dot(turned, turned) / (turn_reach * turn_reach);
        let of_facets = least.simd_ge(f32x8::ZERO) & (similarity * share.max(f32x8::ZERO));
        let [depth_here, depth_there] = [here, there].map(|place| self.0.load(2, place));
        let [are_media, is_medium] =
            [depth_here.min(depth_there), depth_here.max(depth_there)].map(|depth| depth.simd_ge(f32x8::ZERO));
        let of_media = f32x8::ONE - (depth_here - depth_there).abs() / f32x8::splat(MEDIUM_REACH);
        is_medium.select(are_media & of_media.max(f32x8::ZERO), of_facets)
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

    /// Weights for the light of facets.
    fn of_facets(&self, grid: Grid, surfaces: &SurfacePlanes, reaches: &Reaches) -> Self {
        let step = self.step;
        let similarities = Planes::of_eight(grid, |place| {
            let mut similarities = [f32x8::ZERO; 4];
            if !reaches.has_any(place) {
                return similarities;
            }
            let surface = surfaces.at(place);
            for (k, (([dx, dy], _), similarity)) in HALF_OF_TAPS.into_iter().zip(&mut similarities).enumerate() {
                if let Some(other) = place.moved(grid, step * dx, step * dy) {
                    let alike = self.similarities.load(k, place);
                    *similarity = reaches.weights(alike, [&surface, &surfaces.at(other)], [place, other]);
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

/// Filtered radiance of the means of a history, and of those of the light of facets with their images if there is any;
/// `settles` if the film has samples enough to show edges. `reach` is that of the luminance, in standard deviations.
pub(super) fn filter(
    history: &History,
    facets: Option<(&[PixelMean], &[Image])>,
    settles: bool,
    reach: f32,
) -> Vec<Vec3> {
    let grid = Grid::new(history.frame.size());
    let surfaces = &SurfacePlanes::new(grid, &history.guides, history.frame.pixel, settles);
    let mut weights = PairWeights::new(grid, surfaces, STEPS[0]);
    let start = |weights: &PairWeights, means: &[PixelMean], reaches: Option<&Reaches>| {
        let first = first_estimates(grid, means, surfaces, reaches);
        Estimates::of_eight(grid, |place| with_smooth_variance(grid, weights, &first, place))
    };
    let mut base = start(&weights, &history.means, None);
    let mut facets = facets.map(|(means, images)| {
        let reaches = Reaches::new(grid, &history.guides, images);
        (start(&weights.of_facets(grid, surfaces, &reaches), means, Some(&reaches)), reaches)
    });
    for step in STEPS {
        if step != weights.step {
            weights = PairWeights::new(grid, surfaces, step);
        }
        base = Estimates::of_eight(grid, |place| filtered(grid, &weights, &base, place, reach));
        if let Some((estimates, reaches)) = &mut facets {
            let weights = weights.of_facets(grid, surfaces, reaches);
            *estimates = Estimates::of_eight(grid, |place| match reaches.has_any(place) {
                true => filtered(grid, &weights, estimates, place, SMOOTH_REACH),
                false => [f32x8::ZERO; 4],
            });
        }
    }
    let mut colours = vec![Vec3::ZERO; history.guides.len()];
    let rows = colours.par_chunks_mut(grid.width as usize).zip(history.guides.par_chunks(grid.width as usize));
    rows.enumerate().with_min_len(8).for_each(|(row, (colours, guides))| {
        let (base, facets) =
            (colours_of(grid, &base, row), facets.as_ref().map(|(facets, _)| colours_of(grid, facets, row)));
        for (x, (colour, guide)) in colours.iter_mut().zip(guides).enumerate() {
            let of_facets = facets.as_ref().map_or(Vec3::ZERO, |facets| facets(x) * guide.reflection_divisor());
            *colour = base(x) * guide.divisor() + of_facets;
        }
    });
    colours
}

/// Irradiance of the pixels of a row.
fn colours_of(grid: Grid, estimates: &Estimates, row: usize) -> impl Fn(usize) -> Vec3 + '_ {
    let [r, g, b] = [0, 1, 2].map(|k| estimates.row(grid, k, row));
    move |x| Vec3::new(r[x], g[x], b[x])
}

/// One pass at eight pixels.
#[inline(always)]
fn filtered(grid: Grid, weights: &PairWeights, estimates: &Estimates, place: Place, reach: f32) -> [f32x8; 4] {
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
        let difference = apart / (deviation * reach + f32x8::splat(1e-6));
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
fn first_estimates(
    grid: Grid,
    pixel_means: &[PixelMean],
    surfaces: &SurfacePlanes,
    reaches: Option<&Reaches>,
) -> Estimates {
    let means = Planes::new(grid, [0.0; 6], |index| {
        let PixelMean { irradiance: Vec3 { x: r, y: g, z: b }, length, moments: [mean, square], .. } =
            pixel_means[index];
        [r, g, b, mean, square, length]
    });
    Estimates::of_eight(grid, |place| {
        if reaches.is_some_and(|reaches| !reaches.has_any(place)) {
            return [f32x8::ZERO; 4];
        }
        let [r, g, b, mut mean, mut square, length] = means.lanes(place);
        let surface = surfaces.at(place);
        let is_young = length.simd_lt(f32x8::splat(TRUSTED_SAMPLES));
        if is_young.any() {
            let (mut means_around, mut squares_around, mut total) = (mean, square, f32x8::ONE);
            for other in square_around(VARIANCE_RADIUS).filter_map(|(dx, dy)| place.moved(grid, dx, dy)) {
                let there = surfaces.at(other);
                let similarity = surface.similarity(&there, VARIANCE_RADIUS as f32);
                let weight = match reaches {
                    Some(reaches) => reaches.weights(similarity, [&surface, &there], [place, other]),
                    None => similarity,
                };
                means_around += means.load(3, other) * weight;
                squares_around += means.load(4, other) * weight;
                total += weight;
            }
            mean = is_young.select(means_around / total, mean);
            square = is_young.select(squares_around / total, square);
        }
        let variance = (square - mean * mean).max(f32x8::ZERO) / length.max(f32x8::ONE);
        let mut is_filtered = surface.surface.simd_ge(f32x8::ZERO);
        if let Some(reaches) = reaches {
            is_filtered |= reaches.0.load(2, place).simd_ge(f32x8::ZERO);
        }
        [r, g, b, is_filtered & variance]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
