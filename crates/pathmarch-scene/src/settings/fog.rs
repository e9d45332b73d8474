//! Settings of the fog.

use super::{Range, Setting, SettingKind, number, setting};

const fn coefficient(name: &'static str, unit: &'static str, example: &'static str, doc: &'static str) -> Setting {
    setting(name, SettingKind::Colour { max: f32::MAX, default: Some([0.0; 3]) }, unit, example, doc)
}

/// Settings in the braces of a fog. Materials have parameters of the same names.
pub const FOG: &[Setting] = &[
    coefficient(
        "scatter",
        "1/m",
        "scatter 0.1",
        "Scattering coefficient: light is scattered once on a way of 1 / scatter, on average.",
    ),
    coefficient("absorb", "1/m", "absorb 0.02", "Absorption coefficient: exp(-absorb × length) passes."),
    setting(
        "anisotropy",
        number(Range::between(-1.0, 1.0), 0.0),
        "",
        "anisotropy 0.6",
        "Mean cosine of scattering angles: 0 in all directions, above 0 forwards, below 0 backwards.",
    ),
    coefficient("glow", "W/(m³ sr)", "glow 0.1", "Radiance that a metre of it emits."),
];
