//! Several light samples and indirect samples at first surfaces: they leave the picture as it is, pay where there are many lamps,
//! and are the same on both backends.

use crate::common::{cpu, on_both_backends, parse, render};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{RenderError, Renderer, Settings};
use pathmarch_testing::{plain, some_of, tests};

/// A floor, metal and glass below a sun, a few lamps without a light tree, or with one.
fn scene(lamps: u32) -> Scene {
    let mut text = String::from(
        r#"pathmarch 1
camera { position 0 1.6 4; target 0 0.6 0; fov 45 }
render { bounces 3 }
sky 0.1
sun { direction 0.4 1 0.6; irradiance 0.5; angle 3 }
material "white" { diffuse 0.7 }
material "metal" { metal 0.9 0.7 0.4; roughness 0.4 }
material "glass" { glass 0.9; roughness 0.3 }
object "floor" material="white" { plane }
object "metal" material="metal" { sphere 0.5 { at -0.7 0.5 0 } }
object "glass" material="glass" { sphere 0.4 { at 0.5 0.4 0.3 } }
"#,
    );
    for k in 0..lamps {
        let (x, z) = (0.7 * (k % 6) as f32 - 1.75, 0.8 * (k / 6) as f32 - 2.0);
        let colour = ["9 2 1", "2 8 2", "1 3 12"][k as usize % 3];
        let shape = ["sphere 0.06", "rect 0.15 0.1 { normal 0 -1 0; at X 1.7 Z }", "box 0.1 0.05 0.1"][k as usize % 3];
        let shape = match shape.contains("at") {
            true => shape.replace('X', &x.to_string()).replace('Z', &z.to_string()),
            false => format!("{shape} {{ at {x} 1.7 {z} }}"),
        };
        text += &format!(
            "material \"lamp {k}\" {{ emit {colour} }}\nobject \"lamp {k}\" material=\"lamp {k}\" {{ {shape} }}\n"
        );
    }
    parse(&text)
}

fn settings(scene: &Scene, samples: u32, seed: u32, [light_samples, indirect_samples]: [u32; 2]) -> Settings {
    Settings {
        size: [61, 37],
        samples,
        seed,
        splitting: Some(1),
        light_samples: Some(light_samples),
        indirect_samples: Some(indirect_samples),
        path_reuse: Some(false),
        ..Settings::of(scene)
    }
}

fn pictures_are_the_same() {
    for lamps in some_of([24, 2], 2) {
        let scene = scene(lamps);
        let picture = |seed, counts| render(&cpu(), &scene, &settings(&scene, 2048, seed, counts)).mean();
        let reference = picture(1, [1, 1]);
        let error = |picture: &Picture| relmse(picture, &reference).expect("equal sizes");
        let noise = error(&picture(2, [1, 1]));
        for (seed, counts) in [(3, [4, 1]), (4, [1, 3]), (5, [4, 2])] {
            let with = picture(seed, counts);
            assert!(error(&with) < 1.1 * noise, "{lamps} lamps, {counts:?}: {:.2e}, of one {noise:.2e}", error(&with));
            for (mean, expected) in mean_colour(&with).iter().zip(&mean_colour(&reference)) {
                assert!((mean / expected - 1.0).abs() < 2e-3, "{lamps} lamps, {counts:?}: {mean} is not {expected}");
            }
        }
    }
}

fn many_lamps_have_less_noise() {
    let scene = scene(24);
    let picture = |samples, seed, counts| render(&cpu(), &scene, &settings(&scene, samples, seed, counts)).mean();
    let reference = picture(1024, 1, [4, 2]);
    let error = |seed, counts| relmse(&picture(8, seed, counts), &reference).expect("equal sizes");
    let [one, four, further] = [error(2, [1, 1]), error(3, [4, 1]), error(4, [4, 4])];
    assert!(four < 0.7 * one && further < 0.7 * four, "{one:.2e} {four:.2e} {further:.2e}");
}

