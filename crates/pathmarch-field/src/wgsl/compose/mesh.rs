//! WGSL of meshes: functions that read [`Program::mesh_words`](super::Program::mesh_words).

use super::Composer;
use super::parameters::local;
use crate::mesh_shape::words;
use crate::mesh_shape::{ATTRIBUTES_WGSL, OPACITY_WGSL, OPAQUE_WGSL, TRIANGLES_WGSL};

impl Composer<'_> {
    /// Encodes the meshes, and writes the offset of its grid to the parameters of each leaf.
    pub(super) fn append_meshes(&mut self) {
        self.meshes = self.field.mesh_words(self.has_all_grids);
        let leaves = self.field.leaves().iter().enumerate().filter(|(_, leaf)| leaf.shape.mesh().is_some());
        for (index, leaf) in leaves {
            let (_, offset) = local(&leaf.pose, self.starts[index], "p");
            self.parameters[offset][0] = self.meshes.grids[index] as f32;
        }
    }

    /// Functions of meshes that are not those of their shape: constants, and ray intersection.
    pub(super) fn mesh_code(&self) -> String {
        let mut code = String::new();
        if self.field.has_meshes() {
            code += &words::grid_constants_wgsl();
            code += &words::constants_wgsl();
            code += "\n";
            code += ATTRIBUTES_WGSL;
        }
        if self.field.has_triangles() {
            let has_opacity = self.field.has_opacity();
            let is_lit_by_field = self.field.has_meshes_lit_by_field();
            code += &format!("\nconst HAS_OPACITY = {has_opacity};\nconst HAS_LIT_BY_FIELD = {is_lit_by_field};\n\n");
            code += if has_opacity { OPACITY_WGSL } else { OPAQUE_WGSL };
            code += "\n";
            code += TRIANGLES_WGSL;
        }
        code
    }
}
