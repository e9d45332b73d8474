//! Materials: scattering, emission and absorption.
//!
//! A material is one file that declares a [`MaterialKind`]: name, documentation, source and parameters. The name in the
//! list below is the file and its registration; the parser, the reference page, both renderers and the tests read
//! [`kinds`]. A kind that scatters light has a [`Bsdf`]: `eval` and `sample` in Rust, and the same in the WGSL file of
//! its name.

pub mod albedo;
pub mod dispersion;
mod microfacet;
mod orbit_trap;

use crate::medium::Medium;
use crate::textures::{Decal, Pattern, Ramp, Texture};
pub use diffuse::DiffuseInLanes;
use glam::Vec3;
pub use glass::straight_transmittance;
pub use metal::MetalInLanes;
pub use microfacet::fresnel;
pub use orbit_trap::{OrbitTrap, Trap};
use pathmarch_field::number::{Mask8, Vec3 as FieldVec3};
use pathmarch_field::{Param, Range};
pub use principled::PrincipledInLanes;
use wide::f32x8;

/// Type of a material's parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParamKind {
    /// Linear Rec. 709; one number stands for three equal ones.
    Colour,
    /// One number.
    Number,
    /// `#true` or `#false`; 1 or 0 as a value.
    Flag,
}

impl ParamKind {
    /// Its name in reference pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Colour => "colour",
            Self::Number => "number",
            Self::Flag => "flag",
        }
    }
}

/// Effect of a texture on a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texturing {
    /// None may.
    None,
    /// A colour that is copied to three of the [`BsdfParameters`], starting at this index.
    Colour(usize),
    /// A number from which [`Bsdf::pack`] computes some of the [`BsdfParameters`]; no other textured parameter may
    /// change those.
    Packed,
}

/// One parameter of a material.
#[derive(Clone, Debug)]
pub struct MaterialParam {
    /// Name, unit, default, range and documentation; of a colour, those of each channel.
    pub spec: Param,
    /// Colour or number.
    pub kind: ParamKind,
    /// Effect of a texture.
    pub texturing: Texturing,
}

impl MaterialParam {
    /// Name in the scene language.
    pub fn name(&self) -> &str {
        &self.spec.name
    }
    /// Value when not given; a number is the first of the three.
    pub fn default_value(&self) -> [f32; 3] {
        match self.kind {
            ParamKind::Colour => [self.spec.default; 3],
            ParamKind::Number | ParamKind::Flag => [self.spec.default, 0.0, 0.0],
        }
    }
    /// The default as in the scene language.
    pub fn default_in_words(&self) -> String {
        match self.kind {
            ParamKind::Flag => format!("#{}", self.spec.default > 0.0),
            ParamKind::Colour | ParamKind::Number => self.spec.default_in_words(),
        }
    }
    /// The range, as in "must be …".
    pub fn range_in_words(&self) -> String {
        match self.kind {
            ParamKind::Flag => "#true or #false".to_owned(),
            ParamKind::Colour | ParamKind::Number => self.spec.range_in_words(),
        }
    }
}

/// Dielectric inside a solid that transmits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Refractive index at the line d.
    pub ior: f32,
    /// Difference of the index between the lines F and C; 0 without dispersion.
    pub index_difference: f32,
    /// Where solids overlap, the one of the highest priority fills the space.
    pub priority: i32,
    /// True if every surface is a sheet, and nothing is inside.
    pub is_thin: bool,
}

impl Dielectric {
    /// Nothing, of the lowest priority among those of the default.
    pub const VACUUM: Self = Self { ior: 1.0, index_difference: 0.0, priority: 0, is_thin: false };

    /// Refractive index at an [offset](dispersion::index_offset).
    #[inline]
    pub fn index_at(&self, offset: f32) -> f32 {
        dispersion::dispersed_index(self.ior, self.index_difference, offset)
    }
}

/// A colour for each set of parameter values, in the order of [`MaterialKind::params`].
pub type ColourOf = fn(values: &[[f32; 3]]) -> [f32; 3];

/// Parameters of a BSDF as its functions read them, in Rust and in WGSL (there as the vectors a, b, c, d and the array
/// `table` of four more).
pub type BsdfParameters = [f32; 32];

