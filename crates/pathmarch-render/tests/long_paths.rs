//! Long paths through expensive fields look alike on both backends.
//!
//! Mesa's software Vulkan ends the loops of an invocation after 65,535 turns: pictures of such scenes were wrong there, and
//! nothing reported it (see src/gpu/loop_limit.rs).

use crate::common::random_scenes::random_scene;
use crate::common::{on_both_backends, parse};
use pathmarch_render::{RenderError, Renderer, Settings};
use pathmarch_testing::tests;

/// Scenes that are tried, unless `PATHMARCH_RANDOM_SCENES` gives another number.
const SCENES: u64 = 40;

fn random_scenes_render_alike([cpu, gpu]: &mut [Renderer; 2]) {
    let count = std::env::var("PATHMARCH_RANDOM_SCENES").ok().and_then(|text| text.parse().ok()).unwrap_or(SCENES);
    let (mut refused, mut worst) = (0, 0.0f64);
    let mut wrong = Vec::new();
    for seed in 0..count {
        let scene = parse(&random_scene(seed));
        let settings = Settings { size: [16, 16], samples: 16, ..Settings::of(&scene) };
        let mean = |renderer: &mut Renderer| {
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
    // A surface that alone takes more turns than the limit is rare.
    assert!(refused * 10 <= count, "{refused} of {count} were refused");
}

tests! {
    on_both_backends slow: [random_scenes_render_alike],
}
