//! Reprojection and temporal accumulation.

use super::motion::{EarlierPoint, EarlierPoints};
use super::planes::box_sums;
use super::{direct_square, luminance};
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
    pub(super) means: Vec<PixelMean>,
    pub(super) projection: Projection,
    points: Vec<ShownPoint>,
}

/// Mean of a pixel.
#[derive(Clone, Copy)]
pub(super) struct PixelMean {
    pub(super) irradiance: Vec3,
    /// Number of samples in the mean.
    pub(super) length: f32,
    /// Means of the luminance and of its square, over samples.
    pub(super) moments: [f32; 2],
    /// Position of the pixel's point in the last picture, pixels of that picture from its top left corner; `None` where it
    /// was hidden.
    pub(super) before: Option<[f32; 2]>,
}

/// Point that a pixel shows, as the next picture looks it up. Small, since every pixel looks at several.
struct ShownPoint {
    position: Vec3,
    /// Reciprocal of the cosine between the normal and the ray: seen at a grazing angle, a pixel covers more of the plane.
    stretch: f32,
    normal: Vec3,
    /// See [`surface_of`]; negative if the pixel shows several surfaces.
    surface: f32,
}

/// Point of a present picture, where it was in an earlier scene.
pub(super) struct SoughtPoint {
    pub(super) position: Vec3,
    normal: Vec3,
    /// Side of a pixel at its distance, metres: that of the picture with the larger pixels.
    pixel: f32,
    surface: f32,
    is_sky: bool,
}

/// Surface of a guide, as a number from 1 on that is equal on points of one surface: a medium in front of it takes light from
/// it. It is no integer, which vector instructions would read as a subnormal number, and be slow.
fn surface_of(guide: &Guide) -> f32 {
    (8 * guide.object + 2 * guide.class as u32 + u32::from(guide.has_medium()) + 1) as f32
}

impl ShownPoint {
    /// Point of a guide in a picture from `eye`.
    fn new(guide: &Guide, eye: Vec3) -> Self {
        let &Guide { position, normal, .. } = guide;
        let cosine = normal.dot((position - eye).normalize()).abs();
        let surface = if guide.is_mixed { -surface_of(guide) } else { surface_of(guide) };
        Self { position, stretch: cosine.max(MIN_GRAZING_COSINE).recip(), normal, surface }
    }

    /// True if the pixel shows a point of this surface.
    fn has_surface(&self, surface: f32) -> bool {
        self.surface.abs() == surface
    }

    /// True if it and a point that was sought show one place of one surface, to within a few sides of a pixel.
    #[inline]
    fn is_at(&self, sought: &SoughtPoint) -> bool {
        if !self.has_surface(sought.surface) {
            return false;
        }
        if sought.is_sky {
            return true;
        }
        let (apart, pixel) = (sought.position - self.position, sought.pixel);
        let along = sought.normal.dot(apart).abs().min(self.normal.dot(apart).abs());
        let stretched = pixel * POINT_TOLERANCE * self.stretch;
        along <= PLANE_TOLERANCE * pixel
            && apart.length_squared() <= stretched * stretched
            && sought.normal.dot(self.normal) >= MIN_NORMAL_COSINE
    }
}

/// New samples of each pixel.
pub(super) struct Samples<'a> {
    /// Means of the irradiance.
    pub(super) irradiance: &'a [Vec3],
    /// Number of samples in each mean.
    pub(super) count: f32,
}

