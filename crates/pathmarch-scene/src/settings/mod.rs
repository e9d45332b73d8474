//! Specification of the settings of cameras, rendering, lights, skies, placement and blends.
//!
//! Each setting is one row of a table: name, kind, range, default, unit, help. The reader of scene files, the controls of
//! [`crate::document`], the checks of scenes built in code ([`crate::parts`]) and the command line all read these tables.
//! Shapes, operators, materials and textures declare their parameters in their own files, in the same manner.
//!
//! To add a render setting, add a row to [`render`](self::RENDER); to add another setting, add a row to its table and
//! read it in `language/read/`.

mod blend;
mod camera;
mod decal;
mod emitter;
mod fog;
mod lights;
mod mesh;
mod placement;
mod render;
mod sky;
mod visibility;

pub use blend::BLEND;
pub use camera::{CAMERA, EXPOSURE, LENS};
pub use decal::DECAL;
pub use emitter::EMITTER;
pub use fog::FOG;
pub use lights::{POINT, SPOT, SUN};
pub use mesh::MESH;
pub use pathmarch_field::Range;
pub use placement::{NORMAL, PLACEMENT};
pub use render::{
    BOUNCES, CLAMP, Caustics, DETAIL, DirectLighting, FPS, RENDER, RenderSettings, SAMPLES, SHUTTER, SIDE, Sampler,
    Tonemap,
};
pub use sky::{DAY, DAY_GROUND, GRADIENT, PICTURE, SKY_FORMS};
use std::fmt;
pub use visibility::VISIBILITY;

/// Names of the render settings that only scenes in motion use.
pub const OF_MOTION: [&str; 2] = ["fps", "shutter"];

/// Word of a number that the renderer chooses.
pub const AUTO: &str = "auto";

/// One setting.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Name in the scene language.
    pub name: &'static str,
    /// Name for people, as in a window.
    pub label: &'static str,
    /// Type of the value, with its range and default.
    pub kind: SettingKind,
    /// True if scene files must give it. Its default is then the value of a new node.
    pub required: bool,
    /// Unit, as printed after a number; empty without one.
    pub unit: &'static str,
    /// Example in the scene language, as in `fov 40`. Without a default, its numbers are the first value of a control.
    pub example: &'static str,
    /// Help: one sentence for people.
    pub doc: &'static str,
}

