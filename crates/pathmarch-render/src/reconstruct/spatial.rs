//! Spatial filter: an à-trous filter along surfaces.

use super::means::{Means, PixelMean, luminances};
use super::planes::{Grid, Place, Planes, by_eight, square_around};
use super::reflections::{Images, are_media};
use super::surfaces::{SurfacePlanes, Surfaces, Vectors, are_of};
use super::temporal::History;
use crate::integrator::guides::{Guide, GuideClass, NO_LEAF};
use crate::integrator::medium_light::MEDIUM_REACH;
use crate::intersect::ray::unpack;
use crate::wgsl::shared_constants;
use glam::Vec3;
use wide::f32x8;

/// Distances between the taps of the filter, pixels, one for each pass.
pub(super) const STEPS: [i32; 2] = [1, 4];

shared_constants! {
    /// Samples of a history that make its own variance trustworthy.
    const TRUSTED_SAMPLES: f32 = 4.0;
    /// Half the side of the square in which the variance of a young history is estimated, pixels.
    const VARIANCE_RADIUS: i32 = 2;
    /// Difference of luminance, in standard deviations, at which the weight ends for direct light, which has sharp shadows.
    pub(super) const DIRECT_REACH: f32 = 2.5;
    /// The same for indirect light and for that of facets.
    pub(super) const SMOOTH_REACH: f32 = 3.0;
    /// Standard deviation of a pixel that is brighter than all next to it, in what it has above these: it shares this evenly.
    const PEAK_DEVIATION: f32 = 3.0;
    /// Distance of the normals of points that share the light of facets, in alphas, at which the weight ends.
    const TURN_REACH: f32 = 1.0;
    /// Distance from a plane, in sides of a pixel for each pixel between the taps, at which the weight ends.
    const PLANE_REACH: f32 = 1.0;
}

/// Offsets to the pixels of the square in which the variance of a young history is estimated.
const SQUARE: [(i32, i32); 24] = square_around(VARIANCE_RADIUS);

/// Weights of pairs of pixels, `distance` pixels apart, as parts of one smooth surface; the same for both.
#[inline(always)]
fn similarity(a: &Surfaces, b: &Surfaces, distance: f32) -> f32x8 {
    let apart = a.position - b.position;
    let along = a.normal.dot(apart).abs().fast_max(b.normal.dot(apart).abs());
    let plane = f32x8::ONE - along / (a.pixel.fast_max(b.pixel) * (PLANE_REACH * distance));
    let cosine = a.seen_normal.dot(b.seen_normal).fast_max(f32x8::ZERO);
    let square = cosine * cosine;
    let fourth = square * square;
    let same = a.filtered.simd_eq(b.filtered) & a.filtered.simd_ge(f32x8::ZERO);
    same & (plane.fast_max(f32x8::ZERO) * fourth * fourth * fourth)
}

/// Largest distances at which the light of facets is shared, metres, see [`Image::reach`], [`NO_FACETS`] where there are none;
/// largest distances of normals; depths of surfaces in media, [`NO_MEDIUM`] where there are none.
struct Reaches(Planes<3>);

/// Reach of pixels without facets.
const NO_FACETS: f32 = -1.0;
/// Depth of surfaces without a medium in front of them.
const NO_MEDIUM: f32 = -1.0;

impl Reaches {
    fn new(surfaces: &SurfacePlanes, images: &Images) -> Self {
        Self(Planes::within(surfaces.grid, [NO_FACETS, 1.0, NO_MEDIUM], |place| {
            let (alpha, reach) = (surfaces.alpha(place), images.at(place).reach);
            let are_media = are_media(alpha);
            let are_facets = alpha.simd_gt(f32x8::ZERO) & !are_media;
            [
                are_facets.select(reach, f32x8::splat(NO_FACETS)),
                are_facets.select(alpha * TURN_REACH, f32x8::ONE),
                are_media.select(reach, f32x8::splat(NO_MEDIUM)),
            ]
        }))
    }

    /// True if one of eight pixels has facets or a medium.
    #[inline(always)]
    fn has_any(&self, place: Place) -> bool {
        self.0.load(0, place).fast_max(self.0.load(2, place)).simd_ge(f32x8::ZERO).any()
    }

