//! Materials, textures, lights and cameras.

use super::super::error::{Mistake, Warnings};
use super::json;
use crate::material::{
    AlphaMode, Camera, Clearcoat, Light, LightKind, Material, Projection, Texture, TextureTransform, Volume, Wrap,
};
use glam::{Vec2, Vec3};

/// Reads textures, given the image of each in the file: none if it cannot be shown.
pub struct TextureReader<'a> {
    pub root: &'a json::Root,
    /// Index of each image of the file in those that were read.
    pub images: &'a [Option<usize>],
    pub warnings: &'a mut Warnings,
}

impl TextureReader<'_> {
    /// Texture of a material; none if its image is missing, of which a warning was given.
    fn texture(&mut self, info: Option<&json::TextureInfo>, place: &str) -> Result<Option<Texture>, Mistake> {
        let Some(info) = info else { return Ok(None) };
        let missing = |what: &str, index: usize| Mistake::new(place, format!("{what} {index} does not exist"));
        let json = self.root.textures.get(info.index).ok_or_else(|| missing("texture", info.index))?;
        let Some(source) = json.source else {
            let message = "a texture has no image in a format that is supported; the material is shown without";
            self.warnings.add(format!("texture {}", info.index), message);
            return Ok(None);
        };
        let Some(image) = *self.images.get(source).ok_or_else(|| missing("image", source))? else { return Ok(None) };
        let default = json::Sampler::default();
        let sampler = match json.sampler {
            Some(index) => self.root.samplers.get(index).ok_or_else(|| missing("sampler", index))?,
            None => &default,
        };
        let transform = info.extensions.transform.as_ref();
        let uv_set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord);
        if uv_set > 1 {
            self.warnings.add(place, "only two sets of texture coordinates are supported; the first is shown");
        }
        Ok(Some(Texture {
            image,
            uv_set: if uv_set > 1 { 0 } else { uv_set },
            wrap: [sampler.wrap_s, sampler.wrap_t].map(wrap),
            is_nearest: sampler.mag_filter == Some(9728),
            transform: transform.map_or_else(TextureTransform::default, |transform| TextureTransform {
                offset: Vec2::from(transform.offset.unwrap_or([0.0; 2])),
                rotation_radians: transform.rotation,
                scale: Vec2::from(transform.scale.unwrap_or([1.0; 2])),
            }),
        }))
    }

    /// Material of a file.
    pub fn material(&mut self, index: usize, json: &json::Material) -> Result<Material, Mistake> {
        let place = format!("material {index}");
        let surface = &json.pbr_metallic_roughness;
        let [r, g, b, alpha] = surface.base_color_factor.unwrap_or([1.0; 4]);
        let strength = json.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength).unwrap_or(1.0);
        for name in json.extensions.others.keys() {
            let message =
                format!("extension {} is not supported; the material is shown without", super::shortened(name));
            self.warnings.add(place.as_str(), message);
        }
        let material = Material {
            name: json.name.clone(),
            base_colour: Vec3::new(r, g, b),
            alpha,
            base_colour_texture: self.texture(surface.base_color_texture.as_ref(), &place)?,
            metallic: surface.metallic_factor.unwrap_or(1.0),
            roughness: surface.roughness_factor.unwrap_or(1.0),
            metallic_roughness_texture: self.texture(surface.metallic_roughness_texture.as_ref(), &place)?,
            normal_texture: self.texture(json.normal_texture.as_ref(), &place)?,
            normal_scale: json.normal_texture.as_ref().and_then(|normal| normal.scale).unwrap_or(1.0),
            emission: strength * Vec3::from(json.emissive_factor),
            emission_texture: self.texture(json.emissive_texture.as_ref(), &place)?,
            alpha_mode: self.alpha_mode(json, &place),
            is_double_sided: json.double_sided,
            ..self.extended(&json.extensions, &place)?
        };
        Ok(self.limited(material, &place))
    }

    fn alpha_mode(&mut self, json: &json::Material, place: &str) -> AlphaMode {
        match json.alpha_mode.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask { cutoff: json.alpha_cutoff.unwrap_or(0.5) },
            Some("BLEND") => AlphaMode::Blend,
            Some(mode) => {
                self.warnings.add(place, format!("unknown alpha mode {}; it is shown opaque", super::shortened(mode)));
                AlphaMode::Opaque
            }
        }
    }

    /// Material with the extensions alone.
    fn extended(&mut self, json: &json::MaterialExtensions, place: &str) -> Result<Material, Mistake> {
        let mut material = Material::default();
        if let Some(ior) = json.ior.as_ref().and_then(|ior| ior.ior) {
            // Zero stands for an infinite index: every reflection is total.
            material.ior = if ior == 0.0 { f32::MAX } else { ior.max(1.0) };
        }
        if let Some(transmission) = &json.transmission {
            material.transmission = transmission.transmission_factor;
            material.transmission_texture = self.texture(transmission.transmission_texture.as_ref(), place)?;
        }
        if let Some(specular) = &json.specular {
            material.specular = specular.specular_factor.unwrap_or(1.0);
            material.specular_texture = self.texture(specular.specular_texture.as_ref(), place)?;
            material.specular_colour = Vec3::from(specular.specular_color_factor.unwrap_or([1.0; 3]));
            material.specular_colour_texture = self.texture(specular.specular_color_texture.as_ref(), place)?;
        }
        if let Some(coat) = json.clearcoat.as_ref().filter(|coat| coat.clearcoat_factor > 0.0) {
            material.clearcoat = Some(Clearcoat {
                factor: coat.clearcoat_factor.min(1.0),
                texture: self.texture(coat.clearcoat_texture.as_ref(), place)?,
                roughness: coat.clearcoat_roughness_factor.clamp(0.0, 1.0),
                roughness_texture: self.texture(coat.clearcoat_roughness_texture.as_ref(), place)?,
                normal_texture: self.texture(coat.clearcoat_normal_texture.as_ref(), place)?,
            });
        }
        material.volume = json.volume.as_ref().map(|volume| Volume {
            thickness: volume.thickness_factor.max(0.0),
            attenuation_distance: volume
                .attenuation_distance
                .filter(|distance| *distance > 0.0)
                .unwrap_or(f32::INFINITY),
            attenuation_colour: Vec3::from(volume.attenuation_color.unwrap_or([1.0; 3])).clamp(Vec3::ZERO, Vec3::ONE),
        });
        Ok(material)
    }

    /// Limits the factors to the ranges of the specification.
    fn limited(&mut self, mut material: Material, place: &str) -> Material {
        let before = material.clone();
        material.base_colour = material.base_colour.clamp(Vec3::ZERO, Vec3::ONE);
        for factor in [
            &mut material.alpha,
            &mut material.metallic,
            &mut material.roughness,
            &mut material.transmission,
            &mut material.specular,
        ] {
            *factor = factor.clamp(0.0, 1.0);
        }
        material.specular_colour = material.specular_colour.max(Vec3::ZERO);
        let is_finite = material.emission.is_finite();
        material.emission = if is_finite { material.emission.max(Vec3::ZERO) } else { Vec3::ZERO };
        if before != material {
            self.warnings.add(place, "factors beyond their range are clamped to it");
        }
        material
    }
}

