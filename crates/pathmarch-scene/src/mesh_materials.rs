//! Materials of mesh files as materials of a scene.
//!
//! The metallic-roughness material of glTF 2.0 (section 3.9) is `principled`; one that emits and reflects nothing is `emit`.
//! Opacity is part of the mesh ([`MeshOpacity`]). **Limits.** The strength of specular reflection becomes a refractive
//! index of the same reflectance at normal incidence. Warnings name what is not shown.

use crate::materials::{self, Material, NormalMap, TextureMapping, TexturedParameter};
use crate::textures::{Channel, Pattern, Picture, Texture, UvMapping};
use glam::Vec3;
use pathmarch_field::Placement;
use pathmarch_field::mesh_shape::{AlphaTest, AlphaTexture, MaterialOpacity, MeshOpacity};
use pathmarch_mesh::material::{AlphaMode, Image, Material as Source, Texture as SourceTexture};
use std::collections::HashMap;
use std::sync::Arc;

/// Material of a scene for one of a mesh file, and what is not shown of it.
pub(crate) struct Converted {
    pub(crate) material: Material,
    pub(crate) warnings: Vec<String>,
}

/// Pictures of the images of a mesh file, each made once.
pub(crate) struct Pictures<'a> {
    images: &'a [Image],
    /// By image, and whether its codes are colours.
    made: HashMap<(usize, bool), Result<Arc<Picture>, String>>,
}

impl<'a> Pictures<'a> {
    pub(crate) fn new(images: &'a [Image]) -> Self {
        Self { images, made: HashMap::new() }
    }

    fn picture(&mut self, image: usize, is_colour: bool) -> Result<Arc<Picture>, String> {
        let images = self.images;
        let made = self.made.entry((image, is_colour)).or_insert_with(|| {
            let image = images.get(image).ok_or_else(|| "a texture names an image that does not exist".to_owned())?;
            let decoded = image.decode().map_err(|error| error.to_string())?;
            Ok(Arc::new(Picture::of_image(decoded.into_rgb8(), is_colour)))
        });
        made.clone()
    }

    /// Texture of a scene; `is_colour` for sRGB.
    fn texture(&mut self, source: &SourceTexture, is_colour: bool, channel: Channel) -> Result<Texture, String> {
        let picture = self.picture(source.image, is_colour)?;
        Ok(placed(picture, UvMapping { channel, ..mapping(source) }))
    }
}

fn placed(picture: Arc<Picture>, mapping: UvMapping) -> Texture {
    Texture { pattern: Pattern::UvPicture { picture, mapping }, pose: Placement::default().pose() }
}

fn rows(source: &SourceTexture) -> [[f32; 3]; 2] {
    let matrix = source.transform.matrix();
    [0, 1].map(|k| [matrix.x_axis[k], matrix.y_axis[k], matrix.z_axis[k]])
}

fn mapping(source: &SourceTexture) -> UvMapping {
    UvMapping {
        set: source.uv_set.min(1),
        rows: rows(source),
        wrap: source.wrap,
        is_nearest: source.is_nearest,
        ..UvMapping::default()
    }
}

