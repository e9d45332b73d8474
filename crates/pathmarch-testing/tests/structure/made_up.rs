//! Small trees with known imports, rings and diagrams.

use crate::modules::read_crates;
use crate::{diagram, imports, rings};
use std::fs;
use std::path::PathBuf;
use tempfile::TempDir;

/// A workspace in a folder of its own.
struct Tree {
    _folder: TempDir,
    root: PathBuf,
}

impl Tree {
    /// A workspace with these files; each crate has the name of its folder.
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let root = fs::canonicalize(folder.path()).expect("a path");
        for (file, text) in files {
            let path = root.join("crates").join(file);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
            let name = file.split('/').next().expect("a crate");
            let manifest = format!("[package]\nname = \"{name}\"\n");
            fs::write(root.join("crates").join(name).join("Cargo.toml"), manifest).expect("a manifest");
        }
        Self { _folder: folder, root }
    }

    /// A workspace with the crate `a`, whose `src` contains these files.
    fn of_crate(files: &[(&str, &str)]) -> Self {
        let files: Vec<_> = files.iter().map(|(file, text)| (format!("a/src/{file}"), *text)).collect();
        Self::new(&files.iter().map(|(file, text)| (file.as_str(), *text)).collect::<Vec<_>>())
    }

    /// Each import between files as `from > to: names`, without the folders around `src`.
    fn imports(&self) -> Vec<String> {
        let crates = read_crates(&self.root);
        let imports = imports::of_crates(&crates);
        let short = |file: &str| file.split_once("src/").expect("a source").1.to_owned();
        let files = imports.iter().flat_map(|imports| &imports.files);
        let names =
            files.map(|((from, to), names)| (short(from), short(to), names.iter().cloned().collect::<Vec<_>>()));
        names.map(|(from, to, names)| format!("{from} > {to}: {}", names.join(" "))).collect()
    }

    /// Texts of the rings.
    fn rings(&self) -> Vec<String> {
        let crates = read_crates(&self.root);
        imports::of_crates(&crates).iter().flat_map(rings::find).map(|ring| ring.to_string()).collect()
    }

    /// Result of a comparison with a document.
    fn compare(&self, document: &str) -> Result<(), String> {
        diagram::compare(document, &diagram::of_workspace(&imports::of_crates(&read_crates(&self.root))))
    }

    /// A document with the right diagram.
    fn drawn(&self) -> String {
        let document = format!("# Title\n\n{}\n{}\n\nMore.\n", diagram::START, diagram::END);
        diagram::replace(&document, &diagram::of_workspace(&imports::of_crates(&read_crates(&self.root))))
            .expect("markers")
    }
}

#[test]
fn a_ring_is_found_with_the_names_that_tie_it() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod x; mod y; mod z;"),
        ("x.rs", "use crate::y::{self, Y}; pub struct X; fn f() { y::g() }"),
        ("y.rs", "use super::z::Z as Other; pub struct Y; pub fn g() {}"),
        ("z.rs", "pub struct Z(crate::x::X);"),
    ]);
    let ring = "ring of 3 files in crates/a/src\n  x.rs takes from y.rs: Y, g\n  y.rs takes from z.rs: Z\n  \
                z.rs takes from x.rs: X\n";
    assert_eq!(tree.rings(), [ring]);
}

#[test]
fn a_module_and_its_descendants_may_use_each_other() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod m; pub struct Error; use m::M;"),
        ("m/mod.rs", "mod x; mod y; pub use x::X; pub struct M; pub struct N;"),
        ("m/x/mod.rs", "mod deep; use super::{M, y::Y}; pub struct X; use deep::D;"),
        ("m/x/deep.rs", "use super::X; use crate::m::N; pub struct D;"),
        ("m/y.rs", "use super::N; pub struct Y(crate::Error);"),
    ]);
    assert!(tree.imports().len() >= 9, "{:?}", tree.imports());
    assert!(tree.rings().is_empty(), "{:?}", tree.rings());
}