/// A kind of material.
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
    /// Albedo for display and denoisers, 0 to 1.
    pub albedo: ColourOf,
    /// Radiance in every outward direction, W/(m² sr).
    pub emission: ColourOf,
    /// Medium in the solid.
    pub medium: fn(values: &[[f32; 3]]) -> Medium,
    /// Dielectric in the solid.
    pub dielectric: fn(values: &[[f32; 3]]) -> Dielectric,
    /// False for boundaries of media, which light passes straight and unchanged.
    pub has_surface: bool,
    /// Its preview.
    pub preview: fn(values: &[[f32; 3]]) -> PreviewMaterial,
    /// Scattering; `None` for pure emitters.
    pub bsdf: Option<&'static Bsdf>,
}

impl MaterialKind {
    /// True if it has a surface that light falls on, with bumps and the colours of orbit traps.
    pub(crate) fn is_shaded(&self) -> bool {
        self.bsdf.is_some() && self.has_surface
    }
}

/// A material as previews show it, without random scattering: a Lambertian surface under one glossy reflection, and
/// transmission. Colours are linear Rec. 709.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreviewMaterial {
    /// Diffuse albedo.
    pub diffuse: [f32; 3],
    /// Specular reflectance at normal incidence (F0) and at grazing incidence (F90).
    pub specular: [[f32; 3]; 2],
    /// Roughness of the specular reflection; 0 is a mirror.
    pub roughness: f32,
    /// Transmitted fraction of the light that is not reflected specularly.
    pub transmission: [f32; 3],
    /// Refractive index.
    pub ior: f32,
}

/// Scattering functions of a kind of material (BSDF).
///
/// Directions are unit vectors in a frame whose z is the normal on the side of `wo`, so that `wo.z` is above 0; both point
/// away from the surface, `wo` along the path back to the camera. `inside` says that this side is the inside of the solid.
/// Values are of radiance that travels from `wi` to `wo`.
pub struct Bsdf {
    /// Packs the values of parameters.
    pub pack: fn(values: &[[f32; 3]]) -> BsdfParameters,
    /// True if it scatters in single directions only, for which [`eval`](Self::eval) returns zero.
    pub is_delta: fn(&BsdfParameters) -> bool,
    /// True if it reflects the same radiance in every direction, and is sampled by the cosine.
    pub is_lambertian: bool,
    /// True if all its light stays close to the specular directions, so that it throws caustics.
    pub focuses: fn(&BsdfParameters) -> bool,
    /// True if light passes to the other side.
    pub transmits: fn(&BsdfParameters) -> bool,
    /// True if [`sample`](Self::sample) uses its third random number.
    pub chooses_lobes: bool,
    /// True if its WGSL reads the table of [`albedo`].
    pub reads_albedos: fn(&BsdfParameters) -> bool,
    /// True if `multiscatter` is above zero.
    pub compensates: fn(&BsdfParameters) -> bool,
    /// Parameters at an [offset](dispersion::index_offset) of refractive indices; `None` if it cannot disperse light.
    pub at_wavelength: Option<fn(&BsdfParameters, offset: f32) -> BsdfParameters>,
    /// Parameters with another refractive index, relative to what is outside of the surface; `None` if it has none.
    pub with_index: Option<fn(&BsdfParameters, index: f32) -> BsdfParameters>,
    /// The value and density of one direction.
    pub eval: fn(&BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Eval,
    /// A random direction of three uniform numbers in 0..1, the first two of them its position; `None` where the light
    /// is lost.
    pub sample: fn(&BsdfParameters, wo: Vec3, inside: bool, random: [f32; 3]) -> Option<Scattered>,
    /// Facets of the surface; `None` if all its light is scattered below the surface, or in single directions.
    pub facets: Option<&'static Facets>,
    /// The same for eight paths at once, where the surface does not transmit; `None` if there are none.
    pub in_lanes: Option<KindInLanes>,
    /// Sampling for eight paths at once where the surface is perfectly smooth and transmits.
    pub smooth_in_lanes: Option<&'static SmoothInLanes>,
    /// The same in WGSL: `NAME_eval(m, wo, wi, inside) -> vec4f` (value, density) and
    /// `NAME_sample(m, wo, inside, random) -> Scattered`, where `m` is the index of the material.
    pub wgsl: &'static str,
}

/// Facets of a surface, whose light depends on the direction of view.
pub struct Facets {
    /// Share of the facets in [`Bsdf::eval`] of two directions, for each channel, 0 to 1.
    pub share: fn(&BsdfParameters, wo: Vec3, wi: Vec3, inside: bool) -> Vec3,
    /// Width of the distribution of their normals: alpha of GGX, that of the smoothest layer.
    pub alpha: fn(&BsdfParameters) -> f32,
    /// Chance that a direction which [`Bsdf::sample`] chooses is one of theirs.
    pub chance: fn(&BsdfParameters, wo: Vec3, inside: bool) -> f32,
    /// True if they reflect in the colour of the surface.
    pub are_coloured: fn(&BsdfParameters) -> bool,
}

impl std::fmt::Debug for Bsdf {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Bsdf").finish_non_exhaustive()
    }
}

