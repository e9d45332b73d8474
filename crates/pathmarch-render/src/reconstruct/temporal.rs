//! Reprojection and temporal accumulation.

use super::changed_light;
use super::means::{Found, Means, PixelMean, Samples};
use super::motion::EarlierPoints;
use super::planes::{Grid, Place, SQUARE_OF_3, by_eight};
use super::surfaces::{MIN_NORMAL_COSINE, Points, SurfacePlanes, Vectors};
use super::variance_without_facets;
use crate::integrator::guides::Guide;
use crate::intersect::ray::{lanes, transposed};
use crate::scene::FrameUniforms;
use crate::wgsl::shared_constants;
use glam::Vec3;
use std::sync::Arc;
use wide::{f32x8, i32x8};

/// Means of the pixels of a picture, with all that is needed to find them in the next one.
pub(super) struct History {
    pub(super) frame: FrameUniforms,
    pub(super) guides: Arc<Vec<Guide>>,
    pub(super) means: Vec<PixelMean>,
    pub(super) projection: Projection,
    points: Vec<ShownPoint>,
}

/// Point that a pixel shows, as the next picture looks it up. Small, since every pixel looks at several.
#[derive(Clone, Copy, Default)]
#[repr(C)]
struct ShownPoint {
    position: Vec3,
    /// Reciprocal of the cosine between the normal and the ray: seen at a grazing angle, a pixel covers more of the plane.
    stretch: f32,
    normal: Vec3,
    /// See [`surface_of`](super::surfaces::surface_of); negative if the pixel shows several surfaces.
    surface: f32,
}

/// Points that eight pixels show.
struct ShownPoints {
    position: Vectors,
    stretch: f32x8,
    normal: Vectors,
    surface: f32x8,
}

/// Points of eight pixels of a present picture, where they were in an earlier scene.
#[derive(Clone, Copy)]
pub(super) struct SoughtPoints {
    pub(super) position: Vectors,
    pub(super) normal: Vectors,
    /// Sides of a pixel at their distances, metres: those of the picture with the larger pixels.
    pub(super) pixel: f32x8,
    pub(super) surface: f32x8,
    /// Largest squared difference between directions to points of the sky; below 0 for surfaces.
    pub(super) sky_tolerance: f32x8,
}

impl ShownPoint {
    /// A point from its numbers, in their order in memory.
    fn from_row([px, py, pz, stretch, nx, ny, nz, surface]: [f32; 8]) -> Self {
        Self { position: Vec3::new(px, py, pz), stretch, normal: Vec3::new(nx, ny, nz), surface }
    }

    #[inline(always)]
    fn row(&self) -> [f32; 8] {
        let &Self { position: p, stretch, normal: n, surface } = self;
        [p.x, p.y, p.z, stretch, n.x, n.y, n.z, surface]
    }
}

impl ShownPoints {
    /// Points of a picture from `eye`.
    fn of(surfaces: &SurfacePlanes, place: Place, eye: Vectors) -> Self {
        let (position, normal) = (surfaces.position(place), surfaces.normal(place));
        let ray = position - eye;
        let cosine = normal.dot(ray).abs() / ray.dot(ray).sqrt();
        let stretch = f32x8::ONE / cosine.fast_max(f32x8::splat(MIN_GRAZING_COSINE));
        Self { position, stretch, normal, surface: surfaces.surface(place) }
    }

    /// Points of these indices.
    #[inline(always)]
    fn gathered(points: &[ShownPoint], indices: [usize; 8]) -> Self {
        let [px, py, pz, stretch, nx, ny, nz, surface] = transposed(indices.map(|index| points[index].row()));
        Self { position: Vectors::new(px, py, pz), stretch, normal: Vectors::new(nx, ny, nz), surface }
    }

    /// The points, one by one.
    fn each(self) -> [ShownPoint; 8] {
        let Self { position: p, stretch, normal: n, surface } = self;
        let rows = f32x8::transpose([p.x, p.y, p.z, stretch, n.x, n.y, n.z, surface]);
        rows.map(|row| ShownPoint::from_row(row.to_array()))
    }

    /// Mask of the pixels that show points of these surfaces.
    #[inline(always)]
    fn have_surface(&self, surface: f32x8) -> f32x8 {
        self.surface.abs().simd_eq(surface)
    }

