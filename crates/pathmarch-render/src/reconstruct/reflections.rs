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

use super::motion::EarlierPoints;
use super::planes::box_sums_of_surfaces;
use super::temporal::{
    Clamp, History, MIN_NORMAL_COSINE, PixelMean, SMOOTH_NEIGHBOURS, Samples, camera_moves, joined, plausible_range,
    smooth_neighbours,
};
use super::{Changes, luminance};
use crate::integrator::guides::Guide;
use crate::integrator::medium_light::{MEDIUM_REACH, distance_in_medium};
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;

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

/// True if some pixel shows facets or media.
pub(super) fn exist(guides: &[Guide]) -> bool {
    guides.iter().any(Guide::has_layer)
}

/// Image of what the facets of a pixel mirror, or of a medium.
#[derive(Clone, Copy, Default)]
pub(super) struct Image {
    /// Distance of the image behind the surface, metres, below 0 for media in front of it; [`NO_IMAGE`] if the surface is not
    /// smooth.
    depth: f32,
    /// Largest distance of points of the surface that share their light, metres; the [depth of the surface](depth_of_surface)
    /// in the medium in front of it.
    pub(super) reach: f32,
    /// Least and largest plausible luminance, divided as the light is filtered.
    limits: [f32; 2],
    /// Longest history while the camera moves, samples.
    max_history: f32,
}

/// Images of all pixels, whose facets or media have this light, divided as it is filtered.
pub(super) fn images(frame: &FrameUniforms, guides: &[Guide], reflected: &[Vec3]) -> Vec<Image> {
    let size = frame.size();
    let values = |index: usize| {
        let guide = &guides[index];
        let light = luminance(reflected[index]);
        if !guide.has_layer() {
            return [0.0; 5];
        }
        let weight = luminance(guide.reflected.radiance) + DARK_WEIGHT;
        [light, light * light, weight, weight * guide.reflected.depth, 1.0]
    };
    let around = box_sums_of_surfaces(size, IMAGE_RADIUS, MIN_NORMAL_COSINE, |index| layer_of(&guides[index]), values);
    let image = |index: usize| {
        let guide = &guides[index];
        if !guide.has_layer() {
            return Image::default();
        }
        let [light, squares, weight, weighted_depth, count] = around.at(index);
        let depth = (weighted_depth / weight).min(MAX_IMAGE_DEPTH);
        let limits = plausible_range([light, squares, count], IMAGE_REACH);
        if guide.has_medium() {
            let distance = distance_in_medium(depth, frame.far);
            let reach = depth_of_surface(guide.length, distance);
            return Image { depth: distance - guide.length, reach, limits, max_history: MAX_MEDIUM_HISTORY };
        }
        let distance = guide.length * depth / (1.0 - depth);
        let lobe_reach = LOBE_REACH * guide.reflected.alpha * distance;
        let Some([curvature, turn]) = curvature(guides, size, index) else {
            return Image { depth: NO_IMAGE, reach: lobe_reach, limits: [0.0, f32::MAX], max_history: f32::MAX };
        };
        let bent = 1.0 + 2.0 * curvature * distance;
        Image {
            depth: distance / bent.max(MIN_MAGNIFICATION),
            reach: lobe_reach,
            limits,
            max_history: guide.reflected.alpha / (turn * frame.pixel * guide.length + MIN_TURN),
        }
    };
    (0..guides.len()).into_par_iter().with_min_len(1024).map(image).collect()
}

/// Number and normal that pixels have in common if their layers are parts of one: that of an object's side, or of media.
fn layer_of(guide: &Guide) -> (f32, Vec3) {
    if guide.has_medium() { (-1.0, Vec3::Z) } else { (guide.object as f32, guide.normal) }
}

/// Depth of a surface at a distance from the camera in a medium whose light has this mean distance: 0 at the camera, 1/2 where
/// most light is, 1 at infinity.
fn depth_of_surface(length: f32, distance: f32) -> f32 {
    length / (length + distance.max(f32::MIN_POSITIVE))
}

/// Mean curvature of a surface at a pixel, above 0 if it is convex, and by how much its normal turns, both per metre. `None` if
/// the surface is not smooth.
fn curvature(guides: &[Guide], size: [u32; 2], index: usize) -> Option<[f32; 2]> {
    let guide = &guides[index];
    let (mut curvature, mut turn, mut count) = (0.0, 0.0, 0);
    for there in smooth_neighbours(guides, size, index) {
        let (apart, turned) = (there.position - guide.position, there.normal - guide.normal);
        let square = apart.length_squared().max(f32::MIN_POSITIVE);
        curvature += turned.dot(apart) / square;
        turn += (turned.length_squared() / square).sqrt();
        count += 1;
    }
    (count >= SMOOTH_NEIGHBOURS).then(|| [curvature, turn].map(|sum| sum / count as f32))
}