fn wrap(code: Option<u32>) -> Wrap {
    match code {
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    }
}

/// Lights of a file.
pub fn lights(root: &json::Root, warnings: &mut Warnings) -> Vec<Light> {
    let light = |(index, json): (usize, &json::Light)| {
        let spot = json.spot.as_ref();
        let outer_cone_radians = spot.and_then(|spot| spot.outer_cone_angle).unwrap_or(std::f32::consts::FRAC_PI_4);
        let kind = match json.kind.as_str() {
            "directional" => LightKind::Directional,
            "spot" => LightKind::Spot {
                inner_cone_radians: spot.and_then(|spot| spot.inner_cone_angle).unwrap_or(0.0),
                outer_cone_radians,
            },
            kind => {
                if kind != "point" {
                    let message = format!("unknown kind {}; a point light is shown", super::shortened(kind));
                    warnings.add(format!("light {index}"), message);
                }
                LightKind::Point
            }
        };
        let colour = Vec3::from(json.color.unwrap_or([1.0; 3])).max(Vec3::ZERO);
        let intensity = json.intensity.unwrap_or(1.0).max(0.0);
        Light { name: json.name.clone(), colour, intensity, range: json.range, kind }
    };
    root.extensions.lights.iter().flat_map(|lights| &lights.lights).enumerate().map(light).collect()
}

/// Cameras of a file.
pub fn cameras(root: &json::Root) -> Result<Vec<Camera>, Mistake> {
    let camera = |(index, json): (usize, &json::Camera)| {
        let projection = match (&json.perspective, &json.orthographic) {
            (Some(perspective), _) => {
                Projection::Perspective { y_fov_radians: perspective.yfov, aspect_ratio: perspective.aspect_ratio }
            }
            (None, Some(parallel)) => Projection::Orthographic { half_size: Vec2::new(parallel.xmag, parallel.ymag) },
            (None, None) => return Err(Mistake::new(format!("camera {index}"), "it has no projection")),
        };
        Ok(Camera { name: json.name.clone(), projection })
    };
    root.cameras.iter().enumerate().map(camera).collect()
}
