//! Render settings.

use super::arguments::{arguments, properties};
use super::context::Context;
use super::settings::Braces;
use crate::language::tree::Node;
use crate::settings::{RENDER, RenderSettings};

/// Reads the render settings; those with a mistake keep their defaults.
pub(crate) fn render(node: &Node, context: &mut Context) -> RenderSettings {
    arguments(node, 0, "`render { … }`", context);
    properties(node, &[], context);
    let braces = Braces::new(node, RENDER, "in `render`", context);
    let mut settings = RenderSettings::default();
    for setting in RENDER {
        let value = braces.get(setting.name).and_then(|node| Braces::value(setting, node, context));
        value.into_iter().for_each(|value| {
            settings.set(setting.name, value);
        });
    }
    settings
}
