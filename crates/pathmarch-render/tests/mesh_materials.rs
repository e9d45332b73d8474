//! Materials of glTF files against values in closed form, on both backends.

use crate::common::{on_each_backend, parse, render};
use pathmarch_render::metrics::relmse;
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::tests;
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
    for lamp in lamps {
        let render_with = |estimator: &str, samples: u32| {
            let scene = parse(&format!(
                "pathmarch 1\ncamera {{ position 0 3 1.5; target 0 0 0; fov 50 }}\nrender {{ estimator \"{estimator}\" }}\n\
                 material \"white\" {{ diffuse 0.7 }}\nmaterial \"lamp\" {{ emit 5 }}\n\
                 object \"floor\" material=\"white\" {{ plane }}\n{lamp}"
            ));
            let settings = Settings { size: [32, 24], samples, ..Settings::of(&scene) };
            render(renderer, &scene, &settings).mean()
        };
        let reference = render_with("bsdf", 4096);
        for (estimator, samples, limit) in [("mis", 512, 2e-3), ("light", 512, 4e-3)] {
            let film = render_with(estimator, samples);
            let error = relmse(&film, &reference).expect("equal sizes");
            let mean = |film: &pathmarch_render::image::Picture| film.pixels.iter().map(|pixel| pixel[1]).sum::<f32>();
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
    ],
}
