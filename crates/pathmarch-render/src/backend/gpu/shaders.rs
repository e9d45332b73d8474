//! Shader files of the kernels, and their imports.
//!
//! A line `// import: a, b` at the top of a file names the files that it needs, by their paths in the crate, without extension.
//! Some names are interfaces instead, such as `sampler`: the kernel chooses the file that implements them. Constants and
//! structures that a file shares with Rust are printed in front of it.

use super::encode;
use super::loop_limit::SuspendedPath;
use super::slice::Slice;
use crate::integrator::{light_sampling, medium, path, shadow, splitting};
use crate::intersect::march;
use crate::preview::{self, soft_shadow};
use crate::sampling::sobol::pair;
use crate::scene::{FrameUniforms, LeafRecord, MaterialRecord, leaf, material, preview_material, textured_material};
use crate::views;
use crate::wgsl::declaration;

/// Shader file.
struct ShaderFile {
    /// Path in the crate, without extension.
    name: &'static str,
    text: &'static str,
    /// Prints the declarations that it shares with Rust.
    shared: fn() -> String,
}

macro_rules! shader_files {
    ($($name:literal $(shares $shared:expr)?,)+) => {
        &[$(ShaderFile {
            name: $name,
            text: include_str!(concat!("../../", $name, ".wgsl")),
            shared: shader_files!(@shared $($shared)?),
        }),+]
    };
    (@shared) => { String::new };
    (@shared $shared:expr) => { $shared };
}

static FILES: &[ShaderFile] = shader_files![
    "backend/gpu/buffers" shares || {
        [declaration::<FrameUniforms>(), declaration::<Slice>(), declaration::<LeafRecord>(), leaf::shared_wgsl(),
            declaration::<MaterialRecord>(), material::shared_wgsl()].concat()
    },
    "backend/gpu/film",
    "backend/gpu/loop_limit" shares declaration::<SuspendedPath>,
    "backend/gpu/loops_unlimited",
    "backend/gpu/sample",
    "backend/gpu/sample_resumed",
    "backend/gpu/trace",
    "integrator/camera",
    "integrator/light_sampling" shares || encode::light::shared_wgsl() + &light_sampling::shared_wgsl(),
    "integrator/light_weights" shares encode::light::direct_lighting_wgsl,
    "integrator/medium" shares medium::shared_wgsl,
    "integrator/moments",
    "integrator/no_penumbra",
    "integrator/path" shares path::shared_wgsl,
    "integrator/penumbra",
    "integrator/radiance",
    "integrator/shadow" shares shadow::shared_wgsl,
    "integrator/sky" shares encode::sky_kinds_wgsl,
    "integrator/splitting" shares splitting::shared_wgsl,
    "intersect/march" shares march::shared_wgsl,
    "intersect/ray",
    "preview/light_irradiance",
    "preview/preview" shares || {
        preview::shared_wgsl() + &encode::preview::shared_wgsl() + &preview_material::shared_wgsl()
    },
    "preview/soft_shadow" shares soft_shadow::shared_wgsl,
    "sampling/basis",
    "sampling/r2_sequence" shares pair::shared_wgsl,
    "sampling/sobol" shares || pair::shared_wgsl() + &encode::samplers_wgsl(),
    "shading/no_orbits",
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

/// Text of a shader file and its imports, each file once; `implementation` maps an interface to a file.
///
/// # Panics
/// If a file imports a name that is neither a file nor an interface. Every test of a kernel finds this mistake.
pub(super) fn with_imports(name: &str, implementation: &dyn Fn(&str) -> Option<&'static str>) -> String {
    let mut code = String::new();
    append(name, implementation, &mut Vec::new(), &mut code);
    code
}

fn append(
    name: &str,
    implementation: &dyn Fn(&str) -> Option<&'static str>,
    seen: &mut Vec<&'static str>,
    code: &mut String,
) {
    let name = implementation(name).unwrap_or(name);
    let Some(file) = FILES.iter().find(|file| file.name == name) else {
        panic!("no shader file implements {name}");
    };
    if seen.contains(&file.name) {
        return;
    }
    seen.push(file.name);
    for import in imports(file.text) {
        append(import, implementation, seen, code);
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
    use crate::wgsl::SharedStruct;
    use naga::TypeInner;
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

    /// Compares the layout of a structure in Rust with naga's layout of its declaration.
    fn check_layout<S: SharedStruct>() {
        let code = declaration::<S>() + &format!("@group(0) @binding(0) var<storage> all: array<{}>;\n", S::NAME);
        let module =
            naga::front::wgsl::parse_str(&code).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&code)));
        let members = module.types.iter().find_map(|(_, kind)| match &kind.inner {
            TypeInner::Struct { members, span } if kind.name.as_deref() == Some(S::NAME) => Some((members, *span)),
            _ => None,
        });
        let (members, span) = members.expect("the structure is declared");
        let found: Vec<_> =
            members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset as usize)).collect();
        let (padding, fields): (Vec<_>, Vec<_>) = S::fields().into_iter().partition(|field| field.name == "padding");
        let expected: Vec<_> = fields.iter().map(|field| (field.name.to_owned(), field.offset)).collect();
        assert_eq!(found, expected, "{}", S::NAME);
        // Padding at the end may be part of the structure in WGSL, or lie behind it.
        let sizes = [size_of::<S>(), size_of::<S>() - 4 * padding.len()];
        assert!(sizes.contains(&(span as usize)), "{}: {span} bytes, {} in Rust", S::NAME, sizes[0]);
    }

    #[test]
    fn structures_have_one_layout_in_both_languages() {
        check_layout::<FrameUniforms>();
        check_layout::<Slice>();
        check_layout::<LeafRecord>();
        check_layout::<MaterialRecord>();
        check_layout::<encode::LightRecord>();
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
        // The display pass is a shader of its own.
        let found: BTreeSet<String> = files.filter(|name| name != "backend/gpu/display").collect();
        assert_eq!(listed, found);
    }
}