    /// Weights of pairs of pixels that share light of facets or media, from their similarities; the same for both.
    #[inline(always)]
    fn weights(&self, similarity: f32x8, [a, b]: [&Surfaces; 2], [here, there]: [Place; 2]) -> f32x8 {
        let (apart, turned) = (a.position - b.position, a.normal - b.normal);
        let least = self.0.load(0, here).fast_min(self.0.load(0, there));
        let reach = least + a.pixel.fast_max(b.pixel);
        let turn_reach = self.0.load(1, here).fast_min(self.0.load(1, there));
        let share = f32x8::ONE - apart.dot(apart) / (reach * reach) - turned.dot(turned) / (turn_reach * turn_reach);
        let of_facets = least.simd_ge(f32x8::ZERO) & (similarity * share.fast_max(f32x8::ZERO));
        let [depth_here, depth_there] = [here, there].map(|place| self.0.load(2, place));
        let [are_media, is_medium] = [depth_here.fast_min(depth_there), depth_here.fast_max(depth_there)]
            .map(|depth| depth.simd_ge(f32x8::ZERO));
        let of_media = f32x8::ONE - (depth_here - depth_there).abs() / f32x8::splat(MEDIUM_REACH);
        is_medium.select(are_media & of_media.fast_max(f32x8::ZERO), of_facets)
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
    fn new(surfaces: &SurfacePlanes, step: i32) -> Self {
        let grid = surfaces.grid;
        let similarities = Planes::of_eight(grid, |place| {
            let surface = surfaces.at(place);
            let mut similarities = [f32x8::ZERO; 4];
            for (([dx, dy], _), similarity) in HALF_OF_TAPS.iter().zip(&mut similarities) {
                if let Some(other) = place.moved(grid, step * dx, step * dy) {
                    *similarity = self::similarity(&surface, &surfaces.at(other), step as f32);
                }
            }
            similarities
        });
        Self { step, similarities }
    }

    /// Weights for the light of facets.
    fn of_facets(&self, surfaces: &SurfacePlanes, reaches: &Reaches) -> Self {
        let (grid, step) = (surfaces.grid, self.step);
        let similarities = Planes::of_eight(grid, |place| {
            let mut similarities = [f32x8::ZERO; 4];
            if !reaches.has_any(place) {
                return similarities;
            }
            let surface = surfaces.at(place);
            for (k, (([dx, dy], _), similarity)) in HALF_OF_TAPS.iter().zip(&mut similarities).enumerate() {
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
        for (k, &([dx, dy], kernel)) in HALF_OF_TAPS.iter().enumerate() {
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

/// Filtered irradiance of all pixels.
pub(super) struct Filtered {
    base: Estimates,
    /// That of facets and media, if there are any.
    reflected: Option<Estimates>,
}

/// Filters the means of a history, and those of the light of facets with their images if there is any. `reach` is that of the
/// luminance, in standard deviations.
pub(super) fn filter(
    history: &History,
    surfaces: &SurfacePlanes,
    facets: Option<(&[PixelMean], &Images)>,
    reach: f32,
) -> Filtered {
    let pairs = STEPS.map(|step| PairWeights::new(surfaces, step));
    let base = Layer { surfaces, reaches: None, reach }.filtered(&history.means, &pairs);
    let reflected = facets.map(|(means, images)| {
        let reaches = Reaches::new(surfaces, images);
        let pairs = pairs.each_ref().map(|pairs| pairs.of_facets(surfaces, &reaches));
        Layer { surfaces, reaches: Some(&reaches), reach: SMOOTH_REACH }.filtered(means, &pairs)
    });
    Filtered { base, reflected }
}

/// Light that is filtered: that of facets and media, if it has reaches, or all other.
struct Layer<'a> {
    surfaces: &'a SurfacePlanes,
    reaches: Option<&'a Reaches>,
    /// Reach of the luminance, in standard deviations.
    reach: f32,
}

/// Filtered light of a pixel.
#[derive(Clone, Copy, Default)]
pub(super) struct FilteredLight {
    pub(super) radiance: Vec3,
    /// Part of the radiance that does not change with the albedo, and the derivative of the rest by it.
    pub(super) apart: Vec3,
    pub(super) irradiance: Vec3,
    /// Index of the leaf if the pixel shows a single surface.
    pub(super) leaf: u32,
}

impl Filtered {
    /// Means of a history as they are, and those of the light of facets, if there is any.
    pub(super) fn unfiltered(grid: Grid, means: &[PixelMean], reflected: Option<&[PixelMean]>) -> Self {
        let estimates = |means: &[PixelMean]| {
            Estimates::of_eight(grid, |place| {
                let Vectors { x: r, y: g, z: b } = Means::gathered(means, place.indices(grid)).irradiance;
                [r, g, b, f32x8::ZERO]
            })
        };
        Self { base: estimates(means), reflected: reflected.map(estimates) }
    }

    /// Irradiance of eight pixels without the light of facets.
    #[inline(always)]
    pub(super) fn base(&self, place: Place) -> Vectors {
        colours_of(&self.base, place)
    }

    /// Part that a function takes of the light of all pixels, which have these guides. `indirect` gives the indirect irradiance of eight
    /// pixels, and the mask of those where it is known; the others keep their own.
    pub(super) fn light<T: Copy + Default + Send>(
        &self,
        grid: Grid,
        guides: &[Guide],
        indirect: impl Fn(Place) -> (Vectors, f32x8) + Sync,
        of: impl Fn(FilteredLight) -> T + Sync,
    ) -> Vec<T> {
        by_eight(grid, |place| {
            let (light, are_known) = indirect(place);
            let (base, light, are_known) = (unpack(self.base(place)), unpack(light), are_known.to_bitmask());
            let reflected = self.reflected.as_ref().map(|reflected| unpack(colours_of(reflected, place)));
            let indices = place.indices(grid);
            std::array::from_fn(|lane| {
                let guide = &guides[indices[lane]];
                let divisor = guide.divisor();
                let (coloured, of_facets) = match reflected {
                    Some(reflected) if guide.reflected.is_coloured => (reflected[lane], Vec3::ZERO),
                    Some(reflected) => (Vec3::ZERO, reflected[lane]),
                    None => (Vec3::ZERO, Vec3::ZERO),
                };
                let scattered = match guide.class {
                    GuideClass::Surface if are_known >> lane & 1 == 1 => light[lane],
                    GuideClass::Surface => guide.indirect / divisor,
                    _ => Vec3::ZERO,
                };
                let irradiance = base[lane] + scattered + coloured;
                of(FilteredLight {
                    radiance: irradiance * divisor + of_facets,
                    apart: of_facets,
                    irradiance,
                    leaf: if guide.is_mixed { NO_LEAF } else { guide.leaf },
                })
            })
        })
    }
}

/// Irradiance of eight pixels.
#[inline(always)]
fn colours_of(estimates: &Estimates, place: Place) -> Vectors {
    let [r, g, b] = [0, 1, 2].map(|k| estimates.load(k, place));
    Vectors::new(r, g, b)
}

impl Layer<'_> {
    /// Filtered means.
    fn filtered(&self, means: &[PixelMean], [near, far]: &[PairWeights; 2]) -> Estimates {
        let grid = self.surfaces.grid;
        let first = self.first_estimates(means);
        let variances = &Planes::of_eight(grid, |place| [smooth_variances(self.surfaces, near, &first, place)]);
        let once = &Estimates::of_eight(grid, |place| self.pass(near, &first, |at| variances.load(0, at), place));
        Estimates::of_eight(grid, |place| self.pass(far, once, |at| once.load(3, at), place))
    }

    /// True if one of eight pixels has such light.
    #[inline(always)]
    fn is_at(&self, place: Place) -> bool {
        self.reaches.is_none_or(|reaches| reaches.has_any(place))
    }

    /// Means of the history and their variances. That of a young history is taken from its neighbours on the same surface.
    fn first_estimates(&self, means: &[PixelMean]) -> Estimates {
        let Self { surfaces, reaches, .. } = *self;
        let grid = surfaces.grid;
        let means_at = |place: Place| Means::gathered(means, place.indices(grid));
        let moments = Planes::of_eight(grid, |place| means_at(place).moments);
        Estimates::of_eight(grid, |place| {
            if !self.is_at(place) {
                return [f32x8::ZERO; 4];
            }
            let Means { irradiance: Vectors { x: r, y: g, z: b }, length, moments: [mut mean, mut square], .. } =
                means_at(place);
            let surface = surfaces.at(place);
            let is_young = length.simd_lt(f32x8::splat(TRUSTED_SAMPLES));
            if is_young.any() {
                let (mut means_around, mut squares_around, mut total) = (mean, square, f32x8::ONE);
                for &(dx, dy) in &SQUARE {
                    let Some(other) = place.moved(grid, dx, dy) else { continue };
                    let there = surfaces.at(other);
                    let similarity = similarity(&surface, &there, VARIANCE_RADIUS as f32);
                    let weight = match reaches {
                        Some(reaches) => reaches.weights(similarity, [&surface, &there], [place, other]),
                        None => similarity,
                    };
                    means_around += moments.load(0, other) * weight;
                    squares_around += moments.load(1, other) * weight;
                    total += weight;
                }
                mean = is_young.select(means_around / total, mean);
                square = is_young.select(squares_around / total, square);
            }
            let variance = (square - mean * mean).fast_max(f32x8::ZERO) / length.fast_max(f32x8::ONE);
            let mut is_filtered = surface.filtered.simd_ge(f32x8::ZERO);
            if let Some(reaches) = reaches {
                is_filtered |= reaches.0.load(2, place).simd_ge(f32x8::ZERO);
            }
            [r, g, b, is_filtered & variance]
        })
    }

    /// One pass at eight pixels: irradiance, and its variance.
    #[inline(always)]
    fn pass(
        &self,
        weights: &PairWeights,
        estimates: &Estimates,
        variance_at: impl Fn(Place) -> f32x8,
        place: Place,
    ) -> [f32x8; 4] {
        if !self.is_at(place) {
            return [f32x8::ZERO; 4];
        }
        let (here, variance_here) = (colours_of(estimates, place), variance_at(place));
        let luminance_here = luminances(here);
        let (mut sum, mut variance, mut total) = (here, variance_here, f32x8::ONE);
        // Pixels that saw no light yet take what their neighbours give: otherwise these would lose it.
        weights.for_taps(self.surfaces.grid, place, |Tap { place, similarity, kernel }| {
            let (there, variance_there) = (colours_of(estimates, place), variance_at(place));
            // The same for both, so that each gives the other as much as it takes.
            let deviation = (variance_here + variance_there).sqrt();
            let apart = (luminance_here - luminances(there)).abs();
            let difference = apart / (deviation * self.reach + f32x8::splat(1e-6));
            let weight = similarity * (f32x8::ONE - difference).fast_max(f32x8::ZERO) * kernel;
            sum = sum + there * weight;
            variance += variance_there * weight * weight;
            total += weight;
        });
        let share = f32x8::ONE / total;
        let Vectors { x: r, y: g, z: b } = sum * share;
        [r, g, b, variance * share * share]
    }
}

/// Variances of eight pixels, averaged with those of the next pixels on the same surface: the variance of a few samples is
/// itself noisy. What a pixel has above all of these is noise, too, unless it shows glass.
#[inline(always)]
fn smooth_variances(surfaces: &SurfacePlanes, weights: &PairWeights, estimates: &Estimates, place: Place) -> f32x8 {
    let here = luminances(colours_of(estimates, place));
    let (mut variance, mut total, mut most) = (estimates.load(3, place), f32x8::ONE, f32x8::splat(-1.0));
    weights.for_taps(surfaces.grid, place, |Tap { place, similarity, .. }| {
        variance += estimates.load(3, place) * similarity;
        total += similarity;
        let there = luminances(colours_of(estimates, place));
        most = similarity.simd_gt(f32x8::ZERO).select(most.fast_max(there), most);
    });
    let variance = variance / total;
    let (has_noise, has_others) = (variance.simd_gt(f32x8::ZERO), most.simd_ge(f32x8::ZERO));
    let is_compared = has_noise & has_others & !are_of(surfaces.part(place), GuideClass::Glass);
    let above = is_compared & ((here - most).fast_max(f32x8::ZERO) * PEAK_DEVIATION);
    variance.fast_max(above * above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::FrameUniforms;
    use bytemuck::Zeroable;

    /// Filtered luminance of the pixels of a wall of this class, 24x24 pixels whose means are 1 and have this variance, but that
    /// of the middle, which is 6.
    fn with_peak(class: GuideClass, variance: f32) -> Vec<f32> {
        let guide = |index: usize| {
            let position = Vec3::new((index % 24) as f32, (index / 24) as f32, 0.0) * 0.01;
            Guide { position, normal: Vec3::Z, seen_normal: Vec3::Z, length: 1.0, class, ..Guide::NONE }
        };
        let guides: Vec<Guide> = (0..576).map(guide).collect();
        let frame = FrameUniforms { width: 24, height: 24, pixel: 0.01, ..FrameUniforms::zeroed() };
        let surfaces = SurfacePlanes::new(&frame, &guides, false);
        let mean = |index: usize| {
            let light = if index == 12 * 24 + 12 { 6.0 } else { 1.0 };
            let moments = [light, light * light + variance];
            PixelMean { irradiance: Vec3::splat(light), length: TRUSTED_SAMPLES, moments, before: [0.0; 2] }
        };
        let means: Vec<PixelMean> = (0..576).map(mean).collect();
        let pairs = STEPS.map(|step| PairWeights::new(&surfaces, step));
        let filtered = Layer { surfaces: &surfaces, reaches: None, reach: DIRECT_REACH }.filtered(&means, &pairs);
        let at =
            |index: usize| filtered.load(0, Place::new(index % 24 / 8 * 8, (index / 24) as i32)).to_array()[index % 8];
        (0..576).map(at).collect()
    }

    #[test]
    fn peaks_of_single_pixels_are_noise() {
        // The deviation of the mean is 0.1.
        let filtered = with_peak(GuideClass::Surface, 0.04);
        let sum: f32 = filtered.iter().sum();
        assert!(filtered[12 * 24 + 12] < 2.0, "{}", filtered[12 * 24 + 12]);
        assert!((sum - 581.0).abs() < 1.0, "{sum}");
        assert!(filtered.iter().all(|light| *light > 0.99));
        // Glass shows such highlights; without noise all is as it is.
        for (class, variance) in [(GuideClass::Glass, 0.04), (GuideClass::Surface, 0.0)] {
            assert!((with_peak(class, variance)[12 * 24 + 12] - 6.0).abs() < 1e-3);
        }
    }

    #[test]
    fn similarity_is_symmetric_and_ends_at_edges() {
        let at = |x: f32, normal: Vec3, object: u32| {
            let position = Vec3::new(x, 0.3 * x * x, 0.0);
            let (length, seen_object, class) = (4.0 + x, object, GuideClass::Surface);
            let guide =
                Guide { position, normal, seen_normal: normal, length, object, seen_object, class, ..Guide::NONE };
            let frame = FrameUniforms { width: 1, height: 1, pixel: 0.01, ..FrameUniforms::zeroed() };
            SurfacePlanes::new(&frame, &[guide], false).at(Place::new(0, 0))
        };
        let similarity = |a: &Surfaces, b: &Surfaces| self::similarity(a, b, 1.0).to_array()[0];
        let tilted = Vec3::new(0.2, 1.0, 0.0).normalize();
        let (a, b) = (at(0.0, Vec3::Y, 3), at(0.05, tilted, 3));
        assert!(similarity(&a, &b) > 0.3);
        assert_eq!(similarity(&a, &b), similarity(&b, &a));
        assert_eq!(similarity(&a, &at(0.05, tilted, 4)), 0.0);
        assert_eq!(similarity(&a, &at(0.05, Vec3::X, 3)), 0.0);
        assert_eq!(similarity(&a, &at(2.0, Vec3::Y, 3)), 0.0);
    }
}
