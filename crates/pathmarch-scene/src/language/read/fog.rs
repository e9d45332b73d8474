//! The fog: the medium between the objects.

use super::arguments::{arguments, properties};
use super::context::Context;
use super::settings::Braces;
use crate::language::tree::Node;
use crate::medium::Medium;
use crate::settings::FOG;

/// The medium of a node; `None` after a mistake.
pub(crate) fn fog(node: &Node, context: &mut Context) -> Option<Medium> {
    arguments(node, 0, "`fog { scatter 0.1 }`", context);
    properties(node, &[], context);
    let settings = Braces::new(node, FOG, "in a fog", context);
    let scattering = settings.colour("scatter", context);
    let absorption = settings.colour("absorb", context);
    let anisotropy = settings.number("anisotropy", context);
    let emission = settings.colour("glow", context);
    Some(Medium { absorption: absorption?, scattering: scattering?, anisotropy: anisotropy?, emission: emission? })
}
