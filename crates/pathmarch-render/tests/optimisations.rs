//! Optimisations do not change pictures: comparisons with and without them, on both backends.

use crate::common::{for_each_backend, parse, scenes, with_gpu};
use pathmarch_render::film::Film;
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::pathmarch_field::Field;
use pathmarch_render::pathmarch_field::number::Vec3;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::testing::{Device, Picture};
use pathmarch_render::{Backend, Settings};
use pathmarch_testing::tests;

fn pictures_do_not_depend_on_the_kind_of_memory() {
    let few = r#"pathmarch 1
camera "main" { position 0 1 4; target 0 0.5 0; fov 40 }
sky 0.2 0.3 0.4
point { at 1 3 2; intensity 20 }
material "red" { diffuse 0.8 0.1 0.1 }
material "glass" { glass 1; ior 1.5 }
material "lamp" { emit 4 }
object "floor" material="red" { plane }
object "ball" material="glass" { torus 0.4 0.15 { at 0 0.3 0 } }
object "lamp" material="lamp" { sphere 0.2 { at 0.6 1 -0.5 } }
"#;
    // A hierarchy, and textures.
    let ball = |k: i32| format!("object \"ball {k}\" {{ sphere 0.05 {{ at {} 0.05 {} }} }}\n", k % 8 - 4, k / 8 - 5);
    let many = few
        .replace("torus 0.4 0.15", "sphere 0.4")
        .replace("diffuse 0.8 0.1 0.1", "diffuse { checker size=0.3 { colour 0.8; colour 0.1 } }")
        + &(0..60).map(ball).collect::<String>();
    for text in [few, &many] {
        let scene = parse(text);
        let picture = Picture::new(&scene, &Settings { size: [24, 16], ..Settings::of(&scene) });
        let devices = [Device::open_as("software"), Device::open_as("discrete GPU"), Device::open_without_textures()];
        let [a, others @ ..] = devices.map(|device| {
            let device = device.expect("a GPU adapter");
            let uniform = device.has_uniform_frame_and_leaves(&picture);
            assert_eq!(uniform, [!device.is_software(), device.is_software()]);
            picture.on_gpu(&device, 2).expect("renders").sums
        });
        assert!(a.iter().flatten().sum::<f32>() > 0.0);
        for b in others {
            let difference = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs());
            assert!(difference.fold(0.0, f32::max) < 1e-3, "{text}");
        }
    }
}

fn pictures_do_not_depend_on_constant_numbers() {
    let device = Device::open_as("software").expect("a GPU adapter");
    // Sphere-traced shapes with suns and a sky, a closed room, and shapes along the axes of the world.
    let room = scenes().into_iter().find(|path| path.ends_with("closed-emitting-room.kdl")).expect("there");
    for scene in [parse(THIN), Scene::load(&room).expect("a valid scene"), parse(ALONG_AXES)] {
        let settings = Settings { size: [48, 28], bounces: 3, ..Settings::of(&scene) };
        // Enough that single samples do not count whose path is decided by rounding.
        let render = |picture: Picture| picture.on_gpu(&device, 64).expect("renders").mean();
        let plain = render(Picture::new(&scene, &settings));
        let constant = render(Picture::new(&scene, &settings).with_constant_numbers());
        let error = relmse(&constant, &plain).expect("equal sizes");
        assert!(mean_colour(&plain)[1] > 0.01 && error < 1e-5, "{error:.2e}");
    }
}

/// Wires of a few millimetres, a thin shell and a needle between large shapes, which long steps could miss.
const THIN: &str = r#"pathmarch 1
camera "main" { position 0.4 1.3 4; target 0 0.55 0; fov 36 }
sky 0.7 0.8 1
sun { direction 1 2 1.5; irradiance 2.5; angle 3 }
material "grey" { diffuse 0.6 }
material "red" { diffuse 0.8 0.2 0.1 }
object "floor" material="grey" { plane }
object "wires" material="red" {
    union smooth=0.002 {
        capsule 0.004 1.4 { at -0.9 0.8 0.3 }
        capsule 0.004 1.4 { at -0.7 0.8 0.3; rotate 0 0 8 }
        capsule 0.004 1.4 { at -0.5 0.8 0.3; rotate 12 0 -8 }
    }
}
object "shell" material="grey" { subtract smooth=0.004 { sphere 0.5 { at 0.9 0.6 -0.2 }; sphere 0.494 { at 0.9 0.6 -0.2 }; box 1 0.5 1 { at 0.9 1.05 0 } } }
object "cut" material="grey" { subtract { box 0.5 0.5 0.5; sphere 0.3; cylinder 0.12 2 { rotate 90 0 0 }; at 0.1 0.25 0.6 } }
object "needle" material="red" { cone 0.01 1.2 { at -0.15 0.6 0.7 } }
"#;

