//! Scenes of many lights: pictures do not depend on the choice of lights, both backends agree, and odd lights have defined results.

use crate::common::{mean, on_both_backends, on_each_backend, parse, render, with_gpu, worst_block};
use pathmarch_render::metrics::{block_means, relmse};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::testing::{Device, Picture};
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{plain, tests};
use std::f32::consts::FRAC_PI_4;
use std::fmt::Write;

/// Air of a hall with fog in it.
const FOG: &str = "fog { scatter 0.08 0.1 0.12; absorb 0.01; anisotropy 0.4 }\n";

/// Hall with lamps of every kind near a floor and a ball of each kind of surface, a sun and an environment of few pixels, with
/// this in the air.
fn hall(air: &str) -> Scene {
    let mut text = String::from(
        r#"pathmarch 1
camera { position 0 2.5 7; target 0 0.6 0; fov 45 }
render { bounces 2 }
sky "day" elevation=8
material "white" { diffuse 0.7 }
material "metal" { metal 0.9 0.7 0.4; roughness 0.35 }
material "frosted" { glass 0.95; roughness 0.5 }
material "rough" { diffuse 0.6; bump { fbm height=0.02 size=0.1 } }
object "floor" material="white" { plane }
object "metal" material="metal" { sphere 0.5 { at -1.3 0.5 0 } }
object "frosted" material="frosted" { sphere 0.5 { at 0 0.5 0.6 } }
object "rough" material="rough" { sphere 0.5 { at 1.3 0.5 0 } }
"#,
    );
    text += air;
    let shapes = ["sphere 0.05", "rect 0.2 0.1", "disc 0.08", "box 0.1", "torus 0.06 0.02"];
    for k in 0..30 {
        let [x, z] = [k % 6, k / 6].map(|place: i32| place as f32 * 1.1 - 2.6);
        let y = 0.6 + 0.07 * (k * 7 % 11) as f32;
        let [r, g, b] = [3.0, 5.0, 7.0].map(|step: f32| 6.0 + 5.0 * (step * k as f32).sin());
        write!(
            text,
            "material \"l{k}\" {{ emit {r:.2} {g:.2} {b:.2} }}\nobject \"l{k}\" material=\"l{k}\" {{ {} {{ rotate {} 0 \
             {}; at {x:.2} {y:.2} {z:.2} }} }}\npoint {{ at {z:.2} {y:.2} {x:.2}; intensity {:.2} }}\n",
            shapes[k as usize % shapes.len()],
            k * 50,
            k * 70,
            0.1 * b
        )
        .expect("writing to a string");
    }
    parse(&text)
}

/// Blocks of pictures of this number of seeds differ by no more than their noise.
fn pictures_of_each_choice_of_lights_agree(air: &str, seeds: u32) {
    let scene = hall(air);
    let blocks = |by_place: bool, samples: u32| -> Vec<(f64, f64)> {
        let of_seed = |seed| {
            let settings = Settings { size: [48, 32], samples, seed, ..Settings::of(&scene) };
            let picture =
                if by_place { Picture::new(&scene, &settings) } else { Picture::with_light_table(&scene, &settings) };
            block_means(&picture.on_cpu(samples).mean(), 8)
        };
        let pictures: Vec<_> = (0..seeds).map(|seed| of_seed(seed + 100 * u32::from(by_place))).collect();
        let count = f64::from(seeds);
        let of_block = |k: usize| {
            let values = pictures.iter().map(|picture| f64::from(picture.pixels[k / 3][k % 3]));
            let mean = values.clone().sum::<f64>() / count;
            (mean, values.map(|v| (v - mean).powi(2)).sum::<f64>() / (count * (count - 1.0)))
        };
        (0..3 * pictures[0].pixels.len()).map(of_block).collect()
    };
    let (tree, table) = (blocks(true, 64), blocks(false, 128));
    let z: Vec<f64> = tree.iter().zip(&table).map(|((a, s), (b, t))| (a - b) / (s + t).sqrt().max(1e-6)).collect();
    let square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    let largest = z.iter().fold(0.0f64, |largest, z| largest.max(z.abs()));
    let variance = |blocks: &[(f64, f64)]| blocks.iter().map(|(_, variance)| variance).sum::<f64>();
    let gain = 2.0 * variance(&table) / variance(&tree);
    println!("mean z² {square:.2}, largest |z| {largest:.2}, variance of one sample {gain:.1} times lower");
    assert!(square < 1.7 && largest < 5.5, "{square} {largest}");
    assert!(gain > 1.2, "{gain}");
}

