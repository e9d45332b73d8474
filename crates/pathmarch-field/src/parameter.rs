//! Parameter specification: name, unit, default, range and documentation of one number of a shape or operator.
//!
//! The parser, the reference page, the window's controls and the tests read the same [`Param`].

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
            Self::Axis => "axis",
            Self::Ratio => "",
        }
    }
}

/// Specification of one parameter of a shape, operator or texture.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// Name in the scene language.
    pub name: &'static str,
    /// Unit of its values.
    pub unit: Unit,
    /// Value used when none is given.
    pub default: f32,
    /// Smallest allowed value.
    pub min: f32,
    /// True if `min` itself is allowed.
    pub min_allowed: bool,
    /// Largest allowed value.
    pub max: f32,
    /// One line of documentation.
    pub doc: &'static str,
}

impl Param {
    /// Specification of a length above zero, metres.
    pub const fn length(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Metres, default, min: 0.0, min_allowed: false, max: f32::MAX, doc }
    }
    /// Specification of a length of zero or more, metres.
    pub const fn length_or_zero(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { min_allowed: true, ..Self::length(name, default, doc) }
    }
    /// Specification of any finite number, e.g. a component of a direction.
    pub const fn any(name: &'static str, default: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Ratio, default, min: f32::MIN, min_allowed: true, max: f32::MAX, doc }
    }
    /// Specification of a number from `min` to `max`.
    pub const fn between(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self { name, unit: Unit::Ratio, default, min, min_allowed: true, max, doc }
    }
    /// Specification of a whole number from `min` to `max`.
    pub const fn count(name: &'static str, default: f32, min: f32, max: f32, doc: &'static str) -> Self {
        Self { unit: Unit::Count, ..Self::between(name, default, min, max, doc) }
    }
    /// Specification of an axis.
    pub const fn axis(name: &'static str, doc: &'static str) -> Self {
        Self { unit: Unit::Axis, ..Self::between(name, 0.0, 0.0, 2.0, doc) }
    }
    /// Reports whether `value` is finite and within the range.
    pub fn accepts(&self, value: f32) -> bool {
        value.is_finite() && (value > self.min || self.min_allowed && value == self.min) && value <= self.max
    }
    /// Description of the range, to follow "must be", e.g. "above 0".
    pub fn range_in_words(&self) -> String {
        let whole = if self.unit == Unit::Count { "a whole number " } else { "" };
        match (self.min > f32::MIN, self.max < f32::MAX) {
            (true, true) => format!("{whole}from {} to {}", self.min, self.max),
            (true, false) if self.min_allowed => format!("{whole}{} or more", self.min),
            (true, false) => format!("{whole}above {}", self.min),
            (false, true) => format!("{whole}at most {}", self.max),
            (false, false) => format!("{whole}any finite number"),
        }
    }
}