    /// Mask of those that show the places of surfaces that were sought, to within a few sides of a pixel.
    #[inline(always)]
    fn are_at(&self, sought: &SoughtPoints) -> f32x8 {
        let (apart, pixel) = (sought.position - self.position, sought.pixel);
        let along = sought.normal.dot(apart).abs().fast_min(self.normal.dot(apart).abs());
        let stretched = pixel * POINT_TOLERANCE * self.stretch;
        let are_near = along.simd_le(pixel * PLANE_TOLERANCE)
            & apart.dot(apart).simd_le(stretched * stretched)
            & sought.normal.dot(self.normal).simd_ge(f32x8::splat(MIN_NORMAL_COSINE));
        let turned = sought.normal - self.normal;
        let are_same_sky = turned.dot(turned).simd_le(sought.sky_tolerance);
        self.have_surface(sought.surface) & (are_same_sky | (are_near & sought.sky_tolerance.simd_lt(f32x8::ZERO)))
    }
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
    /// Longest history of glass, and of glossy surfaces whose facets are not filtered apart, while the camera moves, samples.
    const MAX_GLOSSY_HISTORY: f32 = 3.0;
    /// Longest history of surfaces that are not smooth, as those of fractals, while the camera moves, samples: the past,
    /// interpolated again and again, would blur them.
    const MAX_ROUGH_HISTORY: f32 = 3.0;
    /// Squared deviation of the luminance of the pixels between which the past is interpolated, in variances of its mean, from
    /// which on the history is shortened: interpolated again and again, the edges of shadows would blur.
    const MAX_CONTRAST: f32 = 0.3;
    /// Squared relative deviation that counts as rounding, in units of the above.
    const CONTRAST_ROUNDING: f32 = 1e-6;
    /// Length below which contrast shortens no history, samples.
    const MIN_CONTRAST_HISTORY: f32 = 2.0;
    /// Least weight of the pixels of the last picture that show a point, of 1.
    const MIN_FOUND_WEIGHT: f32 = 0.01;
}

/// Positions in a picture, pixels from its top left corner, and the mask of those that are in front of its camera.
#[derive(Clone, Copy)]
pub(super) struct Positions {
    pub(super) x: f32x8,
    pub(super) y: f32x8,
    pub(super) mask: f32x8,
}

impl Positions {
    #[inline(always)]
    pub(super) fn moved(self, [x, y]: [f32x8; 2]) -> Self {
        Self { x: self.x + x, y: self.y + y, ..self }
    }
}

/// Pixels of a picture that are next to positions.
pub(super) struct Tap {
    pub(super) indices: [usize; 8],
    /// Mask of those in the picture.
    are_inside: f32x8,
}

impl Tap {
    /// Pixels of these columns and rows; the nearest ones for those beyond the picture.
    #[inline(always)]
    fn new(grid: Grid, column: f32x8, row: f32x8) -> Self {
        let [width, height] = [grid.width, grid.height].map(|side| f32x8::splat(side as f32));
        let are_inside =
            column.simd_ge(f32x8::ZERO) & row.simd_ge(f32x8::ZERO) & column.simd_lt(width) & row.simd_lt(height);
        // Missing numbers would be no index, and floating-point numbers are too coarse for that of a very large picture.
        let [column, row] = [column, row].map(|at| (are_inside & at).fast_trunc_int());
        let index = row * i32x8::splat(grid.width) + column;
        Self { indices: index.to_array().map(|index| index as usize), are_inside }
    }
}

impl History {
    /// Joins new samples with the past, whose light may be another if the scene `has_changed`.
    pub(super) fn new(
        frame: &FrameUniforms,
        (guides, surfaces): (&Arc<Vec<Guide>>, &SurfacePlanes),
        new: Samples,
        past: Option<(&History, &EarlierPoints)>,
        max_length: f32,
        has_changed: bool,
    ) -> Self {
        let moves = past.is_some_and(|(past, _)| camera_moves(&past.frame, frame));
        let past = past.filter(|_| max_length > 0.0);
        let (grid, longest, projection) = (surfaces.grid, f32x8::splat(max_length), Projection::new(frame));
        let square = |index: usize, mean: f32| mean * mean + variance_without_facets(&guides[index], mean);
        let alone = |place: Place| Means::alone(&new, place.indices(grid), square);
        let find = |place: Place| {
            let Some((past, earlier)) = past else { return Found::NONE };
            let points = surfaces.points(place);
            let sought = past.sought(&points, earlier, place.indices(grid), frame);
            let to_middle = past.offset_to_middle(&projection, place, points.position);
            let max_length = match moves {
                true => {
                    let rough = surfaces
                        .smooth_neighbours(place, |_, _| ())
                        .select(longest, longest.fast_min(f32x8::splat(MAX_ROUGH_HISTORY)));
                    surfaces.are_glossy(place).select(longest.fast_min(f32x8::splat(MAX_GLOSSY_HISTORY)), rough)
                }
                false => longest,
            };
            past.find(&sought, to_middle, &past.means).limited(None, max_length)
        };
        let means = match has_changed {
            true => changed_light::joined(surfaces, new.irradiance, find, alone),
            false => by_eight(grid, |place| find(place).joined(alone(place)).each()),
        };
        let eye = Vectors::constant(frame.position);
        Self {
            frame: *frame,
            guides: guides.clone(),
            projection,
            means,
            points: by_eight(grid, |place| ShownPoints::of(surfaces, place, eye).each()),
        }
    }