fn both_backends_sample_the_same_lights(renderers: &mut [Renderer; 2]) {
    for (lamps, counts, splitting) in [(2, [3, 1], 1), (24, [4, 1], 1), (2, [2, 1], 4), (24, [4, 2], 1), (2, [1, 3], 1)]
    {
        let scene = scene(lamps);
        let settings = Settings { splitting: Some(splitting), ..settings(&scene, 24, 0, counts) };
        let [cpu, gpu] = renderers.each_ref().map(|renderer| {
            let job = renderer.start(&scene, &settings).expect("starts");
            assert_eq!([job.light_samples(), job.indirect_samples()], counts);
            render(renderer, &scene, &settings).mean()
        });
        let error = relmse(&gpu, &cpu).expect("equal sizes");
        assert!(error < 2e-5, "{lamps} lamps, {counts:?} samples: {error:.2e}");
    }
}

fn shared_light_leaves_one_indirect_sample() {
    let scene = scene(2);
    let settings = |splitting, path_reuse| Settings {
        size: [64, 64],
        splitting: Some(splitting),
        path_reuse: Some(path_reuse),
        ..settings(&scene, 16, 0, [1, 4])
    };
    let indirect_samples = |splitting, path_reuse| {
        cpu().start(&scene, &settings(splitting, path_reuse)).expect("starts").indirect_samples()
    };
    assert_eq!([indirect_samples(1, false), indirect_samples(2, false), indirect_samples(1, true)], [4, 1, 1]);
}

fn pictures_decide_for_themselves() {
    let chosen = |scene: &Scene, size| {
        let settings = Settings { size, samples: 64, ..Settings::of(scene) };
        let job = cpu().start(scene, &settings).expect("starts");
        [job.light_samples(), job.indirect_samples()]
    };
    let below_lamps = |objects: &str| {
        let mut text = String::from(
            "pathmarch 1\ncamera { position 0 2 6; target 0 0.5 0 }\nmaterial \"white\" { diffuse 0.7 }\n\
             object \"floor\" material=\"white\" { plane }\n",
        );
        for k in 0..40 {
            let colour = ["9 2 1", "2 8 2", "1 3 12"][k % 3];
            let (x, z) = (0.9 * (k % 8) as f32 - 3.0, 0.9 * (k / 8) as f32 - 2.0);
            text += &format!("point {{ at {x} 2.5 {z}; intensity {colour} }}\n");
        }
        parse(&(text + objects))
    };
    let plane = below_lamps("");
    let with_objects = below_lamps(
        "object \"ball\" material=\"white\" { sphere 0.8 { at 0 0.8 0 } }\n\
         object \"box\" material=\"white\" { box 1 1 1 { at -2 0.5 0.4; rotate 0 30 0 } }\n\
         object \"ring\" material=\"white\" { torus 0.6 0.2 { at 2 0.6 0.3; rotate 70 20 0 } }\n",
    );
    assert_eq!(chosen(&plane, [640, 360]), [4, 1], "all light is direct");
    assert_eq!(chosen(&with_objects, [640, 360]), [4, 2], "some is not");
    assert_eq!(chosen(&plane, [64, 36]), [1, 1], "too small");
    let one = parse(
        "pathmarch 1\ncamera { position 0 2 6; target 0 0 0 }\nmaterial \"white\" { diffuse 0.7 }\n\
         object \"floor\" material=\"white\" { plane }\npoint { at 0 1 0; intensity 5 }\n",
    );
    assert_eq!(chosen(&one, [640, 360]), [1, 1], "there is nothing to choose");
    let too_many = Settings { light_samples: Some(9), ..Settings::of(&one) };
    assert!(matches!(cpu().start(&one, &too_many), Err(RenderError::Settings(text)) if text.contains("light samples")));
    let none = Settings { indirect_samples: Some(0), ..Settings::of(&one) };
    assert!(matches!(cpu().start(&one, &none), Err(RenderError::Settings(text)) if text.contains("indirect samples")));
}

tests! {
    on_both_backends: [both_backends_sample_the_same_lights],
    plain: [many_lamps_have_less_noise, pictures_decide_for_themselves, shared_light_leaves_one_indirect_sample],
    plain slow: [pictures_are_the_same],
}
