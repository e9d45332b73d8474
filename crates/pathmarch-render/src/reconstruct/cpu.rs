//! Reconstruction on the CPU.
//!
//! **Cost.** 0.2 to 1.6 of the time in which one sample is traced.

use super::antialiasing::{Last, ShownPicture, Textures, antialiased, new_weight};
use super::emitters::EmitterLayer;
use super::film_view::FilmView;
use super::indirect::HalfFilm;
use super::means::{PixelMean, Samples};
use super::motion::{EarlierPoints, Motion};
use super::planes::{Grid, box_sums};
use super::reflections::Images;
use super::spatial::{DIRECT_REACH, Filtered, SMOOTH_REACH};
use super::surfaces::{SurfacePlanes, Vectors};
use super::temporal::History;
use super::{
    BIAS_RADIUS, Buffer, Changes, FULL_MOTION, MAX_HISTORY, OWN_VARIANCE, PassTime, PixelHistory, ReconstructOptions,
    direct_irradiance, film_variance, fireflies, luminance, motions, reflections, settled_weight, settles, spatial,
};
use crate::integrator::guides::Guide;
use crate::integrator::pixel_albedo::TexturedFilm;
use crate::scene::{FrameUniforms, RenderScene};
use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;
use std::sync::Arc;
use web_time::Instant;
use wide::f32x8;

/// Result of a film.
struct Reconstructed {
    scene: Arc<RenderScene>,
    history: History,
    /// Means of the indirect light, at half the resolution, if there was any.
    indirect: Option<History>,
    /// Means of the light of facets; empty if there are none.
    reflections: Vec<PixelMean>,
    shown: ShownPicture,
}

/// State between the pictures of a sequence.
#[derive(Default)]
pub(super) struct CpuReconstruction {
    /// Result before the present film.
    past: Option<Reconstructed>,
    /// Result of the present film.
    present: Option<Reconstructed>,
    changes: Changes,
    /// Passes of the last picture.
    pub(super) passes: Vec<PassTime>,
}

/// Clock that times passes.
struct PassClock {
    last: Instant,
    passes: Vec<PassTime>,
}

impl Default for PassClock {
    fn default() -> Self {
        Self { last: Instant::now(), passes: Vec::new() }
    }
}

impl PassClock {
    /// Records the pass of this name, which ends now.
    fn ends(&mut self, name: &'static str) {
        let seconds = self.last.elapsed().as_secs_f64();
        self.last = Instant::now();
        self.passes.push(PassTime { name, seconds });
    }
}

impl CpuReconstruction {
    /// Starts another film: of another view, size or moment, or of a changed scene.
    pub(super) fn start_film(&mut self, scene_changed: bool) {
        let present = self.present.take();
        self.changes.start_film(present.is_some(), scene_changed);
        self.past = present.or(self.past.take());
    }

