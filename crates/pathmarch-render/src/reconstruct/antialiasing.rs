//! Temporal anti-aliasing and upscaling.
//!
//! Samples of one pixel see its edges and textures at other places in every picture. The picture is therefore averaged
//! with the last one at the same points. What the last picture shows is clamped to the colours around the pixel, so that
//! nothing stays that is not there any more. The picture may be larger than its samples: then a sample counts most in the
//! pixels next to its position.
//!
//! **Source.** Karis 2014, "High-Quality Temporal Supersampling"; interpolation: Catmull and Rom 1974, "A Class of Local
//! Interpolating Splines"; upscaling: Epic Games, "Temporal Upsampling" in Unreal
//! Engine 4.19 (2018); clamping to mean and deviation: Salvi 2016, "An Excursion
//! in Temporal Supersampling". Colours stay linear: compressing bright ones would darken the mean.

use super::motion::EarlierPoints;
use super::planes::{Grid, Place, Planes};
use super::temporal::{History, Projection, SoughtPoint};
use crate::integrator::guides::Guide;
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
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
    /// Standard deviation of the filter that interpolates samples, pixels of the picture.
    const KERNEL_DEVIATION: f32 = 0.6;
}

/// Weight of a new picture of one sample, unless the pixel was not seen before.
const NEW_WEIGHT: f32 = 0.12;

/// Weight of a new picture of so many samples: that of as many pictures of one sample.
pub(super) fn new_weight(samples: u32) -> f32 {
    1.0 - (1.0 - NEW_WEIGHT).powf(samples as f32)
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
}

/// Power of two below which a weight is 0.
const LEAST_EXPONENT: f32 = -64.0;

/// Number of rows of the picture that are made one after the other, so that they share the neighbourhoods of their samples.
const SHARED_ROWS: usize = 8;

/// Samples of the nine pixels around one.
struct Neighbourhood {
    /// Means of the opponent colours and of their squares.
    mean: Vec3,
    mean_square: Vec3,
    /// Motion of the surface nearest to the camera: edges move with what is in front. `None` without a last
    /// picture, and behind one of the cameras.
    motion: Option<SurfaceMotion>,
}

/// A point of a surface, and its positions in the last picture and in this one, each in pixels of its samples.
struct SurfaceMotion {
    sought: SoughtPoint,
    before: [f32; 2],
    now: [f32; 2],
}

/// New samples of a picture, which is shown at another size.
struct Upscaling<'a> {
    frame: &'a FrameUniforms,
    projection: Projection,
    guides: &'a [Guide],
    samples: &'a [Vec3],
    /// Opponent colour of each sample, and the length of its path; the largest number if it is no part of the picture.
    opponents: Vec<Vec4>,
    /// Position of each sample, pixels of the samples; `None` if the picture is as large as they are.
    positions: Option<Planes<2>>,
    /// Pixels of the picture for each pixel of the samples.
    factor: [f32; 2],
}

