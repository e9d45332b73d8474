//! Mesh files, read by other programs' readers.

use glam::Vec3;
use pathmarch_render::mesh_file::{MeshFormat, mesh, save};
use pathmarch_render::pathmarch_field::mesh::Fineness;
use pathmarch_render::pathmarch_field::{Field, Mesh};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::srgb_encode;
use pathmarch_testing::{plain, tests};
use ply_rs_bw::ply::{DefaultElement, Property};
use std::ops::ControlFlow;
use std::path::Path;

/// Two adjoining boxes, one red and one grey.
fn boxes() -> Scene {
    let text = "pathmarch 1\ncamera \"front\" { position 0 1 4; target 0 0 0; fov 50 }\nrender { size 320 160 }\n\
                sky 1\nmaterial \"red\" { diffuse 0.8 0.1 0.05 }\n\
                object \"left\" material=\"red\" { box 1 { at -0.5 0 0 } }\nobject \"right\" { box 1 { at 0.5 0 0 } }";
    Scene::parse("boxes.kdl", text).expect("a scene")
}

/// Mesh of the boxes.
fn example() -> Mesh {
    let scene = boxes();
    let objects: Vec<_> = scene.objects.iter().collect();
    let made = mesh(&scene, &objects, Fineness::Resolution(16), None, &|_| ControlFlow::Continue(()));
    made.expect("a mesh")
}

/// Volume and area of triangles.
fn measure(triangles: impl Iterator<Item = [Vec3; 3]>) -> [f32; 2] {
    triangles.fold([0.0; 2], |[volume, area], [a, b, c]| {
        [volume + a.dot(b.cross(c)) / 6.0, area + 0.5 * (b - a).cross(c - a).length()]
    })
}

fn check(name: &str, triangles: impl Iterator<Item = [Vec3; 3]>) {
    let [volume, area] = measure(triangles);
    println!("{name}: volume {volume}, area {area}");
    assert!((volume - 2.0).abs() < 0.002 && (area - 10.0).abs() < 0.01, "{name}: volume {volume}, area {area}");
}

fn written(format: MeshFormat, mesh: &Mesh, directory: &Path) -> std::path::PathBuf {
    let path = directory.join("mesh").with_extension(format.extension());
    save(&path, mesh, &boxes()).expect("written");
    path
}

fn stl_is_read_by_other_programs() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    let path = written(MeshFormat::Stl, &mesh, directory.path());
    let read = stl_io::read_stl(&mut std::fs::File::open(path).expect("there")).expect("read");
    read.validate().expect("closed");
    assert_eq!(read.faces.len(), mesh.triangles.len());
    let corner = |vertex: usize| Vec3::from(<[f32; 3]>::from(read.vertices[vertex]));
    check("stl", read.faces.iter().map(|face| face.vertices.map(corner)));
    for face in &read.faces {
        let [a, b, c] = face.vertices.map(corner);
        let normal = Vec3::from(<[f32; 3]>::from(face.normal));
        assert!(normal.dot((b - a).cross(c - a)) >= 0.0);
    }
}

fn ply_is_read_by_other_programs() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    let path = written(MeshFormat::Ply, &mesh, directory.path());
    let mut file = std::io::BufReader::new(std::fs::File::open(path).expect("there"));
    let read = ply_rs_bw::parser::Parser::<DefaultElement>::new().read_ply(&mut file).expect("read");
    let (vertices, faces) = (&read.payload["vertex"], &read.payload["face"]);
    assert_eq!((vertices.len(), faces.len()), (mesh.positions.len(), mesh.triangles.len()));
    let number = |vertex: usize, name: &str| match vertices[vertex][name] {
        Property::Float(value) => value,
        Property::UChar(value) => f32::from(value) / 255.0,
        ref other => panic!("{name}: {other:?}"),
    };
    let corner = |vertex: i32| Vec3::from(["x", "y", "z"].map(|name| number(vertex as usize, name)));
    check(
        "ply",
        faces.iter().map(|face| match &face["vertex_indices"] {
            Property::ListInt(indices) => [indices[0], indices[1], indices[2]].map(corner),
            other => panic!("{other:?}"),
        }),
    );
    for (vertex, colour) in mesh.colours.iter().enumerate() {
        let expected = colour.map(srgb_encode);
        for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
            assert!((number(vertex, name) - expected[k]).abs() < 0.003);
        }
    }
}

