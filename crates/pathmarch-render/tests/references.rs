//! Pictures compared with those of an established path tracer, and both backends compared with each other on these scenes.
//! `data/README.md` describes each reference and the expected differences.

use crate::common::{data, on_both_backends, render, worst_block};
use pathmarch_render::image::{self, Picture, PictureKind};
use pathmarch_render::metrics::{compare, mean_colour, relmse};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Renderer, Settings};
use pathmarch_testing::{long_tests_run, plain, tests};

/// References that take long, for their fog: only long tests compare them with the established path tracer.
const LONG: [&str; 2] = ["fog_point", "fog_area"];

/// References: name, number of samples at which our noise is well below the limits, and limit of the relative difference of a
/// block of 16 by 16 pixels.
const REFERENCES: [(&str, u32, f32); 24] = [
    ("furnace_050", 64, 0.005),
    ("diffuse_sphere_plane", 128, 0.01),
    ("diffuse_sphere_plane_area", 128, 0.01),
    ("cornell", 192, 0.03),
    // Mitsuba uses a separable Smith term: 2 % less on the roughest ball, more at its edge.
    ("rough_metal", 512, 0.04),
    ("rough_metal_correlated", 256, 0.02),
    ("mirror", 256, 0.02),
    ("glass", 128, 0.02),
    ("glass_absorb", 128, 0.02),
    ("rough_glass", 128, 0.02),
    ("environment", 256, 0.02),
    ("environment_rotated", 128, 0.02),
    ("sun", 256, 0.02),
    ("many_lights", 128, 0.02),
    // Mitsuba does not compensate for single scattering: 0.6 % less on the metal.
    ("principled", 256, 0.03),
    ("lens", 128, 0.02),
    ("box_light", 512, 0.02),
    // Photons blur the edges of caustics by about a pixel.
    ("caustic_point", 512, 0.02),
    // A point light in fog: rare paths that come close to it are bright, in both renderers. One such pixel makes a block of the
    // reference 5 % brighter.
    ("fog_point", 1024, 0.06),
    ("fog_area", 1536, 0.03),
    ("subsurface", 256, 0.02),
    ("smoke", 256, 0.03),
    ("nested_glass", 128, 0.02),
    ("thin_glass", 128, 0.02),
];

fn pictures_agree_with_mitsuba() {
    let cpu = Renderer::open(Backend::Cpu, None).expect("the CPU backend");
    let mut wrong = Vec::new();
    let is_compared = |name: &str| !LONG.contains(&name) || long_tests_run();
    for (name, samples, limit) in REFERENCES.into_iter().filter(|(name, ..)| is_compared(name)) {
        let scene = Scene::load(data(&format!("{name}.kdl"))).expect("a valid scene");
        let reference = image::load(&data(&format!("{name}.exr"))).expect("a picture").picture;
        let picture = render(&cpu, &scene, &Settings { samples, ..Settings::of(&scene) }).mean();
        let result = compare(&picture, &reference, PictureKind::Hdr).expect("equal sizes");
        let worst = worst_block(&picture, &reference, 16);
        let line = format!(
            "{name}, {samples} samples: relMSE {:.2e}, FLIP {:.4}, worst 16x16 block {:.2} %",
            result.relmse,
            result.flip,
            worst * 100.0
        );
        println!("{line}");
        let noise = if name == "fog_point" { 1.2e-2 } else { 2e-3 };
        if result.relmse > noise || worst > limit {
            wrong.push(line);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Caustics through glass and over a mirror, which Mitsuba's light tracer does not show. The reference is noisy where the ball
/// reflects the lamp.
fn seen_caustics_agree_with_luxcore() {
    let cpu = Renderer::open(Backend::Cpu, None).expect("the CPU backend");
    let scene = Scene::load(data("seen_caustics.kdl")).expect("a valid scene");
    let reference = image::load(&data("seen_caustics.exr")).expect("a picture").picture;
    let picture = render(&cpu, &scene, &Settings { samples: 1024, ..Settings::of(&scene) }).mean();
    let mean_in = |picture: &Picture, [x, y, width, height]: [u32; 4]| {
        let rows = (y..y + height).flat_map(|y| (x..x + width).map(move |x| (y * picture.width + x) as usize));
        rows.map(|pixel| picture.pixels[pixel].iter().sum::<f32>()).sum::<f32>() / (3 * width * height) as f32
    };
    for (name, region, limit) in [
        ("all", [0, 0, 96, 72], 0.015),
        ("through the pane", [18, 38, 24, 10], 0.02),
        ("through the block", [58, 48, 24, 8], 0.03),
        ("in the mirror", [40, 24, 16, 8], 0.03),
        ("below the pane", [10, 54, 40, 12], 0.02),
    ] {
        let [ours, theirs] = [&picture, &reference].map(|picture| mean_in(picture, region));
        println!("{name}: {ours:.4} {theirs:.4}");
        assert!((ours / theirs - 1.0).abs() < limit, "{name}: {ours} {theirs}");
    }
}

fn references_render_alike_on_both_backends(renderers: &mut [Renderer; 2]) {
    let mut wrong = Vec::new();
    for (name, ..) in REFERENCES {
        let scene = Scene::load(data(&format!("{name}.kdl"))).expect("a valid scene");
        let settings = Settings { size: [128, 96], samples: 8, ..Settings::of(&scene) };
        let [a, b] = [0, 1].map(|k| render(&renderers[k], &scene, &settings).mean());
        let difference = relmse(&a, &b).expect("equal sizes");
        let (a, b) = (mean_colour(&a), mean_colour(&b));
        let mean = (0..3).map(|k| (a[k] / b[k] - 1.0).abs()).fold(0.0, f64::max);
        let line = format!("{name}: relMSE {difference:.1e}, means {:.3} % apart", mean * 100.0);
        println!("{line}");
        // Paths through glass and over mirrors occasionally diverge by rounding.
        if difference > 5e-3 || mean > 2e-3 {
            wrong.push(line);
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

tests! {
    plain slow: [pictures_agree_with_mitsuba, seen_caustics_agree_with_luxcore],
    on_both_backends slow: [references_render_alike_on_both_backends],
}
