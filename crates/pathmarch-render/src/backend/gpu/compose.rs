//! The whole kernel of a scene as text: the fixed parts, the scene's field, its materials, and what it needs of the
//! estimator as constants, so that a scene pays for nothing that it does not use.

use super::bindings::Bindings;
use super::encode::{self, SceneData};
use crate::backend::RenderInput;
use crate::mode::Mode;
use crate::scene::textured_material::{KNOTS, TexturedMaterial};
use crate::scene::{KernelConfig, MaterialRecord};
use pathmarch_field::wgsl::{CHOICE, Program};
use pathmarch_scene::materials::{self, albedo};
use pathmarch_scene::textures::{self, Pattern};
use std::collections::BTreeSet;
use std::fmt::{Display, Write};

/// The field's distance, which says how often a march called it, and how fast it changed between its points at most, over what
/// is allowed.
const WATCHING: &str = "
var<private> watched: vec4f;

fn sphere_traced_distance(p: vec3f) -> f32 {
    let distance = unwatched_distance(p);
    let change = abs(distance - watched.w) * frame.step_factor - NOISE * frame.rounding * largest(abs(p));
    if steps > 0u {
        steepest = max(steepest, change / max(length(p - watched.xyz), 1e-30));
    }
    watched = vec4f(p, distance);
    steps += 1u;
    return distance;
}
";

/// Kernel of a picture, in WGSL.
pub(super) fn kernel(input: &RenderInput, program: &Program, bindings: &Bindings, data: &SceneData) -> String {
    let mode = input.mode;
    let mut code = bindings.declarations(input, program) + &program.code;
    if mode.traces_paths() {
        if input.config.penumbra {
            code.push('\n');
            code.push_str(&program.estimated_distance);
        }
        code += &constants(input, data);
        code += &scattering(input);
    } else {
        // `r2_sequence.wgsl` has one without noise.
        code = code.replace(CHOICE, "");
        if matches!(mode, Mode::Steps | Mode::Violations) {
            code = code.replace("fn sphere_traced_distance(", "fn unwatched_distance(") + WATCHING;
        }
        code += &constants_of_mode(input, data);
    }
    code += &textures_of(input, data);
    writeln!(code, "const RELAXATION = {:?};", input.config.relaxation).expect("writing to a string");
    writeln!(code, "const HAS_SPHERE_TRACED = {};", input.scene.is_sphere_traced()).expect("writing to a string");
    writeln!(code, "const REFINED_GRAZING = {};", input.config.refined_grazing).expect("writing to a string");
    for part in parts(mode) {
        code.push('\n');
        code.push_str(part);
    }
    code.push('\n');
    code += &samples_wgsl(mode, input.config.splitting, bindings.loops_are_limited);
    code + include_str!("trace.wgsl")
}

/// Name of the function that computes a sample: `NAME(camera: Ray, random: Random) -> vec3f`.
fn trace_function(mode: Mode) -> &'static str {
    match mode {
        Mode::Path => PATH_FUNCTION,
        Mode::Preview => "preview_along",
        Mode::Variance => "moments_along",
        _ => "view_along",
    }
}

/// The function of [`Mode::Path`].
const PATH_FUNCTION: &str = "radiance_along";

/// What the entry point computes: `samples_of(x: u32, y: u32) -> vec4f`.
fn samples_wgsl(mode: Mode, splitting: u32, loops_are_limited: bool) -> String {
    let checks = match loops_are_limited {
        true => include_str!("loop_limit.wgsl"),
        false => include_str!("loops_unlimited.wgsl"),
    };
    let samples = match splitting {
        1 if loops_are_limited && mode.traces_paths() => include_str!("sample_resumed.wgsl").to_owned(),
        1 => include_str!("sample.wgsl").replace(PATH_FUNCTION, trace_function(mode)),
        _ => include_str!("../../integrator/splitting.wgsl").to_owned(),
    };
    format!("{checks}\n{samples}")
}

