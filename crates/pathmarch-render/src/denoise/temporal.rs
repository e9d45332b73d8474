//! Frames of a sequence: each is averaged with the one before along the motion, so that the rest of the noise does not
//! flicker.
//!
//! **Idea.** A pixel finds its point in the frame before by its position in space: the camera is known exactly, and moved
//! objects by [`Motion`]. In mirrors, the image of a point leads to a first guess, and Newton steps over the positions that
//! the frame before shows lead to the point. There it must show the same place of the same surface. The irradiance is
//! averaged by the inverse of the expected squared errors. The halves of the frame tell its own variance; the product of the
//! differences between both halves and the past, whose noise is independent, has the mean of the squared error of the
//! past. So a light that changes leaves no trail.
//!
//! **Source.** Reprojection with validated points: Schied et al. 2017, "Spatiotemporal Variance-Guided Filtering";
//! weights by estimated errors of filtered halves: Rousselle, Knaus, Zwicker 2012; interpolation: Catmull and Rom 1974.
//!
//! **Limits.** Pixels whose rays reach several places are those of [`front`](super::front): edges, glass, blur of lens and
//! motion.
//!
//! **Cost.** See `docs/denoising.md`; memory of [`Past`], about 115 bytes a pixel, and the scene of one frame.

use super::features::{Features, PixelFeatures, SeenLeaf, View};
use super::signal::{PixelClass, Signal, Surface, mean_channel};
use crate::integrator::guides::{Guide, NO_LEAF};
use crate::reconstruct::{EarlierPoint, EarlierPoints, Motion, Projection, catmull_rom};
use glam::Vec3;
use rayon::prelude::*;

/// Largest deviation of the positions that the rays of a pixel reach, in sides of the pixel on the surface.
const MAX_SPREAD: f32 = 0.8;
/// Largest distance of a point of the past from the plane of the surface, in sides of a pixel.
const PLANE_TOLERANCE: f32 = 1.5;
/// Largest distance within the plane, in sides of a pixel on the surface.
const POINT_TOLERANCE: f32 = 2.5;
/// Least cosine between the normal and the ray by which sides of a pixel are divided.
const MIN_GRAZING_COSINE: f32 = 0.05;
/// Cosine that is assumed for surfaces in mirrors.
const MIRRORED_COSINE: f32 = 0.3;
/// Least cosine between normals of one surface.
const MIN_NORMAL_COSINE: f32 = 0.9;
/// Largest difference between hashes of one material.
const MATERIAL_TOLERANCE: f32 = 1e-4;
/// Least share of the bilinear weights that must show the point.
const MIN_SHOWN: f32 = 0.3;
/// Newton steps towards a point in a mirror.
const MIRROR_STEPS: u32 = 4;
/// Least squared length of the mean normal of the rays of a pixel that reach one place.
const MIN_COMMON_NORMAL: f32 = 0.9;
/// Half the side of the square in which errors are estimated, pixels.
const ERROR_RADIUS: usize = 3;
/// Squared error of a pixel by itself above which it counts more than that of the square, in variances of the frame.
const OWN_ERROR: f32 = 4.0;
/// Least variance of the past, in variances of the frame.
pub(super) const MIN_PAST_VARIANCE: f32 = 0.06;
/// Largest square of an error in sums.
const MAX_SQUARE: f32 = 1e30;
/// Standard deviations of the frame by which the past may be beyond its nine pixels around the point.
const REACH: f32 = 0.1;

/// Filtered frame.
pub(super) struct Filtered<'a> {
    pub(super) signal: &'a Signal,
    pub(super) features: &'a Features,
    /// Filtered irradiance of both halves.
    pub(super) halves: &'a [Vec<Vec3>; 2],
    pub(super) irradiance: Vec<Vec3>,
}

/// Frame that is averaged with those before.
pub(super) struct Joined {
    pub(super) irradiance: Vec<Vec3>,
    /// Estimated variance of the irradiance, mean of the channels.
    variances: Vec<f32>,
    pub(super) is_one_place: Vec<bool>,
}

/// A frame as the next one reads it.
#[derive(Clone, Debug)]
pub(super) struct Past {
    pub(super) view: View,
    pub(super) size: [usize; 2],
    surfaces: Vec<Surface>,
    /// True for pixels whose rays reach one place.
    is_one_place: Vec<bool>,
    irradiance: Vec<Vec3>,
    /// Estimated variances of the irradiance.
    variances: Vec<f32>,
}

