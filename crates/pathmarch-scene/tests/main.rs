//! All tests of scenes in one program, which is compiled and linked once.

mod declared;
mod document;
mod extremes;
mod flux;
mod formulas;
mod glass;
mod include;
mod language_service;
mod materials;
mod media;
mod meshes;
mod mistakes;
mod parsed;
mod random;
mod reference_page;
mod robust;
mod sky;
mod textures;
mod valid;

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
