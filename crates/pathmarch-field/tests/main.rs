//! All tests of fields in one program, which is compiled and linked once.

mod custom_sdf;
#[path = "sampling/fields.rs"]
mod fields;
mod fractals;
mod glsl;
mod graph;
mod lamps;
mod lipschitz_check;
mod mesh;
mod mesh_shape;
mod modifiers;
mod number;
mod operators;
mod outline;
mod rays;
mod registry;
mod sampling;
mod shape_grid;
mod wgsl;

/// A file that is missing above would not be compiled.
#[test]
fn every_file_is_listed() {
    let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    for entry in std::fs::read_dir(directory).expect("a directory") {
        let path = entry.expect("a file").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str()).expect("a name");
        let is_code = path.extension().is_some_and(|extension| extension == "rs") && stem != "main";
        assert!(!is_code || include_str!("main.rs").contains(&format!("mod {stem};")), "{stem} is not in main.rs");
    }
}
