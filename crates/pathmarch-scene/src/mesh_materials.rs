//! Materials of mesh files as materials of a scene.
//!
//! The metallic-roughness material of glTF 2.0 (section 3.9) is `principled`; one that emits everywhere is `emit`, which reflects
//! nothing. The factor of a base colour is multiplied into its picture. **Limits.** Warnings name what is not shown.

use crate::materials::{self, Material, TextureMapping, TexturedParameter};
use crate::textures::{Channel, Pattern, Picture, Texture, UvMapping, tinted};
use pathmarch_field::Placement;
use pathmarch_mesh::material::{AlphaMode, Image, Material as Source, Texture as SourceTexture};
use std::sync::Arc;

/// Material of a scene for one of a mesh file with these images, and what is not shown of it.
pub(crate) fn material(source: &Source, images: &[Image]) -> (Material, Vec<String>) {
    let mut warnings = unsupported(source);
    let emission = source.emission.to_array();
    let is_emitter = emission.iter().any(|&v| v > 0.0) && source.emission_texture.is_none();
    let kind = materials::kind(if is_emitter { "emit" } else { "principled" }).expect("is registered");
    let mut material = Material::new(&source.name, kind);
    let colour = source.base_colour.clamp(glam::Vec3::ZERO, glam::Vec3::ONE).to_array();
    let coat = source.clearcoat.as_ref();
    for (index, param) in kind.params.iter().enumerate() {
        let number = |value: f32| [value, 0.0, 0.0];
        let texture_of_number = |channel: Channel, factor: f32| {
            let texture = source.metallic_roughness_texture.as_ref()?;
            Some((texture, channel, None, TextureMapping::Range([0.0, factor])))
        };
        let (value, texture) = match param.name() {
            "radiance" => (emission, None),
            "colour" => {
                let texture = source.base_colour_texture.as_ref();
                let with_factor = |texture| (texture, Channel::Luminance, Some(colour), TextureMapping::Direct);
                (colour, texture.map(with_factor))
            }
            "metallic" => (number(source.metallic), texture_of_number(Channel::Blue, source.metallic)),
            "roughness" => (number(source.roughness), texture_of_number(Channel::Green, source.roughness)),
            "ior" => (number(source.ior.clamp(1.0, 10.0)), None),
            "coat" => (number(coat.map_or(0.0, |coat| coat.factor)), None),
            "coat-roughness" => (number(coat.map_or(0.0, |coat| coat.roughness)), None),
            "transmission" => (number(source.transmission), None),
            _ => continue,
        };
        material.values[index] = value;
        let Some((texture, channel, tint, mapping)) = texture else { continue };
        match pattern(texture, images, channel, tint) {
            Ok(pattern) => {
                let texture = Texture { pattern, pose: Placement::default().pose() };
                material.textured.push(TexturedParameter { param: index, texture, mapping });
            }
            Err(error) => warnings.push(format!("{error}; its factor is shown instead")),
        }
    }
    for textured in &material.textured {
        material.values[textured.param] = textured.average();
    }
    (material, warnings)
}

/// Picture of a texture; `tint` for colours.
fn pattern(
    texture: &SourceTexture,
    images: &[Image],
    channel: Channel,
    tint: Option<[f32; 3]>,
) -> Result<Pattern, String> {
    let image = images.get(texture.image).ok_or("a texture names an image that does not exist")?;
    let decoded = image.decode().map_err(|error| error.to_string())?.into_rgb8();
    let tinted = match tint {
        Some(factor) if factor != [1.0; 3] => tinted(&decoded, factor),
        _ => decoded,
    };
    let matrix = texture.transform.matrix();
    let row = |k: usize| [matrix.x_axis[k], matrix.y_axis[k], matrix.z_axis[k]];
    let mapping = UvMapping { set: texture.uv_set.min(1), rows: [row(0), row(1)], wrap: texture.wrap, channel };
    Ok(Pattern::UvPicture { picture: Arc::new(Picture::of_image(tinted, tint.is_some())), mapping })
}

/// Parts of a material that are not shown.
fn unsupported(source: &Source) -> Vec<String> {
    let coat = source.clearcoat.as_ref();
    let coat_textures = coat.is_some_and(|coat| {
        coat.texture.is_some() || coat.roughness_texture.is_some() || coat.normal_texture.is_some()
    });
    let parts = [
        (source.normal_texture.is_some(), "its normal texture; the normals of the mesh are shown"),
        (source.emission_texture.is_some(), "its emission texture; it does not emit"),
        (source.alpha_mode != AlphaMode::Opaque, "its alpha; it is opaque"),
        (source.transmission_texture.is_some(), "its transmission texture; the factor is shown"),
        (source.volume.is_some(), "its volume; nothing is absorbed"),
        (source.specular != 1.0 || source.specular_texture.is_some(), "its specular strength; it is 1"),
        (source.specular_colour != glam::Vec3::ONE, "its specular colour; it is white"),
        (coat_textures, "the textures of its coat; their factors are shown"),
    ];
    let name = if source.name.is_empty() { "a material".to_owned() } else { format!("material \"{}\"", source.name) };
    parts.iter().filter(|(is_there, _)| *is_there).map(|(_, what)| format!("{name}: {what}")).collect()
}