/// The kernel's WGSL but for the scene's field and the entry point; declarations may stand in any order.
fn parts(mode: Mode) -> &'static [&'static str] {
    const BASIS: &str = include_str!("../../sampling/basis.wgsl");
    const CAMERA: &str = include_str!("../../integrator/camera.wgsl");
    const FRAME: &str = include_str!("frame.wgsl");
    const LIGHTS: &str = include_str!("../../integrator/light_sampling.wgsl");
    const MARCH: &str = include_str!("../../intersect/march.wgsl");
    const PATH: &str = include_str!("../../integrator/path.wgsl");
    const RANDOM: &str = include_str!("../../sampling/sobol.wgsl");
    const SHADOW: &str = include_str!("../../integrator/shadow.wgsl");
    const SKY: &str = include_str!("../../integrator/sky.wgsl");
    const STEADY: &str = include_str!("../../sampling/r2_sequence.wgsl");
    const VISIBLE: &str = include_str!("../../shading/surface_interaction.wgsl");
    const RADIANCE: &str = include_str!("../../integrator/radiance.wgsl");
    const MOMENTS: &str = include_str!("../../integrator/moments.wgsl");
    match mode {
        Mode::Path => &[BASIS, CAMERA, LIGHTS, MARCH, FRAME, PATH, RANDOM, SHADOW, SKY, RADIANCE],
        Mode::Variance => &[BASIS, CAMERA, LIGHTS, MARCH, FRAME, PATH, RANDOM, SHADOW, SKY, MOMENTS],
        Mode::Preview => &[
            BASIS,
            CAMERA,
            LIGHTS,
            MARCH,
            FRAME,
            SKY,
            STEADY,
            VISIBLE,
            include_str!("../../preview/light_irradiance.wgsl"),
            include_str!("../../preview/preview.wgsl"),
            include_str!("../../preview/soft_shadow.wgsl"),
        ],
        _ => &[CAMERA, MARCH, FRAME, STEADY, VISIBLE, include_str!("../../views/views.wgsl")],
    }
}

/// What a mode without noise needs of the scene.
fn constants_of_mode(input: &RenderInput, data: &SceneData) -> String {
    let mut code = String::from("\n");
    if let Some(preview) = input.preview() {
        code += &Program::distances_to(&input.scene.field, &preview.distance_functions());
        code += &constants(input, data);
        writeln!(code, "const MIRRORS = {};", preview.has_reflections()).expect("writing to a string");
    } else {
        let views = [Mode::Normal, Mode::Depth, Mode::Albedo, Mode::Steps, Mode::Violations];
        for (number, name) in ["NORMAL", "DEPTH", "ALBEDO", "STEPS", "VIOLATIONS"].into_iter().enumerate() {
            writeln!(code, "const VIEW_{name} = {number}u;").expect("writing to a string");
        }
        // The others show a colour of the leaf and nothing else.
        let view = views.iter().position(|&view| view == input.mode).unwrap_or(views.len());
        writeln!(code, "const VIEW = {view}u;").expect("writing to a string");
    }
    writeln!(code, "const MODE_TABLE = {}u;", data.mode).expect("writing to a string");
    code
}

