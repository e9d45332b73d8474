//! Temporal anti-aliasing and upscaling.
//!
//! Samples of one pixel see its edges and textures at other places in every picture. The picture is therefore averaged
//! with the last one at the same points. What the last picture shows is clamped to the colours around the pixel, so that
//! nothing stays that is not there any more. The picture may be larger than its samples: then a sample counts most in the
//! pixels next to its position, and of [textures that are finer](crate::integrator::pixel_albedo) only its light.
//!
//! **Source.** Karis 2014, "High-Quality Temporal Supersampling"; interpolation: Catmull and Rom 1974, "A Class of Local
//! Interpolating Splines"; upscaling: Epic Games, "Temporal Upsampling" in Unreal
//! Engine 4.19 (2018); clamping to mean and deviation: Salvi 2016, "An Excursion
//! in Temporal Supersampling". Colours stay linear: compressing bright ones would darken the mean.

use super::motion::EarlierPoints;
use super::planes::{Grid, Place, Planes};
use super::spatial::FilteredLight;
use super::surfaces::{MirrorPlanes, Points, SurfacePlanes, Vectors};
use super::temporal::{History, Positions, Projection, SoughtPoints};
use crate::integrator::guides::{Guide, MIN_ALBEDO};
use crate::intersect::ray::{lanes, pack, set_bits, transposed, unpack};
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::{Vec3, Vec4, Vec4Swizzles};
use pathmarch_field::number::{Mask8, Real, Vec3 as FieldVec3};
use rayon::prelude::*;
use std::f32::consts::{LN_2, LOG2_E};
use wide::{f32x8, i32x8};

shared_constants! {
    /// Least weight of a new picture, for pixels between its samples.
    const MIN_WEIGHT: f32 = 0.02;
    /// Deviations from the mean of the neighbours that the past may have.
    const REACH: f32 = 1.25;
    /// Least weight of a new picture of one sample where the picture moves fast: interpolation blurs the past, and its clamp lags.
    const MOVING_WEIGHT: f32 = 0.4;
    /// Motion since the last picture at which that weight is reached, pixels of the samples.
    const FAST_MOTION: f32 = 0.3;
    /// Least weight of a new picture after a change of the scene where facets mirror sharply: what they show may move, and their
    /// surface tells nothing of it.
    const IMAGE_WEIGHT: f32 = 0.6;
    /// Largest alpha of such facets; above it, the weight falls with the square of alpha.
    const SHARP_ALPHA: f32 = 0.005;
    /// Standard deviation of the filter that interpolates samples, pixels of the picture.
    const KERNEL_DEVIATION: f32 = 0.6;
}

/// Weight of a new picture of one sample, unless the pixel was not seen before.
const NEW_WEIGHT: f32 = 0.12;
/// The same after a change of the scene: colours that are limited lag.
const NEW_WEIGHT_OF_CHANGED_SCENE: f32 = 0.16;

/// Weight of a new picture of so many samples: that of as many pictures of one sample.
pub(super) fn new_weight(samples: u32, scene_has_changed: bool) -> f32 {
    let of_one = if scene_has_changed { NEW_WEIGHT_OF_CHANGED_SCENE } else { NEW_WEIGHT };
    1.0 - (1.0 - of_one).powf(samples as f32)
}

/// Picture that was shown.
pub(super) struct ShownPicture {
    /// Width and height, pixels; at least those of its samples.
    pub(super) size: [u32; 2],
    pub(super) colours: Vec<Vec4>,
}

/// Last picture, what it shows, and the motion since.
#[derive(Clone, Copy)]
pub(super) struct Last<'a> {
    pub(super) picture: &'a ShownPicture,
    pub(super) history: &'a History,
    pub(super) earlier: &'a EarlierPoints,
    /// Weight of the new picture, see [`new_weight`].
    pub(super) new_weight: f32,
    pub(super) scene_has_changed: bool,
}

/// Textures that are finer than pixels.
#[derive(Clone, Copy)]
pub(super) struct Textures<'a> {
    /// Albedos of the pixels of the picture, with 1 in w where they are not those of the samples.
    pub(super) albedos: &'a [Vec4],
    /// Light of the samples.
    pub(super) light: &'a [FilteredLight],
}

