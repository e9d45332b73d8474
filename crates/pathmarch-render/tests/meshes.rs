//! Meshes in scenes: triangles and distance fields, on both backends.

use crate::common::{cpu, on_each_backend, parse, render};
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Mode, Renderer, Settings};
use pathmarch_testing::tests;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Mesh among the files of the tests of `pathmarch-mesh`.
fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../pathmarch-mesh/tests/data").join(name)
}

/// Writes a box of these edges, centred at the origin, as 12 triangles.
fn write_box(path: &Path, edges: [f32; 3]) {
    let mut text = String::new();
    for corner in 0..8 {
        let side = |axis: usize| edges[axis] * if corner >> axis & 1 == 1 { 0.5 } else { -0.5 };
        writeln!(text, "v {} {} {}", side(0), side(1), side(2)).expect("writing to a string");
    }
    for face in ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"] {
        writeln!(text, "f {face}").expect("writing to a string");
    }
    std::fs::write(path, text).expect("a writable folder");
}

/// Scene of two boxes, one of them clear, among shapes that they are reflected in. `solid` is the first box.
fn boxes(solid: &str, clear: &str) -> Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position 1 1.6 3.4; target 0 0.5 0; fov 40 }}\nsky 0.5 0.6 0.8\n\
         sun {{ direction 0.5 0.8 0.6; irradiance 3; angle 3 }}\nmaterial \"grey\" {{ diffuse 0.6 0.5 0.4 }}\n\
         material \"gold\" {{ metal 1 0.8 0.4; roughness 0.2 }}\nmaterial \"glass\" {{ glass 1; absorb 1 0.3 0.2 }}\n\
         object \"floor\" material=\"grey\" {{ plane }}\n\
         object \"blend\" material=\"gold\" {{ union smooth=0.1 {{ sphere 0.3 {{ at -1 0.3 0.6 }}; box 0.4 {{ at -0.7 0.2 0.6 }} }} }}\n\
         object \"solid\" material=\"grey\" {{ {solid} {{ rotate 0 30 10; scale 1.5; at -0.2 0.8 -0.4 }} }}\n\
         object \"clear\" material=\"glass\" {{ {clear} {{ rotate 20 10 0; at 0.7 0.6 0.4 }} }}"
    ))
}

fn a_box_of_triangles_looks_like_a_box(renderer: &Renderer) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let paths = [folder.path().join("solid.obj"), folder.path().join("clear.obj")];
    write_box(&paths[0], [0.6, 0.5, 0.4]);
    write_box(&paths[1], [0.5, 0.7, 0.3]);
    let shapes = boxes("box 0.6 0.5 0.4", "box 0.5 0.7 0.3");
    let meshes = boxes(&format!("mesh \"{}\"", paths[0].display()), &format!("mesh \"{}\"", paths[1].display()));
    for mode in [Mode::Path, Mode::Normal, Mode::Depth, Mode::Albedo] {
        let settings = Settings { size: [96, 54], samples: 16, mode, ..Settings::of(&shapes) };
        let reference = render(&cpu(), &shapes, &settings).mean();
        let error = relmse(&render(renderer, &meshes, &settings).mean(), &reference).expect("equal sizes");
        println!("{mode:?} {}: relMSE {error:.2e}", renderer.backend().name);
        assert!(error < 1e-5, "{mode:?} {}: {error}", renderer.backend().name);
    }
}

/// Scene of meshes as triangles and in fields, with copies and several sizes.
fn melting() -> Scene {
    let (spot, suzanne) = (model("spot.obj"), model("suzanne.glb"));
    let (spot, suzanne) = (spot.display(), suzanne.display());
    parse(&format!(
        "pathmarch 1\ncamera {{ position 0.4 1.4 4.2; target 0 0.7 0; fov 40 }}\nsky 0.5 0.6 0.8\n\
         sun {{ direction 0.5 0.8 0.6; irradiance 3; angle 2 }}\nmaterial \"white\" {{ diffuse 0.7 }}\n\
         material \"red\" {{ principled 0.7 0.1 0.05; roughness 0.4 }}\nmaterial \"glass\" {{ glass 1; ior 1.4 }}\n\
         object \"floor\" material=\"white\" {{ plane }}\n\
         object \"cow\" material=\"white\" {{ mesh \"{spot}\" {{ at -1.2 0.73 0; rotate 0 160 0 }} }}\n\
         object \"calf\" material=\"glass\" {{ mesh \"{spot}\" {{ scale 0.4; at 0.1 0.3 1.3; rotate 0 200 0 }} }}\n\
         object \"melted\" {{ union smooth=0.2 {{\n\
         mesh \"{suzanne}\" as=\"field\" resolution=64 material=\"red\" {{ scale 0.6; at 0.6 0.9 0 }}\n\
         shell 0.05 {{ twist 0.2 {{ mesh \"{spot}\" as=\"field\" resolution=64 material=\"white\" {{ scale 0.6; at 0 0.45 0 }} }}; at 1.4 0 0.2 }}\n\
         }} }}"
    ))
}

