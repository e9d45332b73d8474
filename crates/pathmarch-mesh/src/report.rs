//! Checks of a mesh that becomes a distance field or a solid.
//!
//! **Idea.** Edges are counted by the triangles on either side: an edge with one is the border of a hole, one with more than two is
//! not manifold, and one that two run along in the same direction lies between a flipped triangle and its neighbour. A
//! wall is measured by a ray from the middle of a triangle into the solid: the next surface that faces the other way is its other
//! side. **Cost.** That of a hierarchy, and a ray for each triangle up to [`WALL_SAMPLES`].

use crate::bvh::{BuildError, Bvh, Ray};
use crate::topology::Welded;
use crate::triangle_mesh::TriangleMesh;
use glam::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;
use std::fmt;

/// Most triangles whose walls are measured; of larger meshes every second, third and so on.
pub const WALL_SAMPLES: usize = 200_000;

/// What stands between a mesh and a good distance field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeshReport {
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Edges with a triangle on one side only: borders of holes.
    pub boundary_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges between a triangle and one that is flipped against it.
    pub flipped_edges: usize,
    /// Triangles with the same corners as another.
    pub duplicate_triangles: usize,
    /// Triangles without area.
    pub degenerate_triangles: usize,
    /// Triangles on walls that are thinner than `thinnest_wall`, of those measured.
    pub thin_triangles: usize,
    /// Triangles whose walls were measured.
    pub measured_triangles: usize,
    /// Thickness below which a wall is thin: two voxels.
    pub thinnest_wall: f32,
    /// Least thickness found; infinite if there is none.
    pub least_thickness: f32,
}

impl MeshReport {
    /// Checks a mesh for a grid with voxels of a given edge.
    ///
    /// # Errors
    /// [`BuildError`].
    pub fn new(mesh: &TriangleMesh, voxel: f32) -> Result<Self, BuildError> {
        let bvh = Bvh::build(mesh)?;
        let welded = Welded::new(mesh);
        let mut report = Self { triangles: mesh.triangles.len(), thinnest_wall: 2.0 * voxel, ..Self::default() };
        report.count_edges(&welded);
        report.duplicate_triangles = duplicates(&welded);
        report.degenerate_triangles =
            (0..mesh.triangles.len()).filter(|&triangle| is_degenerate(mesh, triangle)).count();
        report.measure_walls(mesh, &bvh);
        Ok(report)
    }

    /// Reports a mesh without any of these.
    pub fn is_clean(&self) -> bool {
        self.boundary_edges
            + self.non_manifold_edges
            + self.flipped_edges
            + self.duplicate_triangles
            + self.degenerate_triangles
            + self.thin_triangles
            == 0
    }

    fn count_edges(&mut self, welded: &Welded) {
        for edge in welded.edges() {
            match (edge.forward, edge.backward) {
                (1, 1) => {}
                (1, 0) | (0, 1) => self.boundary_edges += 1,
                (2, 0) | (0, 2) => self.flipped_edges += 1,
                _ => self.non_manifold_edges += 1,
            }
        }
    }

    fn measure_walls(&mut self, mesh: &TriangleMesh, bvh: &Bvh) {
        let step = mesh.triangles.len().div_ceil(WALL_SAMPLES).max(1);
        let thicknesses: Vec<f32> = (0..mesh.triangles.len())
            .into_par_iter()
            .step_by(step)
            .map(|triangle| thickness(mesh, bvh, triangle, 2.0 * self.thinnest_wall))
            .collect();
        self.measured_triangles = thicknesses.len();
        self.thin_triangles = thicknesses.iter().filter(|thickness| **thickness < self.thinnest_wall).count();
        self.least_thickness = thicknesses.into_iter().fold(f32::INFINITY, f32::min);
    }
}

/// Triangles that another one with the same corners, in any order, precedes.
fn duplicates(welded: &Welded) -> usize {
    let mut seen: HashMap<[u32; 3], ()> = HashMap::with_capacity(welded.triangles.len());
    let is_repeated = |triangle: &&[u32; 3]| {
        let mut corners = **triangle;
        corners.sort_unstable();
        seen.insert(corners, ()).is_some()
    };
    welded.triangles.iter().filter(is_repeated).count()
}

fn is_degenerate(mesh: &TriangleMesh, triangle: usize) -> bool {
    let [a, b, c] = mesh.corners(triangle).map(Vec3::as_dvec3);
    (b - a).cross(c - a).length_squared() == 0.0
}

/// Distance from the middle of a triangle into the solid to the next surface that faces the other way; infinite beyond a limit.
fn thickness(mesh: &TriangleMesh, bvh: &Bvh, triangle: usize, limit: f32) -> f32 {
    let normal_of = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let (normal, [a, b, c]) = (normal_of(triangle), mesh.corners(triangle));
    if normal == Vec3::ZERO {
        return f32::INFINITY;
    }
    let middle = (a + b + c) / 3.0;
    // Beyond the rounding of coordinates, so that the triangle itself is not hit.
    let start = 4.0 * f32::EPSILON * middle.abs().max_element();
    let ray = Ray { t_min: start, t_max: limit, ..Ray::new(middle, -normal) };
    let other = bvh.intersect(&ray).filter(|hit| hit.triangle as usize != triangle);
    other.filter(|hit| normal_of(hit.triangle as usize).dot(normal) < 0.0).map_or(f32::INFINITY, |hit| hit.t)
}

impl fmt::Display for MeshReport {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.is_clean() {
            return write!(f, "{} triangles, closed and manifold, no wall thinner than two voxels", self.triangles);
        }
        write!(f, "{} triangles", self.triangles)?;
        let lines = [
            (self.boundary_edges, "edges at holes; the field closes each hole with a fan"),
            (self.non_manifold_edges, "edges with more than two triangles"),
            (self.flipped_edges, "edges beside a flipped triangle; the field counts it the right way round"),
            (self.duplicate_triangles, "triangles that are there twice"),
            (self.degenerate_triangles, "triangles without area"),
        ];
        for (count, what) in lines.into_iter().filter(|(count, _)| *count > 0) {
            write!(f, "\n{count} {what}")?;
        }
        if self.thin_triangles > 0 {
            let Self { thin_triangles, measured_triangles, thinnest_wall, least_thickness, .. } = self;
            write!(
                f,
                "\n{thin_triangles} of {measured_triangles} triangles on walls thinner than two voxels ({thinnest_wall:.3}), \
                 down to {least_thickness:.3}; raise the resolution"
            )?;
        }
        Ok(())
    }
}