impl Textures<'_> {
    /// Colour of a sample, which shows a surface, with the albedo of a pixel of the picture.
    #[inline(always)]
    fn colour(&self, sample: usize, pixel: usize) -> Vec3 {
        let light = &self.light[sample];
        light.apart + light.irradiance * self.albedos[pixel].xyz().max(Vec3::splat(MIN_ALBEDO))
    }

    /// Colours of samples of a picture of their size, with the albedos of its pixels.
    fn averaged(&self, samples: &[Vec3]) -> Vec<Vec3> {
        let of = |index: usize| if self.albedos[index].w > 0.0 { self.colour(index, index) } else { samples[index] };
        (0..samples.len()).into_par_iter().with_min_len(4096).map(of).collect()
    }
}

/// Power of two below which a weight is 0.
const LEAST_EXPONENT: f32 = -64.0;

/// Number of rows of the picture that are made one after the other, so that they share the neighbourhoods of their samples.
const SHARED_ROWS: usize = 8;

/// Eight pixels of the samples: the nine samples around each of them, and the motion of the surface nearest to the camera among
/// these, as edges move with what is in front.
struct Neighbourhoods {
    /// Means of the opponent colours.
    mean: Vectors,
    /// Largest deviations from them that the past may have.
    deviation: Vectors,
    /// Least weights of the new picture.
    new_weight: f32x8,
    /// Points of the surfaces in the last picture.
    sought: SoughtPoints,
    /// Positions of these points in the last picture and in this one, each in pixels of its samples.
    before: Positions,
    now: Positions,
}

/// Numbers of one of [`Neighbourhoods`].
type Row = [[f32; 8]; 3];

impl Neighbourhoods {
    /// The neighbourhoods, one by one.
    #[inline(always)]
    fn each(self) -> [Row; 8] {
        let Self {
            mean,
            deviation,
            new_weight,
            sought: SoughtPoints { position, normal, pixel, surface, sky_tolerance },
            before,
            now,
        } = self;
        let one = |mask: f32x8| mask & f32x8::ONE;
        let columns = [
            [position.x, position.y, position.z, pixel, normal.x, normal.y, normal.z, surface],
            [mean.x, mean.y, mean.z, deviation.x, deviation.y, deviation.z, sky_tolerance, one(before.mask & now.mask)],
            [before.x, before.y, now.x, now.y, new_weight, f32x8::ZERO, f32x8::ZERO, f32x8::ZERO],
        ];
        let [a, b, c] = columns.map(|columns| f32x8::transpose(columns).map(f32x8::to_array));
        std::array::from_fn(|lane| [a[lane], b[lane], c[lane]])
    }

    /// Those at these indices of a row.
    #[inline(always)]
    fn gathered(row: &[Row], indices: [usize; 8]) -> Self {
        let numbers = |k: usize| transposed(indices.map(|index| row[index][k]));
        let [px, py, pz, pixel, nx, ny, nz, surface] = numbers(0);
        let [mx, my, mz, dx, dy, dz, sky_tolerance, moves] = numbers(1);
        let [bx, by, x, y, new_weight, ..] = numbers(2);
        let mask = moves.simd_gt(f32x8::ZERO);
        let (position, normal) = (Vectors::new(px, py, pz), Vectors::new(nx, ny, nz));
        Self {
            mean: Vectors::new(mx, my, mz),
            deviation: Vectors::new(dx, dy, dz),
            new_weight,
            sought: SoughtPoints { position, normal, pixel, surface, sky_tolerance },
            before: Positions { x: bx, y: by, mask },
            now: Positions { x, y, mask },
        }
    }
}

/// Outlines of mirrors at eight pixels: they move with the mirrors, not with their images.
struct Outlines {
    /// Mask of the pixels at an outline.
    mask: f32x8,
    /// Offsets of the indices of the samples that show the first surfaces nearest to the camera, and the distances of these from the
    /// camera if they are mirrors, metres, else 0.
    nearest: f32x8,
    distance: f32x8,
}

/// New samples of a picture, which is shown at another size.
struct Upscaling<'a> {
    present: &'a History,
    surfaces: &'a SurfacePlanes,
    grid: Grid,
    samples: &'a [Vec3],
    textures: Option<Textures<'a>>,
    /// Opponent colours of the samples, and the lengths of their paths; the largest number for those that are no part of the picture.
    opponents: Planes<4>,
    /// If the picture is larger than the samples: where they are.
    placed: Option<PlacedSamples>,
    /// Pixels of the picture for each pixel of the samples.
    factor: [f32; 2],
}

