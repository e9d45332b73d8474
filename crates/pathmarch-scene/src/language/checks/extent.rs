//! Limits of size and position, beyond which 32-bit numbers cannot represent a scene.
//!
//! Squares of lengths must be finite and not zero, and the bounds of the scene set the precision of tracing: one object
//! at 1e20 m would blacken all others. So every position is within [`MAX_METRES`] of the origin and every size above
//! [`MIN_METRES`]; anything else is a mistake.

use super::visible_nodes;
use crate::language::diagnostics::report::{Draft, Report, draft, shown};
use crate::language::tree::{Block, Node};
use crate::light::Light;
use crate::scene::Scene;
use pathmarch_field::Aabb;

/// The farthest coordinate from the origin, metres.
const MAX_METRES: f32 = 1e9;
/// The smallest size of an object and the smallest factor of its shapes, metres.
const MIN_METRES: f32 = 1e-9;

/// Reports whatever is too far away, too large or too small.
pub(crate) fn check(scene: &Scene, file: &Block, report: &mut Report) {
    for (node, camera) in visible_nodes(file, &["camera"]).zip(&scene.cameras) {
        for (what, place) in [("position", camera.position), ("target", camera.target)] {
            check_place(node, &format!("The {what} of the camera {}", shown(&camera.name)), place, report);
        }
    }
    let points = scene.lights.iter().filter_map(Light::position);
    for (node, place) in visible_nodes(file, &["point", "spot"]).zip(points) {
        check_place(node, &format!("This {} light", node.name.value), place, report);
    }
    // The first shape of each object that is out of range; without mistakes every visible object node has become an object.
    let mut bad = vec![None; scene.objects.len()];
    for leaf in scene.field.leaves() {
        let (scale, place) = (leaf.pose.scale, farthest(leaf.pose.at));
        // A range does not contain NaN.
        let fault = match () {
            () if !(0.0..=MAX_METRES).contains(&place) => Some(format!("has a shape {place:e} m from the origin")),
            () if !(MIN_METRES..=MAX_METRES).contains(&scale) => {
                Some(format!("has a shape that is scaled by {scale:e}"))
            }
            () => None,
        };
        let first = &mut bad[leaf.object as usize];
        *first = first.take().or(fault);
    }
    let bounds = scene.field.object_bounds().iter();
    for ((node, object), (bounds, fault)) in visible_nodes(file, &["object"]).zip(&scene.objects).zip(bounds.zip(bad)) {
        if let Some(fault) = fault.or_else(|| out_of_range(bounds)) {
            let mistake = out_of_range_mistake(node, format!("The object {} {fault}.", shown(&object.name)));
            report.add(mistake);
        }
    }
}

fn check_place(node: &Node, what: &str, place: [f32; 3], report: &mut Report) {
    let far = farthest(place);
    if far > MAX_METRES {
        report.add(out_of_range_mistake(node, format!("{what} is {far:e} m from the origin.")));
    }
}

/// The largest coordinate without its sign; NaN where one is.
fn farthest(place: [f32; 3]) -> f32 {
    place.iter().fold(0.0, |far: f32, v| if v.is_nan() { *v } else { far.max(v.abs()) })
}

/// Problem with the bounds of an object, if they are finite.
fn out_of_range(bounds: &Aabb) -> Option<String> {
    if !bounds.is_finite() || bounds.is_empty() {
        return None;
    }
    let far = farthest(bounds.min).max(farthest(bounds.max));
    let size = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]).fold(0.0, f32::max);
    match () {
        () if far > MAX_METRES => Some(format!("reaches {far:e} m from the origin")),
        () if size > 0.0 && size < MIN_METRES => Some(format!("is {size:e} m large")),
        () => None,
    }
}

fn out_of_range_mistake(node: &Node, message: String) -> Draft {
    let limits = format!(
        "Places are at most {MAX_METRES:e} m from the origin, sizes and factors from {MIN_METRES:e} to {MAX_METRES:e}."
    );
    draft("pathmarch::extent", node.name.span, message).label("beyond what 32-bit numbers can hold").help(limits)
}
