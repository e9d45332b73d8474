//! Emitter: the same radiance in every outward direction, no reflection. Its power is π A times the radiance, for a
//! surface of area A.

use super::{MaterialKind, MaterialParam, ParamKind, PreviewMaterial, Texturing, black};

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "emit",
    doc: "Lamp: the same radiance in every outward direction; reflects nothing.",
    source: "Lambert 1760, Photometria",
    params: &[MaterialParam {
        name: "radiance",
        kind: ParamKind::Colour,
        default: [1.0; 3],
        min: 0.0,
        max: f32::MAX,
        doc: "Emitted radiance, W/(m² sr).",
        texturing: Texturing::None,
    }],
    albedo: black,
    emission: |values| values[0],
    absorption: black,
    preview: |_| PreviewMaterial::default(),
    bsdf: None,
};
