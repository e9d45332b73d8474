//! Material records: emission, absorption, flags and BSDF parameters.

use super::flag_if;
use super::textured_material::TexturedMaterial;
use crate::wgsl::{shared_constants, shared_struct};
use pathmarch_scene::Material;
use pathmarch_scene::materials::{self, BsdfParameters};

shared_struct! {
    /// Material.
    pub(crate) struct MaterialRecord as Material {
        /// Emitted radiance, W/(m² sr).
        pub(crate) emission: [f32; 3],
        /// Flags [`EMITS`], [`DELTA`], [`TRANSMITS`], [`GLOSSY`], [`GLOWS`], [`DISPERSES`], [`BOUNDARY`], [`FOCUSES`] and
        /// [`LAMBERTIAN`].
        pub(crate) flags: u32,
        /// Absorption coefficient of the solid, per metre.
        pub(crate) absorption: [f32; 3],
        /// Index of the kind in [`materials::kinds`].
        pub(crate) kind: u32,
        /// Parameters of the BSDF.
        pub(crate) parameters: BsdfParameters,
    }
}

shared_constants! {
    /// Emitter. It does not reflect.
    pub(crate) const EMITS: u32 = 1;
    /// BSDF of delta distributions only, for which no light is sampled.
    pub(crate) const DELTA: u32 = 2;
    /// Transmissive BSDF.
    pub(crate) const TRANSMITS: u32 = 4;
    /// BSDF that looks different from other directions: it reflects specularly and is not rough.
    pub(crate) const GLOSSY: u32 = 8;
    /// Surface that emits and scatters light.
    pub(crate) const GLOWS: u32 = 16;
    /// BSDF that depends on the wavelength.
    pub(crate) const DISPERSES: u32 = 32;
    /// Boundary of a medium, which light passes straight and unchanged.
    pub(crate) const BOUNDARY: u32 = 64;
    /// Surface that throws caustics: clear or slightly frosted glass, and mirrors or slightly rough metal.
    pub(crate) const FOCUSES: u32 = 128;
    /// Lambertian BSDF.
    pub(crate) const LAMBERTIAN: u32 = 256;
}

/// Clear glass. Shadow rays of fast caustics pass through it.
pub(crate) const CLEAR: u32 = DELTA | TRANSMITS;

impl MaterialRecord {
    pub(super) fn new(material: &Material, textured: &TexturedMaterial) -> Self {
        let kind = materials::kinds().iter().position(|kind| std::ptr::eq(*kind, material.kind)).unwrap_or_default();
        let mut flags = flag_if(EMITS, material.is_lamp());
        let mut parameters = BsdfParameters::default();
        if let Some(bsdf) = material.kind.bsdf {
            parameters = (bsdf.pack)(&material.values);
            let mut all_parameters = textured.knot_parameters(&parameters);
            if all_parameters.is_empty() {
                all_parameters.push(parameters);
            }
            flags |= flag_if(DELTA, all_parameters.iter().all(bsdf.is_delta))
                | flag_if(LAMBERTIAN, bsdf.is_lambertian)
                | flag_if(FOCUSES, all_parameters.iter().all(bsdf.focuses))
                | flag_if(TRANSMITS, all_parameters.iter().any(bsdf.transmits))
                | flag_if(DISPERSES, bsdf.at_wavelength.is_some_and(|at| at(&parameters, 1.0) != parameters));
        }
        let glows = material.emits() || material.emission_texture.is_some();
        flags |= flag_if(GLOWS, glows && !material.is_lamp());
        flags |= flag_if(GLOSSY, is_glossy(material)) | flag_if(BOUNDARY, !material.kind.has_surface);
        Self { emission: material.emission(), flags, absorption: material.absorption(), kind: kind as u32, parameters }
    }

    /// Reports whether the material emits and reflects nothing.
    #[inline]
    pub(crate) fn emits(&self) -> bool {
        self.has(EMITS)
    }

    /// Reports whether this flag is set.
    #[inline]
    pub(crate) fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }
}

/// True if a material reflects specularly and is not rough.
fn is_glossy(material: &Material) -> bool {
    /// Roughness from which on reflections change little with the direction.
    const ROUGH: f32 = 0.6;
    let preview = (material.kind.preview)(&material.values);
    preview.specular[0] != [0.0; 3] && preview.roughness < ROUGH
}
