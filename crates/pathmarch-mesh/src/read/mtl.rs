//! MTL: materials of OBJ files.
//!
//! **Idea.** The Phong material is translated: `Kd` becomes the base colour, the exponent `Ns` a roughness with the same width of
//! the highlight, `Ke` emission, `d` transparency. `Pr` and `Pm` give roughness and metalness directly, as many programs write.
//! **Differences.** `Ka` and `Ks` have no counterpart; a black `Ks` turns reflection off.
//!
//! **Source.** Wavefront 1990, appendix B5; the exponent's roughness after Walter et al. 2007, section 5.

use super::error::Warnings;
use super::files::{Companions, shortened};
use super::text;
use crate::material::{AlphaMode, Image, Material, Texture, Wrap};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// Materials by name, and the images that they use.
#[derive(Default)]
pub(super) struct MaterialLibrary {
    pub materials: HashMap<String, Material>,
    pub images: Vec<Image>,
    /// Index of each image by the name of its file; none if it cannot be read.
    files: HashMap<String, Option<usize>>,
    /// Number of libraries read.
    count: usize,
}

impl MaterialLibrary {
    /// Reports that no more libraries are read, so that a text which names one many times takes bounded time.
    pub fn is_full(&self) -> bool {
        self.count >= 100
    }
}

/// Adds the materials of an MTL file.
pub(super) fn read(bytes: &[u8], companions: &Companions, library: &mut MaterialLibrary, warnings: &mut Warnings) {
    library.count += 1;
    let text = text::decode(bytes);
    let mut current: Option<Material> = None;
    for (index, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let place = format!("material library, line {}", index + 1);
        if keyword == "newmtl" {
            let named = Material { name: rest.trim().to_string(), ..Material::plain() };
            if let Some(done) = current.replace(named) {
                library.materials.insert(done.name.clone(), done);
            }
        } else if let Some(material) = &mut current {
            let mut context = Context { companions, library, warnings, place };
            context.statement(material, keyword, rest.trim());
        }
    }
    if let Some(done) = current {
        library.materials.insert(done.name.clone(), done);
    }
}

struct Context<'a> {
    companions: &'a Companions<'a>,
    library: &'a mut MaterialLibrary,
    warnings: &'a mut Warnings,
    place: String,
}

