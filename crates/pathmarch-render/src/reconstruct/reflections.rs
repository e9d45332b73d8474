//! Light that does not move with the surface of its pixel: what facets reflect, accumulated along the motion of its images, and
//! what media in front of the surface scatter, accumulated along its own.
//!
//! **Idea.** A reflection does not move with its surface. What a flat and smooth surface mirrors appears as far behind it
//! as it is in front; this image stands still when the camera moves, and is looked up in the last picture. A curved
//! surface moves the image: towards itself if it is convex, by the equation of spherical mirrors. The distance of what is
//! mirrored is recorded with the path and averaged over the pixels around. What the last picture shows there is limited to
//! what the samples around the pixel make plausible, since rough surfaces, and light that has come a longer way, have no
//! sharp images. The more a surface turns from pixel to pixel, beside the width of its facets' distribution, the less is
//! known where its images were, and the shorter are their histories.
//!
//! Light of media moves as a point at its mean distance from the camera. It is shared among all pixels whose surfaces are equally
//! deep in the medium.
//!
//! **Source.** Images of reflections as points of their own motion: Zimmer et al. 2015, "Path-space Motion Estimation and
//! Decomposition for Robust Animation Filtering". Filters as wide as roughness and the distance of what is mirrored allow:
//! Zhdan 2021, "ReBLUR: A Hierarchical Recurrent Denoiser".
//!
//! **Limits.** Images in moving surfaces start anew after a few samples. Light that is refracted on its way moves in another
//! way than the surface that refracts it, which is taken for the image. What is near in a medium moves faster than what is far,
//! so that histories of its light are short.

use super::changed_light;
use super::means::{Found, Means, PixelMean, Samples};
use super::motion::EarlierPoints;
use super::planes::{Place, Planes, box_sums_of_surfaces, by_eight};
use super::surfaces::{MIN_NORMAL_COSINE, SurfacePlanes, Vectors};
use super::temporal::{History, Positions, camera_moves};
use super::{Changes, luminance};
use crate::integrator::guides::Guide;
use crate::integrator::medium_light::{MEDIUM_ALPHA, MEDIUM_REACH, distance_in_medium};
use crate::intersect::ray::lanes;
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use wide::f32x8;

shared_constants! {
    /// Half the side of the square over which the light of facets and the distance of what is mirrored are averaged, pixels.
    const IMAGE_RADIUS: i32 = 5;
    /// Standard deviations of single samples by which a mean may differ from that of the square: four standard errors.
    const IMAGE_REACH: f32 = 0.4;
    /// Largest distance of points that share the light of facets, in distances of what is mirrored times alpha.
    const LOBE_REACH: f32 = 0.5;
    /// Least factor between the depth of an image in a flat surface and that in a curved one.
    const MIN_MAGNIFICATION: f32 = 0.2;
    /// Largest share of the depth of an image in its distance from the camera.
    const MAX_IMAGE_DEPTH: f32 = 0.9999;
    /// Depth of images in surfaces that are not smooth.
    const NO_IMAGE: f32 = -3e38;
    /// Weight of pixels without light of facets, W/(m² sr).
    const DARK_WEIGHT: f32 = 1e-6;
    /// Turn of normals from pixel to pixel below which a surface is flat, radians.
    const MIN_TURN: f32 = 1e-9;
    /// Longest history of light of media while the camera moves, samples: what is far and what is near move differently.
    const MAX_MEDIUM_HISTORY: f32 = 3.0;
    /// Longest history of light of facets whose image the last picture does not show, while the camera moves, samples.
    const MAX_IMAGELESS_HISTORY: f32 = 3.0;
}

/// Images of what the facets of all pixels mirror, or of media.
pub(super) struct Images(Planes<5>);

/// Images of eight pixels; 0 where there are none.
pub(super) struct Image {
    /// Distance of the image behind the surface, metres, below 0 for media in front of it; [`NO_IMAGE`] if the surface is not
    /// smooth.
    depth: f32x8,
    /// Largest distance of points of the surface that share their light, metres; the [depth of the surface](depth_of_surface)
    /// in the medium in front of it.
    pub(super) reach: f32x8,
    /// Least and largest plausible luminance, divided as the light is filtered.
    limits: [f32x8; 2],
    /// Longest history while the camera moves, samples.
    max_history: f32x8,
}

