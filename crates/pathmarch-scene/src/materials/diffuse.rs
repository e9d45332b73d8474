//! Lambert's surface: the same radiance in every direction, whatever the direction of the light (Lambert 1760,
//! "Photometria"). BRDF albedo / π.

use super::{MaterialKind, MaterialParam, ParamKind, black};

pub(super) static KIND: MaterialKind = MaterialKind {
    name: "diffuse",
    doc: "Matt surface that looks equally bright from everywhere.",
    source: "Lambert 1760, Photometria",
    params: &[MaterialParam {
        name: "albedo",
        kind: ParamKind::Colour,
        default: [0.8; 3],
        min: 0.0,
        max: 1.0,
        doc: "Fraction of the light that is reflected.",
    }],
    albedo: |values| values[0],
    emission: black,
};
