//! Light that other surfaces have scattered to that of a pixel, at half the resolution.
//!
//! **Idea.** Light that comes straight from lamps has sharp shadows and little noise; what walls scatter is smooth and
//! noisy. So each has its own means and filter: the indirect light is averaged over the pixels of 2x2 that show one
//! surface, continued and filtered at this size, with wider weights, and interpolated along the surfaces. It costs a
//! quarter of another layer.
//!
//! **Source.** Indirect light apart and at half the resolution: Zhdan 2021, "ReBLUR: A Hierarchical Recurrent Denoiser";
//! interpolation along surfaces: Kopf et al. 2007, "Joint Bilateral Upsampling".
//!
//! **Limits.** Light through glass, that of facets, and that of fractals is not split.

use super::film_view::FilmView;
use super::planes::Place;
use super::spatial::Filtered;
use super::surfaces::{SurfacePlanes, Vectors};
use super::{direct_irradiance, luminance, settles, variance_without_facets};
use crate::integrator::first_mirror::FirstMirror;
use crate::integrator::guides::{Guide, GuideClass};
use crate::integrator::medium_light::MEDIUM_ALPHA;
use crate::integrator::reflected_light::ReflectedLight;
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;
use wide::f32x8;

shared_constants! {
    /// Least cosine between the normals of pixels of 2x2 that are averaged.
    const MIN_BLOCK_COSINE: f32 = 0.8;
    /// Distance from a plane, in sides of a pixel, at which the weight of the interpolation ends.
    const INTERPOLATION_REACH: f32 = 4.0;
    /// Least sum of the weights of the interpolation, of 16.
    const MIN_INTERPOLATION_WEIGHT: f32 = 1e-2;
}

/// Indirect light of a film at half the resolution.
pub(super) struct HalfFilm {
    pub(super) frame: FrameUniforms,
    pub(super) guides: Arc<Vec<Guide>>,
    pub(super) surfaces: SurfacePlanes,
    pub(super) irradiance: Vec<Vec3>,
}

/// Frame of half the size.
pub(super) fn half_frame(frame: &FrameUniforms) -> FrameUniforms {
    let (width, height) = (frame.width.div_ceil(2), frame.height.div_ceil(2));
    FrameUniforms { width, height, pixel: 2.0 * frame.pixel, ..*frame }
}

/// Guide of a surface and the mean indirect irradiance of its pixels among these; that of the first pixel if none has such
/// light.
fn averaged(film: &FilmView, pixels: &[usize]) -> (Guide, Vec3) {
    let guides = film.guides.as_slice();
    // What is in front counts, so that thin objects have light; but the mean of several surfaces is that of none.
    let is_before = |a: &Guide, b: &Guide| (a.is_mixed, a.length) < (b.is_mixed, b.length);
    let mut front: Option<&Guide> = None;
    for guide in pixels.iter().map(|&pixel| &guides[pixel]).filter(|guide| guide.class == GuideClass::Surface) {
        if front.is_none_or(|front| is_before(guide, front)) {
            front = Some(guide);
        }
    }
    let Some(front) = front else { return (guides[pixels[0]], Vec3::ZERO) };
    let is_part = |guide: &Guide| {
        let is_same = guide.class == GuideClass::Surface
            && guide.object == front.object
            && guide.is_mixed == front.is_mixed
            && guide.has_medium() == front.has_medium();
        is_same && guide.normal.dot(front.normal) >= MIN_BLOCK_COSINE
    };
    let (mut sum, mut position, mut variance, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0, 0.0);
    for (pixel, guide) in pixels.iter().map(|&pixel| (pixel, &guides[pixel])).filter(|(_, guide)| is_part(guide)) {
        sum += guide.indirect.max(Vec3::ZERO) / guide.divisor();
        position += guide.position;
        // Nothing reads that of one sample.
        if film.samples > 1 {
            variance += variance_without_facets(guide, luminance(direct_irradiance(film.means[pixel], guide)));
        }
        count += 1.0;
    }
    let (irradiance, position) = (sum / count, position / count);
    let mean = luminance(irradiance);
    let guide = Guide {
        // The middle of the pixels: the nearest would draw the past towards the camera.
        position,
        length: position.distance(film.input.frame.position.into()),
        albedo: Vec3::ONE,
        square: mean * mean + variance / (count * count),
        is_glossy: front.is_glossy && !front.has_facets(),
        reflected: ReflectedLight {
            alpha: if front.has_medium() { MEDIUM_ALPHA } else { 0.0 },
            ..ReflectedLight::NONE
        },
        indirect: Vec3::ZERO,
        // Only anti-aliasing looks for their outlines, at the full resolution.
        mirror: FirstMirror::NONE,
        ..*front
    };
    (guide, irradiance)
}

