//! One edit each: the text before and the text after.

use super::path;
use pathmarch_scene::document::{Addition, Document, EditError, Group, Path, Value, key};

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\n";

/// An edit of a text that stands below a camera, and the text it makes; taken back and done again on the way.
#[track_caller]
fn edited<T>(before: &str, edit: impl FnOnce(&mut Document) -> Result<T, EditError>) -> String {
    let text = format!("{HEAD}{before}");
    let mut document = Document::new("test.kdl", text.as_str());
    document.scene().unwrap_or_else(|error| panic!("{:?} in\n{text}", error.mistakes()[0].message));
    edit(&mut document).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let after = document.text().to_owned();
    if after != text {
        assert_eq!(document.undo().as_deref(), document.can_redo());
        assert_eq!(document.text(), text);
        document.redo();
    }
    assert_eq!(document.text(), after);
    after.strip_prefix(HEAD).map_or(after.clone(), str::to_owned)
}

/// That an edit is refused, and why.
#[track_caller]
fn refused<T: std::fmt::Debug>(before: &str, edit: impl FnOnce(&mut Document) -> Result<T, EditError>) -> String {
    let text = format!("{HEAD}{before}");
    let mut document = Document::new("test.kdl", text.as_str());
    let error = edit(&mut document).expect_err("refused");
    assert_eq!((document.text(), document.can_undo(), document.revision()), (&*text, None, 0));
    error.to_string()
}

#[track_caller]
fn set(before: &str, title: &str, key: &str, value: Value, after: &str) {
    assert_eq!(edited(before, |document| document.set(&path(document, title), key, value, None)), after, "of {before}");
}
#[track_caller]
fn reset(before: &str, title: &str, key: &str, after: &str) {
    assert_eq!(edited(before, |document| document.reset(&path(document, title), key)), after, "of {before}");
}

fn number(value: f32) -> Value {
    Value::Number(value)
}
fn text(value: &str) -> Value {
    Value::Text(value.to_owned())
}
fn addition(group: Group, name: &str, document: &Document, parent: Option<&Path>) -> Addition {
    let all = document.additions(parent);
    all.iter().find(|addition| addition.group == group && addition.name == name).expect("may be added").clone()
}

#[test]
fn numbers_keep_their_style() {
    set("object \"a\" { sphere 1 }", "sphere", "radius", number(0.25), "object \"a\" { sphere 0.25 }");
    set("object \"a\" { sphere radius=1.50 }", "sphere", "radius", number(2.0), "object \"a\" { sphere radius=2 }");
    set("object \"a\" { sphere }", "sphere", "radius", number(2.0), "object \"a\" { sphere 2 }");
    set(
        "object \"a\" { sphere{ at 0 1 0 } }",
        "sphere",
        "radius",
        number(2.0),
        "object \"a\" { sphere 2{ at 0 1 0 } }",
    );
    set("object \"a\" { sphere 1.0 }", "sphere", "radius", number(1.0), "object \"a\" { sphere 1.0 }");
    set("object \"a\" { torus }", "torus", "minor", number(0.1), "object \"a\" { torus minor=0.1 }");
    set("object \"a\" { torus 1 }", "torus", "minor", number(0.1), "object \"a\" { torus 1 0.1 }");
    set("object \"a\" { torus minor=0.1 }", "torus", "major", number(2.0), "object \"a\" { torus 2 minor=0.1 }");
    set(
        "object \"a\" { torus /-3 1 /* b */ }",
        "torus",
        "minor",
        number(0.1),
        "object \"a\" { torus /-3 1 0.1 /* b */ }",
    );
    set(
        "object \"a\" { sphere \\ // c\n  1 \\\n }",
        "sphere",
        "radius",
        number(2.0),
        "object \"a\" { sphere \\ // c\n  2 \\\n }",
    );
}

#[test]
fn one_size_stands_for_several() {
    set("object \"a\" { box 2 }", "box", "y", number(1.0), "object \"a\" { box 2 1 2 }");
    set("object \"a\" { box 2.0 }", "box", "x", number(1.0), "object \"a\" { box 1 2.0 2.0 }");
    set("object \"a\" { box }", "box", "x", number(3.0), "object \"a\" { box x=3 }");
    set("object \"a\" { box y=2 }", "box", "x", number(3.0), "object \"a\" { box 3 y=2 }");
    set("object \"a\" { rounded-box 2 }", "rounded-box", "radius", number(0.2), "object \"a\" { rounded-box 2 0.2 }");
    set(
        "object \"a\" { rounded-box 2 0.1 }",
        "rounded-box",
        "z",
        number(3.0),
        "object \"a\" { rounded-box 2 2 3 0.1 }",
    );
    reset("object \"a\" { box 2 }", "box", "x", "object \"a\" { box 1 2 2 }");
    reset("object \"a\" { box 2 3 4 }", "box", "z", "object \"a\" { box 2 3 1 }");
    reset("object \"a\" { rounded-box 2 0.2 }", "rounded-box", "radius", "object \"a\" { rounded-box 2 }");
    reset(
        "object \"a\" { sphere 2 material=\"m\" }\nmaterial \"m\" { emit 1 }",
        "sphere",
        "radius",
        "object \"a\" { sphere material=\"m\" }\nmaterial \"m\" { emit 1 }",
    );
    reset("object \"a\" { torus minor=0.1 }", "torus", "minor", "object \"a\" { torus }");
}

#[test]
fn triples_change_one_by_one() {
    let at = |x, y, z| Value::Triple([x, y, z]);
    set(
        "object \"a\" { sphere { at 0 1.0 0 } }",
        "sphere",
        key::AT,
        at(0.0, 1.0, -2.5),
        "object \"a\" { sphere { at 0 1.0 -2.5 } }",
    );
    set("object \"a\" { sphere }", "sphere", key::AT, at(1.0, 0.0, 0.0), "object \"a\" { sphere { at 1 0 0 } }");
    set("object \"a\" { sphere {} }", "sphere", key::AT, at(1.0, 0.0, 0.0), "object \"a\" { sphere { at 1 0 0 } }");
    set(
        "object \"a\" { sphere { scale 2 } }",
        "sphere",
        key::AT,
        at(1.0, 0.0, 0.0),
        "object \"a\" { sphere { scale 2; at 1 0 0 } }",
    );
    set(
        "object \"a\" { sphere { scale 2; } }",
        "sphere",
        key::AT,
        at(1.0, 0.0, 0.0),
        "object \"a\" { sphere { scale 2; at 1 0 0; } }",
    );
    set(
        "object \"a\" { sphere 1; box }",
        "sphere",
        key::AT,
        at(1.0, 0.0, 0.0),
        "object \"a\" { sphere 1 { at 1 0 0 }; box }",
    );
    set(
        "object \"a\" {\n\tsphere 1 // b\n}\n",
        "sphere",
        key::AT,
        at(1.0, 0.0, 0.0),
        "object \"a\" {\n\tsphere 1 { at 1 0 0 } // b\n}\n",
    );
    set(
        "object \"a\" {\n  sphere {\n    scale 2 // c\n  }\n}",
        "sphere",
        key::ROTATE,
        at(1.0, 0.0, 0.0),
        "object \"a\" {\n  sphere {\n    scale 2 // c\n    rotate 1 0 0\n  }\n}",
    );
    set(
        "object \"a\" {\n  sphere {\n  }\n}",
        "sphere",
        key::SCALE,
        number(2.0),
        "object \"a\" {\n  sphere {\n    scale 2\n  }\n}",
    );
    set(
        "object \"a\" {\n  sphere {\n    // c\n  }\n}",
        "sphere",
        key::SCALE,
        number(2.0),
        "object \"a\" {\n  sphere {\n    scale 2\n    // c\n  }\n}",
    );
    set(
        "object \"a\" { sphere { scale 2 \\\n\n } }",
        "sphere",
        key::AT,
        at(1.0, 0.0, 0.0),
        "object \"a\" { sphere { scale 2 \\\n\n    at 1 0 0\n } }",
    );
    set("object \"a\" { plane }", "plane", key::NORMAL, at(1.0, 1.0, 0.0), "object \"a\" { plane { normal 1 1 0 } }");
    reset("object \"a\" { sphere 1 { at 0 1 0 } }", "sphere", key::AT, "object \"a\" { sphere 1 }");
    reset(
        "object \"a\" { sphere 1 { at 0 1 0; scale 2 } }",
        "sphere",
        key::AT,
        "object \"a\" { sphere 1 { scale 2 } }",
    );
    reset(
        "object \"a\" { sphere 1 { at 0 1 0; scale 2 } }",
        "sphere",
        key::SCALE,
        "object \"a\" { sphere 1 { at 0 1 0 } }",
    );
    reset("object \"a\" { sphere 1 { at 0 1 0 /* b */ } }", "sphere", key::AT, "object \"a\" { sphere 1 { /* b */ } }");
    reset(
        "object \"a\" {\n    sphere 1 {\n        at 0 1 0\n    }\n}",
        "sphere",
        key::AT,
        "object \"a\" {\n    sphere 1\n}",
    );
    reset(
        "object \"a\" {\n    sphere 1 {\n        at 0 1 0 // c\n        /-scale 2\n    }\n}",
        "sphere",
        key::AT,
        "object \"a\" {\n    sphere 1 {\n        /-scale 2\n    }\n}",
    );
}

