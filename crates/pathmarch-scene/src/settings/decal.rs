//! Properties of `decal`.

use super::{Range, Setting, SettingKind, number, optional, setting};

/// Properties of a `decal`.
pub const DECAL: &[Setting] = &[
    setting("size", number(Range::POSITIVE, 1.0), "m", "size=0.1", "Width of the picture."),
    setting(
        "depth",
        optional(Range::POSITIVE),
        "m",
        "depth=0.05",
        "Extent of the projection along z, half of it on each side of the picture; the size when absent.",
    ),
    setting(
        "angle",
        number(Range::from_to(0.0, 180.0), 80.0),
        "°",
        "angle=80",
        "Surfaces that are turned further away from +z do not show the picture.",
    ),
    setting("opacity", number(Range::from_to(0.0, 1.0), 1.0), "", "opacity=0.8", "Factor of the picture's alpha."),
    setting(
        "world",
        SettingKind::Flag { default: false },
        "",
        "world=#true",
        "Placed in the coordinates of the scene, not in those of each shape.",
    ),
];
