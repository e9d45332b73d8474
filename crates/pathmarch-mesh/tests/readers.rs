//! Readers on good files, compared with other readers, and on odd ones.

use glam::Vec3;
use pathmarch_mesh::material::{AlphaMode, LightKind, Projection, TextureTransform, Wrap};
use pathmarch_mesh::{Imported, ReadError, ReadOptions, TriangleMesh, read, read_bytes};
use std::path::{Path, PathBuf};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

fn import(name: &str) -> Imported {
    read(&data(name), &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn merged(imported: &Imported) -> TriangleMesh {
    imported.merged(usize::MAX).expect("few triangles")
}

/// Reads a text as if it were a file with an extension.
fn parse(text: &str, extension: &str) -> Result<Imported, ReadError> {
    read_bytes(text.as_bytes(), extension, &data("made-up"), &ReadOptions::default())
}

/// What a file of `odd/` is read as: triangles, area, and number of warnings; or a part of the error.
type Outcome = Result<(usize, f64, usize), &'static str>;

const ODD: [(&str, Outcome); 25] = [
    ("BoxBadNormals.glb", Ok((12, 6.0, 0))),
    ("BoxTextured.gltf", Err("buffer 0: ")),
    ("BoxWithInfinites.glb", Err("all 12 triangles have infinite or huge coordinates")),
    ("IndexOutOfRange.gltf", Err("IndexOutOfRange.bin: cannot be read")),
    ("Mesh_PrimitiveMode_04.gltf", Err("Mesh_PrimitiveMode_04.bin: cannot be read")),
    ("RecursiveNodes.gltf", Err("node 0: it is its own ancestor")),
    ("Spider_binary.stl", Ok((1368, 56.9476, 0))),
    ("badArray.gltf", Err("line 44, column 26: invalid type: map, expected a sequence")),
    ("badUint.gltf", Err("line 128, column 31: invalid value: integer `-1`")),
    ("box_UTF16BE.obj", Ok((12, 6.0, 1))),
    ("box_longline.obj", Ok((944, 239.0, 1))),
    ("concave_polygon.obj", Ok((64, 0.2455, 2))),
    ("crash-30d6d0f7c529b3b66b4131700b7a4580cd7082df.ply", Err("line 7: the file ends within the header")),
    ("cube_binary_header_with_RN_newline.ply", Ok((12, 6.0, 0))),
    ("cube_uv.ply", Ok((12, 24.0, 0))),
    ("cube_with_vertexcolors.obj", Ok((12, 6.0, 0))),
    ("float-color.ply", Ok((1, 10000.0, 0))),
    ("issue623.ply", Err("line 1 after the header: property vertex_indices is missing")),
    ("malformed.obj", Err("line 23: vertex 12 does not exist; there are 8 so far")),
    ("multiple_spaces.obj", Ok((1, 2.5981, 0))),
    ("number_formats.obj", Err("line 11: \"3.1+e2\" is not a number")),
    ("point_cloud.obj", Err("there are no faces, but 3 points")),
    ("regr_3429812.obj", Ok((4, 2.3596e-5, 2))),
    ("sphereWithHole.stl", Ok((285, 27.4187, 0))),
    ("triangle_with_two_solids.stl", Ok((2, 2.5, 0))),
];

#[test]
fn odd_files_are_read_right_or_refused() {
    let mut names: Vec<_> =
        std::fs::read_dir(data("odd")).expect("a directory").map(|entry| entry.expect("a file").file_name()).collect();
    names.sort();
    assert_eq!(names, ODD.map(|(name, _)| name));
    for (name, expected) in ODD {
        match (read(&data("odd").join(name), &ReadOptions::default()), expected) {
            (Ok(imported), Ok((triangles, area, warnings))) => {
                let mesh = merged(&imported);
                assert_eq!(mesh.triangles.len(), triangles, "{name}");
                assert!((mesh.area() / area - 1.0).abs() < 1e-3, "{name}: {}", mesh.area());
                assert_eq!(imported.warnings.len(), warnings, "{name}: {:?}", imported.warnings);
            }
            (Err(error), Err(part)) => {
                let text = error.to_string();
                assert!(text.contains(name) && text.contains(part) && text.contains("; "), "{text}");
            }
            (result, _) => panic!("{name}: {result:?}"),
        }
    }
}

#[test]
fn obj_agrees_with_tobj() {
    let mesh = merged(&import("spot.obj"));
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let (models, _) = tobj::load_obj(data("spot.obj"), &options).expect("a mesh");
    let other = &models[0].mesh;
    assert_eq!(3 * mesh.triangles.len(), other.indices.len());
    for (&ours, &theirs) in mesh.triangles.iter().flatten().zip(&other.indices) {
        let (ours, theirs) = (ours as usize, theirs as usize);
        assert_eq!(mesh.positions[ours].to_array(), other.positions[3 * theirs..3 * theirs + 3]);
        let uv = mesh.uvs[0][ours];
        let off = [uv.x - other.texcoords[2 * theirs], 1.0 - uv.y - other.texcoords[2 * theirs + 1]];
        assert!(off.iter().all(|off| off.abs() < 1e-6), "{off:?}");
    }
}

#[test]
fn stl_agrees_with_stl_io() {
    let mesh = merged(&import("odd/Spider_binary.stl"));
    let mut file = std::fs::File::open(data("odd/Spider_binary.stl")).expect("a file");
    let other = stl_io::read_stl(&mut file).expect("a mesh");
    assert_eq!(mesh.triangles.len(), other.faces.len());
    for (index, face) in other.faces.iter().enumerate() {
        let corners = face.vertices.map(|vertex| other.vertices[vertex].0);
        assert_eq!(mesh.corners(index).map(|corner| corner.to_array()), corners, "{index}");
    }
}

#[test]
fn ply_agrees_with_ply_rs() {
    use ply_rs_bw::{
        parser::Parser,
        ply::{DefaultElement, Property},
    };
    let mesh = merged(&import("odd/cube_uv.ply"));
    let mut file = std::fs::File::open(data("odd/cube_uv.ply")).expect("a file");
    let other = Parser::<DefaultElement>::new().read_ply(&mut file).expect("a mesh");
    for (index, vertex) in other.payload["vertex"].iter().enumerate() {
        let float = |name: &str| match vertex[name] {
            Property::Float(value) => value,
            _ => panic!("{name}"),
        };
        assert_eq!(mesh.positions[index], Vec3::new(float("x"), float("y"), float("z")));
        assert_eq!(mesh.uvs[0][index].to_array(), [float("s"), 1.0 - float("t")]);
    }
}

#[test]
fn gltf_agrees_with_gltf() {
    for name in ["suzanne.glb", "TextureSettingsTest.glb", "BoxVertexColors.glb"] {
        let imported = import(name);
        let file = gltf::Gltf::open(data(name)).expect("a file");
        for (mesh, other) in imported.meshes.iter().zip(file.meshes()) {
            let mut corners = mesh.triangles.iter().flatten().map(|&vertex| vertex as usize);
            for primitive in other.primitives() {
                let reader = primitive.reader(|_| file.blob.as_deref());
                let positions: Vec<_> = reader.read_positions().expect("positions").collect();
                let normals: Vec<_> = reader.read_normals().expect("normals").collect();
                let uvs = reader.read_tex_coords(0).map(|uvs| uvs.into_f32().collect::<Vec<_>>());
                for index in reader.read_indices().expect("indices").into_u32().map(|index| index as usize) {
                    let vertex = corners.next().expect("as many corners");
                    assert_eq!(mesh.positions[vertex].to_array(), positions[index], "{name}");
                    assert!(mesh.normals[vertex].distance(Vec3::from(normals[index]).normalize()) < 1e-5, "{name}");
                    assert!(uvs.iter().all(|uvs| mesh.uvs[0][vertex].to_array() == uvs[index]), "{name}");
                }
            }
            assert_eq!(corners.next(), None);
        }
    }
}

#[test]
fn sampler_settings_are_read() {
    let imported = import("TextureSettingsTest.glb");
    let wraps = |name: &str| {
        let material = imported.materials.iter().find(|material| material.name == name).expect(name);
        material.base_colour_texture.as_ref().expect("a texture").wrap
    };
    assert_eq!(wraps("TextureMirrorMaterialT"), [Wrap::Repeat, Wrap::MirroredRepeat]);
    assert_eq!(wraps("TextureRepeatMaterialT"), [Wrap::ClampToEdge, Wrap::Repeat]);
    assert!(imported.materials.iter().any(|material| material.is_double_sided));
    for image in &imported.images {
        assert!(image.decode().expect("an image").width() > 0);
    }
    let along = |wrap: Wrap| [-0.25, 0.25, 1.25, 2.25].map(|u| wrap.apply(u));
    assert_eq!(along(Wrap::Repeat), [0.75, 0.25, 0.25, 0.25]);
    assert_eq!(along(Wrap::MirroredRepeat), [0.25, 0.25, 0.75, 0.25]);
    assert_eq!(along(Wrap::ClampToEdge), [0.0, 0.25, 1.0, 1.0]);
}

/// glTF of one triangle at (0,0,0), (1,0,0), (0,1,0) with unsigned bytes as indices, and further members.
fn triangle_gltf(primitive: &str, node: &str, members: &str) -> String {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAEC";
    format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0] }}],
        "nodes": [{{ "mesh": 0 {node} }}],
        "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "indices": 1 {primitive} }}] }}],
        "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }},
                      {{ "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 36 }}, {{ "buffer": 0, "byteOffset": 36, "byteLength": 3 }}],
        "buffers": [{{ "byteLength": 39, "uri": "data:application/octet-stream;base64,{data}" }}] {members} }}"#
    )
}

