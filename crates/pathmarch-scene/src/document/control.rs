//! Controls of nodes: their values, ranges and help; and additions.

use crate::settings::Range;
use std::borrow::Cow;

/// The value of a control.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Not given, without a default: no limit, no material of its own.
    None,
    /// One number.
    Number(f32),
    /// A position, a direction, or angles about three axes.
    Triple([f32; 3]),
    /// Linear Rec. 709.
    Colour([f32; 3]),
    /// Width and height, pixels.
    Size([u32; 2]),
    /// A name, a path, or one of a list of words.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// Numbers of which at least one is a formula, each as text: one for a number, two for a size, three for a triple,
    /// one or three for a colour. [`Control::present`] has their values. A text that is a number becomes one.
    Formulas(Vec<String>),
}

/// Type of a control, with the values that it accepts.
#[derive(Clone, Debug, PartialEq)]
pub enum ControlKind {
    /// A [`Value::Number`].
    Number(NumberRange),
    /// A [`Value::Triple`] of any finite numbers.
    Triple {
        /// True for a direction, which has any length but zero.
        direction: bool,
    },
    /// A [`Value::Colour`], each channel from 0 to `max`; `f32::MAX` for radiance.
    Colour {
        /// The largest value of a channel.
        max: f32,
    },
    /// A [`Value::Text`], one of these.
    Choice(Vec<Cow<'static, str>>),
    /// A [`Value::Text`] that is not empty.
    Text,
    /// A [`Value::Text`]: the path of a `.hdr` or `.exr` file, relative to the scene file.
    Picture,
    /// A [`Value::Flag`].
    Flag,
    /// A [`Value::Text`], the name of one of these materials; or [`Value::None`] for the material of the parent.
    Material(Vec<String>),
    /// A [`Value::Size`].
    Size {
        /// The smallest width and height.
        min: u32,
        /// The largest width and height.
        max: u32,
    },
}

/// The numbers that are allowed, and those that a slider should cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NumberRange {
    /// Allowed numbers.
    pub allowed: Range,
    /// True if only whole numbers are allowed.
    pub whole: bool,
    /// Smallest and largest value of a slider: within the limits, wide enough for most scenes.
    pub soft: (f32, f32),
    /// True if the slider should be logarithmic, for sizes and intensities.
    pub logarithmic: bool,
}

/// One parameter of a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// Names the parameter to [`Document::set`](super::Document::set); unlike every other key of the node.
    pub key: Cow<'static, str>,
    /// Name for people.
    pub label: Cow<'static, str>,
    /// One sentence: what it does.
    pub doc: Cow<'static, str>,
    /// As printed after a number; empty without unit.
    pub unit: &'static str,
    /// Type and range.
    pub kind: ControlKind,
    /// Value in the text, else the default.
    pub value: Value,
    /// Present value, without formulas. The default if that is unknown.
    pub present: Value,
    /// Value if the text gives none; [`Value::None`] without a default.
    pub default: Value,
    /// Value to set when it is switched on: the default, if any.
    pub initial: Value,
    /// True if the text gives the value.
    pub given: bool,
    /// True if the text must give the value, so that it cannot be reset.
    pub required: bool,
}

impl NumberRange {
    /// True if `value` is in the range, and whole where it must be.
    pub fn accepts(&self, value: f32) -> bool {
        self.allowed.accepts(value) && (!self.whole || value.fract() == 0.0)
    }
    /// The range in words, as in "must be above 0".
    pub fn in_words(&self) -> String {
        format!("{}{}", if self.whole { "a whole number " } else { "" }, self.allowed.in_words())
    }
}

impl Control {
    /// A control without unit, whose value is the default.
    pub(super) fn new(
        key: impl Into<Cow<'static, str>>,
        label: impl Into<Cow<'static, str>>,
        doc: impl Into<Cow<'static, str>>,
        kind: ControlKind,
        default: Value,
    ) -> Self {
        let [value, present, initial] = std::array::from_fn(|_| default.clone());
        let (key, label, doc) = (key.into(), label.into(), doc.into());
        Self { key, label, doc, unit: "", kind, value, present, default, initial, given: false, required: false }
    }
    pub(super) fn required(self) -> Self {
        Self { required: true, ..self }
    }
}

/// Group of additions, as in a menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Group {
    /// An object that consists of a shape.
    Object,
    /// A shape, in an object or an operator.
    Shape,
    /// An operator, in an object or an operator.
    Operator,
    /// A material.
    Material,
    /// A sun, a point or a spot.
    Light,
    /// The sky: radiance of the surroundings.
    Sky,
    /// A camera.
    Camera,
    /// Picture size and quality.
    Render,
    /// A parameter, which formulas use.
    Param,
}

impl Group {
    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Object => "Object",
            Self::Shape => "Shape",
            Self::Operator => "Operator",
            Self::Material => "Material",
            Self::Light => "Light",
            Self::Sky => "Sky",
            Self::Camera => "Camera",
            Self::Render => "Render",
            Self::Param => "Parameter",
        }
    }
}

/// Something that may be added to a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Addition {
    /// Kind of the node.
    pub group: Group,
    /// Its name in the scene language: of the shape, operator, kind of material or of sky, or of the node.
    pub name: Cow<'static, str>,
    /// One sentence for people.
    pub doc: Cow<'static, str>,
}
