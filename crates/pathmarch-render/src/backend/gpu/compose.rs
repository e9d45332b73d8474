//! Composition of a kernel: bindings, configuration, the scene's field and materials, and the shader files of its mode.
//!
//! The configuration is a set of constants, so that the compiler removes features that the scene does not use.

use super::bindings::{Bindings, LIGHT_TREE};
use super::encode::{self, SceneData};
use super::shaders;
use crate::backend::RenderInput;
use crate::mode::Mode;
use crate::preview::Preview;
use crate::scene::frame::NO_CLAMP;
use crate::scene::material::GLOWS;
use crate::scene::{KernelConfig, MaterialRecord, Medium, TexturedMaterial};
use pathmarch_field::wgsl::{Program, ProgramOptions};
use pathmarch_scene::materials::{self, albedo, dispersion};
use pathmarch_scene::textures::{self, Pattern, Texture};
use std::collections::BTreeSet;
use std::fmt::{Display, Write};

/// Program of the scene's field for a mode. On software adapters its code may depend on the numbers of a long picture; on
/// others it does not, so that the frames of an animation share a kernel.
pub(super) fn program(input: &RenderInput, software: bool) -> Program {
    let defaults = ProgramOptions::default();
    let counts = matches!(input.mode, Mode::Steps | Mode::Violations);
    let sphere_traced_distance = if counts { "uncounted_distance" } else { defaults.sphere_traced_distance };
    // Without noise, `r2_sequence.wgsl` declares `choice`.
    let declares_choice = input.mode.traces_paths();
    let has_triangle_distances = input.preview().is_some() || input.config.penumbra;
    let has_constant_numbers = software && input.config.constant_numbers;
    let options =
        ProgramOptions { sphere_traced_distance, has_triangle_distances, declares_choice, has_constant_numbers };
    let mut program = Program::with_options(&input.scene.field, options);
    if let Some(preview) = input.preview() {
        program.write_object_sets(&input.scene.field, &preview.distance_functions());
    }
    program
}

/// WGSL that the code of fields with meshes calls.
const MESH_WORD: &str = "\
/// Word of the meshes.
fn mesh_word(index: u32) -> u32 {
    return scene_word(MESH_DATA + index);
}

";

/// WGSL in place of that of triangles, for textures at texture coordinates in fields without them.
const NO_MESH_ATTRIBUTES: &str = "\
/// Never called: no hit has a triangle.
fn mesh_uv(leaf: u32, triangle: u32, local: vec3f, uv_set: u32) -> vec3f {
    return vec3f(0.0);
}

/// Never called: no hit has a triangle.
fn mesh_colour(leaf: u32, triangle: u32, local: vec3f) -> vec4f {
    return vec4f(0.0);
}

/// Never called: no hit has a triangle.
fn mesh_tangent(leaf: u32, triangle: u32, local: vec3f) -> vec4f {
    return vec4f(0.0);
}

";

/// Kernels of a picture.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum KernelKind {
    /// Samples of all pixels.
    Samples,
    /// Further camera rays of the pixels at edges of emitters.
    EmitterEdges,
    /// Coverage of pixels by emitters, from the guides of a live picture.
    EmitterCoverage,
    /// Albedos of pixels, from the guides of a live picture.
    PixelAlbedo,
}

/// Source of a picture's kernel in WGSL.
pub(super) fn kernel(
    kind: KernelKind,
    input: &RenderInput,
    program: &Program,
    bindings: &Bindings,
    data: &SceneData,
) -> String {
    let mut code = String::from("// ---- bindings ----\n");
    code += &bindings.declarations(input, program);
    code += "\n// ---- configuration ----\n";
    code += &constants(input, data);
    code += "\n// ---- field ----\n";
    if input.scene.field.has_meshes() {
        code += MESH_WORD;
    }
    if input.config.mesh_fields && !input.config.textures {
        code += &Program::coordinates(&input.scene.field);
    }
    if input.config.uv_textures && !input.scene.field.has_meshes() {
        code += NO_MESH_ATTRIBUTES;
    }
    code += &program.code;
    if input.mode.traces_paths() {
        if input.config.penumbra {
            code.push('\n');
            code += &program.estimated_distance;
        }
        code += "\n// ---- materials ----\n";
        code += &bsdfs(input);
    }
    if let Some(preview) = input.preview() {
        code.push('\n');
        code += &Program::distances_to(&input.scene.field, &preview.distance_functions());
    }
    if input.config.textures {
        code += "\n// ---- textures ----\n";
        code += &textures_of(input);
    }
    let entry = match kind {
        KernelKind::EmitterEdges => "backend/gpu/emitter_edges",
        KernelKind::EmitterCoverage => "backend/gpu/emitter_coverage",
        KernelKind::PixelAlbedo => "backend/gpu/pixel_albedo",
        KernelKind::Samples if input.config.path_reuse => "backend/gpu/trace_tiles",
        KernelKind::Samples if bindings.pixels_per_lane > 1 => "backend/gpu/trace_pixels",
        KernelKind::Samples => "backend/gpu/trace",
    };
    code + &shaders::with_imports(entry, &[], &|name| implementation(name, input, bindings))
}

