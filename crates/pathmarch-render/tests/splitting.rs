//! Splitting: pictures do not depend on the number of paths that share a camera ray, and every sample counts once.

use crate::common::{on_each_backend, parse, render};
use pathmarch_render::metrics::relmse;
use pathmarch_render::{MAX_SPLITTING, Renderer, Settings};
use pathmarch_testing::tests;

/// Closed room with glass, metal, a visible lamp and a sphere-traced object.
pub const ROOM: &str = r#"pathmarch 1
camera { position 0 1 2.8; target 0 0.9 0; fov 50 }
render { bounces 5 }
sky 0.3 0.4 0.6
material "white" { diffuse 0.7 }
material "red" { diffuse 0.6 0.1 0.1 }
material "metal" { metal 0.9 0.7 0.4; roughness 0.4 }
material "glass" { glass 0.95 }
material "lamp" { emit 9 8 6 }
object "floor" material="white" { plane }
object "back" material="white" { rect 4 4 { normal 0 0 1; at 0 1 -1.2 } }
object "left" material="red" { rect 4 4 { normal 1 0 0; at -1.2 1 0 } }
object "metal" material="metal" { sphere 0.4 { at -0.5 0.4 -0.3 } }
object "glass" material="glass" { box 0.4 0.8 0.4 { at 0.4 0.4 -0.2; rotate 0 30 0 } }
object "ring" material="red" { torus 0.3 0.08 { at 0 1.3 -0.6; rotate 70 0 0 } }
object "lamp" material="lamp" { sphere 0.15 { at 0.7 1.7 0 } }
"#;

fn paths_that_share_a_ray_make_the_same_picture(renderer: &Renderer) {
    let scene = parse(ROOM);
    let picture = |splitting, seed| {
        let settings =
            Settings { size: [64, 40], samples: 1024, seed, splitting: Some(splitting), ..Settings::of(&scene) };
        render(renderer, &scene, &settings).mean()
    };
    let reference = picture(1, 1);
    let noise = relmse(&picture(1, 2), &reference).expect("equal sizes");
    for splitting in [3, MAX_SPLITTING] {
        let error = relmse(&picture(splitting, 2), &reference).expect("equal sizes");
        println!("{splitting} paths to a ray: relMSE {error:.2e}, of one {noise:.2e}");
        assert!(error < 1.6 * noise + 1e-5, "{splitting} paths to a ray: {error:.2e}, of one {noise:.2e}");
    }
}

fn ranges_of_samples_add_up_with_splitting(renderer: &Renderer) {
    let scene = parse(ROOM);
    let settings = Settings { size: [32, 20], samples: 23, splitting: Some(4), ..Settings::of(&scene) };
    let whole = render(renderer, &scene, &settings);
    let mut parts = render(renderer, &scene, &Settings { samples: 18, ..settings.clone() });
    let rest = Settings { first_sample: 18, samples: 5, ..settings.clone() };
    parts.add(&render(renderer, &scene, &rest)).expect("equal sizes");
    assert_eq!((whole.samples, parts.samples), (23, 23));
    for (a, b) in whole.sums.iter().flatten().zip(parts.sums.iter().flatten()) {
        assert!((a - b).abs() <= 1e-5 * a.abs().max(1.0), "{a} {b}");
    }
}

fn a_picture_that_is_stopped_has_as_many_samples_everywhere(renderer: &Renderer) {
    let scene = parse(ROOM);
    // Far more samples than the test renders, so that the last ones are begun and not finished.
    let settings = Settings { size: [320, 200], samples: 4096, splitting: Some(8), ..Settings::of(&scene) };
    let mut job = renderer.start(&scene, &settings).expect("starts");
    while job.samples_done() <= 24.0 {
        job.advance(settings.samples).expect("goes on");
    }
    let stopped = job.film().expect("is read");
    assert_eq!(stopped.samples % 8, 0);
    let settings = Settings { samples: stopped.samples, ..settings };
    let whole = render(renderer, &scene, &settings);
    assert!(stopped.sums == whole.sums, "of {} samples", stopped.samples);
}

tests! {
    on_each_backend: [ranges_of_samples_add_up_with_splitting],
    on_each_backend slow: [
        paths_that_share_a_ray_make_the_same_picture,
        a_picture_that_is_stopped_has_as_many_samples_everywhere,
    ],
}
