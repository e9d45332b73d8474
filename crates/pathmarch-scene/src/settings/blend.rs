//! Settings of operators that blend.

use super::{Range, Setting, SettingKind, number, setting};
use pathmarch_field::BlendProfile;
use pathmarch_field::blend::{DEFAULT_STEPS, MAX_STEPS};

/// Properties of every operator that blends.
pub const BLEND: &[Setting] = &[
    setting(
        "smooth",
        number(Range::NOT_NEGATIVE, 0.0),
        "m",
        "smooth=0.1",
        "Width over which edges and materials blend; 0 is sharp.",
    ),
    setting(
        "profile",
        SettingKind::Choice { noun: "profile of blends", names: || BlendProfile::ALL.map(BlendProfile::name).to_vec() },
        "",
        "profile=\"round\"",
        "Cross-section of the seam of a blend.",
    ),
    setting(
        "steps",
        SettingKind::Whole { range: (1, MAX_STEPS), default: DEFAULT_STEPS as u32 },
        "",
        "steps=4",
        "Number of steps of the profile \"stairs\".",
    ),
];
