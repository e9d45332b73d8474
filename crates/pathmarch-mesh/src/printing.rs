//! Checks of a solid that is to be printed: thickness of its walls, and overhangs.
//!
//! **Idea.** A wall is measured by a ray from the middle of a triangle into the solid to the next surface that faces
//! the other way to within 45°; edges and tips, which become thin everywhere, do not count. An overhang faces down by
//! more than 45° and does not lie on the build plate, the lowest plane of the solid. **Cost.** That of a hierarchy, and
//! a ray for each triangle up to [`WALL_SAMPLES`].

use crate::bvh::{BuildError, Bvh, Ray};
use crate::report::WALL_SAMPLES;
use crate::triangle_mesh::TriangleMesh;
use glam::Vec3;
use rayon::prelude::*;

/// Share of the surface that may be thinner than [`PrintReport::thinnest_wall`]: triangles that are folded over at
/// sharp edges.
pub const THINNER_SHARE: f64 = 0.001;
/// Smallest cosine between the normals of one side of a wall and of the other, reversed.
const COSINE_OF_WALL: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// Sine of 45°, with a margin for the rounding of faces at exactly this angle.
const SINE_OF_OVERHANG: f64 = std::f64::consts::FRAC_1_SQRT_2 + 1e-3;
/// Height above the lowest point up to which a surface lies on the build plate, as a share of the diagonal.
const PLATE_SHARE: f32 = 1e-3;

/// What a printer must know of a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrintReport {
    /// Thickness of the thinnest wall, in units of the mesh, but for a thousandth of the surface; `None` without walls.
    pub thinnest_wall: Option<f32>,
    /// Share of the surface that overhangs by more than 45° and does not lie on the plate, from 0 to 1.
    pub overhang_share: f64,
}

impl PrintReport {
    /// Checks a closed mesh that is printed with this unit vector up.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn new(mesh: &TriangleMesh, up: Vec3) -> Result<Self, BuildError> {
        let bvh = Bvh::build(mesh)?;
        let step = mesh.triangles.len().div_ceil(WALL_SAMPLES).max(1);
        let walls = (0..mesh.triangles.len()).into_par_iter().step_by(step);
        let walls: Vec<(f32, f64)> = walls.filter_map(|triangle| wall(mesh, &bvh, triangle)).collect();
        Ok(Self { thinnest_wall: thinnest(walls), overhang_share: overhang_share(mesh, up) })
    }
}

/// Area and unit normal of a triangle; the normal is zero without an area.
fn area_and_normal(mesh: &TriangleMesh, triangle: usize) -> (f64, Vec3) {
    let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
    let cross = (b - a).cross(c - a);
    (0.5 * cross.length(), cross.normalize_or_zero().as_vec3())
}

/// Thickness of the wall at the middle of a triangle, and its area.
fn wall(mesh: &TriangleMesh, bvh: &Bvh, triangle: usize) -> Option<(f32, f64)> {
    let (area, normal) = area_and_normal(mesh, triangle);
    if normal == Vec3::ZERO {
        return None;
    }
    let [a, b, c] = mesh.corners(triangle);
    let middle = (a + b + c) / 3.0;
    // Beyond the rounding of coordinates, so that the triangle itself is not hit.
    let start = 4.0 * f32::EPSILON * middle.abs().max_element();
    let hit = bvh.intersect(&Ray { t_min: start, ..Ray::new(middle, -normal) })?;
    let (_, other) = area_and_normal(mesh, hit.triangle as usize);
    (hit.triangle as usize != triangle && -other.dot(normal) >= COSINE_OF_WALL).then_some((hit.t, area))
}

/// Thickness than which [`THINNER_SHARE`] of the area is thinner.
fn thinnest(mut walls: Vec<(f32, f64)>) -> Option<f32> {
    walls.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let total: f64 = walls.iter().map(|(_, area)| area).sum();
    let mut seen = 0.0;
    let passed = walls.iter().find(|(_, area)| {
        seen += area;
        seen > THINNER_SHARE * total
    });
    passed.map(|(thickness, _)| *thickness)
}

/// Share of the area that faces down by more than 45° and does not lie on the plate.
fn overhang_share(mesh: &TriangleMesh, up: Vec3) -> f64 {
    let height = |corner: Vec3| corner.dot(up);
    let lowest = mesh.positions.iter().map(|position| height(*position)).fold(f32::INFINITY, f32::min);
    let bounds = mesh.bounds();
    let plate = lowest + PLATE_SHARE * bounds.min.distance(bounds.max);
    let (mut overhanging, mut total) = (0.0, 0.0);
    for triangle in 0..mesh.triangles.len() {
        let (area, normal) = area_and_normal(mesh, triangle);
        let lies = mesh.corners(triangle).into_iter().all(|corner| height(corner) <= plate);
        if -f64::from(normal.dot(up)) > SINE_OF_OVERHANG && !lies {
            overhanging += area;
        }
        total += area;
    }
    if total > 0.0 { overhanging / total } else { 0.0 }
}