    fn grid(&self) -> Grid {
        Grid::new(self.frame.size())
    }

    /// Points that the pixels of these indices show.
    #[inline(always)]
    pub(super) fn points(&self, indices: [usize; 8]) -> Points {
        let ShownPoints { position, normal, surface, .. } = ShownPoints::gathered(&self.points, indices);
        let length = (position - Vectors::constant(self.frame.position)).length();
        Points { position, length, normal, surface: surface.abs() }
    }

    /// Points of pixels of the picture `frame`, which have these indices, as this picture may show them, from where they were.
    #[inline(always)]
    pub(super) fn sought(
        &self,
        points: &Points,
        earlier: &EarlierPoints,
        indices: [usize; 8],
        frame: &FrameUniforms,
    ) -> SoughtPoints {
        let (position, normal) = earlier.lanes(indices).unwrap_or((points.position, points.normal));
        let side = self.frame.pixel.max(frame.pixel);
        let sky_tolerance = points.sky_tolerance(POINT_TOLERANCE * side);
        SoughtPoints { position, normal, pixel: points.length * side, surface: points.surface, sky_tolerance }
    }

    /// Mask of the points that this picture shows at positions, or next to them.
    pub(super) fn shows(&self, sought: &SoughtPoints, position: &Positions) -> f32x8 {
        let (grid, column, row) = (self.grid(), position.x.floor(), position.y.floor());
        let shows = |dx: f32, dy: f32| {
            let tap = Tap::new(grid, column + dx, row + dy);
            tap.are_inside & ShownPoints::gathered(&self.points, tap.indices).are_at(sought)
        };
        // Most often the pixels themselves show them.
        let mut found = shows(0.0, 0.0);
        for (dx, dy) in SQUARE_OF_3 {
            if (found | !position.mask).all() {
                break;
            }
            found |= shows(dx as f32, dy as f32);
        }
        found & position.mask
    }

    /// Offsets from points that the samples of eight pixels of another picture show to the middle of these pixels, in pixels of
    /// this picture. A mean is that of its whole pixel: looked up where the last sample was, it would blur in every picture.
    #[inline(always)]
    pub(super) fn offset_to_middle(&self, other: &Projection, place: Place, points: Vectors) -> [f32x8; 2] {
        let now = other.project_all(points);
        let [column, row] = [lanes(|lane| (place.x() + lane) as f32), f32x8::splat(place.row as f32)];
        let scale: [f32; 2] = std::array::from_fn(|k| self.projection.middle[k] / other.middle[k]);
        [(column + 0.5 - now.x) * scale[0], (row + 0.5 - now.y) * scale[1]].map(|offset| now.mask & offset)
    }

    /// Means of the pixels that show points, and the positions here of what was in the middle of pixels, which have these offsets
    /// from the points.
    pub(super) fn find(&self, sought: &SoughtPoints, to_middle: [f32x8; 2], means: &[PixelMean]) -> Found {
        let position = self.projection.project_all(sought.position).moved(to_middle);
        self.means_at(&position, means, |tap| {
            let points = ShownPoints::gathered(&self.points, tap.indices);
            // The mean of several surfaces is that of none.
            points.surface.simd_gt(f32x8::ZERO) & points.are_at(sought)
        })
    }

    /// Mask of the pixels that show parts of surfaces which mirror what the sought points of them mirror.
    pub(super) fn show_reflectors(&self, tap: &Tap, sought: &SoughtPoints) -> f32x8 {
        let points = ShownPoints::gathered(&self.points, tap.indices);
        let apart = sought.position - points.position;
        let along = sought.normal.dot(apart).abs().fast_min(points.normal.dot(apart).abs());
        points.have_surface(sought.surface)
            & sought.normal.dot(points.normal).simd_ge(f32x8::splat(MIN_NORMAL_COSINE))
            & along.simd_le(sought.pixel * PLANE_TOLERANCE + apart.length() * CURVED_TOLERANCE)
    }

