//! Nested dielectrics and thin glass: against furnaces, formulas and scenes that mean the same.

use crate::common::{cpu, on_both_backends, on_each_backend, parse, render};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::pathmarch_scene::DirectLighting;
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{plain, tests};
use std::f64::consts::PI;

fn picture(renderer: &Renderer, text: &str, size: [u32; 2], samples: u32) -> Picture {
    let scene = parse(&format!("pathmarch 1\n{text}"));
    render(renderer, &scene, &Settings { size, samples, ..Settings::of(&scene) }).mean()
}

fn colour(renderer: &Renderer, text: &str, size: [u32; 2], samples: u32) -> [f64; 3] {
    mean_colour(&picture(renderer, text, size, samples))
}

fn assert_near(name: &str, found: [f64; 3], expected: [f64; 3], limit: f64) {
    println!("{name}: {found:.4?}, expected {expected:.4?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < limit, "{name}: {found} instead of {expected}");
    }
}

/// Light without a surface, seen along -z.
const VIEW: &str = "camera { position 0 0 0; target 0 0 -1; fov 1 }\n";

/// Materials of the tests, from water to diamond.
const MATERIALS: &str = "material \"water\" { glass 1; ior 1.33 }\nmaterial \"shell\" { glass 1; ior 1.5; priority 2 }\n\
    material \"air\" { glass 1; ior 1; priority 3 }\nmaterial \"gem\" { glass 1; ior 2.4; priority 3 }\n\
    material \"core\" { glass 1; ior 1.7; priority 3 }\n\
    material \"flint\" { glass 1; ior 1.6; abbe 20; priority 1 }\nmaterial \"film\" { glass 1; thin #true }\n\
    material \"clear\" { principled 1; transmission 1; roughness 0; ior 1.4; priority 1 }\n";

/// Nested solids are invisible in uniform surroundings, also if a path forgets one that fills no space.
fn nested_glass_is_invisible_in_a_furnace(renderer: &Renderer) {
    let ball =
        |name: &str, material: &str, shape: &str| format!("object \"{name}\" material=\"{material}\" {{ {shape} }}\n");
    let shell = ball("shell", "shell", "subtract { sphere 1; sphere 0.8 }");
    let onion: String = ["shell", "flint", "gem", "air", "water"]
        .iter()
        .enumerate()
        .map(|(k, material)| ball(&format!("{k}"), material, &format!("sphere {}", 1.0 - 0.15 * k as f32)))
        .collect();
    for (name, objects) in [
        ("water in a shell", shell.clone() + &ball("water", "water", "sphere 0.82")),
        ("bubble in water", ball("water", "water", "sphere 1") + &ball("bubble", "air", "sphere 0.5 { at 0.2 0.1 0 }")),
        ("halves", ball("a", "shell", "sphere 0.8 { at -0.4 0 0 }") + &ball("b", "flint", "sphere 0.8 { at 0.4 0 0 }")),
        ("marched", ball("ring", "shell", "torus 0.7 0.3") + &ball("core", "core", "ellipsoid 0.6 0.45 0.5")),
        (
            "film in water",
            ball("water", "water", "sphere 1")
                + &ball("gem", "gem", "sphere 0.2")
                + &ball("film", "film", "sphere 0.6"),
        ),
        ("five solids", onion),
        ("oblique water", shell + &ball("water", "water", "intersect { sphere 0.82; box 2 { at 0 -1.05 0 } }")),
    ] {
        let text = format!(
            "camera {{ position 0 1.2 2.4; target 0 0 0; fov 50 }}\nrender {{ bounces 100 }}\nsky 1\n{MATERIALS}{objects}"
        );
        // The tolerance of marched surfaces falls with the size of a pixel. Some light that gems reflect inside runs out of bounces.
        let (size, samples, limit) = match name {
            "marched" => ([128, 128], 6, 4e-3),
            "halves" | "five solids" => ([32, 32], 64, 0.012),
            _ => ([32, 32], 64, 3e-3),
        };
        assert_near(name, colour(renderer, &text, size, samples), [1.0; 3], limit);
    }
}