/// Joins new samples of the light of facets or media with the past, if the last picture showed any.
pub(super) fn accumulated(
    frame: &FrameUniforms,
    guides: &[Guide],
    images: &[Image],
    new: Samples,
    past: Option<(&History, &[PixelMean], &EarlierPoints)>,
    changes: &Changes,
) -> Vec<PixelMean> {
    let moves = past.is_some_and(|(past, ..)| camera_moves(&past.frame, frame));
    let eye = Vec3::from(frame.position);
    let past = past.filter(|_| changes.max_history > 0.0);
    let join = |index: usize| {
        let (guide, image) = (&guides[index], &images[index]);
        let alone = PixelMean::alone(&new, index, guide.reflected.square);
        let Some((past, means, earlier)) = past.filter(|_| guide.has_layer()) else { return alone };
        let earlier = earlier.at(index, guide);
        let sought = past.sought(guide, earlier, frame);
        let max_length = if moves { changes.max_history.min(image.max_history) } else { changes.max_history };
        let mirrored = guide.position + (guide.position - eye).normalize() * image.depth;
        if guide.has_medium() {
            let distance = image.depth + guide.length;
            let shows = |index: usize| {
                let there = &past.guides[index];
                let depth = depth_of_surface(there.length, distance);
                there.has_medium() && (depth - image.reach).abs() < MEDIUM_REACH
            };
            let place = past.projection.project(mirrored);
            let found = place.and_then(|place| past.mean_at(place, means, shows));
            let clamp = Clamp { limits: changes.scene.then_some(image.limits), max_length };
            return found.map_or(alone, |found| joined(found, alone, clamp));
        }
        // In a surface that moves, the image moves as well.
        let stands_still = earlier.position == guide.position;
        let place = past.projection.project(mirrored).filter(|_| stands_still && moves && image.depth > NO_IMAGE);
        let of_image = place.and_then(|place| past.mean_at(place, means, |index| past.shows_reflector(index, &sought)));
        let found = of_image.or_else(|| {
            let mut mean = past.find(&sought, means)?;
            mean.length = if moves { mean.length.min(MAX_IMAGELESS_HISTORY) } else { mean.length };
            Some(mean)
        });
        let clamp = Clamp { limits: (moves || changes.scene).then_some(image.limits), max_length };
        found.map_or(alone, |found| joined(found, alone, clamp))
    };
    (0..guides.len()).into_par_iter().with_min_len(1024).map(join).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    /// Guides of the middle of a picture that shows an object of metal, which mirrors what is 3 m away, and their images.
    fn images_in(object: &str) -> (Vec<Guide>, Vec<Image>) {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 0 5; target 0 0 0; fov 10 }}\nsky 1\n\
             material \"metal\" {{ metal 0.5; roughness 0.2 }}\nobject \"mirror\" material=\"metal\" {{ {object} }}"
        );
        let scene = Scene::parse("test.kdl", &text).expect("a scene");
        let input = RenderInput::new(&scene, &Settings { size: [24, 24], ..Settings::of(&scene) });
        let pixels: Vec<(u32, u32)> = (0..576).map(|index| (index % 24, index / 24)).collect();
        let (_, mut guides) = input.sample_with_guides(&input.context(None), &pixels, 0);
        for guide in &mut guides {
            guide.reflected.depth = 3.0 / (3.0 + guide.length);
        }
        let images = images(&input.frame, &guides, &vec![Vec3::ONE; 576]);
        (guides, images)
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
    fn light_of_facets_is_split_from_that_of_the_base() {
        let text = "pathmarch 1\ncamera { position 0 4 0.1; target 0 0 0; fov 20 }\nsky 1\n\
            material \"varnish\" { principled 0.5; roughness 0.1 }\nmaterial \"chalk\" { diffuse 0.5 }\n\
            object \"floor\" material=\"MATERIAL\" { plane }";
        for (material, range) in [("varnish", 0.06..0.1), ("chalk", -1e-9..1e-9)] {
            let scene = Scene::parse("test.kdl", &text.replace("MATERIAL", material)).expect("a scene");
            let input = RenderInput::new(&scene, &Settings { size: [24, 24], ..Settings::of(&scene) });
            let pixels: Vec<(u32, u32)> = (0..576).map(|index| (index % 24, index / 24)).collect();
            let mut share = 0.0;
            for sample in 0..16 {
                let (radiance, guides) = input.sample_with_guides(&input.context(None), &pixels, sample);
                let reflected: Vec3 = guides.iter().map(|guide| guide.reflected.radiance).sum();
                share += luminance(reflected) / luminance(radiance.iter().sum::<Vec3>()) / 16.0;
            }
            // From above, 0.04 is reflected, and half of the rest is scattered.
            assert!(range.contains(&share), "{material}: {share}");
        }
    }
}
