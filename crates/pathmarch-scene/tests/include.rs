//! Scenes that take things from other files.

use pathmarch_scene::document::{Document, ItemKind};
use pathmarch_scene::{Scene, SceneError};
use std::path::Path;

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 1\n";

/// A directory with these files.
fn files(all: &[(&str, &str)]) -> tempfile::TempDir {
    let directory = tempfile::tempdir().expect("a directory");
    for (name, text) in all {
        let path = directory.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("made");
        std::fs::write(path, text).expect("written");
    }
    directory
}

fn load(directory: &Path) -> Result<Scene, SceneError> {
    Scene::load(directory.join("scene.kdl"))
}

/// File, line and message of each mistake, and what to do.
fn mistakes(all: &[(&str, &str)]) -> Vec<String> {
    let directory = files(all);
    let error = load(directory.path()).expect_err("a mistake");
    let told = error.mistakes().iter().map(|mistake| {
        let source = &mistake.source_code;
        let line = 1 + source.inner()[..mistake.span.offset()].matches('\n').count();
        let name = Path::new(source.name()).strip_prefix(directory.path()).expect("in the directory").display();
        let help = mistake.help.as_deref().unwrap_or_default().replace(&directory.path().display().to_string(), "");
        format!("{name}:{line}: {} {help}", mistake.message)
    });
    told.collect()
}

#[test]
fn what_another_file_holds_is_taken() {
    let parts = "pathmarch 1
include \"deep.kdl\"
param size 2
camera \"theirs\" { position 0 9 0; target 0 0 0; up 0 0 1 }
render { samples 3 }
sky 5
material \"steel\" { metal 0.6 }
sun { direction 0 1 0; irradiance 1 }
shape \"pin\" { param length 1; cylinder 0.1 \"length*size\"; dot }
object \"floor\" { plane }";
    let deep = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nshape \"dot\" { sphere 0.1 }\n";
    let scene = format!(
        "{HEAD}include \"lib/parts.kdl\"\ninclude \"lib/deep.kdl\"\nparam twice \"2*size\"\n\
         object \"o\" material=\"steel\" {{ pin length=twice; box }}\n"
    );
    let directory = files(&[("scene.kdl", &scene), ("lib/parts.kdl", parts), ("lib/deep.kdl", deep)]);
    let read = load(directory.path()).expect("a scene");
    assert_eq!((read.cameras.len(), read.render.samples, read.lights.len()), (1, 256, 1));
    let names: Vec<&str> = read.objects.iter().map(|object| object.name.as_str()).collect();
    assert_eq!(names, ["o", "floor"]);
    let params: Vec<Vec<f32>> = read.field.leaves().iter().map(|leaf| leaf.params.clone()).collect();
    assert_eq!(params, [vec![0.1, 8.0], vec![0.1], vec![1.0; 3], vec![]]);
    let found: Vec<_> = read.includes.iter().filter_map(|path| path.file_name()).collect();
    assert_eq!(found, ["parts.kdl", "deep.kdl"]);
    // Its own nodes are edited, with what they use of others.
    let document = Document::new(directory.path().join("scene.kdl").display().to_string(), scene);
    let object = document.path_of_object(0).expect("its object");
    let pin = document.path_of_leaf(1).expect("the dot of the pin");
    assert_eq!(document.item(&pin).map(|item| (item.kind, item.word.as_str())), Some((ItemKind::Instance, "pin")));
    assert_eq!(document.path_of_leaf(3), None);
    assert!(document.control(&pin, "length").is_some() && pin.is_within(&object));
    assert!(document.additions(Some(&object)).iter().any(|addition| addition.name == "dot"));
}

#[test]
fn mistakes_are_told_in_their_file() {
    let scene = format!("{HEAD}include \"a.kdl\"\nmaterial \"steel\" {{ metal 2 }}\nobject \"o\" {{ ball }}\n");
    let a = "pathmarch 1\n\nmaterial \"steel\" { metal 0.6 }\nshape \"ball\" { sphre 1 }\nobject \"p\" { sphere 1 2 }\nobjekt 1\nobject {{\n";
    assert_eq!(
        mistakes(&[("scene.kdl", &scene), ("a.kdl", a)]),
        [
            "scene.kdl:5: `metal` must be from 0 to 1. ",
            "a.kdl:3: The material `steel` is given twice. In /scene.kdl, line 5: first here.",
            "a.kdl:4: There is no `sphre` in a declared shape. Did you mean `sphere`?",
            "a.kdl:5: `sphere` has one argument too many. Expected `sphere radius`.",
            "a.kdl:6: There is no `objekt` at the top of a scene. Did you mean `object`?",
            "a.kdl:7: `object` has too few arguments. ",
            "a.kdl:7: This { is never closed. ",
            "a.kdl:7: Braces without a node. A brace opens on the same line as the node it belongs to.",
            "a.kdl:7: This { is never closed. ",
        ]
    );
}

#[test]
fn files_that_cannot_be_included_are_told() {
    let scene = format!(
        "{HEAD}include \"missing.kdl\"\ninclude\ninclude 3\ninclude \"new.kdl\"\ninclude \".\"\ninclude \"none.kdl\"\n"
    );
    let told = mistakes(&[("scene.kdl", &scene), ("new.kdl", "pathmarch 2\nfuture"), ("none.kdl", "sphere 1\n")]);
    assert_eq!(
        told,
        [
            "scene.kdl:4: `missing.kdl` cannot be included: there is no such file. Check the path.",
            "scene.kdl:5: `include` has too few arguments. ",
            "scene.kdl:6: The path of a file must be a string. ",
            "scene.kdl:8: `.` cannot be included: it is a directory. Name a .kdl file in it.",
            "new.kdl:1: This scene is written in version 2 of the language. Use a newer pathmarch.",
            "none.kdl:1: A scene starts with its version. Write `pathmarch 1` on the first line.",
            "none.kdl:1: `sphere` is not allowed at the top of a scene. Shapes and operators belong in an object: object \"name\" { sphere … }.",
        ]
    );
    let scene = format!("{HEAD}include \"a.kdl\"\n");
    let told = mistakes(&[
        ("scene.kdl", &scene),
        ("a.kdl", "pathmarch 1\ninclude \"b.kdl\""),
        ("b.kdl", "pathmarch 1\ninclude \"a.kdl\"\ninclude \"scene.kdl\""),
    ]);
    let help = "Put what both need into a third file.";
    assert_eq!(
        told,
        [
            format!("b.kdl:2: `a.kdl` would include itself. {help}"),
            format!("b.kdl:3: `scene.kdl` would include itself. {help}"),
        ]
    );
    // A chain of files is followed for some time only, and all of them together are as bounded as one.
    let chain: Vec<(String, String)> =
        (0..20).map(|k| (format!("{k}.kdl"), format!("pathmarch 1\ninclude \"{}.kdl\"\n", k + 1))).collect();
    let mut all: Vec<(&str, &str)> = chain.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let scene = format!("{HEAD}include \"0.kdl\"\n");
    all.push(("scene.kdl", &scene));
    let told = mistakes(&all);
    assert!(told.len() == 1 && told[0].starts_with("15.kdl:2: Files are included more than 16 deep"), "{told:?}");
    let large = format!("pathmarch 1\n// {}\n", "x".repeat(9 << 20));
    let scene = format!("{HEAD}include \"a.kdl\"\ninclude \"b.kdl\"\n");
    let told = mistakes(&[("scene.kdl", &scene), ("a.kdl", &large), ("b.kdl", &large)]);
    assert_eq!(told, ["scene.kdl:5: The scene and what it includes are larger than 16 MiB. Leave parts of it out."]);
}
