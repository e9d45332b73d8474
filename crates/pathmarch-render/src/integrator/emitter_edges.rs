//! Emitter edges: further camera rays through the edges of emitters that the camera sees.
//!
//! **Idea.** A pixel that a small or bright emitter covers in part is noisy: its camera rays hit the emitter or miss it.
//! But what emitters add to it directly is the mean of their emission over camera rays alone, and a path costs ten times
//! as much as its camera ray. So each sample of such a pixel has [`EDGE_RAYS`] further camera rays. The mean of the
//! emission that they find takes the place of that of the path's own ray: the difference is added to the sample. Its
//! expected value is zero, so any pixels may have it.
//!
//! **Pixels.** Those within the bounds of an emitter, unless a few camera rays through them and their neighbours all
//! find the same emission; and all that an emitter of a few pixels or less, or one far [out of focus](super::lens_targets),
//! may cover.
//!
//! **Source.** More primary than secondary rays, where they cause the variance: Arvo and Kirk 1990, "Particle Transport
//! and Image Synthesis", section 5.
//!
//! **Cost.** Sixteen camera rays for each sample of these pixels. Sixty-four lamps over a plane: 2 % of the time, and a
//! tenth of the relMSE (docs/performance.md).

use super::camera::{camera_rays, pixel_sampler};
use super::lens_targets::{Disc, FurtherRay, LensTargets};
use super::path::{self, SeenEmission};
use super::splitting::camera_ray_index;
use crate::intersect::ray::Ray;
use crate::sampling::sobol::{PixelSampler, hash, pair};
use crate::scene::{FrameUniforms, TraceContext};
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

shared_constants! {
    /// Number of further camera rays of each sample.
    const EDGE_RAYS: u32 = 15;
    /// Number of rays of each sample: these, and the path's own.
    const RAYS_PER_EDGE: u32 = EDGE_RAYS + 1;
    /// Number of pixels whose rays a workgroup traces.
    pub(crate) const EDGES_PER_GROUP: u32 = 64 / RAYS_PER_EDGE;
}

/// Number of camera rays through a pixel near an emitter, to find whether its emission varies.
const PROBE_RAYS: u32 = 4;
/// Largest radius of an emitter whose pixels all count as edges, pixels.
const SMALL_RADIUS: f32 = 1.5;

/// Smallest number of samples, summed over the pixels, of a picture in which edges are found.
const MIN_SAMPLES: f64 = 1e6;

/// True if a picture of this size and with so many samples of a pixel is worth finding its edges.
pub(crate) fn pay(size: [u32; 2], samples: u32) -> bool {
    size.map(f64::from).iter().product::<f64>() * f64::from(samples) >= MIN_SAMPLES
}

/// Pixels at edges of emitters.
#[derive(Debug)]
pub(crate) struct EmitterEdges {
    width: u32,
    /// Indices of the pixels, row by row, in ascending order.
    pixels: Vec<u32>,
    targets: LensTargets,
}

/// What is known of a pixel before rays are traced through it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    /// No emitter is near.
    Outside,
    /// Within the bounds of an emitter.
    Near,
    /// Within those of a small one, or one far out of focus.
    Edge,
}

impl EmitterEdges {
    /// Edges in the picture of a context; `None` if there are none.
    pub(crate) fn new(ctx: &TraceContext) -> Option<Self> {
        let [width, height] = ctx.frame.size();
        let mut places = vec![Place::Outside; width as usize * height as usize];
        let mut mark = |disc: Disc, place: Place| {
            disc.visit([width, height], |pixel| places[pixel] = place.max(places[pixel]));
        };
        let bounds = ctx.scene.lights.iter().filter_map(|light| light.shape.emitting_bounds());
        for disc in bounds.filter_map(|(centre, radius)| Disc::new(ctx.frame, centre, radius)) {
            mark(disc, if disc.radius <= SMALL_RADIUS { Place::Edge } else { Place::Near });
        }
        let targets = LensTargets::new(ctx);
        targets.discs().for_each(|disc| mark(disc, Place::Edge));
        if places.iter().all(|&place| place == Place::Outside) {
            return None;
        }
        let found = probe(ctx, &places);
        let varies = |pixel: usize| {
            let (x, y) = (pixel as u32 % width, pixel as u32 / width);
            let around = |at: u32, length: u32| at.saturating_sub(1)..(at + 2).min(length);
            let pixels = around(y, height).flat_map(|y| around(x, width).map(move |x| (y * width + x) as usize));
            pixels.map(|near| found[near]).any(|near| near == MIXED || (near != UNKNOWN && near != found[pixel]))
        };
        let is_edge = |pixel: &u32| match places[*pixel as usize] {
            Place::Outside => false,
            Place::Near => varies(*pixel as usize),
            Place::Edge => true,
        };
        let pixels: Vec<u32> = (0..places.len() as u32).into_par_iter().filter(is_edge).collect();
        (!pixels.is_empty()).then_some(Self { width, pixels, targets })
    }

    /// These pixels of a picture of this width, in ascending order.
    #[cfg(test)]
    pub(crate) fn at(width: u32, pixels: Vec<u32>) -> Self {
        Self { width, pixels, targets: LensTargets::default() }
    }

