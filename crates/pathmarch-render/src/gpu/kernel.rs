//! The whole kernel of a scene as text: the fixed parts, the scene's field, its materials, and what it needs of the
//! estimator as constants, so that a scene pays for nothing that it does not use.

use crate::frame::{EMITS, Features, Prepared};
use crate::mode::Mode;
use crate::transport::{self, lights};
use pathmarch_field::wgsl::{CHOICE, MAX_UNIFORM_VECTORS, Program};
use pathmarch_scene::materials::{self, albedo};
use std::collections::BTreeSet;
use std::fmt::{Display, Write};

/// The field's distance, which says how often a march called it.
const COUNTING: &str = "
fn marched_distance(p: vec3f) -> f32 {
    steps += 1u;
    return uncounted_distance(p);
}
";

/// The field's distance, which says how fast it changed between the points of a march at most, over what is allowed.
const WATCHING: &str = "
var<private> steepest: f32;
var<private> watched: vec4f;

fn marched_distance(p: vec3f) -> f32 {
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

/// The kernel, in WGSL.
pub(crate) fn kernel(prepared: &Prepared, program: &Program) -> String {
    let count = program.parameters.len();
    let space = if count <= MAX_UNIFORM_VECTORS { "uniform" } else { "storage, read" };
    let mode = prepared.mode;
    let mut code =
        format!("@group(0) @binding(2) var<{space}> field_parameters: array<vec4f, {count}>;\n\n{}", program.code);
    if mode.traces_paths() {
        if prepared.features.penumbra {
            code.push('\n');
            code.push_str(&program.whole_distance);
        }
        code += &constants(prepared);
        code += &scattering(prepared);
    } else {
        // `steady.wgsl` has one without noise.
        code = code.replace(CHOICE, "");
        if mode == Mode::Steps {
            code = code.replace("fn marched_distance(", "fn uncounted_distance(") + COUNTING;
        }
        if mode == Mode::Violations {
            code = code.replace("fn marched_distance(", "fn unwatched_distance(") + WATCHING;
        }
        code += &numbers_of_mode(prepared);
    }
    for part in transport::kernel(mode) {
        code.push('\n');
        code.push_str(part);
    }
    code.push('\n');
    code + &transport::TRACE.replace(transport::PATH_WGSL, transport::trace_wgsl(mode))
}

/// What a mode without noise needs of the scene.
fn numbers_of_mode(prepared: &Prepared) -> String {
    let mut code = String::from("\n");
    if let Some(preview) = &prepared.preview {
        let distances = [("occluder_distance", &preview.occluders[..]), ("near_distance", &preview.neighbours[..])];
        code += &Program::distances_to(&prepared.field, &distances);
        code += &constants(prepared);
        writeln!(code, "const MIRRORS = {};", preview.mirrors()).expect("writing to a string");
    } else {
        let views = [Mode::Normal, Mode::Depth, Mode::Albedo, Mode::Steps, Mode::Violations];
        for (number, name) in ["NORMAL", "DEPTH", "ALBEDO", "STEPS", "VIOLATIONS"].into_iter().enumerate() {
            writeln!(code, "const VIEW_{name} = {number}u;").expect("writing to a string");
        }
        // The others show a colour of the leaf and nothing else.
        let view = views.iter().position(|&view| view == prepared.mode).unwrap_or(views.len());
        writeln!(code, "const VIEW = {view}u;").expect("writing to a string");
        if prepared.mode != Mode::Violations {
            code += "const steepest = 0.0;\n";
        }
    }
    writeln!(code, "const MODE_TABLE = {}u;", prepared.mode_table).expect("writing to a string");
    code
}

fn constants(prepared: &Prepared) -> String {
    let Features { absorption, transmission, chooses_lobes, fast_caustics, penumbra, light_search, .. } =
        prepared.features;
    let near_misses = if penumbra {
        transport::PENUMBRA
    } else {
        "fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {\n    return 1.0;\n}\n"
    };
    let (sky, sky_table, ggx_table) = (prepared.sky.form(), prepared.sky_table, prepared.ggx_table);
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
        ("HAS_EMITTERS", prepared.materials.iter().any(|material| material.flags & EMITS != 0)),
        ("HAS_LIGHTS", !prepared.lights.is_empty()),
        ("HAS_SURFACE_LIGHTS", prepared.lights.iter().any(|light| light.emitting_leaf().is_some())),
    ] {
        constant(name, &value);
    }
    for (kind, name) in (0..).zip(lights::KIND_NAMES) {
        constant(&format!("HAS_{name}"), &prepared.lights.iter().any(|light| light.kind() == kind));
    }
    for (name, value) in [
        ("LIGHT_SEARCH", light_search as u32),
        ("SAMPLER", prepared.frame.sampler),
        ("SKY", sky),
        ("SKY_TABLE", sky_table as u32),
        ("GGX_TABLE", ggx_table as u32),
        ("PAINT_TABLE", prepared.paint_table as u32),
        ("GGX_ROUGHNESSES", roughnesses as u32),
        ("GGX_COSINES", cosines as u32),
    ] {
        constant(name, &format_args!("{value}u"));
    }
    if prepared.preview.is_none() {
        code.push('\n');
        code += near_misses;
    }
    code
}

/// The functions of the materials in use, and the choice among them.
fn scattering(prepared: &Prepared) -> String {
    let kinds = materials::kinds();
    let used: BTreeSet<u32> = prepared.materials.iter().map(|material| material.kind).collect();
    let used: Vec<_> =
        used.iter().filter_map(|&kind| Some((kind, kinds[kind as usize].name, kinds[kind as usize].bsdf?))).collect();
    let mut code = match prepared.features.orbit_traps {
        true => Program::orbits(&prepared.field) + transport::PAINT,
        false => {
            "fn paint(m: u32, leaf: u32, p: vec3f) {}\n\nfn base(m: u32) -> vec4f {\n    return materials[m].a;\n}\n\n"
                .to_owned()
        }
    };
    code += &materials::SHARED_WGSL.join("\n");
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