/// WGSL that the scattering functions share: microfacets, albedos, and `Scattered` as in Rust. That of [`dispersion`] is printed.
pub const SHARED_WGSL: [&str; 3] =
    [include_str!("scattering.wgsl"), include_str!("microfacet.wgsl"), include_str!("albedo.wgsl")];

/// Constants of the scattering functions in WGSL, with their values in Rust.
pub fn constants_wgsl() -> String {
    let constants = [
        ("MIRROR_ALPHA", microfacet::MIRROR_ALPHA),
        ("COAT_F0", principled::COAT_F0),
        ("MATCHED_INDEX", glass::MATCHED_INDEX),
        ("MIN_IOR", principled::MIN_IOR),
        ("COMPENSATED_CHANGE", glass::COMPENSATED_CHANGE),
    ];
    constants.map(|(name, value)| format!("const {name} = {value:?};\n")).concat()
}

/// Result of evaluating a BSDF for two directions.
#[derive(Clone, Copy, Debug)]
pub struct Eval {
    /// BSDF times the cosine of `wi`, 1/sr.
    pub value: Vec3,
    /// Density of `wi` in [`Bsdf::sample`], over solid angle, 1/sr.
    pub pdf: f32,
}

impl Eval {
    /// Nothing, and never sampled.
    pub const NONE: Self = Self { value: Vec3::ZERO, pdf: 0.0 };
}

/// A direction that light may come from.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// The direction; below the surface, `wi.z` < 0, where it was refracted.
    pub wi: Vec3,
    /// BSDF times cosine over density.
    pub weight: Vec3,
    /// Density over solid angle, 1/sr; 0 for one of single directions.
    pub pdf: f32,
    /// Refractive index beyond the surface over that before it; 1 where it was reflected.
    pub eta: f32,
}

/// Materials whose scattering functions also exist for eight paths at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KindInLanes {
    /// [`DiffuseInLanes`].
    Diffuse,
    /// [`MetalInLanes`].
    Metal,
    /// [`PrincipledInLanes`].
    Principled,
}

/// [`BsdfParameters`] of eight surfaces.
pub struct ParametersInLanes<'a> {
    /// The first of them, number by number.
    first: [f32x8; 16],
    surfaces: [&'a BsdfParameters; 8],
}