fn pictures_do_not_depend_on_the_choice_of_lights() {
    pictures_of_each_choice_of_lights_agree("", 24);
}

fn pictures_of_fog_do_not_depend_on_the_choice_of_lights() {
    pictures_of_each_choice_of_lights_agree(FOG, 64);
}

fn backends_agree_on_lights(renderers: &mut [Renderer; 2], air: &str) {
    let scene = hall(air);
    let settings = Settings { size: [48, 32], samples: 64, ..Settings::of(&scene) };
    let [cpu, gpu] = renderers.each_ref().map(|renderer| render(renderer, &scene, &settings).mean());
    let (error, block) = (relmse(&gpu, &cpu).expect("equal sizes"), worst_block(&gpu, &cpu, 16));
    println!("relMSE {error:.1e}, worst block {block:.1e}");
    // The same random numbers: other lights would give other noise, with a relMSE of 1e-2.
    assert!(error < 2e-3 && block < 0.02, "{error} {block}");
}

fn both_backends_choose_the_same_lights(renderers: &mut [Renderer; 2]) {
    backends_agree_on_lights(renderers, "");
}

fn both_backends_choose_the_same_lights_in_fog(renderers: &mut [Renderer; 2]) {
    backends_agree_on_lights(renderers, FOG);
}

/// The tree is in uniform memory on software adapters if it is small, and in storage memory otherwise.
fn the_memory_of_the_tree_does_not_matter() {
    let scene = hall("");
    let picture = Picture::new(&scene, &Settings { size: [24, 16], ..Settings::of(&scene) });
    let [a, b] = ["software", "discrete GPU"].map(|kind| {
        let device = Device::open_as(kind).expect("a GPU adapter");
        assert_eq!(device.has_uniform_light_tree(&picture), device.is_software());
        picture.on_gpu(&device, 2).expect("renders").sums
    });
    assert!(a.iter().flatten().sum::<f32>() > 0.0);
    let difference = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs() / (1.0 + a));
    assert!(difference.fold(0.0, f32::max) < 1e-3);
}

fn ranges_of_samples_add_up(renderer: &Renderer) {
    let scene = hall("");
    let settings = Settings { size: [24, 16], samples: 12, splitting: Some(1), ..Settings::of(&scene) };
    let whole = render(renderer, &scene, &settings);
    let mut parts = render(renderer, &scene, &Settings { samples: 5, ..settings.clone() });
    let rest = render(renderer, &scene, &Settings { first_sample: 5, samples: 7, ..settings.clone() });
    parts.add(&rest).expect("equal sizes");
    for (a, b) in parts.sums.iter().flatten().zip(whole.sums.iter().flatten()) {
        assert!((a - b).abs() <= 1e-4 * b.abs().max(1.0), "{a} {b}");
    }
}

/// Ten thousand lamps in one point light a floor as one lamp of their sum does.
fn lamps_in_one_point_are_one_lamp(renderer: &Renderer) {
    let view = "pathmarch 1\ncamera { position 0 3 0.01; target 0 0 0; fov 40 }\nrender { bounces 0 }\n\
                material \"grey\" { diffuse 0.5 }\nobject \"floor\" material=\"grey\" { rect 4 4 }\n";
    let lamp = |intensity: f32| format!("point {{ at 0.2 1 0.1; intensity {intensity} }}\n");
    let settings = |scene: &Scene| Settings { size: [16, 16], samples: 2, ..Settings::of(scene) };
    let (one, many) =
        (parse(&(view.to_owned() + &lamp(20.0))), parse(&(view.to_owned() + &lamp(0.002).repeat(10_000))));
    let [one, many] = [one, many].map(|scene| render(renderer, &scene, &settings(&scene)).mean());
    let error = worst_block(&many, &one, 4);
    assert!(mean(&one, |_, _| true) > 0.1 && error < 1e-3, "{error}");
}

