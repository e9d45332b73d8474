//! Description of a shape or operator: its name, documentation, source and the facts that hold for all its parameters.

/// What a shape or an operator says of itself.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// Name in the scene language.
    pub name: &'static str,
    /// One sentence: what it is, where it stands.
    pub doc: &'static str,
    /// Author, work, year, section; a key of REFERENCES.md where there is one.
    pub source: &'static str,
    /// Whether the value outside is the true Euclidean distance, not only a lower bound.
    pub exact: bool,
    /// How many of the leading parameters are one size, for which a single number may stand.
    pub size_params: usize,
    /// A surface without thickness that faces +y: it emits on that side only.
    pub sheet: bool,
    /// Faces +y, and may be turned to face a `normal` instead.
    pub facing: bool,
    /// A profile: it stands in the plane of x and y, its distance does not depend on z, and it has no end along z. What is
    /// [of profiles](ModifierDef::OF_PROFILES) makes solids of it.
    pub profile: bool,
    /// What its outline is made of, if it is drawn: numbers behind its parameters, [`crate::outline`].
    pub outline: Option<Outline>,
}

/// What people write of a shape that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// Points.
    Points,
    /// Letters of a font.
    Text,
}

impl Info {
    /// An exact solid without size parameters; override fields with struct update syntax.
    pub const fn new(name: &'static str, doc: &'static str, source: &'static str) -> Self {
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
}