impl<'a> ParametersInLanes<'a> {
    /// Parameters of these surfaces, of which functions read the first `count` in lanes, at most 16.
    #[inline(always)]
    pub fn new(surfaces: [&'a BsdfParameters; 8], count: usize) -> Self {
        let mut first = [f32x8::ZERO; 16];
        for (k, eight) in first.chunks_exact_mut(8).enumerate().filter(|(k, _)| 8 * k < count) {
            let mut rows = [f32x8::ZERO; 8];
            for (row, parameters) in rows.iter_mut().zip(surfaces) {
                let mut numbers = [0.0; 8];
                numbers.copy_from_slice(&parameters[8 * k..8 * k + 8]);
                *row = f32x8::from(numbers);
            }
            eight.copy_from_slice(&f32x8::transpose(rows));
        }
        Self { first, surfaces }
    }
}

/// Scattering functions of eight opaque surfaces, each seen from a direction `wo`, as those of [`Bsdf`] for one.
pub trait BsdfInLanes: Sized {
    /// Number of parameters that they read in lanes.
    const PARAMETERS: usize;
    /// What does not depend on `wi`; `inside` is true where `wo` is within the solid.
    fn new(parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, inside: Mask8) -> Self;
    /// The values and densities of a direction of each.
    fn eval(&self, parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, wi: FieldVec3<f32x8>) -> EvalInLanes;
    /// A random direction of each, of three uniform numbers in 0..1, as [`Bsdf::sample`].
    fn sample(&self, parameters: &ParametersInLanes, wo: FieldVec3<f32x8>, random: [f32x8; 3]) -> ScatteredInLanes;
}

/// Sampling of a perfectly smooth interface for eight paths at once, as [`Bsdf::sample`] for one.
pub struct SmoothInLanes {
    /// True if it serves a surface with these parameters.
    pub is_smooth: fn(&BsdfParameters) -> bool,
    /// A random direction of each, for `wo` from the inside of the solid or not, of the random number that chooses the lobe.
    pub sample: fn(&ParametersInLanes, FieldVec3<f32x8>, Mask8, f32x8) -> SmoothSampleInLanes,
}

impl SmoothInLanes {
    /// Number of parameters that [`sample`](Self::sample) reads in lanes, at most.
    pub const PARAMETERS: usize = 8;
}

/// [`Scattered`] of eight smooth interfaces, whose densities are those of single directions.
pub struct SmoothSampleInLanes {
    /// The direction.
    pub wi: FieldVec3<f32x8>,
    /// Weight of the light from there.
    pub weight: FieldVec3<f32x8>,
    /// As in [`Scattered`].
    pub eta: f32x8,
}

/// [`Eval`] of eight surfaces.
pub struct EvalInLanes {
    /// BSDF times the cosine of `wi`, 1/sr.
    pub value: FieldVec3<f32x8>,
    /// Density of `wi`, over solid angle, 1/sr.
    pub pdf: f32x8,
}

/// [`Scattered`] of eight surfaces. Light is lost where `wi.z` is not above 0.
pub struct ScatteredInLanes {
    /// The direction.
    pub wi: FieldVec3<f32x8>,
    /// BSDF times cosine over density.
    pub weight: FieldVec3<f32x8>,
    /// Density over solid angle, 1/sr; 0 for one of single directions.
    pub pdf: f32x8,
}

/// Colour in the first three parameters.
fn colour_of(parameters: &BsdfParameters) -> Vec3 {
    Vec3::new(parameters[0], parameters[1], parameters[2])
}

/// Black, whatever the values: for a kind that emits nothing.
fn black(_values: &[[f32; 3]]) -> [f32; 3] {
    [0.0; 3]
}

/// Nothing, whatever the values: for a kind of opaque solids.
fn vacuum(_values: &[[f32; 3]]) -> Medium {
    Medium::VACUUM
}

/// Nothing, whatever the values: for a kind without refraction.
fn no_dielectric(_values: &[[f32; 3]]) -> Dielectric {
    Dielectric::VACUUM
}

/// A colour, grey by default.
const fn colour(
    name: &'static str,
    default: f32,
    range: Range,
    doc: &'static str,
    texturing: Texturing,
) -> MaterialParam {
    MaterialParam { spec: Param::within(name, default, range, doc), kind: ParamKind::Colour, texturing }
}

/// A number from 0 to 1.
const fn fraction(name: &'static str, default: f32, doc: &'static str) -> MaterialParam {
    let spec = Param::between(name, default, 0.0, 1.0, doc);
    MaterialParam { spec, kind: ParamKind::Number, texturing: Texturing::Packed }
}

/// The parameter `roughness`.
const fn roughness(default: f32) -> MaterialParam {
    fraction("roughness", default, "0 is a mirror, 1 as rough as can be; the microfacets' alpha is its square.")
}

/// The parameter `multiscatter`.
const fn multiscatter() -> MaterialParam {
    fraction(
        "multiscatter",
        0.0,
        "Share of the light lost between the facets of a rough surface that is given back; 0 is single scattering.",
    )
}

/// The parameter `emission`.
const fn emission() -> MaterialParam {
    colour(
        "emission",
        0.0,
        Range::NOT_NEGATIVE,
        "Radiance that it emits in every outward direction, beside what it scatters, W/(m² sr).",
        Texturing::None,
    )
}

/// The parameter `absorb`.
const fn absorption() -> MaterialParam {
    colour(
        "absorb",
        0.0,
        Range::NOT_NEGATIVE,
        "What the inside absorbs, per metre: exp(-absorb × length) passes.",
        Texturing::None,
    )
}

/// The parameter `scatter`, or the first one of a medium.
const fn scattering(name: &'static str, default: f32) -> MaterialParam {
    colour(
        name,
        default,
        Range::NOT_NEGATIVE,
        "Scattering coefficient of the inside, per metre: light is scattered once on a way of 1 / scatter, on average.",
        Texturing::None,
    )
}

/// The parameter `anisotropy`.
const fn anisotropy() -> MaterialParam {
    let doc = "Mean cosine of scattering angles inside: 0 in all directions, above 0 forwards, below 0 backwards.";
    MaterialParam {
        spec: Param::within("anisotropy", 0.0, Range::between(-1.0, 1.0), doc),
        kind: ParamKind::Number,
        texturing: Texturing::None,
    }
}

/// The parameter `glow`.
const fn glow() -> MaterialParam {
    colour("glow", 0.0, Range::NOT_NEGATIVE, "Radiance that a metre of the inside emits, W/(m³ sr).", Texturing::None)
}

/// The parameter `ior`.
const fn ior() -> MaterialParam {
    let spec =
        Param::between(IOR, 1.5, 1.0, 10.0, "Refractive index: water 1.33, glass 1.5, diamond 2.42; an air bubble 1.");
    MaterialParam { spec, kind: ParamKind::Number, texturing: Texturing::None }
}

/// The parameter `abbe`.
const fn abbe() -> MaterialParam {
    let doc = "Abbe number: crown glass 60, flint 30, diamond 55; small ones spread colours more, 0 does not.";
    MaterialParam {
        spec: Param::within("abbe", 0.0, Range::from_to(0.0, 200.0), doc),
        kind: ParamKind::Number,
        texturing: Texturing::None,
    }
}

/// The parameter `priority`.
const fn priority() -> MaterialParam {
    let doc =
        "Where solids overlap, the one of the highest priority fills the space: give a vessel more than its water.";
    MaterialParam {
        spec: Param::count(PRIORITY, 0.0, -100.0, 100.0, doc),
        kind: ParamKind::Number,
        texturing: Texturing::None,
    }
}

/// The parameter `thin`.
const fn thin() -> MaterialParam {
    let doc = "Makes every surface a sheet with two faces, which does not bend light: windows and soap bubbles.";
    MaterialParam { spec: Param::count(THIN, 0.0, 0.0, 1.0, doc), kind: ParamKind::Flag, texturing: Texturing::None }
}

/// Name of the parameter of [`Dielectric::ior`].
pub(crate) const IOR: &str = "ior";
/// Name of the parameter of [`Dielectric::priority`].
pub(crate) const PRIORITY: &str = "priority";
/// Name of the parameter of [`Dielectric::is_thin`].
pub(crate) const THIN: &str = "thin";

macro_rules! materials {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        static ALL: &[&MaterialKind] = &[$(&$module::KIND),*];
    };
}