/// Shader file that implements an interface; `None` for names of files.
fn implementation(interface: &str, input: &RenderInput, bindings: &Bindings) -> Option<&'static str> {
    let KernelConfig { textures, penumbra, splitting, .. } = input.config;
    let (mode, limited) = (input.mode, bindings.loops_are_limited);
    let if_paths = |paths, preview, views| match mode {
        Mode::Path | Mode::Variance => paths,
        Mode::Preview => preview,
        _ => views,
    };
    Some(match interface {
        "sampler" if mode.traces_paths() => "sampling/sobol",
        "sampler" => "sampling/r2_sequence",
        "estimator" => if_paths("integrator/path", "preview/preview", "views/views"),
        "film_value" if mode == Mode::Variance => "integrator/moments",
        "film_value" => "integrator/radiance",
        "photons" if input.config.traced_caustics => "integrator/photons",
        "photons" => "integrator/no_photons",
        "near_misses" if penumbra => "integrator/penumbra",
        "near_misses" => "integrator/no_penumbra",
        "textures" if textures => "shading/textured_material",
        "textures" => "shading/untextured",
        "texture_target" if textures => {
            if_paths("shading/textured_bsdf", "shading/textured_preview", "shading/textured_albedo")
        }
        "texture_target" => {
            if_paths("shading/untextured_bsdf", "shading/untextured_preview", "shading/untextured_albedo")
        }
        "ray_kind" if input.scene.field.has_meshes_lit_by_field() => "intersect/ray_kind",
        "ray_kind" => "intersect/no_ray_kind",
        "mesh_normals" if input.scene.field.has_shading_normals() => "shading/mesh_normals",
        "mesh_normals" => "shading/no_mesh_normals",
        "light_choice" if input.light_tree().is_none() => "integrator/light_table",
        "light_choice" => "integrator/light_tree",
        "light_nodes" if bindings.is_uniform(LIGHT_TREE) => "integrator/light_nodes_uniform",
        "light_nodes" => "integrator/light_nodes_storage",
        "mesh_lights" if !input.scene.mesh_lights.is_empty() => "integrator/mesh_lights",
        "mesh_lights" => "integrator/no_mesh_lights",
        "mesh_fields" if input.config.mesh_fields => "shading/mesh_fields",
        "mesh_fields" => "shading/no_mesh_fields",
        "mesh_uvs" if input.config.uv_textures => "shading/mesh_uvs",
        "mesh_uvs" => "shading/no_mesh_uvs",
        "media" if input.config.media => "integrator/participating_media",
        "media" => "integrator/absorbing_media",
        "nested_dielectrics" if input.config.nested_dielectrics => "integrator/nested_dielectrics",
        "nested_dielectrics" => "integrator/no_nested_dielectrics",
        "path_segment" if input.config.media => "integrator/media_segment",
        "path_segment" => "integrator/path_segment",
        "guides" if bindings.has_guides => "integrator/guides",
        "guides" => "integrator/no_guides",
        "march_stats" if matches!(mode, Mode::Steps | Mode::Violations) => "views/march_stats",
        "march_stats" => "views/no_march_stats",
        "loop_check" if limited => "backend/gpu/loop_limit",
        "loop_check" => "backend/gpu/loops_unlimited",
        "slice" if splitting > 1 => "integrator/splitting",
        "slice" if limited && mode.traces_paths() => "backend/gpu/sample_resumed",
        "slice" => "backend/gpu/sample",
        _ => return None,
    })
}

