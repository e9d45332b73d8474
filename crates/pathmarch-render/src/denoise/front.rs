//! Frames of a sequence: pixels whose rays reach several places, at edges and in glass, follow the surface in front.
//!
//! **Idea.** Such a pixel has no single point, but its edge, or its glass, moves with the surface that is next to the
//! camera. Its radiance is averaged with that of the frame before at that place, by the same weights as in
//! [`temporal`](super::temporal), from the halves of samples and features: what moves otherwise, as the background does,
//! differs from both halves, and does not count.
//!
//! **Source.** Motion of the nearest surface for edges: Karis 2014, "High-Quality Temporal Supersampling".

use super::features::{Features, FrontPoint};
use super::signal::{PixelClass, Signal, mean_channel};
use super::temporal::{Joined, MIN_PAST_VARIANCE, Past, bounded, limits};
use crate::integrator::guides::Guide;
use crate::reconstruct::{Motion, Projection, catmull_rom};
use glam::Vec3;
use rayon::prelude::*;

/// Largest distance between points in front, in sides of a pixel.
const FRONT_TOLERANCE: f32 = 6.0;
/// Half the side of the square in which errors are estimated, pixels.
const ERROR_RADIUS: usize = 2;
/// Weight of the samples against the prediction in halves of mixed pixels.
const SAMPLE_SHARE: f32 = 0.5;

/// Radiance of a frame, and the surfaces in front.
#[derive(Clone, Debug)]
pub(super) struct Fronts {
    /// Position and leaf of the surface in front.
    points: Vec<Option<(Vec3, u32)>>,
    radiance: Vec<Vec3>,
    /// Estimated variances of the radiance, mean of the channels.
    variances: Vec<f32>,
}

/// Filtered frame whose colours are composed.
pub(super) struct Composed<'a> {
    pub(super) signal: &'a Signal,
    pub(super) features: &'a Features,
    /// Filtered irradiance of both halves.
    pub(super) halves: &'a [Vec<Vec3>; 2],
    pub(super) joined: &'a Joined,
}

/// Averages the colours of pixels whose rays reach several places with the frame before.
pub(super) fn joined(frame: &Composed, colours: &mut [Vec3], past: Option<(&Past, &Fronts)>) -> Fronts {
    let &Composed { signal, features, .. } = frame;
    let size = [signal.grid.width, signal.grid.height];
    let pairs = features.halves[0].par_iter().zip(&features.halves[1]);
    let fronts: Vec<Option<FrontPoint>> = pairs.map(|(a, b)| FrontPoint::nearer(a.front, b.front)).collect();
    let points = fronts.par_iter().map(|front| front.map(|front| (front.position, front.leaf))).collect();
    let weight = |index: usize| f32::from(u8::from(frame.is_joined(index)));
    let weights: Vec<f32> = (0..colours.len()).into_par_iter().map(weight).collect();
    let square = |index: usize| {
        let [a, b] = frame.half_colours(index);
        bounded(signal.share * (1.0 - signal.share) * mean_channel((a - b) * (a - b)))
    };
    let squares: Vec<f32> = (0..colours.len()).into_par_iter().map(square).collect();
    let mut variances = signal.grid.box_means(&squares, &weights, ERROR_RADIUS);
    if let Some(past) = past.filter(|(past, _)| past.size == size && signal.has_two_halves()) {
        frame.join(&fronts, past, colours, &mut variances);
    }
    Fronts { points, radiance: colours.to_vec(), variances }
}

