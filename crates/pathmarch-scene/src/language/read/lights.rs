//! Suns and point lights.

use super::arguments::arguments;
use super::context::Context;
use super::settings::{Braces, Properties};
use crate::language::tree::Node;
use crate::light::Light;
use crate::settings::{POINT, SUN, VISIBILITY};

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
pub(crate) fn point(node: &Node, context: &mut Context) -> Option<Light> {
    arguments(node, 0, "`point { … }`", context);
    let hidden = Properties::new(node, VISIBILITY, context).flag("hidden", context);
    let settings = Braces::new(node, POINT, "in a point light", context);
    let at = settings.triple("at", context);
    let intensity = settings.colour("intensity", context);
    let penumbra = settings.number("penumbra", context);
    let point = Light::Point { at: at?, intensity: intensity?, penumbra };
    (!hidden).then_some(point)
}
