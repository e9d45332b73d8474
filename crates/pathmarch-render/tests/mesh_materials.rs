//! Materials of glTF files against values in closed form, on both backends.

use crate::common::{cpu, on_each_backend, parse, render};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{some_of, tests};
use std::path::Path;

/// Corners of a square of edge 2 in the plane z = 0: lower left, lower right, upper right, upper left.
const CORNERS: [[f32; 3]; 4] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
/// Base colour without specular reflection.
const MATTE: &str = r#""extensions": { "KHR_materials_ior": { "ior": 1.0 } }"#;

/// Square as glTF.
struct Square<'a> {
    /// Its material.
    material: &'a str,
    /// RGBA of each corner.
    colour: [f32; 4],
    /// Rows of its picture, texture 0 with the sampler's filter.
    picture: (u32, &'a [[u8; 4]]),
    /// Corners of its triangles are clockwise.
    is_flipped: bool,
}

impl Default for Square<'_> {
    fn default() -> Self {
        Self { material: "", colour: [1.0; 4], picture: (1, &[[255; 4]]), is_flipped: false }
    }
}

impl Square<'_> {
    /// Mean radiance of the middle of the square, seen from the front.
    fn radiance(&self, renderer: &Renderer, lights: &str) -> [f32; 3] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        self.write(folder.path());
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 3; target 0 0 0; fov 20 }}\n{lights}\n\
             object \"square\" {{ mesh \"{}\" }}",
            folder.path().join("square.gltf").display()
        ));
        let settings = Settings { size: [16, 16], samples: 256, ..Settings::of(&scene) };
        let film = render(renderer, &scene, &settings).mean();
        let sum = film.pixels.iter().fold([0.0; 3], |sum, pixel| std::array::from_fn(|k| sum[k] + pixel[k]));
        sum.map(|sum| sum / film.pixels.len() as f32)
    }

    fn write(&self, folder: &Path) {
        let uvs = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let indices: [u32; 6] = if self.is_flipped { [0, 2, 1, 0, 3, 2] } else { [0, 1, 2, 0, 2, 3] };
        let mut bytes: Vec<u8> = CORNERS.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        bytes.extend(uvs.as_flattened().iter().flat_map(|v: &f32| v.to_le_bytes()));
        bytes.extend([self.colour; 4].as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(indices.iter().flat_map(|v| v.to_le_bytes()));
        std::fs::write(folder.join("square.bin"), &bytes).expect("a writable folder");
        let (width, texels) = self.picture;
        let picture = image::RgbaImage::from_fn(width, texels.len() as u32 / width, |x, y| {
            image::Rgba(texels[(y * width + x) as usize])
        });
        picture.save(folder.join("square.png")).expect("a writable folder");
        let json = format!(
            r#"{{ "asset": {{ "version": "2.0" }}, "scenes": [{{ "nodes": [0] }}], "nodes": [{{ "mesh": 0 }}],
            "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2 }},
                "indices": 3, "material": 0 }}] }}],
            "materials": [{{ {} }}],
            "textures": [{{ "source": 0, "sampler": 0 }}], "images": [{{ "uri": "square.png" }}],
            "samplers": [{{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33071 }}],
            "buffers": [{{ "uri": "square.bin", "byteLength": {} }}],
            "bufferViews": [{{ "buffer": 0, "byteOffset": 0, "byteLength": 48 }},
                {{ "buffer": 0, "byteOffset": 48, "byteLength": 32 }},
                {{ "buffer": 0, "byteOffset": 80, "byteLength": 64 }},
                {{ "buffer": 0, "byteOffset": 144, "byteLength": 24 }}],
            "accessors": [
                {{ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                    "min": [-1, -1, 0], "max": [1, 1, 0] }},
                {{ "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" }},
                {{ "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC4" }},
                {{ "bufferView": 3, "componentType": 5125, "count": 6, "type": "SCALAR" }}] }}"#,
            self.material,
            bytes.len()
        );
        std::fs::write(folder.join("square.gltf"), json).expect("a writable folder");
    }
}

fn assert_close(name: &str, found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let error = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("{name}: {found:?}, expected {expected:?}");
    assert!(error < tolerance, "{name}: {found:?} is not {expected:?}");
}

fn blended_alpha_is_the_share_of_light_that_a_surface_takes(renderer: &Renderer) {
    let material = format!(
        r#""alphaMode": "BLEND", "doubleSided": true, {MATTE},
           "pbrMetallicRoughness": {{ "baseColorFactor": [0, 0, 0, 0.5], "metallicFactor": 0 }}"#
    );
    let square = Square { material: &material, colour: [1.0, 1.0, 1.0, 0.5], ..Square::default() };
    assert_close("blend", square.radiance(renderer, "sky 1"), [0.75; 3], 0.01);
}

fn masked_alpha_cuts_a_surface_out(renderer: &Renderer) {
    let material = format!(
        r#""alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true, {MATTE},
           "pbrMetallicRoughness": {{ "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0,
               "baseColorTexture": {{ "index": 0 }} }}"#
    );
    // A quarter of the picture is above the cutoff.
    let texels = [[255, 255, 255, 101], [255, 255, 255, 103], [255, 255, 255, 0], [255, 255, 255, 60]];
    let square = Square { material: &material, picture: (2, &texels), ..Square::default() };
    assert_close("mask", square.radiance(renderer, "sky 1"), [0.75; 3], 0.01);
}

