//! Shapes that a file declares, and what comes of their uses.

use pathmarch_scene::Scene;

fn body(text: &str) -> Scene {
    let text = format!("pathmarch 1\ncamera {{ position 0 1 5; target 0 1 0 }}\nsky 1\n{text}");
    match Scene::parse("test.kdl", &text) {
        Ok(scene) => scene,
        Err(error) => panic!("{:?}", miette::Report::new(error)),
    }
}

/// Numbers, material and place of each leaf.
fn leaves(scene: &Scene) -> Vec<(Vec<f32>, &str, [f32; 3], f32)> {
    let of = |leaf: &pathmarch_field::graph::Leaf| {
        (leaf.params.clone(), &*scene.materials[leaf.tag as usize].name, leaf.pose.at, leaf.pose.scale)
    };
    scene.field.leaves().iter().map(of).collect()
}

#[test]
fn a_use_is_what_it_holds() {
    let declared = body(
        r#"
param size 2
material "steel" { metal 0.6 }
material "wood" { diffuse 0.3 }
object "o" material="wood" {
    bolt length=0.5 material="steel" { at 0 size 0; scale 2 }
    bolt 1 0.25 { rotate 0 90 0; at 1 0 0 }
    subtract { box; bolt }
}
shape "bolt" {
    param length 0.1
    param head "length/5" min=0
    cylinder 0.01 height=length
    head size=head { at 0 "length/2" 0 }
}
shape "head" { param size 1; sphere size material="wood" }
"#,
    );
    let written = body(
        r#"
material "steel" { metal 0.6 }
material "wood" { diffuse 0.3 }
object "o" material="wood" {
    union material="steel" { cylinder 0.01 0.5; sphere 0.1 material="wood" { at 0 0.25 0 }; at 0 2 0; scale 2 }
    union { cylinder 0.01 1; sphere 0.25 { at 0 0.5 0 }; rotate 0 90 0; at 1 0 0 }
    subtract { box; union { cylinder 0.01 0.1; sphere 0.02 { at 0 0.05 0 } } }
}
"#,
    );
    assert_eq!(leaves(&declared), leaves(&written));
    for point in [[0.0, 2.0, 0.0], [1.0, 0.3, 0.1], [0.0, 0.06, 0.0], [3.0, 3.0, 3.0]] {
        let point = pathmarch_field::number::Vec3::new(point[0], point[1], point[2]);
        assert_eq!(declared.field.distance(point), written.field.distance(point));
    }
    assert!(declared.params.len() == 1 && !declared.animated);
    // Without use, it brings nothing, not even a material.
    assert_eq!(body("shape \"a\" { sphere \"1 + t\" }\nobject \"o\" { box }").materials.len(), 1);
    assert!(!body("shape \"a\" { sphere \"1 + t\" }\nobject \"o\" { box }").animated);
    assert!(body("shape \"a\" { sphere \"1 + t\" }\nobject \"o\" { a }").animated);
}

#[test]
fn names_are_those_in_sight() {
    // The parameters of a use are those of its declaration and of the file, not of what uses it.
    let scene = body(
        "param a 1\nshape \"inner\" { param b a; sphere \"a + b\" }\n\
         shape \"outer\" { param a 5; inner b=\"a + 1\"; sphere a }\nobject \"o\" { outer; inner }",
    );
    let radii: Vec<f32> = scene.field.leaves().iter().map(|leaf| leaf.params[0]).collect();
    assert_eq!(radii, [7.0, 5.0, 2.0]);
    // Profiles may be declared, too.
    body("shape \"plate\" { star }\nobject \"o\" { extrude { plate } }");
}

const SHADER: &str = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nfield \"f\" {\n    bounds 2 2 2\n    glsl \"\"\"\n        uniform float size; // slider[0,0.5,2]\n        float map(vec3 p) { return length(p) - size * scale; }\n        \"\"\"\n    param scale 1\n}\nobject \"o\" { f size=0.25 }\n";

/// Uniforms are parameters behind those of the field, and mistakes are shown at their lines.
#[test]
fn a_field_may_be_a_shader_in_glsl() {
    let scene = Scene::parse("shader.kdl", SHADER).unwrap_or_else(|error| panic!("{:#?}", error.mistakes()));
    let leaf = &scene.field.leaves()[0];
    assert_eq!(leaf.params[..2], [1.0, 0.25]);
    let names: Vec<&str> = leaf.shape.params().iter().map(|param| &*param.name).collect();
    assert_eq!(names, ["scale", "size"]);
    let broken = SHADER.replace("length", "lenght");
    let error = Scene::parse("shader.kdl", &broken).err().unwrap_or_else(|| panic!("accepted"));
    let mistake = &error.mistakes()[0];
    assert!(mistake.message.contains("no function `lenght`"), "{}", mistake.message);
    assert_eq!(mistake.span.offset(), broken.find("lenght").unwrap_or_default());
}
