//! Pictures at the texture coordinates of meshes, times the colour of their vertices.
//!
//! **Filter.** That of `picture.rs`; the level follows from the density of texture coordinates on the triangle. **Wrap modes** are
//! those of glTF 2.0, section 3.8.4.2, for each texel.

use super::{MeshAttributes, Picture};
use glam::{Vec2, Vec3};
use pathmarch_mesh::material::Wrap;

/// Channel of a picture that stands for a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Luminance of the colour.
    #[default]
    Luminance,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
}

impl Channel {
    /// Value of a colour.
    pub fn of(self, colour: Vec3) -> f32 {
        match self {
            Self::Luminance => colour.dot(Vec3::from(super::LUMINANCE)),
            Self::Red => colour.x,
            Self::Green => colour.y,
            Self::Blue => colour.z,
        }
    }
}

/// Mapping from texture coordinates to a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvMapping {
    /// Set of texture coordinates, 0 or 1.
    pub set: usize,
    /// Rows of the matrix that maps (u, v, 1); (0, 0) is the upper left corner of the picture, (1, 1) the lower right one.
    pub rows: [[f32; 3]; 2],
    /// Continuation along u and v.
    pub wrap: [Wrap; 2],
    /// Texels are not interpolated.
    pub is_nearest: bool,
    /// Channel of numbers.
    pub channel: Channel,
    /// Factor of the colour.
    pub factor: [f32; 3],
    /// The colour of the vertices is another factor.
    pub has_vertex_colours: bool,
}

impl Default for UvMapping {
    fn default() -> Self {
        let rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Self {
            set: 0,
            rows,
            wrap: [Wrap::Repeat; 2],
            is_nearest: false,
            channel: Channel::Luminance,
            factor: [1.0; 3],
            has_vertex_colours: false,
        }
    }
}

impl UvMapping {
    /// Place in the picture.
    fn place(&self, uv: Vec2) -> Vec2 {
        Vec2::from_array(self.rows.map(|[a, b, c]| a * uv.x + b * uv.y + c))
    }

    /// Length in the picture of a unit of texture coordinates.
    pub fn scale(&self) -> f32 {
        let [[a, b, _], [c, d, _]] = self.rows;
        (a * d - b * c).abs().sqrt()
    }
}

/// Largest coordinate that is told apart from others.
const MAX_COORDINATE: f32 = 1e4;

impl Picture {
    /// Colour at a point of a mesh with these attributes, for a footprint in the shape's coordinates.
    pub(super) fn at_uv(&self, at: &MeshAttributes, footprint: f32, mapping: &UvMapping) -> Vec3 {
        let tint = if mapping.has_vertex_colours { at.colour.truncate() } else { Vec3::ONE };
        self.filtered_at_uv(at, footprint, mapping) * Vec3::from(mapping.factor) * tint
    }

    fn filtered_at_uv(&self, at: &MeshAttributes, footprint: f32, mapping: &UvMapping) -> Vec3 {
        let place = mapping.place(at.uvs[mapping.set]).clamp(Vec2::splat(-MAX_COORDINATE), Vec2::splat(MAX_COORDINATE));
        let side = self.width.max(self.height) as f32;
        let texels = footprint * at.uv_densities[mapping.set] * mapping.scale() * side;
        let last = self.levels() - 1;
        let level = texels.max(1.0).log2().min(last as f32);
        let first = level.floor();
        let fine = self.wrapped_bilinear(first as u32, place, mapping);
        if level == first {
            return fine;
        }
        fine.lerp(self.wrapped_bilinear((first as u32 + 1).min(last), place, mapping), level - first)
    }

    fn wrapped_bilinear(&self, level: u32, place: Vec2, mapping: &UvMapping) -> Vec3 {
        let (start, width, height) = self.level(level);
        let at = place * Vec2::new(width as f32, height as f32) - 0.5;
        let corner = at.floor();
        let mut part = at - corner;
        if mapping.is_nearest {
            part = (part + 0.5).floor();
        }
        let (x, y) = (corner.x as i32, corner.y as i32);
        let columns = [x, x + 1].map(|x| mapping.wrap[0].texel(x, width as i32));
        let row = |y: i32| {
            let y = mapping.wrap[1].texel(y, height as i32);
            let [left, right] = columns.map(|x| self.texel(start, width, x, y));
            left.lerp(right, part.x)
        };
        row(y).lerp(row(y + 1), part.y)
    }
}