    /// Linear picture of a film, of this size.
    pub(super) fn picture(&mut self, film: &FilmView, size: [u32; 2], options: &ReconstructOptions) -> Vec<Vec3> {
        let &FilmView { input, guides, means, samples, first_sample, weight } = film;
        let (scene, frame) = (&input.scene, &input.frame);
        let mut clock = PassClock::default();
        let surfaces = &SurfacePlanes::new(frame, guides, settles(samples));
        clock.ends("surfaces");
        let divided = means.par_iter().zip(guides.par_iter()).map(|(mean, guide)| direct_irradiance(*mean, guide));
        let mut irradiance: Vec<Vec3> = divided.collect();
        let has_layers = surfaces.have_layers();
        let of_layer = |guide: &Guide| guide.reflected.radiance / guide.reflection_divisor();
        let mut reflected: Vec<Vec3> =
            if has_layers { guides.par_iter().with_min_len(4096).map(of_layer).collect() } else { Vec::new() };
        clock.ends("division by the albedo");
        if options.firefly_filter {
            for light in [&mut irradiance, &mut reflected].into_iter().filter(|light| !light.is_empty()) {
                fireflies::spread_fireflies(surfaces, samples as f32, light);
            }
            clock.ends("fireflies");
        }
        let past = self.past.as_ref();
        let changed_past = past.filter(|_| self.changes.scene);
        let motion = changed_past.map_or_else(Motion::default, |past| Motion::new(&past.scene, scene));
        let earlier = motion.earlier_points(guides, frame.pixel);
        let max_history = self.changes.max_history * (1.0 - weight);
        let continued = |frame: &FrameUniforms,
                         shown: (&Arc<Vec<Guide>>, &SurfacePlanes),
                         irradiance: &[Vec3],
                         past: Option<(&History, &EarlierPoints)>| {
            let past = past.filter(|_| options.reprojection);
            let new = Samples { irradiance, count: samples as f32 };
            History::new(frame, shown, new, past, max_history, self.changes.scene)
        };
        let history = continued(frame, (guides, surfaces), &irradiance, past.map(|past| (&past.history, &earlier)));
        clock.ends("reprojection");
        let past_indirect = past.and_then(|past| past.indirect.as_ref());
        // Some scenes, such as a fractal alone, never have any.
        let indirect = (surfaces.have_indirect_light || past_indirect.is_some()).then(|| {
            let mut half = HalfFilm::new(film);
            if options.firefly_filter {
                fireflies::spread_fireflies(&half.surfaces, samples as f32, &mut half.irradiance);
            }
            let earlier = motion.earlier_points(&half.guides, half.frame.pixel);
            let past = past_indirect.map(|past| (past, &earlier));
            let history = continued(&half.frame, (&half.guides, &half.surfaces), &half.irradiance, past);
            let clean = match options.spatial_filter {
                true => spatial::filter(&history, &half.surfaces, None, SMOOTH_REACH),
                false => Filtered::unfiltered(half.surfaces.grid, &history.means, None),
            };
            (half, history, clean)
        });
        clock.ends("indirect light");
        let images = has_layers.then(|| Images::new(frame, (guides, surfaces), &reflected));
        let past_reflections = past.filter(|past| options.reprojection && !past.reflections.is_empty());
        let past_reflections = past_reflections.map(|past| reflections::Past {
            history: &past.history,
            means: &past.reflections,
            earlier: &earlier,
        });
        let changes = Changes { max_history, ..self.changes };
        let reflections = images.as_ref().map_or_else(Vec::new, |images| {
            let new = Samples { irradiance: &reflected, count: samples as f32 };
            let present = reflections::Present { history: &history, surfaces, images, new };
            present.accumulated(past_reflections, &changes)
        });
        clock.ends("reflections");
        let facets = images.as_ref().map(|images| (reflections.as_slice(), images));
        let filtered = match options.spatial_filter {
            true => spatial::filter(&history, surfaces, facets, DIRECT_REACH),
            false => Filtered::unfiltered(surfaces.grid, &history.means, facets.map(|(means, _)| means)),
        };
        let indirect_light = |place| match &indirect {
            Some((half, _, clean)) => half.interpolated(surfaces, place, clean),
            None => (Vectors::splat(f32x8::ZERO), f32x8::ZERO),
        };
        clock.ends("spatial filter");
        let textured = TexturedFilm { ctx: &input.context(None), guides, samples, first_sample, size };
        let albedos = options.texture_filter.then(|| textured.albedos()).flatten();
        clock.ends("albedos of pixels");
        let light = albedos.as_ref().map(|_| filtered.light(surfaces.grid, guides, indirect_light, |light| light));
        let clean: Vec<Vec3> = match &light {
            Some(light) => light.par_iter().with_min_len(4096).map(|light| light.radiance).collect(),
            None => filtered.light(surfaces.grid, guides, indirect_light, |light| light.radiance),
        };
        let textures = albedos.as_ref().zip(light.as_ref()).map(|(albedos, light)| Textures { albedos, light });
        clock.ends("multiplication by the albedo");
        let emitters =
            options.emitter_edges.then(|| EmitterLayer::new(&input.context(None), guides, size, first_sample));
        let emitters = emitters.flatten();
        let clean = match &emitters {
            Some(emitters) => emitters.without_emitters(&clean),
            None => clean,
        };
        clock.ends("emitters");
        let last = past.filter(|_| options.antialiasing);
        let last = last.map(|past| Last {
            picture: &past.shown,
            history: &past.history,
            earlier: &earlier,
            new_weight: new_weight(samples, self.changes.scene),
            scene_has_changed: self.changes.scene,
        });
        let shown = antialiased((&history, surfaces), (&clean, textures), size, last, emitters.is_some());
        clock.ends("anti-aliasing");
        let rest = shown.colours.par_iter().enumerate().map(|(index, colour)| (index, colour.xyz()));
        let picture: Vec<Vec3> = match &emitters {
            Some(emitters) => rest.map(|(index, colour)| emitters.over(film, index, colour)).collect(),
            None => rest.map(|(_, colour)| colour).collect(),
        };
        let picture = match settles(samples) && frame.size() == size {
            true => mixed_with_film(film, &picture, emitters.as_ref()),
            false => picture,
        };
        clock.ends("mix with the film");
        self.passes = clock.passes;
        let indirect = indirect.map(|(_, history, _)| history);
        self.present = Some(Reconstructed { scene: scene.clone(), history, indirect, reflections, shown });
        picture
    }

