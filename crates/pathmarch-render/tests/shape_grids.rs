//! Shape grids: scenes of many shapes, which are data of the kernel and not code, and what is code beside them.

use crate::common::{on_both_backends, on_each_backend, parse, render};
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_field::Field;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Mode, Renderer, Settings};
use pathmarch_testing::{some_of, tests};
use std::fmt::Write;

/// Scene of a smooth union of shapes of two colours, spheres and tori as separate objects, lamps, and a floor.
fn scene() -> Scene {
    let mut text = String::from(
        "pathmarch 1\ncamera { position 3 4 9; target 0 0.8 0; fov 40 }\nsky 0.5 0.6 0.7\n\
         sun { direction 0.5 0.8 0.6; irradiance 2.5; angle 2 }\nmaterial \"a\" { diffuse 0.7 0.5 0.4 }\n\
         material \"b\" { diffuse 0.3 0.5 0.7 }\nmaterial \"lamp\" { emit 20 15 8 }\nobject \"floor\" material=\"a\" { plane }\n\
         object \"union\" material=\"a\" {\n    union smooth=0.1 {\n",
    );
    let place = |k: u32| {
        let angle = 2.399_963 * k as f32;
        let radius = 0.2 * (k as f32).sqrt();
        [radius * angle.cos(), 0.3 + 0.5 * (0.37 * k as f32).sin().abs(), radius * angle.sin()]
    };
    let shapes = ["sphere 0.15", "box 0.3 0.2 0.2", "torus 0.15 0.05", "capsule 0.06 0.3", "octahedron 0.2"];
    for k in 0..150 {
        let [x, y, z] = place(k);
        let colour = if k % 3 == 0 { " material=\"b\"" } else { "" };
        let shape = shapes[k as usize % shapes.len()];
        writeln!(text, "        {shape}{colour} {{ at {x} {y} {z}; rotate {} 30 0 }}", 7 * k)
            .expect("writing to a string");
    }
    text += "    }\n}\n";
    for k in 0..120 {
        let [x, y, z] = place(k);
        let (shape, material) = match k % 4 {
            0 => ("torus 0.1 0.03", "b"),
            1 => ("sphere 0.03", "lamp"),
            _ => ("sphere 0.08", "a"),
        };
        writeln!(text, "object \"o{k}\" material=\"{material}\" {{ {shape} {{ at {x} {} {z} }} }}", y + 1.2)
            .expect("writing to a string");
    }
    parse(&text)
}

/// Scene of a smooth union of shapes with a twisted box, a fractal and a plane among them, and of unions inside of a difference and
/// of a shell.
fn mixed_scene() -> Scene {
    let balls = |count: u32, radius: f32, height: f32| {
        let mut text = String::new();
        for k in 0..count {
            let (angle, away) = (2.399_963 * k as f32, radius * (k as f32).sqrt());
            let [x, y, z] = [away * angle.cos(), height + 0.3 * (0.37 * k as f32).sin(), away * angle.sin()];
            let material = if k % 3 == 0 { "b" } else { "a" };
            writeln!(text, "        sphere 0.15 material=\"{material}\" {{ at {x} {y} {z} }}")
                .expect("writing to a string");
        }
        text
    };
    parse(&format!(
        "pathmarch 1\ncamera {{ position 3 4 9; target 0 0.8 0; fov 40 }}\nsky 0.5 0.6 0.7\n\
         sun {{ direction 0.5 0.8 0.6; irradiance 2.5; angle 2 }}\nmaterial \"a\" {{ diffuse 0.7 0.5 0.4 }}\n\
         material \"b\" {{ diffuse 0.3 0.5 0.7 }}\nobject \"union\" material=\"a\" {{\n    union smooth=0.1 {{\n        \
         plane material=\"b\"\n{}        twist 0.2 {{ box 0.5 1.2 0.5 {{ at 0 0.9 0 }} }}\n{}        \
         mandelbulb {{ at 1.5 0.6 1.5; scale 0.5 }}\n    }}\n}}\nobject \"cut\" material=\"b\" {{\n    \
         subtract smooth=0.05 {{\n        union {{\n{}        }}\n        box 1.5 {{ at 0.4 2.5 0.4 }}\n    }}\n}}\n\
         object \"hollow\" material=\"a\" {{\n    subtract {{ shell 0.04 {{ union smooth=0.05 {{\n{}    }} }}\n    \
         box 4 1 4 {{ at 0 4.1 0 }} }}\n}}\n",
        balls(60, 0.3, 0.2),
        balls(60, 0.25, 0.5),
        balls(60, 0.2, 2.2),
        balls(40, 0.2, 3.4),
    ))
}

/// Same scene without shape grids: every shape is code.
fn without_grids(scene: &Scene) -> Scene {
    let roots: Vec<_> = scene.objects.iter().map(|object| object.root.clone()).collect();
    Scene { field: Field::with_shape_grids_from(&roots, usize::MAX), ..scene.clone() }
}

fn pictures_do_not_depend_on_shape_grids(renderers: &mut [Renderer; 2]) {
    for (scene, shapes_as_code) in some_of([(mixed_scene(), [5, 225]), (scene(), [1, 271])], 2) {
        let as_code = without_grids(&scene);
        assert_eq!([&scene, &as_code].map(|scene| scene.field.shapes_as_code()), shapes_as_code);
        let settings = Settings { size: [96, 54], samples: 64, ..Settings::of(&scene) };
        let reference = render(&renderers[0], &as_code, &settings).mean();
        for renderer in renderers.iter() {
            let error = relmse(&render(renderer, &scene, &settings).mean(), &reference).expect("equal sizes");
            println!("{}: relMSE {error:.6} to the same as code", renderer.backend().name);
            assert!(error < 0.0005, "{}: {error}", renderer.backend().name);
        }
    }
}

fn previews_and_views_do_not_depend_on_shape_grids(renderer: &Renderer) {
    let modes = [Mode::Preview, Mode::Normal, Mode::Depth, Mode::Albedo];
    for (scene, mode) in [scene(), mixed_scene()].iter().flat_map(|scene| modes.map(|mode| (scene, mode))) {
        let settings = Settings { size: [128, 72], samples: 4, mode, ..Settings::of(scene) };
        let cpu = Renderer::open(Backend::Cpu, None).expect("the CPU backend");
        let code = render(&cpu, &without_grids(scene), &settings).mean();
        let error = relmse(&render(renderer, scene, &settings).mean(), &code).expect("equal sizes");
        println!("{mode:?} {}: relMSE {error:.6} to the same as code", renderer.backend().name);
        assert!(error < 0.005, "{mode:?} {}: {error}", renderer.backend().name);
    }
}

tests! {
    on_both_backends slow: [pictures_do_not_depend_on_shape_grids],
    on_each_backend slow: [previews_and_views_do_not_depend_on_shape_grids],
}
