//! Caustics by light paths: those of all kinds of lights are the same as camera paths find, and samples add up.

use crate::common::{cpu, on_both_backends, parse, render, worst_block};
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::pathmarch_scene::{Caustics, Scene};
use pathmarch_render::{MAX_LIGHT_PATHS, Renderer, Settings};
use pathmarch_testing::{plain, some_of, tests};

/// A ball and a block of glass and a mirror on a floor, under these lights.
fn lit_by(lights: &str) -> Scene {
    parse(&format!(
        r#"pathmarch 1
camera {{ position 0 2.2 4.5; target 0 0.4 0; fov 40 }}
render {{ bounces 6; caustics "traced" }}
material "floor" {{ diffuse 0.7 }}
material "clear" {{ glass 1 }}
material "tinted" {{ glass 0.9 0.8 1; ior 1.3; absorb 0.2 0.6 0.4 }}
material "mirror" {{ metal 0.9 0.7 0.4 }}
material "lamp" {{ emit 6 5 4 }}
object "floor" material="floor" {{ plane }}
object "ball" material="clear" {{ sphere 0.5 {{ at -0.8 0.55 0.3 }} }}
object "block" material="tinted" {{ rounded-box 0.7 0.9 0.7 0.1 {{ rotate 0 30 0; at 0.7 0.5 0.4 }} }}
object "mirror" material="mirror" {{ box 1.6 1.2 0.6 {{ rotate 0 15 0; at 0.2 0.5 -1.4 }} }}
{lights}
"#
    ))
}

/// Lights of all kinds at which light paths start, large enough that camera paths find them through glass.
const LIGHTS: [(&str, &str); 9] = [
    ("sphere", "object \"a\" material=\"lamp\" { sphere 0.5 { at 1.5 3 1 } }"),
    ("rect", "object \"a\" material=\"lamp\" { rect 1.5 1 { rotate 180 20 0; at -0.5 2.8 0 } }"),
    ("disc", "object \"a\" material=\"lamp\" { disc 0.6 { rotate 170 0 0; at 0 2.5 0.5 } }"),
    ("box", "object \"a\" material=\"lamp\" { box 0.8 0.5 0.6 { rotate 10 20 30; at -1 2.6 0.5 } }"),
    ("torus, which camera paths alone find", "object \"a\" material=\"lamp\" { torus 0.6 0.25 { at 0 2.6 0 } }"),
    ("sun", "sky 0.1\nsun { direction 1 2 0.5; irradiance 3; angle 25 }"),
    (
        "sphere over nested glass",
        "object \"a\" material=\"lamp\" { sphere 0.5 { at -1 3 1 } }\n\
         material \"water\" { glass 1; ior 1.33; priority -1; absorb 0.3 0.1 0 }\n\
         object \"water\" material=\"water\" { sphere 0.4 { at -0.35 0.45 0.6 } }",
    ),
    (
        "sphere over frosted glass and brushed metal",
        "object \"a\" material=\"lamp\" { sphere 0.5 { at -1 3 1 } }\n\
         material \"frosted\" { glass 0.9; roughness 0.2 }\nmaterial \"brushed\" { metal 0.9 0.6 0.3; roughness 0.25 }\n\
         object \"frosted\" material=\"frosted\" { sphere 0.3 { at -0.1 0.31 1.3 } }\n\
         object \"brushed\" material=\"brushed\" { shell 0.05 { cylinder 0.35 0.4 { at 1.2 0.2 1.4 } } }",
    ),
    (
        "two in fog",
        "fog { scatter 0.08; absorb 0.03 }\nobject \"a\" material=\"lamp\" { sphere 0.4 { at 1.2 2.8 1 } }\n\
      object \"b\" material=\"lamp\" { rect 1 1 { rotate 180 0 0; at -1 2.6 0 } }",
    ),
];

