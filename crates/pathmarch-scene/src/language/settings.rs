//! Cameras, render settings and lights.

use super::arguments::{arguments, name, no_children, properties, twice};
use super::report::{Report, draft, shown};
use super::schema::{Braces, CAMERA, LENS, POINT, Properties, RENDER, SUN};
use super::tree::{Node, Span};
use crate::render_settings::{Caustics, RenderSettings, Sampler, Tonemap};
use crate::scene::{Camera, Light};
use glam::DVec3;
use std::collections::HashMap;

/// Sine of the angle below which two directions are parallel: a view that f32 cannot hold upright.
const PARALLEL: f64 = 1e-5;

/// A camera; `None` after a mistake. `seen` holds the names of those before it.
pub(crate) fn camera(node: &Node, seen: &mut HashMap<String, Span>, report: &mut Report) -> Option<Camera> {
    let given = name(node, "`camera \"name\" { … }`", report);
    let unnamed = node.entries.iter().all(|entry| entry.name.is_some());
    let (camera_name, name_span) = given.unwrap_or(("main", node.name.span));
    match seen.get(camera_name) {
        _ if given.is_none() && !unnamed => {}
        Some(&first) => twice(&format!("The camera {}", shown(camera_name)), name_span, first, report),
        None => drop(seen.insert(camera_name.to_owned(), name_span)),
    }
    properties(node, &[], report);
    let settings = Braces::new(node, CAMERA, "in a camera", report);
    let position = settings.triple("position", report);
    let target = settings.triple("target", report);
    let up = settings.triple("up", report);
    let fov = settings.number("fov", report);
    let exposure = settings.number("exposure", report);
    let (lens_radius, focus) = settings.get("lens").map_or((Some(0.0), None), |lens| self::lens(lens, report));
    let (position, target, up) = (position?, target?, up?);
    let view = (DVec3::from_array(target.map(f64::from)) - DVec3::from_array(position.map(f64::from))).try_normalize();
    let span = |word: &str| settings.get(word).map_or(node.name.span, Node::span);
    match view {
        None => report.add(
            draft("pathmarch::no_direction", span("target"), "The camera looks at the point where it stands.")
                .label("the same as `position`")
                .also(span("position"), "this point"),
        ),
        Some(view) if view.cross(DVec3::from_array(up.map(f64::from)).normalize_or_zero()).length() < PARALLEL => {
            report.add(
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
        exposure: exposure?,
    })
}

fn lens(node: &Node, report: &mut Report) -> (Option<f32>, Option<f32>) {
    arguments(node, 0, "`lens radius=0.05 focus=6`", report);
    no_children(node, report);
    let properties = Properties::new(node, LENS, report);
    (properties.number("radius", report), properties.number("focus", report))
}

/// The render settings; `None` after a mistake.
pub(crate) fn render(node: &Node, report: &mut Report) -> Option<RenderSettings> {
    arguments(node, 0, "`render { … }`", report);
    properties(node, &[], report);
    let settings = Braces::new(node, RENDER, "in `render`", report);
    let size = settings.size("size", report);
    let samples = settings.whole("samples", report);
    let bounces = settings.whole("bounces", report);
    let tonemap = settings.choice("tonemap", "tone mapping", &Tonemap::ALL, Tonemap::name, report);
    let sampler = settings.choice("sampler", "sampler", &Sampler::ALL, Sampler::name, report);
    let caustics = settings.choice("caustics", "kind of caustics", &Caustics::ALL, Caustics::name, report);
    let clamp = settings.number("clamp", report);
    let detail = settings.number("detail", report);
    let fps = settings.number("fps", report);
    let shutter = settings.number("shutter", report);
    Some(RenderSettings {
        size: size?.into(),
        samples: samples?,
        bounces: bounces?,
        tonemap: tonemap?,
        sampler: sampler?,
        caustics: caustics?,
        clamp,
        detail: detail?,
        fps: fps?,
        shutter: shutter?,
    })
}

/// A sun; `None` after a mistake.
pub(crate) fn sun(node: &Node, report: &mut Report) -> Option<Light> {
    arguments(node, 0, "`sun { … }`", report);
    properties(node, &[], report);
    let settings = Braces::new(node, SUN, "in a sun", report);
    let direction = settings.triple("direction", report);
    let irradiance = settings.colour("irradiance", report);
    let angle = settings.number("angle", report);
    let penumbra = settings.number("penumbra", report);
    Some(Light::Sun { direction: direction?, irradiance: irradiance?, angle: angle?, penumbra })
}

/// A point light; `None` after a mistake.
pub(crate) fn point(node: &Node, report: &mut Report) -> Option<Light> {
    arguments(node, 0, "`point { … }`", report);
    properties(node, &[], report);
    let settings = Braces::new(node, POINT, "in a point light", report);
    let at = settings.triple("at", report);
    let intensity = settings.colour("intensity", report);
    let penumbra = settings.number("penumbra", report);
    Some(Light::Point { at: at?, intensity: intensity?, penumbra })
}
