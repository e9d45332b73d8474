//! Points of surfaces to which dragged things are snapped.
//!
//! **Idea.** The ray through the pointer is intersected with the scene without the dragged node. The node is put there so
//! that it touches the plane through that point, across the surface's normal: its extent against the normal is found by
//! sphere tracing it from below on a grid of rays, or taken from its bounds if it is a part of an object.

use glam::{DVec3, Vec3};
use pathmarch_render::pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_render::pathmarch_field::{Aabb, Field};
use pathmarch_render::pathmarch_scene::document::{Document, Path};

/// Rays along each side of the grid; an odd number, so that one goes through the middle.
const RAYS: i32 = 15;
/// Most steps of a ray.
const STEPS: u32 = 48;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    /// Position, metres.
    pub(crate) position: DVec3,
    /// Origin of the dragged node with which it touches the surface there.
    pub(crate) touching: DVec3,
}

/// Extent of a node from its origin against a normal, metres; `None` if it is infinite.
pub(crate) fn extent_below(
    document: &Document,
    field: &Field,
    node: &Path,
    origin: DVec3,
    normal: DVec3,
) -> Option<f64> {
    let leaves = document.leaves_of(node);
    let bounds = leaves.iter().map(|leaf| field.declared_bounds(*leaf)).reduce(Aabb::union)?;
    if !bounds.is_finite() || bounds.is_empty() {
        return None;
    }
    let corner = |k: usize| {
        DVec3::from_array(
            [0, 1, 2].map(|axis| f64::from(if k >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] })),
        )
    };
    let of_bounds = (0..8).map(|k| (origin - corner(k)).dot(normal)).fold(f64::NEG_INFINITY, f64::max);
    let object = field.leaves().get(*leaves.first()?)?.object as usize;
    let is_whole = (0..)
        .zip(field.leaves())
        .all(|(k, leaf)| leaf.object as usize != object || leaves.contains(&field.declared_leaf(k)));
    if !is_whole {
        return Some(of_bounds);
    }
    // Towards the object from the plane that touches its bounds from below.
    let middle = 0.5 * (corner(0) + corner(7));
    let depth = 2.0 * (of_bounds - (origin - middle).dot(normal));
    let start = middle - normal * (0.5 * depth);
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    let half = [u, v].map(|axis| (0..8).map(|k| (corner(k) - middle).dot(axis)).fold(0.0, f64::max));
    let mut included = vec![false; field.object_bounds().len()];
    included[object] = true;
    let distance = |p: DVec3| {
        let p: Vec3 = p.as_vec3();
        f64::from(field.distance_to(FieldVec3::new(p.x, p.y, p.z), &included, -1.0))
    };
    let mut least = depth;
    for (i, j) in (0..RAYS).flat_map(|i| (0..RAYS).map(move |j| (i, j))) {
        let side = |k: i32| f64::from(2 * k - (RAYS - 1)) / f64::from(RAYS - 1);
        let from = start + u * (half[0] * side(i)) + v * (half[1] * side(j));
        let mut along = 0.0;
        for _ in 0..STEPS {
            if along >= least {
                break;
            }
            let step = distance(from + normal * along);
            along += step;
            if step < 1e-4 * depth {
                least = least.min(along);
                break;
            }
        }
    }
    // Nothing was met by a grid that is too coarse.
    Some(if least < depth { of_bounds - least } else { of_bounds })
}
