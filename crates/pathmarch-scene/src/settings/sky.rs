//! Settings of each form of the sky.

use super::{Range, Setting, SettingKind, number, radiance, setting};
use crate::atmosphere::Day;

/// Forms of the sky: name and help.
pub const SKY_FORMS: &[(&str, &str)] = &[
    ("colour", "The same radiance from every direction."),
    ("gradient", "Radiance from up, from the horizon and from below."),
    ("day", "The sky of a clear day, computed, with its sun."),
    ("picture", "A picture of radiance in every direction, a .hdr or .exr file."),
];

/// Settings in the braces of a gradient.
pub const GRADIENT: &[Setting] = &[
    setting("zenith", radiance([0.2, 0.4, 0.8]), "W/(m² sr)", "zenith 0.2 0.4 0.8", "Radiance from straight up.")
        .required(),
    setting(
        "horizon",
        radiance([0.8, 0.85, 0.9]),
        "W/(m² sr)",
        "horizon 0.8 0.85 0.9",
        "Radiance at the height of the eye.",
    )
    .required(),
    setting(
        "ground",
        SettingKind::Colour { max: f32::MAX, default: None },
        "W/(m² sr)",
        "ground 0.3 0.25 0.2",
        "Radiance from below; that of the horizon when absent.",
    ),
];

const STRENGTH: Setting =
    setting("strength", number(Range::NOT_NEGATIVE, 1.0), "", "strength=1", "Factor of all radiance.");

/// Properties of a picture.
pub const PICTURE: &[Setting] = &[
    STRENGTH,
    setting("rotate", number(Range::ANY, 0.0), "°", "rotate=90", "Rotation about the vertical, right-handed."),
];

/// Properties of a day.
pub const DAY: &[Setting] = &[
    setting(
        "elevation",
        number(Range::from_to(-20.0, 90.0), Day::DEFAULT.elevation),
        "°",
        "elevation=40",
        "Height of the sun above the horizon.",
    ),
    setting(
        "azimuth",
        number(Range::ANY, Day::DEFAULT.azimuth),
        "°",
        "azimuth=135",
        "Direction of the sun, clockwise from north (-z): 90 is +x.",
    ),
    setting(
        "haze",
        number(Range::from_to(0.0, 20.0), Day::DEFAULT.haze),
        "",
        "haze=1",
        "Factor of haze: 0 is air alone, 1 a clear day, 4 a usual one, 20 thick haze.",
    ),
    STRENGTH,
    setting("sun", SettingKind::Flag { default: true }, "", "sun=#true", "Adds the light of the sun itself."),
];

/// Settings in the braces of a day.
pub const DAY_GROUND: &[Setting] = &[setting(
    "ground",
    SettingKind::Colour { max: 1.0, default: Some(Day::DEFAULT.ground) },
    "",
    "ground 0.2",
    "Fraction of the light that the ground reflects.",
)];