fn vertex_colours_multiply_the_base_colour(renderer: &Renderer) {
    let material = format!(
        r#""doubleSided": true, {MATTE},
           "pbrMetallicRoughness": {{ "baseColorFactor": [0.5, 1, 1, 1], "metallicFactor": 0 }}"#
    );
    let square = Square { material: &material, colour: [0.4, 0.5, 0.8, 1.0], ..Square::default() };
    assert_close("colours", square.radiance(renderer, "sky 1"), [0.2, 0.5, 0.8], 0.005);
}

fn the_back_of_a_single_sided_surface_is_not_there(renderer: &Renderer) {
    let base = format!(
        r#"{MATTE}, "pbrMetallicRoughness": {{ "baseColorFactor": [0.25, 0.25, 0.25, 1], "metallicFactor": 0 }}"#
    );
    for (sides, is_flipped, expected) in [("false", false, 0.25), ("false", true, 1.0), ("true", true, 0.25)] {
        let material = format!(r#""doubleSided": {sides}, {base}"#);
        let square = Square { material: &material, is_flipped, ..Square::default() };
        assert_close("sides", square.radiance(renderer, "sky 1"), [expected; 3], 0.005);
    }
}

fn green_of_a_normal_map_points_up_and_red_to_the_right(renderer: &Renderer) {
    let material = format!(
        r#""doubleSided": true, {MATTE}, "normalTexture": {{ "index": 0 }},
           "pbrMetallicRoughness": {{ "metallicFactor": 0 }}"#
    );
    // Normals tilted by 30 degrees to the right, and up.
    let code = |v: f32| ((0.5 + 0.5 * v) * 255.0).round() as u8;
    let (tilt, along) = (code(0.5), code(0.75f32.sqrt()));
    for (texel, sun) in [([tilt, 128, along, 255], "0.5 0 0.8660254"), ([128, tilt, along, 255], "0 0.5 0.8660254")] {
        let square = Square { material: &material, picture: (1, &[texel]), ..Square::default() };
        let lights = format!("sun {{ direction {sun}; irradiance 3.1415927; angle 0 }}");
        assert_close("normal map", square.radiance(renderer, &lights), [1.0; 3], 0.01);
        let opposite = format!("sun {{ direction -{sun}; irradiance 3.1415927; angle 0 }}").replace("-0 0.5", "0 -0.5");
        assert_close("away", square.radiance(renderer, &opposite), [0.5; 3], 0.02);
    }
}

fn emission_is_the_factor_times_strength_and_texture(renderer: &Renderer) {
    let material = r#""doubleSided": true, "emissiveFactor": [1, 0.5, 0.25], "emissiveTexture": { "index": 0 },
           "extensions": { "KHR_materials_ior": { "ior": 1.0 }, "KHR_materials_emissive_strength": { "emissiveStrength": 4 } },
           "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 }"#;
    // sRGB 188 is 0.5029.
    let square = Square { material, picture: (1, &[[188, 188, 188, 255]]), ..Square::default() };
    let light = 4.0 * 0.5029;
    assert_close(
        "emission",
        square.radiance(renderer, "sky 1"),
        [light + 0.5, 0.5 * light + 0.5, 0.25 * light + 0.5],
        0.01,
    );
}

/// A mesh of cubes of this half edge around these points, as OBJ.
fn cubes(centres: &[[f32; 3]], radius: f32) -> String {
    use std::fmt::Write;
    const FACES: [[usize; 4]; 6] = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let mut text = String::new();
    for (cube, [x, y, z]) in centres.iter().enumerate() {
        for corner in 0..8 {
            let side = |bit: usize| if corner >> bit & 1 == 1 { radius } else { -radius };
            let _ = writeln!(text, "v {} {} {}", x + side(2), y + side(1), z + side(0));
        }
        for [a, b, c, d] in FACES.map(|face| face.map(|corner| 8 * cube + corner + 1)) {
            let _ = writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    text
}

/// Many lamps of one mesh are as many lights. As one light they have seven times the noise. Boxes are less noisy than theirs
/// because no points on hidden faces are sampled.
fn lamps_of_a_mesh_are_chosen_by_place(renderer: &Renderer) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("lamps.obj");
    let centres: Vec<[f32; 3]> = (0..64).map(|k| [(k % 8) as f32 - 3.5, 0.6, (k / 8) as f32 - 3.5]).collect();
    std::fs::write(&file, cubes(&centres, 0.05)).expect("is written");
    let mesh = format!("object \"lamps\" material=\"lamp\" {{ mesh \"{}\" }}", file.display());
    let boxes = centres.iter().enumerate().map(|(k, [x, y, z])| {
        format!("object \"lamp {k}\" material=\"lamp\" {{ box 0.1 0.1 0.1 {{ at {x} {y} {z} }} }}\n")
    });
    let [by_mesh, by_boxes] = [mesh, boxes.collect()].map(|lamps| {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0.55 1.5; target 0 0 0.6; fov 40 }}\nmaterial \"white\" {{ diffuse 0.7 }}\n\
             material \"lamp\" {{ emit 9 }}\nobject \"floor\" material=\"white\" {{ plane }}\n{lamps}"
        ));
        [1, 2].map(|seed| {
            let settings = Settings { size: [64, 48], samples: 16, seed, ..Settings::of(&scene) };
            render(renderer, &scene, &settings).mean()
        })
    });
    let noise = |[a, b]: &[Picture; 2]| relmse(a, b).expect("equal sizes");
    let (mesh, boxes) = (noise(&by_mesh), noise(&by_boxes));
    println!("{}: relMSE between seeds {mesh:.2e} by a mesh, {boxes:.2e} by boxes", renderer.backend().name);
    assert!(mesh < 8.0 * boxes, "{mesh} {boxes}");
    let mean = |[a, b]: &[Picture; 2]| mean_colour(a)[1] + mean_colour(b)[1];
    assert!((mean(&by_mesh) / mean(&by_boxes) - 1.0).abs() < 0.01, "{} {}", mean(&by_mesh), mean(&by_boxes));
}