fn both_backends_show_meshes_alike(renderer: &Renderer) {
    let scene = melting();
    for (mode, limit) in [(Mode::Path, 1e-4), (Mode::Preview, 1e-5), (Mode::Normal, 1e-5)] {
        let settings = Settings { size: [64, 36], samples: 8, mode, ..Settings::of(&scene) };
        let reference = render(&cpu(), &scene, &settings).mean();
        let error = relmse(&render(renderer, &scene, &settings).mean(), &reference).expect("equal sizes");
        println!("{mode:?} {}: relMSE {error:.2e} to the CPU backend", renderer.backend().name);
        assert!(error < limit, "{mode:?} {}: {error}", renderer.backend().name);
    }
}

/// A cow on the ground; `form` is that of its mesh.
fn cow(form: &str, material: &str) -> Scene {
    let spot = model("spot.obj");
    parse(&format!(
        "pathmarch 1\ncamera {{ position 0.6 1.2 -3; target 0 0 0; fov 40 }}\nsky 0.5 0.6 0.8\n\
         sun {{ direction 0.5 0.8 -0.6; irradiance 3; angle 40 }}\nmaterial \"cow\" {{ {material} }}\n\
         object \"floor\" {{ plane {{ at 0 -0.75 0 }} }}\n\
         object \"blend\" {{ union smooth=0.1 {{ sphere 0.3 {{ at -1 -0.45 0.6 }}; box 0.4 {{ at -0.7 -0.5 0.6 }} }} }}\n\
         object \"cow\" material=\"cow\" {{ mesh \"{}\" {form} }}",
        spot.display()
    ))
}

/// The camera sees the triangles, and light the field.
fn triangles_are_lit_by_their_field(renderer: &Renderer) {
    const LIT: &str = "as=\"lit-by-field\" resolution=192";
    for material in ["diffuse 0.7 0.5 0.4", "principled 0.8; roughness 0.3", "glass 1"] {
        let [triangles, lit] = ["", LIT].map(|form| cow(form, material));
        let difference = |mode, samples| {
            let settings = Settings { size: [96, 54], samples, mode, ..Settings::of(&lit) };
            let [a, b] = [&triangles, &lit].map(|scene| render(renderer, scene, &settings).mean());
            let of_cpu = render(&cpu(), &lit, &settings).mean();
            (relmse(&b, &a).expect("one size"), relmse(&b, &of_cpu).expect("one size"))
        };
        // The slope of the field shortens the steps towards the blended object.
        let (normals, _) = difference(Mode::Normal, 4);
        assert!(normals < 2e-4, "{material}: {normals}");
        let (light, backends) = difference(Mode::Path, 64);
        println!("{material} {}: relMSE {light:.2e}, {backends:.2e} to the CPU backend", renderer.backend().name);
        // Paths through glass are others from the first refraction on.
        let limit = if material.starts_with("glass") { 0.1 } else { 5e-3 };
        assert!(light > 1e-6 && light < limit && backends < 1e-4, "{material}: {light}, {backends}");
    }
}

fn no_ray_leaves_a_closed_mesh(renderer: &Renderer) {
    // Black inside, bright outside, so that each ray that finds a crack is a bright sample.
    let spot = model("spot.obj");
    for target in ["0 0 0", "0.3 0.4 -0.8"] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 0.1; target {target}; fov 150 }}\nrender {{ bounces 0 }}\nsky 1000\n\
             material \"black\" {{ diffuse 0 }}\nobject \"cow\" material=\"black\" {{ mesh \"{}\" }}",
            spot.display()
        ));
        let settings = Settings { size: [320, 180], samples: 4, ..Settings::of(&scene) };
        let film = render(renderer, &scene, &settings).mean();
        let lost = film.pixels.iter().filter(|pixel| pixel.iter().any(|&v| v > 0.0)).count();
        assert_eq!(lost, 0, "{}: rays were lost", renderer.backend().name);
    }
}

tests! {
    on_each_backend slow: [
        a_box_of_triangles_looks_like_a_box,
        both_backends_show_meshes_alike,
        triangles_are_lit_by_their_field,
        no_ray_leaves_a_closed_mesh,
    ],
}
