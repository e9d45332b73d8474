//! Suns, point lights and spot lights.

use super::arguments::arguments;
use super::context::Context;
use super::settings::{Braces, Properties};
use crate::language::diagnostics::report::draft;
use crate::language::tree::Node;
use crate::light::{LUMENS_OF_WATT, Light, spot_cosines};
use crate::settings::{POINT, SPOT, SUN, VISIBILITY};
use crate::unit::LengthUnit;
use glam::DVec3;
use std::f32::consts::PI;

/// A sun; `None` after a mistake, and of a hidden one.
pub(crate) fn sun(node: &Node, context: &mut Context) -> Option<Light> {
    arguments(node, 0, "`sun { … }`", context);
    let hidden = Properties::new(node, VISIBILITY, context).flag("hidden", context);
    let settings = Braces::new(node, SUN, "in a sun", context);
    let direction = settings.triple("direction", context);
    let irradiance = settings.colour("irradiance", context);
    let angle = settings.number("angle", context);
    let penumbra = settings.number("penumbra", context);
    let sun = Light::Sun { direction: direction?, irradiance: irradiance?, angle: angle?, penumbra };
    (!hidden).then_some(sun)
}

/// A point light; `None` after a mistake, and of a hidden one.
pub(crate) fn point(node: &Node, unit: LengthUnit, context: &mut Context) -> Option<Light> {
    arguments(node, 0, "`point { … }`", context);
    let hidden = Properties::new(node, VISIBILITY, context).flag("hidden", context);
    let settings = Braces::new(node, POINT, "in a point light", context);
    let at = settings.triple("at", context);
    let intensity = intensity(&settings, 4.0 * PI, unit, context);
    let penumbra = settings.number("penumbra", context);
    let point = Light::Point { at: at?, intensity: intensity?, penumbra };
    (!hidden).then_some(point)
}

/// A spot light; `None` after a mistake, and of a hidden one.
pub(crate) fn spot(node: &Node, unit: LengthUnit, context: &mut Context) -> Option<Light> {
    arguments(node, 0, "`spot { … }`", context);
    let hidden = Properties::new(node, VISIBILITY, context).flag("hidden", context);
    let settings = Braces::new(node, SPOT, "in a spot light", context);
    let at = settings.triple("at", context);
    let target = settings.triple("target", context);
    let cone = settings.number("cone", context);
    let blend = settings.number("blend", context);
    let solid_angle = cone.zip(blend).map_or(PI, |(cone, blend)| spot_solid_angle(cone, blend));
    let intensity = intensity(&settings, solid_angle, unit, context);
    let penumbra = settings.number("penumbra", context);
    let (at, target) = (at?, target?);
    let direction = (DVec3::from_array(target.map(f64::from)) - DVec3::from_array(at.map(f64::from))).try_normalize();
    let Some(direction) = direction else {
        let span = settings.get("target").map_or(node.name.span, Node::span);
        let mistake = draft("pathmarch::no_direction", span, "The `target` of the spot light equals its position.");
        context.report.add(mistake.label("the same as `at`").help("Give it a point in the middle of its light."));
        return None;
    };
    let direction = direction.as_vec3().into();
    let spot = Light::Spot { at, direction, intensity: intensity?, cone: cone?, blend: blend?, penumbra };
    (!hidden).then_some(spot)
}

/// Integral of the falloff of a spot light over all directions, sr.
fn spot_solid_angle(cone: f32, blend: f32) -> f32 {
    let [outer, inner] = spot_cosines(cone, blend);
    // The mean of a smoothstep is a half.
    2.0 * PI * ((1.0 - inner) + 0.5 * (inner - outer))
}

/// Radiant intensity from `intensity`, `candela` or `lumen`, of which there is one. `solid_angle`, sr, is that of the light
/// with its largest intensity.
fn intensity(settings: &Braces, solid_angle: f32, unit: LengthUnit, context: &mut Context) -> Option<[f32; 3]> {
    let given: Vec<&Node> = ["intensity", "candela", "lumen"].iter().filter_map(|word| settings.get(word)).collect();
    if let [first, second, ..] = given[..] {
        let mistake = draft("pathmarch::two_intensities", second.name.span, "A light has one intensity.");
        let help = "Keep one of `intensity`, `candela` and `lumen`.";
        context.report.add(mistake.label("a second one").also(first.name.span, "the first").help(help));
        return None;
    }
    let word = given.first().map_or("intensity", |node| &*node.name.value);
    if word == "intensity" {
        if let Some(colour) = settings.get("colour") {
            let mistake = draft("pathmarch::misplaced_node", colour.name.span, "`colour` needs `candela` or `lumen`.");
            let help = "Write the colour as three numbers of `intensity`.";
            context.report.add(mistake.label("not with `intensity`").help(help));
        }
        return settings.colour("intensity", context);
    }
    let candela = settings.number(word, context)? / if word == "lumen" { solid_angle } else { 1.0 };
    let colour = settings.colour("colour", context)?;
    let luminance = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
    // Irradiance is the intensity by the squared distance in units of the scene.
    let units_per_metre = 1.0 / unit.metres() as f32;
    let factor = candela / LUMENS_OF_WATT * units_per_metre * units_per_metre / luminance;
    Some(if luminance > 0.0 { colour.map(|channel| channel * factor) } else { [0.0; 3] })
}
