//! Property of objects and lights.

use super::{Setting, SettingKind, setting};

/// Properties of an object, a sun and a point light.
pub const VISIBILITY: &[Setting] = &[setting(
    "hidden",
    SettingKind::Flag { default: false },
    "",
    "hidden=#true",
    "Leaves it out of the scene, as if it were not in the file.",
)];
