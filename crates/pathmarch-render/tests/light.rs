//! Properties of the estimator: all direct-light estimators agree, no light leaks, pictures do not depend on the scale, and each
//! approximation does what it documents.

use crate::common::{mean, on_each_backend, parse, render};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{block_means, mean_colour, relmse};
use pathmarch_render::pathmarch_scene::{Caustics, DirectLighting, Scene, Sky};
use pathmarch_render::{Backend, Mode, Renderer, Settings};
use pathmarch_testing::{plain, some_of, tests};
use std::f32::consts::PI;

fn cpu() -> Renderer {
    Renderer::open(Backend::Cpu, None).expect("the CPU backend")
}

/// Room with every kind of light that paths can hit, and with BSDF lobes of several widths.
const LIT_ROOM: &str = r##"pathmarch 1
camera { position 0 1.2 4; target 0 0.8 0; fov 45 }
render { bounces 3 }
sky 0.05
material "white" { diffuse 0.7 }
material "metal" { metal 0.9 0.7 0.4; roughness 0.3 }
material "glossy" { principled 0.2 0.3 0.6; roughness 0.25; coat 0.5 }
material "frosted" { glass 0.95; roughness 0.5 }
material "warm" { emit 5 4 3 }
material "cool" { emit 2 3 5 }
material "ember" { diffuse 0.6; emission 2 0.5 0.2 }
material "neon" { metal 0.8; roughness 0.3; emission 0.3 1 2 }
sun { direction 1 2 1; irradiance 1; angle 20 }
object "floor" material="white" { plane }
object "back" material="white" { rect 8 8 { rotate 90 0 0; at 0 2 -2 } }
object "metal" material="metal" { sphere 0.5 { at -1.1 0.5 0 } }
object "glossy" material="glossy" { rounded-box 0.7 0.7 0.7 0.1 { rotate 0 30 0; at 0 0.35 0 } }
object "frosted" material="frosted" { sphere 0.5 { at 1.1 0.5 0 } }
object "ball" material="warm" { sphere 0.3 { at -1 2 0.5 } }
object "panel" material="cool" { rect 0.8 0.5 { rotate 150 0 0; at 0.3 2.1 0.3 } }
object "box" material="warm" { box 0.3 0.2 0.4 { rotate 10 20 30; at 1.2 1.6 0.2 } }
object "ring" material="cool" { torus 0.25 0.08 { rotate 60 0 0; at 0 1.4 -0.8 } }
object "disc" material="warm" { disc 0.3 { rotate 120 0 0; at -0.4 1.5 -1 } }
object "ember" material="ember" { sphere 0.2 { at -0.3 0.2 1.2 } }
object "neon" material="neon" { box 0.2 0.5 0.2 { at 0.9 0.25 1.2 } }
"##;

/// Mean and variance of the mean of every block's channels over pictures of different seeds.
fn blocks(scene: &Scene, estimator: DirectLighting, samples: u32) -> Vec<(f64, f64)> {
    const SEEDS: u32 = 12;
    let renderer = cpu();
    let pictures: Vec<Picture> = (0..SEEDS)
        .map(|seed| {
            let settings =
                Settings { size: [96, 64], samples, seed, direct_lighting: estimator, ..Settings::of(scene) };
            block_means(&render(&renderer, scene, &settings).mean(), 16)
        })
        .collect();
    let count = f64::from(SEEDS);
    (0..pictures[0].pixels.len() * 3)
        .map(|k| {
            let values = pictures.iter().map(|picture| f64::from(picture.pixels[k / 3][k % 3]));
            let mean = values.clone().sum::<f64>() / count;
            (mean, values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count * (count - 1.0)))
        })
        .collect()
}

