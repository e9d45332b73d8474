//! Participating media: what is known in closed form, and that all ways of finding light agree.

use crate::common::{cpu, mean, on_both_backends, on_each_backend, parse, render};
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::pathmarch_scene::DirectLighting;
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{plain, tests};
use std::f64::consts::PI;

/// Mean colour of a scene at a few pixels.
fn colour(renderer: &Renderer, text: &str, samples: u32) -> [f64; 3] {
    let scene = parse(&format!("pathmarch 1\n{text}"));
    let settings = Settings { size: [8, 8], samples, ..Settings::of(&scene) };
    mean_colour(&render(renderer, &scene, &settings).mean())
}

/// Checks each channel within a relative limit.
fn assert_near(name: &str, found: [f64; 3], expected: [f64; 3], limit: f64) {
    println!("{name}: {found:.5?}, expected {expected:.5?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= limit * expected.max(1e-3), "{name}: {found} is not {expected}");
    }
}

const LAMP: &str =
    "material \"lamp\" { emit 1 }\nobject \"lamp\" material=\"lamp\" { rect 4 4 { normal 0 0 1; at 0 0 -4 } }\n";
const VIEW: &str = "camera { position 0 0 0; target 0 0 -1; fov 0.05 }\n";

fn media_absorb_by_beer_and_lamberts_law(renderer: &Renderer) {
    let exp = |depths: [f64; 3]| depths.map(|depth| (-depth).exp());
    for inside in ["medium 0; absorb 0.5 0.1 0", "glass 1; ior 1; absorb 0.5 0.1 0"] {
        let text = format!(
            "{VIEW}{LAMP}material \"it\" {{ {inside} }}\nobject \"it\" material=\"it\" {{ box 2 {{ at 0 0 -2 }} }}"
        );
        assert_near(inside, colour(renderer, &text, 4), exp([1.0, 0.2, 0.0]), 1e-3);
        // Glass displaces the fog, a medium adds to it.
        let (length, name) = if inside.starts_with("glass") { (2.0, "in fog, glass") } else { (4.0, "in fog, medium") };
        let text = format!("{text}\nfog {{ scatter 0; absorb 0.2 }}");
        let expected = [1.0_f64, 0.2, 0.0].map(|depth| (-depth - 0.2 * length).exp());
        assert_near(name, colour(renderer, &text, 4), expected, 1e-3);
    }
    // Two media that overlap, in which the camera is, and the sky beyond.
    let text = format!(
        "{VIEW}sky 1\nmaterial \"a\" {{ medium 0; absorb 5 0.5 0 }}\nmaterial \"b\" {{ medium 0; absorb 0.3 0 0.01 }}\n\
         object \"a\" material=\"a\" {{ sphere 0.5 }}\nobject \"b\" material=\"b\" {{ sphere 2 {{ at 0 0 -1 }} }}"
    );
    assert_near("overlapping", colour(renderer, &text, 4), exp([2.5 + 0.9, 0.25, 0.03]), 1e-3);
}

fn media_emit_along_the_way(renderer: &Renderer) {
    let closed_form = |emission: f64, extinction: f64, length: f64| {
        if extinction > 0.0 { emission * (1.0 - (-extinction * length).exp()) / extinction } else { emission * length }
    };
    let text = format!(
        "{VIEW}material \"flame\" {{ medium 0; absorb 0 0.001 2; glow 3 2 1 }}\n\
         object \"flame\" material=\"flame\" {{ box 2 {{ at 0 0 -2 }} }}"
    );
    let expected = [closed_form(3.0, 0.0, 2.0), closed_form(2.0, 0.001, 2.0), closed_form(1.0, 2.0, 2.0)];
    assert_near("flame", colour(renderer, &text, 4), expected, 1e-3);
    let text = format!("{VIEW}fog {{ scatter 0; absorb 0.5 1 2; glow 1 }}");
    assert_near("endless fog", colour(renderer, &text, 4), [2.0, 1.0, 0.5], 1e-3);
    // What is scattered is emitted by the same medium elsewhere.
    let text = format!("{VIEW}fog {{ scatter 1 0.5 2; absorb 0.5 1 2; glow 1 }}\nrender {{ bounces 60 }}");
    assert_near("endless fog that scatters", colour(renderer, &text, 256), [2.0, 1.0, 0.5], 0.02);
}