#[test]
fn gltf_extensions_are_read() {
    let imported = import("extensions.gltf");
    let material = &imported.materials[0];
    assert_eq!((material.ior, material.transmission, material.specular), (1.33, 0.9, 0.25));
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!(material.emission, Vec3::new(10.0, 5.0, 0.0));
    assert_eq!(material.volume.as_ref().map(|volume| volume.attenuation_distance), Some(2.0));
    assert_eq!(material.clearcoat.as_ref().map(|coat| coat.roughness), Some(0.1));
    assert!(imported.warnings[0].to_string().contains("KHR_materials_sheen is not supported"));
    assert!(matches!(imported.cameras[0].projection, Projection::Perspective { y_fov_radians: 0.7, .. }));
    assert!(matches!(imported.lights[0].kind, LightKind::Spot { outer_cone_radians: 0.5, .. }));
    let child = &imported.nodes[1];
    assert_eq!((child.parent, child.camera, child.light), (Some(0), Some(0), Some(0)));
    assert_eq!(child.world_from_node.translation.x, -2.0);
    // A mirrored node turns its triangles, so that their fronts stay.
    let mesh = merged(&imported);
    let [a, b, c] = mesh.corners(0);
    assert!((b - a).cross(c - a).z > 0.0 && mesh.bounds().min.x == -2.0);
}