/// Shapes turned by right angles, of several sizes and materials.
const ALONG_AXES: &str = r#"pathmarch 1
camera "main" { position 0.4 1.3 4; target 0 0.6 0; fov 40 }
sky 0.3 0.4 0.5
point { at 1 3 2; intensity 20 }
material "tiles" { diffuse { checker size=0.3 { colour 0.8 0.7 0.6; colour 0.2 0.3 0.2 } } }
material "glass" { glass 0.9 1 0.9; ior 1.5; roughness 0.2 }
material "metal" { metal 0.9 0.6 0.3; roughness 0.3 }
material "plastic" { principled 0.1 0.3 0.8; roughness 0.4 }
material "lamp" { emit 3 }
object "floor" material="tiles" { rect 5 4 { rotate 0 90 0 } }
object "back" material="plastic" { rect 3 2 { normal 0 0 1; at 0 1 -1.5 } }
object "side" material="metal" { disc 0.5 { normal -1 0 0; scale 1.5; at 1.4 0.8 0 } }
object "roof" material="lamp" { rect 1 0.5 { normal 0 -1 0; at 0 2.2 0 } }
object "prism" material="glass" { cylinder 0.3 0.5 { rotate 90 0 90; scale 1.2; at -0.7 0.4 0.5 } }
object "ball" material="metal" { sphere 0.3 { rotate 0 0 -90; at 0.3 0.3 0.8 } }
object "cut" material="plastic" { subtract { box 0.4 0.6 0.5; cylinder 0.12 2 { rotate 90 0 0 }; rotate 0 180 0; at 0.9 0.3 -0.6 } }
object "ring" material="glass" { torus 0.3 0.08 { rotate 0 0 90; at -1 0.9 -0.6 } }
"#;

/// Compares pictures with optimisations, rendered by `render`, with a reference without.
fn compare_optimisations(backend: &str, render: impl Fn(&Picture, u32) -> Film) {
    let scene = parse(THIN);
    let roots: Vec<_> = scene.objects.iter().map(|object| object.root.clone()).collect();
    let sphere_traced = Scene { field: Field::all_sphere_traced(&roots), ..scene.clone() };
    assert!(sphere_traced.field.analytic_hit::<f32>(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, -1.0, 0.0)).1 < 0.0);
    const SAMPLES: u32 = 256;
    let settings = Settings { size: [80, 45], samples: SAMPLES, bounces: 2, detail: 0.005, ..Settings::of(&scene) };
    let reference = Picture::new(&sphere_traced, &settings).without_relaxation().on_cpu(SAMPLES).mean();
    let relaxed = Picture::new(&sphere_traced, &settings);
    let whole = Picture::new(&scene, &settings);
    for (name, picture) in [("long steps", &relaxed), ("long steps and analytic hits", &whole)] {
        let error = relmse(&render(picture, SAMPLES).mean(), &reference).expect("equal sizes");
        println!("{name} on {backend}: relMSE {error:.1e}");
        assert!(error < 5e-4, "{name} on {backend}: {error:.1e}");
    }
}

fn pictures_do_not_depend_on_long_steps_and_analytic_hits(backend: Backend) {
    if backend == Backend::Cpu {
        compare_optimisations("CPU", Picture::on_cpu);
    } else {
        let device = Device::open().expect("a GPU adapter");
        compare_optimisations("GPU", |picture, samples| picture.on_gpu(&device, samples).expect("renders"));
    }
}

tests! {
    for_each_backend slow: [pictures_do_not_depend_on_long_steps_and_analytic_hits],
    with_gpu: [pictures_do_not_depend_on_constant_numbers, pictures_do_not_depend_on_the_kind_of_memory],
}