impl Context<'_> {
    fn statement(&mut self, material: &mut Material, keyword: &str, rest: &str) {
        match keyword.to_ascii_lowercase().as_str() {
            "kd" => material.base_colour = self.colour(rest).unwrap_or(material.base_colour),
            "ke" => material.emission = self.colour(rest).unwrap_or(material.emission),
            "ks" if self.colour(rest) == Some(Vec3::ZERO) => material.specular = 0.0,
            "ns" => material.roughness = self.number(rest).map_or(material.roughness, roughness_of_exponent),
            "ni" => material.ior = self.number(rest).unwrap_or(1.5).clamp(1.0, 10.0),
            "d" => self.set_alpha(material, self.number(rest.trim_start_matches("-halo"))),
            "tr" => self.set_alpha(material, self.number(rest).map(|transparency| 1.0 - transparency)),
            "pr" => material.roughness = self.number(rest).unwrap_or(material.roughness).clamp(0.0, 1.0),
            "pm" => material.metallic = self.number(rest).unwrap_or(material.metallic).clamp(0.0, 1.0),
            "map_kd" => {
                material.base_colour_texture = self.texture(rest).map(|(texture, _)| texture);
                // The texture replaces a black colour that many programs write beside it.
                if material.base_colour == Vec3::ZERO && material.base_colour_texture.is_some() {
                    material.base_colour = Vec3::ONE;
                }
            }
            "map_ke" => {
                material.emission_texture = self.texture(rest).map(|(texture, _)| texture);
                if material.emission == Vec3::ZERO && material.emission_texture.is_some() {
                    material.emission = Vec3::ONE;
                }
            }
            "norm" | "map_kn" => {
                if let Some((texture, scale)) = self.texture(rest) {
                    (material.normal_texture, material.normal_scale) = (Some(texture), scale);
                }
            }
            "map_bump" | "bump" => self.ignored("bump map", "a smooth surface"),
            "disp" => self.ignored("displacement map", "a smooth surface"),
            "map_d" => self.ignored("opacity map", "the material's opacity"),
            "map_pr" | "map_pm" => self.ignored("roughness or metalness map", "the material's value"),
            "map_ks" | "map_ns" => self.ignored("highlight map", "the material's value"),
            "refl" => self.ignored("reflection map", "the scene's reflection"),
            _ => {}
        }
    }

    fn ignored(&mut self, feature: &str, instead: &str) {
        self.warnings.add(self.place.as_str(), format!("{feature} of MTL is not supported; {instead} is shown"));
    }

    fn set_alpha(&self, material: &mut Material, alpha: Option<f32>) {
        if let Some(alpha) = alpha.map(|alpha| alpha.clamp(0.0, 1.0)).filter(|alpha| *alpha < 1.0) {
            material.alpha = alpha;
            material.alpha_mode = AlphaMode::Blend;
        }
    }

    fn number(&self, rest: &str) -> Option<f32> {
        rest.split_whitespace().next().and_then(text::number).filter(|number| number.is_finite())
    }

    /// Colour of three numbers, or of one for all.
    fn colour(&self, rest: &str) -> Option<Vec3> {
        let numbers: Vec<f32> = rest.split_whitespace().map_while(text::number).take(3).collect();
        let colour = match *numbers {
            [r, g, b] => Vec3::new(r, g, b),
            [grey, ..] => Vec3::splat(grey),
            [] => return None,
        };
        colour.is_finite().then_some(colour.max(Vec3::ZERO))
    }

    /// Texture with its options, and the multiplier of a bump map.
    fn texture(&mut self, rest: &str) -> Option<(Texture, f32)> {
        let mut texture = Texture::new(0);
        let mut scale = 1.0;
        let mut rest = rest;
        while let Some(option) = rest.split_whitespace().next().filter(|word| word.starts_with('-')) {
            rest = rest[option.len()..].trim_start();
            // Up to three numbers, or one word.
            let mut values = Vec::new();
            while let Some(word) = rest.split_whitespace().next() {
                let number = text::number(word);
                if number.is_none() && (!values.is_empty() || matches!(option, "-s" | "-o" | "-t" | "-mm" | "-bm")) {
                    break;
                }
                rest = rest[word.len()..].trim_start();
                values.push(number.unwrap_or(0.0));
                if number.is_none() || values.len() == 3 {
                    if number.is_none() && option == "-clamp" && word == "on" {
                        texture.wrap = [Wrap::ClampToEdge; 2];
                    }
                    break;
                }
            }
            let pair = |default: f32| {
                let value = |k: usize| values.get(k).copied().unwrap_or(default);
                Vec2::new(value(0), value(1))
            };
            match option {
                "-s" => texture.transform.scale = pair(1.0),
                // With v up, scaling and moving start at the lower left corner.
                "-o" => texture.transform.offset = pair(0.0),
                "-bm" => scale = values.first().copied().unwrap_or(1.0),
                _ => {}
            }
        }
        let Vec2 { x, y } = texture.transform.offset;
        texture.transform.offset = Vec2::new(x, 1.0 - texture.transform.scale.y - y);
        texture.image = self.image(rest)?;
        Some((texture, scale))
    }

    fn image(&mut self, name: &str) -> Option<usize> {
        if let Some(&index) = self.library.files.get(name) {
            return index;
        }
        let image = self.companions.read(name, &self.place).map(|bytes| Image { name: name.to_string(), bytes });
        let index = match image {
            Ok(image) if image.is_supported() => {
                self.library.images.push(image);
                Some(self.library.images.len() - 1)
            }
            Ok(_) => {
                let message = format!("\"{}\" is neither PNG nor JPEG; the material is shown without", shortened(name));
                self.warnings.add(self.place.as_str(), message);
                None
            }
            Err(mistake) => {
                let message = format!("{}; the material is shown without", mistake.problem);
                self.warnings.add(self.place.as_str(), message);
                None
            }
        };
        self.library.files.insert(name.to_string(), index);
        index
    }
}

/// Roughness whose GGX highlight is as wide as that of a Phong exponent.
fn roughness_of_exponent(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25)
}
