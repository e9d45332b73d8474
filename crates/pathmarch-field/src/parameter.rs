//! Parameter specification: name, unit, default, range and documentation of one number of a shape or operator.
//!
//! The parser, the reference page, the window's controls and the tests read the same [`Param`].

use crate::range::Range;
use std::borrow::Cow;

/// Unit of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Metres,
    /// Degrees.
    Degrees,
    /// A whole number.
    Count,
    /// One of the axes x, y and z, as 0, 1 and 2.
    Axis,
    /// A number without unit.
    Ratio,
}

impl Unit {
    /// Text printed after a value.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Degrees => "°",
            Self::Count => "count",
            Self::Axis | Self::Ratio => "",
        }
    }
}

/// Specification of one parameter of a shape, operator or texture.
#[derive(Clone, Debug)]
pub struct Param {
    /// Name in the scene language.
    pub name: Cow<'static, str>,
    /// Unit of its values.
    pub unit: Unit,
    /// Value used when none is given.
    pub default: f32,
    /// Allowed values.
    pub range: Range,
    /// One line of documentation.
    pub doc: Cow<'static, str>,
}

impl Param {
    /// Specification of a length above zero, metres.
    pub const fn length(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self::within(name, default, Range::POSITIVE, doc).with_unit(Unit::Metres)
    }
    /// Specification of a length of zero or more, metres.
    pub const fn length_or_zero(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self::within(name, default, Range::NOT_NEGATIVE, doc).with_unit(Unit::Metres)
    }
    /// Specification of any finite number, e.g. a component of a direction.
    pub const fn any(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self::within(name, default, Range::ANY, doc)
    }
    /// Specification of a number from `min` to `max`.
    pub const fn between(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self::within(name, default, Range::from_to(min, max), doc)
    }
    /// Specification of a number in a range.
    pub const fn within(name: &'static str, default: f32, range: Range, doc: &'static str) -> Self {
        Self { name: Cow::Borrowed(name), unit: Unit::Ratio, default, range, doc: Cow::Borrowed(doc) }
    }
    /// Specification of a whole number from `min` to `max`.
    pub const fn count(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self::between(name, default, min, max, doc).with_unit(Unit::Count)
    }
    /// Specification of an axis.
    pub const fn axis(name: &'static str, doc: &'static str) -> Self {
        Self::between(name, 0.0, 0.0, 2.0, doc).with_unit(Unit::Axis)
    }
    /// Sets the unit.
    pub const fn with_unit(mut self, unit: Unit) -> Self {
        self.unit = unit;
        self
    }
    /// Sets the default.
    pub const fn with_default(mut self, default: f32) -> Self {
        self.default = default;
        self
    }
    /// True if the parameter takes whole numbers only.
    pub fn is_whole(&self) -> bool {
        matches!(self.unit, Unit::Count | Unit::Axis)
    }
    /// True if `value` is in the range, and whole where it must be.
    pub fn accepts(&self, value: f32) -> bool {
        self.range.accepts(value) && (!self.is_whole() || value.fract() == 0.0)
    }
    /// The default as in the scene language.
    pub fn default_in_words(&self) -> String {
        match self.unit {
            Unit::Axis => format!("\"{}\"", ["x", "y", "z"][self.default as usize % 3]),
            _ => self.default.to_string(),
        }
    }
    /// Description of the range, to follow "must be", e.g. "above 0".
    pub fn range_in_words(&self) -> String {
        if self.unit == Unit::Axis {
            return "\"x\", \"y\" or \"z\"".to_owned();
        }
        format!("{}{}", if self.is_whole() { "a whole number " } else { "" }, self.range.in_words())
    }
}