#[test]
fn siblings_form_a_ring_below_their_module() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod m;"),
        ("m.rs", "mod x; mod y; pub struct M; use x::X;"),
        ("m/x.rs", "use super::{M, y::Y}; pub struct X;"),
        ("m/y.rs", "use super::{M, x::X}; pub struct Y;"),
    ]);
    let rings = tree.rings();
    assert_eq!(rings.len(), 1);
    assert!(rings[0].starts_with("ring of 2 files") && !rings[0].contains("m.rs"), "{}", rings[0]);
}

#[test]
fn files_that_only_their_module_ties_are_named_last() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod list; mod m;"),
        ("list.rs", "use crate::m::M; pub struct List;"),
        ("m.rs", "mod x; use crate::list::List; use x::X; pub struct M;"),
        ("m/x.rs", "use crate::list::List; pub struct X;"),
    ]);
    let ring = "ring of 3 files in crates/a/src\n  list.rs takes from m.rs: M\n  m.rs takes from list.rs: List\n  \
                also tied: m/x.rs\n";
    assert_eq!(tree.rings(), [ring]);
}

#[test]
fn a_ring_that_leaves_a_module_counts() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod m; mod other;"),
        ("m.rs", "mod x; use crate::other::O; pub struct M;"),
        ("m/x.rs", "use super::M; pub struct X;"),
        ("other.rs", "use crate::m::x::X; pub struct O;"),
    ]);
    assert!(tree.rings()[0].starts_with("ring of 3 files"), "{:?}", tree.rings());
}

#[test]
fn a_reexport_is_followed_to_the_definition() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod gpu; mod film; mod same; mod user; pub use film::Film;"),
        ("gpu/mod.rs", "mod device; mod job; pub use self::device::{Device as Adapter, *}; pub use job::job;"),
        ("gpu/device.rs", "use crate::Film; pub struct Device; pub fn open() {} pub const LIMIT: u32 = 1;"),
        ("gpu/job.rs", "pub fn job() {}"),
        (
            "same.rs",
            "use crate::user::{self as module}; use crate::user::film::{self, f}; fn g() { module::h(); film::f() }",
        ),
        ("film.rs", "use crate::gpu; pub struct Film; fn f(a: gpu::Adapter) { gpu::open() }"),
        ("user.rs", "use crate::gpu::*; pub mod film; pub fn film() {} pub fn h() { job(); LIMIT }"),
        ("user/film.rs", "pub fn f() {}"),
    ]);
    let imports = tree.imports();
    for expected in [
        "film.rs > gpu/device.rs: Device open",
        "gpu/device.rs > film.rs: Film",
        "same.rs > user.rs: h",
        "same.rs > user/film.rs: f",
        "user.rs > gpu/device.rs: LIMIT",
        "user.rs > gpu/job.rs: job",
        "user.rs > gpu/mod.rs: *",
    ] {
        assert!(imports.contains(&expected.to_owned()), "{expected} is not in {imports:#?}");
    }
    assert!(!imports.iter().any(|import| import.starts_with("film.rs > gpu/mod.rs")), "{imports:#?}");
    assert!(tree.rings()[0].starts_with("ring of 2 files"), "{:?}", tree.rings());
}

#[test]
fn names_of_other_crates_belong_to_the_file_that_passes_them_on() {
    let tree = Tree::new(&[
        ("a/src/lib.rs", "mod x; mod y; pub use b_c;"),
        ("a/src/x.rs", "pub use b_c::B; pub use std::fmt::Debug;"),
        ("a/src/y.rs", "use crate::x::{B, Debug};"),
        ("b-c/src/lib.rs", "pub struct B;"),
    ]);
    assert_eq!(tree.imports(), ["y.rs > x.rs: B Debug"]);
    assert!(tree.drawn().contains("    a --> b_c\n"), "{}", tree.drawn());
}