/// Type of a setting's value, with its range and default.
#[derive(Clone, Copy, Debug)]
pub enum SettingKind {
    /// A number. Without a default, absence has a meaning of its own, which the help states.
    Number {
        /// Accepted numbers.
        range: Range,
        /// Value when absent.
        default: Option<f32>,
    },
    /// A number, or "auto": chosen by the renderer.
    NumberOrAuto {
        /// Accepted numbers.
        range: Range,
        /// Value when absent.
        default: f32,
    },
    /// A whole number.
    Whole {
        /// Smallest and largest number.
        range: (u32, u32),
        /// Value when absent.
        default: u32,
    },
    /// Width and height.
    Size {
        /// Smallest and largest width and height.
        range: (u32, u32),
        /// Value when absent.
        default: (u32, u32),
    },
    /// Three finite numbers.
    Triple {
        /// Value when absent.
        default: [f32; 3],
    },
    /// Three finite numbers that are not all zero.
    Direction {
        /// Value when absent.
        default: [f32; 3],
    },
    /// A linear Rec. 709 colour with channels from 0 to `max`.
    Colour {
        /// Largest channel; `f32::MAX` for radiance.
        max: f32,
        /// Value when absent; without it, absence has a meaning of its own.
        default: Option<[f32; 3]>,
    },
    /// One of several names; the first is the default.
    Choice {
        /// Noun for messages, as in "There is no {noun} `x`".
        noun: &'static str,
        /// All names.
        names: fn() -> Vec<&'static str>,
    },
    /// A truth value.
    Flag {
        /// Value when absent.
        default: bool,
    },
    /// A node whose properties are settings.
    Properties(&'static [Setting]),
}

/// Value of a setting, of the type that its [`SettingKind`] names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingValue {
    /// No value, for an optional number.
    Absent,
    /// Value of a [`SettingKind::Number`].
    Number(f32),
    /// Value of a [`SettingKind::Whole`].
    Whole(u32),
    /// Value of a [`SettingKind::Size`].
    Size((u32, u32)),
    /// Value of a [`SettingKind::Choice`].
    Choice(&'static str),
}

/// A row of a table, with the name as label.
const fn setting(
    name: &'static str,
    kind: SettingKind,
    unit: &'static str,
    example: &'static str,
    doc: &'static str,
) -> Setting {
    Setting { name, label: name, kind, required: false, unit, example, doc }
}

const fn number(range: Range, default: f32) -> SettingKind {
    SettingKind::Number { range, default: Some(default) }
}
const fn optional(range: Range) -> SettingKind {
    SettingKind::Number { range, default: None }
}
const fn radiance(default: [f32; 3]) -> SettingKind {
    SettingKind::Colour { max: f32::MAX, default: Some(default) }
}

impl Setting {
    const fn required(self) -> Self {
        Self { required: true, ..self }
    }
    const fn labelled(self, label: &'static str) -> Self {
        Self { label, ..self }
    }
    /// Usage in the scene language, as in "`at x y z`".
    pub fn usage(&self) -> impl fmt::Display {
        fmt::from_fn(|f| match self.kind {
            SettingKind::Triple { .. } | SettingKind::Direction { .. } => write!(f, "`{} x y z`", self.name),
            _ => write!(f, "`{}`", self.example),
        })
    }
}

impl SettingKind {
    /// Accepted numbers, for a single number; any for other kinds.
    pub fn range(&self) -> Range {
        match *self {
            Self::Number { range, .. } | Self::NumberOrAuto { range, .. } => range,
            _ => Range::ANY,
        }
    }
    /// Default of a single number.
    pub fn default_number(&self) -> Option<f32> {
        match *self {
            Self::Number { default, .. } => default,
            Self::NumberOrAuto { default, .. } => Some(default),
            _ => None,
        }
    }
    /// The accepted values in words, as in "must be …".
    pub fn range_in_words(&self) -> String {
        match *self {
            Self::Number { range, .. } => range.in_words(),
            Self::NumberOrAuto { range, .. } => format!("{}, or \"{AUTO}\"", range.in_words()),
            Self::Whole { range: (min, max), .. } => format!("from {min} to {max}"),
            Self::Size { range: (min, max), .. } => format!("from {min} to {max} each"),
            Self::Triple { .. } => "three finite numbers".to_owned(),
            Self::Direction { .. } => "a direction of any length but 0".to_owned(),
            Self::Colour { max, .. } => Range::from_to(0.0, max).in_words(),
            Self::Choice { names, .. } => names().join(", "),
            Self::Flag { .. } => "#true or #false".to_owned(),
            Self::Properties(_) => String::new(),
        }
    }
    /// True if the value is of this kind and in range.
    pub fn accepts(&self, value: SettingValue) -> bool {
        match (*self, value) {
            (Self::Number { default, .. }, SettingValue::Absent) => default.is_none(),
            (Self::Number { range, .. }, SettingValue::Number(number)) => range.accepts(number),
            (Self::Whole { range: (min, max), .. }, SettingValue::Whole(number)) => (min..=max).contains(&number),
            (Self::Size { range: (min, max), .. }, SettingValue::Size((width, height))) => {
                [width, height].iter().all(|side| (min..=max).contains(side))
            }
            (Self::Choice { names, .. }, SettingValue::Choice(name)) => names().contains(&name),
            _ => false,
        }
    }
}

/// Names of a table's settings.
pub(crate) fn names(table: &'static [Setting]) -> Vec<&'static str> {
    table.iter().map(|setting| setting.name).collect()
}

/// The setting of this name.
pub(crate) fn find(table: &'static [Setting], name: &str) -> &'static Setting {
    table.iter().find(|setting| setting.name == name).expect("a name of this table")
}

/// The required settings of a table, as a new node contains them.
pub(crate) fn required(table: &'static [Setting], separator: &str) -> String {
    let examples: Vec<&str> = table.iter().filter(|setting| setting.required).map(|setting| setting.example).collect();
    examples.join(separator)
}