fn constants(input: &RenderInput, data: &SceneData) -> String {
    let KernelConfig { absorption, transmission, chooses_lobes, fast_caustics, penumbra, light_search, .. } =
        input.config;
    let near_misses = if penumbra {
        include_str!("../../integrator/penumbra.wgsl")
    } else {
        "fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {\n    return 1.0;\n}\n"
    };
    let scene = &input.scene;
    let sky = match (scene.sky.environment(), scene.sky.is_gradient()) {
        (Some(_), _) => 2,
        (None, true) => 1,
        (None, false) => 0,
    };
    let (roughnesses, cosines) = (albedo::ROUGHNESSES, albedo::COSINES);
    let mut code = String::from("\n");
    let mut constant = |name: &str, value: &dyn Display| {
        writeln!(code, "const {name} = {value};").expect("writing to a string");
    };
    for (name, value) in [
        ("ABSORPTION", absorption),
        ("TRANSMISSION", transmission),
        ("CHOOSES_LOBES", chooses_lobes),
        ("FAST_CAUSTICS", fast_caustics),
        ("PENUMBRA", penumbra),
        ("HAS_EMITTERS", scene.materials.iter().any(MaterialRecord::emits)),
        ("HAS_LIGHTS", !scene.lights.is_empty()),
        ("HAS_SURFACE_LIGHTS", scene.lights.iter().any(|light| light.leaf().is_some())),
    ] {
        constant(name, &value);
    }
    for (kind, name) in (0..).zip(encode::KIND_NAMES) {
        constant(&format!("HAS_{name}"), &scene.lights.iter().any(|light| light.shape.kind() == kind));
    }
    for (name, value) in [
        ("LIGHT_SEARCH", light_search as u32),
        ("SAMPLER", input.frame.sampler),
        ("SPLITTING", input.config.splitting),
        ("SKY", sky),
        ("SKY_TABLE", data.sky as u32),
        ("GGX_TABLE", data.ggx as u32),
        ("GGX_ROUGHNESSES", roughnesses as u32),
        ("GGX_COSINES", cosines as u32),
    ] {
        constant(name, &format_args!("{value}u"));
    }
    if input.preview().is_none() {
        code.push('\n');
        code += near_misses;
    }
    code
}

/// Surfaces along which nothing varies.
const UNPAINTED: &str = "
fn paint(m: u32, leaf: u32, p: vec3f, outward: vec3f, path_length: f32) {}

fn shaded_normal(outward: vec3f, normal: vec3f, view: vec3f) -> vec3f {
    return normal;
}
";

/// What paths read of them.
const UNPAINTED_NUMBERS: &str = "
fn packed(m: u32, k: u32) -> vec4f {
    return materials[m].numbers[k];
}

fn tint(m: u32, leaf: u32, p: vec3f, outward: vec3f, path_length: f32) -> vec3f {
    return materials[m].numbers[0].xyz;
}
";

/// A path's look at clear glass on the way to a light; what it has met last stays as it is.
const TINT: &str = "
fn tint(m: u32, leaf: u32, p: vec3f, outward: vec3f, path_length: f32) -> vec3f {
    let kept = own;
    let kept_relief = relief;
    paint(m, leaf, p, outward, path_length);
    let colour = own[0].xyz;
    own = kept;
    relief = kept_relief;
    return colour;
}
";