/// Averages samples with the last picture, at a size that is at least theirs. If emitters are a layer apart, samples of them
/// do not move others.
pub(super) fn antialiased(
    frame: &FrameUniforms,
    guides: &[Guide],
    samples: &[Vec3],
    size: [u32; 2],
    last: Option<Last>,
    emitters_are_apart: bool,
) -> ShownPicture {
    let is_larger = size != frame.size();
    let projection = Projection::new(frame);
    let position = |index: usize| sample_position(frame, &projection, index, &guides[index]);
    let length = |guide: &Guide| if emitters_are_apart && guide.is_seen_emitter() { f32::MAX } else { guide.length };
    let opponent = |(sample, guide): (&Vec3, &Guide)| opponent_of(*sample).extend(length(guide));
    let upscaling = Upscaling {
        frame,
        projection,
        guides,
        samples,
        opponents: samples.par_iter().zip(guides).with_min_len(4096).map(opponent).collect(),
        positions: is_larger.then(|| Planes::new(Grid::new(frame.size()), [0.0; 2], position)),
        factor: [size[0] as f32 / frame.width as f32, size[1] as f32 / frame.height as f32],
    };
    if last.is_none() && !is_larger {
        return ShownPicture { size, colours: samples.iter().map(|sample| sample.extend(0.0)).collect() };
    }
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
        let [samples_wide, samples_high] = self.frame.size().map(|side| side as usize);
        let point = |pixel: usize, k: usize| (pixel as f32 + 0.5) / self.factor[k];
        let (mut row_of_samples, mut neighbourhoods) = (usize::MAX, Vec::new());
        for (row, colours) in colours.chunks_mut(width).enumerate() {
            let v = point(first_row + row, 1);
            let y = (v as usize).min(samples_high - 1);
            if row_of_samples != y {
                row_of_samples = y;
                neighbourhoods = (0..samples_wide).map(|x| self.neighbourhood([x, y], last)).collect();
            }
            for (column, colour) in colours.iter_mut().enumerate() {
                let u = point(column, 0);
                let x = (u as usize).min(samples_wide - 1);
                *colour = self.pixel([u, v], [x, y], &neighbourhoods[x], last).extend(0.0);
            }
        }
    }

    /// Colour of the picture at a point, in pixels of the samples, within one of these pixels.
    fn pixel(&self, point: [f32; 2], pixel: [usize; 2], around: &Neighbourhood, last: Option<Last>) -> Vec3 {
        let &Neighbourhood { mean, mean_square, ref motion } = around;
        let (new, weight) = self.interpolated(point, pixel);
        let Some(Last { picture: shown, history, new_weight, .. }) = last else { return new };
        let position = motion.as_ref().and_then(|motion| self.before(point, motion, history));
        let Some(position) = position else { return new };
        let sampled = history.frame.size();
        let old = shown.cubic(std::array::from_fn(|k| position[k] * shown.size[k] as f32 / sampled[k] as f32));
        let deviation = REACH * (mean_square - mean * mean).max(Vec3::ZERO).map(f32::sqrt);
        let old = colour_of(opponent_of(old).clamp(mean - deviation, mean + deviation)).max(Vec3::ZERO);
        let moved = |k: usize| position[k] * self.frame.size()[k] as f32 / sampled[k] as f32 - point[k];
        let speed = (Vec2::new(moved(0), moved(1)).length() / FAST_MOTION).min(1.0);
        let new_weight = new_weight.max(MOVING_WEIGHT * speed);
        old.lerp(new, (new_weight * weight).max(MIN_WEIGHT))
    }

    /// Motion of the surface of the sample with this index since the last picture.
    fn motion_of(&self, index: usize, Last { history, earlier, .. }: Last) -> Option<SurfaceMotion> {
        let guide = &self.guides[index];
        let sought = history.sought(guide, earlier.at(index, guide), self.frame);
        let before = history.projection.project(sought.position)?;
        Some(SurfaceMotion { sought, before, now: self.projection.project(guide.position)? })
    }

    /// Position of a point in the last picture, if it moves as this surface does; `None` outside, and where the surface was
    /// hidden. Both positions are in pixels of the samples.
    fn before(&self, point: [f32; 2], motion: &SurfaceMotion, history: &History) -> Option<[f32; 2]> {
        let SurfaceMotion { sought, before, now } = motion;
        // Pictures may differ in size.
        let size = [history.frame.width as f32, history.frame.height as f32];
        let scale = [size[0] / self.frame.width as f32, size[1] / self.frame.height as f32];
        let [x, y]: [f32; 2] = std::array::from_fn(|k| (point[k] - now[k]) * scale[k] + before[k]);
        let is_inside = (0.0..size[0]).contains(&x) && (0.0..size[1]).contains(&y);
        (is_inside && history.shows(sought, [x, y])).then_some([x, y])
    }

    /// Indices of a pixel of the samples and those around it, row by row.
    fn square(&self, [x, y]: [usize; 2]) -> impl Iterator<Item = usize> + use<> {
        let [width, height] = self.frame.size().map(|side| side as usize);
        let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
        let columns = x.saturating_sub(1)..=(x + 1).min(width - 1);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// Samples around a pixel of them.
    fn neighbourhood(&self, [x, y]: [usize; 2], last: Option<Last>) -> Neighbourhood {
        let centre = y * self.frame.width as usize + x;
        let (mut sum, mut squares, mut count) = (Vec4::ZERO, Vec4::ZERO, 0.0);
        let (mut nearest, mut least) = (centre, self.opponents[centre].w);
        for index in self.square([x, y]) {
            let opponent = self.opponents[index];
            if opponent.w < least {
                (nearest, least) = (index, opponent.w);
            }
            sum += opponent;
            squares += opponent * opponent;
            count += 1.0;
        }
        let motion = last.and_then(|last| self.motion_of(nearest, last));
        Neighbourhood { mean: sum.xyz() / count, mean_square: squares.xyz() / count, motion }
    }

    /// Colour at a point, in pixels of the samples, within one of these pixels, and the weight of the sample nearest to it, 0 to 1.
    fn interpolated(&self, point: [f32; 2], [x, y]: [usize; 2]) -> (Vec3, f32) {
        let (grid, width) = (Grid::new(self.frame.size()), self.frame.width as usize);
        let own = self.samples[y * width + x];
        let Some(positions) = &self.positions else { return (own, 1.0) };
        let (mut opponent, mut total, mut largest) = (Vec4::ZERO, 0.0, 0.0);
        for place in (-1..=1).filter_map(|dy| Place::new(x, y as i32).moved(grid, -1, dy)) {
            let distance = |k: usize| (positions.load(k, place) - f32x8::splat(point[k])) * self.factor[k];
            let weights = gaussian(distance(0), distance(1)).to_array();
            let row = &self.opponents[place.row as usize * width..][..width];
            let inside = usize::from(x == 0)..(width + 1 - x).min(3);
            for (&weight, &there) in weights[inside.clone()].iter().zip(&row[x + inside.start - 1..]) {
                opponent += there * weight;
                total += weight;
                largest = f32::max(largest, weight);
            }
        }
        if total > 0.0 { (colour_of(opponent.xyz() / total), largest) } else { (own, 1.0) }
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
fn opponent_of(colour: Vec3) -> Vec3 {
    let Vec3 { x: r, y: g, z: b } = colour;
    Vec3::new(0.25 * r + 0.5 * g + 0.25 * b, 0.5 * (r - b), 0.5 * g - 0.25 * (r + b))
}

/// Inverse of [`opponent_of`].
fn colour_of(opponent: Vec3) -> Vec3 {
    let Vec3 { x: lightness, y: orange, z: green } = opponent;
    Vec3::new(lightness + orange - green, lightness + green, lightness - orange - green)
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