shared_constants! {
    /// Largest distance of a point of the last picture from the plane of the surface, in sides of a pixel at its distance.
    const PLANE_TOLERANCE: f32 = 2.0;
    /// Largest distance within the plane, in sides of a pixel of the coarser picture.
    const POINT_TOLERANCE: f32 = 3.0;
    /// Further distance of a point that mirrors the same image, in its distance within the plane.
    const CURVED_TOLERANCE: f32 = 0.2;
    /// Least cosine between the normal and the ray by which the tolerance within the plane is divided.
    const MIN_GRAZING_COSINE: f32 = 0.05;
    /// Least cosine between the normals of pixels beside each other on a smooth surface.
    const MIN_SMOOTH_COSINE: f32 = 0.9;
    /// Least number of such pixels beside one that is on a smooth surface.
    pub(super) const SMOOTH_NEIGHBOURS: u32 = 2;
    /// Longest history of glass, and of glossy surfaces whose facets are not filtered apart, while the camera moves, samples.
    const MAX_GLOSSY_HISTORY: f32 = 3.0;
    /// Longest history of surfaces that are not smooth, as those of fractals, while the camera moves, samples: the past,
    /// interpolated again and again, would blur them.
    const MAX_ROUGH_HISTORY: f32 = 3.0;
    /// Half the side of the square that decides which luminance is plausible, pixels.
    const PLAUSIBLE_RADIUS: i32 = 2;
    /// Standard deviations of single samples by which a mean may differ from that of the square: three standard errors.
    const PLAUSIBLE_REACH: f32 = 0.6;
    /// Squared deviation of the luminance of the pixels between which the past is interpolated, in variances of its mean, from
    /// which on the history is shortened: interpolated again and again, the edges of shadows would blur.
    const MAX_CONTRAST: f32 = 0.3;
    /// Squared relative deviation that counts as rounding, in units of the above.
    const CONTRAST_ROUNDING: f32 = 1e-6;
    /// Length below which contrast shortens no history, samples.
    const MIN_CONTRAST_HISTORY: f32 = 2.0;
    /// Least cosine between normals of one surface.
    pub(super) const MIN_NORMAL_COSINE: f32 = 0.8;
}

impl PixelMean {
    /// Mean of new samples alone; `square` is that of their luminance.
    pub(super) fn alone(new: &Samples, index: usize, square: f32) -> Self {
        let irradiance = new.irradiance[index];
        let l = luminance(irradiance);
        // Fireflies of a single sample have been spread.
        let square = if new.count > 1.0 { square } else { l * l };
        Self { irradiance, length: new.count, moments: [l, square], before: None }
    }
}

/// What limits the past of a pixel.
pub(super) struct Clamp {
    /// Least and largest plausible luminance.
    pub(super) limits: Option<[f32; 2]>,
    /// Samples that count at most.
    pub(super) max_length: f32,
}

/// Joins the mean of the past with that of new samples.
pub(super) fn joined(past: PixelMean, new: PixelMean, clamp: Clamp) -> PixelMean {
    let PixelMean { irradiance: mut old, mut length, mut moments, before } = past;
    if let Some([least, most]) = clamp.limits {
        let old_luminance = luminance(old);
        let clamped = old_luminance.clamp(least, most);
        let factor = clamped / old_luminance.max(1e-9);
        old *= factor;
        moments = [moments[0] * factor, moments[1] * factor * factor];
        // The less of it is plausible, the fewer samples it is worth.
        let agreement = (clamped.min(old_luminance) + 1e-9) / (clamped.max(old_luminance) + 1e-9);
        length *= agreement * agreement;
    }
    let length = length.min(clamp.max_length);
    let share = new.length / (new.length + length);
    let mean = |old: f32, new: f32| old + (new - old) * share;
    let moments = std::array::from_fn(|k| mean(moments[k], new.moments[k]));
    PixelMean { irradiance: old.lerp(new.irradiance, share), length: new.length + length, moments, before }
}

/// Pixels beside a pixel that are parts of one smooth surface.
pub(super) fn smooth_neighbours(guides: &[Guide], size: [u32; 2], index: usize) -> impl Iterator<Item = &Guide> {
    let [width, height] = size.map(|side| side as i32);
    let (x, y, guide) = (index as i32 % width, index as i32 / width, &guides[index]);
    let beside = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)].into_iter();
    let inside = beside.filter(move |(x, y)| (0..width).contains(x) && (0..height).contains(y));
    inside.map(move |(x, y)| &guides[(y * width + x) as usize]).filter(move |there| {
        let is_same = there.object == guide.object && there.class == guide.class;
        is_same && there.normal.dot(guide.normal) >= MIN_SMOOTH_COSINE
    })
}

/// True if a pixel shows a surface that is smooth from pixel to pixel.
fn is_smooth(guides: &[Guide], size: [u32; 2], index: usize) -> bool {
    smooth_neighbours(guides, size, index).count() >= SMOOTH_NEIGHBOURS as usize
}

