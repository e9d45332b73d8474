//! Settings that place a shape, an operator or a texture.

use super::{Range, Setting, SettingKind, number, setting};

/// Placement of every shape and operator: scaled, rotated, then moved.
pub const PLACEMENT: &[Setting] = &[
    setting("at", SettingKind::Triple { default: [0.0; 3] }, "m", "at 0 1 0", "Position.").labelled("position"),
    setting(
        "rotate",
        SettingKind::Triple { default: [0.0; 3] },
        "°",
        "rotate 0 45 0",
        "Rotations about the fixed x, then y, then z axis, right-handed.",
    )
    .labelled("rotation"),
    setting("scale", number(Range::POSITIVE, 1.0), "", "scale s", "Factor of all lengths."),
];

/// Direction of a shape that faces +y by itself.
pub const NORMAL: Setting = setting(
    "normal",
    SettingKind::Direction { default: [0.0, 1.0, 0.0] },
    "",
    "normal 0 1 0",
    "Direction that the shape faces, before `rotate`.",
);
