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
use super::planes::Grid;
use super::{direct_irradiance, luminance, variance_without_facets};
use crate::integrator::guides::{Guide, GuideClass};
use crate::integrator::medium_light::MEDIUM_ALPHA;
use crate::integrator::reflected_light::ReflectedLight;
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

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
    pub(super) irradiance: Vec<Vec3>,
}

/// Frame of half the size.
pub(super) fn half_frame(frame: &FrameUniforms) -> FrameUniforms {
    let (width, height) = (frame.width.div_ceil(2), frame.height.div_ceil(2));
    FrameUniforms { width, height, pixel: 2.0 * frame.pixel, ..*frame }
}

/// Guide of a surface and the mean indirect irradiance of its pixels among these; that of the first pixel if none has such
/// light.
fn averaged(film: &FilmView, pixels: impl Iterator<Item = usize> + Clone) -> (Guide, Vec3) {
    let of = |pixel: usize| &film.guides[pixel];
    let surfaces = pixels.clone().filter(|&pixel| of(pixel).class == GuideClass::Surface);
    // What is in front counts, so that thin objects have light; but the mean of several surfaces is that of none.
    let first = |&a: &usize, &b: &usize| {
        let (a, b) = (of(a), of(b));
        a.is_mixed.cmp(&b.is_mixed).then(a.length.total_cmp(&b.length))
    };
    let Some(front) = surfaces.clone().min_by(first) else {
        return (pixels.map(of).next().copied().unwrap_or(Guide::NONE), Vec3::ZERO);
    };
    let front = of(front);
    let is_part = |guide: &Guide| {
        let is_same = guide.object == front.object
            && guide.is_mixed == front.is_mixed
            && guide.has_medium() == front.has_medium();
        is_same && guide.normal.dot(front.normal) >= MIN_BLOCK_COSINE
    };
    let (mut sum, mut position, mut variance, mut count) = (Vec3::ZERO, Vec3::ZERO, 0.0, 0.0);
    for (pixel, guide) in surfaces.map(|pixel| (pixel, of(pixel))).filter(|(_, guide)| is_part(guide)) {
        sum += guide.indirect.max(Vec3::ZERO) / guide.divisor();
        position += guide.position;
        variance += variance_without_facets(guide, luminance(direct_irradiance(film.means[pixel], guide)));
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
        ..*front
    };
    (guide, irradiance)
}

impl HalfFilm {
    /// Indirect light of a film, averaged over blocks of 2x2 pixels.
    pub(super) fn new(film: &FilmView) -> Self {
        let grid = Grid::new(film.input.frame.size());
        let frame = half_frame(&film.input.frame);
        let block = |index: u32| {
            let (x, y) = (2 * (index % frame.width) as i32, 2 * (index / frame.width) as i32);
            let pixels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| grid.index(x + dx, y + dy));
            averaged(film, pixels.into_iter().flatten())
        };
        let (guides, irradiance) =
            (0..frame.width * frame.height).into_par_iter().with_min_len(1024).map(block).unzip();
        Self { frame, guides: Arc::new(guides), irradiance }
    }

    /// Adds filtered indirect light of half the resolution to the radiance of the pixels.
    pub(super) fn add_to(&self, film: &FilmView, filtered: &[Vec3], radiance: &mut [Vec3]) {
        let (width, pixel) = (film.input.frame.width, film.input.frame.pixel);
        let grid = Grid::new(self.frame.size());
        radiance.par_iter_mut().enumerate().with_min_len(1024).for_each(|(index, radiance)| {
            let guide = &film.guides[index];
            if guide.class != GuideClass::Surface {
                return;
            }
            let (x, y) = (index as i32 % width as i32, index as i32 / width as i32);
            let [right, down] = [2 * (x % 2) - 1, 2 * (y % 2) - 1];
            let (mut sum, mut total) = (Vec3::ZERO, 0.0);
            for (dx, dy, weight) in [(0, 0, 9.0), (right, 0, 3.0), (0, down, 3.0), (right, down, 1.0)] {
                let Some(there) = grid.index(x / 2 + dx, y / 2 + dy) else { continue };
                let weight = weight * similarity(guide, &self.guides[there], pixel);
                (sum, total) = (sum + filtered[there] * weight, total + weight);
            }
            let is_found = total > MIN_INTERPOLATION_WEIGHT;
            *radiance += if is_found { sum / total * guide.divisor() } else { guide.indirect };
        });
    }
}

/// Weight of a pixel of half the resolution for one of the full resolution, whose sides are `pixel` at distance one.
fn similarity(guide: &Guide, half: &Guide, pixel: f32) -> f32 {
    let is_same = half.object == guide.object && half.has_medium() == guide.has_medium();
    if half.class != GuideClass::Surface || !is_same {
        return 0.0;
    }
    let apart = half.position - guide.position;
    let along = guide.normal.dot(apart).abs().max(half.normal.dot(apart).abs());
    let plane = 1.0 - along / (INTERPOLATION_REACH * pixel * guide.length);
    let cosine = guide.normal.dot(half.normal).max(0.0);
    let fourth = cosine * cosine * cosine * cosine;
    plane.max(0.0) * fourth * fourth
}

#[cfg(test)]
mod tests {
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
            let mut radiance = vec![Vec3::ZERO; guides.len()];
            half.add_to(&film, &half.irradiance, &mut radiance);
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
