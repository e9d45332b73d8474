//! Reprojection and temporal accumulation.

use super::luminance;
use super::motion::Motion;
use crate::integrator::guides::{Guide, GuideClass};
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Means of the pixels of a picture, with all that is needed to find them in the next one.
pub(super) struct History {
    pub(super) frame: FrameUniforms,
    pub(super) guides: Arc<Vec<Guide>>,
    /// Mean irradiance.
    pub(super) irradiance: Vec<Vec3>,
    /// Means of the luminance and of its square, over samples.
    pub(super) moments: Vec<[f32; 2]>,
    /// Number of samples in each mean.
    pub(super) length: Vec<f32>,
    /// Position of each pixel's point in the last picture, pixels of that picture from its top left corner; `None` where it
    /// was hidden.
    pub(super) before: Vec<Option<[f32; 2]>>,
}

/// New samples of each pixel.
pub(super) struct Samples<'a> {
    /// Means of the irradiance.
    pub(super) irradiance: &'a [Vec3],
    /// Number of samples in each mean.
    pub(super) count: f32,
}

/// Mean of a point in an earlier picture.
struct Found {
    position: [f32; 2],
    irradiance: Vec3,
    moments: [f32; 2],
    length: f32,
}

shared_constants! {
    /// Largest distance of a point of the last picture from the plane of the surface, in sides of a pixel at its distance.
    const PLANE_TOLERANCE: f32 = 2.0;
    /// Largest distance within the plane, in sides of a pixel of the coarser picture.
    const POINT_TOLERANCE: f32 = 3.0;
    /// Least cosine between the normal and the ray by which the tolerance within the plane is divided.
    const MIN_GRAZING_COSINE: f32 = 0.05;
    /// Longest history of a surface that looks different from other directions, while the camera moves, samples.
    const MAX_GLOSSY_HISTORY: f32 = 5.0;
    /// Least cosine between normals of one surface.
    const MIN_NORMAL_COSINE: f32 = 0.8;
}

impl History {
    /// Joins new samples with the past, of which at most `max_length` samples count. If given, its luminance is clamped to
    /// the limits of each pixel.
    pub(super) fn new(
        frame: &FrameUniforms,
        guides: &Arc<Vec<Guide>>,
        new: Samples,
        past: Option<(&History, &Motion)>,
        max_length: f32,
        limits: Option<&[[f32; 2]]>,
    ) -> Self {
        let samples = new.count;
        let moves = past.is_some_and(|(past, _)| camera_moves(&past.frame, frame));
        let join = |index: usize| {
            let (guide, irradiance) = (&guides[index], new.irradiance[index]);
            let l = luminance(irradiance);
            // Fireflies of a single sample have been spread.
            let square = if samples > 1.0 { guide.square } else { l * l };
            let found = past.filter(|_| max_length > 0.0);
            let found = found.and_then(|(past, motion)| past.find(&motion.earlier(guide), frame));
            let Some(Found { position, irradiance: mut before, mut moments, length }) = found else {
                return (irradiance, [l, square], samples, None);
            };
            if let Some([least, most]) = limits.map(|limits| limits[index]) {
                let old = luminance(before);
                let factor = old.clamp(least, most) / old.max(1e-9);
                before *= factor;
                moments = [moments[0] * factor, moments[1] * factor * factor];
            }
            let limit = if moves && guide.is_glossy { max_length.min(MAX_GLOSSY_HISTORY) } else { max_length };
            let length = length.min(limit);
            let share = samples / (samples + length);
            let mean = |old: f32, new: f32| old + (new - old) * share;
            let moments = [mean(moments[0], l), mean(moments[1], square)];
            (before.lerp(irradiance, share), moments, samples + length, Some(position))
        };
        let joined: Vec<_> = (0..guides.len()).into_par_iter().with_min_len(1024).map(join).collect();
        Self {
            frame: *frame,
            guides: guides.clone(),
            irradiance: joined.iter().map(|joined| joined.0).collect(),
            moments: joined.iter().map(|joined| joined.1).collect(),
            length: joined.iter().map(|joined| joined.2).collect(),
            before: joined.iter().map(|joined| joined.3).collect(),
        }
    }

    /// True if this picture shows the point of a guide, which the picture `frame` shows, at a position or next to it, in
    /// pixels.
    pub(super) fn shows(&self, guide: &Guide, frame: &FrameUniforms, [x, y]: [f32; 2]) -> bool {
        let [width, height] = self.frame.size().map(|side| side as i32);
        let pixel = guide.length * self.frame.pixel.max(frame.pixel);
        let (x, y) = (x as i32, y as i32);
        let eye = self.frame.position.into();
        let shows = |(dx, dy): (i32, i32)| {
            let (x, y) = (x + dx, y + dy);
            let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
            is_inside && same_point(guide, &self.guides[(y * width + x) as usize], eye, pixel)
        };
        // Most often the pixel itself shows it.
        shows((0, 0)) || (-1..=1).any(|dy| (-1..=1).any(|dx| shows((dx, dy))))
    }

