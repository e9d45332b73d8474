//! The whole kernel of a scene as text: the fixed parts, the scene's field, its materials, and what it needs of the
//! estimator as constants, so that a scene pays for nothing that it does not use.

use super::memory::Memory;
use crate::frame::{EMITS, Features, Prepared};
use crate::mode::Mode;
use crate::transport::paint::{self, Paint};
use crate::transport::{self, lights};
use pathmarch_field::wgsl::{Program, ProgramOptions};
use pathmarch_scene::materials::{self, albedo};
use pathmarch_scene::textures;
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

/// The program of the scene's field for the kernel of its mode.
pub(super) fn program(prepared: &Prepared) -> Program {
    let defaults = ProgramOptions::default();
    let sphere_traced_distance = match prepared.mode {
        Mode::Steps | Mode::Violations => "unwatched_distance",
        _ => defaults.sphere_traced_distance,
    };
    // `steady.wgsl` declares a `choice` without noise.
    let declares_choice = prepared.mode.traces_paths();
    Program::with_options(&prepared.field, ProgramOptions { sphere_traced_distance, declares_choice })
}

/// The kernel, in WGSL.
pub(super) fn kernel(prepared: &Prepared, program: &Program, memory: &Memory) -> String {
    let mode = prepared.mode;
    let mut code = memory.declarations(prepared, program) + &program.code;
    if mode.traces_paths() {
        if prepared.features.penumbra {
            code.push('\n');
            code.push_str(&program.estimated_distance);
        }
        code += &constants(prepared);
        code += &scattering(prepared);
    } else {
        if matches!(mode, Mode::Steps | Mode::Violations) {
            code += WATCHING;
        }
        code += &numbers_of_mode(prepared);
    }
    code += &paint(prepared);
    writeln!(code, "const RELAXATION = {:?};", prepared.features.relaxation).expect("writing to a string");
    writeln!(code, "const HAS_MARCHED = {};", prepared.marches()).expect("writing to a string");
    writeln!(code, "const REFINED_GRAZING = {};", prepared.features.refined_grazing).expect("writing to a string");
    for part in transport::kernel(mode) {
        code.push('\n');
        code.push_str(part);
    }
    code.push('\n');
    code += &transport::samples_wgsl(mode, prepared.features.splitting, memory.loops_are_limited);
    code + transport::TRACE
}

/// What a mode without noise needs of the scene.
fn numbers_of_mode(prepared: &Prepared) -> String {
    let mut code = String::from("\n");
    if let Some(preview) = &prepared.preview {
        code += &Program::distances_to(&prepared.field, &preview.counted());
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
        ("SPLITTING", prepared.features.splitting),
        ("SKY", sky),
        ("SKY_TABLE", sky_table as u32),
        ("GGX_TABLE", ggx_table as u32),
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
fn paint(prepared: &Prepared) -> String {
    let Features { paint, orbits, bump, .. } = prepared.features;
    let uses: Vec<_> = prepared.paints.iter().map(Paint::uses).collect();
    let pictures = uses.iter().any(|(_, pictures)| *pictures);
    let kinds: BTreeSet<usize> = uses.into_iter().flat_map(|(kinds, _)| kinds).collect();
    let mut code = String::from("\n");
    let flags = [("HAS_PAINT", paint), ("HAS_ORBITS", orbits), ("HAS_BUMP", bump), ("HAS_PICTURES", pictures)];
    for (name, value) in flags {
        writeln!(code, "const {name} = {value};").expect("writing to a string");
    }
    if !paint {
        code += UNPAINTED;
        return code
            + match prepared.mode {
                Mode::Path | Mode::Variance => UNPAINTED_NUMBERS,
                Mode::Preview => "fn changed_look(look: Look) -> Look {\n    return look;\n}\n",
                _ => "const painted_colour = vec4f(0.0);\n",
            };
    }
    for (name, value) in [
        ("PAINT_TABLE", prepared.paint_table as u32),
        ("LEAF_COUNT", prepared.leaves.len() as u32),
        ("KNOTS", paint::KNOTS as u32),
        ("ORBIT_SOURCE", paint::ORBIT),
        ("PICTURE_SOURCE", paint::PICTURE),
        ("OWN_COLOURS_LAYER", paint::OWN_COLOURS),
        ("PACKED_LAYER", paint::PACKED),
    ] {
        writeln!(code, "const {name} = {value}u;").expect("writing to a string");
    }
    code.push('\n');
    code += &Program::coordinates(&prepared.field);
    code += &match orbits {
        true => Program::orbits(&prepared.field),
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
    code += &transport::paint(prepared.mode).join("\n");
    if prepared.mode.traces_paths() {
        code += TINT;
    }
    code
}

/// The functions of the materials in use, and the choice among them.
fn scattering(prepared: &Prepared) -> String {
    let kinds = materials::kinds();
    let used: BTreeSet<u32> = prepared.materials.iter().map(|material| material.kind).collect();
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