    /// Means at positions of this picture, of the pixels that `shows` accepts.
    #[inline(always)]
    pub(super) fn means_at(&self, position: &Positions, means: &[PixelMean], shows: impl Fn(&Tap) -> f32x8) -> Found {
        let (grid, x, y) = (self.grid(), position.x - 0.5, position.y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (mut irradiance, mut moments) = (Vectors::splat(f32x8::ZERO), [f32x8::ZERO; 2]);
        let (mut length, mut total, mut squares) = (f32x8::ZERO, f32x8::ZERO, f32x8::ZERO);
        for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            let (column, row) = (left + dx, top + dy);
            let tap = Tap::new(grid, column, row);
            let weight = (f32x8::ONE - (x - column).abs()) * (f32x8::ONE - (y - row).abs());
            let counts = tap.are_inside & position.mask & weight.simd_gt(f32x8::ZERO);
            if counts.none() {
                continue;
            }
            let counts = counts & shows(&tap);
            let weight = counts & weight;
            let there = Means::gathered(means, tap.indices);
            irradiance = irradiance + there.irradiance * weight;
            moments = [moments[0] + there.moments[0] * weight, moments[1] + there.moments[1] * weight];
            squares += there.moments[0] * there.moments[0] * weight;
            length += there.length * weight;
            total += weight;
        }
        let share = f32x8::ONE / total;
        let (moments, length) = ([moments[0] * share, moments[1] * share], length * share);
        let length = contrast_limited_length(moments, squares * share, length);
        let means = Means { irradiance: irradiance * share, length, moments, before: [position.x, position.y] };
        Found { means, mask: total.simd_gt(f32x8::splat(MIN_FOUND_WEIGHT)) }
    }
}