    /// True if a pixel is among them.
    pub(crate) fn contains(&self, x: u32, y: u32) -> bool {
        self.pixels.binary_search(&(y * self.width + x)).is_ok()
    }

    /// Indices of the pixels, row by row, in ascending order.
    pub(crate) fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Places among the [`pixels`](Self::pixels) of those in these rows.
    pub(crate) fn in_rows(&self, rows: Range<u32>) -> Range<usize> {
        self.between(rows.start * self.width, rows.end * self.width)
    }

    /// Pixels (x, y) in these columns and rows.
    pub(crate) fn within(&self, columns: Range<u32>, rows: Range<u32>) -> Vec<(u32, u32)> {
        let of_row = |y: u32| {
            let row = y * self.width;
            let places = self.between(row + columns.start, row + columns.end);
            self.pixels[places].iter().map(move |pixel| (pixel - row, y))
        };
        rows.flat_map(of_row).collect()
    }

    /// Corrections of the sums of the `samples` samples of each of these pixels that share the camera ray of sample `first`.
    pub(crate) fn corrections(&self, ctx: &TraceContext, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
        if pixels.is_empty() {
            return Vec::new();
        }
        let ray = camera_ray_index(first, ctx.config.splitting);
        let own = emission(ctx, pixels, ray..ray + 1);
        let further = seen_by_further_rays(ctx, &self.targets, pixels, ray.wrapping_mul(RAYS_PER_EDGE), EDGE_RAYS);
        let mean = |seen: &[Seen]| {
            seen.iter().map(|seen| seen.emission.radiance * seen.weight).sum::<Vec3>() / EDGE_RAYS as f32
        };
        let means = further.chunks(EDGE_RAYS as usize).map(mean);
        let difference = |(mean, own): (Vec3, Vec3)| {
            let difference = samples as f32 * (mean - own);
            // The film rejects samples that are not finite.
            if difference.is_finite() { difference } else { Vec3::ZERO }
        };
        means.zip(own).map(difference).collect()
    }

    /// Places of the pixels with these indices.
    fn between(&self, start: u32, end: u32) -> Range<usize> {
        let first = |index: u32| self.pixels.partition_point(|&pixel| pixel < index);
        first(start)..first(end)
    }
}

/// Code of a pixel that is not probed.
const UNKNOWN: u32 = 0;
/// Code of a pixel with several emissions.
const MIXED: u32 = 1;

/// Code of the emission along a few camera rays through each pixel near an emitter: [`UNKNOWN`], [`MIXED`], or one for each
/// value.
fn probe(ctx: &TraceContext, places: &[Place]) -> Vec<u32> {
    let frame = FrameUniforms { seed: hash(ctx.frame.seed), ..*ctx.frame };
    let ctx = TraceContext { frame: &frame, ..*ctx };
    let width = frame.width as usize;
    let code = |found: &[Vec3]| {
        let [r, g, b] = found[0].to_array().map(f32::to_bits);
        let is_mixed = found.iter().any(|emission| *emission != found[0]);
        if is_mixed { MIXED } else { hash(r ^ hash(g ^ hash(b))).max(MIXED + 1) }
    };
    let of_row = |(y, row): (usize, &[Place])| {
        let near: Vec<(u32, u32)> =
            (0..frame.width).filter(|&x| row[x as usize] == Place::Near).map(|x| (x, y as u32)).collect();
        let found = emission(&ctx, &near, 0..PROBE_RAYS);
        let mut codes = vec![UNKNOWN; width];
        for ((x, _), found) in near.into_iter().zip(found.chunks(PROBE_RAYS as usize)) {
            codes[x as usize] = code(found);
        }
        codes
    };
    places.par_chunks(width).enumerate().flat_map_iter(of_row).collect()
}

/// Emission along these camera rays through each of these pixels, pixel by pixel.
fn emission(ctx: &TraceContext, pixels: &[(u32, u32)], indices: Range<u32>) -> Vec<Vec3> {
    let (pixels, samplers) = samplers(ctx, pixels, indices);
    let rays: Vec<Ray> = camera_rays(ctx.frame, &pixels, &samplers);
    path::emission_along(ctx, rays.into_iter().zip(samplers)).into_iter().map(|seen| seen.radiance).collect()
}

/// Random numbers of these camera rays through each of these pixels, pixel by pixel, and the pixel of each.
fn samplers(ctx: &TraceContext, pixels: &[(u32, u32)], indices: Range<u32>) -> (Vec<(u32, u32)>, Vec<PixelSampler>) {
    let of_pixel = |&(x, y): &(u32, u32)| {
        let sampler = move |index: u32| pixel_sampler(ctx, x, y, index);
        indices.clone().map(move |index| ((x, y), sampler(index)))
    };
    pixels.iter().flat_map(of_pixel).unzip()
}

/// Emission that a further camera ray sees.
pub(super) struct Seen {
    pub(super) emission: SeenEmission,
    /// Weight of the emission in the mean over the rays of the pixel.
    pub(super) weight: f32,
}

