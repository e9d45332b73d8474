//! All tests of pictures in one program, so that they share opened devices and are linked once.

mod adaptive;
mod aov;
mod backends;
mod blends;
mod caustics;
mod common;
mod custom_sdf;
mod denoise;
mod dispersion;
mod emitter_edges;
mod examples;
mod glass;
mod images;
mod light;
mod light_samples;
mod live;
mod long_paths;
mod many_lights;
mod media;
mod mesh_file;
mod mesh_materials;
mod meshes;
mod missing_gpu;
mod modes;
mod motion;
mod optimisations;
mod path_reuse;
mod reconstruct;
mod references;
mod sampling;
mod shape_grids;
mod splitting;
mod textures;

use std::path::Path;

fn main() {
    let tests = [
        adaptive::tests(),
        aov::tests(),
        backends::tests(),
        blends::tests(),
        caustics::tests(),
        dispersion::tests(),
        emitter_edges::tests(),
        examples::tests(),
        glass::tests(),
        images::tests(),
        light::tests(),
        light_samples::tests(),
        live::tests(),
        many_lights::tests(),
        long_paths::tests(),
        shape_grids::tests(),
        media::tests(),
        mesh_file::tests(),
        mesh_materials::tests(),
        meshes::tests(),
        missing_gpu::tests(),
        modes::tests(),
        motion::tests(),
        optimisations::tests(),
        path_reuse::tests(),
        custom_sdf::tests(),
        denoise::tests(),
        reconstruct::tests(),
        references::tests(),
        sampling::tests(),
        splitting::tests(),
        textures::tests(),
    ];
    pathmarch_testing::run(
        &[Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")],
        tests.into_iter().flatten().collect(),
    );
}