/// Z-test over the blocks of the picture: with an unbiased estimator, Z² is one on average.
fn all_direct_light_estimators_make_the_same_picture() {
    let environment = format!("{LIT_ROOM}\nobject \"roof\" {{ rect 1 1 {{ at 0 9 0 }} }}");
    for with_map in some_of([true, false], 2) {
        let mut scene = parse(&environment);
        if with_map {
            // Environment map with a bright spot instead of a constant sky.
            let texels = (0..32 * 16).map(|k| if k % 32 == 20 && k / 32 == 4 { [60.0; 3] } else { [0.1, 0.15, 0.2] });
            let picture = pathmarch_render::pathmarch_scene::Environment {
                width: 32,
                height: 16,
                texels: texels.collect(),
                rotate: 30.0,
            };
            scene.sky = Sky::Map(std::sync::Arc::new(picture));
        }
        let both = blocks(&scene, DirectLighting::Mis, 16);
        for (estimator, samples) in [(DirectLighting::LightSampling, 32), (DirectLighting::BsdfSampling, 256)] {
            let other = blocks(&scene, estimator, samples);
            let z: Vec<f64> =
                both.iter().zip(&other).map(|(a, b)| (a.0 - b.0) / (a.1 + b.1).sqrt().max(1e-9)).collect();
            let square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
            let worst = z.iter().fold(0.0f64, |worst, z| worst.max(z.abs()));
            let bias = z.iter().sum::<f64>() / z.len() as f64;
            println!("{estimator:?}, picture {with_map}: mean Z² {square:.2}, mean Z {bias:.2}, worst {worst:.1}");
            assert!(square < 2.0 && worst < 6.0, "{estimator:?}: {square} {worst}");
        }
    }
}

/// Clear glass in uniform surroundings has their radiance: no light is lost or leaks, at any scale, for analytic and
/// sphere-traced surfaces.
fn clear_glass_is_invisible_in_a_furnace_at_every_scale(renderer: &Renderer) {
    for scale in ["0.001", "1", "1000"] {
        for shape in
            ["sphere 1", "box 1.4", "torus 0.8 0.3", "rounded-box 1.2 1.2 1.2 0.2", "subtract { sphere 1; sphere 0.9 }"]
        {
            let scene = parse(&format!(
                "pathmarch 1\ncamera {{ position 0 {0}e0 {0}e0; target 0 0 0; fov 100 }}\nrender {{ bounces 64 }}\nsky 1\n\
                 material \"glass\" {{ glass 1 }}\nobject \"o\" material=\"glass\" {{ {shape} {{ rotate 20 30 0; scale {0} }} }}",
                scale
            )
            .replace("position 0 0.001e0 0.001e0", "position 0 0.0012 0.0018")
            .replace("position 0 1e0 1e0", "position 0 1.2 1.8")
            .replace("position 0 1000e0 1000e0", "position 0 1200 1800")
            .replace("subtract { sphere 1; sphere 0.9 } {", "subtract { sphere 1; sphere 0.9;"));
            let settings = Settings { size: [48, 48], samples: 16, ..Settings::of(&scene) };
            let picture = render(renderer, &scene, &settings).mean();
            let mean = mean_colour(&picture)[1];
            let darkest = picture.pixels.iter().map(|p| p[1]).fold(1.0, f32::min);
            // Some light that travels along the inside runs out of bounces.
            assert!((mean - 1.0).abs() < 4e-3, "{shape} at {scale} on {}: {mean}", renderer.backend().name);
            assert!(darkest > 0.7, "{shape} at {scale} on {}: {darkest}", renderer.backend().name);
        }
    }
}

/// A scene in millimetres, metres and kilometres has the same picture.
fn pictures_do_not_depend_on_the_scale() {
    let at = |scale: f32| {
        let [s, s2] = [scale, scale * scale];
        let n = |v: f32| v * s;
        parse(&format!(
            "pathmarch 1\ncamera {{ position {} {} {}; target 0 {} 0; fov 40 }}\nrender {{ bounces 4 }}\nsky 0.3\n\
             point {{ at {} {} {}; intensity {} }}\nmaterial \"m\" {{ metal 0.9; roughness 0.3 }}\nmaterial \"g\" {{ glass 1; absorb {} }}\n\
             material \"l\" {{ emit 4 }}\nobject \"floor\" {{ plane }}\nobject \"a\" material=\"m\" {{ sphere {} {{ at {} {} 0 }} }}\n\
             object \"b\" material=\"g\" {{ torus {} {} {{ rotate 70 0 0; at {} {} 0 }} }}\n\
             object \"c\" {{ subtract smooth={} {{ box {}; sphere {} {{ at 0 {} 0 }}; at 0 {} {} }} }}\n\
             object \"l\" material=\"l\" {{ rect {} {} {{ rotate 180 0 0; at 0 {} 0 }} }}",
            n(0.4),
            n(1.6),
            n(4.0),
            n(0.5),
            n(3.0),
            n(4.0),
            n(2.0),
            8.0 * s2,
            1.5 / s,
            n(0.5),
            n(-0.9),
            n(0.5),
            n(0.4),
            n(0.15),
            n(0.9),
            n(0.5),
            n(0.1),
            n(0.7),
            n(0.4),
            n(0.3),
            n(0.35),
            n(-1.2),
            n(1.0),
            n(1.0),
            n(3.0),
        ))
    };
    let mut pictures = [0.001, 1.0, 1000.0].map(|scale| {
        let scene = at(scale);
        render(&cpu(), &scene, &Settings { size: [96, 64], samples: 64, ..Settings::of(&scene) }).mean()
    });
    let [small, metres, large] = &mut pictures;
    for (name, other) in [("millimetres", small), ("kilometres", large)] {
        let difference = relmse(other, metres).expect("equal sizes");
        println!("{name}: relMSE {difference:.1e}");
        assert!(difference < 1e-3, "{name}: {difference}");
    }
}