#[test]
fn colours_keep_their_style() {
    let colour = |r, g, b| Value::Colour([r, g, b]);
    let material = |inside: &str| format!("material \"m\" {{ {inside} }}\nobject \"a\" material=\"m\" {{ sphere }}\n");
    let set = |before: &str, value, after: &str| set(&material(before), "m", "albedo", value, &material(after));
    set("diffuse 0.5", colour(0.25, 0.25, 0.25), "diffuse 0.25");
    set("diffuse 0.5", colour(0.5, 0.25, 0.5), "diffuse 0.5 0.25 0.5");
    set("diffuse 0.5 0.50 0.5", colour(0.5, 0.5, 0.25), "diffuse 0.5 0.50 0.25");
    set("diffuse", colour(0.5, 0.5, 0.5), "diffuse 0.5");
    set("diffuse \"#ff8000\"", colour(1.0, 0.0, 0.0), "diffuse \"#ff0000\"");
    set("diffuse \"#FF8000\"", colour(0.0, 1.0, 1.0), "diffuse \"#00FFFF\"");
    set("diffuse \"#fff\"", colour(0.0, 0.0, 0.0), "diffuse \"#000000\"");
    set("diffuse \"#ff8000\"", colour(0.3, 0.2, 0.1), "diffuse 0.3 0.2 0.1");
    reset(&material("diffuse 0.5 0.1 0.2"), "m", "albedo", &material("diffuse"));
    reset(&material("metal 1; roughness 0.5; edge 1"), "m", "roughness", &material("metal 1; edge 1"));
    super::edits::set(&material("metal 1"), "m", "roughness", number(0.5), &material("metal 1; roughness 0.5"));
    super::edits::set("sky 0.5\n", "sky", "colour", colour(1.0, 2.0, 3.0), "sky 1 2 3\n");
}

#[test]
fn settings_are_added_and_removed() {
    set("render", "render", "samples", number(16.0), "render { samples 16 }");
    set("render { samples 16 }", "render", "size", Value::Size([64, 48]), "render { samples 16; size 64 48 }");
    set("render { size 64 48 }", "render", "size", Value::Size([64, 32]), "render { size 64 32 }");
    set("render { tonemap srgb }", "render", "tonemap", text("agx"), "render { tonemap agx }");
    set("render { tonemap \"srgb\" }", "render", "tonemap", text("agx"), "render { tonemap \"agx\" }");
    set("render { clamp 3 }", "render", "clamp", Value::None, "render");
    reset("render {\n    samples 3\n\n    clamp 3\n}", "render", "clamp", "render {\n    samples 3\n}");
    set(
        "",
        "main",
        "lens.radius",
        number(0.1),
        "pathmarch 1\ncamera { position 0 1 5; target 0 1 0; lens radius=0.1 }\n",
    );
    let lens = "camera \"b\" { position 0 1 5; lens focus=2 radius=0.1; target 0 1 0 }";
    reset(lens, "b", "lens.focus", "camera \"b\" { position 0 1 5; lens radius=0.1; target 0 1 0 }");
    set(
        "camera \"b\" { position 0 1 5; lens focus=2; target 0 1 0 }",
        "b",
        "lens.focus",
        Value::None,
        "camera \"b\" { position 0 1 5; target 0 1 0 }",
    );
    set(
        "sun { direction 0.3 0.8 0.5   // towards\n      irradiance 3 2.9 2.7\n      angle 0.53 }",
        "sun",
        "penumbra",
        number(8.0),
        "sun { direction 0.3 0.8 0.5   // towards\n      irradiance 3 2.9 2.7\n      angle 0.53\n      penumbra 8 }",
    );
    set("sky \"day\" haze=2", "sky", "sun", Value::Flag(false), "sky \"day\" haze=2 sun=#false");
    set("sky \"day\" sun=#false", "sky", "ground", Value::Colour([0.5; 3]), "sky \"day\" sun=#false { ground 0.5 }");
    reset("sky \"day\" sun=#false haze=2", "sky", "sun", "sky \"day\" haze=2");
    set(
        "object \"a\" { union { sphere; box } }",
        "union",
        "smooth",
        number(0.1),
        "object \"a\" { union smooth=0.1 { sphere; box } }",
    );
}

#[test]
fn materials_are_given_and_taken() {
    let scene = |object: &str| format!("material \"m\" {{ emit 1 }}\nmaterial n {{ emit 1 }}\n{object}");
    let give = |before: &str, title: &str, material: Option<&str>, after: &str| {
        let edit = |document: &mut Document| document.set_material(&path(document, title), material);
        assert_eq!(edited(&scene(before), edit), scene(after));
    };
    give("object \"a\" { sphere }", "a", Some("m"), "object \"a\" material=\"m\" { sphere }");
    give("object \"a\" { sphere }", "sphere", Some("m"), "object \"a\" { sphere material=\"m\" }");
    give("object \"a\" { sphere material=\"m\" 1 }", "sphere", Some("n"), "object \"a\" { sphere material=\"n\" 1 }");
    give("object \"a\" material=n { sphere }", "a", Some("m"), "object \"a\" material=m { sphere }");
    give("object \"a\" material=\"m\" { sphere }", "a", None, "object \"a\" { sphere }");
    give("object \"a\" \\\n    material=\"m\" \\\n { sphere }", "a", None, "object \"a\" \\\n \\\n { sphere }");
    give("object \"a\" { sphere 1 \\\n    material=\"m\"\n}", "sphere", None, "object \"a\" { sphere 1\n}");
    let message = refused(&scene("object \"a\" { sphere }"), |d| d.set_material(&path(d, "a"), Some("gold")));
    assert_eq!(message, "`material` must be the name of a material, and there is none called gold.");
}