/// Samples by their positions in their pixels.
struct PlacedSamples {
    /// Positions, pixels of the samples.
    positions: Planes<2>,
    /// Opponent colours.
    opponents: Vec<Vec4>,
}

/// Averages samples with the last picture, at a size that is at least theirs. If emitters are a layer apart, samples of them
/// do not move others.
pub(super) fn antialiased(
    (present, surfaces): (&History, &SurfacePlanes),
    (samples, textures): (&[Vec3], Option<Textures>),
    size: [u32; 2],
    last: Option<Last>,
    emitters_are_apart: bool,
) -> ShownPicture {
    let History { frame, guides, projection, .. } = present;
    let is_larger = size != frame.size();
    let averaged = textures.filter(|_| !is_larger).map(|textures| textures.averaged(samples));
    let samples = averaged.as_deref().unwrap_or(samples);
    if last.is_none() && !is_larger {
        return ShownPicture { size, colours: samples.iter().map(|sample| sample.extend(0.0)).collect() };
    }
    let grid = Grid::new(frame.size());
    let opponent = |index: usize| {
        let guide = &guides[index];
        let is_apart = emitters_are_apart && guide.is_seen_emitter();
        let [lightness, orange, green] = opponent_of(samples[index]).to_array();
        [lightness, orange, green, if is_apart { f32::MAX } else { guide.length }]
    };
    let placed = || PlacedSamples {
        positions: Planes::new(grid, [0.0; 2], |index| sample_position(frame, projection, index, &guides[index])),
        opponents: samples.par_iter().with_min_len(4096).map(|sample| opponent_of(*sample).extend(0.0)).collect(),
    };
    let upscaling = Upscaling {
        present,
        surfaces,
        grid,
        samples,
        textures,
        opponents: Planes::new(grid, [0.0, 0.0, 0.0, f32::MAX], opponent),
        placed: is_larger.then(placed),
        factor: [size[0] as f32 / frame.width as f32, size[1] as f32 / frame.height as f32],
    };
    let mut colours = vec![Vec4::ZERO; (size[0] * size[1]) as usize];
    let rows = colours.par_chunks_mut(size[0] as usize * SHARED_ROWS).enumerate();
    rows.for_each(|(chunk, colours)| upscaling.fill_rows(chunk * SHARED_ROWS, size[0] as usize, colours, last));
    ShownPicture { size, colours }
}

/// Position of the sample of a pixel, from its guide.
fn sample_position(frame: &FrameUniforms, projection: &Projection, index: usize, guide: &Guide) -> [f32; 2] {
    let middle = || [index % frame.width as usize, index / frame.width as usize].map(|at| at as f32 + 0.5);
    projection.project(guide.position).unwrap_or_else(middle)
}