/// A small, distant light out of focus is a disc of the diameter of the thin lens formula.
fn the_lens_blurs_by_its_formula(renderer: &Renderer) {
    let (radius, focus, distance, fov) = (0.05f32, 2.0f32, 10.0f32, 20.0f32);
    let scene = parse(&format!(
        "pathmarch 1\ncamera {{ position 0 0 {distance}; target 0 0 0; fov {fov}; lens radius={radius} focus={focus} }}\n\
         render {{ bounces 0 }}\nmaterial \"l\" {{ emit 10 }}\nobject \"l\" material=\"l\" {{ sphere 0.05 }}"
    ));
    const SIZE: u32 = 128;
    // Radii in the plane of focus, pixels: of the lens as seen from the light, and of the light.
    let pixel = 2.0 * focus * (0.5 * fov.to_radians()).tan() / SIZE as f32;
    let (blur, light) = (radius * (distance - focus) / distance / pixel, 0.05 * focus / distance / pixel);
    // Mean squared radii add up: half of the squared radius for a disc, a sixth for a pixel.
    let expected = 0.5 * (blur * blur + light * light) + 1.0 / 6.0;
    let settings = Settings { size: [SIZE, SIZE], samples: 256, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    let (mut sum, mut weight) = (0.0, 0.0);
    for (k, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (k as u32 % SIZE, k as u32 / SIZE);
        let middle = 0.5 * SIZE as f32 - 0.5;
        sum += pixel[1] * ((x as f32 - middle).powi(2) + (y as f32 - middle).powi(2));
        weight += pixel[1];
    }
    let found = sum / weight;
    println!("{}: mean square {found:.2} pixels, {expected:.2} by the formula", renderer.backend().name);
    assert!((found / expected - 1.0).abs() < 0.03, "{found} {expected}");
}

/// Light straight down through a slab of glass: two interfaces at normal incidence, and absorption.
fn fast_caustics_weigh_by_fresnel_and_absorption(renderer: &Renderer) {
    let scene = |caustics: &str| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0.5 0.01; target 0 0 0; fov 2 }}\nrender {{ bounces 0; caustics \"{caustics}\" }}\n\
             point {{ at 0 4 0; intensity 16 }}\nmaterial \"g\" {{ glass 1 0.5 1; ior 1.5; absorb 0.4 0 0.2 }}\n\
             material \"w\" {{ diffuse 0.5 }}\nobject \"floor\" material=\"w\" {{ plane }}\n\
             object \"slab\" material=\"g\" {{ box 2 0.5 2 {{ at 0 2 0 }} }}"
        ))
    };
    for (caustics, shows) in [("fast", 1.0), ("sampled", 0.0)] {
        let scene = scene(caustics);
        let settings = Settings { size: [8, 8], samples: 4, ..Settings::of(&scene) };
        let found = mean_colour(&render(renderer, &scene, &settings).mean());
        let clear = 0.5 / f64::from(PI) * 0.96 * 0.96 * shows;
        let expected = [clear * (-0.2f64).exp(), clear * 0.25, clear * (-0.1f64).exp()];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 2e-3 * expected.max(0.01), "{caustics}: {found} {expected}");
        }
    }
}

