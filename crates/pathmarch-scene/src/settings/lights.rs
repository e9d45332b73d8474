//! Settings of suns and point lights.

use super::{Range, Setting, SettingKind, number, optional, radiance, setting};
use crate::atmosphere::SUN_ANGLE;

const PENUMBRA: Setting = setting(
    "penumbra",
    optional(Range::POSITIVE),
    "",
    "penumbra 16",
    "Softens shadows by near misses, an approximation; larger is sharper.",
);

/// Settings in the braces of a sun.
pub const SUN: &[Setting] = &[
    setting(
        "direction",
        SettingKind::Direction { default: [0.3, 0.8, 0.5] },
        "",
        "direction 0.3 0.8 0.5",
        "Direction towards the sun.",
    )
    .required(),
    setting(
        "irradiance",
        radiance([3.0, 2.9, 2.7]),
        "W/m²",
        "irradiance 3 2.9 2.7",
        "Irradiance of a surface that faces the sun.",
    )
    .required(),
    setting(
        "angle",
        number(Range::from_to(0.0, 180.0), SUN_ANGLE),
        "°",
        "angle 0.53",
        "Apparent diameter; 0 is parallel light with hard shadows.",
    ),
    PENUMBRA,
];

/// Settings in the braces of a point light.
pub const POINT: &[Setting] = &[
    setting("at", SettingKind::Triple { default: [4.0, 6.0, 4.0] }, "m", "at 4 6 4", "Position of the light.")
        .required()
        .labelled("position"),
    setting(
        "intensity",
        radiance([60.0; 3]),
        "W/sr",
        "intensity 60",
        "Radiant intensity, the same in every direction.",
    )
    .required(),
    PENUMBRA,
];