#[test]
fn names_change_with_what_refers_to_them() {
    let before = "material \"m\" { emit 1 } // lamp\nobject \"a\" material=\"m\" { union material=m { sphere; box material=\"m\" } }\n";
    let after = "material \"the \\\"lamp\\\"\" { emit 1 } // lamp\nobject \"a\" material=\"the \\\"lamp\\\"\" \
                 { union material=\"the \\\"lamp\\\"\" { sphere; box material=\"the \\\"lamp\\\"\" } }\n";
    assert_eq!(edited(before, |document| document.rename(&path(document, "m"), "the \"lamp\"")), after);
    set("object a { sphere }", "a", key::NAME, text("b"), "object b { sphere }");
    set("object #\"a\"# { sphere }", "a", key::NAME, text("b"), "object \"b\" { sphere }");
    set("object \"\"\"\n  a\n  \"\"\" { sphere }", "a", key::NAME, text("b"), "object \"b\" { sphere }");
    assert_eq!(
        edited("", |document| document.rename(&Path::top(1), "front")),
        "pathmarch 1\ncamera \"front\" { position 0 1 5; target 0 1 0 }\n"
    );
    assert_eq!(edited("", |document| document.rename(&Path::top(1), "main")), "");
    let objects = "object \"a\" { sphere }\nobject \"b\" { sphere }\n";
    let taken = refused(objects, |document| document.rename(&path(document, "a"), "b"));
    assert_eq!(taken, "There is an object called `b` already. Choose another name.");
    let empty = refused(objects, |document| document.rename(&path(document, "a"), ""));
    assert_eq!(empty, "The name of an object must not be empty.");
    let nameless = refused(objects, |document| document.rename(&path(document, "sphere"), "b"));
    assert_eq!(
        nameless,
        "A `sphere` has no name. Cameras, materials, fields, objects, parameters and declared shapes have."
    );
}

#[test]
fn nodes_go_with_their_line() {
    let remove = |before: &str, title: &str, after: &str| {
        assert_eq!(edited(before, |document| document.remove(&path(document, title))), after, "of {before}");
    };
    remove(
        "object \"a\" { sphere }\nobject \"b\" { box } // c\nobject \"d\" { plane }",
        "b",
        "object \"a\" { sphere }\nobject \"d\" { plane }",
    );
    remove(
        "object \"a\" { sphere }\n\n// c\nobject \"b\" { box }\n\nobject \"d\" { plane }",
        "b",
        "object \"a\" { sphere }\n\n// c\n\nobject \"d\" { plane }",
    );
    remove(
        "object \"a\" { sphere }\n\nobject \"b\" { box }\n\nobject \"d\" { plane }",
        "b",
        "object \"a\" { sphere }\n\nobject \"d\" { plane }",
    );
    remove("object \"a\" { sphere }\nobject \"b\" { box }", "b", "object \"a\" { sphere }");
    remove("object \"a\" { sphere }\r\nobject \"b\" { box }", "b", "object \"a\" { sphere }");
    remove("object \"a\" { sphere }; object \"b\" { box }; sky 1", "b", "object \"a\" { sphere }; sky 1");
    remove("object \"a\" { sphere; box }", "box", "object \"a\" { sphere }");
    remove("object \"a\" { sphere; box; }", "box", "object \"a\" { sphere; }");
    remove("object \"a\" { sphere; box }", "sphere", "object \"a\" { box }");
    remove(
        "object \"a\" {\n\n    sphere {\n        at 0 1 0\n    } // c\n\n    box\n\n    plane\n\n}",
        "sphere",
        "object \"a\" {\n\n    box\n\n    plane\n\n}",
    );
    remove("object \"a\" {\n    box\n\n    plane\n}", "plane", "object \"a\" {\n    box\n}");
    remove("object \"a\" {\n    box // c\n    plane }", "plane", "object \"a\" {\n    box // c\n    }");
    remove("object \"a\" { sphere /-1 /-{ box }; plane }", "sphere", "object \"a\" { plane }");
    remove("object \"a\" { sphere; /-box\n}\nsky 1", "sky", "object \"a\" { sphere; /-box\n}");
}

#[test]
fn what_is_needed_stays() {
    let scene = "material \"m\" { emit 1 }\nobject \"a\" material=\"m\" { subtract { sphere; box } }\n\
                 object \"b\" { sphere material=\"m\" }\nobject \"c\" material=\"m\" { plane }\nobject \"d\" material=\"m\" { plane }\n";
    let remove = |title: &str| refused(scene, |document| document.remove(&path(document, title)));
    assert_eq!(remove("main"), "`main` is the only camera, and a scene needs one. Add another first.");
    assert_eq!(remove("pathmarch"), "A scene starts with its version, which cannot be removed.");
    assert_eq!(
        remove("m"),
        "`m` is the material of `a`, `b` and `c`, and 1 more. Give them another first, or remove them."
    );
    assert_eq!(remove("subtract"), "`subtract` is all that `a` contains. Remove `a` instead.");
    assert_eq!(
        remove("box"),
        "This would make a mistake in the scene: `subtract` of a single shape. It needs at least two: the first child without the others."
    );
    let camera = refused(scene, |document| document.set(&Path::top(1), "target", Value::Triple([0.0, 1.0, 5.0]), None));
    assert_eq!(camera, "This would make a mistake in the scene: The `target` of the camera equals its `position`.");
    let reset = refused(scene, |document| document.reset(&Path::top(1), "target"));
    assert_eq!(reset, "`target` must be given. Set it to another value instead.");
    let range = refused(scene, |document| document.set(&path(document, "sphere"), "radius", number(0.0), None));
    assert_eq!(range, "`radius` must be above 0.");
    let kind = refused(scene, |document| document.set(&path(document, "sphere"), "radius", text("1"), None));
    assert_eq!(kind, "`radius` must be a number.");
    let unknown = refused(scene, |document| document.set(&path(document, "sphere"), "height", number(1.0), None));
    assert_eq!(unknown, "`sphere` has no `height`.");
    assert_eq!(
        refused(scene, |document| document.remove(&Path::top(99))),
        "There is no node 99 in this scene. Select one of those that it has."
    );
}