/// With `fast`, paths that hit a light through glass do not count it again: shadow rays have counted it.
fn fast_caustics_count_no_light_twice(renderer: &Renderer) {
    // Glass with almost the index of air does not refract: both modes must agree.
    let scene = parse(
        "pathmarch 1\ncamera { position 0 1 5; target 0 0.5 0; fov 40 }\nrender { bounces 4; caustics \"fast\" }\n\
         material \"g\" { glass 0.8; ior 1.002 }\nmaterial \"l\" { emit 8 }\nsun { direction 0 1 0.2; irradiance 1; angle 8 }\n\
         object \"floor\" { plane }\nobject \"slab\" material=\"g\" { box 3 0.3 3 { at 0 1.5 0 } }\n\
         object \"l\" material=\"l\" { sphere 0.3 { at 0.5 2.5 0 } }",
    );
    let [fast, sampled] = [Caustics::Fast, Caustics::Sampled].map(|caustics| {
        let settings = Settings { size: [48, 32], samples: 512, caustics, ..Settings::of(&scene) };
        mean_colour(&render(renderer, &scene, &settings).mean())[1]
    });
    println!("{}: fast {fast:.4}, sampled {sampled:.4}", renderer.backend().name);
    assert!((fast / sampled - 1.0).abs() < 0.01, "{fast} {sampled}");
}

/// Paths still hit emitters that are not sampled as lights, also behind clear glass.
fn fast_caustics_keep_emitters_that_are_not_sampled(renderer: &Renderer) {
    let scene = |caustics: &str| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 1 4; target 0 0 0; fov 30 }}\nrender {{ bounces 6; caustics \"{caustics}\" }}\n\
             material \"g\" {{ glass 1; ior 1.002 }}\nmaterial \"l\" {{ emit 1 }}\nobject \"floor\" {{ plane }}\n\
             object \"slab\" material=\"g\" {{ box 3 0.3 3 {{ at 0 1.5 0 }} }}\n\
             object \"ceiling\" material=\"l\" {{ plane {{ normal 0 -1 0; at 0 5 0 }} }}"
        ))
    };
    let [fast, sampled] = ["fast", "sampled"].map(|caustics| {
        let scene = scene(caustics);
        let settings = Settings { size: [32, 24], samples: 64, ..Settings::of(&scene) };
        mean_colour(&render(renderer, &scene, &settings).mean())[1]
    });
    assert!((fast / sampled - 1.0).abs() < 0.01, "{fast} {sampled}");
}

/// A sun whose disc is approximated by near misses is not hit by paths as well.
fn a_penumbra_counts_no_light_twice(renderer: &Renderer) {
    let scene = |penumbra: &str| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 1 3; target 0 0.5 0; fov 40 }}\nrender {{ bounces 2 }}\n\
             sun {{ direction 1 2 2; irradiance 1; angle 6; {penumbra} }}\nmaterial \"m\" {{ metal 0.9; roughness 0.3 }}\n\
             object \"ball\" material=\"m\" {{ sphere 0.7 {{ at 0 0.7 0 }} }}"
        ))
    };
    let [plain, soft] = ["", "penumbra 1000"].map(|penumbra| {
        let scene = scene(penumbra);
        let settings = Settings { size: [48, 32], samples: 256, ..Settings::of(&scene) };
        mean_colour(&render(renderer, &scene, &settings).mean())[1]
    });
    assert!((soft / plain - 1.0).abs() < 0.02, "{soft} {plain}");
}

fn a_penumbra_softens_a_hard_shadow_and_leaves_the_rest(renderer: &Renderer) {
    let scene = |penumbra: &str| {
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 4 0.01; target 0 0 0; fov 5 }}\nrender {{ bounces 0 }}\n\
             sun {{ direction 0 1 0; irradiance 1; angle 0; {penumbra} }}\nobject \"floor\" {{ plane }}\n\
             object \"edge\" {{ box 4 0.1 4 {{ at -2 1 0 }} }}"
        ))
    };
    let shadow = |penumbra: &str| {
        let scene = scene(penumbra);
        let settings = Settings { size: [64, 8], samples: 16, ..Settings::of(&scene) };
        render(renderer, &scene, &settings).mean()
    };
    let (hard, soft) = (shadow(""), shadow("penumbra 4"));
    // The slab covers the picture up to just beyond its middle; the rest is floor.
    let row = |picture: &Picture| (33..60).map(|x| picture.pixels[4 * 64 + x][1]).collect::<Vec<_>>();
    let (hard, soft) = (row(&hard), row(&soft));
    println!("{}: {soft:.2?}", renderer.backend().name);
    assert!(soft.windows(2).all(|pair| pair[0] <= pair[1] + 0.02), "brighter and brighter: {soft:?}");
    assert!(soft[0] < 0.9 * hard[0] && (soft[26] / hard[26] - 1.0).abs() < 0.02, "{hard:?} {soft:?}");
}