impl Upscaling<'_> {
    /// Computes rows of the picture, `width` pixels each, from this one on.
    fn fill_rows(&self, first_row: usize, width: usize, colours: &mut [Vec4], last: Option<Last>) {
        let [samples_wide, samples_high] = self.present.frame.size().map(|side| side as usize);
        let point = |pixel: usize, k: usize| (pixel as f32 + 0.5) / self.factor[k];
        let (mut row_of_samples, mut neighbourhoods) = (usize::MAX, Vec::new());
        for (row, colours) in colours.chunks_mut(width).enumerate() {
            let v = point(first_row + row, 1);
            let y = (v as usize).min(samples_high - 1);
            if let Some(last) = last.filter(|_| row_of_samples != y) {
                row_of_samples = y;
                neighbourhoods.clear();
                let each = |place: Place| self.neighbourhoods(place, last).each();
                neighbourhoods.extend(self.grid.places(y as i32).flat_map(each));
            }
            for (eighth, colours) in colours.chunks_mut(8).enumerate() {
                let u: [f32; 8] = std::array::from_fn(|lane| point(8 * eighth + lane, 0));
                let x = u.map(|u| (u as usize).min(samples_wide - 1));
                let (mut new, mut weights) = ([Vec3::ZERO; 8], [1.0; 8]);
                for lane in 0..colours.len() {
                    let pixel = (first_row + row) * width + 8 * eighth + lane;
                    (new[lane], weights[lane]) = self.interpolated([u[lane], v], [x[lane], y], pixel);
                }
                let shown = match last {
                    Some(last) => {
                        let around = Neighbourhoods::gathered(&neighbourhoods, x);
                        self.averaged([u.into(), f32x8::splat(v)], (new, weights), &around, last)
                    }
                    None => new,
                };
                for (colour, shown) in colours.iter_mut().zip(shown) {
                    *colour = shown.extend(0.0);
                }
            }
        }
    }

    /// Averages new colours of eight pixels of the picture, of these weights, with the last picture. The points of the pixels are
    /// in pixels of the samples.
    fn averaged(
        &self,
        point: [f32x8; 2],
        (new, weights): ([Vec3; 8], [f32; 8]),
        around: &Neighbourhoods,
        Last { picture: shown, history, .. }: Last,
    ) -> [Vec3; 8] {
        let position = self.before(point, around, history);
        let seen = history.shows(&around.sought, &position);
        if seen.none() {
            return new;
        }
        let sampled = history.frame.size();
        let [x, y]: [[f32; 8]; 2] = std::array::from_fn(|k| {
            ([position.x, position.y][k] * (shown.size[k] as f32 / sampled[k] as f32)).to_array()
        });
        let mut old = [Vec3::ZERO; 8];
        for lane in set_bits(seen.to_bitmask()) {
            old[lane] = shown.cubic([x[lane], y[lane]]);
        }
        let (old, Vectors { x: lightness, y: orange, z: green }) = (pack(old), around.mean);
        let (opponent, deviation) = (opponents_of(old), around.deviation);
        let limited =
            |value: f32x8, mean: f32x8, deviation: f32x8| value.fast_max(mean - deviation).fast_min(mean + deviation);
        let old = colours_of(Vectors::new(
            limited(opponent.x, lightness, deviation.x),
            limited(opponent.y, orange, deviation.y),
            limited(opponent.z, green, deviation.z),
        ))
        .max(f32x8::ZERO);
        let moved = |k: usize| {
            [position.x, position.y][k] * (self.present.frame.size()[k] as f32 / sampled[k] as f32) - point[k]
        };
        let speed = (moved(0) * moved(0) + moved(1) * moved(1)).sqrt() * FAST_MOTION.recip();
        let new_weight = around.new_weight.fast_max(speed.fast_min(f32x8::ONE) * MOVING_WEIGHT);
        let weight = (new_weight * f32x8::from(weights)).fast_max(f32x8::splat(MIN_WEIGHT));
        let new = pack(new);
        unpack(Vectors::select(Mask8(seen), old + (new - old) * weight, new))
    }

    /// Positions of points in the last picture, if they move as these surfaces do; without a mask outside. All are in pixels
    /// of the samples.
    #[inline(always)]
    fn before(&self, [u, v]: [f32x8; 2], around: &Neighbourhoods, history: &History) -> Positions {
        let Neighbourhoods { before, now, .. } = around;
        // Pictures may differ in size.
        let size = [history.frame.width as f32, history.frame.height as f32];
        let scale = [size[0] / self.present.frame.width as f32, size[1] / self.present.frame.height as f32];
        let (x, y) = ((u - now.x) * scale[0] + before.x, (v - now.y) * scale[1] + before.y);
        let is_inside = |at: f32x8, size: f32| at.simd_ge(f32x8::ZERO) & at.simd_lt(f32x8::splat(size));
        Positions { x, y, mask: before.mask & is_inside(x, size[0]) & is_inside(y, size[1]) }
    }

    /// Neighbourhoods of eight pixels of the samples.
    fn neighbourhoods(&self, place: Place, last: Last) -> Neighbourhoods {
        let Last { history, earlier, .. } = last;
        let (mut sum, mut squares) = ([f32x8::ZERO; 3], [f32x8::ZERO; 3]);
        let (mut rows, mut nearest) = (0.0, f32x8::ZERO);
        let mut least = self.opponents.load(3, place);
        for dy in -1..=1 {
            if place.moved(self.grid, 0, dy).is_none() {
                continue;
            }
            rows += 1.0;
            for dx in -1..=1 {
                let Some(there) = place.moved(self.grid, dx, dy) else { continue };
                for (k, (sum, square)) in sum.iter_mut().zip(&mut squares).enumerate() {
                    let value = self.opponents.load(k, there);
                    *sum += value;
                    *square += value * value;
                }
                let length = self.opponents.load(3, there);
                let is_nearer = length.simd_lt(least);
                least = is_nearer.select(length, least);
                nearest = is_nearer.select(f32x8::splat((dy * self.grid.width + dx) as f32), nearest);
            }
        }
        let columns = lanes(|lane| {
            let x = place.x() + lane;
            3.0 - f32::from(x == 0) - f32::from(x + 1 >= self.grid.width as usize)
        });
        let share = f32x8::ONE / (columns * rows);
        let (mean, square) = (sum.map(|sum| sum * share), squares.map(|squares| squares * share));
        let deviation = |k: usize| (square[k] - mean[k] * mean[k]).fast_max(f32x8::ZERO).sqrt() * f32x8::splat(REACH);
        let outlines = self.surfaces.mirrors.as_ref().map(|mirrors| self.outlines(mirrors, place));
        let nearest = outlines.as_ref().map_or(nearest, |outlines| outlines.mask.select(outlines.nearest, nearest));
        let (indices, nearest) = (place.indices(self.grid), nearest.to_array());
        let indices = std::array::from_fn(|lane| {
            let index = indices[lane] as i32 + nearest[lane] as i32;
            (index.max(0) as usize).min(self.samples.len() - 1)
        });
        let points = self.present.points(indices);
        let sought = history.sought(&points, earlier, indices, &self.present.frame);
        Neighbourhoods {
            mean: Vectors::new(mean[0], mean[1], mean[2]),
            deviation: Vectors::new(deviation(0), deviation(1), deviation(2)),
            new_weight: self.new_weights(place, last),
            sought,
            before: history.projection.project_all(self.moving_points(&points, &sought, outlines)),
            now: self.present.projection.project_all(points.position),
        }
    }

    /// Least weights of the new picture at eight pixels of the samples.
    #[inline(always)]
    fn new_weights(&self, place: Place, Last { new_weight, scene_has_changed, .. }: Last) -> f32x8 {
        if !scene_has_changed {
            return f32x8::splat(new_weight);
        }
        let alpha = self.surfaces.alpha(place);
        let sharpness = (f32x8::splat(SHARP_ALPHA) / alpha).fast_min(f32x8::ONE);
        let of_images = alpha.simd_gt(f32x8::ZERO) & (sharpness * sharpness * IMAGE_WEIGHT);
        of_images.fast_max(f32x8::splat(new_weight))
    }

    /// Outlines of mirrors at eight pixels of the samples.
    #[inline(always)]
    fn outlines(&self, mirrors: &MirrorPlanes, place: Place) -> Outlines {
        let here = mirrors.at(place);
        let (mut mask, mut nearest, mut distance) = (f32x8::ZERO, f32x8::ZERO, f32x8::ZERO);
        let mut least = f32x8::splat(f32::MAX);
        for dy in -1..=1 {
            for dx in -1..=1 {
                let Some(at) = place.moved(self.grid, dx, dy) else { continue };
                let (there, length) = (mirrors.at(at), self.opponents.load(3, at));
                mask |= here.differ(&there) & length.simd_lt(f32x8::splat(f32::MAX));
                let front = there.are_mirrors().select(there.distance, length);
                let is_nearer = front.simd_lt(least);
                least = is_nearer.select(front, least);
                distance = is_nearer.select(there.distance, distance);
                nearest = is_nearer.select(f32x8::splat((dy * self.grid.width + dx) as f32), nearest);
            }
        }
        Outlines { mask, nearest, distance }
    }

    /// Points whose motion eight pixels share: those of the surfaces in the last picture, or of the mirrors that they outline.
    #[inline(always)]
    fn moving_points(&self, points: &Points, sought: &SoughtPoints, outlines: Option<Outlines>) -> Vectors {
        let Some(Outlines { mask, distance, .. }) = outlines else { return sought.position };
        let eye = Vectors::constant(self.present.frame.position);
        let of_mirrors = eye + (points.position - eye) * (distance / points.length);
        Vectors::select(Mask8(mask & distance.simd_gt(f32x8::ZERO)), of_mirrors, sought.position)
    }

    /// Colour at a point, in pixels of the samples, within one of these pixels, and the weight of the sample nearest to it, 0 to 1.
    /// The point is in this pixel of the picture.
    #[inline(always)]
    fn interpolated(&self, point: [f32; 2], [x, y]: [usize; 2], pixel: usize) -> (Vec3, f32) {
        let here = y * self.grid.width as usize + x;
        let Some(placed) = &self.placed else { return (self.samples[here], 1.0) };
        if let Some(textures) = self.textures.filter(|textures| textures.albedos[pixel].w > 0.0) {
            let leaf = textures.light[here].leaf;
            let of = |there: usize| {
                let is_same = textures.light[there].leaf == leaf;
                let colour = if is_same { textures.colour(there, pixel) } else { self.samples[there] };
                colour.extend(0.0)
            };
            // Only light is interpolated.
            return (self.weighted(placed, point, [x, y], of).map_or(of(here), |(colour, _)| colour).xyz(), 1.0);
        }
        match self.weighted(placed, point, [x, y], |there| placed.opponents[there]) {
            Some((opponent, largest)) => (colour_of(opponent.xyz()), largest),
            None => (self.samples[here], 0.0),
        }
    }

    /// Mean of the colours of the samples around a point, in pixels of the samples, within one of these pixels, by the distances
    /// of the samples, and the largest of their weights; `None` if all are far away.
    #[inline(always)]
    fn weighted(
        &self,
        placed: &PlacedSamples,
        point: [f32; 2],
        [x, y]: [usize; 2],
        colour: impl Fn(usize) -> Vec4,
    ) -> Option<(Vec4, f32)> {
        let width = self.grid.width as usize;
        let (mut sum, mut total, mut largest) = (Vec4::ZERO, 0.0, 0.0);
        for place in (-1..=1).filter_map(|dy| Place::new(x, y as i32).moved(self.grid, -1, dy)) {
            let distance = |k: usize| (placed.positions.load(k, place) - f32x8::splat(point[k])) * self.factor[k];
            let weights = gaussian(distance(0), distance(1)).to_array();
            let inside = usize::from(x == 0)..(width + 1 - x).min(3);
            for k in inside {
                let weight = weights[k];
                sum += colour(place.row as usize * width + x + k - 1) * weight;
                total += weight;
                largest = f32::max(largest, weight);
            }
        }
        (total > 0.0).then(|| (sum / total, largest))
    }
}