/// Lamps below the floor, behind a wall, without power, and so far away that their light is zero.
fn lamps_that_light_nothing_change_nothing(renderer: &Renderer) {
    let lit = "pathmarch 1\ncamera { position 0 2 4; target 0 0 0; fov 40 }\nrender { bounces 1 }\n\
               material \"grey\" { diffuse 0.5 }\nmaterial \"lamp\" { emit 8 }\nmaterial \"dark\" { emit 0 }\n\
               object \"floor\" material=\"grey\" { plane }\nobject \"wall\" material=\"grey\" { rect 50 50 { normal 0 0 1; at 0 0 -6 } }\n\
               point { at 0.5 1.5 0.5; intensity 6 }\npoint { at -0.5 1.5 0.5; intensity 6 }\n";
    let unseen = "point { at 0 -1 0; intensity 6 }\nobject \"below\" material=\"lamp\" { sphere 0.5 { at 1 -2 0 } }\n\
                  object \"behind\" material=\"lamp\" { sphere 0.5 { at 0 2 -9 } }\npoint { at 1 1 1; intensity 0 }\n\
                  object \"dark\" material=\"dark\" { rect 0.1 0.1 { at 0 40 0 } }\npoint { at 0 1e9 0; intensity 1e-6 }\n";
    let [without, with] = [lit.to_owned(), lit.to_owned() + unseen].map(|text| {
        let scene = parse(&text);
        render(renderer, &scene, &Settings { size: [32, 24], samples: 256, ..Settings::of(&scene) }).mean()
    });
    let error = worst_block(&with, &without, 8);
    println!("worst block {error:.1e}");
    assert!(error < 0.03, "{error}");
}

/// A scene whose only lamps light nothing is black, and every sample is finite.
fn lamps_that_nothing_can_see(renderer: &Renderer) {
    let scene = parse(
        "pathmarch 1\ncamera { position 0 2 4; target 0 0 0 }\nmaterial \"grey\" { diffuse 0.5 }\n\
         object \"floor\" material=\"grey\" { plane }\npoint { at 0 -1 0; intensity 6 }\npoint { at 1 -1 0; intensity 6 }\n\
         point { at 2 -1 0; intensity 6 }\npoint { at 3 -1 0; intensity 6 }\n",
    );
    let picture = render(renderer, &scene, &Settings { size: [16, 12], samples: 4, ..Settings::of(&scene) }).mean();
    assert!(picture.pixels.iter().flatten().all(|&value| value == 0.0));
}

/// Ceiling of 4,000 lamps: balls on a lattice in rings, panels as one union, and as many points. The modifiers of the wave are
/// declared after those of the rings, which lamps do not keep.
fn ceiling(counts: [u32; 2], points: u32) -> Scene {
    let [columns, rows] = counts;
    let mut text = format!(
        "pathmarch 1\ncamera {{ position 0 2 7; target 0 1 0; fov 60 }}\nrender {{ bounces 1 }}\n\
         material \"white\" {{ diffuse 0.7 }}\nmaterial \"metal\" {{ metal 0.9; roughness 0.3 }}\n\
         material \"warm\" {{ emit 30 20 10 }}\nmaterial \"cold\" {{ emit 10 20 30 }}\n\
         object \"floor\" material=\"white\" {{ plane }}\n\
         object \"rings\" material=\"warm\" {{ repeat 0.5 0 0.5 count-x={columns} count-z={rows} {{ polar 8 {{ sphere 0.02 {{ at 0.2 \
         3 0 }} }} }} }}\n\
         object \"wave\" material=\"metal\" {{ shell 0.01 {{ twist 0.05 {{ torus 1.2 0.4 {{ at 0 0.5 0 }} }} }} }}\n\
         object \"panels\" material=\"cold\" {{ union {{\n"
    );
    for k in 0..rows * columns {
        let [x, z] = [k % columns, k / columns].map(|k| 0.5 * k as f32);
        let (x, z) = (x - 0.25 * (columns - 1) as f32, z - 0.25 * (rows - 1) as f32);
        writeln!(text, "rect 0.1 0.05 {{ rotate 180 0 0; at {x} 3 {z} }}").expect("writing to a string");
    }
    text += "} }\n";
    for k in 0..points {
        let at = |step: f32| 8.0 * (step * k as f32).fract() - 4.0;
        writeln!(text, "point {{ at {} {} {}; intensity 0.001 }}", at(0.618), 2.6 + 0.02 * at(0.755), at(0.57))
            .expect("writing to a string");
    }
    parse(&text)
}