    /// Histories of all pixels of the last picture.
    pub(super) fn histories(&self) -> Vec<PixelHistory> {
        let Some(Reconstructed { history, .. }) = &self.present else { return Vec::new() };
        history.means.iter().map(PixelMean::history).collect()
    }

    /// Motion of each pixel, see [`motions`](super::motions).
    fn motion(&self) -> Vec<[f32; 3]> {
        let size = |film: &Option<Reconstructed>| film.as_ref().map(|film| film.history.frame.size());
        let present = size(&self.present).unwrap_or_default();
        motions(&self.histories(), present, size(&self.past).unwrap_or(present))
    }

    /// Buffer of the last picture as sRGB codes at this size: red, green, blue and 255 for each pixel; `None` for the picture
    /// itself, and without one.
    pub(super) fn buffer(&self, buffer: Buffer, size: [u32; 2]) -> Option<Vec<u8>> {
        let history = &self.present.as_ref()?.history;
        let codes: Vec<[f32; 3]> = match buffer {
            Buffer::Picture => return None,
            Buffer::Motion => self.motion().into_iter().map(motion_code).collect(),
            Buffer::HistoryLength => history.means.iter().map(|mean| [mean.length / MAX_HISTORY; 3]).collect(),
            Buffer::Deviation => history.means.iter().map(deviation_code).collect(),
        };
        let [width, height] = history.frame.size();
        let code = |index: u32| {
            let [x, y] = [index % size[0] * width / size[0], index / size[0] * height / size[1]];
            let [r, g, b] = codes[(y * width + x) as usize].map(|code| (255.0 * code.clamp(0.0, 1.0)).round() as u8);
            [r, g, b, 255]
        };
        Some((0..size[0] * size[1]).flat_map(code).collect())
    }
}

/// Squared difference between a picture and the means of its film in luminance of the irradiance, the variance of these means,
/// and 1.
fn film_difference(film: &FilmView, picture: &[Vec3], index: usize) -> [f32; 3] {
    let guide = &film.guides[index];
    let irradiance = luminance(film.means[index] / guide.divisor());
    let difference = irradiance - luminance(picture[index] / guide.divisor());
    [difference * difference, film_variance(guide, irradiance, film.samples as f32), 1.0]
}

/// Weight of the film in a pixel of a variance from these sums around it: what the noise of the film does not explain is an error of
/// the picture (James and Stein 1961).
fn unbiased_weight([square, variance, count]: [f32; 3], own_variance: f32) -> f32 {
    // A speck is its own noise, whatever is around it.
    let variance = f32::max(variance, OWN_VARIANCE * count * own_variance);
    (1.0 - variance / f32::max(square, 1e-12)).max(0.0)
}

/// Mixes a picture with the means of its film, each pixel by the noise of the film and the error of the picture. Discs of emitters
/// out of focus have less noise than the film.
fn mixed_with_film(film: &FilmView, picture: &[Vec3], emitters: Option<&EmitterLayer>) -> Vec<Vec3> {
    let size = film.input.frame.size();
    let differences = box_sums(size, BIAS_RADIUS, |index| film_difference(film, picture, index));
    let mixed = |index: usize| {
        let (mean, guide) = (film.means[index], &film.guides[index]);
        let irradiance = luminance(mean / guide.divisor());
        let variance = film_variance(guide, irradiance, film.samples as f32);
        let settled = settled_weight(guide, [irradiance, variance], film.samples as f32);
        let settled = match guide.is_mixed {
            _ if emitters.is_some_and(|emitters| emitters.is_out_of_focus(index)) => 0.0,
            true => settled,
            false => settled.max(unbiased_weight(differences.at(index), variance)),
        };
        // Pixels of several surfaces are not filtered; their noise ends where no colour around them is.
        let settling = if guide.is_mixed { limited(picture, size, index, mean) } else { mean };
        picture[index].lerp(settling, settled).lerp(mean, film.weight)
    };
    (0..film.means.len()).into_par_iter().with_min_len(4096).map(mixed).collect()
}

