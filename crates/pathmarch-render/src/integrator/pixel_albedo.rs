//! Albedos of pixels of live pictures whose texture is finer than they are.
//!
//! **Idea.** One sample has one colour: a checker near the horizon would have grain in motion, whatever its light. But a
//! texture costs no rays. Where the albedos of neighbouring samples differ, the texture is evaluated at further points of the
//! pixel, in the plane that touches its surface. Light is divided by the albedo of its samples, filtered, and multiplied by
//! the mean of the albedos of all these points. A picture that is larger than its samples has albedos of its own size.
//!
//! **Cost.** 2 to 4 ms of two cores for 320x180 pixels that all have textures, on the CPU, which evaluates eight points at once.
//!
//! **Limits.** Elsewhere the albedo is that of the samples: textures at texture coordinates of meshes, decals, fractals,
//! surfaces in mirrors, behind glass, or in media, and pictures through a lens, which blurs the texture.
//!
//! **Source.** Points of a pixel: the sequence R2, see [`r2_sequence`].

use super::camera::sample_at;
use super::guides::{Guide, GuideClass, NO_LEAF, colours_differ};
use crate::intersect::ray::lanes;
use crate::sampling::r2_sequence;
use crate::sampling::sobol::hash;
use crate::scene::leaf::TEXTURED_IN_SPACE;
use crate::scene::{FrameUniforms, RenderScene, TraceContext};
use crate::shading::textured_point::TexturedPoint;
use crate::wgsl::shared_constants;
use glam::{Vec3, Vec4};
use pathmarch_field::number::{Mask8, Vec3 as FieldVec3};
use pathmarch_scene::textures::MeshAttributes;
use rayon::prelude::*;
use wide::f32x8;

shared_constants! {
    /// Number of further points of a pixel at which its texture is evaluated.
    const ALBEDO_POINTS: u32 = 8;
    /// Largest difference between the albedos of neighbouring samples, in the larger one, without further points.
    const ALBEDO_CONTRAST: f32 = 0.05;
    /// Largest distance of these points, in that of the far end of rays: at the horizon little of a pixel is nearer than that.
    const ALBEDO_REACH: f32 = 100.0;
    /// Number of pixels of a workgroup.
    pub(crate) const ALBEDOS_PER_GROUP: u32 = 64;
}

/// True if a scene has textures that may be finer than pixels.
pub(crate) fn has_fine_textures(scene: &RenderScene) -> bool {
    scene.leaves.iter().any(|leaf| leaf.has(TEXTURED_IN_SPACE))
}

/// Film whose pixels have textures.
pub(crate) struct TexturedFilm<'a> {
    pub(crate) ctx: &'a TraceContext<'a>,
    pub(crate) guides: &'a [Guide],
    /// Number of samples of each pixel.
    pub(crate) samples: u32,
    /// Index of the first sample.
    pub(crate) first_sample: u32,
    /// Size of the picture that shows it, pixels.
    pub(crate) size: [u32; 2],
}

impl TexturedFilm<'_> {
    /// Albedos of the pixels of the picture, with 1 in w where they are not those of the samples; `None` if these are everywhere.
    pub(crate) fn albedos(&self) -> Option<Vec<Vec4>> {
        let TraceContext { scene, frame, config, .. } = *self.ctx;
        if config.media || frame.lens_radius > 0.0 || !has_fine_textures(scene) {
            return None;
        }
        let count = self.guides.len();
        let are_fine: Vec<bool> =
            (0..count).into_par_iter().with_min_len(512).map(|index| self.has_fine_texture(index)).collect();
        let [width, height] = self.size;
        let mut albedos = vec![Vec4::ZERO; (width * height) as usize];
        albedos.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
            let mut last: Option<(usize, Option<TexturedPoint>)> = None;
            for (x, albedo) in row.iter_mut().enumerate() {
                let index = sample_at([x as u32, y as u32], self.size, frame.size());
                if !are_fine[index] {
                    continue;
                }
                if last.as_ref().is_none_or(|(sample, _)| *sample != index) {
                    last = Some((index, self.textured_point(index)));
                }
                if let Some((_, Some(point))) = &last {
                    *albedo = self.mean_albedo(index, point, [x as u32, y as u32]).extend(1.0);
                }
            }
        });
        Some(albedos)
    }

    /// Point of the texture that a sample shows.
    fn textured_point(&self, index: usize) -> Option<TexturedPoint<'_>> {
        let guide = &self.guides[index];
        let hit = (guide.position, guide.normal, MeshAttributes::default());
        TexturedPoint::at(self.ctx, guide.leaf as usize, hit, guide.length)
    }

    /// True if the texture of a pixel may be finer than it is: its sample and one beside it on the same surface differ.
    fn has_fine_texture(&self, index: usize) -> bool {
        let here = &self.guides[index];
        if here.class != GuideClass::Surface || here.is_mixed || here.leaf == NO_LEAF {
            return false;
        }
        if !self.ctx.scene.leaves[here.leaf as usize].has(TEXTURED_IN_SPACE) {
            return false;
        }
        let [width, height] = self.ctx.frame.size();
        let (x, y) = (index as u32 % width, index as u32 / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let mut around = rows.flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| y * width + x));
        around.any(|beside| {
            let there = &self.guides[beside as usize];
            there.leaf == here.leaf && colours_differ(there.albedo, here.albedo, ALBEDO_CONTRAST)
        })
    }

    /// Mean albedo of the samples at a pixel of the picture, which show this point, and of further points of it.
    fn mean_albedo(&self, index: usize, point: &TexturedPoint, [x, y]: [u32; 2]) -> Vec3 {
        let Self { ctx, samples, first_sample, size, .. } = *self;
        let guide = &self.guides[index];
        let start = hash(y * size[0] + x);
        let places: [[f32; 2]; ALBEDO_POINTS as usize] = std::array::from_fn(|k| {
            r2_sequence::point(first_sample.wrapping_mul(ALBEDO_POINTS).wrapping_add(k as u32), [start, hash(start)])
        });
        let place = [0, 1].map(|k| lanes(|lane| places[lane][k]) + f32x8::splat([x, y][k] as f32));
        let (offsets, are_seen) = offsets_to(ctx.frame, size, guide, place);
        let Some(colours) = point.colours_beside(offsets) else { return guide.albedo };
        let sum_of = |channel: f32x8| (are_seen & channel).reduce_add();
        let sum = Vec3::new(sum_of(colours.x), sum_of(colours.y), sum_of(colours.z));
        // Samples of an enlarged picture are those of several pixels.
        let samples = if size == ctx.frame.size() { samples as f32 } else { 0.0 };
        let count = samples + sum_of(f32x8::ONE);
        if count > 0.0 { (guide.albedo * samples + sum) / count } else { guide.albedo }
    }
}