/// Lengths of the histories of interpolated means, shortened where the contrast between their pixels is more than their noise,
/// samples; `square` is the mean square of the interpolated luminances.
#[inline(always)]
fn contrast_limited_length([mean, mean_square]: [f32x8; 2], square: f32x8, length: f32x8) -> f32x8 {
    let deviation = (square - mean * mean).fast_max(f32x8::ZERO);
    let variance = (mean_square - square).fast_max(f32x8::ZERO) / length;
    let limit = variance * MAX_CONTRAST + mean * mean * CONTRAST_ROUNDING;
    let known = length * limit / deviation.fast_max(f32x8::splat(f32::MIN_POSITIVE));
    length.fast_min(known.fast_max(f32x8::splat(MIN_CONTRAST_HISTORY)))
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

    /// Positions of eight points.
    #[inline(always)]
    pub(super) fn project_all(&self, points: Vectors) -> Positions {
        let v = points - Vectors::constant(self.position.into());
        let [right, down, forward] = [self.right, self.down, self.forward].map(|v| Vectors::constant(v.into()));
        let depth = v.dot(forward);
        let mask = depth.simd_gt(v.abs().largest() * 1e-6);
        let scale = f32x8::ONE / depth;
        let [x, y] = [v.dot(right) * scale + self.middle[0], v.dot(down) * scale + self.middle[1]];
        Positions { x, y, mask }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::RenderInput;
    use crate::integrator::camera::central_ray;
    use crate::integrator::guides::{GuideClass, NO_OBJECT};
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

    /// History of a picture of these guides.
    fn history_of(
        frame: &FrameUniforms,
        guides: Vec<Guide>,
        new: Samples,
        past: Option<(&History, &EarlierPoints)>,
    ) -> History {
        let surfaces = SurfacePlanes::new(frame, &guides, false);
        History::new(frame, (&Arc::new(guides), &surfaces), new, past, 24.0, false)
    }

    /// Lengths of the histories of a picture after one of the plane, from these cameras, whose guides `change` alters.
    fn lengths(cameras: [[f32; 3]; 2], change: impl Fn(&mut Guide)) -> Vec<f32> {
        let [past, (frame, mut guides)] = cameras.map(on_a_plane);
        guides.iter_mut().for_each(change);
        let irradiance = vec![Vec3::ONE; 1200];
        let picture = |frame: &FrameUniforms, guides: Vec<Guide>, past: Option<(&History, &EarlierPoints)>| {
            let new = Samples { irradiance: &irradiance, count: 1.0 };
            history_of(frame, guides, new, past)
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

    /// A flat mirror shows the same part of the sky when the camera has moved, but for edges that come into sight. A ball shows
    /// another part.
    #[test]
    fn the_sky_in_curved_mirrors_has_no_past() {
        let text = "pathmarch 1\ncamera { position 0 0 6; target 0 0 0; fov 35 }\nsky 1\n\
            material \"mirror\" { metal 0.9; roughness 0 }\n\
            object \"ball\" material=\"mirror\" { sphere 1 { at -1.2 0 0 } }\n\
            object \"wall\" material=\"mirror\" { rect 2 { normal 0 0 1; at 1.2 0 0 } }";
        let scene = Scene::parse("test.kdl", text).expect("a scene");
        let mut past: Option<History> = None;
        for x in [0.0, 0.2] {
            let mut camera = scene.cameras[0].clone();
            camera.position[0] += x;
            camera.target[0] += x;
            let input =
                RenderInput::new(&scene, &Settings { size: [40, 30], viewpoint: Some(camera), ..Settings::of(&scene) });
            let pixels: Vec<(u32, u32)> = (0..30).flat_map(|y| (0..40).map(move |x| (x, y))).collect();
            let (_, guides) = input.sample_with_guides(&input.context(None), &pixels, 0);
            let irradiance = vec![Vec3::ONE; guides.len()];
            let new = Samples { irradiance: &irradiance, count: 1.0 };
            let still = EarlierPoints::default();
            let history = history_of(&input.frame, guides, new, past.as_ref().map(|past| (past, &still)));
            if past.is_some() {
                for (object, least, most) in [(NO_OBJECT, 0.85, 1.0), (0, 0.0, 0.05), (1, 0.85, 1.0)] {
                    let seen = history.guides.iter().zip(&history.means).filter(|(guide, _)| guide.object == object);
                    let lengths: Vec<f32> = seen.map(|(_, mean)| mean.length).collect();
                    let share = lengths.iter().filter(|length| **length > 1.0).count() as f32 / lengths.len() as f32;
                    assert!(lengths.len() > 80, "{} pixels of {object}", lengths.len());
                    assert!((least..=most).contains(&share), "{share} of {object}");
                }
            }
            past = Some(history);
        }
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
            past = Some((history_of(&frame, guides, new, last), truth));
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
    fn means_at_rest_are_those_of_their_own_pixels() {
        let mut past: Option<History> = None;
        let irradiance: Vec<Vec3> = (0..1200).map(|index| Vec3::splat((index % 7) as f32)).collect();
        for step in 0..6 {
            let (frame, mut guides) = on_a_plane([1.0, 2.0, 6.0]);
            // Samples are anywhere in their pixels.
            for (index, guide) in guides.iter_mut().enumerate() {
                let offset = [7 * step + index, 11 * step + 3 * index].map(|number| (number % 10) as f32 / 10.0 - 0.45);
                let ray =
                    central_ray(&frame, (index % 40) as f32 + 0.5 + offset[0], (index / 40) as f32 + 0.5 + offset[1]);
                guide.length = -ray.origin.z / ray.direction.z;
                guide.position = ray.origin + ray.direction * guide.length;
            }
            let earlier = EarlierPoints::default();
            let last = past.as_ref().map(|history| (history, &earlier));
            past = Some(history_of(&frame, guides, Samples { irradiance: &irradiance, count: 1.0 }, last));
        }
        for (mean, own) in past.expect("a picture").means.iter().zip(&irradiance) {
            let error = (mean.irradiance - *own).length();
            assert!(error < 1e-2 && mean.length > 2.9, "{error} after {} samples", mean.length);
        }
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
        let light = |light: f32| Means {
            irradiance: Vectors::splat(f32x8::splat(light)),
            length: f32x8::splat(4.0),
            moments: [light, light * light].map(f32x8::splat),
            before: [f32x8::ZERO; 2],
        };
        let after = |limit: f32, max_length: f32| {
            let found = Found { means: light(8.0), mask: f32x8::ZERO.simd_eq(f32x8::ZERO) };
            let limited = found.limited(Some([f32x8::splat(limit); 2]), f32x8::splat(max_length));
            let new = Means { length: f32x8::ONE, ..light(limit) };
            let [mean, ..] = limited.joined(new).each();
            (mean.irradiance.x, mean.length)
        };
        assert_eq!(after(8.0, 24.0), (8.0, 5.0));
        assert_eq!(after(8.0, 3.0), (8.0, 4.0));
        // Half as much light: a quarter of the samples.
        for limit in [4.0, 16.0] {
            let (light, length) = after(limit, 24.0);
            assert!((light - limit).abs() < 1e-5 && (length - 2.0).abs() < 1e-5, "{light} {length}");
        }
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