impl Past {
    /// Past of the frame that comes next.
    pub(super) fn new(signal: Signal, features: &Features, joined: Joined) -> Self {
        let Joined { irradiance, variances, is_one_place } = joined;
        let size = [signal.grid.width, signal.grid.height];
        Self { view: features.view.clone(), size, surfaces: signal.surfaces, is_one_place, irradiance, variances }
    }
}

/// Point of a frame that is looked for in the one before.
struct SoughtPoint {
    position: Vec3,
    normal: Vec3,
    material: f32,
    /// Sides of a pixel at the distance of the surface, and on the surface where it is longest, metres.
    pixel: f32,
    stretched_pixel: f32,
    /// Position in the frame before, pixels from the centre of the first one; a first guess in mirrors.
    place: [f32; 2],
    is_mirrored: bool,
}

/// Irradiance of the frame before at a point.
#[derive(Clone, Copy, Default)]
struct Found {
    irradiance: Vec3,
    variance: f32,
}

/// Average of a frame and the one before.
pub(super) fn joined(frame: Filtered, past: Option<&Past>) -> Joined {
    let Filtered { signal, features, halves, irradiance } = frame;
    let own = own_variances(signal, halves);
    let pixels = Pixels::new(signal, features);
    let size = [signal.grid.width, signal.grid.height];
    let Some(past) = past.filter(|past| past.size == size && signal.has_two_halves()) else {
        return Joined { irradiance, variances: own, is_one_place: pixels.is_one_place };
    };
    let found = pixels.found(past);
    let weights: Vec<f32> = found.par_iter().map(|found| f32::from(u8::from(found.is_some()))).collect();
    let product = |index: usize| {
        let Some(found) = found[index] else { return 0.0 };
        bounded(mean_channel((halves[0][index] - found.irradiance) * (halves[1][index] - found.irradiance)))
    };
    let products: Vec<f32> = (0..found.len()).into_par_iter().map(product).collect();
    let mean_errors = signal.grid.box_means(&products, &weights, ERROR_RADIUS);
    let join = |index: usize| {
        let (present, variance) = (irradiance[index], own[index]);
        let Some(found) = found[index] else { return (present, variance) };
        let own_error = if products[index] > OWN_ERROR * variance { products[index] } else { 0.0 };
        // The error of the past: its variance, and what has changed.
        let past_error = mean_errors[index].max(own_error).max(found.variance).max(MIN_PAST_VARIANCE * variance);
        let share = variance / (variance + past_error).max(f32::MIN_POSITIVE);
        let [least, most] = limits(&irradiance, size, index);
        let margin = REACH * variance.sqrt();
        let plausible = found.irradiance.clamp(least - margin, most + margin);
        // A picture at rest stays as it is, to the bit.
        (present + (plausible - present) * share, variance * (1.0 - share))
    };
    let (irradiance, variances) = (0..irradiance.len()).into_par_iter().map(join).unzip();
    Joined { irradiance, variances, is_one_place: pixels.is_one_place }
}

/// Square of an error, small enough for sums; 0 if it is not a number.
pub(super) fn bounded(square: f32) -> f32 {
    if square.is_nan() { 0.0 } else { square.clamp(-MAX_SQUARE, MAX_SQUARE) }
}

/// Least and largest values of the nine pixels around one.
pub(super) fn limits(values: &[Vec3], [width, height]: [usize; 2], index: usize) -> [Vec3; 2] {
    let (x, y) = (index % width, index / width);
    let [mut least, mut most] = [values[index]; 2];
    for row in y.saturating_sub(1)..=(y + 1).min(height - 1) {
        for column in x.saturating_sub(1)..=(x + 1).min(width - 1) {
            let there = values[row * width + column];
            (least, most) = (least.min(there), most.max(there));
        }
    }
    [least, most]
}

/// Variances of a frame by itself, from its halves.
fn own_variances(signal: &Signal, halves: &[Vec<Vec3>; 2]) -> Vec<f32> {
    let both = halves[0].par_iter().zip(&halves[1]);
    let share = signal.share * (1.0 - signal.share);
    let squares: Vec<f32> = both.map(|(a, b)| bounded(share * mean_channel((*a - *b) * (*a - *b)))).collect();
    signal.grid.box_means(&squares, &signal.weights, ERROR_RADIUS)
}