/// Media that absorb nothing are invisible in uniform surroundings, with and without a surface.
fn white_media_are_invisible_in_a_furnace(renderer: &Renderer) {
    for (inside, shape) in [
        ("medium 3", "sphere 1"),
        ("medium 1 2 5; anisotropy 0.7", "sphere 1"),
        ("medium 2; anisotropy -0.5", "torus 0.7 0.4"),
        ("glass 1; ior 1.3; scatter 4 3 2; anisotropy 0.4", "sphere 1"),
        ("glass 1; ior 1.5; scatter 2", "rounded-box 1.4 1.4 1.4 0.2"),
    ] {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 1.2 1.8; target 0 0 0; fov 60 }}\nsky 1\nrender {{ bounces 400 }}\n\
             material \"it\" {{ {inside} }}\nobject \"it\" material=\"it\" {{ {shape} {{ rotate 20 30 0 }} }}"
        );
        let scene = parse(&text);
        let settings = Settings { size: [24, 24], samples: 48, ..Settings::of(&scene) };
        let found = mean_colour(&render(renderer, &scene, &settings).mean());
        assert_near(inside, found, [1.0; 3], 6e-3);
    }
}

/// Light of a point that fog scatters once, against the integral along the ray.
fn single_scattering_is_the_integral_along_the_ray(renderer: &Renderer) {
    let (scattering, absorption): ([f64; 3], f64) = ([0.2, 0.4, 0.8], 0.1);
    for (anisotropy, position) in [(0.0f64, [0.05f64, 0.0, -2.0]), (0.6, [0.5, 0.3, -3.0]), (-0.4, [0.0, 0.7, 1.0])] {
        let [x, y, z] = position;
        let text = format!(
            "{VIEW}render {{ bounces 0 }}\nfog {{ scatter 0.2 0.4 0.8; absorb {absorption}; anisotropy {anisotropy} }}\n\
             point {{ at {x} {y} {z}; intensity 5 }}\nmaterial \"black\" {{ diffuse 0 }}\n\
             object \"wall\" material=\"black\" {{ rect 9 9 {{ normal 0 0 1; at 0 0 -5 }} }}"
        );
        let integral = |scattering: f64| {
            let extinction = scattering + absorption;
            let steps = 500_000;
            let at = |k: u32| {
                let t = (f64::from(k) + 0.5) * 5.0 / f64::from(steps);
                let square = x * x + y * y + (z + t) * (z + t);
                let distance = square.sqrt();
                let cosine = -(z + t) / distance;
                let g = anisotropy;
                let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cosine).powf(1.5));
                scattering * phase * (-extinction * (t + distance)).exp() * 5.0 / square
            };
            (0..steps).map(at).sum::<f64>() * 5.0 / f64::from(steps)
        };
        let name = format!("anisotropy {anisotropy} around {position:?}");
        assert_near(&name, colour(renderer, &text, 4096), scattering.map(integral), 0.01);
    }
}

const LIT_FOG: &str = "camera { position 0 0.8 4; target 0 0.5 0; fov 40 }\nrender { bounces 6 }\n\
    sun { direction 1 2 1; irradiance 1; angle 20 }\n\
    material \"bulb\" { emit 20 14 8 }\nmaterial \"lamp\" { emit 4 }\nmaterial \"haze\" { medium 0.6 0.8 1; absorb 0.1; anisotropy 0.5 }\n\
    material \"white\" { diffuse 0.7 }\nmaterial \"milk\" { glass 1; ior 1.3; roughness 0.5; scatter 6; absorb 0 0.3 0.9 }\n\
    object \"floor\" material=\"white\" { plane }\nobject \"haze\" material=\"haze\" { box 6 3 6 { at 0 1.4 0 } }\n\
    object \"bulb\" material=\"bulb\" { sphere 0.12 { at -0.6 0.9 0.3 } }\n\
    object \"lamp\" material=\"lamp\" { rect 0.8 0.8 { rotate 180 0 0; at 0.8 1.8 0 } }\n\
    object \"ball\" material=\"milk\" { sphere 0.4 { at 0.5 0.41 0.4 } }\n";

fn all_estimators_make_one_picture_in_media() {
    let scene = parse(&format!("pathmarch 1\n{LIT_FOG}"));
    let means =
        [DirectLighting::Mis, DirectLighting::LightSampling, DirectLighting::BsdfSampling].map(|direct_lighting| {
            let settings = Settings { size: [24, 16], samples: 6000, direct_lighting, ..Settings::of(&scene) };
            mean_colour(&render(&cpu(), &scene, &settings).mean())
        });
    assert_near("light", means[1], means[0], 0.015);
    assert_near("bsdf", means[2], means[0], 0.015);
}

