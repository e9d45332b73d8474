//! Emitters that the camera sees, as a layer of their own in front of the picture.
//!
//! **Idea.** A lamp is hundreds of times brighter than what is beside it. Where its edge is averaged with earlier pictures,
//! it grows by the blur of their interpolation, and its light stays where the lamp has been. But it has no noise, and
//! camera rays alone tell which share of a pixel it covers. So edges of emitters get a few camera rays of their own in
//! every picture, and the rest of the picture is reconstructed without emitters, which are laid over it at the end. Discs of
//! emitters far out of focus are edges all over; there half of the rays [aim](crate::integrator::lens_targets) at them.
//!
//! **Limits.** An emitter of which neighbouring pixels show but one sample is too small to be found in every picture; it
//! stays in the rest. Emitters in mirrors and behind glass are parts of the rest, too.

use super::film_view::FilmView;
use super::planes::Grid;
use crate::integrator::camera::sample_at;
use crate::integrator::emitter_coverage::{
    Coverage, EmitterPlace, FULL_COVERAGE, LEAST_COVERAGE, LEAST_REST, MIN_EMITTER_SAMPLES, coverages, emitter_place,
};
use crate::integrator::guides::Guide;
use crate::integrator::lens_targets::LensTargets;
use crate::scene::{FrameUniforms, TraceContext};
use glam::{Vec3, Vec4Swizzles};
use rayon::prelude::*;

/// Emitters of a picture. It may be larger than its samples.
pub(super) struct EmitterLayer {
    /// Sizes of the picture and of its samples, pixels.
    size: [u32; 2],
    samples: [u32; 2],
    map: EmitterMap,
    /// Places of the samples.
    places: Vec<EmitterPlace>,
    coverages: Vec<Coverage>,
}

/// What each sample of a film shows, in a byte: [`EMITTER`], [`MIXED`], or neither. Few of them show an emitter, and guides are
/// large.
struct EmitterMap {
    grid: Grid,
    shown: Vec<u8>,
    /// Number of samples that show emitters in the square of 3x3 around each.
    around: Vec<u8>,
}

/// The sample shows an emitter.
const EMITTER: u8 = 1;
/// The samples of the pixel show several surfaces.
const MIXED: u8 = 2;

impl EmitterMap {
    /// Map of a film; `None` if it shows no emitters, unless it may show some that are `out_of_focus`.
    fn new(size: [u32; 2], guides: &[Guide], out_of_focus: &LensTargets) -> Option<Self> {
        let of = |guide: &Guide| u8::from(guide.is_seen_emitter()) * EMITTER + u8::from(guide.is_mixed) * MIXED;
        let shown: Vec<u8> = guides.par_iter().with_min_len(4096).map(of).collect();
        let emitters: Vec<u8> = shown.iter().map(|shown| shown & EMITTER).collect();
        if out_of_focus.is_empty() && emitters.iter().all(|emitter| *emitter == 0) {
            return None;
        }
        let width = size[0] as usize;
        let mut beside = emitters.clone();
        for (beside, emitters) in beside.chunks_mut(width).zip(emitters.chunks(width)) {
            add(&mut beside[1..], emitters);
            add(beside, &emitters[1..]);
        }
        let mut around = beside.clone();
        add(&mut around[width..], &beside);
        add(&mut around, &beside[width..]);
        Some(Self { grid: Grid::new(size), shown, around })
    }

    /// Number of samples that show emitters in the square around one.
    fn emitters_around(&self, index: usize) -> u32 {
        self.around[index].into()
    }
}

/// Adds numbers to others, as far as there are both.
fn add(sums: &mut [u8], numbers: &[u8]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
}

/// Pixels of the square of 3x3 around a pixel.
fn square(grid: Grid, index: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (index as i32 % grid.width, index as i32 / grid.width);
    grid.around(x, y).chain([index])
}