fn obj_is_read_by_other_programs() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    let path = written(MeshFormat::Obj, &mesh, directory.path());
    let (models, _) = tobj::load_obj(path, &tobj::LoadOptions::default()).expect("read");
    let read = &models[0].mesh;
    assert_eq!((models.len(), read.positions.len()), (1, 3 * mesh.positions.len()));
    let corner = |vertex: u32| Vec3::from_slice(&read.positions[3 * vertex as usize..]);
    check("obj", read.indices.chunks(3).map(|triangle| [triangle[0], triangle[1], triangle[2]].map(corner)));
    // The reader renumbers the vertices in the order of the triangles.
    for (&found, &vertex) in read.indices.iter().zip(mesh.triangles.as_flattened()) {
        assert_eq!(corner(found), Vec3::from(mesh.positions[vertex as usize]), "nothing is rounded");
        let colour = Vec3::from_slice(&read.vertex_color[3 * found as usize..]);
        assert!((colour - Vec3::from(mesh.colours[vertex as usize].map(srgb_encode))).length() < 2e-4);
    }
}

fn glb_is_read_by_other_programs() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    let path = written(MeshFormat::Glb, &mesh, directory.path());
    let read = gltf::Gltf::open(path).expect("valid");
    let blob = read.blob.as_deref().expect("a buffer");
    let primitive = read.meshes().next().expect("a mesh").primitives().next().expect("triangles");
    let reader = primitive.reader(|_| Some(blob));
    let positions: Vec<_> = reader.read_positions().expect("positions").map(Vec3::from).collect();
    let normals: Vec<_> = reader.read_normals().expect("normals").map(Vec3::from).collect();
    let colours: Vec<_> = reader.read_colors(0).expect("colours").into_rgb_f32().collect();
    let indices: Vec<_> = reader.read_indices().expect("indices").into_u32().map(|vertex| vertex as usize).collect();
    assert!(normals.len() == positions.len() && colours.len() == positions.len());
    assert_eq!(indices.len(), 3 * mesh.triangles.len());
    check("glb", indices.chunks(3).map(|triangle| [0, 1, 2].map(|k| positions[triangle[k]])));
    let bounds = primitive.bounding_box();
    for (k, side) in [1.0, 0.5, 0.5].into_iter().enumerate() {
        assert!((bounds.min[k] + side).abs() < 1e-3 && (bounds.max[k] - side).abs() < 1e-3, "{bounds:?}");
    }
    // The sides of a box are shaded flat, up to their edges; the colours are those of the materials, linear.
    for triangle in indices.chunks(3) {
        let [a, b, c] = [0, 1, 2].map(|k| positions[triangle[k]]);
        let face = (b - a).cross(c - a).normalize();
        for &vertex in triangle {
            assert!(normals[vertex].dot(face) > 0.99, "at {}: {} on {face}", positions[vertex], normals[vertex]);
        }
    }
    for (position, colour) in positions.iter().zip(&colours) {
        if position.x.abs() > 0.2 {
            let expected = if position.x < 0.0 { [0.8, 0.1, 0.05] } else { [0.8; 3] };
            assert!((Vec3::from(*colour) - Vec3::from(expected)).length() < 1e-6, "{colour:?} at {position}");
        }
    }
    // The camera stands at (0, 1, 4), looks along -z of its node at the origin, and its picture is upright.
    let node = read.nodes().find(|node| node.camera().is_some()).expect("a camera");
    let camera = node.camera().expect("a camera");
    let gltf::camera::Projection::Perspective(lens) = camera.projection() else { panic!("perspective") };
    assert_eq!(lens.aspect_ratio(), Some(2.0));
    assert!((lens.yfov().to_degrees() - 50.0).abs() < 1e-4, "{}", lens.yfov());
    let matrix = glam::Mat4::from_cols_array_2d(&node.transform().matrix());
    let middle = matrix.transform_point3(Vec3::new(0.0, 0.0, -17.0_f32.sqrt()));
    let up = matrix.transform_vector3(Vec3::Y);
    assert!(middle.length() < 1e-5, "{middle}");
    assert!(up.abs_diff_eq(Vec3::new(0.0, 4.0, -1.0).normalize(), 1e-5), "{up}");
}