#[test]
fn gltf_mistakes_are_refused_by_name() {
    let cases = [
        (triangle_gltf("", "", "").replace("AAEC", "AAkC"), "index 9 is beyond the 3 vertices"),
        (
            triangle_gltf("", "", "")
                .replace("\"count\": 3, \"type\": \"VEC3\"", "\"count\": 400000000, \"type\": \"VEC3\""),
            "accessor 0: 400000000 elements",
        ),
        (
            triangle_gltf("", "", "").replace("\"byteLength\": 36 }", "\"byteLength\": 3600 }"),
            "buffer view 0 is beyond",
        ),
        (
            triangle_gltf("", "", ", \"extensionsRequired\": [\"KHR_draco_mesh_compression\"]"),
            "requires the extension KHR_draco_mesh_compression",
        ),
        (triangle_gltf(", \"material\": 4", "", ""), "material 4 does not exist"),
        (triangle_gltf("", "", "").replace("\"version\": \"2.0\"", "\"version\": \"1.0\""), "version 1.0 is not 2.0"),
        (triangle_gltf(", \"mode\": 1", "", ""), "no triangles"),
        (triangle_gltf("", "", "").replace("data:application/octet-stream;base64,", "../../../etc/"), "cannot be read"),
        (
            triangle_gltf("", "", "").replace("data:application/octet-stream;base64,", "https://example.org/"),
            "is not a relative path",
        ),
        (format!("{{ \"skins\": {}", "[".repeat(100_000)), "recursion limit"),
    ];
    for (text, part) in cases {
        let error = parse(&text, "gltf").expect_err(part).to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn gltf_strips_and_fans_keep_their_orientation() {
    for mode in [5, 6] {
        // A square of four corners as positions, without indices.
        let text = format!(
            r#"{{ "asset": {{ "version": "2.0" }}, "nodes": [{{ "mesh": 0 }}],
            "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "mode": {mode} }}] }}],
            "accessors": [{{ "bufferView": 0, "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3" }}],
            "bufferViews": [{{ "buffer": 0, "byteLength": 16, "byteStride": 4 }}],
            "buffers": [{{ "byteLength": 16, "uri": "data:;base64,{}" }}] }}"#,
            if mode == 5 { "AAAAAH8AAAAAfwAAf38AAA==" } else { "AAAAAH8AAAB/fwAAAH8AAA==" }
        );
        let mesh = merged(&parse(&text, "gltf").unwrap_or_else(|error| panic!("{error}")));
        assert_eq!(mesh.triangles.len(), 2);
        for triangle in 0..2 {
            let [a, b, c] = mesh.corners(triangle);
            assert_eq!((b - a).cross(c - a), Vec3::Z, "mode {mode}");
        }
    }
}