fn the_camera_may_be_inside_an_absorbing_medium(renderer: &Renderer) {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 0; target 0 0 -1; fov 1 }\nrender { bounces 4 }\n\
         material \"water\" { glass 1; ior 1.33; absorb 0.5 0.1 0 }\nmaterial \"lamp\" { emit 1 }\n\
         object \"sea\" material=\"water\" { sphere 10 }\nobject \"lamp\" material=\"lamp\" { sphere 1 { at 0 0 -4 } }",
    );
    let settings = Settings { size: [4, 4], samples: 4, ..Settings::of(&scene) };
    let found = mean_colour(&render(renderer, &scene, &settings).mean());
    for (found, absorb) in found.iter().zip([0.5, 0.1, 0.0f64]) {
        assert!((found / (-3.0 * absorb).exp() - 1.0).abs() < 1e-3, "{found}");
    }
}

/// Each object keeps its own surface, so that objects inside clear glass are visible, analytic or sphere-traced.
fn objects_inside_glass_are_visible(renderer: &Renderer) {
    for (glass, inner) in
        [("sphere 1", "sphere 0.4"), ("rounded-box 2 2 2 0.2", "torus 0.3 0.2"), ("box 2", "torus 0.3 0.2")]
    {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 6; target 0 0 0; fov 30 }}\nrender {{ bounces 8 }}\nsky 1\n\
             material \"g\" {{ glass 1 }}\nmaterial \"black\" {{ diffuse 0 }}\n\
             object \"g\" material=\"g\" {{ {glass} }}\nobject \"i\" material=\"black\" {{ {inner} {{ rotate 90 0 0 }} }}"
        ));
        let settings = Settings { size: [64, 64], samples: 16, ..Settings::of(&scene) };
        let picture = render(renderer, &scene, &settings).mean();
        let at = |x: u32, y: u32| mean(&picture, |a, b| a == x && b == y);
        // The ring has a clear hole in its middle; the ball has none.
        let dark = (16..48).flat_map(|y| (16..48).map(move |x| (x, y))).filter(|&(x, y)| at(x, y) < 0.2).count();
        assert!(dark > 60, "{inner} in {glass} on {}: {dark} dark pixels", renderer.backend().name);
        assert!(at(1, 1) > 0.99);
    }
}

/// A ray that leaves a sphere-traced surface does not start beyond a surface at a distance of a millimetre.
fn no_light_leaks_through_a_thin_gap(renderer: &Renderer) {
    for floor in ["rect 400 400", "box 400 0.2 400 { at 0 -0.1 0 }", "rounded-box 400 0.2 400 0.05 { at 0 -0.1 0 }"] {
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 2.2 1.6 3.2; target -0.5 0.1 0; fov 16 }}\nrender {{ bounces 16 }}\n\
             sky \"gradient\" {{ zenith 1; horizon 1; ground 2 0 2 }}\nmaterial \"glass\" {{ glass 1; ior 1.33 }}\n\
             object \"slab\" material=\"glass\" {{ rounded-box 1.4 0.1 1.4 0.01 {{ at -0.8 0.051 0 }} }}\n\
             object \"floor\" {{ {floor} }}"
        ));
        let settings = Settings { size: [96, 54], samples: 32, ..Settings::of(&scene) };
        let picture = render(renderer, &scene, &settings).mean();
        let tint = |p: &[f32; 3]| (p[0] - p[1]).abs() / p[1].max(0.1);
        let tinted = picture.pixels.iter().map(tint).sum::<f32>() / picture.pixels.len() as f32;
        let darkest = block_means(&picture, 6).pixels.iter().map(|p| p[1]).fold(1.0, f32::min);
        println!("{floor} on {}: tint {tinted:.4}, darkest block {darkest:.2}", renderer.backend().name);
        // Two sphere-traced surfaces closer than the detail at this size merge: dark, but no leak.
        assert!(tinted < 0.01 && (darkest > 0.7 || floor.starts_with("rounded")), "{floor}: {tinted} {darkest}");
    }
}