fn backends_agree_on_thousands_of_lamps(renderers: &mut [Renderer; 2]) {
    let scene = ceiling([20, 22], 2000);
    assert_eq!(scene.field.leaves().len(), 2 + 20 * 22 * 9);
    let settings = Settings { size: [48, 32], samples: 8, ..Settings::of(&scene) };
    let [cpu, gpu] = renderers.each_ref().map(|renderer| render(renderer, &scene, &settings).mean());
    let (error, block) = (relmse(&gpu, &cpu).expect("equal sizes"), worst_block(&gpu, &cpu, 16));
    println!("relMSE {error:.1e}, worst block {block:.1e}");
    assert!(error < 2e-3 && block < 0.02, "{error} {block}");
}

/// Copies and parts of unions light as objects of their own do, which a march enlarges by no tolerance.
fn copies_of_lamps_light_as_objects_do(renderer: &Renderer) {
    let text = "pathmarch 1\ncamera { position 0 2 7; target 0 1 0; fov 60 }\nrender { bounces 1 }\n\
                material \"white\" { diffuse 0.7 }\nmaterial \"warm\" { emit 30 20 10 }\nmaterial \"cold\" { emit 10 20 30 }\n\
                object \"floor\" material=\"white\" { plane }\nobject \"wave\" material=\"white\" { torus 1.2 0.4 { at 0 0.5 0 } }\n";
    let copies = "object \"rings\" material=\"warm\" { repeat 0.5 0 0.5 count-x=3 count-z=2 { polar 8 { sphere 0.02 { at 0.2 3 0 } } } }\n\
                  object \"panels\" material=\"cold\" { union { rect 0.4 0.5 { rotate 180 0 0; at -1 2 0 }; box 0.2 { at 1 2 0 } } }\n";
    let mut objects = "object \"rect\" material=\"cold\" { rect 0.4 0.5 { rotate 180 0 0; at -1 2 0 } }\n\
                       object \"box\" material=\"cold\" { box 0.2 { at 1 2 0 } }\n"
        .to_owned();
    for k in 0..48 {
        let (sine, cosine) = (k as f32 * FRAC_PI_4).sin_cos();
        let (x, z) = (0.5 * (k / 8 % 3) as f32 - 0.5 + 0.2 * cosine, 0.5 * (k / 24) as f32 - 0.25 + 0.2 * sine);
        writeln!(objects, "object \"o{k}\" material=\"warm\" {{ sphere 0.02 {{ at {x} 3 {z} }} }}")
            .expect("writing to a string");
    }
    let [copies, objects] = [copies, &objects].map(|lamps| {
        let scene = parse(&(text.to_owned() + lamps));
        assert_eq!(scene.field.leaves().len(), 52);
        render(renderer, &scene, &Settings { size: [48, 32], samples: 128, ..Settings::of(&scene) }).mean()
    });
    let (block, mean) = (worst_block(&copies, &objects, 16), mean(&objects, |_, _| true));
    println!("worst block {block:.1e}, mean {mean:.3}");
    assert!(block < 0.01 && mean > 0.02, "{block} {mean}");
}

tests! {
    plain slow: [pictures_do_not_depend_on_the_choice_of_lights],
    plain long: [pictures_of_fog_do_not_depend_on_the_choice_of_lights],
    on_each_backend: [
        ranges_of_samples_add_up,
        lamps_in_one_point_are_one_lamp,
        lamps_that_light_nothing_change_nothing,
        lamps_that_nothing_can_see,
        copies_of_lamps_light_as_objects_do,
    ],
    on_both_backends: [
        both_backends_choose_the_same_lights,
        both_backends_choose_the_same_lights_in_fog,
        backends_agree_on_thousands_of_lamps,
    ],
    with_gpu: [the_memory_of_the_tree_does_not_matter],
}