#[test]
fn nodes_move_with_their_comments() {
    let to = |before: &str, title: &str, parent: Option<&str>, index: usize, after: &str| {
        let edit = |document: &mut Document| {
            let parent = parent.map(|parent| path(document, parent));
            let moved = document.move_to(&path(document, title), parent.as_ref(), index)?;
            assert_eq!(document.item(&moved).map(|item| item.title()), Some(title));
            Ok(())
        };
        assert_eq!(edited(before, edit), after, "of {before}");
    };
    to(
        "object \"a\" { sphere }\n// of b\n// too\nobject \"b\" { box } // c\nobject \"d\" { plane }\n",
        "b",
        None,
        4,
        "object \"a\" { sphere }\nobject \"d\" { plane }\n// of b\n// too\nobject \"b\" { box } // c\n",
    );
    to(
        "object \"a\" { sphere }\nobject \"b\" { box }",
        "b",
        None,
        0,
        "pathmarch 1\nobject \"b\" { box }\ncamera { position 0 1 5; target 0 1 0 }\nobject \"a\" { sphere }",
    );
    to("object \"a\" { sphere; box; plane }", "plane", Some("a"), 0, "object \"a\" { plane; sphere; box }");
    to("object \"a\" { sphere; box; plane }", "sphere", Some("a"), 1, "object \"a\" { box; sphere; plane }");
    to("object \"a\" { sphere; box; plane }", "sphere", Some("a"), 9, "object \"a\" { box; plane; sphere }");
    to(
        "object \"a\" { sphere; box }\nobject \"b\" {\n    plane\n}\n",
        "sphere",
        Some("b"),
        0,
        "object \"a\" { box }\nobject \"b\" {\n    sphere\n    plane\n}\n",
    );
    to(
        "object \"a\" {\n    union {\n        // ball\n        sphere {\n            at 0 1 0\n        } // c\n        box\n    }\n}\n",
        "sphere",
        Some("a"),
        1,
        "object \"a\" {\n    union {\n        box\n    }\n    // ball\n    sphere {\n        at 0 1 0\n    } // c\n}\n",
    );
    to(
        "object \"a\" {\n\tsphere // c\n\tbox\n}\nobject \"b\" { plane }",
        "sphere",
        Some("b"),
        1,
        "object \"a\" {\n\tbox\n}\nobject \"b\" { plane\n\tsphere // c\n}",
    );
    to(
        "object \"a\" { sphere; box }\nobject \"b\" { union { plane } }",
        "sphere",
        Some("union"),
        1,
        "object \"a\" { box }\nobject \"b\" { union { plane; sphere } }",
    );
    to(
        "object \"a\" { sphere /* b */; /* c */ box /* d */ }",
        "sphere",
        Some("a"),
        1,
        "object \"a\" { /* c */ box /* d */; sphere /* b */ }",
    );
    let scene = "object \"a\" { union { sphere; box } }\nobject \"b\" { plane }\n";
    let into = |title: &str, parent: Option<&str>| {
        refused(scene, |document| {
            let parent = parent.map(|parent| path(document, parent));
            document.move_to(&path(document, title), parent.as_ref(), 0)
        })
    };
    assert_eq!(into("union", Some("union")), "`union` cannot be moved into itself.");
    assert_eq!(
        into("plane", Some("sphere")),
        "`plane` cannot be in `sphere`: objects and operators contain shapes and operators."
    );
    assert_eq!(into("main", Some("b")), "`main` cannot be in `b`: objects and operators contain shapes and operators.");
    assert_eq!(into("pathmarch", None), "The version stays at the top of the file.");
}

#[test]
fn what_moves_keeps_its_material_and_what_is_empty_goes() {
    let to = |before: &str, title: &str, parent: Option<&str>, after: &str| {
        let edit = |document: &mut Document| {
            let parent = parent.map(|parent| path(document, parent));
            document.move_to(&path(document, title), parent.as_ref(), 9)
        };
        assert_eq!(edited(before, edit), after, "of {before}");
    };
    let red = "material \"red\" { diffuse 0.5 0 0 }\n";
    to(
        &format!("{red}object \"a\" material=\"red\" {{ sphere }}\nobject \"b\" {{ union {{ box }} }}\n"),
        "a",
        Some("union"),
        &format!("{red}object \"b\" {{ union {{ box; sphere material=\"red\" }} }}\n"),
    );
    to(
        &format!("{red}object \"a\" material=\"red\" {{ sphere; cone {{ at 1 0 0 }} }}\nobject \"b\" {{ box }}\n"),
        "a",
        Some("b"),
        &format!("{red}object \"b\" {{ box; union material=\"red\" {{ sphere; cone {{ at 1 0 0 }} }} }}\n"),
    );
    to(
        "object \"a\" { union { sphere } }\nobject \"b\" { plane }\n",
        "sphere",
        Some("b"),
        "object \"b\" { plane; sphere }\n",
    );
    to(
        &format!("{red}object \"a\" material=\"red\" {{ union {{ sphere; box }} }}\n"),
        "sphere",
        Some("a"),
        &format!("{red}object \"a\" material=\"red\" {{ union {{ box }}; sphere }}\n"),
    );
    to(
        "object \"a\" { union { sphere; box } }\n",
        "box",
        None,
        "object \"a\" { union { sphere } }\nobject \"box\" { box }\n",
    );
}

#[test]
fn nodes_are_combined_in_the_order_of_selection() {
    let combine = |before: &str, titles: &[&str], operator: &str, after: &str| {
        let edit = |document: &mut Document| {
            let paths: Vec<Path> = titles.iter().map(|title| path(document, title)).collect();
            let made = document.combine(&paths, operator)?;
            assert_eq!(document.item(&made).map(|item| item.title()), Some(operator));
            Ok(())
        };
        assert_eq!(edited(before, edit), after, "of {before}");
    };
    combine(
        "object \"a\" { sphere; box; plane }\n",
        &["box", "sphere"],
        "subtract",
        "object \"a\" { subtract { box; sphere }; plane }\n",
    );
    let red = "material \"red\" { diffuse 0.5 0 0 }\n";
    combine(
        &format!("{red}object \"a\" material=\"red\" {{ sphere }}\nobject \"b\" {{ box; cone }}\n"),
        &["b", "a"],
        "subtract",
        &format!("{red}object \"b\" {{ subtract {{ union {{ box; cone }}; sphere material=\"red\" }} }}\n"),
    );
    combine(
        "object \"a\" {\n    sphere // ball\n}\nobject \"b\" {\n    box\n}\nobject \"c\" { cone }\n",
        &["a", "b", "c"],
        "intersect",
        "object \"a\" {\n    intersect {\n        sphere // ball\n        box\n        cone\n    }\n}\n",
    );
    // One selected node is enough of what it contains.
    combine(
        "object \"a\" { sphere; box }\nobject \"b\" { cone }\n",
        &["a", "sphere", "b"],
        "union",
        "object \"a\" { union { union { sphere; box }; cone } }\n",
    );
    let refuse = |before: &str, titles: &[&str]| {
        refused(before, |document| {
            let paths: Vec<Path> = titles.iter().map(|title| path(document, title)).collect();
            document.combine(&paths, "union")
        })
    };
    let scene = "object \"a\" { sphere; union { box; cone; at 1 0 0 }; twist 0.2 { torus } }\n";
    assert_eq!(refuse(scene, &["sphere"]), "Select at least two shapes or objects to combine.");
    assert_eq!(
        refuse(scene, &["sphere", "main"]),
        "`main` has no shape. Only shapes, operators and objects can be combined."
    );
    assert_eq!(
        refuse(scene, &["sphere", "box"]),
        "The `at` of a `union` moves some of the selected shapes and not the others. Ungroup it first."
    );
    assert_eq!(
        refuse(scene, &["torus", "sphere"]),
        "A `twist` changes some of the selected shapes and not the others. Select the `twist` itself."
    );
}

#[test]
fn strings_of_several_lines_move_as_they_are() {
    let scene = "material \"\"\"\n  two\n    lines\n  \"\"\" { emit 1 }\nobject \"a\" {\n    union {\n        sphere material=\"\"\"\n  two\n    lines\n  \"\"\" {\n            at 0 1 0\n        }\n        box\n    }\n}\n";
    let moved = edited(scene, |document| document.move_to(&path(document, "sphere"), Some(&path(document, "a")), 1));
    assert!(
        moved.ends_with("    sphere material=\"\"\"\n  two\n    lines\n  \"\"\" {\n        at 0 1 0\n    }\n}\n"),
        "{moved}"
    );
}