/// Offsets from the position of a guide to those points of the plane that touches its surface which these places of a picture of
/// this size show, in pixels from its top left corner; and the mask of those that are not beyond the horizon.
fn offsets_to(frame: &FrameUniforms, size: [u32; 2], guide: &Guide, [x, y]: [f32x8; 2]) -> (FieldVec3<f32x8>, f32x8) {
    let [position, right, up, forward] = [frame.position, frame.right, frame.up, frame.forward].map(Vec3::from);
    let towards = guide.position - position;
    let across = x * (2.0 / size[0] as f32) - f32x8::ONE;
    let upwards = f32x8::ONE - y * (2.0 / size[1] as f32);
    let vector = |v: Vec3| FieldVec3::<f32x8>::constant(v.into());
    let view = vector(forward) + vector(right) * across + vector(up) * upwards;
    let scale = f32x8::splat(towards.dot(guide.normal)) / view.dot(vector(guide.normal));
    let is_far = (view.length() * scale).simd_ge(f32x8::splat(ALBEDO_REACH * frame.far));
    let are_seen = scale.simd_gt(f32x8::ZERO) & !is_far;
    (FieldVec3::select(Mask8(are_seen), view * scale - vector(towards), FieldVec3::splat(f32x8::ZERO)), are_seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    const SIZE: [u32; 2] = [48, 32];

    /// Input of a ball on a floor, both of this material, with these words in the camera.
    fn input(material: &str, camera: &str) -> RenderInput {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 1 4; target 0 0.6 0; {camera} }}\nsky 1\nmaterial \"m\" {{ {material} }}\n\
             object \"floor\" material=\"m\" {{ plane }}\n\
             object \"ball\" material=\"m\" {{ twist 0.4 {{ sphere 0.6 {{ at 0 0.6 0; rotate 0 20 0 }} }} }}"
        );
        let scene = Scene::parse("test.kdl", &text).unwrap_or_else(|error| panic!("{error:?}"));
        RenderInput::new(&scene, &Settings { size: SIZE, ..Settings::of(&scene) })
    }

    fn guides(input: &RenderInput, sample: u32) -> Vec<Guide> {
        let pixels: Vec<(u32, u32)> = (0..SIZE[0] * SIZE[1]).map(|index| (index % SIZE[0], index / SIZE[0])).collect();
        input.sample_with_guides(&input.context(None), &pixels, sample).1
    }

    fn albedos(input: &RenderInput, guides: &[Guide], size: [u32; 2]) -> Option<Vec<Vec4>> {
        let ctx = &input.context(None);
        TexturedFilm { ctx, guides, samples: 1, first_sample: 0, size }.albedos()
    }

    #[test]
    fn albedos_are_means_over_pixels() {
        for material in [
            "diffuse { checker size=0.15 { colour 0.1; colour 0.8 0.4 0.2 } }",
            "principled { marble size=0.3 { colour 0.9; colour 0.2 } }",
            "metal { brick length=0.3 course=0.1 { colour 0.9; colour 0.3 } }; roughness 0.4",
        ] {
            let input = input(material, "");
            let mut mean = guides(&input, 0);
            (1..256).for_each(|k| mean.iter_mut().zip(guides(&input, k)).for_each(|(mean, one)| mean.add(&one, k)));
            let guides = guides(&input, 0);
            let albedos = albedos(&input, &guides, SIZE).expect("a texture");
            let mut errors = [0.0; 2];
            for (index, mean) in mean.iter().enumerate().filter(|(_, mean)| !mean.is_mixed) {
                let error = |albedo: Vec3| albedo.distance_squared(mean.albedo);
                errors[0] += error(guides[index].albedo);
                errors[1] +=
                    error(if albedos[index].w > 0.0 { albedos[index].truncate() } else { guides[index].albedo });
            }
            println!("{material}: {errors:?}");
            assert!(errors[1] < 0.15 * errors[0], "{material}: {errors:?}");
        }
    }
}