/// Pixels of a frame, with the places that their rays reach.
struct Pixels<'a> {
    features: &'a Features,
    width: usize,
    surfaces: &'a [Surface],
    sums: Vec<PixelFeatures>,
    /// Sides of the pixels on the surface where they are longest, metres.
    stretched: Vec<f32>,
    /// True for pixels whose rays reach one place.
    is_one_place: Vec<bool>,
}

impl<'a> Pixels<'a> {
    fn new(signal: &'a Signal, features: &'a Features) -> Self {
        let halves = features.halves[0].par_iter().zip(&features.halves[1]);
        let sum = |(first, second): (&PixelFeatures, &PixelFeatures)| {
            let mut sums = *first;
            sums += *second;
            sums
        };
        let sums: Vec<PixelFeatures> = halves.map(sum).collect();
        let eye = Vec3::from(features.view.frame.position);
        let rays = 2.0 * features.rays as f32;
        let place = |(surface, sums): (&Surface, &PixelFeatures)| {
            let stretched = stretched_pixel(surface, sums, eye);
            let spread = (sums.squared_spread / sums.surfaces).sqrt();
            let is_one = spread <= MAX_SPREAD * stretched && surface.normal.length_squared() >= MIN_COMMON_NORMAL;
            let is_one_leaf = matches!(sums.leaf, SeenLeaf::Direct(_) | SeenLeaf::Indirect(_));
            let is_whole = surface.class != PixelClass::Source && sums.surfaces == rays;
            (stretched, is_one && is_one_leaf && is_whole)
        };
        let (stretched, is_one_place) = signal.surfaces.par_iter().zip(&sums).map(place).unzip();
        Self { features, width: signal.grid.width, surfaces: &signal.surfaces, sums, stretched, is_one_place }
    }

    /// Irradiance of the frame before at the points of all pixels; `None` where it does not show them.
    fn found(&self, past: &Past) -> Vec<Option<Found>> {
        let guide = |(surface, sums): (&Surface, &PixelFeatures)| Guide {
            position: surface.position,
            normal: surface.normal.normalize_or_zero(),
            length: sums.length / sums.surfaces.max(1.0),
            leaf: if let SeenLeaf::Direct(leaf) = sums.leaf { leaf } else { NO_LEAF },
            ..Guide::NONE
        };
        let guides: Vec<Guide> = self.surfaces.par_iter().zip(&self.sums).map(guide).collect();
        let motion = Motion::new(&past.view.scene, &self.features.view.scene);
        let earlier: EarlierPoints = motion.earlier_points(&guides, self.features.pixel);
        let projections = [&past.view, &self.features.view].map(|view| Projection::new(&view.frame));
        let find = |index: usize| {
            let sought = self.sought(index, earlier.at(index, &guides[index]), &projections)?;
            past.find(&sought)
        };
        (0..guides.len()).into_par_iter().map(find).collect()
    }

    /// Point of a pixel that was there in the scene of the frame before; `None` if its rays reach several places.
    fn sought(&self, index: usize, earlier: EarlierPoint, [past, present]: &[Projection; 2]) -> Option<SoughtPoint> {
        let (surface, sums) = (&self.surfaces[index], &self.sums[index]);
        let is_mirrored = matches!(sums.leaf, SeenLeaf::Indirect(_));
        if !self.is_one_place[index] {
            return None;
        }
        let image = sums.image / sums.surfaces;
        let now = present.project(if is_mirrored { image } else { surface.position })?;
        let before = past.project(if is_mirrored { image } else { earlier.position })?;
        // Relative to the centre of the pixel: the mean of a few rays is beside it.
        let pixel = [(index % self.width) as f32, (index / self.width) as f32];
        Some(SoughtPoint {
            position: earlier.position,
            normal: earlier.normal,
            material: surface.material,
            pixel: surface.footprint,
            stretched_pixel: self.stretched[index],
            place: std::array::from_fn(|k| pixel[k] + (before[k] - now[k])),
            is_mirrored,
        })
    }
}

/// Side of a pixel on the surface where it is longest, metres.
fn stretched_pixel(surface: &Surface, sums: &PixelFeatures, eye: Vec3) -> f32 {
    let cosine = match sums.leaf {
        SeenLeaf::Direct(_) => {
            let direction = (surface.position - eye).normalize_or_zero();
            surface.normal.normalize_or_zero().dot(direction).abs()
        }
        _ => MIRRORED_COSINE,
    };
    surface.footprint / cosine.max(MIN_GRAZING_COSINE)
}