/// Emission along `count` camera rays through each of these pixels, pixel by pixel, whose random numbers are not those of its
/// samples.
pub(super) fn seen_by_further_rays(
    ctx: &TraceContext,
    targets: &LensTargets,
    pixels: &[(u32, u32)],
    first: u32,
    count: u32,
) -> Vec<Seen> {
    let frame = FrameUniforms { seed: hash(!ctx.frame.seed), ..*ctx.frame };
    let ctx = &TraceContext { frame: &frame, ..*ctx };
    let (pixels, samplers) = samplers(ctx, pixels, first..first + count);
    let in_pixels = PixelSampler::samples_2d(&samplers, pair::PAIR_PIXEL);
    let on_lens = match frame.lens_radius == 0.0 {
        true => vec![[0.0; 2]; samplers.len()],
        false => PixelSampler::samples_2d(&samplers, pair::PAIR_LENS),
    };
    let ray = |slot: usize| {
        let ((x, y), [dx, dy]) = (pixels[slot], in_pixels[slot]);
        let position = [x as f32 + dx, y as f32 + dy];
        targets.ray(&frame, position, on_lens[slot], FurtherRay { index: slot as u32 % count, count })
    };
    let (rays, weights): (Vec<Ray>, Vec<f32>) = (0..pixels.len()).map(ray).unzip();
    let seen = path::emission_along(ctx, rays.into_iter().zip(samplers));
    seen.into_iter().zip(weights).map(|(emission, weight)| Seen { emission, weight }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use glam::Vec2;
    use pathmarch_scene::Scene;

    /// Edges in a picture of 64x48 pixels, at a distance of 8 metres 8 pixels a metre, of the scene with these objects.
    fn edges(objects: &str) -> Option<EmitterEdges> {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 8; target 0 0 0; fov 41.112 }}\nmaterial \"lamp\" {{ emit 5 }}\n\
             material \"wall\" {{ diffuse 0.5 }}\n{objects}"
        );
        let scene = Scene::parse("test.kdl", &text).expect("valid");
        let input = RenderInput::new(&scene, &Settings { size: [64, 48], ..Settings::of(&scene) });
        EmitterEdges::new(&input.context(None))
    }

    /// Distance of the centre of a pixel from that of the picture, pixels.
    fn from_centre((x, y): (u32, u32)) -> f32 {
        Vec2::new(x as f32 - 31.5, y as f32 - 23.5).length()
    }

    #[test]
    fn the_outline_of_a_ball_is_an_edge() {
        let edges = edges("object \"ball\" material=\"lamp\" { sphere 1.5 }").expect("has an outline");
        let radius = 8.0 * 1.5 * 8.0 / (8.0f32.powi(2) - 1.5f32.powi(2)).sqrt();
        for pixel in (0..48).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let from_outline = (from_centre(pixel) - radius).abs();
            let is_edge = edges.within(pixel.0..pixel.0 + 1, pixel.1..pixel.1 + 1) == [pixel];
            assert!(is_edge || from_outline > 0.7, "{pixel:?} is {from_outline} pixels from the outline");
            assert!(!is_edge || from_outline < 3.0, "{pixel:?} is {from_outline} pixels from the outline");
        }
    }

    #[test]
    fn a_lamp_smaller_than_a_pixel_has_edges() {
        let edges = edges("object \"ball\" material=\"lamp\" { sphere 0.01 { at 0.02 0.02 0 } }").expect("is seen");
        assert!(edges.within(32..33, 23..24) == [(32, 23)]);
        assert!(edges.pixels().len() <= 9);
    }

    #[test]
    fn what_is_not_seen_has_no_edges() {
        let ball = "object \"ball\" material=\"lamp\" { sphere 1.5 }";
        assert!(
            edges(&format!("{ball}\nobject \"wall\" material=\"wall\" {{ box 20 20 0.1 {{ at 0 0 3 }} }}")).is_none()
        );
        assert!(edges(&ball.replace("1.5", "1.5 { at 0 0 20 }")).is_none(), "behind the camera");
        assert!(edges(&ball.replace("1.5", "1.5 { at 40 0 0 }")).is_none(), "beside the picture");
        assert!(edges(&ball.replace("1.5", "20")).is_none(), "the camera is inside");
        assert!(edges("object \"ball\" material=\"wall\" { sphere 1.5 }").is_none(), "does not emit");
    }

    #[test]
    fn pixels_are_found_by_rows_and_rectangles() {
        let edges = edges("object \"ball\" material=\"lamp\" { sphere 1.5 }").expect("has an outline");
        assert!(edges.pixels().is_sorted());
        let (left, right) = (edges.within(0..30, 0..48).len(), edges.within(30..64, 0..48).len());
        assert_eq!(left + right, edges.pixels().len());
        assert_eq!(edges.in_rows(0..48), 0..edges.pixels().len());
        let rows = edges.in_rows(20..28);
        assert!(edges.pixels()[rows.clone()].iter().all(|pixel| (20..28).contains(&(pixel / 64))));
        assert_eq!(rows.len(), edges.within(0..64, 20..28).len());
    }
}