/// A colour, limited to the range of those of a picture at a pixel and next to it.
fn limited(picture: &[Vec3], size: [u32; 2], index: usize, colour: Vec3) -> Vec3 {
    let grid = Grid::new(size);
    let (x, y) = (index as i32 % grid.width, index as i32 / grid.width);
    let here = (picture[index], picture[index]);
    let (least, most) =
        grid.around(x, y).fold(here, |(least, most), there| (least.min(picture[there]), most.max(picture[there])));
    colour.clamp(least, most)
}

/// Colour of a motion as [`motions`] gives it: red rightwards, green downwards, blue where it is unknown.
fn motion_code([dx, dy, is_known]: [f32; 3]) -> [f32; 3] {
    if is_known == 0.0 { [0.0, 0.0, 1.0] } else { [0.5 - 0.5 * dx / FULL_MOTION, 0.5 - 0.5 * dy / FULL_MOTION, 0.0] }
}

/// Standard deviation of a mean, divided by the mean.
fn deviation_code(&PixelMean { moments: [mean, square], length, .. }: &PixelMean) -> [f32; 3] {
    let variance = (square - mean * mean).max(0.0) / length;
    [variance.sqrt() / mean.max(1e-6); 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    /// Pictures of a film whose sample of pixel 528 is this, and then is 1 as all others.
    fn pictures_after(speck: Vec3) -> Vec<Vec<Vec3>> {
        let text =
            "pathmarch 1\ncamera { position 0 0 3; target 0 0 0 }\nsky 1\nobject \"wall\" { rect 9 { normal 0 0 1 } }";
        let scene = Scene::parse("test.kdl", text).expect("a scene");
        let input = RenderInput::new(&scene, &Settings { size: [32, 32], ..Settings::of(&scene) });
        let pixels: Vec<(u32, u32)> = (0..1024).map(|index| (index % 32, index / 32)).collect();
        let guides = Arc::new(input.sample_with_guides(&input.context(None), &pixels, 0).1);
        let mut reconstruction = CpuReconstruction::default();
        let mut picture = |number: u32| {
            let mut means = vec![Vec3::ONE; 1024];
            means[528] = if number == 2 { speck } else { Vec3::ONE };
            reconstruction.start_film(false);
            let (samples, first_sample, weight) = (1, number, 0.0);
            let film = FilmView { input: &input, guides: &guides, means: &means, samples, first_sample, weight };
            reconstruction.picture(&film, [32, 32], &ReconstructOptions::default())
        };
        (0..12).map(&mut picture).collect()
    }

    #[test]
    fn samples_that_are_no_numbers_leave_no_trail() {
        for speck in [f32::NAN, f32::INFINITY, -f32::INFINITY] {
            let pictures = pictures_after(Vec3::new(speck, 1.0, 1.0));
            for picture in &pictures {
                assert!(picture.iter().all(|colour| (*colour - 1.0).abs().max_element() < 0.1), "{speck}");
            }
        }
        // The largest numbers that the film keeps are spread, and stay numbers.
        let pictures = pictures_after(Vec3::splat(1e30));
        assert!(pictures.iter().flatten().all(|colour| colour.is_finite()));
    }

    #[test]
    fn the_film_counts_where_its_noise_does_not_explain_the_difference() {
        let weight = |differences: &[[f32; 2]; 25]| {
            let sum = |k: usize| differences.iter().map(|difference| difference[k]).sum();
            unbiased_weight([sum(0), sum(1), 25.0], differences[12][1])
        };
        // As large as the noise of the film, and ten times as large.
        assert_eq!(weight(&[[0.04, 0.04]; 25]), 0.0);
        assert!((weight(&[[0.4, 0.04]; 25]) - 0.9).abs() < 1e-6);
        // A speck with much noise of its own stays hidden.
        let mut speck = [[0.4, 0.04]; 25];
        speck[12] = [10.0, 40.0];
        assert_eq!(weight(&speck), 0.0);
    }
}