#[test]
fn siblings_are_grouped_and_set_free() {
    let group = |before: &str, titles: &[&str], operator: &str, after: &str| {
        let edit = |document: &mut Document| {
            let paths: Vec<Path> = titles.iter().map(|title| path(document, title)).collect();
            let group = document.group(&paths, operator)?;
            assert_eq!(document.item(&group).map(|item| item.children.len()), Some(titles.len()));
            Ok(())
        };
        assert_eq!(edited(before, edit), after, "of {before}");
    };
    let ungroup = |before: &str, title: &str, after: &str| {
        let edit = |document: &mut Document| {
            let operator = path(document, title);
            let words: Vec<_> =
                document.item(&operator).unwrap().children.iter().map(|item| item.word.clone()).collect();
            let paths = document.ungroup(&operator)?;
            let now: Vec<_> = paths.iter().map(|path| document.item(path).unwrap().word.clone()).collect();
            assert_eq!(words, now);
            Ok(())
        };
        assert_eq!(edited(before, edit), after, "of {before}");
    };
    group("object \"a\" { sphere; box }", &["sphere", "box"], "subtract", "object \"a\" { subtract { sphere; box } }");
    group(
        "object \"a\" { sphere; box; plane }",
        &["plane", "box"],
        "union",
        "object \"a\" { sphere; union { box; plane } }",
    );
    let lines = "object \"a\" {\n  // ball\n  sphere 1 {\n    at 0 1 0\n  } // c\n\n  // one\n\n  cone\n  box\n}\n";
    let grouped = "object \"a\" {\n  subtract {\n    // ball\n    sphere 1 {\n      at 0 1 0\n    } // c\n    box\n  }\n\n  // one\n\n  cone\n}\n";
    group(lines, &["sphere", "box"], "subtract", grouped);
    ungroup(
        grouped,
        "subtract",
        "object \"a\" {\n  // ball\n  sphere 1 {\n    at 0 1 0\n  } // c\n  box\n\n  // one\n\n  cone\n}\n",
    );
    ungroup("object \"a\" { subtract { sphere; box; } }", "subtract", "object \"a\" { sphere; box }");
    ungroup("object \"a\" { union {\n    sphere // c\n} }", "union", "object \"a\" { sphere // c\n     }");
    ungroup(
        "material m { emit 1 }\nmaterial n { emit 1 }\nobject \"a\" { union material=m { sphere; box material=n } }",
        "union",
        "material m { emit 1 }\nmaterial n { emit 1 }\nobject \"a\" { sphere material=m; box material=n }",
    );
    let scene = "object \"a\" { union { sphere; at 0 1 0 }; box }\nobject \"b\" { plane }\n";
    let placed = refused(scene, |document| document.ungroup(&path(document, "union")));
    assert_eq!(placed, "The `at` of this `union` moves everything in it. Reset it first, or move it to the shapes.");
    let apart =
        refused(scene, |document| document.group(&[path(document, "sphere"), path(document, "plane")], "union"));
    assert!(apart.starts_with("Only shapes and operators of one object or operator can be grouped."), "{apart}");
    let operator = refused(scene, |document| document.group(&[path(document, "sphere")], "sphere"));
    assert!(operator.starts_with("There is no operator `sphere`. Expected `union`, `subtract`, "), "{operator}");
    let single = refused(scene, |document| document.group(&[path(document, "box")], "subtract"));
    assert!(single.starts_with("This would make a mistake in the scene: `subtract` of a single shape."), "{single}");
}

#[test]
fn copies_stand_behind() {
    let duplicate = |before: &str, title: &str, after: &str| {
        assert_eq!(edited(before, |document| document.duplicate(&path(document, title))), after, "of {before}");
    };
    duplicate(
        "// c\nobject \"a\" { sphere } // d\nsky 1",
        "a",
        "// c\nobject \"a\" { sphere } // d\nobject \"a 2\" { sphere }\nsky 1",
    );
    duplicate(
        "object \"a\" {\n  sphere\n}\nobject \"a 2\" { box }\n",
        "a",
        "object \"a\" {\n  sphere\n}\nobject \"a 3\" {\n  sphere\n}\nobject \"a 2\" { box }\n",
    );
    duplicate(
        "object \"a\" { sphere }; object \"a 2\" { box }",
        "a 2",
        "object \"a\" { sphere }; object \"a 2\" { box }\nobject \"a 3\" { box }",
    );
    duplicate("object \"a\" { sphere; box }", "sphere", "object \"a\" { sphere; sphere; box }");
    duplicate("object \"a\" { sphere; box }", "box", "object \"a\" { sphere; box; box }");
    duplicate("", "main", "camera \"main 2\" { position 0 1 5; target 0 1 0 }\n");
    duplicate(
        "point { at 1 1 1; intensity 1 }",
        "point",
        "point { at 1 1 1; intensity 1 }\npoint { at 1 1 1; intensity 1 }",
    );
    assert_eq!(refused("sky 1", |document| document.duplicate(&path(document, "sky"))), "A scene has only one `sky`.");
}

#[test]
fn kinds_change() {
    let kind = |before: &str, title: &str, kind: &str, after: &str| {
        assert_eq!(edited(before, |document| document.set_kind(&path(document, title), kind)), after, "of {before}");
    };
    kind(
        "object \"a\" { union smooth=0.1 { sphere; box } }",
        "union",
        "subtract",
        "object \"a\" { subtract smooth=0.1 { sphere; box } }",
    );
    kind("object \"a\" { sphere 2 { at 0 1 0 } }", "sphere", "cylinder", "object \"a\" { cylinder 2 { at 0 1 0 } }");
    kind("object \"a\" { plane { normal 0 1 1 } }", "plane", "sphere", "object \"a\" { sphere }");
    let m = |inside: &str| format!("material \"m\" {{ {inside} }}\nobject \"a\" material=\"m\" {{ sphere }}\n");
    kind(
        &m("metal 1 0.8 0.3; roughness 0.2; edge 1 // c\n"),
        "m",
        "principled",
        &m("principled 1 0.8 0.3; roughness 0.2 // c\n"),
    );
    kind(&m("metal 0.5; edge 1; roughness 0.2"), "m", "diffuse", &m("diffuse 0.5"));
    kind(&m("emit 8"), "m", "diffuse", &m("diffuse"));
    kind(&m("\n  glass 1 // clear\n  ior 1.4\n"), "m", "principled", &m("\n  principled 1 // clear\n  ior 1.4\n"));
    kind("sky 0.5 // c\n", "sky", "day", "sky \"day\" // c\n");
    kind(
        "sky \"day\" haze=2 { ground 0.1 }\n",
        "sky",
        "gradient",
        "sky \"gradient\" { zenith 0.2 0.4 0.8; horizon 0.8 0.85 0.9 }\n",
    );
    kind("sky \"gradient\" { zenith 0.2; horizon 0.8 }\n", "sky", "colour", "sky 0.8\n");
    let message = refused("sky 1", |document| document.set_kind(&path(document, "sky"), "picture"));
    assert_eq!(message, "Choose a .hdr or .exr file to be the sky.");
    let message = refused("object \"a\" { sphere }", |document| document.set_kind(&path(document, "a"), "b"));
    assert_eq!(message, "`a` is of no kind that could be changed.");
}

#[test]
fn a_sky_becomes_a_picture() {
    let text = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\nsky 0.5\n";
    let mut document = Document::new("tests/data/test.kdl", text);
    let sky = path(&document, "sky");
    document.set(&sky, key::PICTURE, Value::Text("small.hdr".to_owned()), None).unwrap();
    assert!(document.text().ends_with("sky \"small.hdr\"\n"), "{}", document.text());
    document.set(&sky, "strength", Value::Number(2.0), None).unwrap();
    assert!(document.text().ends_with("sky \"small.hdr\" strength=2\n"));
    let error = document.set(&sky, key::PICTURE, Value::Text("none.hdr".to_owned()), None).unwrap_err();
    assert!(error.to_string().contains("`none.hdr` cannot be the sky"), "{error}");
}