    /// Mean of the point of a guide, which the picture `frame` shows; `None` if this picture does not show the point.
    fn find(&self, guide: &Guide, frame: &FrameUniforms) -> Option<Found> {
        let [width, height] = self.frame.size();
        let position = project(&self.frame, guide.position)?;
        let [x, y] = position.map(|coordinate| coordinate - 0.5);
        // Pictures of a smaller size have larger pixels.
        let pixel = guide.length * self.frame.pixel.max(frame.pixel);
        let (mut irradiance, mut moments, mut length, mut total) = (Vec3::ZERO, [0.0; 2], 0.0, 0.0);
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (column, row) = (x.floor() + dx, y.floor() + dy);
            if column < 0.0 || row < 0.0 || column >= width as f32 || row >= height as f32 {
                continue;
            }
            let index = row as usize * width as usize + column as usize;
            if !same_point(guide, &self.guides[index], self.frame.position.into(), pixel) {
                continue;
            }
            let weight = (1.0 - (x - column).abs()) * (1.0 - (y - row).abs());
            irradiance += self.irradiance[index] * weight;
            moments = [moments[0] + self.moments[index][0] * weight, moments[1] + self.moments[index][1] * weight];
            length += self.length[index] * weight;
            total += weight;
        }
        (total > 0.01).then(|| Found {
            position,
            irradiance: irradiance / total,
            moments: moments.map(|moment| moment / total),
            length: length / total,
        })
    }
}

/// True if the camera moves between two frames.
pub(super) fn camera_moves(before: &FrameUniforms, after: &FrameUniforms) -> bool {
    let view = |frame: &FrameUniforms| (frame.position, frame.forward);
    view(before) != view(after)
}

/// True if a guide and one of a picture from `eye` show one place of one surface, to within a few sides of a pixel.
fn same_point(a: &Guide, b: &Guide, eye: Vec3, pixel: f32) -> bool {
    if a.class != b.class || a.object != b.object {
        return false;
    }
    if a.class == GuideClass::Sky {
        return true;
    }
    let apart = a.position - b.position;
    let along = a.normal.dot(apart).abs().min(b.normal.dot(apart).abs());
    // Seen at a grazing angle, a pixel covers more of the plane.
    let cosine = b.normal.dot((b.position - eye).normalize()).abs();
    let stretched = pixel * POINT_TOLERANCE / cosine.max(MIN_GRAZING_COSINE);
    along <= PLANE_TOLERANCE * pixel
        && apart.length_squared() <= stretched * stretched
        && a.normal.dot(b.normal) >= MIN_NORMAL_COSINE
}

/// Position of a point in a picture, in pixels from its top left corner; `None` behind the camera.
pub(super) fn project(frame: &FrameUniforms, point: Vec3) -> Option<[f32; 2]> {
    let [position, right, up, forward] = [frame.position, frame.right, frame.up, frame.forward].map(Vec3::from);
    let v = point - position;
    let depth = v.dot(forward);
    if depth <= 1e-6 * v.length() {
        return None;
    }
    let across = v.dot(right) / (right.length_squared() * depth);
    let upwards = v.dot(up) / (up.length_squared() * depth);
    Some([0.5 * (across + 1.0) * frame.width as f32, 0.5 * (1.0 - upwards) * frame.height as f32])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::integrator::camera::central_ray;
    use crate::settings::Settings;
    use pathmarch_scene::Scene;

    const SCENE: &str = "pathmarch 1\ncamera { position 1 2 6; target 0 1 0; fov 35 }\nsky 1\n\
        material \"mirror\" { metal 0.5; roughness 0 }\nobject \"floor\" { plane }\n\
        object \"mirror\" material=\"mirror\" { rect 4 { normal 0 0 1; at 0 1 -1 } }";

    fn input(viewpoint: [f32; 3]) -> RenderInput {
        let scene = Scene::parse("test.kdl", SCENE).expect("a scene");
        let mut camera = scene.cameras[0].clone();
        camera.position = viewpoint;
        let settings = Settings { size: [40, 30], viewpoint: Some(camera), ..Settings::of(&scene) };
        RenderInput::new(&scene, &settings)
    }

    #[test]
    fn projection_is_the_inverse_of_camera_rays() {
        let frame = input([1.0, 2.0, 6.0]).frame;
        for [x, y] in [[0.5, 0.5], [20.0, 15.0], [39.5, 3.25], [7.0, 29.0]] {
            let ray = central_ray(&frame, x, y);
            let [across, down] = project(&frame, ray.origin + ray.direction * 3.7).expect("in front");
            assert!((across - x).abs() < 1e-3 && (down - y).abs() < 1e-3, "{x} {y}: {across} {down}");
            assert!(project(&frame, ray.origin - ray.direction).is_none());
        }
    }

    /// What a plane mirror shows is a world behind it, in which points stand still when the camera moves: the floor there
    /// is the plane y = 0, too, and faces upwards.
    #[test]
    fn mirror_images_of_the_floor_lie_in_its_plane() {
        for viewpoint in [[1.0, 2.0, 6.0], [0.4, 1.5, 5.0]] {
            let input = input(viewpoint);
            let pixels: Vec<(u32, u32)> = (0..30).flat_map(|y| (0..40).map(move |x| (x, y))).collect();
            let (_, guides) = input.sample_with_guides(None, &pixels, 0);
            // The albedo of the floor is 0.8, that times the reflectance of the mirror about 0.4.
            let mirrored = guides.iter().filter(|guide| guide.object == 0 && guide.albedo.x < 0.7);
            let mut count = 0;
            for guide in mirrored.filter(|guide| guide.class == GuideClass::Surface) {
                assert!(guide.position.y.abs() < 0.01 && guide.position.z < -1.0, "{guide:?}");
                assert!(guide.normal.y > 0.99 && guide.albedo.x > 0.39, "{guide:?}");
                count += 1;
            }
            assert!(count > 20, "{count} pixels show the floor in the mirror");
        }
    }
}