/// Within a dielectric, uniform surroundings have n² times their radiance; of overlapping solids, the one of the highest
/// priority counts.
fn the_camera_may_be_inside_nested_solids(renderer: &Renderer) {
    let objects = "object \"shell\" material=\"shell\" { subtract { sphere 1; sphere 0.8 } }\n\
        object \"water\" material=\"water\" { sphere 0.9 }\nobject \"bubble\" material=\"air\" { sphere 0.3 }\n";
    for (z, index) in [(0.0, 1.0), (0.6, 1.33), (0.85, 1.5), (0.95, 1.5)] {
        let text = format!(
            "camera {{ position 0 0 {z}; target 0.2 0 2; fov 20 }}\nrender {{ bounces 100 }}\nsky 1\n{MATERIALS}{objects}"
        );
        assert_near(&format!("at {z}"), colour(renderer, &text, [16, 16], 64), [index * index; 3], 4e-3);
    }
}

/// Solids of one priority look as those without any.
fn equal_priorities_change_nothing(renderer: &Renderer) {
    let rendered = |[g, h, p]: [&str; 3]| {
        let text = format!(
            "camera {{ position 0 1 4; target 0 0.5 0; fov 40 }}\nrender {{ bounces 8 }}\nsky 0.5\n\
             material \"g\" {{ glass 1; ior 1.4; absorb 0.4 0.9 2; {g} }}\n\
             material \"h\" {{ glass 0.9; ior 1.7; roughness 0.3; {h} }}\n\
             material \"p\" {{ principled 0.9; transmission 0.8; roughness 0.2; absorb 1 0 0; {p} }}\n\
             object \"floor\" {{ plane }}\nobject \"a\" material=\"g\" {{ sphere 0.6 {{ at 0 0.7 0 }} }}\n\
             object \"b\" material=\"h\" {{ box 0.5 {{ at 0.4 0.5 0.6 }} }}\n\
             object \"c\" material=\"p\" {{ sphere 0.3 {{ at -0.4 0.5 0.4 }} }}"
        );
        picture(renderer, &text, [48, 32], 16)
    };
    let plain = rendered([""; 3]);
    let [same, other] = [rendered(["priority 7"; 3]), rendered(["priority 7", "", ""])]
        .map(|picture| relmse(&picture, &plain).expect("equal sizes"));
    println!("relMSE {same:.1e}; with one other priority {other:.1e}");
    assert!(same < 1e-4 && other > 1e-3, "{same} {other}");
}

/// The walls of a vessel hide how far the water reaches into them.
fn the_depth_of_the_overlap_does_not_matter(renderer: &Renderer) {
    let pictures = [0.81, 0.9].map(|radius| {
        let text = format!(
            "camera {{ position 0 1 4; target 0 0 0; fov 40 }}\nrender {{ bounces 12 }}\nsky \"gradient\" {{ zenith 0.2 0.4 0.8; horizon 0.9 }}\n\
             {MATERIALS}material \"tea\" {{ glass 1; ior 1.33; absorb 0.2 0.6 1.5 }}\n\
             object \"shell\" material=\"shell\" {{ subtract {{ sphere 1; sphere 0.8 }} }}\n\
             object \"tea\" material=\"tea\" {{ sphere {radius} }}"
        );
        picture(renderer, &text, [48, 48], 64)
    });
    let difference = relmse(&pictures[1], &pictures[0]).expect("equal sizes");
    println!("relMSE {difference:.1e}");
    assert!(difference < 1e-3, "{difference}");
    assert_near("means", mean_colour(&pictures[1]), mean_colour(&pictures[0]), 2e-3);
}

