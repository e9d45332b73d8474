//! Textures: computed values from 0 to 1 in space, and pictures.
//!
//! A texture is one file that declares a [`TextureKind`], a pair `x.rs` and `x.wgsl`; the name in the list below is its
//! registration. Its value is written once, for one point and for eight in lanes. The parser, the window, both renderers and the tests read [`kinds`]. A texture is evaluated in the
//! coordinates of its shape ([`Field::coordinates`](pathmarch_field::Field::coordinates)), so that it moves with the
//! shape, and may be placed there. The textured parameter maps its values: to positions on a colour ramp ([`Ramp`]), to
//! a range of numbers, to heights. A [`Decal`] is a picture over the colour of a material.

mod decal;
mod noise;
mod picture;
mod ramp;
mod uv;

pub use decal::{Decal, DecalSpace};
use glam::Vec3;
pub use pathmarch_field::MeshAttributes;
use pathmarch_field::Param;
use pathmarch_field::graph::{Pose, Turn};
use pathmarch_field::number::{Real, Vec3 as FieldVec3};
pub use picture::{Picture, PictureError};
pub use ramp::Ramp;
use std::sync::Arc;
use wide::f32x8;

/// Largest number of parameters of a texture.
pub const MAX_PARAMETERS: usize = 8;

/// Parameters of a texture, in the order of [`TextureKind::params`].
pub type TextureParameters = [f32; MAX_PARAMETERS];

/// A kind of texture.
pub struct TextureKind {
    /// Name in the scene language.
    pub name: &'static str,
    /// One sentence for people.
    pub doc: &'static str,
    /// Author, work, year; a key of REFERENCES.md where there is one.
    pub source: &'static str,
    /// Parameters.
    pub params: &'static [Param],
    /// Step of finite differences, metres: short compared to its features.
    pub step: fn(&TextureParameters) -> f32,
    /// Value, clamped to 0 to 1.
    pub value: fn(&Place<f32>, &TextureParameters) -> f32,
    /// Values at eight places.
    pub values: fn(&Place<f32x8>, &TextureParameters) -> f32x8,
    /// The same in WGSL: `NAME_texture(spot: Spot, k: array<f32, 8>) -> f32`.
    pub wgsl: &'static str,
}

impl std::fmt::Debug for TextureKind {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// Point at which a texture is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    /// Position in the coordinates of the shape, or of a placed texture.
    pub p: Vec3,
    /// Unit normal of the surface.
    pub normal: Vec3,
    /// Footprint of a pixel, in these coordinates.
    pub footprint: f32,
    /// Attributes of the vertices of a mesh; the defaults on other shapes.
    pub attributes: MeshAttributes,
}

/// Place of one or eight spots, at which computed textures are evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Place<N> {
    /// Position in the coordinates of the texture.
    pub p: FieldVec3<N>,
    /// Unit normal of the surface.
    pub normal: FieldVec3<N>,
}

/// WGSL that textures share: `Spot` as in Rust, and noise.
pub const SHARED_WGSL: &str = include_str!("noise.wgsl");
/// WGSL of pictures: `picture_projected(picture: TexturePicture, spot: Spot, size: f32) -> vec3f`, with the picture's texels in
/// the array `tables`.
pub const PICTURE_WGSL: &str = include_str!("picture.wgsl");
/// WGSL of decals, after [`PICTURE_WGSL`]: `decal_at(picture: TexturePicture, spot: Spot, …) -> vec4f`.
pub const DECAL_WGSL: &str = include_str!("decal.wgsl");

pub use uv::{Channel, UvMapping};

const OCTAVES: Param = Param::count("octaves", 5.0, 1.0, 12.0, "How many sizes of detail, each half as large.");
const GAIN: Param = Param::between("gain", 0.5, 0.0, 1.0, "How strong each size of detail is against the one before.");
const SEED: Param = Param::count("seed", 0.0, 0.0, 1_000_000.0, "Another one, of the same kind.");
const JITTER: Param = Param::between("jitter", 1.0, 0.0, 1.0, "How irregular: 0 is a lattice.");

