//! Shader files of the kernels, and their imports.
//!
//! A line `// import: a, b` at the top of a file names the files that it needs, by their paths in the crate, without extension.
//! Some names are interfaces instead, such as `sampler`: the kernel chooses the file that implements them. Constants and
//! structures that a file shares with Rust are printed in front of it.

use super::encode;
use super::loop_limit::SuspendedPath;
use super::slice::{self, Slice};
use crate::integrator::{
    emitter_coverage, emitter_edges, first_mirror, guides, lens_targets, light_sampling, media_segment, medium,
    medium_light, participating_media, path_reuse, path_state, pixel_albedo, reflected_light, shadow, splitting,
};
use crate::intersect::march;
use crate::preview::{self, soft_shadow};
use crate::preview_steps;
use crate::sampling::{self, r2_sequence, sobol::pair};
use crate::scene::light as scene_light;
use crate::scene::medium as scene_medium;
use crate::scene::{
    FrameUniforms, LeafRecord, LightNode, MaterialRecord, leaf, light_tree, material, nested_dielectrics, photon_map,
    preview_material, textured_material,
};
use crate::views;
use crate::wgsl::declaration;

/// Shader file.
pub(crate) struct ShaderFile {
    /// Path in the crate, without extension.
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
    /// Prints the declarations that it shares with Rust.
    pub(crate) shared: fn() -> String,
}

/// Lists shader files by their paths in the crate, with the declarations that they share with Rust.
macro_rules! shader_files {
    ($($name:literal $(shares $shared:expr)?,)+) => {
        &[$($crate::backend::gpu::shaders::ShaderFile {
            name: $name,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/", $name, ".wgsl")),
            shared: $crate::backend::gpu::shaders::shader_files!(@shared $($shared)?),
        }),+]
    };
    (@shared) => { String::new };
    (@shared $shared:expr) => { $shared };
}

pub(crate) use shader_files;

/// Files of the kernels. Passes list theirs beside them.
static FILES: &[ShaderFile] = shader_files![
    "backend/gpu/buffers" shares || {
        [declaration::<FrameUniforms>(), declaration::<Slice>(), declaration::<LeafRecord>(), leaf::shared_wgsl(),
            declaration::<MaterialRecord>(), material::shared_wgsl()].concat()
    },
    "backend/gpu/emitter_coverage" shares slice::shared_wgsl,
    "backend/gpu/emitter_edges" shares || emitter_edges::shared_wgsl() + &slice::shared_wgsl(),
    "backend/gpu/film",
    "backend/gpu/lanes",
    "backend/gpu/loop_limit" shares declaration::<SuspendedPath>,
    "backend/gpu/loops_unlimited",
    "backend/gpu/pixel_albedo" shares || pixel_albedo::shared_wgsl() + &slice::shared_wgsl(),
    "backend/gpu/sample",
    "backend/gpu/sample_resumed",
    "backend/gpu/trace",
    "backend/gpu/trace_pixels" shares slice::shared_wgsl,
    "backend/gpu/trace_tiles",
    "integrator/absorbing_media",
    "integrator/camera",
    "integrator/camera_emission",
    "integrator/camera_ray_index" shares splitting::shared_wgsl,
    "integrator/emitter_coverage" shares emitter_coverage::shared_wgsl,
    "integrator/first_mirror" shares first_mirror::shared_wgsl,
    "integrator/guide" shares guides::shared_wgsl,
    "integrator/guides",
    "integrator/lens_targets" shares lens_targets::shared_wgsl,
    "integrator/light_nodes_storage" shares declaration::<LightNode>,
    "integrator/light_nodes_uniform" shares declaration::<LightNode>,
    "integrator/light_sampling" shares || encode::light::shared_wgsl() + &light_sampling::shared_wgsl(),
    "integrator/light_table",
    "integrator/light_tree" shares light_tree::shared_wgsl,
    "integrator/light_weights" shares encode::light::direct_lighting_wgsl,
    "integrator/media_segment" shares media_segment::shared_wgsl,
    "integrator/medium" shares medium::shared_wgsl,
    "integrator/medium_light" shares medium_light::shared_wgsl,
    "integrator/mesh_lights",
    "integrator/moments",
    "integrator/nested_dielectrics" shares nested_dielectrics::shared_wgsl,
    "integrator/no_guides",
    "integrator/no_mesh_lights",
    "integrator/no_nested_dielectrics",
    "integrator/no_penumbra",
    "integrator/no_photons",
    "integrator/participating_media" shares || {
        [participating_media::shared_wgsl(), scene_medium::shared_wgsl(), scene_light::shared_wgsl()].concat()
    },
    "integrator/path",
    "integrator/path_reuse" shares path_reuse::shared_wgsl,
    "integrator/path_segment",
    "integrator/path_state" shares path_state::shared_wgsl,
    "integrator/penumbra",
    "integrator/photons" shares photon_map::shared_wgsl,
    "integrator/radiance",
    "integrator/reflected_light" shares reflected_light::shared_wgsl,
    "integrator/shadow" shares shadow::shared_wgsl,
    "integrator/sky" shares encode::sky_kinds_wgsl,
    "integrator/splitting",
    "intersect/march" shares march::shared_wgsl,
    "intersect/no_ray_kind",
    "intersect/ray",
    "intersect/ray_kind",
    "preview/light_irradiance",
    "preview/preview" shares || {
        [preview::shared_wgsl(), preview_steps::shared_wgsl(), encode::preview::shared_wgsl(),
            preview_material::shared_wgsl()].concat()
    },
    "preview/soft_shadow" shares soft_shadow::shared_wgsl,
    "sampling/basis",
    "sampling/r2_point" shares r2_sequence::shared_wgsl,
    "sampling/r2_sequence" shares || pair::shared_wgsl() + &sampling::shared_wgsl(),
    "sampling/sobol" shares || pair::shared_wgsl() + &sampling::shared_wgsl() + &encode::samplers_wgsl(),
    "sampling/unit_circle",
    "shading/mesh_fields",
    "shading/mesh_normals",
    "shading/mesh_uvs",
    "shading/no_mesh_fields",
    "shading/no_mesh_normals",
    "shading/no_mesh_uvs",
    "shading/no_orbits",
    "shading/shading_normal",
    "shading/surface_interaction",
    "shading/textured_albedo",
    "shading/textured_bsdf",
    "shading/textured_material" shares || encode::texture::shared_wgsl() + &textured_material::shared_wgsl(),
    "shading/textured_preview",
    "shading/untextured",
    "shading/untextured_albedo",
    "shading/untextured_bsdf",
    "shading/untextured_preview",
    "views/march_stats",
    "views/no_march_stats",
    "views/views" shares views::shared_wgsl,
];