/// Light straight down through water between plates of glass that it reaches into.
fn fast_caustics_weigh_by_the_media_of_both_sides(renderer: &Renderer) {
    let text = "camera { position 0 0.5 0.01; target 0 0 0; fov 2 }\nrender { bounces 0; caustics \"fast\" }\n\
        point { at 0 4 0; intensity 16 }\nmaterial \"g\" { glass 1; ior 1.5; priority 1; absorb 0.1 0.2 0.3 }\n\
        material \"water\" { glass 1; ior 1.33; absorb 0.5 0.2 0 }\nmaterial \"w\" { diffuse 0.5 }\n\
        object \"floor\" material=\"w\" { plane }\nobject \"water\" material=\"water\" { box 2 0.6 2 { at 0 2 0 } }\n\
        object \"above\" material=\"g\" { box 2 0.4 2 { at 0 2.4 0 } }\nobject \"below\" material=\"g\" { box 2 0.4 2 { at 0 1.6 0 } }";
    // Water is left from 1.8 to 2.2.
    let face = |n: f64| 1.0 - ((n - 1.0) / (n + 1.0)).powi(2);
    let clear = 0.5 / PI * (face(1.5) * face(1.5 / 1.33)).powi(2);
    let expected =
        [[0.1, 0.5], [0.2, 0.2], [0.3, 0.0f64]].map(|[glass, water]| clear * (-0.8 * glass - 0.4 * water).exp());
    assert_near("fast", colour(renderer, text, [8, 8], 4), expected, 2e-3);
}

/// Reflections between the two faces of a sheet add up; light goes straight on.
fn thin_glass_reflects_by_both_faces(renderer: &Renderer) {
    let face = |n: f64| ((n - 1.0) / (n + 1.0)).powi(2);
    let sheet = |n: f64| 2.0 * face(n) / (1.0 + face(n));
    for n in [1.0, 1.33, 1.5, 4.0] {
        let text = format!(
            "{VIEW}render {{ bounces 4 }}\nsky 1\nmaterial \"pane\" {{ glass 0.5 0.25 1; ior {n}; thin #true }}\n\
             object \"pane\" material=\"pane\" {{ rect 2 2 {{ normal 0 0 1; at 0 0 -1 }} }}"
        );
        let expected = [0.5, 0.25, 1.0].map(|tint| sheet(n) + (1.0 - sheet(n)) * tint);
        assert_near(&format!("index {n}"), colour(renderer, &text, [8, 8], 4096), expected, 4e-3);
    }
    // In water, the index of the sheet is relative to it.
    let text = format!(
        "{VIEW}render {{ bounces 4 }}\nmaterial \"water\" {{ glass 1; ior 1.33; priority 1 }}\n\
         material \"pane\" {{ glass 0.5; ior 2.66; thin #true }}\nmaterial \"lamp\" {{ emit 1 }}\n\
         object \"water\" material=\"water\" {{ box 20 }}\n\
         object \"lamp\" material=\"lamp\" {{ rect 2 2 {{ normal 0 0 1; at 0 0 -3 }} }}\n\
         object \"lamp behind\" material=\"lamp\" {{ rect 2 2 {{ normal 0 0 -1; at 0 0 3 }} }}\n\
         object \"pane\" material=\"pane\" {{ rect 2 2 {{ normal 0 0 1; at 0 0 -1 }} }}"
    );
    let expected = sheet(2.0) + (1.0 - sheet(2.0)) * 0.5;
    assert_near("in water", colour(renderer, &text, [8, 8], 4096), [expected; 3], 4e-3);
}

