//! Settings of a camera.

use super::{Range, Setting, SettingKind, number, optional, setting};

/// Exposure, stops.
pub const EXPOSURE: Range = Range::from_to(-100.0, 100.0);

/// Settings in the braces of a camera.
pub const CAMERA: &[Setting] = &[
    setting(
        "position",
        SettingKind::Triple { default: [0.0, 1.5, 6.0] },
        "m",
        "position 0 1.5 6",
        "Position of the camera.",
    )
    .required(),
    setting(
        "target",
        SettingKind::Triple { default: [0.0, 1.0, 0.0] },
        "m",
        "target 0 1 0",
        "Point in the middle of the picture.",
    )
    .required(),
    setting(
        "up",
        SettingKind::Direction { default: [0.0, 1.0, 0.0] },
        "",
        "up 0 1 0",
        "Direction that is up in the picture; not along the view.",
    ),
    setting("fov", number(Range::between(0.0, 180.0), 40.0), "°", "fov 40", "Vertical field of view.")
        .labelled("field of view"),
    setting("lens", SettingKind::Properties(LENS), "", "lens radius=0.05 focus=6", "A thin lens."),
    setting(
        "exposure",
        SettingKind::NumberOrAuto { range: EXPOSURE, default: 0.0 },
        "EV",
        "exposure 0",
        "Stops for the screen, PNG and JPEG, never for EXR; \"auto\" is the exposure that suits the picture.",
    ),
];

/// Properties of `lens`.
pub const LENS: &[Setting] = &[
    setting("radius", number(Range::NOT_NEGATIVE, 0.0), "m", "radius=0.05", "Radius of the thin lens; 0 is a pinhole.")
        .labelled("lens radius"),
    setting(
        "focus",
        optional(Range::POSITIVE),
        "m",
        "focus=6",
        "Distance that is in focus, along the view axis; the target's distance when absent.",
    )
    .labelled("focus distance"),
];
