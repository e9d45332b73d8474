//! Pictures at the texture coordinates of meshes.
//!
//! **Filter.** That of `picture.rs`; the level follows from the density of texture coordinates on the triangle. **Wrap modes** are
//! those of glTF 2.0, section 3.8.4.2, for each texel.

use super::{Picture, SurfaceUv};
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
    /// Channel of numbers.
    pub channel: Channel,
}

impl Default for UvMapping {
    fn default() -> Self {
        let rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        Self { set: 0, rows, wrap: [Wrap::Repeat; 2], channel: Channel::Luminance }
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

/// Texel of a row of `count` that a position stands for.
fn wrapped(position: i32, count: i32, wrap: Wrap) -> u32 {
    let texel = match wrap {
        Wrap::Repeat => position.rem_euclid(count),
        Wrap::MirroredRepeat => {
            let twice = position.rem_euclid(2 * count);
            twice.min(2 * count - 1 - twice)
        }
        Wrap::ClampToEdge => position.clamp(0, count - 1),
    };
    texel as u32
}

/// Largest coordinate that is told apart from others.
const MAX_COORDINATE: f32 = 1e4;

impl Picture {
    /// Colour at texture coordinates, for a footprint in the shape's coordinates.
    pub(super) fn at_uv(&self, uv: &SurfaceUv, footprint: f32, mapping: &UvMapping) -> Vec3 {
        let place = mapping.place(uv.uvs[mapping.set]).clamp(Vec2::splat(-MAX_COORDINATE), Vec2::splat(MAX_COORDINATE));
        let side = self.width.max(self.height) as f32;
        let texels = footprint * uv.densities[mapping.set] * mapping.scale() * side;
        let last = self.levels() - 1;
        let level = texels.max(1.0).log2().min(last as f32);
        let first = level.floor();
        let fine = self.wrapped_bilinear(first as u32, place, mapping.wrap);
        if level == first {
            return fine;
        }
        fine.lerp(self.wrapped_bilinear((first as u32 + 1).min(last), place, mapping.wrap), level - first)
    }

    fn wrapped_bilinear(&self, level: u32, place: Vec2, wrap: [Wrap; 2]) -> Vec3 {
        let (start, width, height) = self.level(level);
        let at = place * Vec2::new(width as f32, height as f32) - 0.5;
        let corner = at.floor();
        let part = at - corner;
        let (x, y) = (corner.x as i32, corner.y as i32);
        let columns = [x, x + 1].map(|x| wrapped(x, width as i32, wrap[0]));
        let row = |y: i32| {
            let y = wrapped(y, height as i32, wrap[1]);
            let [left, right] = columns.map(|x| self.texel(start, width, x, y));
            left.lerp(right, part.x)
        };
        row(y).lerp(row(y + 1), part.y)
    }
}