#[test]
fn things_are_added_where_they_belong() {
    let add = |before: &str, parent: Option<&str>, group: Group, name: &str, after: &str| {
        let edit = |document: &mut Document| {
            let parent = parent.map(|parent| path(document, parent));
            let addition = addition(group, name, document, parent.as_ref());
            let added = document.add(parent.as_ref(), &addition)?;
            assert!(document.item(&added).is_some());
            Ok(())
        };
        assert_eq!(edited(before, edit), after, "of {before}");
    };
    let scene = "\nmaterial \"m\" { emit 1 } // c\n\nobject \"a\" material=\"m\" { sphere }\n";
    add(
        scene,
        None,
        Group::Material,
        "metal",
        "\nmaterial \"m\" { emit 1 } // c\nmaterial \"metal\" { metal 0.9 }\n\nobject \"a\" material=\"m\" { sphere }\n",
    );
    add(
        scene,
        None,
        Group::Object,
        "box",
        "\nmaterial \"m\" { emit 1 } // c\n\nobject \"a\" material=\"m\" { sphere }\nobject \"box\" { box 1 1 1 }\n",
    );
    add(
        scene,
        None,
        Group::Sky,
        "day",
        "\nsky \"day\"\n\nmaterial \"m\" { emit 1 } // c\n\nobject \"a\" material=\"m\" { sphere }\n",
    );
    add(
        scene,
        Some("a"),
        Group::Shape,
        "torus",
        "\nmaterial \"m\" { emit 1 } // c\n\nobject \"a\" material=\"m\" { sphere; torus 1 0.25 }\n",
    );
    add("", None, Group::Camera, "camera", "\ncamera \"camera\" {\n    position 0 1.5 6\n    target 0 1 0\n}\n");
    add(
        "object \"a\" {\n  sphere // c\n}",
        Some("a"),
        Group::Shape,
        "plane",
        "object \"a\" {\n  sphere // c\n  plane\n}",
    );
    add(
        "object \"a\" {\n  union {\n    sphere\n  }\n}",
        Some("union"),
        Group::Shape,
        "plane",
        "object \"a\" {\n  union {\n    sphere\n    plane\n  }\n}",
    );
    let document = Document::new("", format!("{HEAD}sky 1\nrender\nobject \"a\" {{ sphere }}"));
    let groups = |parent: Option<&str>| {
        let mut groups: Vec<Group> =
            document.additions(parent.map(|title| path(&document, title)).as_ref()).iter().map(|a| a.group).collect();
        groups.dedup();
        groups
    };
    assert_eq!(groups(None), [Group::Object, Group::Material, Group::Light, Group::Camera, Group::Sky, Group::Param]);
    assert_eq!(groups(Some("a")), [Group::Shape, Group::Operator]);
    assert_eq!(groups(Some("sphere")), []);
    let sky = Addition {
        group: Group::Sky,
        name: "day".into(),
        doc: "The sky of a clear day, computed, with its sun.".into(),
    };
    let message = refused("sky 1", |document| document.add(None, &sky));
    assert_eq!(message, "`day` cannot be added here, or there is one already.");
}

#[test]
fn cameras_are_written() {
    let camera = |edit: fn(&mut pathmarch_scene::Camera)| {
        move |document: &mut Document| {
            let mut camera = document.scene().unwrap().cameras[0].clone();
            edit(&mut camera);
            document.write_camera(&camera, Some(&Path::top(1))).map(drop)?;
            assert_eq!(document.scene().unwrap().cameras[0], camera);
            Ok(())
        }
    };
    let head = |camera: &str| format!("pathmarch 1\n{camera}\n");
    assert_eq!(edited("", camera(|_| ())), "");
    let moved = edited("", camera(|camera| (camera.position, camera.fov) = ([0.0, 2.5, 5.0], 30.0)));
    assert_eq!(moved, head("camera { position 0 2.5 5; target 0 1 0; fov 30 }"));
    let lens =
        edited("", camera(|camera| (camera.lens_radius, camera.focus, camera.up) = (0.1, Some(2.0), [1.0, 0.0, 0.0])));
    assert_eq!(lens, head("camera { position 0 1 5; target 0 1 0; up 1 0 0; lens radius=0.1 focus=2 }"));
    assert_eq!(
        edited("", camera(|camera| camera.auto_exposure = true)),
        head("camera { position 0 1 5; target 0 1 0; exposure \"auto\" }")
    );
    let mut document = Document::new("", head("camera { position 0 1 5; target 0 1 0; exposure \"auto\" }"));
    let control = document.control(&Path::top(1), "exposure").expect("a control");
    assert_eq!(control.value, Value::Text("auto".to_owned()));
    camera(|camera| (camera.auto_exposure, camera.exposure) = (false, 2.0))(&mut document).expect("written");
    assert_eq!(document.text(), head("camera { position 0 1 5; target 0 1 0; exposure 2 }"));
    let new = edited("sky 1\n", |document| {
        let mut camera = document.scene().unwrap().cameras[0].clone();
        camera.exposure = 1.5;
        let path = document.write_camera(&camera, None)?;
        assert_eq!(document.item(&path).and_then(|item| item.name.as_deref()), Some("main 2"));
        Ok(())
    });
    assert_eq!(new, "\ncamera \"main 2\" {\n    position 0 1 5\n    target 0 1 0\n    exposure 1.5\n}\nsky 1\n");
    let message = refused("sky 1\n", |document| {
        let camera = document.scene().unwrap().cameras[0].clone();
        document.write_camera(&camera, Some(&path(document, "sky")))
    });
    assert_eq!(message, "`sky` is no camera.");
}

#[test]
fn line_ends_and_tabs_are_kept() {
    let head = HEAD.replace('\n', "\r\n");
    let text = format!("{head}object \"a\" {{\r\n\tunion {{\r\n\t\tsphere // c\r\n\t\tbox\r\n\t}}\r\n}}");
    let mut document = Document::new("", text.as_str());
    document.set(&path(&document, "union"), key::AT, Value::Triple([1.0, 0.0, 0.0]), None).unwrap();
    document.group(&[path(&document, "sphere"), path(&document, "box")], "subtract").unwrap();
    document.duplicate(&path(&document, "a")).unwrap();
    let object = |name: &str| {
        format!(
            "object \"{name}\" {{\r\n\tunion {{\r\n\t\tsubtract {{\r\n\t\t\tsphere // c\r\n\t\t\tbox\r\n\t\t}}\r\n\
             \t\tat 1 0 0\r\n\t}}\r\n}}"
        )
    };
    assert_eq!(document.text(), format!("{head}{}\r\n{}", object("a"), object("a 2")));
    document.remove(&path(&document, "a 2")).unwrap();
    document.ungroup(&path(&document, "subtract")).unwrap();
    document.reset(&path(&document, "union"), key::AT).unwrap();
    assert_eq!(document.text(), text);
}

#[test]
fn a_byte_order_mark_stays() {
    let mut document = Document::new("", "\u{feff}pathmarch 1\r\ncamera { position 0 1 5; target 0 1 0 }\r\nsky 1");
    assert!(document.scene().is_ok());
    document.duplicate(&Path::top(1)).unwrap();
    document.remove(&Path::top(1)).unwrap();
    assert_eq!(document.text(), "\u{feff}pathmarch 1\r\ncamera \"main 2\" { position 0 1 5; target 0 1 0 }\r\nsky 1");
}

