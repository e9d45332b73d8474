//! Features of the thesis's program, Cycles and pathmarch: Table 5.8 of the thesis, for this version.

use super::Study;
use super::table::Table;
use pathmarch_cli::Failure;

/// Columns: feature; the thesis's published program; Cycles 3.4 to 4.5 in Blender; pathmarch.
static ROWS: &[[&str; 4]] = &[
    ["solids by distance functions", "yes", "no: meshes", "sixteen, and profiles to extrude and revolve"],
    [
        "union, difference, intersection",
        "yes",
        "of meshes, before rendering",
        "yes, also with soft, round, chamfered and stepped seams",
    ],
    ["repetition without end", "yes", "instances, finite", "yes; also polar and mirrored"],
    ["fractals", "yes", "no", "eight, coloured by their orbits"],
    ["custom shapes", "in the shader's source", "no", "in the scene, as WGSL, checked"],
    ["meshes", "no", "yes", "written (STL, PLY, OBJ, glTF), not rendered"],
    ["diffuse, specular, refractive, emissive", "yes, not conserving energy (below)", "yes", "yes"],
    ["physically based materials", "no", "yes", "metal, glass and principled, by microfacets"],
    ["textures", "no", "yes", "yes: computed ones, pictures and bumps"],
    ["next-event estimation", "yes", "yes", "yes, with multiple importance sampling"],
    ["light after the first hit", "lost (below)", "yes", "yes"],
    ["lights with a size", "by chance", "yes", "yes, sampled"],
    ["soft shadows", "no: lights are points", "yes", "yes, of lights with a size; also by near misses"],
    ["caustics", "simplified", "traced", "traced, or simplified"],
    ["sky", "one colour", "colour, picture, computed day", "colour, gradient, picture, computed day"],
    ["thin lens, motion blur", "no", "yes", "yes"],
    ["accumulation", "8 bits, fixed blend (below)", "32-bit float", "32-bit float"],
    ["low-discrepancy samples", "no", "yes", "yes, the error is blue noise"],
    ["denoising", "no", "yes", "no"],
    ["reuse of samples when the camera moves", "no", "no", "no"],
    ["fog, subsurface scattering", "no", "yes", "no"],
    ["scenes as files", "no: the shader's source", "yes", "yes, text, with an error message for every mistake"],
    ["live view", "yes", "yes", "yes, with editing"],
    ["without a GPU", "software OpenGL", "yes", "yes"],
];

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let mut table = Table::new(["", "thesis's program", "Cycles", "pathmarch"]);
    for row in ROWS {
        table.push(*row);
    }
    table.save(study.directory, "features")?;
    Ok(format!(
        "## Features\n\nTable 5.8, as of pathmarch {}. The column of the thesis is its published program.\n\n{}\n\
         Measured in the thesis's program: a white furnace gives 0.634 instead of 1, a black sphere under a white sky 0.5 \
         instead of 0, a perfect mirror 0.7; light after the first hit is lost to a division of integers; accumulation in 8 \
         bits with a fixed blend stops improving at about 39 samples; rays that miss always cost all 128 steps and can end \
         as NaN; the mandelbulb vanishes when seen from 10 units away, because its distance estimate overshoots; glass never \
         lets light out by refraction. [light.md](https://github.com/pathmarch/pathmarch/blob/main/docs/light.md) describes how \
         pathmarch's light is tested.\n",
        env!("CARGO_PKG_VERSION"),
        table.markdown()
    ))
}