materials!(diffuse, metal, glass, principled, emit, medium);

/// Every kind of material, in the order of registration.
pub fn kinds() -> &'static [&'static MaterialKind] {
    ALL
}

/// The kind of this name.
pub fn kind(name: &str) -> Option<&'static MaterialKind> {
    kinds().iter().copied().find(|kind| kind.name == name)
}

/// A kind of material with values of its parameters.
#[derive(Clone, Debug)]
pub struct Material {
    /// Its name in the scene.
    pub name: String,
    /// Kind of the material.
    pub kind: &'static MaterialKind,
    /// The value of each of the kind's parameters, in order; a number is the first of the three.
    pub values: Vec<[f32; 3]>,
    /// Colours of fractals, in place of the first parameter.
    pub orbit_trap: Option<OrbitTrap>,
    /// Textured parameters. Their entries in `values` are averages.
    pub textured: Vec<TexturedParameter>,
    /// Pictures over the first parameter, a colour, from the lowest to the topmost.
    pub decals: Vec<Decal>,
    /// Bump texture that perturbs the normals.
    pub bump: Option<Bump>,
    /// Normal map of meshes.
    pub normal_map: Option<NormalMap>,
    /// Emitted radiance at the texture coordinates of a mesh, in place of a constant.
    pub emission_texture: Option<Texture>,
}

/// A parameter with a texture in place of a value.
#[derive(Clone, Debug)]
pub struct TexturedParameter {
    /// Index into the kind's parameters.
    pub param: usize,
    /// Varying values.
    pub texture: Texture,
    /// Mapping from values of the texture to values of the parameter.
    pub mapping: TextureMapping,
}

impl TexturedParameter {
    /// Average value of the parameter, for uses without textures.
    pub fn average(&self) -> [f32; 3] {
        match (&self.mapping, &self.texture.pattern) {
            (TextureMapping::Ramp(ramp), _) => ramp.mean(),
            (TextureMapping::Direct, Pattern::Picture { picture, .. }) => picture.mean().into(),
            (TextureMapping::Direct, Pattern::UvPicture { picture, mapping }) => {
                (picture.mean() * Vec3::from(mapping.factor)).into()
            }
            (TextureMapping::Direct, _) => [0.5; 3],
            (TextureMapping::Range([from, to]), _) => [0.5 * (from + to), 0.0, 0.0],
        }
    }
}