fn media_look_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let fog = "camera { position 0 0.8 4; target 0 0.5 0; fov 40 }\nrender { bounces 5; caustics \"fast\" }\n\
        fog { scatter 0.2 0.25 0.3; absorb 0.02; anisotropy 0.4; glow 0.01 0 0 }\npoint { at 0.5 1.5 0; intensity 8 }\n\
        material \"milk\" { glass 1; ior 1.3; scatter 3; absorb 0 0.3 0.9; glow 0 0.05 0 }\nmaterial \"box\" { emit 3 }\n\
        object \"floor\" { plane }\nobject \"ball\" material=\"milk\" { torus 0.4 0.2 { at 0.5 0.5 0.4 } }\n\
        object \"box\" material=\"box\" { box 0.3 { rotate 20 30 0; at -0.8 0.6 0 } }";
    for (name, text) in [("lit haze", LIT_FOG), ("fog", fog)] {
        let scene = parse(&format!("pathmarch 1\n{text}"));
        let settings = Settings { size: [64, 48], samples: 16, ..Settings::of(&scene) };
        let [a, b] = [0, 1].map(|k| render(&renderers[k], &scene, &settings).mean());
        let difference = relmse(&a, &b).expect("equal sizes");
        println!("{name}: relMSE {difference:.1e}");
        assert_near(name, mean_colour(&b), mean_colour(&a), 5e-3);
        // Paths that scatter often diverge by rounding.
        assert!(difference < 0.03, "{name}: {difference}");
    }
}

/// A medium elsewhere in the scene changes nothing about glass that absorbs.
fn absorption_is_the_same_among_other_media() {
    let scene = |more: &str| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 1 4; target 0 0.5 0; fov 40 }}\nrender {{ bounces 6 }}\nsky 0.5\n\
             material \"g\" {{ glass 1; ior 1.4; absorb 0.4 0.9 2 }}\nobject \"floor\" {{ plane }}\n\
             object \"a\" material=\"g\" {{ sphere 0.6 {{ at 0 0.7 0 }} }}\nobject \"b\" material=\"g\" {{ box 0.5 {{ at 0.4 0.5 0.6 }} }}\n{more}"
        ))
    };
    let far = "material \"far\" { medium 1 }\nobject \"far\" material=\"far\" { sphere 1e-3 { at 0 0.5 -3 } }";
    let pictures = ["", far].map(|more| {
        let scene = scene(more);
        render(&cpu(), &scene, &Settings { size: [48, 32], samples: 16, ..Settings::of(&scene) }).mean()
    });
    let difference = relmse(&pictures[1], &pictures[0]).expect("equal sizes");
    println!("relMSE {difference:.1e}");
    assert!(difference < 1e-6, "{difference}");
}

fn sample_ranges_add_up_in_media() {
    let scene = parse(&format!("pathmarch 1\n{LIT_FOG}"));
    let settings = Settings { size: [24, 16], samples: 8, ..Settings::of(&scene) };
    let whole = render(&cpu(), &scene, &settings).mean();
    let [first, second] = [0, 4]
        .map(|first_sample| render(&cpu(), &scene, &Settings { samples: 4, first_sample, ..settings.clone() }).mean());
    for ((whole, first), second) in whole.pixels.iter().zip(&first.pixels).zip(&second.pixels) {
        for k in 0..3 {
            assert!((whole[k] - 0.5 * (first[k] + second[k])).abs() <= 1e-5 * whole[k].max(1.0));
        }
    }
}

/// Paths that share a camera ray share the event of its segment, and have the same mean.
fn splitting_keeps_the_mean_in_media() {
    let scene = parse(&format!("pathmarch 1\n{LIT_FOG}"));
    let means = [1, 4].map(|splitting| {
        let settings = Settings { size: [24, 16], samples: 2048, splitting: Some(splitting), ..Settings::of(&scene) };
        mean_colour(&render(&cpu(), &scene, &settings).mean())
    });
    assert_near("4 paths a ray", means[1], means[0], 0.01);
}

/// A small lamp in fog converges: no pixel stands out.
fn a_lantern_in_fog_has_no_fireflies(renderer: &Renderer) {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 4; target 0 0 0; fov 40 }\nrender { bounces 0 }\nfog { scatter 0.1 }\n\
         point { at 0 0 0; intensity 1 }",
    );
    let settings = Settings { size: [32, 32], samples: 64, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    let at = |x: u32, y: u32| mean(&picture, |a, b| a == x && b == y);
    // By symmetry, pixels that mirror each other are equal.
    for (x, y) in (0..16).flat_map(|y| (0..16).map(move |x| (x, y))) {
        let [a, b, c, d] = [at(x, y), at(31 - x, y), at(x, 31 - y), at(31 - x, 31 - y)];
        let mean = 0.25 * (a + b + c + d);
        for value in [a, b, c, d] {
            assert!((value / mean - 1.0).abs() < 0.25, "({x}, {y}): {value} beside {mean}");
        }
    }
}

tests! {
    plain: [
        absorption_is_the_same_among_other_media,
        sample_ranges_add_up_in_media,
    ],
    plain slow: [splitting_keeps_the_mean_in_media],
    plain long: [all_estimators_make_one_picture_in_media],
    on_each_backend: [
        media_absorb_by_beer_and_lamberts_law,
        media_emit_along_the_way,
        white_media_are_invisible_in_a_furnace,
        single_scattering_is_the_integral_along_the_ray,
        a_lantern_in_fog_has_no_fireflies,
    ],
    on_both_backends: [media_look_alike_on_both_backends],
}