#[test]
fn a_text_with_mistakes_can_be_edited_as_far_as_it_is_read() {
    let mut document =
        Document::new("", format!("{HEAD}object \"a\" {{ sphere -1; box 2 }}\nobject \"b\" {{ spere }}\n"));
    let mistakes = |document: &Document| document.scene().unwrap_err().mistakes().len();
    assert_eq!(mistakes(&document), 2);
    assert!(document.last_good().is_none());
    document.set(&path(&document, "box"), "y", number(1.0), None).unwrap();
    document.set(&path(&document, "sphere"), "radius", number(1.0), None).unwrap();
    assert_eq!(mistakes(&document), 1);
    document.remove(&path(&document, "b")).unwrap();
    assert_eq!(document.text(), format!("{HEAD}object \"a\" {{ sphere 1; box 2 1 2 }}\n"));
    assert!(document.scene().is_ok() && document.last_good().is_some());
    let open = format!("{HEAD}object \"a\" {{ union {{ sphere 1; ");
    let mut document = Document::new("", open.as_str());
    let error = document.set(&path(&document, "union"), key::AT, Value::Triple([1.0; 3]), None).unwrap_err();
    assert!(error.to_string().starts_with("The text of `union` has mistakes of form"), "{error}");
    assert_eq!(document.text(), open);
    let mut refused = Document::new("", "{".repeat(100));
    assert_eq!(refused.outline(), []);
    assert!(refused.add(None, &Addition { group: Group::Sky, name: "day".into(), doc: "".into() }).is_err());
}

const BOLTS: &str = "material \"steel\" { metal 0.6 }\n\
shape \"bolt\" { param length 0.5 min=0.1 max=2 doc=\"Of its shaft.\"; param r 0.1; cylinder r length; sphere r }\n\
object \"o\" { box; bolt length=1; union { sphere; bolt 2 { at 0 1 0 } } }\n";

#[test]
fn uses_of_declared_shapes_are_nodes() {
    use pathmarch_scene::document::{ControlKind, ItemKind};
    let document = Document::new("", format!("{HEAD}{BOLTS}"));
    assert_eq!(document.scene().unwrap().field.leaves().len(), 6);
    let word = |leaf| document.path_of_leaf(leaf).map(|path| document.item(&path).unwrap().word.clone());
    let words: Vec<String> = (0..6).map_while(word).collect();
    assert_eq!(words, ["box", "bolt", "bolt", "sphere", "bolt", "bolt"]);
    let object = path(&document, "o");
    let (first, second) = (object.child(1), object.child(2).child(1));
    assert_eq!((document.leaves_of(&first), document.leaves_of(&second)), (vec![1, 2], vec![4, 5]));
    assert_eq!(document.item(&first).unwrap().kind, ItemKind::Instance);
    let length = document.control(&second, "length").unwrap();
    assert_eq!((&length.value, &length.default), (&Value::Number(2.0), &Value::Number(0.5)));
    assert!(length.given && &*length.doc == "Of its shaft.");
    assert!(matches!(length.kind, ControlKind::Number(range) if (range.allowed.min, range.allowed.max) == (0.1, 2.0)));
    assert_eq!(document.control(&first, "r").unwrap().value, Value::Number(0.1));
    let shape = path(&document, "bolt");
    assert_eq!(document.item(&shape).unwrap().kind, ItemKind::Declaration);
    assert!(document.leaves_of(&shape).is_empty());
    assert_eq!(document.control(&shape.child(0), "radius").unwrap().value, Value::Formulas(vec!["r".to_owned()]));
    assert_eq!(document.control(&shape.child(0), "radius").unwrap().present, Value::Number(0.1));
}

#[test]
fn uses_of_declared_shapes_are_edited() {
    let use_of = |document: &Document, index| path(document, "o").child(index);
    let set = |key: &'static str, value: f32| {
        edited(BOLTS, |document| {
            let at = use_of(document, 1);
            document.set(&at, key, Value::Number(value), None)
        })
    };
    assert!(set("length", 0.3).contains("box; bolt length=0.3;"), "{}", set("length", 0.3));
    assert!(set("r", 0.2).contains("box; bolt length=1 r=0.2;"), "{}", set("r", 0.2));
    let text = edited(BOLTS, |document| document.reset(&use_of(document, 1), "length"));
    assert!(text.contains("box; bolt;"), "{text}");
    let text = edited(BOLTS, |document| document.rename(&path(document, "bolt"), "long pin"));
    assert!(text.contains("shape \"long pin\"") && text.contains("box; \"long pin\" length=1;"), "{text}");
    let text = edited(BOLTS, |document| document.set_material(&use_of(document, 1), Some("steel")));
    assert!(text.contains("bolt length=1 material=\"steel\""), "{text}");
    let message = refused(BOLTS, |document| document.remove(&path(document, "bolt")));
    assert!(message.contains("There is no `bolt` in an object."), "{message}");
    let message = refused(BOLTS, |document| document.set(&use_of(document, 1), "length", Value::Number(3.0), None));
    assert_eq!(message, "`length` must be from 0.1 to 2.");
    let text = edited(BOLTS, |document| {
        let object = path(document, "o");
        let addition = document.additions(Some(&object)).into_iter().find(|addition| addition.name == "bolt");
        document.add(Some(&object), &addition.expect("a declared shape"))
    });
    assert!(text.contains("; bolt }"), "{text}");
}

/// A number gets its first key, then others where it is changed at other moments; a key at the same moment is replaced.
#[test]
fn changes_of_a_number_with_keys_are_keys() {
    use pathmarch_scene::Moment;
    let text = format!("{HEAD}object \"a\" {{\n    sphere 1 {{ at 0 1 2 }}\n}}\n");
    let mut document = Document::new("test.kdl", text);
    let sphere = path(&document, "sphere");
    document.set_key(&sphere, key::AT, None).unwrap();
    assert!(
        document.text().contains("at \"keys(t, 0, 0)\" \"keys(t, 0, 1)\" \"keys(t, 0, 2)\""),
        "{}",
        document.text()
    );
    document.set_moment(Moment::of_frame(12, 24.0));
    document.set(&sphere, key::AT, Value::Triple([4.0, 1.0, 2.0]), Some(1)).unwrap();
    document.set(&sphere, key::AT, Value::Triple([5.0, 1.0, 2.0]), Some(1)).unwrap();
    assert!(document.text().contains("at \"keys(t, 0, 0, 0.5, 5)\" \"keys(t, 0, 1)\""), "{}", document.text());
    assert_eq!(document.key_times(&sphere), [0.0, 0.5]);
    document.set_moment(Moment::of_frame(6, 24.0));
    assert_eq!(document.control(&sphere, key::AT).unwrap().present, Value::Triple([2.5, 1.0, 2.0]));
    document.undo();
    document.undo();
    assert!(document.text().contains("at 0 1 2"));
    // Other formulas stay what they are.
    let mut document = Document::new("test.kdl", format!("{HEAD}object \"a\" {{ sphere \"1 + t\" }}\n"));
    let sphere = path(&document, "sphere");
    assert!(document.set_key(&sphere, "radius", None).is_err());
    assert!(document.set(&sphere, "radius", Value::Number(4.0), None).is_err());
}

#[test]
fn keys_repeat_with_their_period() {
    use pathmarch_scene::Moment;
    let mut document =
        Document::new("test.kdl", format!("{HEAD}object \"a\" {{ sphere \"keys(t % 2, 0, 1, 1, 3)\" }}\n"));
    let sphere = path(&document, "sphere");
    document.set_moment(Moment::of_frame(60, 24.0));
    document.set(&sphere, "radius", Value::Number(2.5), None).unwrap();
    assert!(document.text().contains("\"keys(t % 2, 0, 1, 0.5, 2.5, 1, 3)\""), "{}", document.text());
}