#[test]
fn shared_vertices_are_bounded() {
    // Ten thousand primitives that name the same three vertices, which is fine, and one mesh that names them a million times.
    let text = triangle_gltf("", "", "");
    let primitive = r#"{ "attributes": { "POSITION": 0 } },"#;
    let many = text.replace("\"primitives\": [", &format!("\"primitives\": [{}", primitive.repeat(10_000)));
    assert_eq!(merged(&parse(&many, "gltf").expect("a mesh")).triangles.len(), 10_001);
    let zeros = r#""accessors": [{ "componentType": 5126, "count": 1000000000, "type": "VEC3" }, "#;
    let many = text.replace("\"accessors\": [", zeros).replace(", \"indices\": 1", "");
    let error = parse(&many, "gltf").expect_err("too many vertices").to_string();
    assert!(error.contains("far more than the file has bytes for"), "{error}");
}

#[test]
fn shared_images_are_bounded() {
    let view = r#""images": [{ "bufferView": 0 }, { "bufferView": 0 }, { "bufferView": 0 }], "buffers""#;
    let imported = parse(&triangle_gltf("", "", "").replace("\"buffers\"", view), "gltf").expect("a mesh");
    let messages: Vec<_> = imported.warnings.iter().map(ToString::to_string).collect();
    assert!(messages[0].contains("image 0: the image is neither PNG nor JPEG"), "{messages:?}");
    assert!(messages[1].contains("image 1: the buffer views of images overlap"), "{messages:?}");
}

#[test]
fn texture_transforms_scale_then_rotate_then_move() {
    let quarter = std::f32::consts::FRAC_PI_2;
    let transform = TextureTransform { offset: [1.0, 0.0].into(), rotation_radians: quarter, scale: [2.0, 1.0].into() };
    let moved = transform.matrix().transform_point2([1.0, 0.0].into());
    assert!(moved.distance([1.0, -2.0].into()) < 1e-6, "{moved}");
}

