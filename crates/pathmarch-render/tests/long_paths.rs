//! Long paths through expensive fields: both backends agree.
//!
//! Mesa's software Vulkan ends the loops of an invocation after 65,535 iterations. Without a remedy, pictures of such scenes are
//! wrong, and no error is reported (see src/backend/gpu/loop_limit.rs).

use crate::common::random_scenes::random_scene;
use crate::common::{on_both_backends, parse, render};
use pathmarch_render::{RenderError, Renderer, Settings};
use pathmarch_testing::tests;

/// Seeds of the random scenes, unless `PATHMARCH_RANDOM_SCENES` sets others: a number of them, or a range such as `800-1000`.
const SEEDS: std::ops::Range<u64> = 0..20;

fn seeds() -> std::ops::Range<u64> {
    let Ok(text) = std::env::var("PATHMARCH_RANDOM_SCENES") else { return SEEDS };
    let (first, end) = text.split_once('-').unwrap_or(("0", &text));
    let seed = |text: &str| text.parse().expect("PATHMARCH_RANDOM_SCENES is a number, or a range such as 800-1000");
    seed(first)..seed(end)
}

/// A path through copies of copies takes more loop iterations than Mesa allows; the picture was 7 % too dark.
fn copies_of_copies_render_alike([cpu, gpu]: &mut [Renderer; 2]) {
    let scene = parse(
        "pathmarch 1\ncamera { position 3 2 6; target 0 0 0; fov 45 }\nrender { bounces 12 }\nsky 0.6\n\
         sun { direction 1 2 1; irradiance 2; angle 3 }\nmaterial \"white\" { diffuse 0.9 }\n\
         object \"copies\" material=\"white\" { repeat 4 4 4 count=3 { repeat 1 1 1 count=3 { union smooth=0.1 { \
         mandelbulb iterations=10 { scale 0.3 }; julia iterations=10 { scale 0.3; at 0.2 0 0 } } } } }",
    );
    let settings = Settings { size: [24, 24], samples: 8, ..Settings::of(&scene) };
    let [on_cpu, on_gpu] = [cpu, gpu].map(|renderer| render(renderer, &scene, &settings).mean().mean_colour()[1]);
    println!("{on_cpu:.5} on the CPU, {on_gpu:.5} on the GPU");
    assert!((on_gpu / on_cpu - 1.0).abs() < 0.01, "{on_cpu} on the CPU, {on_gpu} on the GPU");
}

fn random_scenes_render_alike([cpu, gpu]: &mut [Renderer; 2]) {
    let seeds = seeds();
    let count = seeds.end - seeds.start;
    let (mut refused, mut worst) = (0, 0.0f64);
    let mut wrong = Vec::new();
    for seed in seeds {
        let scene = parse(&random_scene(seed));
        let settings = Settings { size: [16, 16], samples: 16, ..Settings::of(&scene) };
        let mean = |renderer: &Renderer| {
            let picture = renderer.render(&scene, &settings)?.mean();
            let sum: f64 = picture.pixels.iter().flatten().map(|&value| f64::from(value)).sum();
            Ok::<_, RenderError>(sum / (3.0 * picture.pixels.len() as f64))
        };
        let on_cpu = mean(cpu).expect("the CPU renders everything");
        match mean(gpu) {
            Ok(on_gpu) => {
                let difference = (on_gpu / on_cpu - 1.0).abs();
                worst = worst.max(difference);
                if difference > 0.05 {
                    wrong.push(format!("seed {seed}: {on_cpu:.5} on the CPU, {on_gpu:.5} on the GPU"));
                }
            }
            Err(error) => {
                assert!(error.to_string().contains("ends the loops"), "seed {seed}: {error}");
                refused += 1;
            }
        }
    }
    println!("{count} scenes: {refused} refused, means differ by at most {:.3} %", 100.0 * worst);
    assert!(wrong.is_empty(), "{} of {count}:\n{}", wrong.len(), wrong.join("\n"));
    // A single surface rarely exceeds the limit.
    assert!(refused * 10 <= count, "{refused} of {count} were refused");
}

tests! {
    on_both_backends slow: [copies_of_copies_render_alike, random_scenes_render_alike],
}
