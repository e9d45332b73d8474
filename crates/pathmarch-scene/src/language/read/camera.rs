//! Cameras.

use super::arguments::{arguments, name, no_children, properties, twice};
use super::context::Context;
use super::settings::{Braces, Properties};
use crate::language::diagnostics::report::{draft, shown};
use crate::language::tree::{Node, Span};
use crate::scene::Camera;
use crate::settings::{CAMERA, LENS};
use glam::DVec3;
use std::collections::HashMap;

/// Sine of the angle below which two directions count as parallel: f32 cannot represent an upright view.
const PARALLEL: f64 = 1e-5;

/// Reads a camera; `None` after a mistake. `seen` has the names of those before it.
pub(crate) fn camera(node: &Node, seen: &mut HashMap<String, Span>, context: &mut Context) -> Option<Camera> {
    let given = name(node, "`camera \"name\" { … }`", context);
    let unnamed = node.entries.iter().all(|entry| entry.name.is_some());
    let (camera_name, name_span) = given.unwrap_or(("main", node.name.span));
    match seen.get(camera_name) {
        _ if given.is_none() && !unnamed => {}
        Some(&first) => twice(&format!("The camera {}", shown(camera_name)), name_span, first, context),
        None => drop(seen.insert(camera_name.to_owned(), name_span)),
    }
    properties(node, &[], context);
    let settings = Braces::new(node, CAMERA, "in a camera", context);
    let position = settings.triple("position", context);
    let target = settings.triple("target", context);
    let up = settings.triple("up", context);
    let fov = settings.number("fov", context);
    let exposure = settings.number_or_auto("exposure", context);
    let (lens_radius, focus) = settings.get("lens").map_or((Some(0.0), None), |lens| self::lens(lens, context));
    let (position, target, up) = (position?, target?, up?);
    let view = (DVec3::from_array(target.map(f64::from)) - DVec3::from_array(position.map(f64::from))).try_normalize();
    let span = |word: &str| settings.get(word).map_or(node.name.span, Node::span);
    match view {
        None => context.report.add(
            draft("pathmarch::no_direction", span("target"), "The `target` of the camera equals its `position`.")
                .label("the same as `position`")
                .also(span("position"), "this point"),
        ),
        Some(view) if view.cross(DVec3::from_array(up.map(f64::from)).normalize_or_zero()).length() < PARALLEL => {
            context.report.add(
                draft("pathmarch::no_direction", span("up"), "The camera looks along its own `up`.")
                    .label("parallel to the view")
                    .help("Give it another `up` (0 1 0 when absent), such as up 0 0 -1 for a view straight down."),
            );
        }
        Some(_) => {}
    }
    Some(Camera {
        name: camera_name.to_owned(),
        position,
        target,
        up,
        fov: fov?,
        lens_radius: lens_radius?,
        focus,
        exposure: exposure?.unwrap_or(0.0),
        auto_exposure: exposure?.is_none(),
    })
}

fn lens(node: &Node, context: &mut Context) -> (Option<f32>, Option<f32>) {
    arguments(node, 0, "`lens radius=0.05 focus=6`", context);
    no_children(node, context);
    let properties = Properties::new(node, LENS, context);
    (properties.number("radius", context), properties.number("focus", context))
}