/// A floor lit by a mesh: light sampling, BSDF sampling and both agree.
fn emitting_triangles_are_sampled_as_rays_find_them(renderer: &Renderer) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let spot = Path::new(env!("CARGO_MANIFEST_DIR")).join("../pathmarch-mesh/tests/data/spot.obj");
    let emission = r#""emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 }, "extensions":
           { "KHR_materials_ior": { "ior": 1.0 }, "KHR_materials_emissive_strength": { "emissiveStrength": 9 } },
           "pbrMetallicRoughness": { "baseColorFactor": [0.2, 0.2, 0.2, 1], "metallicFactor": 0 }"#;
    // Half of the picture emits.
    let texels = [[255, 255, 255, 255], [0, 0, 0, 255]];
    Square { material: emission, picture: (2, &texels), ..Square::default() }.write(folder.path());
    let lamps = [
        format!("object \"cow\" material=\"lamp\" {{ mesh \"{}\" {{ scale 0.7; at 0 0.9 0 }} }}", spot.display()),
        format!(
            "object \"square\" {{ mesh \"{}\" {{ rotate 60 30 0; scale 0.5; at 0 0.6 0 }} }}",
            folder.path().join("square.gltf").display()
        ),
    ];
    // Two groups of cubes and a far one.
    let centres = [[-0.9, 0.9, 0.1], [-0.8, 0.3, 0.2], [0.8, 0.4, -0.3], [0.9, 0.9, -0.2], [0.1, 0.5, -2.0]];
    std::fs::write(folder.path().join("cubes.obj"), cubes(&centres, 0.08)).expect("is written");
    let cubes = format!(
        "object \"cubes\" material=\"lamp\" {{ mesh \"{}\" {{ rotate 10 40 0; scale 1.2; at 0 0.1 0.2 }} }}",
        folder.path().join("cubes.obj").display()
    );
    for lamp in some_of(lamps.into_iter().chain([cubes]), 2) {
        let render_with = |renderer: &Renderer, estimator: &str, samples: u32| {
            let scene = parse(&format!(
                "pathmarch 1\ncamera {{ position 0 3 1.5; target 0 0 0; fov 50 }}\nrender {{ estimator \"{estimator}\" }}\n\
                 material \"white\" {{ diffuse 0.7 }}\nmaterial \"lamp\" {{ emit 5 }}\n\
                 object \"floor\" material=\"white\" {{ plane }}\n{lamp}"
            ));
            let settings = Settings { size: [32, 24], samples, ..Settings::of(&scene) };
            render(renderer, &scene, &settings).mean()
        };
        let reference = render_with(&cpu(), "bsdf", 4096);
        for (estimator, samples, limit) in [("mis", 512, 2e-3), ("light", 512, 4e-3)] {
            let film = render_with(renderer, estimator, samples);
            let error = relmse(&film, &reference).expect("equal sizes");
            let mean = |film: &Picture| film.pixels.iter().map(|pixel| pixel[1]).sum::<f32>();
            let ratio = mean(&film) / mean(&reference);
            println!("{estimator} {}: relMSE {error:.2e}, mean {ratio:.4}", renderer.backend().name);
            assert!(error < limit && (ratio - 1.0).abs() < 0.005, "{estimator}: {error}, {ratio}");
        }
    }
}

tests! {
    on_each_backend slow: [
        blended_alpha_is_the_share_of_light_that_a_surface_takes,
        masked_alpha_cuts_a_surface_out,
        vertex_colours_multiply_the_base_colour,
        the_back_of_a_single_sided_surface_is_not_there,
        green_of_a_normal_map_points_up_and_red_to_the_right,
        emission_is_the_factor_times_strength_and_texture,
        emitting_triangles_are_sampled_as_rays_find_them,
        lamps_of_a_mesh_are_chosen_by_place,
    ],
}