#[test]
fn hidden_objects_keep_their_place_in_the_tree() {
    let scene = "object \"a\" { sphere 1; box 1 }\nobject \"b\" { torus }\n";
    let hidden = edited(scene, |document| {
        let path = path(document, "a");
        document.set(&path, "hidden", Value::Flag(true), None)
    });
    assert_eq!(hidden, "object \"a\" hidden=#true { sphere 1; box 1 }\nobject \"b\" { torus }\n");
    let document = Document::new("test.kdl", format!("{HEAD}{hidden}"));
    assert_eq!(document.path_of_leaf(0), Some(path(&document, "torus")));
    assert_eq!(document.path_of_object(0), Some(path(&document, "b")));
    assert_eq!(
        (document.leaves_of(&path(&document, "a")), document.leaves_of(&path(&document, "box"))),
        (vec![], vec![])
    );
    let shown = edited(&hidden, |document| {
        let path = path(document, "a");
        document.reset(&path, "hidden")
    });
    assert_eq!(shown, scene);
}

/// The colour that stood there is the last one of the ramp; the first is darker.
#[test]
fn a_texture_keeps_the_colour() {
    let with = |material: &str, key: &str, kind: &str| {
        edited(&format!("material \"m\" {{ {material} }}\nobject \"o\" material=\"m\" {{ sphere }}\n"), |document| {
            let path = path(document, "m");
            document.set(&path, key, Value::Text(kind.to_owned()), None)
        })
    };
    let red = with("diffuse 0.8 0.2 0.1", "albedo.texture", "marble");
    assert!(red.contains("diffuse { marble { colour 0.24 0.06 0.03; colour 0.8 0.2 0.1 } }"), "{red}");
    let grey = with("diffuse 0.5", "albedo.texture", "fbm");
    assert!(grey.contains("diffuse { fbm { colour 0.15; colour 0.5 } }"), "{grey}");
    let rough = with("metal 0.9; roughness 0.3", "roughness.texture", "fbm");
    assert!(rough.contains("roughness { fbm }"), "{rough}");
}

const CURVE: &str = "pathmarch 1
camera { position 0 0 5; target 0 0 0 }
object \"glass\" {
    revolve {
        curve 0.02 {
            point 0.4 0 // foot
            point 0.1 \"0.1 + 0.1\"
            point 0.5 1 corner=#true
        }
    }
}
object \"tag\" { extrude 0.1 { polygon { point 0 0; point 1 0; point 0 1 } } }
";

#[test]
fn control_points_are_moved_added_and_removed_in_place() {
    let mut document = Document::new("a.kdl", CURVE);
    let (curve, polygon) = (path(&document, "curve"), path(&document, "polygon"));
    let points = document.control_points(&curve);
    assert_eq!(points.iter().map(|point| point.at).collect::<Vec<_>>(), [[0.4, 0.0], [0.1, 0.2], [0.5, 1.0]]);
    assert_eq!(points.iter().map(|point| point.is_corner).collect::<Vec<_>>(), [false, false, true]);
    assert!(document.control_points(&polygon).iter().all(|point| point.is_corner));
    assert_eq!(document.control_points(&path(&document, "revolve")), []);
    // One step of undo for a drag, of which the first part adds the point.
    document.add_point(&curve, 1, [0.3, 0.05], Some(1)).expect("added");
    document.move_point(&curve, 1, [0.25, 0.05], Some(1)).expect("moved");
    assert!(document.text().contains("point 0.4 0 // foot\n            point 0.25 0.05\n"), "{}", document.text());
    assert_eq!(document.can_undo(), Some("Add point to curve"));
    document.undo();
    assert_eq!(document.text(), CURVE);
    // A formula stays.
    document.move_point(&curve, 1, [0.2, 0.7], None).expect("moved");
    assert!(document.text().contains("point 0.2 \"0.1 + 0.1\""), "{}", document.text());
    document.set_corner(&curve, 1, true).expect("a corner");
    assert!(document.text().contains("point 0.2 \"0.1 + 0.1\" corner=#true"), "{}", document.text());
    document.set_corner(&curve, 2, false).expect("smooth");
    assert!(document.text().contains("point 0.5 1\n"), "{}", document.text());
    document.remove_point(&curve, 0).expect("two are left");
    assert_eq!(document.control_points(&curve).len(), 2);
    assert!(matches!(document.remove_point(&curve, 0), Err(EditError::Mistake { .. })));
    assert!(matches!(document.move_point(&curve, 5, [0.0; 2], None), Err(EditError::NotHere(_))));
    document.add_point(&polygon, 0, [-1.0, -1.0], None).expect("the first");
    document.add_point(&polygon, 4, [-1.0, 1.0], None).expect("the last");
    assert!(document.text().contains("{ point -1 -1; point 0 0; point 1 0; point 0 1; point -1 1 }"));
    while document.undo().is_some() {}
    assert_eq!(document.text(), CURVE);
}

#[test]
fn a_scene_is_read_without_a_node() {
    let mut document = Document::new("a.kdl", CURVE);
    let revision = document.revision();
    // The object is empty without its profile.
    let without = document.scene_without(&path(&document, "curve")).expect("a scene");
    assert_eq!(without.objects.len(), 1);
    assert_eq!((document.text(), document.revision()), (CURVE, revision));
}

#[test]
fn colours_of_ramps_are_added_moved_and_removed() {
    const TEXT: &str = "pathmarch 1
camera { position 0 0 5; target 0 0 0 }
material \"stone\" {
    principled { marble size=0.4 { colour 0.9 0.88 0.85; colour 0.25; rotate 0 0 30; colour \"0.1*2\" } }
    roughness { fbm from=0.2 }
    orbit-trap \"line\"
}
";
    let mut document = Document::new("a.kdl", TEXT);
    let stone = path(&document, "stone");
    let ramps = document.ramps(&stone);
    let names: Vec<_> = ramps.iter().map(|ramp| (ramp.name.as_str(), ramp.colours.len())).collect();
    assert_eq!(names, [("colour", 3), ("orbit-trap", 0)], "a roughness has no colours");
    assert_eq!(ramps[0].colours, [[0.9, 0.88, 0.85], [0.25; 3], [0.2; 3]]);
    let texts = |document: &Document, part: &str| assert!(document.text().contains(part), "{}", document.text());
    assert_eq!(ramps[0].positions, [0.0, 0.5, 1.0]);
    document.add_colour_at(&stone, &ramps[0], [1.0, 0.5, 0.0], 0.25, 1).expect("added");
    let added = "{ colour 0.9 0.88 0.85; colour 1 0.5 0 at=0.25; colour 0.25 at=0.5; rotate 0 0 30; colour \"0.1*2\" }";
    texts(&document, added);
    let ramp = document.ramps(&stone).swap_remove(0);
    assert_eq!(ramp.positions, [0.0, 0.25, 0.5, 1.0]);
    document.place_colour(&stone, &ramp, 1, 0.9, 2).expect("moved");
    texts(&document, &added.replace("at=0.25", "at=0.5"));
    document.place_colour(&stone, &ramp, 3, 0.75, 2).expect("moved");
    texts(&document, "colour \"0.1*2\" at=0.75 }");
    document.remove_colour(&stone, &ramp, 3).expect("removed");
    texts(&document, "{ colour 0.9 0.88 0.85; colour 1 0.5 0 at=0.5; colour 0.25 at=0.5; rotate 0 0 30 }");
    document.start_ramp(&stone, &ramps[1], &[[0.02; 3], [0.9, 0.0, 0.0]]).expect("the first ones");
    texts(&document, "orbit-trap \"line\" { colour 0.02; colour 0.9 0 0 }");
    assert!(matches!(document.remove_colour(&stone, &ramps[0], 7), Err(EditError::NotHere(_))));
    let mut steps = 0;
    while document.undo().is_some() {
        steps += 1;
    }
    assert_eq!((steps, document.text()), (4, TEXT), "moves of one drag are one step");
}
