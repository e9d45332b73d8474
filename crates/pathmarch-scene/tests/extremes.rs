//! Scenes that would give black pictures are reported.

use pathmarch_scene::{Scene, SceneError};

fn text(objects: &str) -> String {
    format!("pathmarch 1\ncamera {{ position 0 1 5; target 0 0 0 }}\nsky 1\nobject \"ball\" {{ sphere 1 }}\n{objects}")
}

fn messages(text: &str) -> Vec<String> {
    match Scene::parse("test.kdl", text) {
        Ok(_) => Vec::new(),
        Err(error @ SceneError::Mistakes { .. }) => error.mistakes().iter().map(ToString::to_string).collect(),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn what_32_bit_numbers_cannot_hold_is_a_mistake() {
    let bad = [
        ("object \"a\" { sphere 1 { at 1e20 0 0 } }", "`a` has a shape 1e20 m"),
        ("object \"a\" { sphere 1 { at 0 -3e38 0 } }", "`a` has a shape 3e38 m"),
        ("object \"a\" { plane { at 0 1e12 0 } }", "`a` has a shape 1e12 m"),
        ("object \"a\" { sphere 1 { scale 1e-30 } }", "`a` has a shape that is scaled by 1e-30"),
        ("object \"a\" { sphere 1 { scale 1e30 } }", "`a` has a shape that is scaled by 1e30"),
        ("object \"a\" { sphere 1e-20 }", "`a` is 2e-20 m large"),
        ("object \"a\" { torus 1e20 1 }", "`a` reaches 1e20 m"),
        ("object \"a\" { union smooth=0.1 { sphere 1; union { sphere 1; at 1e20 0 0 } } }", "`a` has a shape"),
        ("point { at 1e20 0 0; intensity 1 }", "This point light is 1e20 m"),
        ("camera \"far\" { position 1e20 0 0; target 0 0 0 }", "The position of the camera `far` is 1e20 m"),
        ("camera \"far\" { position 0 0 0; target 1e20 0 0 }", "The target of the camera `far` is 1e20 m"),
    ];
    for (objects, expected) in bad {
        let found = messages(&text(objects));
        assert_eq!(found.len(), 1, "{objects}: {found:?}");
        assert!(found[0].contains(expected), "{objects}: {found:?}");
    }
}

#[test]
fn large_and_small_scenes_are_read() {
    for objects in [
        "object \"planet\" { sphere 6.4e6 { at 0 -6.4e6 0 } }",
        "object \"grain\" { sphere 1e-6 }",
        "object \"floor\" { plane }",
        "object \"endless\" { repeat 2 0 2 { sphere 0.5 } }",
    ] {
        assert_eq!(messages(&text(objects)), [""; 0], "{objects}");
    }
}

#[test]
fn a_camera_inside_an_opaque_solid_is_warned_of() {
    let warnings = |objects: &str| {
        let scene = Scene::parse("test.kdl", &text(objects)).expect("a scene");
        scene.warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let inside = "camera \"in\" { position 0 0.1 0; target 0 0 1 }";
    let found = warnings(inside);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].contains("The camera `in` is inside the object `ball`, which is opaque"), "{found:?}");
    let around = |solid: &str| format!("camera \"in\" {{ position 9 0.1 0; target 9 0 1 }}\n{solid}");
    for fine in [
        "material \"g\" { glass }\nobject \"a\" material=\"g\" { sphere 1 { at 9 0 0 } }",
        "material \"g\" { glass }\nobject \"a\" { sphere 1 material=\"g\" { at 9 0 0 } }",
        "object \"a\" { shell 0.1 { sphere 1; at 9 0 0 } }",
        // A room, seen from inside.
        "object \"a\" { box 4 { at 9 0 0 } }\nmaterial \"lamp\" { emit 1 }\n\
         object \"b\" material=\"lamp\" { sphere 0.5 { at 9 1 1 } }",
        "object \"a\" { box 4 { at 9 0 0 } }\npoint { at 9 1.9 0; intensity 1 }",
    ] {
        assert_eq!(warnings(&around(fine)), [""; 0], "{fine}");
    }
    let dark = "object \"a\" { box 4 { at 9 0 0 } }\npoint { at 9 2.1 0; intensity 1 }";
    let found = warnings(&around(dark));
    assert!(found.len() == 1 && found[0].contains("The camera `in` is inside the object `a`"), "{found:?}");
}
