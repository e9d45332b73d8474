//! Plain algorithms in 64 bits that the fast ones are compared with.

use glam::{DVec3, Vec3};
use pathmarch_mesh::TriangleMesh;
use pathmarch_mesh::bvh::Ray;

/// Corners of all triangles.
fn triangles(mesh: &TriangleMesh) -> impl Iterator<Item = [DVec3; 3]> {
    (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle).map(Vec3::as_dvec3))
}

/// Distance of a point to the nearest triangle, of all.
pub fn exact_distance(mesh: &TriangleMesh, p: Vec3) -> f64 {
    let p = p.as_dvec3();
    triangles(mesh).map(|corners| distance_to_triangle(corners, p)).fold(f64::INFINITY, f64::min)
}

fn distance_to_triangle([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let is_left = |from: DVec3, to: DVec3| normal.cross(to - from).dot(p - from) >= 0.0;
    if normal != DVec3::ZERO && is_left(a, b) && is_left(b, c) && is_left(c, a) {
        return (p - a).dot(normal).abs() / normal.length();
    }
    let to_segment = |from: DVec3, to: DVec3| {
        let along = to - from;
        let t =
            if along == DVec3::ZERO { 0.0 } else { ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0) };
        p.distance(from + t * along)
    };
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}

/// Sum of the solid angles of all triangles over 4 pi.
pub fn exact_winding_number(mesh: &TriangleMesh, p: Vec3) -> f64 {
    let p = p.as_dvec3();
    let angle = |corners: [DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - p);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        2.0 * a.dot(b.cross(c)).atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
    };
    triangles(mesh).map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Parameter of the closest hit of a ray with any triangle (Möller and Trumbore 1997).
pub fn exact_hit(mesh: &TriangleMesh, ray: &Ray) -> Option<f64> {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let hit = |[a, b, c]: [DVec3; 3]| {
        let (ab, ac, from) = (b - a, c - a, origin - a);
        let side = direction.cross(ac);
        let determinant = ab.dot(side);
        let u = from.dot(side) / determinant;
        let other = from.cross(ab);
        let v = direction.dot(other) / determinant;
        let t = ac.dot(other) / determinant;
        let is_hit = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > f64::from(ray.t_min) && t < f64::from(ray.t_max);
        is_hit.then_some(t)
    };
    triangles(mesh).filter_map(hit).min_by(f64::total_cmp)
}
