//! Emitter edges: further camera rays leave the picture as it is and make it less noisy, and every sample counts once.

use crate::common::{cpu, on_both_backends, on_each_backend, parse, render};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::parts::Rect;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{plain, some_of, tests};

/// Small lamps of several shapes, one behind glass, one that also reflects, and one that hides another.
const LAMPS: &str = r#"pathmarch 1
camera { position 0 1 4; target 0 0.9 0; fov 45 }
render { bounces 3 }
sky 0.1
material "white" { diffuse 0.7 }
material "glass" { glass 0.9; absorb 0.5 0.2 0.1 }
material "lamp" { emit 30 20 10 }
material "blue" { emit 4 8 30 }
material "screen" { diffuse 0.3; emission 12 6 3 }
object "floor" material="white" { plane }
object "ball" material="lamp" { sphere 0.05 { at -0.9 1.2 0 } }
object "far" material="blue" { sphere 0.02 { at -0.4 1.6 -1 } }
object "strip" material="lamp" { box 0.5 0.03 0.03 { at 0.3 1.7 0; rotate 0 20 12 } }
object "ring" material="blue" { torus 0.15 0.02 { at 0.9 1.2 0; rotate 60 0 10 } }
object "screen" material="screen" { rect 0.6 0.4 { normal 0 0 1; at -0.4 0.6 0 } }
object "hidden" material="lamp" { sphere 0.1 { at -0.4 0.6 -0.3 } }
object "pane" material="glass" { box 0.5 0.7 0.04 { at 0.6 0.6 0.5 } }
object "seen" material="lamp" { sphere 0.04 { at 0.6 0.6 0 } }
"#;

/// The lamps through a lens.
fn through_lens(radius: f32, focus: u32) -> String {
    LAMPS.replace("fov 45", &format!("fov 45; lens radius={radius} focus={focus}"))
}

fn settings(scene: &Scene, samples: u32, seed: u32, edges: bool) -> Settings {
    // Not a multiple of the tiles' size.
    Settings {
        size: [93, 61],
        samples,
        seed,
        splitting: Some(1),
        path_reuse: Some(false),
        emitter_edges: Some(edges),
        ..Settings::of(scene)
    }
}

fn traces_edges(renderer: &Renderer, scene: &Scene, settings: &Settings) -> bool {
    renderer.start(scene, settings).expect("starts").traces_emitter_edges()
}

fn pictures_are_the_same() {
    for text in some_of([&through_lens(0.25, 2), LAMPS, &through_lens(0.05, 3)], 3) {
        let scene = parse(text);
        let picture = |seed, edges| render(&cpu(), &scene, &settings(&scene, 2048, seed, edges)).mean();
        let reference = picture(1, false);
        let error = |picture: &Picture| relmse(picture, &reference).expect("equal sizes");
        let (without, with) = (picture(2, false), picture(2, true));
        assert!(error(&with) < 1.1 * error(&without), "{:.2e}, without {:.2e}", error(&with), error(&without));
        // With one seed, the pictures differ by the further rays alone.
        for (mean, expected) in mean_colour(&with).iter().zip(&mean_colour(&without)) {
            assert!((mean / expected - 1.0).abs() < 1.5e-3, "{mean} is not {expected}");
        }
    }
}

fn edges_have_less_noise(renderer: &Renderer) {
    // Nothing but the lamps before a bright sky, so that all noise is at their edges.
    // Through the lens, without those that are seen from most of it.
    for (text, hidden) in [(LAMPS, vec![]), (&through_lens(0.25, 2), vec!["strip", "ring"])] {
        let hidden = [vec!["floor", "pane", "screen\" m"], hidden].concat();
        let lines = text.lines().filter(|line| !hidden.iter().any(|name| line.contains(name)));
        let scene = parse(&lines.collect::<Vec<_>>().join("\n"));
        let picture = |samples, seed, edges| render(renderer, &scene, &settings(&scene, samples, seed, edges)).mean();
        let reference = picture(512, 1, true);
        let error = |picture: &Picture| relmse(picture, &reference).expect("equal sizes");
        let (without, with) = (error(&picture(8, 2, false)), error(&picture(8, 3, true)));
        println!("relMSE {with:.2e}, without {without:.2e}");
        assert!(with < 0.1 * without, "{with:.2e}, without {without:.2e}");
    }
}

fn both_backends_trace_the_same_rays(renderers: &mut [Renderer; 2]) {
    // Software adapters do not split where the field has loops, as that of a torus.
    let without_loops = LAMPS.replace("torus 0.15 0.02", "box 0.2 0.04 0.04");
    for (text, splitting) in [(LAMPS, 1), (&through_lens(0.25, 2), 1), (&without_loops, 1), (&without_loops, 3)] {
        let scene = parse(text);
        let settings = Settings { splitting: Some(splitting), ..settings(&scene, 24, 0, true) };
        let [cpu, gpu] = renderers.each_ref().map(|renderer| {
            assert!(traces_edges(renderer, &scene, &settings));
            render(renderer, &scene, &settings).mean()
        });
        let error = relmse(&gpu, &cpu).expect("equal sizes");
        assert!(error < 1e-5, "{splitting} paths to a ray: {error:.2e}");
    }
}

fn samples_and_crops_add_up(renderer: &Renderer) {
    let scene = parse(LAMPS);
    let whole = settings(&scene, 11, 0, true);
    let film = render(renderer, &scene, &whole);
    let mut parts = render(renderer, &scene, &Settings { samples: 4, ..whole.clone() });
    let rest = Settings { first_sample: 4, samples: 7, ..whole.clone() };
    parts.add(&render(renderer, &scene, &rest)).expect("equal sizes");
    for (a, b) in film.sums.iter().flatten().zip(parts.sums.iter().flatten()) {
        assert!((a - b).abs() <= 1e-4 * a.abs().max(1.0), "{a} {b}");
    }
    let crop = Rect { x: 13, y: 5, width: 40, height: 33 };
    let cropped = render(renderer, &scene, &Settings { crop: Some(crop), ..whole });
    for y in 0..crop.height {
        for x in 0..crop.width {
            let whole = film.sums[((y + crop.y) * film.width + x + crop.x) as usize];
            assert_eq!(cropped.sums[(y * crop.width + x) as usize], whole, "pixel ({x}, {y})");
        }
    }
}

fn pictures_decide_for_themselves() {
    let scene = parse(LAMPS);
    let large = Settings { size: [640, 360], samples: 64, ..Settings::of(&scene) };
    assert!(traces_edges(&cpu(), &scene, &large));
    assert!(!traces_edges(&cpu(), &scene, &Settings { emitter_edges: Some(false), ..large.clone() }));
    // Too few samples.
    assert!(!traces_edges(&cpu(), &scene, &Settings { size: [64, 36], ..large.clone() }));
    let fog = parse(&format!("{LAMPS}fog {{ scatter 0.02 }}\n"));
    assert!(!traces_edges(&cpu(), &fog, &large));
    let dark = parse(
        "pathmarch 1\ncamera { position 0 1 4; target 0 1 0 }\nsky 1\nmaterial \"lamp\" { emit 5 }\n\
         object \"behind\" material=\"lamp\" { sphere 1 { at 0 1 9 } }\n",
    );
    assert!(!traces_edges(&cpu(), &dark, &large), "the lamp is behind the camera");
}

tests! {
    on_both_backends: [both_backends_trace_the_same_rays],
    on_each_backend: [edges_have_less_noise, samples_and_crops_add_up],
    plain: [pictures_decide_for_themselves],
    plain slow: [pictures_are_the_same],
}