/// Least and largest luminance of a mean beside these sums over samples: luminance, its square, and 1. `reach` is in standard
/// deviations of single samples.
pub(super) fn plausible_range([light, squares, count]: [f32; 3], reach: f32) -> [f32; 2] {
    let (mean, square) = (light / count, squares / count);
    let reach = (square - mean * mean).max(0.0).sqrt() * reach;
    [(mean - reach).max(0.0), mean + reach]
}

/// Least and largest luminance that the mean of each pixel may have, judged from the samples around it.
pub(super) fn plausible_luminances(size: [u32; 2], irradiance: &[Vec3]) -> Vec<[f32; 2]> {
    let sums = box_sums(size, PLAUSIBLE_RADIUS, |index| {
        let luminance = luminance(irradiance[index]);
        [luminance, luminance * luminance, 1.0]
    });
    let limits = |index: usize| plausible_range(sums.at(index), PLAUSIBLE_REACH);
    (0..irradiance.len()).into_par_iter().with_min_len(4096).map(limits).collect()
}

impl History {
    /// Joins new samples with the past. If given, its luminance is clamped to the limits of each pixel.
    pub(super) fn new(
        frame: &FrameUniforms,
        guides: &Arc<Vec<Guide>>,
        new: Samples,
        past: Option<(&History, &EarlierPoints)>,
        max_length: f32,
        limits: Option<&[[f32; 2]]>,
    ) -> Self {
        let moves = past.is_some_and(|(past, _)| camera_moves(&past.frame, frame));
        let past = past.filter(|_| max_length > 0.0);
        let join = |index: usize| {
            let guide = &guides[index];
            let alone = PixelMean::alone(&new, index, direct_square(guide, luminance(new.irradiance[index])));
            let found = past.and_then(|(past, earlier)| {
                past.find(&past.sought(guide, earlier.at(index, guide), frame), &past.means)
            });
            let max_length = match () {
                () if !moves => max_length,
                () if guide.is_glossy && !guide.has_facets() => max_length.min(MAX_GLOSSY_HISTORY),
                () if !is_smooth(guides, frame.size(), index) => max_length.min(MAX_ROUGH_HISTORY),
                () => max_length,
            };
            let clamp = Clamp { limits: limits.map(|limits| limits[index]), max_length };
            found.map_or(alone, |found| joined(found, alone, clamp))
        };
        let eye = frame.position.into();
        Self {
            frame: *frame,
            guides: guides.clone(),
            projection: Projection::new(frame),
            means: (0..guides.len()).into_par_iter().with_min_len(1024).map(join).collect(),
            points: guides.par_iter().with_min_len(1024).map(|guide| ShownPoint::new(guide, eye)).collect(),
        }
    }

    /// Point of a guide of the picture `frame`, as this picture may show it, from where it was.
    pub(super) fn sought(&self, guide: &Guide, earlier: EarlierPoint, frame: &FrameUniforms) -> SoughtPoint {
        let EarlierPoint { position, normal } = earlier;
        let pixel = guide.length * self.frame.pixel.max(frame.pixel);
        SoughtPoint { position, normal, pixel, surface: surface_of(guide), is_sky: guide.class == GuideClass::Sky }
    }

    /// True if this picture shows a point at a position, in pixels, or next to it.
    pub(super) fn shows(&self, sought: &SoughtPoint, [x, y]: [f32; 2]) -> bool {
        let [width, height] = self.frame.size().map(|side| side as i32);
        let (x, y) = (x as i32, y as i32);
        let shows = |(dx, dy): (i32, i32)| {
            let (x, y) = (x + dx, y + dy);
            let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
            is_inside && self.points[(y * width + x) as usize].is_at(sought)
        };
        // Most often the pixel itself shows it.
        shows((0, 0)) || (-1..=1).any(|dy| (-1..=1).any(|dx| shows((dx, dy))))
    }

    /// Mean of a point among those of the pixels, and its position here; `None` if this picture does not show it.
    pub(super) fn find(&self, sought: &SoughtPoint, means: &[PixelMean]) -> Option<PixelMean> {
        let position = self.projection.project(sought.position)?;
        // The mean of several surfaces is that of none.
        self.mean_at(position, means, |index| self.points[index].surface > 0.0 && self.points[index].is_at(sought))
    }

