//! Property of objects that emit.

use super::{Range, Setting, optional, setting};

/// Properties of an object whose material emits.
pub const EMITTER: &[Setting] = &[setting(
    "lumen",
    optional(Range::NOT_NEGATIVE),
    "lm",
    "lumen=800",
    "Luminous flux of an object whose material emits: scales the radiance of the material.",
)];