impl EmitterLayer {
    /// Emitters that a film may show, in a picture of this size; `None` if there are none.
    pub(super) fn new(ctx: &TraceContext, guides: &[Guide], size: [u32; 2], sample: u32) -> Option<Self> {
        if ctx.config.media {
            return None;
        }
        let (samples, targets) = (ctx.frame.size(), LensTargets::new(ctx));
        let map = EmitterMap::new(samples, guides, &targets)?;
        let place = |index: usize| match map.emitters_around(index) {
            ..MIN_EMITTER_SAMPLES => EmitterPlace::Outside,
            _ => emitter_place(&guides[index], square(map.grid, index).map(|there| &guides[there])),
        };
        let mut places: Vec<EmitterPlace> = (0..guides.len()).into_par_iter().with_min_len(4096).map(place).collect();
        for disc in targets.discs() {
            disc.visit(samples, |index| {
                if places[index] != EmitterPlace::Within {
                    places[index] = EmitterPlace::OutOfFocus;
                }
            });
        }
        let frame = FrameUniforms { width: size[0], height: size[1], ..*ctx.frame };
        let ctx = TraceContext { frame: &frame, ..*ctx };
        let targets = LensTargets::new(&ctx);
        let of_row = |y: u32| {
            let place = |x: u32| places[sample_at([x, y], size, samples)];
            let has_rays = |x: &u32| matches!(place(*x), EmitterPlace::Edge | EmitterPlace::OutOfFocus);
            let edges: Vec<(u32, u32)> = (0..size[0]).filter(has_rays).map(|x| (x, y)).collect();
            let mut at_edges = coverages(&ctx, &targets, &edges, sample).into_iter();
            let coverage = move |x: u32| match place(x) {
                EmitterPlace::Outside => Coverage::ZERO,
                EmitterPlace::Edge => at_edges.next().unwrap_or_default(),
                EmitterPlace::OutOfFocus => {
                    let coverage = at_edges.next().unwrap_or_default();
                    coverage.with_w(-coverage.w.max(LEAST_COVERAGE))
                }
                EmitterPlace::Within => Coverage::W * FULL_COVERAGE,
            };
            (0..size[0]).map(coverage).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<Coverage>> = (0..size[1]).into_par_iter().map(of_row).collect();
        Some(Self { size, samples, map, places, coverages: rows.concat() })
    }

    /// Coverage of the pixel in the middle of a sample's.
    fn coverage_of_sample(&self, index: usize) -> Coverage {
        let sample = [index as u32 % self.samples[0], index as u32 / self.samples[0]];
        let [x, y]: [u32; 2] = std::array::from_fn(|k| {
            let factor = self.size[k] as f32 / self.samples[k] as f32;
            (((sample[k] as f32 + 0.5) * factor) as u32).min(self.size[k] - 1)
        });
        self.coverages[(y * self.size[0] + x) as usize]
    }

    /// Colours of samples without emitters: a pixel that shows one has the mean of those around it that show none.
    pub(super) fn without_emitters(&self, colours: &[Vec3]) -> Vec<Vec3> {
        let EmitterMap { grid, ref shown, .. } = self.map;
        let colour = |index: usize| {
            if shown[index] == 0 || self.places[index] == EmitterPlace::Outside {
                return colours[index];
            }
            let (mut sum, mut count) = (Vec3::ZERO, 0.0);
            for there in square(grid, index).filter(|&there| shown[there] == 0) {
                (sum, count) = (sum + colours[there], count + 1.0);
            }
            if count > 0.0 {
                return sum / count;
            }
            if shown[index] == EMITTER {
                return Vec3::ZERO;
            }
            // Among pixels that all show several surfaces, what is left without the emitters.
            let (mut left, mut rest) = (Vec3::ZERO, 0.0);
            for there in square(grid, index) {
                let coverage = self.coverage_of_sample(there);
                if coverage.w != FULL_COVERAGE {
                    left += colours[there] - coverage.xyz();
                    rest += (1.0 - coverage.w.abs()).max(LEAST_REST);
                }
            }
            left.max(Vec3::ZERO) / f32::max(rest, LEAST_REST)
        };
        (0..colours.len()).into_par_iter().with_min_len(4096).map(colour).collect()
    }

    /// True if an emitter far out of focus may be seen at this pixel.
    pub(super) fn is_out_of_focus(&self, index: usize) -> bool {
        self.coverages[index].w < 0.0
    }

    /// A colour of the rest of the picture at this pixel, with the emitters in front of it.
    pub(super) fn over(&self, film: &FilmView, index: usize, colour: Vec3) -> Vec3 {
        let coverage = self.coverages[index];
        if coverage.w == FULL_COVERAGE {
            let [x, y] = [index as u32 % self.size[0], index as u32 / self.size[0]];
            return film.means[sample_at([x, y], self.size, self.samples)];
        }
        colour * (1.0 - coverage.w.abs()).max(0.0) + coverage.xyz()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::integrator::guides::GuideClass;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;
    use std::sync::Arc;

    /// Input of 64x48 pixels, at a distance of 8 metres 8 pixels a metre, of a lamp of radiance 5 and this radius.
    fn ball(radius: f32) -> RenderInput {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 8; target 0 0 0; fov 41.112 }}\nmaterial \"lamp\" {{ emit 5 }}\n\
             object \"ball\" material=\"lamp\" {{ sphere {radius} {{ at 0.03 0.05 0 }} }}"
        );
        let scene = Scene::parse("test.kdl", &text).expect("valid");
        RenderInput::new(&scene, &Settings { size: [64, 48], ..Settings::of(&scene) })
    }

    fn guides(input: &RenderInput) -> (Vec<Vec3>, Vec<Guide>) {
        let pixels: Vec<(u32, u32)> = (0..64 * 48).map(|index| (index % 64, index / 64)).collect();
        input.sample_with_guides(&input.context(None), &pixels, 0)
    }

    #[test]
    fn a_lamp_covers_its_area_at_every_size() {
        let input = ball(1.5);
        let (means, guides) = guides(&input);
        let radius = 8.0 * 1.5 * 8.0 / (8.0f32.powi(2) - 1.5f32.powi(2)).sqrt();
        let area = std::f32::consts::PI * radius * radius;
        for size in [[64, 48], [96, 80], [128, 96]] {
            let layer = EmitterLayer::new(&input.context(None), &guides, size, 0).expect("a lamp");
            let guides = Arc::new(guides.clone());
            let film =
                FilmView { input: &input, guides: &guides, means: &means, samples: 1, first_sample: 0, weight: 0.0 };
            let light: f32 = (0..layer.coverages.len()).map(|index| layer.over(&film, index, Vec3::ZERO).x).sum();
            let scale = (size[0] * size[1]) as f32 / (64.0 * 48.0);
            assert!((light / (5.0 * scale * area) - 1.0).abs() < 0.01, "{size:?}: {light} for {area}");
            let partly = layer.coverages.iter().filter(|coverage| coverage.w > 0.0 && coverage.w < 1.0).count();
            assert!(partly > 30, "{partly} pixels are covered in part");
        }
    }

    #[test]
    fn a_speck_is_no_part_of_the_layer() {
        let input = ball(0.02);
        let (_, mut guides) = guides(&input);
        assert!(EmitterLayer::new(&input.context(None), &guides, [64, 48], 0).is_none(), "no sample shows it");
        guides[23 * 64 + 32] = Guide { class: GuideClass::Emitter, leaf: 0, ..Guide::NONE };
        let layer = EmitterLayer::new(&input.context(None), &guides, [64, 48], 0).expect("a lamp");
        assert!(layer.coverages.iter().all(|coverage| *coverage == Coverage::ZERO));
        let colours = vec![Vec3::ONE; 64 * 48];
        assert_eq!(layer.without_emitters(&colours), colours);
    }

    #[test]
    fn what_is_beside_a_lamp_takes_its_place() {
        let input = ball(1.5);
        let (colours, guides) = guides(&input);
        let layer = EmitterLayer::new(&input.context(None), &guides, [64, 48], 0).expect("a lamp");
        let colours: Vec<Vec3> =
            colours.iter().map(|colour| if *colour == Vec3::ZERO { Vec3::splat(0.25) } else { *colour }).collect();
        let rest = layer.without_emitters(&colours);
        assert!(rest.iter().all(|colour| *colour == Vec3::splat(0.25) || *colour == Vec3::ZERO));
        assert_eq!(rest[23 * 64 + 32], Vec3::ZERO, "nothing is beside the middle");
        assert!(rest.iter().filter(|colour| **colour == Vec3::ZERO).count() > 300);
    }
}