    /// True if a pixel shows a part of a surface that mirrors what the sought point of it mirrors.
    pub(super) fn shows_reflector(&self, index: usize, sought: &SoughtPoint) -> bool {
        let point = &self.points[index];
        let apart = sought.position - point.position;
        let along = sought.normal.dot(apart).abs().min(point.normal.dot(apart).abs());
        point.has_surface(sought.surface)
            && sought.normal.dot(point.normal) >= MIN_NORMAL_COSINE
            && along <= PLANE_TOLERANCE * sought.pixel + CURVED_TOLERANCE * apart.length()
    }

    /// Mean at a position of this picture, of the pixels that `shows` accepts.
    pub(super) fn mean_at(
        &self,
        position: [f32; 2],
        means: &[PixelMean],
        shows: impl Fn(usize) -> bool,
    ) -> Option<PixelMean> {
        let [width, height] = self.frame.size();
        let [x, y] = position.map(|coordinate| coordinate - 0.5);
        let (mut irradiance, mut moments, mut length, mut total) = (Vec3::ZERO, [0.0; 2], 0.0, 0.0);
        let mut squares = 0.0;
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (column, row) = (x.floor() + dx, y.floor() + dy);
            if column < 0.0 || row < 0.0 || column >= width as f32 || row >= height as f32 {
                continue;
            }
            let index = row as usize * width as usize + column as usize;
            let weight = (1.0 - (x - column).abs()) * (1.0 - (y - row).abs());
            if weight <= 0.0 || !shows(index) {
                continue;
            }
            let mean = &means[index];
            irradiance += mean.irradiance * weight;
            moments = [moments[0] + mean.moments[0] * weight, moments[1] + mean.moments[1] * weight];
            squares += mean.moments[0] * mean.moments[0] * weight;
            length += mean.length * weight;
            total += weight;
        }
        if total <= 0.01 {
            return None;
        }
        let (moments, length) = (moments.map(|moment| moment / total), length / total);
        let length = contrast_limited_length(moments, squares / total, length);
        Some(PixelMean { irradiance: irradiance / total, length, moments, before: Some(position) })
    }
}

/// Length of the history of an interpolated mean, shortened where the contrast between its pixels is more than their noise,
/// samples; `square` is the mean square of the interpolated luminances.
fn contrast_limited_length([mean, mean_square]: [f32; 2], square: f32, length: f32) -> f32 {
    let deviation = (square - mean * mean).max(0.0);
    let variance = (mean_square - square).max(0.0) / length;
    let known = length * (MAX_CONTRAST * variance + CONTRAST_ROUNDING * mean * mean) / deviation.max(f32::MIN_POSITIVE);
    length.min(known.max(MIN_CONTRAST_HISTORY))
}

/// True if the camera moves between two frames.
pub(super) fn camera_moves(before: &FrameUniforms, after: &FrameUniforms) -> bool {
    let view = |frame: &FrameUniforms| (frame.position, frame.forward);
    view(before) != view(after)
}

/// Projection of points into a picture.
#[derive(Clone, Copy)]
pub(crate) struct Projection {
    position: Vec3,
    forward: Vec3,
    /// Vectors whose dot products with a vector, divided by its depth, are pixels from the middle of the picture.
    right: Vec3,
    down: Vec3,
    middle: [f32; 2],
}

impl Projection {
    pub(crate) fn new(frame: &FrameUniforms) -> Self {
        let [position, right, up, forward] = [frame.position, frame.right, frame.up, frame.forward].map(Vec3::from);
        let middle = [0.5 * frame.width as f32, 0.5 * frame.height as f32];
        let (right, down) = (right * middle[0] / right.length_squared(), up * -middle[1] / up.length_squared());
        Self { position, forward, right, down, middle }
    }

