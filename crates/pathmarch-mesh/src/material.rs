//! Materials, images, lights and cameras of mesh files, as data.
//!
//! **Idea.** The metallic-roughness material of glTF 2.0 with some of its extensions; OBJ materials are translated to it. All
//! colours are linear Rec. 709. An image is kept as it is in the file; [`Image::decode`] unpacks it.
//!
//! **Source.** glTF 2.0, sections 3.8 to 3.10 and 5.19 to 5.29; KHR_materials_ior, _transmission, _volume,
//! _specular, _clearcoat, _emissive_strength; KHR_texture_transform; KHR_lights_punctual.

use glam::{Mat3, Vec2, Vec3};
use std::io::Cursor;
use std::sync::Arc;

/// Surface of a triangle. The defaults are those of glTF.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file; may be empty.
    pub name: String,
    /// Base colour, linear; the reflectance of metals at normal incidence, the albedo of others.
    pub base_colour: Vec3,
    /// Opacity, which multiplies the alpha of the texture.
    pub alpha: f32,
    /// Base colour, sRGB, and alpha.
    pub base_colour_texture: Option<Texture>,
    /// Metalness, from 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, from 0 to 1: the square root of the GGX alpha.
    pub roughness: f32,
    /// Roughness in green and metalness in blue, linear.
    pub metallic_roughness_texture: Option<Texture>,
    /// Normals in tangent space, linear.
    pub normal_texture: Option<Texture>,
    /// Factor of the x and y of the normal texture.
    pub normal_scale: f32,
    /// Emitted radiance, linear: the emissive factor times its strength.
    pub emission: Vec3,
    /// Factor of the emission, sRGB.
    pub emission_texture: Option<Texture>,
    /// Use of alpha.
    pub alpha_mode: AlphaMode,
    /// Both sides are shown; otherwise rays pass through the back.
    pub is_double_sided: bool,
    /// Index of refraction.
    pub ior: f32,
    /// Fraction of light that is transmitted, from 0 to 1.
    pub transmission: f32,
    /// Transmission in red, linear.
    pub transmission_texture: Option<Texture>,
    /// Interior; none for thin walls.
    pub volume: Option<Volume>,
    /// Strength of the specular reflection of dielectrics, from 0 to 1.
    pub specular: f32,
    /// Strength in alpha.
    pub specular_texture: Option<Texture>,
    /// Colour of the specular reflection of dielectrics at normal incidence, linear.
    pub specular_colour: Vec3,
    /// Colour, sRGB.
    pub specular_colour_texture: Option<Texture>,
    /// Clear coat; none if there is no coat.
    pub clearcoat: Option<Clearcoat>,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_colour: Vec3::ONE,
            alpha: 1.0,
            base_colour_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_texture: None,
            alpha_mode: AlphaMode::Opaque,
            is_double_sided: false,
            ior: 1.5,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            specular: 1.0,
            specular_texture: None,
            specular_colour: Vec3::ONE,
            specular_colour_texture: None,
            clearcoat: None,
        }
    }
}

impl Material {
    /// White plastic, for files without materials.
    pub fn plain() -> Self {
        Self { base_colour: Vec3::splat(0.8), metallic: 0.0, roughness: 0.5, is_double_sided: true, ..Self::default() }
    }
}

/// Use of a material's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Points with an alpha below the cutoff are absent.
    Mask {
        /// The cutoff.
        cutoff: f32,
    },
    /// Alpha is the probability that the surface is present.
    Blend,
}

/// Absorbing interior of a closed surface (KHR_materials_volume).
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Thickness for renderers without refracted rays, in the mesh's units; zero means thin walls.
    pub thickness: f32,
    /// Distance after which white light has the attenuation colour, in world units; may be infinite.
    pub attenuation_distance: f32,
    /// Colour of light after that distance, linear.
    pub attenuation_colour: Vec3,
}

/// Clear coat (KHR_materials_clearcoat).
#[derive(Clone, Debug, PartialEq)]
pub struct Clearcoat {
    /// Strength, from 0 to 1.
    pub factor: f32,
    /// Strength in red, linear.
    pub texture: Option<Texture>,
    /// Perceptual roughness.
    pub roughness: f32,
    /// Roughness in green, linear.
    pub roughness_texture: Option<Texture>,
    /// Normals in tangent space, linear.
    pub normal_texture: Option<Texture>,
}

/// Image on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Index of the image.
    pub image: usize,
    /// Set of texture coordinates, 0 or 1.
    pub uv_set: usize,
    /// Continuation along u and v.
    pub wrap: [Wrap; 2],
    /// Texels are not interpolated.
    pub is_nearest: bool,
    /// Transform of texture coordinates.
    pub transform: TextureTransform,
}

impl Texture {
    /// Repeated image on the first set of coordinates.
    pub fn new(image: usize) -> Self {
        let transform = TextureTransform::default();
        Self { image, uv_set: 0, wrap: [Wrap::Repeat; 2], is_nearest: false, transform }
    }
}

