//! Leaves of the field: material, light and flags of each surface.

use super::flag_if;
use super::light::Light;
use crate::wgsl::{shared_constants, shared_struct};
use pathmarch_scene::materials::{TexturedParameter, Texturing};
use pathmarch_scene::textures::Pattern;
use pathmarch_scene::{Material, Scene};
use std::collections::HashMap;

shared_struct! {
    /// Leaf of the field.
    pub(crate) struct LeafRecord as LeafRecord {
        /// Unit normal of the emitting side of a sheet, in world space.
        pub(crate) facing: [f32; 3],
        /// Index of the material.
        pub(crate) material: u32,
        /// Origin of the local coordinates, in world space.
        pub(crate) origin: [f32; 3],
        /// [`SHEET`], [`ANALYTIC`], [`IN_GLASS`], [`MESH_FIELD`], [`TWO_SIDED`], [`FRACTAL`] and [`TEXTURED_IN_SPACE`]. The bits
        /// from [`LIGHT_SHIFT`] on are one more than the index of its light, or zero.
        pub(crate) flags: u32,
    }
}

shared_constants! {
    /// Surface without thickness. It emits on one side.
    pub(crate) const SHEET: u32 = 1;
    /// Shape with an analytic ray intersection.
    pub(crate) const ANALYTIC: u32 = 2;
    /// Leaf of an object with some transmissive material, so that paths hit it from inside.
    pub(crate) const IN_GLASS: u32 = 4;
    /// Field of a mesh whose materials or texture coordinates are those of the closest triangle.
    pub(crate) const MESH_FIELD: u32 = 8;
    /// Triangles of a mesh that does not transmit: their backs look as their fronts do.
    pub(crate) const TWO_SIDED: u32 = 16;
    /// Fractal, whose surface is rough from pixel to pixel.
    pub(crate) const FRACTAL: u32 = 32;
    /// Surface whose base colour depends on its position, not on texture coordinates or an orbit, nor on a decal.
    pub(crate) const TEXTURED_IN_SPACE: u32 = 64;
    /// First bit of the light index in the flags.
    pub(crate) const LIGHT_SHIFT: u32 = 7;
}

impl LeafRecord {
    /// Reports whether this flag is set.
    #[inline]
    pub(crate) fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// Index of the leaf's light; `None` if the leaf is no light.
    #[inline]
    pub(crate) fn light(&self) -> Option<usize> {
        (self.flags >> LIGHT_SHIFT).checked_sub(1).map(|index| index as usize)
    }
}

/// Reports whether the materials or texture coordinates of a leaf are those of the closest triangle of its mesh.
fn is_mesh_field(scene: &Scene, leaf: &pathmarch_field::graph::Leaf) -> bool {
    let has_uvs = |tag: u32| {
        let material = &scene.materials[tag as usize];
        let textured = &material.textured;
        let has_picture = textured.iter().any(|textured| matches!(textured.texture.pattern, Pattern::UvPicture { .. }));
        has_picture || material.normal_map.is_some() || material.emission_texture.is_some()
    };
    let mesh = leaf.shape.mesh().filter(|mesh| !mesh.is_triangles());
    mesh.is_some_and(|mesh| mesh.tags().len() > 1 || has_uvs(leaf.tag))
}

/// Reports whether textures of the position vary the base colour of a material, and nothing else does.
fn is_textured_in_space(material: &Material) -> bool {
    let is_base =
        |textured: &&TexturedParameter| material.kind.params[textured.param].texturing == Texturing::Colour(0);
    let mut textures = material.textured.iter().filter(is_base).map(|textured| &textured.texture.pattern).peekable();
    textures.peek().is_some()
        && textures.all(|pattern| !matches!(pattern, Pattern::UvPicture { .. }))
        && material.decals.is_empty()
}

/// Records of all leaves.
pub(super) fn records(scene: &Scene, lights: &[Light]) -> Vec<LeafRecord> {
    let field = &scene.field;
    let light_of_leaf: HashMap<u32, u32> =
        (0..).zip(lights).filter_map(|(index, light)| Some((light.leaf()?, index))).collect();
    let mut in_glass = vec![false; scene.objects.len()];
    for leaf in field.leaves() {
        in_glass[leaf.object as usize] |= scene.materials[leaf.tag as usize].transmits();
    }
    let textured_in_space: Vec<bool> = scene.materials.iter().map(is_textured_in_space).collect();
    let record = |(index, leaf): (usize, &pathmarch_field::graph::Leaf)| {
        let light = light_of_leaf.get(&(index as u32)).map_or(0, |light| light + 1);
        let (is_textured, is_mesh_field) = (textured_in_space[leaf.tag as usize], is_mesh_field(scene, leaf));
        LeafRecord {
            facing: leaf.pose.axes[1],
            material: leaf.tag,
            // A modifier bends space, so that the leaf has neither an origin nor a facing direction in world space.
            origin: if leaf.modified { [0.0; 3] } else { leaf.pose.at },
            flags: flag_if(SHEET, leaf.shape.info().sheet && !leaf.modified)
                | flag_if(ANALYTIC, field.is_analytic_leaf(index))
                | flag_if(IN_GLASS, in_glass[leaf.object as usize])
                | flag_if(MESH_FIELD, is_mesh_field)
                | flag_if(FRACTAL, leaf.shape.has_orbit())
                | flag_if(TEXTURED_IN_SPACE, is_textured && !is_mesh_field && !leaf.shape.has_orbit())
                | flag_if(
                    TWO_SIDED,
                    (leaf.is_triangles() || leaf.is_lit_by_field()) && !in_glass[leaf.object as usize],
                )
                | (light << LIGHT_SHIFT),
        }
    };
    field.leaves().iter().enumerate().map(record).collect()
}