macro_rules! textures {
    ($($module:ident),* $(,)?) => {
        $(mod $module;)*
        static ALL: &[&TextureKind] = &[$(&$module::KIND),*];
    };
}

textures!(fbm, marble, wood, brick, checker, voronoi, cells, cracks);

/// Every kind of texture that is computed, in the order of registration.
pub fn kinds() -> &'static [&'static TextureKind] {
    ALL
}

/// Name of a picture in the scene language.
pub const PICTURE: &str = "picture";
/// Width of a picture.
pub static PICTURE_SIZE: Param = Param::length("size", 1.0, "Width of the picture.");

/// Names of all textures, computed ones and pictures.
pub fn names() -> Vec<&'static str> {
    kinds().iter().map(|kind| kind.name).chain([PICTURE]).collect()
}

/// The kind of this name.
pub fn kind(name: &str) -> Option<&'static TextureKind> {
    kinds().iter().copied().find(|kind| kind.name == name)
}

/// Source of a texture's values.
#[derive(Clone, Debug)]
pub enum Pattern {
    /// A computed texture.
    Computed {
        /// Kind of the node.
        kind: &'static TextureKind,
        /// Values of the parameters; the rest is zero.
        parameters: TextureParameters,
    },
    /// A picture, projected along the three axes and blended by the normal.
    Picture {
        /// Its texels.
        picture: Arc<Picture>,
        /// Its width, metres.
        size: f32,
    },
    /// A picture at the texture coordinates of a mesh.
    UvPicture {
        /// Its texels.
        picture: Arc<Picture>,
        /// From texture coordinates to the picture.
        mapping: UvMapping,
    },
}

/// A texture with its placement.
#[derive(Clone, Debug)]
pub struct Texture {
    /// Source of its values.
    pub pattern: Pattern,
    /// Pose of its coordinates in those of the shape.
    pub pose: Pose,
}

/// A spot in the coordinates in which a pose is given, as one in the coordinates of the pose.
fn placed(pose: &Pose, spot: &Spot) -> Spot {
    let offset = spot.p - Vec3::from(pose.at);
    if pose.turn == Turn::None {
        return Spot { p: offset, ..*spot };
    }
    let rows: [Vec3; 3] = pose.local_from_world().map(Vec3::from);
    let turned = |v: Vec3| Vec3::from_array(rows.map(|row| row.dot(v)));
    Spot {
        p: turned(offset),
        normal: turned(spot.normal) * pose.scale,
        footprint: spot.footprint / pose.scale,
        attributes: spot.attributes,
    }
}

/// Values of a computed texture at eight places, clamped to 0 to 1.
fn values_at(kind: &TextureKind, parameters: &TextureParameters, place: Place<f32x8>) -> f32x8 {
    let value = (kind.values)(&place, parameters);
    // What is not a number is 0.
    Real::select(Real::lt(f32x8::ZERO, value), value.fast_min(f32x8::ONE), f32x8::ZERO)
}

/// Spots at eight positions, which in all else are like one.
fn spots_at(spot: &Spot, positions: FieldVec3<f32x8>) -> [Spot; 8] {
    let [x, y, z] = [positions.x, positions.y, positions.z].map(f32x8::to_array);
    std::array::from_fn(|lane| Spot { p: Vec3::new(x[lane], y[lane], z[lane]), ..*spot })
}

impl Texture {
    /// A spot of the shape as one of the texture.
    fn placed(&self, spot: &Spot) -> Spot {
        placed(&self.pose, spot)
    }

    /// Its value at a spot of the shape, 0 to 1; of a picture, its luminance.
    pub fn value(&self, spot: &Spot) -> f32 {
        let value = match &self.pattern {
            Pattern::Computed { kind, parameters } => {
                let Spot { p, normal, .. } = self.placed(spot);
                (kind.value)(&Place { p: p.into(), normal: normal.into() }, parameters)
            }
            Pattern::Picture { .. } => self.colour(spot).dot(Vec3::from(LUMINANCE)),
            Pattern::UvPicture { mapping, .. } => mapping.channel.of(self.colour(spot)),
        };
        // What is not a number is 0.
        if value > 0.0 { value.min(1.0) } else { 0.0 }
    }