/// Weights of samples at these distances, in pixels of the picture: a Gaussian. Its exponential takes a quarter of the time of
/// [`f32x8::exp`], which also serves large, infinite and missing numbers.
fn gaussian(dx: f32x8, dy: f32x8) -> f32x8 {
    const SCALE: f32 = -0.5 * LOG2_E / (KERNEL_DEVIATION * KERNEL_DEVIATION);
    let least = f32x8::splat(LEAST_EXPONENT);
    let exponent = ((dx * dx + dy * dy) * SCALE).fast_max(least);
    let whole = exponent.round();
    let power_of_two: f32x8 = bytemuck::cast((whole.fast_round_int() + i32x8::splat(127)) << 23);
    // Taylor series of two to the power of the rest, which is at most a half.
    let rest = (exponent - whole) * LN_2;
    let series = [1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    let power = series.into_iter().fold(f32x8::splat(1.0 / 720.0), |sum, term| sum * rest + f32x8::splat(term));
    exponent.simd_gt(least) & (power_of_two * power)
}

/// Lightness, orange against blue, green against magenta (YCoCg; Malvar and Sullivan 2003). Clamped there, a grey
/// pattern lets no colour pass.
fn opponents_of<N: Real>(FieldVec3 { x: r, y: g, z: b }: FieldVec3<N>) -> FieldVec3<N> {
    let (half, quarter) = (N::constant(0.5), N::constant(0.25));
    FieldVec3::new(quarter * r + half * g + quarter * b, half * (r - b), half * g - quarter * (r + b))
}

/// Inverse of [`opponents_of`].
fn colours_of<N: Real>(FieldVec3 { x: lightness, y: orange, z: green }: FieldVec3<N>) -> FieldVec3<N> {
    FieldVec3::new(lightness + orange - green, lightness + green, lightness - orange - green)
}

fn opponent_of(colour: Vec3) -> Vec3 {
    opponents_of(FieldVec3::from(colour)).into()
}

fn colour_of(opponent: Vec3) -> Vec3 {
    colours_of(FieldVec3::from(opponent)).into()
}

impl ShownPicture {
    /// Colour at a position, in pixels, by bicubic interpolation: bilinear interpolation, repeated in every picture, blurs.
    /// It stays between the four nearest colours, or there would be black rings around lamps.
    fn cubic(&self, position: [f32; 2]) -> Vec3 {
        let [width, height] = self.size.map(|side| side as i32);
        let [x, y] = position.map(|coordinate| coordinate - 0.5);
        let [columns, rows] = [x, y].map(|coordinate| catmull_rom(coordinate - coordinate.floor()));
        let mut sum = Vec4::ZERO;
        let (mut least, mut most) = (Vec4::splat(f32::MAX), Vec4::splat(-f32::MAX));
        let places: [usize; 4] =
            std::array::from_fn(|i| (x.floor() as i32 - 1 + i as i32).clamp(0, width - 1) as usize);
        for (j, row) in rows.into_iter().enumerate() {
            let start = (y.floor() as i32 - 1 + j as i32).clamp(0, height - 1) * width;
            let of_row = &self.colours[start as usize..][..width as usize];
            for (i, column) in columns.into_iter().enumerate() {
                let colour = of_row[places[i]];
                sum += colour * (row * column);
                if (1..=2).contains(&i) && (1..=2).contains(&j) {
                    (least, most) = (least.min(colour), most.max(colour));
                }
            }
        }
        sum.clamp(least, most).xyz()
    }
}

/// Weights of four points at -1, 0, 1 and 2 for the value at `t`, 0 to 1.
pub(crate) fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [-0.5 * t + t2 - 0.5 * t3, 1.0 - 2.5 * t2 + 1.5 * t3, 0.5 * t + 2.0 * t2 - 1.5 * t3, -0.5 * t2 + 0.5 * t3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_passes_through_its_points_and_keeps_slopes() {
        assert_eq!(catmull_rom(0.0), [0.0, 1.0, 0.0, 0.0]);
        for t in [0.1, 0.5, 0.8] {
            let weights = catmull_rom(t);
            let position: f32 = weights.iter().zip([-1.0, 0.0, 1.0, 2.0]).map(|(weight, at)| weight * at).sum();
            assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6 && (position - t).abs() < 1e-6);
        }
    }

    #[test]
    fn weights_are_those_of_a_gaussian() {
        for x in [0.0f32, 0.01, 0.3, 0.6, 1.1, 2.0, 3.0, 4.5] {
            let expected = (-0.5 * x * x / (KERNEL_DEVIATION * KERNEL_DEVIATION)).exp();
            for [dx, dy] in [[x, 0.0], [0.6 * x, -0.8 * x]] {
                let weight = gaussian(f32x8::splat(dx), f32x8::splat(dy)).to_array()[3];
                assert!((weight - expected).abs() < 3e-6 * expected + 1e-19, "{x}: {weight} for {expected}");
            }
        }
        for far in [6.0, 1e6, f32::INFINITY] {
            assert_eq!(gaussian(f32x8::splat(far), f32x8::ZERO).to_array(), [0.0; 8], "{far}");
        }
    }

    #[test]
    fn the_past_has_no_dark_rings_around_lamps() {
        let colours = (0..64).map(|k| Vec4::splat(if k % 8 < 4 { 0.2 } else { 12.0 })).collect();
        let picture = ShownPicture { size: [8, 8], colours };
        let row: Vec<f32> = (8..56).map(|k| picture.cubic([k as f32 / 8.0, 4.3]).x).collect();
        assert!(row.iter().all(|value| (0.2..=12.0).contains(value)), "{row:?}");
        assert!(row.is_sorted(), "{row:?}");
    }

    #[test]
    fn opponent_colours_are_those_of_grey_and_back() {
        assert_eq!(opponent_of(Vec3::splat(0.3)), Vec3::new(0.3, 0.0, 0.0));
        let colour = Vec3::new(0.9, 0.25, 3.0);
        assert!((colour_of(opponent_of(colour)) - colour).length() < 1e-6);
    }
}