/// Eight pixels and those beside them on one side, the left of even pixels and the right of odd ones, from numbers of pixels of
/// half the resolution, of which the first is left of that of the first pixel.
#[inline(always)]
fn interleaved(half: f32x8) -> [f32x8; 2] {
    let [a, b, c, d, e, f, ..] = half.to_array();
    [f32x8::new([b, b, c, c, d, d, e, e]), f32x8::new([a, c, b, d, c, e, d, f])]
}

impl HalfFilm {
    /// Indirect light of a film, averaged over blocks of 2x2 pixels.
    pub(super) fn new(film: &FilmView) -> Self {
        let [width, height] = film.input.frame.size().map(|side| side as usize);
        let frame = half_frame(&film.input.frame);
        let block = |index: u32| {
            let (x, y) = (2 * (index % frame.width) as usize, 2 * (index / frame.width) as usize);
            let first = y * width + x;
            match (x + 1 < width, y + 1 < height) {
                (true, true) => averaged(film, &[first, first + 1, first + width, first + width + 1]),
                (true, false) => averaged(film, &[first, first + 1]),
                (false, true) => averaged(film, &[first, first + width]),
                (false, false) => averaged(film, &[first]),
            }
        };
        let (guides, irradiance): (Vec<Guide>, _) =
            (0..frame.width * frame.height).into_par_iter().with_min_len(1024).map(block).unzip();
        let surfaces = SurfacePlanes::new(&frame, &guides, settles(film.samples));
        Self { frame, guides: Arc::new(guides), surfaces, irradiance }
    }