/// Shadow rays of fast caustics pass sheets, one for a pane and two for a box.
fn fast_caustics_pass_thin_glass(renderer: &Renderer) {
    let face = (0.5f64 / 2.5).powi(2);
    let through = |tint: f64| (1.0 - 2.0 * face / (1.0 + face)) * tint;
    for (shape, sheets) in [("rect 2 2 { at 0 2 0 }", 1), ("box 2 0.5 2 { at 0 2 0 }", 2)] {
        let text = format!(
            "camera {{ position 0 0.5 0.01; target 0 0 0; fov 2 }}\nrender {{ bounces 0; caustics \"fast\" }}\n\
             point {{ at 0 4 0; intensity 16 }}\nmaterial \"g\" {{ glass 1 0.5 1; ior 1.5; thin #true }}\n\
             material \"w\" {{ diffuse 0.5 }}\nobject \"floor\" material=\"w\" {{ plane }}\nobject \"pane\" material=\"g\" {{ {shape} }}"
        );
        let expected = [1.0, 0.5, 1.0].map(|tint| 0.5 / PI * through(tint).powi(sheets));
        assert_near(shape, colour(renderer, &text, [8, 8], 4), expected, 2e-3);
    }
}

/// Air, fog or water is inside a bubble of thin glass as well as outside.
fn thin_glass_has_no_inside(renderer: &Renderer) {
    for surroundings in [
        "fog { scatter 0; absorb 0.1 0.2 0.3; glow 0.2 }",
        "material \"sea\" { glass 1; ior 1; absorb 0.1 0.2 0.3 }\nobject \"sea\" material=\"sea\" { sphere 20 }",
        "material \"sea\" { glass 1; ior 1; absorb 0.1 0.2 0.3; priority 1 }\nobject \"sea\" material=\"sea\" { sphere 20 }",
        "material \"mist\" { medium 0; absorb 0.1 0.2 0.3 }\nobject \"mist\" material=\"mist\" { sphere 20 }",
    ] {
        let text = format!(
            "{VIEW}render {{ bounces 8 }}\n{surroundings}\nmaterial \"lamp\" {{ emit 1 }}\n\
             object \"lamp\" material=\"lamp\" {{ rect 2 2 {{ normal 0 0 1; at 0 0 -5 }} }}\n"
        );
        // A film of index 1 reflects nothing.
        let bubble = "material \"film\" { glass 1; ior 1; thin #true }\n\
            object \"bubble\" material=\"film\" { sphere 1 { at 0 0 -3 } }";
        let plain = colour(renderer, &text, [8, 8], 16);
        assert_near(surroundings, colour(renderer, &(text + bubble), [8, 8], 16), plain, 1e-4);
    }
}

/// All kinds of glass at once: nested, thin, rough, dispersing, blended, in fog, with media inside.
const EVERYTHING: &str = "camera { position 0 1.2 4; target 0 0.5 0; fov 40 }\nrender { bounces 9 }\n\
    sun { direction 1 2 1; irradiance 2; angle 20 }\nfog { scatter 0.03; absorb 0.01 }\nsky 0\n\
    material \"lamp\" { emit 4 }\nmaterial \"bulb\" { emit 20 14 8 }\nmaterial \"white\" { diffuse 0.7 }\n\
    material \"shell\" { glass 1; ior 1.5; priority 5 }\nmaterial \"milk\" { glass 1; ior 1.35; scatter 3; absorb 0 0.3 0.9 }\n\
    material \"ice\" { glass 1; ior 1.31; roughness 0.3; priority 2 }\nmaterial \"flint\" { glass 1; ior 1.6; abbe 20; priority 3 }\n\
    material \"clear\" { principled 0.9; transmission 0.9; roughness 0.3; ior 1.45; priority 1 }\n\
    material \"film\" { glass 0.9 0.95 1; ior 1.33; thin #true }\nmaterial \"haze\" { medium 0.4; anisotropy 0.4 }\n\
    object \"floor\" material=\"white\" { plane }\n\
    object \"shell\" material=\"shell\" { subtract { sphere 0.6; sphere 0.5; at -0.7 0.62 0 } }\n\
    object \"milk\" material=\"milk\" { sphere 0.53 { at -0.7 0.62 0 } }\n\
    object \"ice\" material=\"ice\" { box 0.35 { rotate 20 30 0; at -0.75 0.7 0.1 } }\n\
    object \"blend\" material=\"clear\" { union smooth=0.2 { sphere 0.4 { at 0.6 0.42 0 }; sphere 0.3 material=\"flint\" { at 0.9 0.6 0.2 } } }\n\
    object \"core\" material=\"flint\" { torus 0.15 0.08 { at 0.6 0.42 0.1 } }\n\
    object \"film\" material=\"film\" { sphere 0.25 { at 0.1 0.3 0.8 } }\n\
    object \"haze\" material=\"haze\" { sphere 0.5 { at 0.3 0.4 0.5 } }\n\
    object \"lamp\" material=\"lamp\" { rect 1 1 { rotate 180 0 0; at 0 2.2 0 } }\n\
    object \"bulb\" material=\"bulb\" { sphere 0.06 { at 0.1 0.9 0.5 } }\n";

