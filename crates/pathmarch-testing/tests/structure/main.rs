//! The structure of the workspace, compared with its code.
//!
//! [`modules`] reads every source file, [`imports`] finds what each file takes from others. [`rings`] reports files that
//! import each other in a ring; [`diagram`] compares the diagram at the top of `ARCHITECTURE.md` with the imports.
//! `PATHMARCH_UPDATE_DIAGRAM=1` draws the diagram anew. [`made_up`] tests all of it on small trees.

mod diagram;
mod imports;
mod made_up;
mod modules;
mod names;
mod rings;
mod syntax;

use std::fs;
use std::path::PathBuf;

/// Environment variable that makes [`diagram_shows_the_imports`] write the diagram.
const UPDATE: &str = "PATHMARCH_UPDATE_DIAGRAM";

/// Root of the workspace.
fn workspace() -> PathBuf {
    fs::canonicalize(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).expect("the workspace")
}

#[test]
fn files_form_no_rings() {
    let crates = modules::read_crates(&workspace());
    let rings: Vec<_> = imports::of_crates(&crates).iter().flat_map(rings::find).collect();
    let texts: Vec<_> = rings.iter().map(ToString::to_string).collect();
    assert!(rings.is_empty(), "{} rings of files that import each other\n\n{}", rings.len(), texts.join("\n"));
}

#[test]
fn diagram_shows_the_imports() {
    let path = workspace().join("ARCHITECTURE.md");
    let text = fs::read_to_string(&path).expect("ARCHITECTURE.md");
    let diagrams = diagram::of_workspace(&imports::of_crates(&modules::read_crates(&workspace())));
    if std::env::var_os(UPDATE).is_some() {
        let updated = diagram::replace(&text, &diagrams).unwrap_or_else(|mistake| panic!("{mistake}"));
        fs::write(&path, updated).expect("ARCHITECTURE.md is writable");
    } else if let Err(mistakes) = diagram::compare(&text, &diagrams) {
        panic!("ARCHITECTURE.md differs from the imports; {UPDATE}=1 updates it.\n{mistakes}");
    }
}