impl Images {
    #[inline(always)]
    pub(super) fn at(&self, place: Place) -> Image {
        let [depth, reach, least, most, max_history] = self.0.lanes(place);
        Image { depth, reach, limits: [least, most], max_history }
    }

    /// Images of all pixels, whose facets or media have this light, divided as it is filtered.
    pub(super) fn new(
        frame: &FrameUniforms,
        (guides, surfaces): (&[Guide], &SurfacePlanes),
        reflected: &[Vec3],
    ) -> Self {
        let values = |index: usize| {
            let guide = &guides[index];
            let light = luminance(reflected[index]);
            if !guide.has_layer() {
                return [0.0; 5];
            }
            let weight = luminance(guide.reflected.radiance) + DARK_WEIGHT;
            [light, light * light, weight, weight * guide.reflected.depth, 1.0]
        };
        let layer = |index: usize| layer_of(&guides[index]);
        let around = box_sums_of_surfaces(frame.size(), IMAGE_RADIUS, MIN_NORMAL_COSINE, layer, values);
        Self(Planes::of_eight(surfaces.grid, |place| {
            let alpha = surfaces.alpha(place);
            if alpha.simd_le(f32x8::ZERO).all() {
                return [f32x8::ZERO; 5];
            }
            let [light, squares, weight, weighted_depth, count] = around.lanes(place);
            let depth = (weighted_depth / weight).fast_min(f32x8::splat(MAX_IMAGE_DEPTH));
            let [least, most] = plausible_range([light, squares, count], IMAGE_REACH);
            let length = surfaces.length(place);
            let in_medium = distance_in_medium(depth, frame.far);
            let distance = length * depth / (f32x8::ONE - depth);
            let Curvatures { mean, turn, are_smooth } = Curvatures::new(surfaces, place);
            let bent = f32x8::ONE + mean * distance * 2.0;
            let facets = [
                are_smooth.select(distance / bent.fast_max(f32x8::splat(MIN_MAGNIFICATION)), f32x8::splat(NO_IMAGE)),
                alpha * distance * LOBE_REACH,
                are_smooth & least,
                are_smooth.select(most, f32x8::splat(f32::MAX)),
                are_smooth.select(alpha / (turn * length * frame.pixel + MIN_TURN), f32x8::splat(f32::MAX)),
            ];
            let max_history = f32x8::splat(MAX_MEDIUM_HISTORY);
            let media = [in_medium - length, depth_of_surface(length, in_medium), least, most, max_history];
            let (have_layer, are_media) = (alpha.simd_gt(f32x8::ZERO), are_media(alpha));
            std::array::from_fn(|k| have_layer & are_media.select(media[k], facets[k]))
        }))
    }
}

/// Least and largest luminances of means beside these sums over samples: luminance, its square, and 1. `reach` is in standard
/// deviations of single samples.
#[inline(always)]
fn plausible_range([light, squares, count]: [f32x8; 3], reach: f32) -> [f32x8; 2] {
    let (mean, square) = (light / count, squares / count);
    let reach = (square - mean * mean).fast_max(f32x8::ZERO).sqrt() * reach;
    [(mean - reach).fast_max(f32x8::ZERO), mean + reach]
}

/// Mask of the pixels behind media, from the alphas of their layers.
#[inline(always)]
pub(super) fn are_media(alpha: f32x8) -> f32x8 {
    alpha.simd_eq(f32x8::splat(MEDIUM_ALPHA))
}

/// Number and normal that pixels have in common if their layers are parts of one: that of an object's side, or of media.
fn layer_of(guide: &Guide) -> (f32, Vec3) {
    if guide.has_medium() { (-1.0, Vec3::Z) } else { (guide.object as f32, guide.normal) }
}

/// Depths of surfaces at distances from the camera in media whose light has these mean distances: 0 at the camera, 1/2 where
/// most light is, 1 at infinity.
#[inline(always)]
fn depth_of_surface(length: f32x8, distance: f32x8) -> f32x8 {
    length / (length + distance.fast_max(f32x8::splat(f32::MIN_POSITIVE)))
}

