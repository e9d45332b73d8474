//! `pathmarch-measure rays`: rays through meshes against a test of every triangle in 64 bits.
//!
//! Rays start at random points of a box around the mesh, in random directions, and half of them point at vertices and edges, where
//! hierarchies lose rays if they do. A ray is *lost* if the plain test hits and the hierarchy does not, or beyond. Silhouettes are left
//! out, where a ray beside it gets as far: rounding decides there. Cost: that of the plain test, 5 nanoseconds
//! for each ray and triangle.

use glam::{DVec3, Vec3};
use pathmarch_cli::{DONE, FAILED, Failure, note, outln};
use pathmarch_mesh::bvh::Ray;
use pathmarch_mesh::{Bvh, ReadOptions, TriangleMesh};
use rayon::prelude::*;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Mesh files
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Number of rays for each file
    #[arg(long, default_value_t = 10_000_000)]
    rays: u64,
}

/// Largest difference of two hits, as a share of the mesh's size.
const TOLERANCE: f64 = 1e-4;
/// Number of rays beside one, and their distance from it, as a share of the mesh's size.
const BESIDE: u32 = 16;
const OFFSET: f32 = 2e-6;

/// Rays of which the hierarchy and the plain test differ.
#[derive(Clone, Copy, Default)]
struct Counts {
    hits: u64,
    /// The plain test hits; the hierarchy does not, or beyond.
    lost: u64,
    /// The hierarchy hits; the plain test does not, as on an edge, or beyond.
    only_found: u64,
}

impl Counts {
    fn add(self, other: Self) -> Self {
        Self {
            hits: self.hits + other.hits,
            lost: self.lost + other.lost,
            only_found: self.only_found + other.only_found,
        }
    }
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let mut lost = 0;
    for file in &arguments.files {
        let imported =
            pathmarch_mesh::read(file, &ReadOptions::default()).map_err(|e| Failure::Usage(e.to_string()))?;
        let mesh = imported.merged(usize::MAX).map_err(|e| Failure::Usage(e.to_string()))?;
        let bvh = Bvh::build(&mesh).map_err(|e| Failure::Usage(e.to_string()))?;
        note!("{}: {} triangles, {} rays", file.display(), mesh.triangles.len(), arguments.rays);
        let counts = trace(&mesh, &bvh, arguments.rays);
        outln!(
            "{}: {} rays, {} hits, {} lost, {} on edges that only the hierarchy hits",
            file.display(),
            arguments.rays,
            counts.hits,
            counts.lost,
            counts.only_found
        );
        lost += counts.lost;
    }
    Ok(if lost == 0 { DONE } else { FAILED })
}

fn trace(mesh: &TriangleMesh, bvh: &Bvh, rays: u64) -> Counts {
    let corners: Vec<[DVec3; 3]> =
        (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle).map(Vec3::as_dvec3)).collect();
    let size = f64::from(mesh.bounds().size().max_element());
    let count = |index: u64| {
        let ray = ray(mesh, index);
        let (found, exact) = (bvh.intersect(&ray).map(|hit| f64::from(hit.t)), exact_hit(&corners, &ray));
        let tolerance = TOLERANCE * size;
        let is_beyond = |a: Option<f64>, b: Option<f64>| b.is_some_and(|b| a.is_none_or(|a| a > b + tolerance));
        Counts {
            hits: u64::from(found.is_some()),
            lost: u64::from(is_beyond(found, exact) && !is_passed_beside(found, &corners, &ray, size)),
            only_found: u64::from(is_beyond(exact, found)),
        }
    };
    (0..rays).into_par_iter().map(count).reduce(Counts::default, Counts::add)
}

/// Reports whether some ray beside this one gets as far as this hit, or misses if it is `None`.
fn is_passed_beside(found: Option<f64>, corners: &[[DVec3; 3]], ray: &Ray, size: f64) -> bool {
    let (x, y) = ray.direction.any_orthonormal_pair();
    (0..BESIDE).any(|index| {
        let (sin, cos) = (index as f32 * std::f32::consts::TAU / BESIDE as f32).sin_cos();
        let origin = ray.origin + (x * cos + y * sin) * (OFFSET * size as f32);
        let exact = exact_hit(corners, &Ray { origin, ..*ray });
        exact.is_none_or(|exact| found.is_some_and(|found| exact + TOLERANCE * size > found))
    })
}

/// Ray of an index: a unit direction from a random point, every other one towards a vertex or an edge.
fn ray(mesh: &TriangleMesh, index: u64) -> Ray {
    let mut state = index;
    let mut random = || {
        // SplitMix64 (Steele et al. 2014).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let a = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let b = (a ^ (a >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((b ^ (b >> 31)) >> 40) as f32 / 16_777_216.0
    };
    let bounds = mesh.bounds();
    let mut in_box = || bounds.min + bounds.size() * (Vec3::new(random(), random(), random()) * 1.4 - 0.2);
    let (origin, other) = (in_box(), in_box());
    let target = if index.is_multiple_of(2) {
        other
    } else {
        let triangle = ((random() * mesh.triangles.len() as f32) as usize).min(mesh.triangles.len() - 1);
        let [a, b, _] = mesh.corners(triangle);
        if index % 4 == 1 { a } else { a.lerp(b, random()) }
    };
    Ray::new(origin, (target - origin).normalize_or(Vec3::X))
}

/// Parameter of the closest hit with any triangle (Möller and Trumbore 1997).
fn exact_hit(corners: &[[DVec3; 3]], ray: &Ray) -> Option<f64> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let mut nearest = f64::INFINITY;
    for [a, b, c] in corners {
        let (ab, ac, from) = (*b - *a, *c - *a, origin - *a);
        let side = direction.cross(ac);
        let inverse = 1.0 / ab.dot(side);
        let u = from.dot(side) * inverse;
        let other = from.cross(ab);
        let v = direction.dot(other) * inverse;
        let t = ac.dot(other) * inverse;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < nearest {
            nearest = t;
        }
    }
    (nearest < f64::INFINITY).then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_ray_through_the_cow_is_lost() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../pathmarch-mesh/tests/data/spot.obj");
        let imported = pathmarch_mesh::read(file.as_ref(), &ReadOptions::default()).expect("a mesh");
        let mesh = imported.merged(usize::MAX).expect("a mesh");
        let counts = trace(&mesh, &Bvh::build(&mesh).expect("a hierarchy"), 20_000);
        assert!(counts.hits > 5000 && counts.lost == 0, "{} hits, {} lost", counts.hits, counts.lost);
    }
}