impl Composed<'_> {
    /// True for pixels whose rays reach several places.
    fn is_joined(&self, index: usize) -> bool {
        self.signal.surfaces[index].class != PixelClass::Source && !self.joined.is_one_place[index]
    }

    /// Radiance of a pixel from each half of the samples and of the features.
    fn half_colours(&self, index: usize) -> [Vec3; 2] {
        let surface = &self.signal.surfaces[index];
        [0, 1].map(|half: usize| {
            let sums = &self.features.halves[half][index];
            let irradiance = self.halves[half][index].max(Vec3::ZERO);
            let predicted = (sums.emission + sums.albedo * irradiance) / self.features.rays as f32;
            if surface.class != PixelClass::Mixed {
                return predicted;
            }
            let samples = surface.emission + surface.albedo * self.signal.halves[half][index];
            predicted.lerp(samples, SAMPLE_SHARE)
        })
    }

    /// Averages the colours of pixels with these surfaces in front, and updates their variances.
    fn join(&self, fronts: &[Option<FrontPoint>], past: (&Past, &Fronts), colours: &mut [Vec3], variances: &mut [f32]) {
        let found = self.found(fronts, past);
        let product = |index: usize| {
            let Some((past, _)) = found[index] else { return 0.0 };
            let [a, b] = self.half_colours(index);
            bounded(mean_channel((a - past) * (b - past)))
        };
        let products: Vec<f32> = (0..found.len()).into_par_iter().map(product).collect();
        let weights: Vec<f32> = found.iter().map(|found| f32::from(u8::from(found.is_some()))).collect();
        let errors = self.signal.grid.box_means(&products, &weights, ERROR_RADIUS);
        let (size, present) = (past.0.size, colours.to_vec());
        colours.par_iter_mut().zip(variances).enumerate().for_each(|(index, (colour, variance))| {
            let Some((past, past_variance)) = found[index] else { return };
            let error = errors[index].max(past_variance).max(MIN_PAST_VARIANCE * *variance);
            let share = *variance / (*variance + error).max(f32::MIN_POSITIVE);
            let [least, most] = limits(&present, size, index);
            *colour += (past.clamp(least, most) - *colour) * share;
            *variance *= 1.0 - share;
        });
    }

    /// Radiance and variance of the frame before at the places of all pixels; `None` where they have no past.
    fn found(&self, fronts: &[Option<FrontPoint>], (past, past_fronts): (&Past, &Fronts)) -> Vec<Option<(Vec3, f32)>> {
        let guide = |front: &Option<FrontPoint>| match *front {
            Some(FrontPoint { position, normal, length, leaf }) => {
                Guide { position, normal, length, leaf, ..Guide::NONE }
            }
            None => Guide::NONE,
        };
        let guides: Vec<Guide> = fronts.par_iter().map(guide).collect();
        let motion = Motion::new(&past.view.scene, &self.features.view.scene);
        let earlier = motion.earlier_points(&guides, self.features.pixel);
        let [before, now] = [&past.view, &self.features.view].map(|view| Projection::new(&view.frame));
        let find = |index: usize| {
            let front = fronts[index].filter(|_| self.is_joined(index))?;
            let position = earlier.at(index, &guides[index]).position;
            let (there, here) = (before.project(position)?, now.project(front.position)?);
            let pixel = [(index % past.size[0]) as f32, (index / past.size[0]) as f32];
            let place = std::array::from_fn(|k| pixel[k] + (there[k] - here[k]));
            let earlier = FrontPoint { position, ..front };
            past_fronts.find(past.size, place, &earlier, front.length * self.features.pixel)
        };
        (0..fronts.len()).into_par_iter().map(find).collect()
    }
}

impl Fronts {
    /// Radiance and variance at a position, in pixels from the centre of the first one, if the surface of a point is in
    /// front near it. `pixel`: side of a pixel there, metres.
    fn find(
        &self,
        [width, height]: [usize; 2],
        [x, y]: [f32; 2],
        point: &FrontPoint,
        pixel: f32,
    ) -> Option<(Vec3, f32)> {
        let is_inside = x >= 0.0 && y >= 0.0 && x <= (width - 1) as f32 && y <= (height - 1) as f32;
        if !is_inside {
            return None;
        }
        let at = |column: f32, row: f32| {
            let column = column.clamp(0.0, (width - 1) as f32) as usize;
            let row = row.clamp(0.0, (height - 1) as f32) as usize;
            row * width + column
        };
        let is_near = |index: usize| {
            self.points[index].is_some_and(|(position, other)| {
                other == point.leaf && (position - point.position).length_squared() <= (FRONT_TOLERANCE * pixel).powi(2)
            })
        };
        let (nearest_x, nearest_y) = (x.round(), y.round());
        let shows = |k: i32| is_near(at(nearest_x + (k % 3 - 1) as f32, nearest_y + (k / 3 - 1) as f32));
        if !(0..9).any(shows) {
            return None;
        }
        let (left, top) = (x.floor(), y.floor());
        let (columns, rows) = (catmull_rom(x - left), catmull_rom(y - top));
        let (mut sum, mut least, mut most) = (Vec3::ZERO, Vec3::MAX, Vec3::MIN);
        for (j, row) in rows.into_iter().enumerate() {
            for (i, column) in columns.into_iter().enumerate() {
                let colour = self.radiance[at(left + i as f32 - 1.0, top + j as f32 - 1.0)];
                sum += colour * (row * column);
                if (1..=2).contains(&i) && (1..=2).contains(&j) {
                    (least, most) = (least.min(colour), most.max(colour));
                }
            }
        }
        sum.is_finite().then(|| (sum.clamp(least, most), self.variances[at(nearest_x, nearest_y)]))
    }
}