    /// Indirect irradiance of eight pixels, and the mask of those whose surface the pixels of half the resolution show.
    #[inline(always)]
    pub(super) fn interpolated(&self, surfaces: &SurfacePlanes, place: Place, filtered: &Filtered) -> (Vectors, f32x8) {
        let (position, normal, pixel) = (surfaces.position(place), surfaces.normal(place), surfaces.pixel(place));
        let surface = surfaces.surface(place).abs();
        let (mut sum, mut total) = (Vectors::splat(f32x8::ZERO), f32x8::ZERO);
        let half = Place { row: place.row / 2, column: Place::new(place.x() / 2, 0).column - 1 };
        for (dy, weights) in [(0, [9.0, 3.0]), (2 * (place.row % 2) - 1, [3.0, 1.0])] {
            let Some(there) = half.moved(self.surfaces.grid, 0, dy) else { continue };
            let both = |v: Vectors| {
                let ([ax, bx], [ay, by], [az, bz]) = (interleaved(v.x), interleaved(v.y), interleaved(v.z));
                [Vectors::new(ax, ay, az), Vectors::new(bx, by, bz)]
            };
            let positions = both(self.surfaces.position(there));
            let normals = both(self.surfaces.normal(there));
            let half_surfaces = interleaved(self.surfaces.surface(there).abs());
            let light = both(filtered.base(there));
            for k in 0..2 {
                let apart = positions[k] - position;
                let along = normal.dot(apart).abs().fast_max(normals[k].dot(apart).abs());
                let plane = f32x8::ONE - along / (pixel * INTERPOLATION_REACH);
                let cosine = normal.dot(normals[k]).fast_max(f32x8::ZERO);
                let square = cosine * cosine;
                let fourth = square * square;
                let similarity = plane.fast_max(f32x8::ZERO) * fourth * fourth * weights[k];
                let weight = surface.simd_eq(half_surfaces[k]) & similarity;
                sum = sum + light[k] * weight;
                total += weight;
            }
        }
        (sum / total, total.simd_gt(f32x8::splat(MIN_INTERPOLATION_WEIGHT)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::means::PixelMean;
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    const ROOM: &str = "pathmarch 1\ncamera { position 0 1 4; target 0 0.8 0; fov 40 }\nrender { bounces BOUNCES }\n\
        sky 0.2\nmaterial \"red\" { diffuse 0.7 0.2 0.2 }\nmaterial \"lamp\" { emit 5 }\n\
        material \"plastic\" { principled 0.5; roughness 0.6 }\nobject \"floor\" material=\"red\" { plane }\n\
        object \"box\" material=\"plastic\" { box 1 1 1 { at 0 0.5 -0.5; rotate 0 30 0 } }\n\
        object \"lamp\" material=\"lamp\" { sphere 0.3 { at 0.8 1.6 0.5 } }";

    fn input(bounces: u32, size: [u32; 2]) -> RenderInput {
        let scene = Scene::parse("test.kdl", &ROOM.replace("BOUNCES", &bounces.to_string())).expect("valid");
        RenderInput::new(&scene, &Settings { size, ..Settings::of(&scene) })
    }

    /// First samples of all pixels and their guides.
    fn samples(input: &RenderInput) -> (Vec<Vec3>, Arc<Vec<Guide>>) {
        let [width, height] = input.frame.size();
        let pixels: Vec<(u32, u32)> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
        let (means, guides) = input.sample_with_guides(&input.context(None), &pixels, 0);
        let guides = guides.into_iter().zip(&means).map(|(guide, mean)| guide.of_sample(*mean));
        let guides = guides.collect();
        (means, Arc::new(guides))
    }

    fn film<'a>(input: &'a RenderInput, (means, guides): &'a (Vec<Vec3>, Arc<Vec<Guide>>)) -> FilmView<'a> {
        FilmView { input, guides, means, samples: 1, first_sample: 0, weight: 0.0 }
    }

    #[test]
    fn direct_light_is_that_without_bounces() {
        let [(all, guides), (direct, _)] = [4, 0].map(|bounces| samples(&input(bounces, [40, 30])));
        let mut split = 0;
        for ((all, guide), direct) in all.iter().zip(guides.iter()).zip(&direct) {
            let indirect = guide.indirect;
            let error = (*all - indirect - *direct).abs().max_element();
            // Light in one word is smaller by up to 1/256.
            assert!(error <= indirect.max_element() / 256.0 + 1e-5, "{all} {indirect} {direct}");
            split += usize::from(indirect.max_element() > 0.0);
        }
        assert!(split > 60, "{split}");
    }

    #[test]
    fn halving_and_interpolation_keep_uniform_light_on_every_surface() {
        for size in [[40, 30], [41, 31], [1, 7]] {
            let input = input(1, size);
            let (means, guides) = samples(&input);
            let lit = |guide: &Guide| match guide.class {
                GuideClass::Surface => Guide { indirect: guide.divisor() * (1 + guide.object) as f32, ..*guide },
                _ => *guide,
            };
            let samples = (means, Arc::new(guides.iter().map(lit).collect()));
            let film = film(&input, &samples);
            let half = HalfFilm::new(&film);
            assert_eq!(half.irradiance.len(), half.guides.len());
            let mean = |irradiance: &Vec3| PixelMean { irradiance: *irradiance, ..PixelMean::default() };
            let means: Vec<PixelMean> = half.irradiance.iter().map(mean).collect();
            let filtered = Filtered::unfiltered(half.surfaces.grid, &means, None);
            let surfaces = SurfacePlanes::new(&input.frame, film.guides, false);
            let dark = Filtered::unfiltered(surfaces.grid, &vec![PixelMean::default(); guides.len()], None);
            let indirect = |place| half.interpolated(&surfaces, place, &filtered);
            let radiance = dark.light(surfaces.grid, film.guides, indirect, |light| light.radiance);
            for (guide, radiance) in film.guides.iter().zip(radiance) {
                assert!((radiance - guide.indirect).abs().max_element() < 1e-4, "{radiance} for {}", guide.indirect);
            }
        }
    }

    #[test]
    fn points_of_blocks_are_in_the_middle() {
        let input = input(1, [40, 30]);
        let samples = samples(&input);
        let film = film(&input, &samples);
        let half = HalfFilm::new(&film);
        let first = &film.guides[29 * 40];
        let floor = |guide: &Guide| guide.class == GuideClass::Surface && guide.object == first.object;
        let (mut offset, mut count) = (Vec3::ZERO, 0.0);
        for (index, guide) in half.guides.iter().enumerate() {
            let first = index / 20 * 80 + index % 20 * 2;
            let block = [0, 1, 40, 41].map(|at| &film.guides[first + at]);
            if block.iter().all(|guide| floor(guide)) {
                let middle = block.iter().map(|guide| guide.position).sum::<Vec3>() / 4.0;
                (offset, count) = (offset + guide.position - middle, count + 1.0);
            }
        }
        assert!(count > 50.0 && (offset / count).length() < 1e-5, "{offset} {count}");
    }
}