/// Mapping from values of a texture to values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum TextureMapping {
    /// Positions on a colour ramp.
    Ramp(Ramp),
    /// The colours of the texture itself.
    Direct,
    /// Linear from the first number, for 0, to the second, for 1.
    Range([f32; 2]),
}

/// Height of a bump texture.
pub static BUMP_HEIGHT: Param =
    Param::any("height", 0.005, "Height of a value of 1 above one of 0, outwards; below 0 it is inwards.");

/// Bump mapping: a texture that perturbs normals, without changing the shape (Blinn 1978).
#[derive(Clone, Debug)]
pub struct Bump {
    /// Varying values.
    pub texture: Texture,
    /// Height of a value of 1 above a value of 0, outwards, metres.
    pub height: f32,
}

/// Normal map: a picture of normals in tangent space, at the texture coordinates of a mesh.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// Picture whose red, green and blue are x, y and z, from -1 to 1. y points up in the picture.
    pub texture: Texture,
    /// Factor of x and y.
    pub scale: f32,
}

impl NormalMap {
    /// Normal in tangent space for a colour of the picture; z is above zero.
    pub fn normal(&self, colour: Vec3) -> Vec3 {
        let v = colour * 2.0 - 1.0;
        Vec3::new(v.x * self.scale, v.y * self.scale, v.z.max(1e-3))
    }
}

impl Material {
    /// A material of this kind with its defaults.
    pub fn new(name: &str, kind: &'static MaterialKind) -> Self {
        let values = kind.params.iter().map(MaterialParam::default_value).collect();
        Self {
            name: name.to_owned(),
            kind,
            values,
            orbit_trap: None,
            textured: Vec::new(),
            decals: Vec::new(),
            bump: None,
            normal_map: None,
            emission_texture: None,
        }
    }
    /// The material of objects without `material=`: white, diffuse 0.8, named `default`.
    pub fn default_white() -> Self {
        Self::new("default", &diffuse::KIND)
    }
    /// Value of the parameter of this name.
    pub fn value(&self, name: &str) -> Option<[f32; 3]> {
        self.kind.params.iter().position(|param| param.name() == name).map(|index| self.values[index])
    }
    /// Albedo for display and denoisers, 0 to 1.
    pub fn albedo(&self) -> [f32; 3] {
        (self.kind.albedo)(&self.values)
    }
    /// Absorption coefficient of the inside, 1/m.
    pub fn absorption(&self) -> [f32; 3] {
        self.medium().absorption
    }
    /// Medium in the solid.
    pub fn medium(&self) -> Medium {
        (self.kind.medium)(&self.values)
    }
    /// Dielectric in the solid.
    pub fn dielectric(&self) -> Dielectric {
        (self.kind.dielectric)(&self.values)
    }
    /// Its preview.
    pub fn preview(&self) -> PreviewMaterial {
        (self.kind.preview)(&self.values)
    }
    /// Radiance in every outward direction, W/(m² sr); black for what is no light.
    pub fn emission(&self) -> [f32; 3] {
        (self.kind.emission)(&self.values)
    }
    /// The same material with this factor of its emission.
    pub(crate) fn with_emission_scaled(&self, factor: f32) -> Self {
        let mut scaled = self.clone();
        let index =
            if self.is_lamp() { Some(0) } else { self.kind.params.iter().position(|param| param.name() == "emission") };
        if let Some(index) = index {
            scaled.values[index] = scaled.values[index].map(|channel| channel * factor);
        }
        scaled
    }
    /// True if light passes to the other side.
    pub fn transmits(&self) -> bool {
        self.kind.bsdf.is_some_and(|bsdf| (bsdf.transmits)(&(bsdf.pack)(&self.values)))
    }
    /// True if it emits and reflects nothing.
    pub fn is_lamp(&self) -> bool {
        self.kind.bsdf.is_none() && self.emits()
    }
    /// True if it is opaque and emits the same everywhere.
    pub fn is_even_lamp(&self) -> bool {
        self.emits() && !self.transmits() && self.emission_texture.is_none()
    }
    /// True if it emits.
    pub fn emits(&self) -> bool {
        self.emission().iter().any(|&v| v > 0.0)
    }
}