#[test]
fn written_paths_count_wherever_they_are() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod x; mod y; mod z;"),
        (
            "x.rs",
            "use crate::z;
             #[derive(Debug)] #[arg(value_parser = crate::y::attribute)] struct S(Vec<crate::y::Inner>);
             impl crate::y::Trait for S {}
             fn f(s: &dyn super::y::Param) {
                 use crate::y as local;
                 let local::Pattern { .. } = crate::y::call(local::generic::<S>());
                 println!(\"{}\", [crate::y::nested(), z::in_macro()]);
                 <S as crate::y::Qualified>::f();
             }
             macro_rules! m { ($n:ident) => { $crate::y::from_macro($n::no, super::y::Other) } }
             pub(in crate::y) fn visibility() {}",
        ),
        ("y.rs", ""),
        ("z.rs", ""),
    ]);
    let expected = "x.rs > y.rs: Inner Other Param Pattern Qualified Trait attribute call from_macro generic nested";
    assert_eq!(tree.imports(), [expected, "x.rs > z.rs: in_macro"]);
}

#[test]
fn code_for_tests_and_documentation_does_not_count() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "mod x; mod y; #[cfg(test)] mod tests;"),
        ("tests.rs", "mod deep; use crate::x::X;"),
        ("tests/deep.rs", "use crate::x::X;"),
        (
            "x.rs",
            "//! Uses [`crate::y::Y`].
             #[cfg(doc)] use crate::y::A;
             #[cfg(all(unix, test))] use crate::y::B;
             #[cfg(any(test, doc))] use crate::y::C;
             #[cfg(any(test, unix))] use crate::y::D;
             #[cfg(not(test))] use crate::y::E;
             #[cfg(test)] mod tests { mod inner; use crate::y::F; }
             struct S { #[cfg(test)] f: crate::y::G }
             impl S { #[cfg(test)] fn f() { crate::y::h() } }
             #[test] fn t() { crate::y::i() }",
        ),
        ("x/tests/inner.rs", "use crate::y::J;"),
        ("y.rs", ""),
    ]);
    assert_eq!(tree.imports(), ["x.rs > y.rs: D E"]);
}

#[test]
fn modules_are_found_by_attributes_and_macros() {
    let tree = Tree::of_crate(&[
        ("lib.rs", "#[path = \"odd/place.rs\"] mod x; mod y; #[cfg_attr(unix, path = \"z_unix.rs\")] mod z;"),
        ("odd/place.rs", "mod child; #[path = \"../elsewhere.rs\"] mod far; pub struct X;"),
        ("odd/child.rs", "use super::X; use super::super::y::sphere::S;"),
        ("elsewhere.rs", "use crate::x::X;"),
        ("y/mod.rs", "macro_rules! m { ($($n:ident),*) => { $(mod $n;)* } } m!(r#box, sphere, folder: cone);"),
        ("y/box.rs", "use crate::x::X;"),
        ("y/sphere.rs", "mod part;"),
        ("y/sphere/part.rs", "use crate::x::X;"),
        ("y/folder/cone.rs", "use super::super::sphere::S;"),
        ("z.rs", "use crate::x::X;"),
        ("z_unix.rs", "use crate::x::X;"),
    ]);
    let expected = [
        "elsewhere.rs > odd/place.rs: X",
        "odd/child.rs > odd/place.rs: X",
        "odd/child.rs > y/sphere.rs: S",
        "y/box.rs > odd/place.rs: X",
        "y/folder/cone.rs > y/sphere.rs: S",
        "y/mod.rs > y/box.rs: box",
        "y/mod.rs > y/folder/cone.rs: cone",
        "y/mod.rs > y/sphere.rs: sphere",
        "y/sphere/part.rs > odd/place.rs: X",
        "z.rs > odd/place.rs: X",
        "z_unix.rs > odd/place.rs: X",
    ];
    assert_eq!(tree.imports(), expected);
}

