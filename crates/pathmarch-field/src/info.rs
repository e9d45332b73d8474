//! Description of a shape or operator: its name, documentation, source and the facts that hold for all its parameters.

use std::borrow::Cow;

/// Description of a shape, operator or modifier.
#[derive(Clone, Debug)]
pub struct Info {
    /// Name in the scene language.
    pub name: Cow<'static, str>,
    /// One sentence: the solid and its position.
    pub doc: Cow<'static, str>,
    /// Author, work, year, section; a key of REFERENCES.md where there is one.
    pub source: &'static str,
    /// True if the value outside is the Euclidean distance, false if it is a lower bound of it.
    pub exact: bool,
    /// Number of leading parameters that form one size; scenes may give a single number for all of them.
    pub size_params: usize,
    /// True for a surface without thickness that faces +y; it emits on that side only.
    pub sheet: bool,
    /// True if it faces +y and a placement may turn it to a `normal`.
    pub facing: bool,
    /// True for a profile: a shape in the xy plane, unbounded along z, whose distance does not depend on z. Modifiers such
    /// as `extrude` make solids of profiles.
    pub profile: bool,
    /// Source of its outline, if it is drawn; the segments follow its parameters, see [`crate::outline`].
    pub outline: Option<Outline>,
}

/// Source of the outline of a drawn shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// Points of polygons.
    Points,
    /// Glyphs of a font.
    Text,
    /// Points of a smooth curve.
    Curve,
    /// Path in the notation of SVG.
    Path,
}

impl Outline {
    /// True if it is given by points.
    pub const fn has_points(self) -> bool {
        matches!(self, Self::Points | Self::Curve)
    }
    /// True if its argument is a string.
    pub const fn has_string(self) -> bool {
        matches!(self, Self::Text | Self::Path)
    }
}

impl Info {
    /// Description of a registered exact solid without size parameters; the methods below change it.
    pub const fn new(name: &'static str, doc: &'static str, source: &'static str) -> Self {
        Self::with_names(Cow::Borrowed(name), Cow::Borrowed(doc), source)
    }
    /// Description with names of its own, for shapes that scenes declare; otherwise as [`new`](Self::new).
    pub const fn with_names(name: Cow<'static, str>, doc: Cow<'static, str>, source: &'static str) -> Self {
        Self {
            name,
            doc,
            source,
            exact: true,
            size_params: 0,
            sheet: false,
            facing: false,
            profile: false,
            outline: None,
        }
    }
    /// Marks the distance as a lower bound.
    pub const fn inexact(mut self) -> Self {
        self.exact = false;
        self
    }
    /// Sets the number of leading parameters that form one size.
    pub const fn size_params(mut self, count: usize) -> Self {
        self.size_params = count;
        self
    }
    /// Marks a surface without thickness.
    pub const fn sheet(mut self) -> Self {
        self.sheet = true;
        self
    }
    /// Marks a shape that a placement may turn to a `normal`.
    pub const fn facing(mut self) -> Self {
        self.facing = true;
        self
    }
    /// Marks a profile.
    pub const fn profile(mut self) -> Self {
        self.profile = true;
        self
    }
    /// Sets the source of the outline of a drawn shape.
    pub const fn outline(mut self, outline: Outline) -> Self {
        self.outline = Some(outline);
        self
    }
}
