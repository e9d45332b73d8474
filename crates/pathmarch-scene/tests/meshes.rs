//! Meshes in scene files: what is accepted, and what is refused with a message.

use pathmarch_scene::document::mesh_import::{import_mesh, mesh_on_ground, scene_text};
use pathmarch_scene::{Mistake, Scene, SceneError};
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../pathmarch-mesh/tests/data").join(name)
}

fn parse(objects: &str) -> Result<Scene, SceneError> {
    let text = format!("pathmarch 1\ncamera {{ position 0 1 5; target 0 0 0 }}\nsky 1\n{objects}");
    Scene::parse(&data("scene.kdl").display().to_string(), &text)
}

fn mistakes(objects: &str) -> Vec<Mistake> {
    match parse(objects) {
        Err(SceneError::Mistakes { mistakes, .. }) => mistakes,
        other => panic!("{objects}: {other:?}"),
    }
}

#[test]
fn a_mesh_is_an_object_of_triangles_with_the_materials_of_its_file() {
    let scene = parse("object \"box\" { mesh \"BoxVertexColors.glb\" { scale 2; at 1 0 0; rotate 0 45 0 } }");
    let scene = scene.unwrap_or_else(|error| panic!("{error:?}"));
    assert!(scene.field.has_triangles());
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.materials[0].kind.name, "principled");
    let own = parse("material \"m\" { diffuse 1 }\nobject \"box\" material=\"m\" { mesh \"BoxVertexColors.glb\" }");
    assert_eq!(own.expect("a scene").materials.len(), 1, "the object's material replaces those of the file");
}

#[test]
fn a_field_takes_operators_and_triangles_do_not() {
    let solid = |form: &str| format!("object \"o\" {{ subtract {{ mesh \"suzanne.glb\" {form}; sphere 0.5 }} }}");
    let scene = parse(&solid("as=\"field\" resolution=32")).unwrap_or_else(|error| panic!("{error:?}"));
    assert!(scene.field.has_meshes() && !scene.field.has_triangles());
    for form in ["", "as=\"lit-by-field\" resolution=16"] {
        let refused = mistakes(&solid(form));
        assert_eq!(refused[0].code, "pathmarch::combined_triangles");
        assert!(refused[0].help.as_ref().is_some_and(|help| help.contains("as=\"field\"")), "{refused:?}");
    }
    let lit = parse("object \"o\" { mesh \"suzanne.glb\" as=\"lit-by-field\" resolution=16 }");
    let field = &lit.unwrap_or_else(|error| panic!("{error:?}")).field;
    assert!(field.has_triangles() && field.has_meshes_lit_by_field() && !field.sphere_traced_bounds().is_empty());
    let beside = mistakes("object \"o\" { mesh \"suzanne.glb\"; sphere 0.5 }");
    assert_eq!(beside[0].code, "pathmarch::combined_triangles");
}

#[test]
fn mistakes_name_their_place() {
    for (node, code, words) in [
        ("mesh \"missing.glb\"", "pathmarch::mesh_file", "missing.glb"),
        ("mesh \"README.md\"", "pathmarch::mesh_file", "extension"),
        ("mesh \"odd/IndexOutOfRange.gltf\"", "pathmarch::mesh_file", "IndexOutOfRange"),
        ("mesh \"odd/point_cloud.obj\"", "pathmarch::mesh_file", "triangles"),
        ("mesh", "pathmarch::missing_argument", "mesh"),
        ("mesh \"\"", "pathmarch::empty_name", ".glb"),
        ("mesh \"suzanne.glb\" as=\"cloud\"", "pathmarch::unknown_name", "cloud"),
        ("mesh \"suzanne.glb\" as=\"field\" resolution=4", "pathmarch::out_of_range", "16"),
        ("mesh \"suzanne.glb\" detail=4", "pathmarch::unknown_property", "detail"),
        ("mesh \"suzanne.glb\" { sphere 1 }", "pathmarch::misplaced_node", "sphere"),
        ("mesh 3", "pathmarch::wrong_type", "string"),
        ("mesh \"suzanne.glb\" node=9", "pathmarch::mesh_file", "no node 9"),
    ] {
        let found = mistakes(&format!("object \"o\" {{ {node} }}"));
        assert_eq!(found.len(), 1, "{node}: {found:?}");
        let Mistake { message, label, code: found_code, help, .. } = &found[0];
        let text = format!("{message} {label} {help:?}");
        assert!(text.contains(words), "{node}: {text}");
        println!("{found_code} {code}: {text}");
        assert_eq!(*found_code, code, "{node}");
    }
}

#[test]
fn a_file_is_read_once() {
    let text = "pathmarch 1\ncamera { position 0 1 5; target 0 0 0 }\nsky 1\n\
                object \"a\" { mesh \"suzanne.glb\" }\nobject \"b\" { mesh \"suzanne.glb\" { at 3 0 0 } }";
    let scene = Scene::parse(&data("scene.kdl").display().to_string(), text).expect("a scene");
    let surfaces: Vec<_> = scene.field.leaves().iter().filter_map(|leaf| leaf.shape.mesh()).collect();
    assert!(std::sync::Arc::ptr_eq(surfaces[0].surface(), surfaces[1].surface()));
    assert_eq!(scene.materials.len(), 1);
}

#[test]
fn an_imported_file_is_a_scene() {
    for name in ["extensions.gltf", "TextureSettingsTest.glb"] {
        let import = import_mesh(&data(name), name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let text = scene_text(&import);
        let scene = Scene::parse(&data("scene.kdl").display().to_string(), &text);
        let scene = scene.unwrap_or_else(|error| panic!("{name}: {error:?}\n{text}"));
        let objects = import.nodes.iter().filter(|node| node.word == "object").count();
        assert_eq!(scene.objects.len(), objects, "{text}");
    }
}

#[test]
fn a_mesh_on_the_ground_touches_it_above_the_origin() {
    let node = mesh_on_ground(&data("spot.obj"), "spot.obj").expect("a mesh");
    let scene = parse(&format!("object \"spot\" {{ {} }}", node.body)).unwrap_or_else(|error| panic!("{error:?}"));
    let bounds = scene.field.bounds();
    let lowest = [0.5 * (bounds.min[0] + bounds.max[0]), bounds.min[1], 0.5 * (bounds.min[2] + bounds.max[2])];
    assert!(lowest.iter().all(|v| v.abs() < 1e-4), "{lowest:?}");
}