#[test]
#[should_panic(expected = "files that no module declares")]
fn a_file_without_a_module_is_reported() {
    Tree::of_crate(&[("lib.rs", "mod x;"), ("x.rs", ""), ("lost.rs", "")]).imports();
}

/// A workspace for diagrams; `film.rs` has this text.
fn drawn_tree(film: &str) -> Tree {
    Tree::new(&[
        ("pathmarch-field/src/lib.rs", "pub struct Field;"),
        ("pathmarch-render/src/lib.rs", "mod film; mod gpu; mod live; pub use live::Live;"),
        ("pathmarch-render/src/film.rs", film),
        ("pathmarch-render/src/gpu.rs", "mod device; pub struct Gpu(crate::film::Film);"),
        ("pathmarch-render/src/gpu/device.rs", ""),
        ("pathmarch-render/src/live.rs", "use crate::{film::Film, gpu::Gpu}; pub struct Live;"),
        ("pathmarch/src/main.rs", "use pathmarch_render::Live; use pathmarch_field::Field;"),
    ])
}

const FILM: &str = "use pathmarch_field::Field; pub struct Film;";

#[test]
fn a_diagram_shows_parts_and_arrows_but_implied_ones() {
    let expected = "# Title

<!-- rooms -->
The crates. An arrow leads to what one needs; arrows that follow from others are left out.

```mermaid
flowchart TD
    pathmarch[\"pathmarch\"]
    pathmarch_field[\"pathmarch-field\"]
    pathmarch_render[\"pathmarch-render\"]
    pathmarch --> pathmarch_render
    pathmarch_render --> pathmarch_field
```

The modules of `pathmarch-render`. An arrow leads to what one needs; arrows that follow from others are left out.

```mermaid
flowchart TD
    pathmarch_render_film[\"film.rs\"]
    pathmarch_render_gpu[\"gpu/\"]
    pathmarch_render_live[\"live.rs\"]
    pathmarch_render_gpu --> pathmarch_render_film
    pathmarch_render_live --> pathmarch_render_gpu
```

<!-- /rooms -->

More.
";
    let tree = drawn_tree(FILM);
    assert_eq!(tree.drawn(), expected);
    assert_eq!(tree.compare(expected), Ok(()));
    let ring = drawn_tree("pub struct Film(crate::live::Live);").drawn();
    assert!(ring.contains("    pathmarch_render_live --> pathmarch_render_film\n"), "{ring}");
    assert!(ring.contains("all arrows are drawn, since some need each other."), "{ring}");
}

#[test]
fn a_wrong_diagram_fails_with_each_difference() {
    let tree = drawn_tree(FILM);
    let wrong = tree
        .drawn()
        .replace("    pathmarch_render_live --> pathmarch_render_gpu\n", "    pathmarch_render_film --> old\n")
        .replace("    pathmarch_field[\"pathmarch-field\"]\n", "    old[\"old.rs\"]\n");
    let mistakes = tree.compare(&wrong).expect_err("differences");
    let (list, block) = mistakes.split_once("\n\nIt must be\n\n").expect("the block");
    let expected = [
        "missing:  pathmarch_field[\"pathmarch-field\"]   (pathmarch-field)",
        "missing:  pathmarch_render_live --> pathmarch_render_gpu   (crates/pathmarch-render/src/live.rs takes from \
         crates/pathmarch-render/src/gpu.rs: Gpu)",
        "too much: old[\"old.rs\"]",
        "too much: pathmarch_render_film --> old",
    ];
    assert_eq!(list.lines().collect::<Vec<_>>(), expected);
    assert!(tree.drawn().contains(block));
    assert!(tree.compare("# Title").is_err_and(|mistakes| mistakes.contains("no line <!-- rooms -->")));
    let moved = tree.drawn().replace("The crates.", "Crates.");
    assert!(tree.compare(&moved).is_err_and(|mistakes| mistakes.starts_with("nodes and arrows are right")));
}
