//! Triangulation of polygons.
//!
//! **Idea.** A convex polygon is a fan. From others, ears are cut: corners whose triangle contains no other vertex (Meisters
//! 1975), in the plane of the polygon's mean normal. **Limits.** Polygons with more than [`MAX_EARS`] corners, and those that
//! cross themselves, become fans. **Cost.** Quadratic in the corners of a concave polygon.

use glam::{DVec2, DVec3, Vec3};

/// Largest number of corners of which ears are cut.
const MAX_EARS: usize = 256;

/// Triangles of a polygon, as indices of its corners, with its orientation. Fewer than three corners have none.
pub(super) fn triangulate(corners: &[Vec3], mut triangle: impl FnMut([usize; 3])) {
    let count = corners.len();
    if count <= 3 || count > MAX_EARS {
        return fan(&(0..count).collect::<Vec<_>>(), triangle);
    }
    let flat = flattened(corners);
    let turn = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[b]);
    let is_convex = (0..count).all(|k| turn([k, (k + 1) % count, (k + 2) % count]) >= 0.0);
    let mut rest: Vec<usize> = (0..count).collect();
    if is_convex {
        return fan(&rest, triangle);
    }
    let (mut place, mut failures) = (0, 0);
    while rest.len() > 3 && failures < rest.len() {
        let length = rest.len();
        let ear = [rest[(place + length - 1) % length], rest[place % length], rest[(place + 1) % length]];
        if turn(ear) > 0.0 && !rest.iter().any(|&v| is_inside(ear.map(|corner| flat[corner]), flat[v])) {
            triangle(ear);
            rest.remove(place % length);
            failures = 0;
        } else {
            failures += 1;
        }
        place = (place + 1) % rest.len();
    }
    fan(&rest, triangle);
}

fn fan(corners: &[usize], mut triangle: impl FnMut([usize; 3])) {
    for k in 2..corners.len() {
        triangle([corners[0], corners[k - 1], corners[k]]);
    }
}

/// Corners in the plane of the mean normal (Newell), in which the polygon runs anticlockwise.
fn flattened(corners: &[Vec3]) -> Vec<DVec2> {
    let corner = |k: usize| corners[k % corners.len()].as_dvec3() - corners[0].as_dvec3();
    let normal: DVec3 = (0..corners.len()).map(|k| corner(k).cross(corner(k + 1))).sum();
    let normal = normal.try_normalize().unwrap_or(DVec3::Z);
    let (x, y) = normal.any_orthonormal_pair();
    (0..corners.len()).map(|k| DVec2::new(corner(k).dot(x), corner(k).dot(y))).collect()
}

/// Reports a point in a triangle or on its border, unless it is a corner.
fn is_inside([a, b, c]: [DVec2; 3], p: DVec2) -> bool {
    let is_left = |from: DVec2, to: DVec2| (to - from).perp_dot(p - from) >= 0.0;
    p != a && p != b && p != c && is_left(a, b) && is_left(b, c) && is_left(c, a)
}
