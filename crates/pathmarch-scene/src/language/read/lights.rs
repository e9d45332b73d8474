//! Suns and point lights.

use super::arguments::{arguments, properties};
use super::context::Context;
use super::settings::Braces;
use crate::language::tree::Node;
use crate::light::Light;
use crate::settings::{POINT, SUN};

/// A sun; `None` after a mistake.
pub(crate) fn sun(node: &Node, context: &mut Context) -> Option<Light> {
    arguments(node, 0, "`sun { … }`", context);
    properties(node, &[], context);
    let settings = Braces::new(node, SUN, "in a sun", context);
    let direction = settings.triple("direction", context);
    let irradiance = settings.colour("irradiance", context);
    let angle = settings.number("angle", context);
    let penumbra = settings.number("penumbra", context);
    Some(Light::Sun { direction: direction?, irradiance: irradiance?, angle: angle?, penumbra })
}

/// A point light; `None` after a mistake.
pub(crate) fn point(node: &Node, context: &mut Context) -> Option<Light> {
    arguments(node, 0, "`point { … }`", context);
    properties(node, &[], context);
    let settings = Braces::new(node, POINT, "in a point light", context);
    let at = settings.triple("at", context);
    let intensity = settings.colour("intensity", context);
    let penumbra = settings.number("penumbra", context);
    Some(Light::Point { at: at?, intensity: intensity?, penumbra })
}