/// Curvatures of the surfaces of eight pixels.
struct Curvatures {
    /// Mean curvatures, above 0 if the surface is convex, per metre.
    mean: f32x8,
    /// By how much the normals turn, per metre.
    turn: f32x8,
    /// Mask of smooth surfaces; others have none.
    are_smooth: f32x8,
}

impl Curvatures {
    #[inline(always)]
    fn new(surfaces: &SurfacePlanes, place: Place) -> Self {
        let (position, normal) = (surfaces.position(place), surfaces.normal(place));
        let (mut mean, mut turn, mut count) = (f32x8::ZERO, f32x8::ZERO, f32x8::ZERO);
        let are_smooth = surfaces.smooth_neighbours(place, |there, counts| {
            let (apart, turned) = (surfaces.position(there) - position, surfaces.normal(there) - normal);
            let square = apart.dot(apart).fast_max(f32x8::splat(f32::MIN_POSITIVE));
            mean += counts & (turned.dot(apart) / square);
            turn += counts & (turned.dot(turned) / square).sqrt();
            count += counts & f32x8::ONE;
        });
        let share = f32x8::ONE / count.fast_max(f32x8::ONE);
        Self { mean: mean * share, turn: turn * share, are_smooth }
    }
}

/// Present picture whose light of facets and media is accumulated.
pub(super) struct Present<'a> {
    pub(super) history: &'a History,
    pub(super) surfaces: &'a SurfacePlanes,
    pub(super) images: &'a Images,
    pub(super) new: Samples<'a>,
}

/// Last picture, the means of its light of facets and media, and where the points of the present one were.
#[derive(Clone, Copy)]
pub(super) struct Past<'a> {
    pub(super) history: &'a History,
    pub(super) means: &'a [PixelMean],
    pub(super) earlier: &'a EarlierPoints,
}