/// What varies along surfaces, if anything does, and whether.
fn textures_of(input: &RenderInput, data: &SceneData) -> String {
    let KernelConfig { textures: textured, orbits, bump, .. } = input.config;
    let scene = &input.scene;
    let patterns =
        || scene.textured_materials.iter().flat_map(TexturedMaterial::textures).map(|texture| &texture.pattern);
    let pictures = patterns().any(|pattern| matches!(pattern, Pattern::Picture { .. }));
    let kinds: BTreeSet<usize> = patterns()
        .filter_map(|pattern| match pattern {
            Pattern::Computed { kind, .. } => Some(encode::computed_kind(kind)),
            Pattern::Picture { .. } => None,
        })
        .collect();
    let mut code = String::from("\n");
    let flags = [("HAS_PAINT", textured), ("HAS_ORBITS", orbits), ("HAS_BUMP", bump), ("HAS_PICTURES", pictures)];
    for (name, value) in flags {
        writeln!(code, "const {name} = {value};").expect("writing to a string");
    }
    if !textured {
        code += UNPAINTED;
        return code
            + match input.mode {
                Mode::Path | Mode::Variance => UNPAINTED_NUMBERS,
                Mode::Preview => "fn changed_look(look: Look) -> Look {\n    return look;\n}\n",
                _ => "const painted_colour = vec4f(0.0);\n",
            };
    }
    for (name, value) in [
        ("PAINT_TABLE", data.textures as u32),
        ("LEAF_COUNT", scene.leaves.len() as u32),
        ("KNOTS", KNOTS as u32),
        ("ORBIT_SOURCE", encode::ORBIT),
        ("PICTURE_SOURCE", encode::PICTURE),
        ("OWN_COLOURS_LAYER", encode::OWN_COLOURS),
        ("PACKED_LAYER", encode::PACKED),
    ] {
        writeln!(code, "const {name} = {value}u;").expect("writing to a string");
    }
    code.push('\n');
    code += &Program::coordinates(&scene.field);
    code += &match orbits {
        true => Program::orbits(&scene.field),
        false => {
            "fn has_orbit(leaf: u32) -> bool {\n    return false;\n}\n\nfn orbit(leaf: u32, p: vec3f) -> array<f32, 5> \
                  {\n    return array<f32, 5>();\n}\n\n"
                .to_owned()
        }
    };
    code += textures::SHARED_WGSL;
    code += textures::PICTURE_WGSL;
    let mut choice = String::new();
    for kind in kinds {
        let texture = textures::kinds()[kind];
        code.push('\n');
        code += texture.wgsl;
        writeln!(choice, "    if kind == {kind}u {{\n        return {}_texture(spot, k);\n    }}", texture.name)
            .expect("writing to a string");
    }
    write!(
        code,
        "\n/// The value of a computed texture.\nfn computed_texture(kind: u32, spot: Spot, k: array<f32, 8>) -> f32 \
         {{\n{choice}    return 0.0;\n}}\n\n"
    )
    .expect("writing to a string");
    code += &[include_str!("../../shading/textured_material.wgsl"), texture_targets(input.mode)].join("\n");
    if input.mode.traces_paths() {
        code += TINT;
    }
    code
}

/// WGSL of what textures change in a mode.
fn texture_targets(mode: Mode) -> &'static str {
    match mode {
        Mode::Path | Mode::Variance => include_str!("../../shading/textured_bsdf.wgsl"),
        Mode::Preview => include_str!("../../shading/textured_preview.wgsl"),
        _ => include_str!("../../shading/textured_albedo.wgsl"),
    }
}

/// The functions of the materials in use, and the choice among them.
fn scattering(input: &RenderInput) -> String {
    let kinds = materials::kinds();
    let used: BTreeSet<u32> = input.scene.materials.iter().map(|material| material.kind).collect();
    let used: Vec<_> =
        used.iter().filter_map(|&kind| Some((kind, kinds[kind as usize].name, kinds[kind as usize].bsdf?))).collect();
    let mut code = materials::SHARED_WGSL.join("\n");
    let (mut eval, mut sample) = (String::new(), String::new());
    for (k, (kind, name, bsdf)) in used.iter().enumerate() {
        code.push('\n');
        code += bsdf.wgsl;
        // The last one needs no question.
        let question = if k + 1 < used.len() { format!("if kind == {kind}u ") } else { String::new() };
        writeln!(eval, "    {question}{{\n        return {name}_eval(m, wo, wi, inside);\n    }}")
            .expect("writing to a string");
        writeln!(sample, "    {question}{{\n        return {name}_sample(m, wo, inside, u);\n    }}")
            .expect("writing to a string");
    }
    if used.is_empty() {
        eval += "    return vec4f(0.0);\n";
        sample += "    return ABSORBED;\n";
    }
    code + &format!(
        "\n/// BSDF times cosine, and the density of `wi`.\n\
         fn bsdf_eval(kind: u32, m: u32, wo: vec3f, wi: vec3f, inside: bool) -> vec4f {{\n{eval}}}\n\n\
         fn bsdf_sample(kind: u32, m: u32, wo: vec3f, inside: bool, u: vec3f) -> Scattered {{\n{sample}}}\n"
    )
}