/// Constants that configure the shader files.
fn constants(input: &RenderInput, data: &SceneData) -> String {
    let (scene, config) = (&input.scene, &input.config);
    let mut code = String::new();
    let mut constant = |name: &str, value: &dyn Display| {
        writeln!(code, "const {name} = {value};").expect("writing to a string");
    };
    let has_pictures =
        |texture: &Texture| matches!(texture.pattern, Pattern::Picture { .. } | Pattern::UvPicture { .. });
    let mut textures = scene.textured_materials.iter().flat_map(TexturedMaterial::textures);
    for (name, value) in [
        ("ABSORPTION", config.absorption),
        ("PARTICIPATING_MEDIA", scene.media.participate()),
        ("HAS_BOUNDARIES", config.boundaries),
        ("MEDIA_ARE_BOUNDED", config.media_are_bounded),
        ("LIGHTS_IN_SOLIDS", config.lights_in_solids),
        ("TRANSMISSION", config.transmission),
        ("CHOOSES_LOBES", config.chooses_lobes),
        ("NESTED_DIELECTRICS", config.nested_dielectrics),
        ("THIN_GLASS", scene.media.has_thin_glass()),
        ("DISPERSION", config.dispersion),
        ("COMPENSATES", scene.any_bsdf(|bsdf| bsdf.compensates)),
        ("FAST_CAUSTICS", config.fast_caustics),
        ("TRACED_CAUSTICS", config.traced_caustics),
        ("PENUMBRA", config.penumbra),
        ("REFINED_GRAZING", config.refined_grazing),
        ("CLAMPS", input.frame.clamp < NO_CLAMP),
        ("HAS_SPHERE_TRACED", scene.is_sphere_traced()),
        ("HAS_EMITTERS", scene.materials.iter().any(MaterialRecord::emits)),
        ("HAS_LIGHTS", !scene.lights.is_empty()),
        ("HAS_FACING_LIGHTS", input.light_tree().is_some_and(|tree| tree.has_facing_lights)),
        ("HAS_SURFACE_LIGHTS", scene.lights.iter().any(|light| light.leaf().is_some())),
        ("HAS_REFLECTIONS", input.preview().is_some_and(Preview::has_reflections)),
        ("HAS_TEXTURES", config.textures),
        ("HAS_ORBITS", config.orbits),
        ("HAS_BUMP", config.bump),
        ("HAS_NORMAL_MAPS", config.normal_maps),
        ("HAS_EMISSION_TEXTURES", config.emission_textures),
        ("HAS_GLOW", scene.materials.iter().any(|material| material.has(GLOWS))),
        ("SHADING_NORMALS", config.shading_normals),
        ("HAS_PICTURES", textures.any(has_pictures)),
        ("HAS_DECALS", config.decals),
        ("PATH_REUSE", config.path_reuse),
    ] {
        constant(name, &value);
    }
    for (kind, name) in (0..).zip(encode::light::KIND_NAMES) {
        constant(&format!("HAS_{name}"), &scene.lights.iter().any(|light| light.shape.kind() == kind));
    }
    constant("RELAXATION", &format_args!("{:?}", config.relaxation));
    for (name, value) in [
        ("DIRECT_LIGHTING", config.direct_lighting as u32),
        ("SAMPLER", input.frame.sampler),
        ("SPLITTING", config.splitting),
        ("LIGHT_SAMPLES", config.light_samples),
        ("INDIRECT_SAMPLES", config.indirect_samples),
        ("SKY", encode::sky_kind(&scene.sky) as u32),
        ("SKY_DATA", data.sky as u32),
        ("LIGHT_TREE_DATA", data.light_tree as u32),
        ("PHOTON_DATA", data.photons as u32),
        ("GGX_DATA", data.ggx as u32),
        ("GGX_ROUGHNESSES", albedo::ROUGHNESSES as u32),
        ("GGX_COSINES", albedo::COSINES as u32),
        ("TEXTURE_DATA", data.textures as u32),
        ("LEAF_COUNT", scene.leaves.len() as u32),
        ("MODE_DATA", data.mode as u32),
        ("MESH_LIGHT_DATA", data.mesh_lights as u32),
        ("MESH_DATA", data.meshes as u32),
        ("MEDIUM_DATA", data.media as u32),
        ("MEDIUM_WORDS", Medium::WORDS as u32),
        ("DIELECTRIC_DATA", data.dielectrics as u32),
        ("EDGE_DATA", data.edges as u32),
    ] {
        constant(name, &format_args!("{value}u"));
    }
    let views = [Mode::Normal, Mode::Depth, Mode::Albedo, Mode::Steps, Mode::Violations];
    for (number, name) in ["NORMAL", "DEPTH", "ALBEDO", "STEPS", "VIOLATIONS"].into_iter().enumerate() {
        constant(&format!("VIEW_{name}"), &format_args!("{number}u"));
    }
    // All other views show a colour of each leaf.
    let view = views.iter().position(|&view| view == input.mode).unwrap_or(views.len());
    constant("VIEW", &format_args!("{view}u"));
    code
}