fn nested_glass_looks_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let without_priorities = ["; priority 1", "; priority 2", "; priority 3", "; priority 5"]
        .iter()
        .fold(EVERYTHING.to_owned(), |text, priority| text.replace(priority, ""));
    for (name, text) in [
        ("traced", EVERYTHING.to_owned()),
        ("fast", EVERYTHING.replace("bounces 9", "bounces 9; caustics \"fast\"")),
        ("inside", EVERYTHING.replace("position 0 1.2 4", "position -0.55 0.6 0.4")),
        ("textured", EVERYTHING.replace("ior 1.31; roughness 0.3", "ior 1.31; roughness { checker size=0.1 }")),
        ("without priorities", without_priorities),
    ] {
        let [a, b] = [0, 1].map(|k| picture(&renderers[k], &text, [64, 48], 24));
        let difference = relmse(&a, &b).expect("equal sizes");
        println!("{name}: relMSE {difference:.1e}");
        assert_near(name, mean_colour(&b), mean_colour(&a), 0.01);
        // Paths that scatter often diverge by rounding.
        assert!(difference < 0.06, "{name}: {difference}");
    }
}

/// Sampling lights and sampling the BSDF find the same light through rough interfaces of two dielectrics.
fn all_estimators_make_one_picture_of_nested_glass() {
    let text = "camera { position 0 1 4; target 0 0.5 0; fov 30 }\nrender { bounces 8 }\nsun { direction 1 2 1; irradiance 2; angle 30 }\n\
        material \"water\" { principled 0.9; transmission 1; ior 1.33; roughness 0.5 }\nmaterial \"core\" { glass 1; ior 1.8; roughness 0.6; priority 1 }\n\
        material \"lamp\" { emit 4 }\nobject \"floor\" { plane }\nobject \"water\" material=\"water\" { sphere 0.5 { at 0 0.55 0 } }\n\
        object \"core\" material=\"core\" { sphere 0.4 { at 0.4 0.6 0 } }\nobject \"lamp\" material=\"lamp\" { rect 1 1 { rotate 180 0 0; at -1 2.2 0 } }";
    let scene = parse(&format!("pathmarch 1\n{text}"));
    let means =
        [DirectLighting::Mis, DirectLighting::LightSampling, DirectLighting::BsdfSampling].map(|direct_lighting| {
            let settings = Settings { size: [24, 16], samples: 4000, direct_lighting, ..Settings::of(&scene) };
            mean_colour(&render(&cpu(), &scene, &settings).mean())
        });
    assert_near("light", means[1], means[0], 0.01);
    assert_near("bsdf", means[2], means[0], 0.01);
}

tests! {
    on_each_backend: [
        nested_glass_is_invisible_in_a_furnace,
        the_camera_may_be_inside_nested_solids,
        equal_priorities_change_nothing,
        the_depth_of_the_overlap_does_not_matter,
        fast_caustics_weigh_by_the_media_of_both_sides,
        thin_glass_reflects_by_both_faces,
        fast_caustics_pass_thin_glass,
        thin_glass_has_no_inside,
    ],
    on_both_backends: [nested_glass_looks_alike_on_both_backends],
    plain: [all_estimators_make_one_picture_of_nested_glass],
}