/// A mirror shows the sun's disc with its radiance.
fn mirrors_show_the_sun(renderer: &Renderer) {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 0 4; target 0 0 0; fov 2 }\nrender { bounces 1 }\n\
         sun { direction 0 0 1; irradiance 2; angle 30 }\nmaterial \"m\" { metal 1; roughness 0 }\n\
         object \"m\" material=\"m\" { box 2 }",
    );
    let expected = 2.0 / (PI * 15f32.to_radians().sin().powi(2));
    let settings = Settings { size: [4, 4], samples: 4, ..Settings::of(&scene) };
    let found = mean_colour(&render(renderer, &scene, &settings).mean())[1] as f32;
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

fn the_clamp_removes_fireflies_and_nothing_else(renderer: &Renderer) {
    let scene = parse(LIT_ROOM);
    let settings = Settings { size: [48, 32], samples: 64, ..Settings::of(&scene) };
    let free = render(renderer, &scene, &settings).mean();
    let high = render(renderer, &scene, &Settings { clamp: Some(1e6), ..settings.clone() }).mean();
    let low = render(renderer, &scene, &Settings { clamp: Some(0.02), ..settings.clone() }).mean();
    assert!(relmse(&free, &high).expect("equal sizes") < 1e-9, "a limit above all contributions changes nothing");
    assert!(low.pixels.iter().zip(&free.pixels).all(|(l, f)| (0..3).all(|k| l[k] <= f[k] + 1e-4)));
    // The limit does not apply to emitted and direct light.
    let direct = Settings { bounces: 0, ..settings.clone() };
    let limited = render(renderer, &scene, &Settings { clamp: Some(0.02), ..direct.clone() }).mean();
    assert!(relmse(&limited, &render(renderer, &scene, &direct).mean()).expect("equal sizes") < 1e-9);
}

fn a_rough_fractal_is_no_brighter_than_its_lights(renderer: &Renderer) {
    // Some of its normals face away from rays, where the BSDF once produced pixels of thousands.
    let scene = parse(
        "pathmarch 1\ncamera { position 2.25 1.45 2.5; target 0 0 0; fov 42 }\nrender { bounces 4 }\nsky 1\n\
         sun { direction 0.8 0.75 0.25; irradiance 3; angle 3 }\nmaterial \"it\" { principled 0.8; roughness 0.45 }\n\
         object \"bulb\" material=\"it\" { mandelbulb power=8 iterations=7 }",
    );
    let settings = Settings { size: [96, 64], samples: 64, ..Settings::of(&scene) };
    let picture = render(renderer, &scene, &settings).mean();
    let brightest = picture.pixels.iter().flatten().fold(0.0f32, |most, &channel| most.max(channel));
    println!("{}: brightest pixel {brightest}", renderer.backend().name);
    assert!(brightest < 4.0, "{}", renderer.backend().name);
}

/// A convex surface in a uniform sky, without and with indirect light.
fn surfaces_add_what_they_emit_to_what_they_reflect(renderer: &Renderer) {
    for material in ["diffuse 0.5", "metal 0.5; edge 0.5; roughness 0", "principled 0; ior 1"] {
        let reflected = if material.starts_with("principled") { 0.0 } else { 0.5 };
        let scene = parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 1.5; target 0 0 0; fov 20 }}\nsky 1\n\
             material \"it\" {{ {material}; emission 0.25 }}\nobject \"ball\" material=\"it\" {{ sphere 1 }}"
        ));
        for bounces in [0, 3] {
            let settings = Settings { size: [24, 16], samples: 64, bounces, ..Settings::of(&scene) };
            let found = mean(&render(renderer, &scene, &settings).mean(), |_, _| true);
            let name = renderer.backend().name;
            println!("{name}, {material}, {bounces} bounces: {found:.4}");
            assert!((found - 0.25 - reflected).abs() < 0.01, "{name}, {material}, {bounces} bounces: {found}");
        }
    }
}

