//! Materials as a renderer reads them.

use super::textured_material::TexturedMaterial;
use crate::wgsl::{shared_constants, shared_struct};
use glam::Vec3;
use pathmarch_scene::Material;
use pathmarch_scene::materials::{self, BsdfParameters};

shared_struct! {
    /// Material.
    pub(crate) struct MaterialRecord as Material {
        /// Emitted radiance, W/(m² sr).
        pub(crate) emission: [f32; 3],
        /// [`EMITS`], [`DELTA`], [`TRANSMITS`].
        pub(crate) flags: u32,
        /// Absorption coefficient of the inside, per metre.
        pub(crate) absorption: [f32; 3],
        /// Index into [`materials::kinds`].
        pub(crate) kind: u32,
        /// Parameters of the BSDF.
        pub(crate) numbers: BsdfParameters,
    }
}

shared_constants! {
    /// Emitter; it does not reflect.
    pub(crate) const EMITS: u32 = 1;
    /// BSDF of delta distributions only: no light is sampled there.
    pub(crate) const DELTA: u32 = 2;
    /// BSDF that transmits.
    pub(crate) const TRANSMITS: u32 = 4;
}

/// Clear glass, which the shadow rays of fast caustics pass.
pub(crate) const CLEAR: u32 = DELTA | TRANSMITS;

impl MaterialRecord {
    pub(super) fn new(material: &Material, textured: &TexturedMaterial) -> Self {
        let kind = materials::kinds().iter().position(|kind| std::ptr::eq(*kind, material.kind)).unwrap_or_default();
        let mut flags = EMITS * u32::from(material.emits());
        let mut numbers = BsdfParameters::default();
        if let Some(bsdf) = material.kind.bsdf {
            numbers = (bsdf.pack)(&material.values);
            let mut all = textured.extremes(&numbers);
            if all.is_empty() {
                all.push(numbers);
            }
            let flag = |flag: u32, set: bool| if set { flag } else { 0 };
            flags |= flag(DELTA, all.iter().all(bsdf.is_delta)) | flag(TRANSMITS, all.iter().any(bsdf.transmits));
        }
        Self { emission: material.emission(), flags, absorption: material.absorption(), kind: kind as u32, numbers }
    }

    /// Whether it emits.
    pub(crate) fn emits(&self) -> bool {
        self.flags & EMITS != 0
    }
}

/// Transmittance of clear glass with these parameters for light that goes straight on; `cosine` is that outside.
pub(crate) fn straight_transmittance(numbers: &BsdfParameters, cosine: f32) -> Vec3 {
    let [r, g, b, _, ior, ..] = *numbers;
    Vec3::new(r, g, b) * (1.0 - materials::fresnel(cosine, ior))
}
