//! Emitter: the same radiance in every outward direction, no reflection. Its power is π A times the radiance, for a
//! surface of area A.

use super::{MaterialKind, PreviewMaterial, Texturing, black, colour, no_dielectric, vacuum};
use pathmarch_field::Range;

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "emit",
    doc: "Lamp: the same radiance in every outward direction; reflects nothing.",
    source: "Lambert 1760, Photometria",
    params: &[colour("radiance", 1.0, Range::NOT_NEGATIVE, "Emitted radiance, W/(m² sr).", Texturing::None)],
    albedo: black,
    emission: |values| values[0],
    medium: vacuum,
    dielectric: no_dielectric,
    has_surface: true,
    preview: |_| PreviewMaterial::default(),
    bsdf: None,
};
