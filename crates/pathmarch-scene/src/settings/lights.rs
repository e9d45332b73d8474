//! Settings of suns, point lights and spot lights.

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

const AT: Setting =
    setting("at", SettingKind::Triple { default: [4.0, 6.0, 4.0] }, "m", "at 4 6 4", "Position of the light.")
        .required()
        .labelled("position");

const CANDELA: Setting = setting(
    "candela",
    optional(Range::NOT_NEGATIVE),
    "cd",
    "candela 800",
    "Luminous intensity, instead of `intensity`.",
);

const LUMEN: Setting = setting(
    "lumen",
    optional(Range::NOT_NEGATIVE),
    "lm",
    "lumen 800",
    "Luminous flux of the whole light, instead of `intensity`.",
);

const COLOUR: Setting = setting(
    "colour",
    SettingKind::Colour { max: 1.0, default: Some([1.0; 3]) },
    "",
    "colour 1 0.85 0.7",
    "Colour of a light in candela or lumen; its brightness does not matter.",
);

/// Settings in the braces of a point light.
pub const POINT: &[Setting] = &[
    AT,
    setting(
        "intensity",
        radiance([60.0; 3]),
        "W/sr",
        "intensity 60",
        "Radiant intensity, the same in every direction.",
    )
    .required(),
    CANDELA,
    LUMEN,
    COLOUR,
    PENUMBRA,
];

/// Settings in the braces of a spot light.
pub const SPOT: &[Setting] = &[
    AT,
    setting(
        "target",
        SettingKind::Triple { default: [0.0; 3] },
        "m",
        "target 0 0 0",
        "Point that the axis passes through.",
    )
    .required(),
    setting("intensity", radiance([200.0; 3]), "W/sr", "intensity 200", "Radiant intensity on the axis.").required(),
    setting("cone", number(Range { max: 180.0, ..Range::POSITIVE }, 45.0), "°", "cone 45", "Full angle of the cone."),
    setting(
        "blend",
        number(Range::from_to(0.0, 1.0), 0.15),
        "",
        "blend 0.15",
        "Soft share of the cone; 0 is a hard edge.",
    ),
    CANDELA,
    LUMEN,
    COLOUR,
    PENUMBRA,
];