    /// Position of a point, in pixels from the top left corner; `None` behind the camera.
    #[inline]
    pub(crate) fn project(&self, point: Vec3) -> Option<[f32; 2]> {
        let v = point - self.position;
        let depth = v.dot(self.forward);
        if depth <= 1e-6 * v.abs().max_element() {
            return None;
        }
        let scale = depth.recip();
        Some([self.middle[0] + v.dot(self.right) * scale, self.middle[1] + v.dot(self.down) * scale])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::integrator::camera::central_ray;
    use crate::integrator::medium_light::MEDIUM_ALPHA;
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
            let projection = Projection::new(&frame);
            let [across, down] = projection.project(ray.origin + ray.direction * 3.7).expect("in front");
            assert!((across - x).abs() < 1e-3 && (down - y).abs() < 1e-3, "{x} {y}: {across} {down}");
            assert!(projection.project(ray.origin - ray.direction).is_none());
        }
    }

    #[test]
    fn a_lens_leaves_samples_in_their_pixels() {
        let scene = Scene::parse("test.kdl", SCENE).expect("a scene");
        let mut camera = scene.cameras[0].clone();
        (camera.lens_radius, camera.focus) = (0.3, Some(4.0));
        let settings = Settings { size: [40, 30], viewpoint: Some(camera), ..Settings::of(&scene) };
        let input = RenderInput::new(&scene, &settings);
        let pixels: Vec<(u32, u32)> = (0..30).flat_map(|y| (0..40).map(move |x| (x, y))).collect();
        let (_, guides) = input.sample_with_guides(&input.context(None), &pixels, 0);
        let projection = Projection::new(&input.frame);
        for ((x, y), guide) in pixels.into_iter().zip(guides) {
            let [across, down] = projection.project(guide.position).expect("in front");
            let (dx, dy) = (across - x as f32, down - y as f32);
            assert!((-1e-3..1.001).contains(&dx) && (-1e-3..1.001).contains(&dy), "{x} {y}: {across} {down}");
        }
    }

    /// Frame of a camera at this place, and guides of its pixels on the plane z = 0, which is object 1.
    fn on_a_plane(viewpoint: [f32; 3]) -> (FrameUniforms, Vec<Guide>) {
        let frame = input(viewpoint).frame;
        let guide = |index: usize| {
            let ray = central_ray(&frame, (index % 40) as f32 + 0.5, (index / 40) as f32 + 0.5);
            let length = -ray.origin.z / ray.direction.z;
            let (position, class) = (ray.origin + ray.direction * length, GuideClass::Surface);
            Guide { position, normal: Vec3::Z, seen_normal: Vec3::Z, length, class, object: 1, ..Guide::NONE }
        };
        (frame, (0..1200).map(guide).collect())
    }

    /// Lengths of the histories of a picture after one of the plane, from these cameras, whose guides `change` alters.
    fn lengths(cameras: [[f32; 3]; 2], change: impl Fn(&mut Guide)) -> Vec<f32> {
        let [past, (frame, mut guides)] = cameras.map(on_a_plane);
        guides.iter_mut().for_each(change);
        let irradiance = vec![Vec3::ONE; 1200];
        let picture = |frame: &FrameUniforms, guides: Vec<Guide>, past: Option<(&History, &EarlierPoints)>| {
            let new = Samples { irradiance: &irradiance, count: 1.0 };
            History::new(frame, &Arc::new(guides), new, past, 24.0, None)
        };
        let past = picture(&past.0, past.1, None);
        let present = picture(&frame, guides, Some((&past, &EarlierPoints::default())));
        present.means.iter().map(|mean| mean.length).collect()
    }

    #[test]
    fn histories_end_at_other_depths_normals_objects_and_classes() {
        const EYE: [f32; 3] = [1.0, 2.0, 6.0];
        let all = |lengths: Vec<f32>, length: f32| lengths.iter().all(|found| *found == length);
        let side = input(EYE).frame.pixel * 6.0;
        assert!(all(lengths([EYE, EYE], |_| ()), 2.0));
        assert!(all(lengths([EYE, EYE], |guide| guide.position.z += side), 2.0), "within the tolerance");
        assert!(all(lengths([EYE, EYE], |guide| guide.position.z += 4.0 * side), 1.0), "depth");
        assert!(all(lengths([EYE, EYE], |guide| guide.normal = Vec3::new(0.7, 0.0, 0.714)), 1.0), "normal");
        assert!(all(lengths([EYE, EYE], |guide| guide.object = 2), 1.0), "object");
        assert!(all(lengths([EYE, EYE], |guide| guide.class = GuideClass::Glass), 1.0), "class");
        assert!(all(lengths([EYE, EYE], |guide| guide.reflected.alpha = MEDIUM_ALPHA), 1.0), "medium");
        assert!(all(lengths([EYE, EYE], |guide| guide.position = Vec3::splat(f32::NAN)), 1.0), "no position");
    }

    /// Share of the pixels of a plane whose mean is off by more than a fifth after a flight over this irradiance.
    fn blurred(irradiance: impl Fn(Vec3) -> f32) -> f32 {
        let mut past: Option<(History, Vec<f32>)> = None;
        for step in 0..24 {
            let (frame, guides) = on_a_plane([1.0 + 0.037 * step as f32, 2.0, 6.0]);
            let truth: Vec<f32> = guides.iter().map(|guide| irradiance(guide.position)).collect();
            let new: Vec<Vec3> = truth.iter().map(|light| Vec3::splat(*light)).collect();
            let earlier = EarlierPoints::default();
            let last = past.as_ref().map(|(history, _)| (history, &earlier));
            let new = Samples { irradiance: &new, count: 1.0 };
            past = Some((History::new(&frame, &Arc::new(guides), new, last, 24.0, None), truth));
        }
        let (history, truth) = past.expect("a picture");
        let is_off = |(mean, truth): &(&PixelMean, &f32)| (mean.irradiance.x - *truth).abs() > 0.2;
        history.means.iter().zip(&truth).filter(is_off).count() as f32 / truth.len() as f32
    }

    #[test]
    fn shadows_keep_their_edges_in_flight() {
        let stripes = |p: Vec3| if (2.0 * p.x).rem_euclid(1.0) < 0.5 { 1.0 } else { 0.1 };
        let share = blurred(stripes);
        // Without shorter histories it is 0.36.
        assert!(share < 0.15, "{share}");
        assert_eq!(blurred(|_| 0.7), 0.0);
    }

    #[test]
    fn histories_end_beyond_the_picture() {
        // The camera turns about the target: what comes in from one side has no past.
        let lengths = lengths([[1.0, 2.0, 6.0], [3.0, 2.0, 6.0]], |_| ());
        let new = lengths.iter().filter(|length| **length == 1.0).count();
        assert!((20..600).contains(&new), "{new}");
        assert!(lengths.iter().all(|length| *length == 1.0 || *length == 2.0));
        // Behind the camera of the last picture.
        assert!(
            self::lengths([[1.0, 2.0, 6.0], [1.0, 2.0, -6.0]], |guide| guide.position.z = 20.0)
                .iter()
                .all(|length| *length == 1.0)
        );
    }

    #[test]
    fn a_past_that_is_hardly_plausible_counts_less() {
        let (frame, guides) = on_a_plane([1.0, 2.0, 6.0]);
        let guides = Arc::new(guides);
        let picture = |light: f32, past: Option<(&History, &EarlierPoints)>, limits: Option<&[[f32; 2]]>| {
            let irradiance = vec![Vec3::splat(light); 1200];
            History::new(&frame, &guides, Samples { irradiance: &irradiance, count: 1.0 }, past, 24.0, limits)
        };
        let still = EarlierPoints::default();
        let mut past = picture(8.0, None, None);
        for _ in 0..3 {
            past = picture(8.0, Some((&past, &still)), None);
        }
        let after = |light: f32| picture(light, Some((&past, &still)), Some(&vec![[light, light]; 1200])).means[600];
        assert_eq!((after(8.0).length, after(8.0).irradiance), (5.0, Vec3::splat(8.0)));
        // Half as much light: a quarter of the samples.
        assert!((after(4.0).length - 2.0).abs() < 1e-5 && (after(4.0).irradiance - 4.0).length() < 1e-5);
        assert!((after(16.0).length - 2.0).abs() < 1e-5);
    }

    /// What a plane mirror shows is a world behind it, in which points stand still when the camera moves: the floor there
    /// is the plane y = 0, too, and faces upwards.
    #[test]
    fn mirror_images_of_the_floor_lie_in_its_plane() {
        for viewpoint in [[1.0, 2.0, 6.0], [0.4, 1.5, 5.0]] {
            let input = input(viewpoint);
            let pixels: Vec<(u32, u32)> = (0..30).flat_map(|y| (0..40).map(move |x| (x, y))).collect();
            let (_, guides) = input.sample_with_guides(&input.context(None), &pixels, 0);
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