impl Past {
    /// Irradiance of a point; `None` if the frame does not show it.
    fn find(&self, sought: &SoughtPoint) -> Option<Found> {
        let place = if sought.is_mirrored { self.refined(sought)? } else { sought.place };
        self.interpolated(sought, place)
    }

    /// Index of the pixel in this column and row; `None` outside.
    fn index(&self, x: f32, y: f32) -> Option<usize> {
        let [width, height] = self.size;
        let is_inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        is_inside.then(|| y as usize * width + x as usize)
    }

    /// True if a pixel shows the point, to within a few sides of a pixel.
    fn shows(&self, index: usize, sought: &SoughtPoint) -> bool {
        let surface = &self.surfaces[index];
        let apart = sought.position - surface.position;
        let limit = POINT_TOLERANCE * sought.stretched_pixel;
        self.is_one_place[index]
            && (surface.material - sought.material).abs() <= MATERIAL_TOLERANCE
            && sought.normal.dot(apart).abs() <= PLANE_TOLERANCE * sought.pixel
            && apart.length_squared() <= limit * limit
            && sought.normal.dot(surface.normal.normalize_or_zero()) >= MIN_NORMAL_COSINE
    }

    /// Position of a point in a mirror, pixels, by Newton steps over the positions that this frame shows.
    fn refined(&self, sought: &SoughtPoint) -> Option<[f32; 2]> {
        let mut place = sought.place;
        for _ in 0..MIRROR_STEPS {
            let (x, y) = (place[0].round(), place[1].round());
            let here = self.index(x, y)?;
            let position = |index: usize| self.surfaces[index].position;
            let along_x = self.index(x + 1.0, y).map_or(Vec3::ZERO, |next| position(next) - position(here));
            let along_y = self.index(x, y + 1.0).map_or(Vec3::ZERO, |next| position(next) - position(here));
            let apart = sought.position - position(here);
            // Least squares: normal equations of two unknowns.
            let (xx, xy, yy) = (along_x.length_squared(), along_x.dot(along_y), along_y.length_squared());
            let determinant = xx * yy - xy * xy;
            if determinant <= 1e-4 * xx * yy {
                return None;
            }
            let (bx, by) = (along_x.dot(apart), along_y.dot(apart));
            let step = [(bx * yy - by * xy) / determinant, (by * xx - bx * xy) / determinant];
            place = [x + step[0].clamp(-8.0, 8.0), y + step[1].clamp(-8.0, 8.0)];
            if step.iter().all(|step| step.abs() < 1.0) {
                return Some(place);
            }
        }
        None
    }

    /// Irradiance at a position, in pixels from the centre of the first one, interpolated between pixels that show the
    /// point: bicubic and limited to the four nearest where all do, or else bilinear.
    fn interpolated(&self, sought: &SoughtPoint, [x, y]: [f32; 2]) -> Option<Found> {
        let (left, top) = (x.floor(), y.floor());
        let (columns, rows) = (catmull_rom(x - left), catmull_rom(y - top));
        let (mut cubic, mut all) = (Vec3::ZERO, true);
        let (mut linear, mut variance, mut total) = (Vec3::ZERO, 0.0, 0.0);
        let (mut least, mut most) = (Vec3::MAX, Vec3::MIN);
        for (j, row) in rows.into_iter().enumerate() {
            for (i, column) in columns.into_iter().enumerate() {
                let (tap_x, tap_y) = (left + i as f32 - 1.0, top + j as f32 - 1.0);
                let Some(index) = self.index(tap_x, tap_y).filter(|&index| self.shows(index, sought)) else {
                    all = false;
                    continue;
                };
                let irradiance = self.irradiance[index];
                cubic += irradiance * (row * column);
                if (1..=2).contains(&i) && (1..=2).contains(&j) {
                    let weight = (1.0 - (x - tap_x).abs()) * (1.0 - (y - tap_y).abs());
                    linear += irradiance * weight;
                    variance += self.variances[index] * weight;
                    total += weight;
                    (least, most) = (least.min(irradiance), most.max(irradiance));
                }
            }
        }
        if total < MIN_SHOWN || !linear.is_finite() {
            return None;
        }
        let irradiance = if all { cubic.clamp(least, most) } else { linear / total };
        Some(Found { irradiance, variance: variance / total })
    }
}
