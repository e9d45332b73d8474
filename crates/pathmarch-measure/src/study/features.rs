//! Features of the thesis's program, Cycles and pathmarch: Table 5.8 of the thesis and beyond, for this version.

use super::Study;
use super::table::Table;
use pathmarch_cli::Failure;

/// The eight rows of Table 5.8: feature; the thesis's program and Cycles as published; pathmarch.
static TABLE_5_8: [[&str; 4]; 8] = [
    ["High fidelity graphics", "yes", "yes", "yes: unbiased, checked against Mitsuba and Cycles"],
    ["Real-time rendering (over 24 fps)", "yes", "no", "by resolution and machine: see [real time](#real-time)"],
    ["Path tracing denoising", "yes", "yes", "yes: in motion, at rest, and of final frames"],
    ["Solid geometry", "yes", "yes", "yes"],
    ["Distance field based geometry", "yes", "no", "yes"],
    ["Textures", "no", "yes", "yes"],
    ["Physics based materials", "no", "yes", "yes"],
    ["Caustics", "yes (simplified)", "yes", "traced, without those of lights without size; or simplified"],
];

/// Further features: the thesis's published program; Cycles 4.5; pathmarch.
static BEYOND: &[[&str; 4]] = &[
    [
        "union, difference, intersection",
        "yes",
        "of meshes, before rendering",
        "yes, also with soft, round, chamfered and stepped seams",
    ],
    ["repetition without end", "yes", "instances, finite", "yes; also polar and mirrored"],
    ["fractals", "yes", "no", "eight, coloured by their orbits"],
    ["custom shapes", "in the shader's source", "no", "in the scene, as WGSL, checked"],
    ["meshes", "no", "yes", "yes: as triangles, and as distance fields"],
    ["next-event estimation", "yes", "yes", "yes, with multiple importance sampling"],
    ["light after the first hit", "lost (below)", "yes", "yes"],
    ["lights with a size", "by chance", "yes", "yes, sampled"],
    ["soft shadows", "no: lights are points", "yes", "yes, of lights with a size; also by near misses"],
    ["sky", "one colour", "colour, picture, computed day", "colour, gradient, picture, computed day"],
    ["thin lens, motion blur", "no", "yes", "yes"],
    ["accumulation", "8 bits, fixed blend (below)", "32-bit float", "32-bit float"],
    ["low-discrepancy samples", "no", "yes", "yes, the error is blue noise"],
    ["reuse of samples when the camera moves", "no", "no", "yes"],
    ["light chosen by place, path guiding", "no", "yes", "no"],
    ["fog, subsurface scattering", "no", "yes", "no"],
    ["a surface that emits and reflects", "yes", "yes", "yes"],
    ["scenes as files", "no: the shader's source", "yes", "yes, text, with an error message for every mistake"],
    ["live view", "yes", "yes", "yes, with editing"],
    ["without a GPU", "software OpenGL", "yes", "yes"],
];

fn table(rows: &[[&str; 4]]) -> Table {
    let mut table = Table::new(["", "thesis's program", "Cycles", "pathmarch"]);
    for row in rows {
        table.push(*row);
    }
    table
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let (of_thesis, beyond) = (table(&TABLE_5_8), table(BEYOND));
    of_thesis.save(study.directory, "features")?;
    beyond.save(study.directory, "features-beyond")?;
    Ok(format!(
        "## Features\n\nTable 5.8 (page 71), with a column for pathmarch {}.\n\n{}\nBeyond it; the first column is the published \
         program. Cycles leads in fog, subsurface scattering, path guiding and light choice.\n\n{}\n\
         Measured in the thesis's program: a white furnace gives 0.634 instead of 1, a black sphere under a white sky 0.5 \
         instead of 0, a perfect mirror 0.7; light after the first hit is lost to a division of integers; accumulation in 8 \
         bits with a fixed blend stops improving at about 39 samples; rays that miss always cost all 128 steps and can end \
         as NaN; the mandelbulb vanishes when seen from 10 units away, because its distance estimate overshoots; glass never \
         lets light out by refraction. [light.md](https://github.com/pathmarch/pathmarch/blob/main/docs/light.md) describes how \
         pathmarch's light is tested.\n",
        env!("CARGO_PKG_VERSION"),
        of_thesis.markdown(),
        beyond.markdown()
    ))
}