/// Names after `// import:` in a shader file.
fn imports(text: &'static str) -> impl Iterator<Item = &'static str> {
    let lines = text.lines().map_while(|line| line.strip_prefix("// import:"));
    lines.flat_map(|names| names.split(',')).map(str::trim)
}

/// Text of a shader file and its imports, each file once, from these files and those of the kernels; `implementation` maps
/// an interface to a file.
///
/// # Panics
/// If a file imports a name that is neither a file nor an interface. Every test of a kernel finds this mistake.
pub(crate) fn with_imports(
    name: &str,
    files: &[ShaderFile],
    implementation: &dyn Fn(&str) -> Option<&'static str>,
) -> String {
    let mut code = String::new();
    append(name, files, implementation, &mut Vec::new(), &mut code);
    code
}

fn append(
    name: &str,
    files: &[ShaderFile],
    implementation: &dyn Fn(&str) -> Option<&'static str>,
    seen: &mut Vec<&'static str>,
    code: &mut String,
) {
    let name = implementation(name).unwrap_or(name);
    let Some(file) = files.iter().chain(FILES).find(|file| file.name == name) else {
        panic!("no shader file implements {name}");
    };
    if seen.contains(&file.name) {
        return;
    }
    seen.push(file.name);
    for import in imports(file.text) {
        append(import, files, implementation, seen, code);
    }
    *code += &format!("\n// ---- {}.wgsl ----\n", file.name);
    *code += &(file.shared)();
    for line in file.text.lines().skip_while(|line| line.starts_with("// import:")) {
        code.push_str(line);
        code.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::gpu::display::DisplayUniforms;
    use crate::wgsl::check_layout;
    use std::collections::BTreeSet;
    use std::path::{Path, PathBuf};

    /// Files of this crate and of the scene's with this extension, and their text.
    fn sources(extension: &str) -> Vec<(PathBuf, String)> {
        let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let mut folders = vec![crates.join("pathmarch-render/src"), crates.join("pathmarch-scene/src")];
        let mut files = Vec::new();
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).expect("is readable") {
                let path = entry.expect("is readable").path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|found| found == extension) {
                    let text = std::fs::read_to_string(&path).expect("is text");
                    files.push((path, text));
                }
            }
        }
        files
    }

    /// Names of constants that source text declares.
    fn constants(files: &[(PathBuf, String)]) -> BTreeSet<String> {
        let lines = files.iter().flat_map(|(_, text)| text.lines());
        let names = lines.filter_map(|line| {
            let line = line.trim_start();
            let line = line.strip_prefix("pub(crate) ").or(line.strip_prefix("pub(super) ")).unwrap_or(line);
            line.strip_prefix("pub ").unwrap_or(line).strip_prefix("const ")?.split([':', ' ']).next()
        });
        names.filter(|name| name.len() > 1 && *name == name.to_uppercase()).map(str::to_owned).collect()
    }

    #[test]
    fn no_constant_is_written_in_both_languages() {
        let (rust, wgsl) = (constants(&sources("rs")), constants(&sources("wgsl")));
        assert!(rust.contains("MAX_STEPS") && rust.contains("TOLERATED_ROUNDING_ERRORS") && wgsl.contains("NO_HIT"));
        let both: Vec<_> = rust.intersection(&wgsl).collect();
        assert!(both.is_empty(), "share these with `shared_constants!`: {both:?}");
    }

    #[test]
    fn structures_have_one_layout_in_both_languages() {
        check_layout::<FrameUniforms>();
        check_layout::<Slice>();
        check_layout::<LeafRecord>();
        check_layout::<MaterialRecord>();
        check_layout::<encode::LightRecord>();
        check_layout::<LightNode>();
        check_layout::<SuspendedPath>();
        check_layout::<DisplayUniforms>();
    }

    #[test]
    fn every_shader_file_is_listed() {
        let listed: BTreeSet<String> = FILES.iter().map(|file| file.name.to_owned()).collect();
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../pathmarch-render/src");
        let files = sources("wgsl").into_iter().filter_map(|(path, _)| {
            let name = path.strip_prefix(&root).ok()?.with_extension("");
            Some(name.to_str().expect("is Unicode").replace('\\', "/"))
        });
        // The passes list theirs.
        let is_pass = |name: &String| name == "backend/gpu/display" || name.starts_with("reconstruct/");
        let found: BTreeSet<String> = files.filter(|name| !is_pass(name)).collect();
        assert_eq!(listed, found);
    }
}