/// Continuation of an image beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Repeat it.
    #[default]
    Repeat,
    /// Repeat it, every other copy mirrored.
    MirroredRepeat,
    /// Repeat its border.
    ClampToEdge,
}

impl Wrap {
    /// Coordinate from 0 to 1 at which to read the image.
    pub fn apply(self, coordinate: f32) -> f32 {
        match self {
            Self::Repeat => coordinate - coordinate.floor(),
            Self::MirroredRepeat => 1.0 - (coordinate - 2.0 * (0.5 * coordinate).floor() - 1.0).abs(),
            Self::ClampToEdge => coordinate.clamp(0.0, 1.0),
        }
    }

    /// Texel of a row of `count` that a position stands for.
    pub fn texel(self, position: i32, count: i32) -> u32 {
        let texel = match self {
            Self::Repeat => position.rem_euclid(count),
            Self::MirroredRepeat => {
                let twice = position.rem_euclid(2 * count);
                twice.min(2 * count - 1 - twice)
            }
            Self::ClampToEdge => position.clamp(0, count - 1),
        };
        texel as u32
    }

    /// Code of the continuation, as kernels read it.
    pub fn code(self) -> u32 {
        match self {
            Self::Repeat => 0,
            Self::MirroredRepeat => 1,
            Self::ClampToEdge => 2,
        }
    }
}

/// Transform of texture coordinates (KHR_texture_transform): scale, then rotate, then translate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureTransform {
    /// Translation.
    pub offset: Vec2,
    /// Rotation about the origin, radians, anticlockwise in an image whose v points down.
    pub rotation_radians: f32,
    /// Scale.
    pub scale: Vec2,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_radians: 0.0, scale: Vec2::ONE }
    }
}

impl TextureTransform {
    /// The matrix that maps (u, v, 1).
    pub fn matrix(&self) -> Mat3 {
        let (sin, cos) = self.rotation_radians.sin_cos();
        let rotation = Mat3::from_cols_array(&[cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0]);
        Mat3::from_translation(self.offset) * rotation * Mat3::from_scale(self.scale)
    }
}

/// Image file, as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// Name or path in the mesh file; may be empty.
    pub name: String,
    /// Contents of a PNG or JPEG file.
    pub bytes: Arc<[u8]>,
}

/// Image that cannot be decoded.
#[derive(Debug, thiserror::Error)]
#[error("image \"{name}\": {source}; save it again as PNG or JPEG")]
pub struct ImageError {
    name: String,
    source: image::ImageError,
}

/// Largest width and height of an image, pixels.
pub const MAX_IMAGE_SIDE: u32 = 16384;
/// Largest memory that decoding an image may take, bytes.
const MAX_IMAGE_BYTES: u64 = 2 << 30;

impl Image {
    /// Decodes the image.
    ///
    /// # Errors
    /// [`ImageError`]: neither PNG nor JPEG, damaged, or larger than [`MAX_IMAGE_SIDE`].
    pub fn decode(&self) -> Result<image::DynamicImage, ImageError> {
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_IMAGE_SIDE);
        limits.max_image_height = Some(MAX_IMAGE_SIDE);
        limits.max_alloc = Some(MAX_IMAGE_BYTES);
        let failed = |source| ImageError { name: self.name.clone(), source };
        let reader = image::ImageReader::new(Cursor::new(&self.bytes)).with_guessed_format();
        let mut reader = reader.map_err(|error| failed(error.into()))?;
        reader.limits(limits);
        reader.decode().map_err(failed)
    }

    /// Reports bytes that start as PNG or JPEG files do.
    pub fn is_supported(&self) -> bool {
        matches!(image::guess_format(&self.bytes), Ok(image::ImageFormat::Png | image::ImageFormat::Jpeg))
    }
}

/// Light of a point (KHR_lights_punctual). It shines along the negative z axis of its node.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file; may be empty.
    pub name: String,
    /// Linear colour.
    pub colour: Vec3,
    /// Luminous intensity, candela; of a directional light the illuminance, lux.
    pub intensity: f32,
    /// Distance beyond which it may be ignored, metres.
    pub range: Option<f32>,
    /// Kind of light.
    pub kind: LightKind,
}

/// Kind of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// In all directions.
    Point,
    /// In a cone.
    Spot {
        /// Angle from the axis at which it begins to fall off, radians.
        inner_cone_radians: f32,
        /// Angle from the axis at which it ends, radians.
        outer_cone_radians: f32,
    },
}

/// Camera that looks along the negative z axis of its node, with y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file; may be empty.
    pub name: String,
    /// Projection.
    pub projection: Projection,
}

/// Projection of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// Vertical field of view, radians.
        y_fov_radians: f32,
        /// Width over height.
        aspect_ratio: Option<f32>,
    },
    /// Parallel.
    Orthographic {
        /// Half width and half height, world units.
        half_size: Vec2,
    },
}