/// Coordinates and orbits of the field, and the functions of the textures in use.
fn textures_of(input: &RenderInput) -> String {
    let scene = &input.scene;
    let textures = scene.textured_materials.iter().flat_map(TexturedMaterial::textures);
    let kinds: BTreeSet<usize> = textures
        .filter_map(|texture| match &texture.pattern {
            Pattern::Computed { kind, .. } => Some(encode::computed_kind(kind)),
            Pattern::Picture { .. } | Pattern::UvPicture { .. } => None,
        })
        .collect();
    let mut code = Program::coordinates(&scene.field);
    code += &match input.config.orbits {
        true => Program::orbits(&scene.field),
        false => shaders::with_imports("shading/no_orbits", &[], &|_| None),
    };
    code += textures::SHARED_WGSL;
    code += textures::PICTURE_WGSL;
    code += textures::DECAL_WGSL;
    let mut choice = String::new();
    for kind in kinds {
        let texture = textures::kinds()[kind];
        code.push('\n');
        code += texture.wgsl;
        writeln!(choice, "    if kind == {kind}u {{\n        return {}_texture(spot, k);\n    }}", texture.name)
            .expect("writing to a string");
    }
    code + &format!(
        "\n/// Value of a computed texture.\nfn computed_texture(kind: u32, spot: Spot, k: array<f32, 8>) -> f32 \
         {{\n{choice}    return 0.0;\n}}\n"
    )
}

/// Functions of the BSDFs in use, and the choice among them.
fn bsdfs(input: &RenderInput) -> String {
    let kinds = materials::kinds();
    let used: BTreeSet<u32> = input.scene.materials.iter().map(|material| material.kind).collect();
    let used: Vec<_> =
        used.iter().filter_map(|&kind| Some((kind, kinds[kind as usize].name, kinds[kind as usize].bsdf?))).collect();
    let mut code = materials::constants_wgsl() + &dispersion::wgsl() + &materials::SHARED_WGSL.join("\n");
    let (mut eval, mut sample) = (String::new(), String::new());
    let (mut facets, mut share, mut chance) = (String::new(), String::new(), String::new());
    for (k, (kind, name, bsdf)) in used.iter().enumerate() {
        code.push('\n');
        code += bsdf.wgsl;
        // The last one needs no condition.
        let condition = if k + 1 < used.len() { format!("if kind == {kind}u ") } else { String::new() };
        writeln!(eval, "    {condition}{{\n        return {name}_eval(m, wo, wi, inside);\n    }}")
            .expect("writing to a string");
        if bsdf.facets.is_some() {
            writeln!(facets, "    if kind == {kind}u {{\n        return {name}_facets(m);\n    }}")
                .expect("writing to a string");
            writeln!(share, "    if kind == {kind}u {{\n        return {name}_facet_share(m, wo, wi, inside);\n    }}")
                .expect("writing to a string");
            writeln!(chance, "    if kind == {kind}u {{\n        return {name}_facet_chance(m, wo, inside);\n    }}")
                .expect("writing to a string");
        }
        writeln!(sample, "    {condition}{{\n        return {name}_sample(m, wo, inside, u);\n    }}")
            .expect("writing to a string");
    }
    if used.is_empty() {
        eval += "    return vec4f(0.0);\n";
        sample += "    return ABSORBED;\n";
    }
    code + &format!(
        "\n/// BSDF times cosine, and the pdf of `wi` over solid angle.\n\
         fn bsdf_eval(kind: u32, m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {{\n{eval}}}\n\n\
         fn bsdf_sample(kind: u32, m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {{\n{sample}}}\n\n\
         /// Alpha of the facets, 0 if there are none, and 1 if they reflect in the colour of the surface.\n\
         fn bsdf_facets(kind: u32, m: u32) -> vec2f {{\n{facets}    return vec2f(0.0);\n}}\n\n\
         /// Share of the facets in `bsdf_eval`.\n\
         fn bsdf_facet_share(kind: u32, m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec3f {{\n{share}    \
         return vec3f(0.0);\n}}\n\n\
         /// Chance that a direction of `bsdf_sample` is one of the facets.\n\
         fn bsdf_facet_chance(kind: u32, m: u32, wo: vec3f, inside: bool) -> f32 {{\n{chance}    return 0.0;\n}}\n"
    )
}