/// Radiance of a white floor at `x` metres from the foot of a spot light that is two metres above it.
fn under_a_spot(renderer: &Renderer, light: &str, x: f32, mode: Mode) -> f32 {
    let scene = parse(&format!(
        "pathmarch 1\ncamera {{ position {x} 3 0; target {x} 0 0; up 0 0 -1; fov 0.2 }}\nrender {{ bounces 0 }}\n\
         material \"white\" {{ diffuse 1 }}\nobject \"floor\" material=\"white\" {{ plane }}\n{light}"
    ));
    let settings = Settings { size: [8, 8], samples: 16, mode, ..Settings::of(&scene) };
    mean(&render(renderer, &scene, &settings).mean(), |_, _| true) as f32
}

/// The falloff is a smoothstep of the cosine, in traced pictures and in the preview.
fn a_spot_light_falls_off_by_its_formula(renderer: &Renderer) {
    let light = "spot { at 0 2 0; target 0 0 0; intensity 12.566371; cone 60; blend 0.5 }";
    let outer = 30.0_f32.to_radians().cos();
    let width = 0.5 * (1.0 - outer);
    for x in [0.0_f32, 0.3, 0.5, 0.8, 1.0, 1.1, 1.2] {
        let square: f32 = 4.0 + x * x;
        let cosine = 2.0 / square.sqrt();
        let t = ((cosine - outer) / width).clamp(0.0, 1.0);
        let expected = 4.0 * t * t * (3.0 - 2.0 * t) * cosine / square;
        for mode in [Mode::Path, Mode::Preview] {
            let found = under_a_spot(renderer, light, x, mode);
            println!("{}, {}, {x}: {found:.4}, {expected:.4}", renderer.backend().name, mode.name());
            assert!((found - expected).abs() < 0.004 * expected.max(0.1), "{}, {x}: {found} {expected}", mode.name());
        }
    }
    // A hard edge, and the widest cone.
    let hard = light.replace("blend 0.5", "blend 0");
    let [inside, outside] = [1.1, 1.2].map(|x| under_a_spot(renderer, &hard, x, Mode::Path));
    assert!(inside > 0.5 && outside == 0.0, "{inside} {outside}");
    let wide = light.replace("cone 60; blend 0.5", "cone 180; blend 0");
    let point = "point { at 0 2 0; intensity 12.566371 }";
    let [wide, point] = [wide.as_str(), point].map(|light| under_a_spot(renderer, light, 3.0, Mode::Path));
    assert!((wide / point - 1.0).abs() < 1e-4, "{wide} {point}");
}

/// A light tree, which is built for four lights or more, chooses each spot with a probability that fits.
fn many_spot_lights_add_up(renderer: &Renderer) {
    let spot = |k: i32| {
        format!(
            "spot {{ at {} 2 0; target {} 0 0; intensity 3; cone {} }}\n",
            0.3 * k as f32,
            -0.2 * k as f32,
            50 + 5 * k
        )
    };
    let spots: Vec<String> = (-3..=3).map(spot).collect();
    let together = under_a_spot(renderer, &spots.concat(), 0.2, Mode::Path);
    let alone: f32 = spots.iter().map(|spot| under_a_spot(renderer, spot, 0.2, Mode::Path)).sum();
    println!("{}: {together:.4} together, {alone:.4} one by one", renderer.backend().name);
    assert!((together / alone - 1.0).abs() < 0.02, "{together} {alone}");
}

tests! {
    plain: [pictures_do_not_depend_on_the_scale],
    plain slow: [all_direct_light_estimators_make_the_same_picture],
    on_each_backend: [
        clear_glass_is_invisible_in_a_furnace_at_every_scale,
        the_lens_blurs_by_its_formula,
        fast_caustics_weigh_by_fresnel_and_absorption,
        fast_caustics_count_no_light_twice,
        fast_caustics_keep_emitters_that_are_not_sampled,
        a_penumbra_counts_no_light_twice,
        a_penumbra_softens_a_hard_shadow_and_leaves_the_rest,
        the_camera_may_be_inside_an_absorbing_medium,
        objects_inside_glass_are_visible,
        no_light_leaks_through_a_thin_gap,
        mirrors_show_the_sun,
        the_clamp_removes_fireflies_and_nothing_else,
        a_rough_fractal_is_no_brighter_than_its_lights,
        surfaces_add_what_they_emit_to_what_they_reflect,
        a_spot_light_falls_off_by_its_formula,
        many_spot_lights_add_up,
    ],
}