impl Present<'_> {
    /// Joins new samples of the light of facets or media with the past, if the last picture showed any.
    pub(super) fn accumulated(&self, past: Option<Past>, changes: &Changes) -> Vec<PixelMean> {
        let moves = past.is_some_and(|past| camera_moves(&past.history.frame, &self.history.frame));
        let past = past.filter(|_| changes.max_history > 0.0);
        let grid = self.surfaces.grid;
        let square = |index: usize, _| self.history.guides[index].reflected.square;
        let alone = |place: Place| Means::alone(&self.new, place.indices(grid), square);
        let find = |place: Place| {
            let alpha = self.surfaces.alpha(place);
            let have_layer = alpha.simd_gt(f32x8::ZERO);
            let Some(past) = past.filter(|_| have_layer.any()) else { return Found::NONE };
            let (image, are_media) = (self.images.at(place), are_media(alpha));
            let mut found = Found::NONE;
            if are_media.any() {
                found = self.in_media(past, place, &image, are_media);
            }
            let are_facets = have_layer & !are_media;
            if are_facets.any() {
                found = found.or(self.in_facets(past, place, &image, are_facets, moves));
            }
            let longest = f32x8::splat(changes.max_history);
            let [least, most] = image.limits;
            // What media scatter has no limits.
            let limits = || [are_facets & least, are_facets.select(most, f32x8::splat(f32::MAX))];
            let max_length = if moves { longest.fast_min(image.max_history) } else { longest };
            found.limited(moves.then(limits), max_length)
        };
        match changes.scene {
            true => changed_light::joined(self.surfaces, self.new.irradiance, find, alone),
            false => by_eight(grid, |place| find(place).joined(alone(place)).each()),
        }
    }

    /// See [`History::offset_to_middle`].
    #[inline(always)]
    fn offset_to_middle(&self, past: Past, place: Place) -> [f32x8; 2] {
        past.history.offset_to_middle(&self.history.projection, place, self.surfaces.position(place))
    }

    /// Positions in the last picture of the images of eight pixels.
    #[inline(always)]
    fn positions(&self, past: Past, place: Place, image: &Image, mask: f32x8) -> Positions {
        let position = self.surfaces.position(place);
        let ray = position - Vectors::constant(self.history.frame.position);
        let mut positions = past.history.projection.project_all(position + ray.normalized() * image.depth);
        positions.mask &= mask;
        positions.moved(self.offset_to_middle(past, place))
    }

    /// Means of the past of the light of media at the pixels of a mask.
    fn in_media(&self, past: Past, place: Place, image: &Image, mask: f32x8) -> Found {
        let distance = image.depth + self.surfaces.length(place);
        past.history.means_at(&self.positions(past, place, image, mask), past.means, |tap| {
            let there = |lane: usize| &past.history.guides[tap.indices[lane]];
            let are_media = lanes(|lane| f32::from(there(lane).has_medium())).simd_gt(f32x8::ZERO);
            let depth = depth_of_surface(lanes(|lane| there(lane).length), distance);
            are_media & (depth - image.reach).abs().simd_lt(f32x8::splat(MEDIUM_REACH))
        })
    }

    /// Means of the past of the light of facets at the pixels of a mask.
    fn in_facets(&self, past: Past, place: Place, image: &Image, mask: f32x8, moves: bool) -> Found {
        let Past { history, means, earlier } = past;
        let indices = place.indices(self.surfaces.grid);
        let sought = history.sought(&self.surfaces.points(place), earlier, indices, &self.history.frame);
        let mut found = Found::NONE;
        if moves {
            // In a surface that moves, the image moves as well.
            let still = self.surfaces.position(place);
            let [x, y, z] = [(still.x, sought.position.x), (still.y, sought.position.y), (still.z, sought.position.z)]
                .map(|(a, b)| a.simd_eq(b));
            let have_image = mask & x & y & z & image.depth.simd_gt(f32x8::splat(NO_IMAGE));
            let positions = self.positions(past, place, image, have_image);
            found = history.means_at(&positions, means, |tap| history.show_reflectors(tap, &sought));
        }
        if (mask & !found.mask).any() {
            let mut of_point = history.find(&sought, self.offset_to_middle(past, place), means);
            if moves {
                of_point.means.length = of_point.means.length.fast_min(f32x8::splat(MAX_IMAGELESS_HISTORY));
            }
            of_point.mask &= mask;
            found = found.or(of_point);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    /// Image of a pixel, see [`Image`].
    struct PixelImage {
        depth: f32,
        reach: f32,
        limits: [f32; 2],
        max_history: f32,
    }

    /// Input of a picture of 24x24 pixels of a scene.
    fn input_of(text: &str) -> RenderInput {
        let scene = Scene::parse("test.kdl", text).expect("a scene");
        RenderInput::new(&scene, &Settings { size: [24, 24], ..Settings::of(&scene) })
    }

    /// Radiances and guides of all pixels of this sample.
    fn sample(input: &RenderInput, number: u32) -> (Vec<Vec3>, Vec<Guide>) {
        let pixels: Vec<(u32, u32)> = (0..576).map(|index| (index % 24, index / 24)).collect();
        input.sample_with_guides(&input.context(None), &pixels, number)
    }

    /// Guides of the middle of a picture that shows an object of metal, which mirrors what is 3 m away, and their images.
    fn images_in(object: &str) -> (Vec<Guide>, Vec<PixelImage>) {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 10 }}\nsky 1\n\
             material \"metal\" {{ metal 0.5; roughness 0.2 }}\nobject \"mirror\" material=\"metal\" {{ {object} }}"
        );
        let input = input_of(&text);
        let (_, mut guides) = sample(&input, 0);
        for guide in &mut guides {
            guide.reflected.depth = 3.0 / (3.0 + guide.length);
        }
        let surfaces = SurfacePlanes::new(&input.frame, &guides, false);
        let images = Images::new(&input.frame, (&guides, &surfaces), &vec![Vec3::ONE; 576]);
        let image = |index: usize| {
            let [depth, reach, least, most, max_history] =
                images.0.lanes(Place::new(index % 24, index as i32 / 24)).map(|lanes| lanes.to_array()[0]);
            PixelImage { depth, reach, limits: [least, most], max_history }
        };
        (guides, (0..576).map(image).collect())
    }

    #[test]
    fn images_in_flat_mirrors_are_as_far_behind_them() {
        let (guides, images) = images_in("rect 4 { normal 0 0 1 }");
        for (guide, image) in guides.iter().zip(&images) {
            assert!(guide.has_facets() && (image.depth - 3.0).abs() < 0.02, "{}", image.depth);
            // Alpha is the square of the roughness.
            assert!((image.reach - LOBE_REACH * 0.04 * 3.0).abs() < 1e-3, "{}", image.reach);
        }
    }

    #[test]
    fn images_in_convex_mirrors_are_nearer() {
        let (_, images) = images_in("sphere 1");
        // Equation of spherical mirrors with a radius of 1 m: 1/3 + 2/1 = 1/depth.
        let middle = images[12 * 24 + 12].depth;
        assert!((middle - 3.0 / 7.0).abs() < 0.02, "{middle}");
    }

    #[test]
    fn images_in_curved_mirrors_are_soon_forgotten() {
        let [flat, curved] =
            ["rect 4 { normal 0 0 1 }", "sphere 1"].map(|object| images_in(object).1[12 * 24 + 12].max_history);
        assert!(flat > 1e3, "{flat}");
        // Alpha over the angle between the normals of neighbours, 4 m from the camera, whose pixels have these sides.
        let side = 4.0 * 2.0 * 5.0_f32.to_radians().tan() / 24.0;
        assert!((curved / (0.04 / side) - 1.0).abs() < 0.1, "{curved} for {}", 0.04 / side);
    }

    #[test]
    fn what_has_no_facets_does_not_limit_their_light() {
        let (guides, images) = images_in("rect 0.2 { normal 0 0 1 }");
        let of_mirror =
            guides.iter().zip(&images).filter(|(guide, image)| guide.has_facets() && image.depth != NO_IMAGE);
        let limits: Vec<[f32; 2]> = of_mirror.map(|(_, image)| image.limits).collect();
        assert!(limits.len() > 9 && limits.len() < 100, "{}", limits.len());
        assert!(limits.iter().flatten().all(|limit| (limit - 1.0).abs() < 1e-3), "{limits:?}");
    }

    #[test]
    fn light_of_rarely_chosen_facets_is_shared_farther() {
        // From above, a coat reflects 0.04 of the light, and so does the base below it.
        for (material, range) in [
            ("metal 0.5; roughness 0.1", 0.009..0.011),
            ("principled 0.5; roughness 0.1; metallic 1", 0.009..0.011),
            ("principled 0.5; roughness 0.4; coat 1; coat-roughness 0.05", 0.06..0.09),
            ("principled 0.01; roughness 0.4; coat 1; coat-roughness 0.05", 0.004..0.02),
        ] {
            let text = format!(
                "pathmarch 1\ncamera {{ position 0 4 0.1; target 0 0 0; fov 20 }}\nsky 1\n\
                 material \"floor\" {{ {material} }}\nobject \"floor\" material=\"floor\" {{ plane }}"
            );
            let (_, guides) = sample(&input_of(&text), 0);
            let alphas: f32 = guides.iter().map(|guide| guide.reflected.alpha).sum();
            assert!(range.contains(&(alphas / 576.0)), "{material}: {}", alphas / 576.0);
        }
    }

    #[test]
    fn light_of_facets_is_split_from_that_of_the_base() {
        let text = "pathmarch 1\ncamera { position 0 4 0.1; target 0 0 0; fov 20 }\nsky 1\n\
            material \"varnish\" { principled 0.5; roughness 0.1 }\nmaterial \"chalk\" { diffuse 0.5 }\n\
            object \"floor\" material=\"MATERIAL\" { plane }";
        for (material, range) in [("varnish", 0.06..0.1), ("chalk", -1e-9..1e-9)] {
            let input = input_of(&text.replace("MATERIAL", material));
            let mut share = 0.0;
            for number in 0..16 {
                let (radiance, guides) = sample(&input, number);
                let reflected: Vec3 = guides.iter().map(|guide| guide.reflected.radiance).sum();
                share += luminance(reflected) / luminance(radiance.iter().sum::<Vec3>()) / 16.0;
            }
            // From above, 0.04 is reflected, and half of the rest is scattered.
            assert!(range.contains(&share), "{material}: {share}");
        }
    }
}