#[test]
fn obj_materials_are_translated() {
    let directory = tempfile::tempdir().expect("a directory");
    let library = "newmtl red glass\nKd 0.8 0.1 0.1\nd 0.25\nNs 98\nNi 1.45\nmap_Kd missing.png\nnewmtl lamp\nKe 2 2 1\nPr 0.3\nPm 1";
    std::fs::write(directory.path().join("some colours.mtl"), library).expect("written");
    let text = "mtllib some colours.mtl\nv 0 0 0\nv 1 0 0 0 0 1\nv 0 1 0\nusemtl red glass\nf 1 2 3\nusemtl lamp\nf -3 -2 -1\n";
    let path = directory.path().join("mesh.obj");
    std::fs::write(&path, text).expect("written");
    let imported = read(&path, &ReadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    let [glass, lamp] = imported.materials.as_slice() else { panic!("{:?}", imported.materials) };
    assert_eq!((glass.base_colour, glass.alpha, glass.ior), (Vec3::new(0.8, 0.1, 0.1), 0.25, 1.45));
    assert!((glass.roughness - 0.02_f32.powf(0.25)).abs() < 1e-6);
    assert_eq!((lamp.emission, lamp.roughness, lamp.metallic), (Vec3::new(2.0, 2.0, 1.0), 0.3, 1.0));
    assert_eq!(imported.meshes[0].materials, [0, 1]);
    assert_eq!(imported.meshes[0].colours[1].to_array(), [0.0, 0.0, 1.0, 1.0]);
    assert!(imported.warnings.iter().any(|warning| warning.message.contains("missing.png")));
}

#[test]
fn concave_polygons_are_not_folded() {
    let mesh = merged(&import("odd/concave_polygon.obj"));
    let normal = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        (b - a).cross(c - a)
    };
    // All triangles face one way, so that their areas add up to that of the polygon.
    assert!((0..mesh.triangles.len()).all(|triangle| normal(triangle).x >= 0.0));
}

#[test]
fn declared_sizes_are_not_believed() {
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    assert!(parse(ply, "ply").expect_err("too short").to_string().contains("4000000000 elements"));
    let ply = "ply\nformat ascii 1.0\nelement nothing 9000000000000000000\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    assert!(parse(ply, "ply").expect_err("no faces").to_string().contains("no faces"));
    let mut stl = vec![0; 84];
    stl[80..].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = read_bytes(&stl, "stl", Path::new("mesh.stl"), &ReadOptions::default()).expect_err("too short");
    assert!(error.to_string().contains("4294967295 triangles are declared, but there is room for 0"), "{error}");
}

#[test]
fn paths_are_checked() {
    let options = ReadOptions { max_file_bytes: 100 };
    assert!(matches!(read(&data("spot.obj"), &options), Err(ReadError::TooLarge { limit: 100, .. })));
    assert!(matches!(read(Path::new("mesh.fbx"), &options), Err(ReadError::UnknownExtension { .. })));
    assert!(matches!(read(Path::new("nowhere.obj"), &options), Err(ReadError::Open { .. })));
    let directory = tempfile::tempdir().expect("a directory");
    std::fs::create_dir(directory.path().join("mesh.obj")).expect("a directory");
    let error = read(&directory.path().join("mesh.obj"), &options).expect_err("no file").to_string();
    assert!(error.contains("not a regular file"), "{error}");
}

#[test]
fn instances_are_merged_within_a_limit() {
    let imported = import("TextureSettingsTest.glb");
    assert_eq!(merged(&imported).triangles.len(), 72);
    assert_eq!(
        imported.merged(71).expect_err("a limit").to_string().split(';').next(),
        Some("the nodes place 72 triangles, more than 71")
    );
}
