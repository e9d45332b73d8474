//! What surfaces do with light.
//!
//! A material is one file that declares a [`MaterialKind`]: its name, documentation, source and parameters. The name in
//! the list below is the file and its registration; the parser, the reference page and the tests read [`kinds`].

/// What a parameter of a material holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamKind {
    /// Linear Rec. 709; one number stands for three equal ones.
    Colour,
    /// One number.
    Number,
}

/// One parameter of a material.
#[derive(Clone, Copy, Debug)]
pub struct MaterialParam {
    /// Name in the scene language.
    pub name: &'static str,
    /// Colour or number.
    pub kind: ParamKind,
    /// Value when not given; a number is the first of the three.
    pub default: [f32; 3],
    /// Smallest allowed value of each component.
    pub min: f32,
    /// Largest allowed value of each component.
    pub max: f32,
    /// One line for people, with the unit.
    pub doc: &'static str,
}

impl MaterialParam {
    /// The range in words, as in "must be from 0 to 1".
    pub fn range_in_words(&self) -> String {
        match (self.min > f32::MIN, self.max < f32::MAX) {
            (true, true) => format!("from {} to {}", self.min, self.max),
            (true, false) => format!("{} or more", self.min),
            (false, true) => format!("at most {}", self.max),
            (false, false) => "any finite number".to_owned(),
        }
    }
}

/// A colour for each set of parameter values, in the order of [`MaterialKind::params`].
pub type ColourOf = fn(values: &[[f32; 3]]) -> [f32; 3];

/// What a kind of material says of itself.
#[derive(Debug)]
pub struct MaterialKind {
    /// Name in the scene language.
    pub name: &'static str,
    /// One sentence for people.
    pub doc: &'static str,
    /// Author, work, year, section; a key of REFERENCES.md where there is one.
    pub source: &'static str,
    /// The parameters. The first is written after the kind's own name (`metal 1 0.8 0.3`), the others as nodes beside
    /// it (`roughness 0.2`).
    pub params: &'static [MaterialParam],
    /// Fraction of light reflected diffusely, 0 to 1.
    pub albedo: ColourOf,
    /// Radiance in every outward direction, W/(m² sr).
    pub emission: ColourOf,
}

/// Black, whatever the values: for a kind that reflects or emits nothing.
fn black(_values: &[[f32; 3]]) -> [f32; 3] {
    [0.0; 3]
}

macro_rules! materials {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        static ALL: &[&MaterialKind] = &[$(&$module::KIND),*];
    };
}

materials!(diffuse, emit);

/// Every kind of material, in the order of registration.
pub fn kinds() -> &'static [&'static MaterialKind] {
    ALL
}

/// The kind of this name.
pub fn kind(name: &str) -> Option<&'static MaterialKind> {
    kinds().iter().copied().find(|kind| kind.name == name)
}

/// A kind of material with its numbers.
#[derive(Clone, Debug)]
pub struct Material {
    /// Its name in the scene.
    pub name: String,
    /// What kind it is.
    pub kind: &'static MaterialKind,
    /// The value of each of the kind's parameters, in order; a number is the first of the three.
    pub values: Vec<[f32; 3]>,
}

impl Material {
    /// What an object without `material=` is made of: white, diffuse 0.8, named `default`.
    pub fn default_white() -> Self {
        Self { name: "default".to_owned(), kind: &diffuse::KIND, values: vec![[0.8; 3]] }
    }
    /// Value of the parameter of this name.
    pub fn value(&self, name: &str) -> Option<[f32; 3]> {
        self.kind.params.iter().position(|param| param.name == name).map(|index| self.values[index])
    }
    /// Fraction of light reflected diffusely, 0 to 1.
    pub fn albedo(&self) -> [f32; 3] {
        (self.kind.albedo)(&self.values)
    }
    /// Radiance in every outward direction, W/(m² sr); black for what is no light.
    pub fn emission(&self) -> [f32; 3] {
        (self.kind.emission)(&self.values)
    }
    /// Whether it emits at all.
    pub fn emits(&self) -> bool {
        self.emission().iter().any(|&v| v > 0.0)
    }
}
