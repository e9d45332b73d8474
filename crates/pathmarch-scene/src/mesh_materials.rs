//! Materials of mesh files as materials of a scene.
//!
//! The metallic-roughness material of glTF is `principled`; one that emits is `emit`, which reflects nothing.

use crate::materials::{self, Material};
use pathmarch_mesh::material::Material as Source;

/// Material of a scene for one of a mesh file.
pub(crate) fn material(source: &Source) -> Material {
    let emission = source.emission.to_array();
    let is_emitter = emission.iter().any(|&v| v > 0.0) && source.emission_texture.is_none();
    let kind = materials::kind(if is_emitter { "emit" } else { "principled" }).expect("is registered");
    let mut material = Material::new(&source.name, kind);
    let colour = source.base_colour.clamp(glam::Vec3::ZERO, glam::Vec3::ONE).to_array();
    let coat = source.clearcoat.as_ref();
    for (index, param) in kind.params.iter().enumerate() {
        let number = |value: f32| [value, 0.0, 0.0];
        material.values[index] = match param.name() {
            "radiance" => emission,
            "colour" => colour,
            "metallic" => number(source.metallic),
            "roughness" => number(source.roughness),
            "ior" => number(source.ior.clamp(1.0, 10.0)),
            "coat" => number(coat.map_or(0.0, |coat| coat.factor)),
            "coat-roughness" => number(coat.map_or(0.0, |coat| coat.roughness)),
            "transmission" => number(source.transmission),
            _ => continue,
        };
    }
    material
}