fn three_mf_is_read_by_other_programs() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    let path = written(MeshFormat::ThreeMf, &mesh, directory.path());
    let models = threemf::read(std::fs::File::open(path).expect("there")).expect("read");
    let object = &models[0].resources.object[0];
    assert_eq!(models[0].build.item[0].objectid, object.id);
    let read = object.mesh.as_ref().expect("a mesh");
    assert_eq!(read.vertices.vertex.len(), mesh.positions.len());
    let corner = |vertex: usize| {
        let vertex = &read.vertices.vertex[vertex];
        Vec3::from([vertex.x, vertex.y, vertex.z].map(|number| number as f32))
    };
    check("3mf", read.triangles.triangle.iter().map(|found| [found.v1, found.v2, found.v3].map(corner)));
}

/// Numbers of an attribute in the text of a USD file.
fn usd_numbers(text: &str, name: &str) -> Vec<f32> {
    let (_, values) = text.split_once(&format!("{name} = [")).expect(name);
    let (values, _) = values.split_once(']').expect("an end");
    let words = values.split([',', '(', ')', ' ']).filter(|word| !word.is_empty());
    words.map(|word| word.parse().expect("a number")).collect()
}

fn usd_has_the_triangles_with_normals_and_colours() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    let text = std::fs::read_to_string(written(MeshFormat::Usda, &mesh, directory.path())).expect("text");
    assert!(text.starts_with("#usda 1.0\n"));
    let points: Vec<Vec3> = usd_numbers(&text, "points").chunks(3).map(Vec3::from_slice).collect();
    let indices: Vec<usize> = usd_numbers(&text, "faceVertexIndices").iter().map(|number| *number as usize).collect();
    check("usda", indices.chunks(3).map(|triangle| [0, 1, 2].map(|k| points[triangle[k]])));
    assert_eq!(usd_numbers(&text, "faceVertexCounts"), vec![3.0; mesh.triangles.len()]);
    for name in ["normals", "displayColor"] {
        assert_eq!(usd_numbers(&text, name).len(), 3 * points.len(), "{name}");
    }
    let archive = std::fs::read(written(MeshFormat::Usdz, &mesh, directory.path())).expect("an archive");
    let start = archive.windows(9).position(|bytes| bytes == b"#usda 1.0").expect("not compressed");
    assert_eq!(start % 64, 0, "data start at a multiple of 64 bytes");
    assert_eq!(&archive[start..start + text.len()], text.as_bytes());
}

fn unknown_extensions_and_missing_directories_are_refused() {
    let (mesh, directory) = (example(), tempfile::tempdir().expect("a directory"));
    for name in ["mesh", "mesh.fbx", ".stl"] {
        let error = save(&directory.path().join(name), &mesh, &boxes()).expect_err("no such format").to_string();
        assert!(error.contains(".stl, .ply, .obj, .glb, .3mf, .usda or .usdz"), "{error}");
    }
    assert_eq!(MeshFormat::from_path(Path::new("A.STL")).expect("upper case"), MeshFormat::Stl);
    assert!(save(&directory.path().join("no/such/mesh.stl"), &mesh, &boxes()).is_err());
    assert_eq!(directory.path().read_dir().expect("a directory").count(), 0, "nothing is left behind");
}

fn vertices_have_the_colours_of_textures_and_orbits() {
    let coloured = |material: &str, shape: &str| {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 1 4; target 0 0 0 }}\nsky 1\nmaterial \"it\" {{ {material} }}\n\
             object \"it\" material=\"it\" {{ {shape} }}"
        );
        let scene = Scene::parse("it.kdl", &text).expect("a scene");
        let objects: Vec<_> = scene.objects.iter().collect();
        let made = mesh(&scene, &objects, Fineness::Resolution(24), None, &|_| ControlFlow::Continue(()));
        made.expect("a mesh")
    };
    let checker = "diffuse { checker size=0.5 { colour 0.8 0.1 0.1; colour 0.1 0.1 0.8 } }";
    let textured = coloured(checker, "box 2 2 2 { at 0.25 0.25 0.25 }");
    let count = |colour: [f32; 3]| {
        let near = |found: &&[f32; 3]| (0..3).all(|k| (found[k] - colour[k]).abs() < 1e-4);
        textured.colours.iter().filter(near).count() as f64 / textured.colours.len() as f64
    };
    let [red, blue] = [count([0.8, 0.1, 0.1]), count([0.1, 0.1, 0.8])];
    println!("{red:.3} red, {blue:.3} blue");
    assert!((red + blue - 1.0).abs() < 1e-9 && (red - 0.5).abs() < 0.1);
    let lamp = coloured("emit 4 0.5 0", "sphere");
    assert!(lamp.colours.iter().all(|colour| *colour == [1.0, 0.5, 0.0]), "the radiance, clipped to 1");
    let trap = "diffuse 0.5; orbit-trap \"point\" from=0 to=2 { colour 0; colour 1 }";
    let fractal = coloured(trap, "mandelbulb iterations=4");
    let mut greys: Vec<f32> = fractal.colours.iter().map(|colour| colour[0]).collect();
    greys.sort_by(f32::total_cmp);
    assert!(greys[greys.len() - 1] - greys[0] > 0.05, "{} to {}", greys[0], greys[greys.len() - 1]);
}