    /// Its own colour at a spot of the shape; grey where it has none.
    pub fn colour(&self, spot: &Spot) -> Vec3 {
        match &self.pattern {
            Pattern::Computed { .. } => Vec3::splat(self.value(spot)),
            Pattern::Picture { picture, size } => picture.projected(&self.placed(spot), *size),
            Pattern::UvPicture { picture, mapping } => picture.at_uv(&spot.attributes, spot.footprint, mapping),
        }
    }

    /// True if it is computed, from positions and normals alone.
    pub fn is_computed(&self) -> bool {
        matches!(self.pattern, Pattern::Computed { .. })
    }

    /// Its values at eight spots of the shape, bit for bit those of each.
    pub fn values(&self, spots: [&Spot; 8]) -> f32x8 {
        let Pattern::Computed { kind, parameters } = &self.pattern else {
            return f32x8::from(spots.map(|spot| self.value(spot)));
        };
        let [px, py, pz, nx, ny, nz, ..] = f32x8::transpose(spots.map(|spot| {
            let Spot { p, normal: n, .. } = self.placed(spot);
            f32x8::from([p.x, p.y, p.z, n.x, n.y, n.z, 0.0, 0.0])
        }));
        values_at(kind, parameters, Place { p: FieldVec3::new(px, py, pz), normal: FieldVec3::new(nx, ny, nz) })
    }

    /// Its values at eight spots, which have these positions and in all else are like one of the shape.
    pub fn values_around(&self, spot: &Spot, positions: FieldVec3<f32x8>) -> f32x8 {
        let Pattern::Computed { kind, parameters } = &self.pattern else {
            return f32x8::from(spots_at(spot, positions).map(|spot| self.value(&spot)));
        };
        let pose = &self.pose;
        let mut p = positions - FieldVec3::constant(pose.at);
        if pose.turn != Turn::None {
            let rows = pose.local_from_world().map(FieldVec3::constant);
            p = FieldVec3::new(rows[0].dot(p), rows[1].dot(p), rows[2].dot(p));
        }
        let normal = FieldVec3::constant(self.placed(spot).normal.into());
        values_at(kind, parameters, Place { p, normal })
    }

    /// Its own colours at eight spots, as [`values_around`](Self::values_around).
    pub fn colours_around(&self, spot: &Spot, positions: FieldVec3<f32x8>) -> FieldVec3<f32x8> {
        match &self.pattern {
            Pattern::Computed { .. } => FieldVec3::splat(self.values_around(spot, positions)),
            Pattern::Picture { .. } | Pattern::UvPicture { .. } => {
                let colours = spots_at(spot, positions).map(|spot| self.colour(&spot));
                let [r, g, b] = [0, 1, 2].map(|k| f32x8::from(colours.map(|colour| colour[k])));
                FieldVec3::new(r, g, b)
            }
        }
    }

    /// The gradient of its value over the shape's coordinates, by differences as long as what a pixel covers, or as the
    /// texture asks for.
    pub fn slope(&self, spot: &Spot) -> Vec3 {
        let own = match &self.pattern {
            Pattern::Computed { kind, parameters } => (kind.step)(parameters),
            Pattern::Picture { picture, size } => size / picture.width as f32,
            // Its value does not change along the shape's coordinates.
            Pattern::UvPicture { .. } => 1.0,
        };
        let step = (own * self.pose.scale).max(0.5 * spot.footprint);
        let [x, y, z] = spot.p.to_array();
        let places = [[x, y, z], [x + step, y, z], [x, y + step, z], [x, y, z + step]];
        let [here, along_x, along_y, along_z] = if self.is_computed() {
            let [x, y, z] = [0, 1, 2].map(|k| f32x8::from(std::array::from_fn(|lane| places[lane % 4][k])));
            let [a, b, c, d, ..] = self.values_around(spot, FieldVec3::new(x, y, z)).to_array();
            [a, b, c, d]
        } else {
            places.map(|p| self.value(&Spot { p: p.into(), ..*spot }))
        };
        Vec3::new(along_x - here, along_y - here, along_z - here) / step
    }
}

/// Luminance weights of linear Rec. 709.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];