/// Refractive index whose reflectance at normal incidence is that of `ior` times the strength of specular reflection.
fn effective_ior(source: &Source) -> f32 {
    let ior = source.ior.clamp(1.0, 10.0);
    let strength = source.specular * source.specular_colour.element_sum() / 3.0;
    if strength == 1.0 || source.transmission > 0.0 {
        return ior;
    }
    let root = (((ior - 1.0) / (ior + 1.0)).powi(2) * strength).clamp(0.0, 0.66).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// Absorption coefficient of the interior, per metre.
fn absorption(source: &Source) -> [f32; 3] {
    let Some(volume) = source.volume.as_ref().filter(|volume| volume.thickness > 0.0) else { return [0.0; 3] };
    // A colour of zero would absorb infinitely.
    (-volume.attenuation_colour.max(Vec3::splat(1e-4)).ln() / volume.attenuation_distance).max(Vec3::ZERO).to_array()
}

/// Material of a scene for one of a mesh file, whose vertices may have colours.
pub(crate) fn convert(source: &Source, pictures: &mut Pictures, has_vertex_colours: bool) -> Converted {
    let mut warnings = unsupported(source);
    let emission = source.emission.to_array();
    let emits = emission.iter().any(|&v| v > 0.0);
    let reflects_nothing = source.base_colour == Vec3::ZERO && source.metallic == 1.0;
    let is_lamp = emits && source.emission_texture.is_none() && reflects_nothing;
    let kind = materials::kind(if is_lamp { "emit" } else { "principled" }).expect("is registered");
    let mut material = Material::new(&source.name, kind);
    let colour = source.base_colour.clamp(Vec3::ZERO, Vec3::ONE).to_array();
    let coat = source.clearcoat.as_ref();
    let number = |value: f32| [value, 0.0, 0.0];
    for (index, param) in kind.params.iter().enumerate() {
        let (value, texture) = match param.name() {
            "radiance" | "emission" => (emission, None),
            "metallic" => {
                (number(source.metallic), with(&source.metallic_roughness_texture, Channel::Blue, source.metallic))
            }
            "roughness" => {
                (number(source.roughness), with(&source.metallic_roughness_texture, Channel::Green, source.roughness))
            }
            "ior" => (number(effective_ior(source)), None),
            "coat" => {
                let factor = coat.map_or(0.0, |coat| coat.factor);
                (number(factor), coat.and_then(|coat| with(&coat.texture, Channel::Red, factor)))
            }
            "coat-roughness" => {
                let factor = coat.map_or(0.0, |coat| coat.roughness);
                (number(factor), coat.and_then(|coat| with(&coat.roughness_texture, Channel::Green, factor)))
            }
            "transmission" => {
                (number(source.transmission), with(&source.transmission_texture, Channel::Red, source.transmission))
            }
            "absorb" => (absorption(source), None),
            "colour" => {
                material.values[index] = colour;
                match base_colour(source, pictures, has_vertex_colours) {
                    Ok(None) => {}
                    Ok(Some(texture)) => {
                        let mapping = TextureMapping::Direct;
                        material.textured.push(TexturedParameter { param: index, texture, mapping });
                    }
                    Err(error) => warnings.push(format!("{error}; its factor is shown instead")),
                }
                continue;
            }
            _ => continue,
        };
        material.values[index] = value;
        let Some((texture, channel, factor)) = texture else { continue };
        match pictures.texture(texture, false, channel) {
            Ok(texture) => {
                let mapping = TextureMapping::Range([0.0, factor]);
                material.textured.push(TexturedParameter { param: index, texture, mapping });
            }
            Err(error) => warnings.push(format!("{error}; its factor is shown instead")),
        }
    }
    for textured in &material.textured {
        material.values[textured.param] = textured.average();
    }
    if let Some(texture) = &source.normal_texture {
        match pictures.texture(texture, false, Channel::Luminance) {
            Ok(texture) => material.normal_map = Some(NormalMap { texture, scale: source.normal_scale }),
            Err(error) => warnings.push(format!("{error}; the normals of the mesh are shown")),
        }
    }
    if let Some(texture) = source.emission_texture.as_ref().filter(|_| emits) {
        match pictures.picture(texture.image, true) {
            Ok(picture) => {
                let average = picture.mean() * source.emission;
                if let Some(index) = kind.params.iter().position(|param| param.name() == "emission") {
                    material.values[index] = average.to_array();
                }
                material.emission_texture = Some(placed(picture, UvMapping { factor: emission, ..mapping(texture) }));
            }
            Err(error) => warnings.push(format!("{error}; its factor is shown instead")),
        }
    }
    Converted { material, warnings }
}

/// Texture of a number with this factor, if there is one.
fn with(texture: &Option<SourceTexture>, channel: Channel, factor: f32) -> Option<(&SourceTexture, Channel, f32)> {
    texture.as_ref().map(|texture| (texture, channel, factor))
}

/// Texture of the base colour, which the factor and the colours of the vertices multiply.
fn base_colour(source: &Source, pictures: &mut Pictures, has_vertex_colours: bool) -> Result<Option<Texture>, String> {
    let factor = source.base_colour.to_array();
    let (picture, mapping) = match &source.base_colour_texture {
        Some(texture) => (pictures.picture(texture.image, true)?, mapping(texture)),
        None if has_vertex_colours => (Arc::new(Picture::white()), UvMapping::default()),
        None => return Ok(None),
    };
    Ok(Some(placed(picture, UvMapping { factor, has_vertex_colours, ..mapping })))
}

/// Opacity of materials; `None` if all are opaque and two-sided. A texture of alpha that cannot be decoded is left out;
/// [`convert`] reports it.
pub(crate) fn opacity(sources: &[Source], images: &[Image]) -> Option<Arc<MeshOpacity>> {
    let material = |source: &Source| {
        let test = match source.alpha_mode {
            AlphaMode::Opaque => AlphaTest::Opaque,
            AlphaMode::Mask { cutoff } => AlphaTest::Mask(cutoff),
            AlphaMode::Blend => AlphaTest::Blend,
        };
        let texture = source.base_colour_texture.as_ref().filter(|_| test != AlphaTest::Opaque);
        MaterialOpacity {
            test,
            // Rays leave glass through the backs of its triangles.
            is_single_sided: !source.is_double_sided && source.transmission == 0.0,
            alpha: source.alpha,
            texture: texture.and_then(|texture| alpha_texture(texture, images)),
        }
    };
    let materials: Vec<MaterialOpacity> = sources.iter().map(material).collect();
    let is_opaque = materials.iter().all(MaterialOpacity::is_opaque);
    (!is_opaque).then(|| Arc::new(MeshOpacity { materials }))
}

/// Alpha of a texture; `None` if it has none.
fn alpha_texture(source: &SourceTexture, images: &[Image]) -> Option<AlphaTexture> {
    let image = images.get(source.image)?.decode().ok()?;
    if !image.color().has_alpha() {
        return None;
    }
    let image = image.into_rgba8();
    let (width, height) = image.dimensions();
    Some(AlphaTexture {
        width,
        height,
        texels: image.pixels().map(|pixel| pixel.0[3]).collect(),
        uv_set: source.uv_set.min(1),
        rows: rows(source),
        wrap: source.wrap,
        is_nearest: source.is_nearest,
    })
}

/// Parts of a material that are not shown.
fn unsupported(source: &Source) -> Vec<String> {
    let coat = source.clearcoat.as_ref();
    let is_thin = source.transmission > 0.0 && source.volume.as_ref().is_none_or(|volume| volume.thickness == 0.0);
    let is_coloured = source.specular_colour != Vec3::splat(source.specular_colour.x);
    let has_strength = source.specular != 1.0 || source.specular_colour != Vec3::ONE;
    let parts = [
        (is_thin, "its thin walls; they refract as solid glass"),
        (source.specular_texture.is_some(), "the texture of its specular strength; the factor is shown"),
        (source.specular_colour_texture.is_some(), "the texture of its specular colour; the factor is shown"),
        (is_coloured, "its specular colour; its mean is shown"),
        (has_strength && source.transmission > 0.0, "its specular strength; it is 1"),
        (
            coat.is_some_and(|coat| coat.normal_texture.is_some()),
            "the normal texture of its coat; that of the base is shown",
        ),
    ];
    let name = if source.name.is_empty() { "a material".to_owned() } else { format!("material \"{}\"", source.name) };
    parts.iter().filter(|(is_there, _)| *is_there).map(|(_, what)| format!("{name}: {what}")).collect()
}
