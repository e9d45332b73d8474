//! The whole kernel of a scene as text: the fixed parts, the scene's field, its materials, and what it needs of the
//! estimator as constants, so that a scene pays for nothing that it does not use.

use crate::frame::{Features, Prepared};
use crate::transport;
use pathmarch_field::wgsl::{MAX_UNIFORM_VECTORS, Program};
use pathmarch_scene::materials::{self, albedo};
use std::collections::BTreeSet;
use std::fmt::Write;

/// The kernel, in WGSL.
pub(crate) fn kernel(prepared: &Prepared, program: &Program) -> String {
    let count = program.parameters.len();
    let space = if count <= MAX_UNIFORM_VECTORS { "uniform" } else { "storage, read" };
    let mut code =
        format!("@group(0) @binding(2) var<{space}> field_parameters: array<vec4f, {count}>;\n\n{}", program.code);
    if prepared.features.penumbra {
        code.push('\n');
        code.push_str(&program.whole_distance);
    }
    code += &constants(prepared);
    code += &scattering(prepared);
    for part in transport::KERNEL {
        code.push('\n');
        code.push_str(part);
    }
    code
}

fn constants(prepared: &Prepared) -> String {
    let Features { absorption, transmission, chooses_lobes, fast_caustics, penumbra, light_search } = prepared.features;
    let (search, sampler) = (light_search as u32, prepared.frame.sampler);
    let near_misses = if penumbra {
        transport::PENUMBRA
    } else {
        "fn near_misses(ray: Ray, limit: f32, sharpness: f32) -> f32 {\n    return 1.0;\n}\n"
    };
    let (sky, sky_table, ggx_table) = (prepared.sky.form(), prepared.sky_table, prepared.ggx_table);
    let (roughnesses, cosines) = (albedo::ROUGHNESSES, albedo::COSINES);
    format!(
        "\nconst ABSORPTION = {absorption};\nconst TRANSMISSION = {transmission};\nconst CHOOSES_LOBES = {chooses_lobes};\n\
         const FAST_CAUSTICS = {fast_caustics};\nconst PENUMBRA = {penumbra};\nconst LIGHT_SEARCH = {search}u;\nconst SAMPLER = {sampler}u;\nconst SKY = {sky}u;\n\
         const SKY_TABLE = {sky_table}u;\nconst GGX_TABLE = {ggx_table}u;\nconst GGX_ROUGHNESSES = {roughnesses}u;\n\
         const GGX_COSINES = {cosines}u;\n\n{near_misses}"
    )
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
