//! Cameras, render settings and lights.

use super::arguments::{
    Range, Settings, arguments, choice, colour, direction, in_range, name, no_children, numbers, properties, twice,
    whole_numbers,
};
use super::names::{CAMERA, POINT, RENDER, SUN};
use super::report::{Report, draft, shown};
use super::tree::{Node, Span};
use crate::atmosphere::SUN_ANGLE;
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
    let settings = Settings::new(node, CAMERA, "in a camera", report);
    let point = |word: &str, example: &str, report: &mut Report| -> Option<[f32; 3]> {
        let usage = format!("`{word} x y z`");
        numbers(settings.require(word, example, node, report)?, &usage, Range::ANY, report)
    };
    let position = point("position", "position 0 1.5 6", report);
    let target = point("target", "target 0 1 0", report);
    let up = settings.get("up").map_or(Some([0.0, 1.0, 0.0]), |up| direction(up, report));
    let fov = settings.get("fov").and_then(|fov| numbers(fov, "`fov 40`", Range::between(0.0, 180.0), report));
    let exposure = settings.get("exposure").and_then(|stops| {
        let range = Range::from_to(-100.0, 100.0);
        numbers(stops, "`exposure 0`", range, report)
    });
    let (lens_radius, focus) = settings.get("lens").map_or((0.0, None), |lens| self::lens(lens, report));
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
        fov: fov.map_or(40.0, |[fov]| fov),
        lens_radius,
        focus,
        exposure: exposure.map_or(0.0, |[stops]| stops),
    })
}

fn lens(node: &Node, report: &mut Report) -> (f32, Option<f32>) {
    arguments(node, 0, "`lens radius=0.05 focus=6`", report);
    no_children(node, report);
    let (mut radius, mut focus) = (0.0, None);
    for (word, entry) in properties(node, &["radius", "focus"], report) {
        if word == "radius" {
            radius = in_range(entry, "`radius`", Range::NOT_NEGATIVE, report).unwrap_or(0.0);
        } else {
            focus = in_range(entry, "`focus`", Range::POSITIVE, report);
        }
    }
    (radius, focus)
}

/// The render settings; defaults for what is wrong or absent.
pub(crate) fn render(node: &Node, report: &mut Report) -> RenderSettings {
    arguments(node, 0, "`render { … }`", report);
    properties(node, &[], report);
    let settings = Settings::new(node, RENDER, "in `render`", report);
    let mut render = RenderSettings::default();
    if let Some(size) = settings.get("size")
        && let Some([width, height]) = whole_numbers(size, "`size 1280 720`", (1, 16384), report)
    {
        render.size = (width, height);
    }
    if let Some(samples) = settings.get("samples")
        && let Some([samples]) = whole_numbers(samples, "`samples 256`", (1, 1_000_000), report)
    {
        render.samples = samples;
    }
    if let Some(bounces) = settings.get("bounces")
        && let Some([bounces]) = whole_numbers(bounces, "`bounces 4`", (0, 64), report)
    {
        render.bounces = bounces;
    }
    if let Some(node) = settings.get("tonemap")
        && let Some(tonemap) = choice(node, "tone mapping", &Tonemap::ALL, Tonemap::name, report)
    {
        render.tonemap = tonemap;
    }
    if let Some(node) = settings.get("sampler")
        && let Some(sampler) = choice(node, "sampler", &Sampler::ALL, Sampler::name, report)
    {
        render.sampler = sampler;
    }
    if let Some(node) = settings.get("caustics")
        && let Some(caustics) = choice(node, "kind of caustics", &Caustics::ALL, Caustics::name, report)
    {
        render.caustics = caustics;
    }
    if let Some(node) = settings.get("clamp")
        && let Some([clamp]) = numbers(node, "`clamp 10`", Range::POSITIVE, report)
    {
        render.clamp = Some(clamp);
    }
    render
}

/// Sharpness of soft shadows; `None` without a node, or after a mistake.
fn penumbra(settings: &Settings, report: &mut Report) -> Option<f32> {
    numbers(settings.get("penumbra")?, "`penumbra 16`", Range::POSITIVE, report).map(|[penumbra]| penumbra)
}

/// A sun; `None` after a mistake.
pub(crate) fn sun(node: &Node, report: &mut Report) -> Option<Light> {
    arguments(node, 0, "`sun { … }`", report);
    properties(node, &[], report);
    let settings = Settings::new(node, SUN, "in a sun", report);
    let towards = settings.require("direction", "direction 0.3 0.8 0.5", node, report);
    let towards = towards.and_then(|towards| direction(towards, report));
    let irradiance = settings.require("irradiance", "irradiance 3 2.9 2.7", node, report);
    let irradiance = irradiance.and_then(|node| colour(node, Range::NOT_NEGATIVE, report));
    let angle = match settings.get("angle") {
        Some(angle) => numbers(angle, "`angle 0.53`", Range::from_to(0.0, 180.0), report),
        None => Some([SUN_ANGLE]),
    };
    let penumbra = penumbra(&settings, report);
    Some(Light::Sun { direction: towards?, irradiance: irradiance?, angle: angle?[0], penumbra })
}

/// A point light; `None` after a mistake.
pub(crate) fn point(node: &Node, report: &mut Report) -> Option<Light> {
    arguments(node, 0, "`point { … }`", report);
    properties(node, &[], report);
    let settings = Settings::new(node, POINT, "in a point light", report);
    let at = settings.require("at", "at 4 6 4", node, report);
    let at = at.and_then(|at| numbers(at, "`at x y z`", Range::ANY, report));
    let intensity = settings.require("intensity", "intensity 60", node, report);
    let intensity = intensity.and_then(|node| colour(node, Range::NOT_NEGATIVE, report));
    let penumbra = penumbra(&settings, report);
    Some(Light::Point { at: at?, intensity: intensity?, penumbra })
}