fn light_paths_find_what_camera_paths_find() {
    let mut wrong = Vec::new();
    let endless = "object \"water\" material=\"clear\" { plane { at 0 0.3 0 } }\n\
                   object \"a\" material=\"lamp\" { sphere 0.5 { at 1 3 1 } }";
    for (name, lights) in some_of(LIGHTS.into_iter().chain([("water without an end", endless)]), 3) {
        let scene = lit_by(lights);
        let [traced, sampled] = [(Caustics::Traced, 256), (Caustics::Sampled, 2048)].map(|(caustics, samples)| {
            let settings = Settings { size: [64, 48], samples, caustics, ..Settings::of(&scene) };
            render(&cpu(), &scene, &settings).mean()
        });
        let (a, b) = (mean_colour(&traced), mean_colour(&sampled));
        let mean = (0..3).map(|k| (a[k] / b[k] - 1.0).abs()).fold(0.0, f64::max);
        let worst = worst_block(&traced, &sampled, 16);
        let line = format!("{name}: means {:.2} % apart, worst block {:.1} %", mean * 100.0, worst * 100.0);
        println!("{line}");
        // Camera paths rarely find the light under water, so that their picture is noisy.
        let (mean_limit, block_limit) = if name.starts_with("water") { (0.02, 0.12) } else { (0.006, 0.05) };
        if mean > mean_limit || worst > block_limit {
            wrong.push(line);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Points, suns without size, lamps within glass, and many lights at once.
fn light_paths_start_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let many: String =
        (0..40).map(|k| format!("point {{ at {} 3 {}; intensity 1 }}\n", k % 8 - 4, k / 8 - 2)).collect();
    for lights in [
        "point { at 1 3 1; intensity 20 18 12 }",
        "spot { at -0.8 3 0.3; target -0.8 0 0.3; intensity 20; cone 30 }",
        "sky 0.2\nsun { direction 1 2 0.5; irradiance 3 }",
        "material \"bulb\" { glass 1; abbe 30 }\nobject \"bulb\" material=\"bulb\" { sphere 0.3 { at 0 1.6 0 } }\n\
         object \"wire\" material=\"lamp\" { sphere 0.1 { at 0 1.6 0 } }\npoint { at 1 3 0; intensity 9 }",
        &many,
        LIGHTS[8].1,
    ] {
        let scene = lit_by(lights);
        let settings = Settings { size: [96, 64], samples: 8, ..Settings::of(&scene) };
        let [a, b] = [0, 1].map(|k| render(&renderers[k], &scene, &settings).mean());
        let difference = relmse(&a, &b).expect("equal sizes");
        println!("{difference:.1e} {lights}");
        // A path that diverges by rounding is a bright pixel.
        assert!(difference < 2e-3, "{difference} {lights}");
    }
}

fn samples_of_light_paths_add_up() {
    let scene = lit_by("point { at 1 3 1; intensity 20 }");
    let part = |first_sample, samples| {
        let settings = Settings { size: [48, 32], first_sample, samples, ..Settings::of(&scene) };
        render(&cpu(), &scene, &settings)
    };
    let whole = part(0, 12).mean();
    let [mut first, second] = [part(0, 5), part(5, 7)];
    first.add(&second).expect("equal sizes");
    assert!(relmse(&first.mean(), &whole).expect("equal sizes") < 1e-12);
    assert!(mean_colour(&whole)[0] > 0.1);
}

fn any_number_of_light_paths_finds_the_same_light() {
    let scene = lit_by("point { at 1 3 1; intensity 20 }");
    let [few, many] = [(500, 256), (20_000, 64)].map(|(light_paths, samples)| {
        let settings = Settings { size: [64, 48], samples, light_paths: Some(light_paths), ..Settings::of(&scene) };
        let mut job = cpu().start(&scene, &settings).expect("starts");
        job.run(|_| false, |_| {}).expect("runs");
        assert_eq!(job.light_paths(), Some(light_paths));
        job.film().expect("a film").mean()
    });
    let (a, b) = (mean_colour(&few)[1], mean_colour(&many)[1]);
    assert!((a / b - 1.0).abs() < 0.005, "{a} {b}");
    assert!(worst_block(&few, &many, 16) < 0.05, "{}", worst_block(&few, &many, 16));
    for light_paths in [0, MAX_LIGHT_PATHS + 1] {
        let settings = Settings { light_paths: Some(light_paths), ..Settings::of(&scene) };
        let error = settings.check(&scene).expect_err("out of range");
        assert!(error.to_string().contains("light paths; there must be from 1 to 1048576"), "{error}");
    }
}

fn the_number_of_light_paths_suits_the_picture() {
    let light_paths = |scene: &Scene, size: [u32; 2]| {
        let settings = Settings { size, samples: 32, caustics: Caustics::Traced, ..Settings::of(scene) };
        cpu().start(scene, &settings).expect("starts").light_paths()
    };
    let bright_caustics = parse(include_str!("data/caustic_point.kdl"));
    let hardly_any = lit_by("sky 1\npoint { at 1 3 1; intensity 0.02 }");
    let large = [640, 360];
    assert!(light_paths(&bright_caustics, large) > Some(640 * 360 / 2));
    assert!(light_paths(&hardly_any, large) < Some(640 * 360 / 4));
    // Too few camera paths to pay for the probe.
    assert_eq!(light_paths(&bright_caustics, [320, 180]), Some(320 * 180 / 2));
    assert_eq!(light_paths(&lit_by("sky 1"), large), None);
}

fn scenes_without_specular_surfaces_stay_as_they_are() {
    let scene = lit_by("point { at 1 3 1; intensity 20 }");
    let picture = |scene: &Scene, caustics, bounces| {
        let settings = Settings { size: [48, 32], samples: 4, caustics, bounces, ..Settings::of(scene) };
        render(&cpu(), scene, &settings).mean().pixels
    };
    let rough = parse(
        "pathmarch 1\ncamera { position 0 1 3; target 0 0 0 }\npoint { at 1 2 1; intensity 5 }\nobject \"o\" { sphere 1 }",
    );
    assert_eq!(picture(&rough, Caustics::Traced, 3), picture(&rough, Caustics::Sampled, 3));
    // A caustic is a bounce.
    assert_eq!(picture(&scene, Caustics::Traced, 0), picture(&scene, Caustics::Sampled, 0));
    assert_ne!(picture(&scene, Caustics::Traced, 2), picture(&scene, Caustics::Sampled, 2));
}

tests! {
    plain slow: [light_paths_find_what_camera_paths_find],
    plain: [
        any_number_of_light_paths_finds_the_same_light,
        samples_of_light_paths_add_up,
        scenes_without_specular_surfaces_stay_as_they_are,
        the_number_of_light_paths_suits_the_picture,
    ],
    on_both_backends: [light_paths_start_alike_on_both_backends],
}