/// Solid with a smooth blend, an edge and a hollow.
const SOLID: &str =
    "subtract { union smooth=0.2 { sphere 0.8; box 1 0.7 0.6 { at 0.7 0.3 0 } }; torus 0.6 0.2 { at 0 0.5 0 } }";

/// The field of a solid.
fn field_of(solid: &str, directory: &Path) -> Scene {
    let text =
        format!("pathmarch 1\ncamera {{ position 0 1 4; target 0 0 0 }}\nsky 1\nobject \"solid\" {{ {solid} }}\n");
    let path = directory.join("scene.kdl");
    std::fs::write(&path, text).expect("written");
    Scene::load(&path).expect("a scene")
}

fn distance(field: &Field, [x, y, z]: [f32; 3]) -> f32 {
    field.distance(pathmarch_render::pathmarch_field::number::Vec3::new(x, y, z))
}

/// Points at which a field is zero, on random segments.
fn surface_points(field: &Field, count: usize) -> Vec<[f32; 3]> {
    let mut state = 7_u32;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0
    };
    let mut point = || Vec3::from([0; 3].map(|_| 3.0 * uniform() - 1.5));
    let distance = |p: Vec3| distance(field, p.to_array());
    let mut points = Vec::new();
    while points.len() < count {
        let (mut inside, mut outside) = (point(), point());
        if distance(inside) < 0.0 && distance(outside) > 0.0 {
            for _ in 0..40 {
                let middle = inside.midpoint(outside);
                *(if distance(middle) < 0.0 { &mut inside } else { &mut outside }) = middle;
            }
            points.push(inside.to_array());
        }
    }
    points
}

/// Largest absolute value of a field at some points.
fn largest_distance(field: &Field, points: &[[f32; 3]]) -> f32 {
    points.iter().map(|&p| distance(field, p).abs()).fold(0.0, f32::max)
}

/// Field to mesh file to field.
fn exported_solids_return_within_a_voxel() {
    let directory = tempfile::tempdir().expect("a directory");
    let original = field_of(SOLID, directory.path());
    let objects: Vec<_> = original.objects.iter().collect();
    let fineness = Fineness::Resolution(128);
    let exported = mesh(&original, &objects, fineness, None, &|_| ControlFlow::Continue(())).expect("a mesh");
    let extent = exported.positions.iter().fold([[f32::MAX; 3], [f32::MIN; 3]], |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    });
    let voxel = (0..3).map(|k| extent[1][k] - extent[0][k]).fold(0.0, f32::max) / 128.0;
    for format in [MeshFormat::Stl, MeshFormat::Ply, MeshFormat::Obj, MeshFormat::Glb] {
        let path = written(format, &exported, directory.path());
        let file = path.file_name().and_then(|name| name.to_str()).expect("a name");
        let returned = field_of(&format!("mesh \"{file}\" as=\"field\" resolution=128"), directory.path());
        let there = largest_distance(&returned.field, &surface_points(&original.field, 5000));
        let back = largest_distance(&original.field, &surface_points(&returned.field, 5000));
        println!("{format:?}: {:.2} and {:.2} voxels", there / voxel, back / voxel);
        assert!(there < voxel && back < voxel, "{format:?}: {there} and {back}, a voxel is {voxel}");
    }
}

tests! {
    plain: [
        stl_is_read_by_other_programs,
        ply_is_read_by_other_programs,
        obj_is_read_by_other_programs,
        glb_is_read_by_other_programs,
        three_mf_is_read_by_other_programs,
        usd_has_the_triangles_with_normals_and_colours,
        unknown_extensions_and_missing_directories_are_refused,
        vertices_have_the_colours_of_textures_and_orbits,
        exported_solids_return_within_a_voxel,
    ],
}
