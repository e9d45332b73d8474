//! Opacity of triangles: hits that rays pass.
//!
//! **Idea.** The test is part of the search for the nearest triangle, so that all rays pass the same holes: camera and shadow rays,
//! previews and picking. A masked material is absent where its alpha is below a cutoff. Of a blended one, alpha is the
//! probability that a ray hits it; the random number is a hash of the ray and the triangle, so that a picture is the same
//! each time. Single-sided triangles are absent for rays that hit their back.
//!
//! **Source.** glTF 2.0, sections 3.9.4 and 3.9.6. **Limits.** Alpha is not averaged over the footprint of a pixel; its samples
//! do that. **Cost.** One texture lookup for each hit that is nearer than the nearest so far.

use super::interpolation::MeshAttributes;
use super::surface::MeshSurface;
use glam::Vec2;
use pathmarch_mesh::bvh::{Hit, Ray};
use pathmarch_mesh::material::Wrap;
use std::sync::Arc;

/// Opacity of the materials of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOpacity {
    /// One entry for each material of the mesh.
    pub materials: Vec<MaterialOpacity>,
}

/// Opacity of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialOpacity {
    /// Use of alpha.
    pub test: AlphaTest,
    /// Rays pass through the back of triangles.
    pub is_single_sided: bool,
    /// Alpha, or the factor of that of the texture and of the vertices.
    pub alpha: f32,
    /// Texture of alpha.
    pub texture: Option<AlphaTexture>,
}

/// Use of alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaTest {
    /// Alpha is ignored.
    Opaque,
    /// Present where alpha is at least this.
    Mask(f32),
    /// Present with a probability of alpha.
    Blend,
}

/// Texture of alpha.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaTexture {
    /// Texels in a row.
    pub width: u32,
    /// Rows, from the top.
    pub height: u32,
    /// Alpha of the texels, from 0 to 255.
    pub texels: Arc<[u8]>,
    /// Set of texture coordinates, 0 or 1.
    pub uv_set: usize,
    /// Rows of the matrix that maps (u, v, 1); (0, 0) is the upper left corner, (1, 1) the lower right one.
    pub rows: [[f32; 3]; 2],
    /// Continuation along u and v.
    pub wrap: [Wrap; 2],
    /// Texels are not interpolated.
    pub is_nearest: bool,
}

impl MaterialOpacity {
    /// Reports whether no ray passes through the material.
    pub fn is_opaque(&self) -> bool {
        self.test == AlphaTest::Opaque && !self.is_single_sided
    }

    /// Alpha at a point.
    fn alpha_at(&self, attributes: &MeshAttributes) -> f32 {
        self.alpha * attributes.colour.w * self.texture.as_ref().map_or(1.0, |texture| texture.alpha(attributes.uvs))
    }
}

impl AlphaTexture {
    /// Alpha at texture coordinates, bilinear.
    fn alpha(&self, uvs: [Vec2; 2]) -> f32 {
        let uv = uvs[self.uv_set];
        let [x, y] = self.rows.map(|[a, b, c]| (a * uv.x + b * uv.y + c).clamp(-MAX_COORDINATE, MAX_COORDINATE));
        let at = Vec2::new(x * self.width as f32, y * self.height as f32) - 0.5;
        let corner = at.floor();
        let mut part = at - corner;
        if self.is_nearest {
            part = (part + 0.5).floor();
        }
        let columns = [0, 1].map(|k| self.wrap[0].texel(corner.x as i32 + k, self.width as i32));
        let rows = [0, 1].map(|k| self.wrap[1].texel(corner.y as i32 + k, self.height as i32));
        let texel = |row: u32, column: u32| f32::from(self.texels[(row * self.width + column) as usize]) / 255.0;
        let [upper, lower] = rows.map(|row| {
            let [left, right] = columns.map(|column| texel(row, column));
            left + (right - left) * part.x
        });
        upper + (lower - upper) * part.y
    }
}

/// Largest coordinate in a picture that is told apart from others.
const MAX_COORDINATE: f32 = 1e4;

impl MeshOpacity {
    /// Reports whether a ray in the mesh's coordinates hits a triangle of this material rather than passes it.
    pub(crate) fn is_present(&self, surface: &MeshSurface, material: usize, ray: &Ray, hit: &Hit) -> bool {
        let Some(opacity) = self.materials.get(material) else { return true };
        if opacity.is_single_sided {
            let [a, b, c] = surface.mesh().corners(hit.triangle as usize);
            if (b - a).cross(c - a).dot(ray.direction) > 0.0 {
                return false;
            }
        }
        let threshold = match opacity.test {
            AlphaTest::Opaque => return true,
            AlphaTest::Mask(cutoff) => cutoff,
            AlphaTest::Blend => threshold(ray, hit.triangle),
        };
        opacity.alpha_at(&surface.attributes(hit.triangle, hit.barycentrics)) >= threshold
    }
}

/// Uniform number above 0, at most 1, for a ray and a triangle (PCG hash; Jarzynski and Olano 2020).
fn threshold(ray: &Ray, triangle: u32) -> f32 {
    let bits = [ray.origin.to_array(), ray.direction.to_array()];
    let state = bits.as_flattened().iter().fold(triangle, |state, value| hash(state ^ value.to_bits()));
    ((hash(state) >> 8) as f32 + 1.0) / 16_777_216.0
}

fn hash(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
