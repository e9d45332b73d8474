//! Path reuse: pixels that share light show the same picture, where it pays with less noise, and every sample counts once.

use crate::common::{cpu, on_both_backends, parse, render, scenes};
use crate::splitting::ROOM;
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{mean_colour, relmse};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{plain, tests};

/// The room of splitting with more surfaces: a textured one, one that glows, and one that is black in blue.
fn room() -> Scene {
    room_with(ROOM)
}

fn room_with(room: &str) -> Scene {
    let more = r#"
material "tiles" { diffuse { checker size=0.4 { colour 0.2; colour 0.8 0.7 0.5 } } }
material "glowing" { diffuse 0.5; emission 0.3 0.1 0 }
material "yellow" { diffuse 0.6 0.5 0 }
object "step" material="tiles" { box 2.4 0.2 0.6 { at 0 0.1 -0.9 } }
object "right" material="glowing" { rect 4 4 { normal -1 0 0; at 1.2 1 0 } }
object "block" material="yellow" { box 0.3 0.3 0.3 { at -0.1 0.35 0.4 } }
"#;
    parse(&format!("{room}{more}"))
}

fn cornell_box() -> Scene {
    Scene::load(scenes().iter().find(|path| path.ends_with("cornell-box.kdl")).expect("there")).expect("a valid scene")
}

fn settings(scene: &Scene, samples: u32, seed: u32, path_reuse: bool) -> Settings {
    Settings {
        // Not a multiple of the tiles' size.
        size: [61, 37],
        samples,
        seed,
        splitting: Some(1),
        // Path reuse alone is compared.
        light_samples: Some(1),
        path_reuse: Some(path_reuse),
        ..Settings::of(scene)
    }
}

fn pictures_are_the_same() {
    let scene = room();
    let picture = |seed, path_reuse| render(&cpu(), &scene, &settings(&scene, 4096, seed, path_reuse)).mean();
    let reference = picture(1, false);
    let error = |picture: &Picture| relmse(picture, &reference).expect("equal sizes");
    let (noise, with) = (error(&picture(2, false)), picture(3, true));
    assert!(error(&with) < 1.3 * noise, "{:.2e}, without {noise:.2e}", error(&with));
    for (mean, expected) in mean_colour(&with).iter().zip(&mean_colour(&reference)) {
        assert!((mean / expected - 1.0).abs() < 2e-3, "{mean} is not {expected}");
    }
}

fn closed_rooms_have_less_noise() {
    let scene = cornell_box();
    let picture = |samples, seed, path_reuse| {
        let settings = Settings { size: [192, 108], ..settings(&scene, samples, seed, path_reuse) };
        render(&cpu(), &scene, &settings).mean()
    };
    let reference = picture(256, 1, true);
    let error = |picture: &Picture| relmse(picture, &reference).expect("equal sizes");
    let (without, with) = (error(&picture(8, 2, false)), error(&picture(8, 3, true)));
    assert!(with < 0.2 * without, "{with:.2e}, without {without:.2e}");
}

fn splitting_and_ranges_of_samples_go_together() {
    let scene = room();
    let whole = Settings { splitting: Some(3), ..settings(&scene, 26, 0, true) };
    let film = render(&cpu(), &scene, &whole);
    let mut parts = render(&cpu(), &scene, &Settings { samples: 19, ..whole.clone() });
    parts
        .add(&render(&cpu(), &scene, &Settings { first_sample: 19, samples: 7, ..whole.clone() }))
        .expect("equal sizes");
    assert_eq!(film.samples, parts.samples);
    for (a, b) in film.sums.iter().flatten().zip(parts.sums.iter().flatten()) {
        assert!((a - b).abs() <= 1e-5 * a.abs().max(1.0), "{a} {b}");
    }
    let picture = |settings: &Settings| render(&cpu(), &scene, settings).mean();
    let reference = picture(&settings(&scene, 4096, 1, false));
    let error = |settings: &Settings| relmse(&picture(settings), &reference).expect("equal sizes");
    let split = error(&Settings { samples: 1024, ..whole.clone() });
    let plain = error(&settings(&scene, 1024, 2, false));
    assert!(split < 1.3 * plain, "{split:.2e}, without {plain:.2e}");
}

fn both_backends_share_the_same_light(renderers: &mut [Renderer; 2]) {
    // Software adapters limit the loops of a torus; then pixels share nothing there.
    let scene = room_with(&ROOM.replace("torus 0.3 0.08", "sphere 0.2"));
    for splitting in [1, 3] {
        // The last samples share camera rays.
        let settings = Settings { splitting: Some(splitting), ..settings(&scene, 24, 0, true) };
        let [cpu, gpu] = renderers.each_ref().map(|renderer| {
            let mut job = renderer.start(&scene, &settings).expect("starts");
            assert!(job.reuses_paths() && job.splitting() == splitting);
            job.run(|_| false, |_| {}).expect("renders");
            job.film().expect("is read").mean()
        });
        let error = relmse(&gpu, &cpu).expect("equal sizes");
        // Rounding turns single paths; other groups than those of the CPU would make a hundred times this error.
        assert!(error < 2e-4, "{error:.2e}");
    }
    // The memory of a workgroup does not hold more second surfaces.
    let split = Settings { splitting: Some(8), ..settings(&scene, 24, 0, true) };
    assert!(!renderers[1].start(&scene, &split).expect("starts").reuses_paths());
}

fn pictures_decide_for_themselves() {
    let scene = cornell_box();
    let starts = |settings: Settings| cpu().start(&scene, &settings).expect("starts").reuses_paths();
    let large = Settings { size: [640, 360], samples: 256, ..Settings::of(&scene) };
    assert!(starts(large.clone()));
    assert!(!starts(Settings { path_reuse: Some(false), ..large.clone() }));
    // Too small for the probe to pay; a clamp and a crop exclude it.
    assert!(!starts(Settings { size: [32, 18], ..large.clone() }));
    assert!(!starts(Settings { clamp: Some(4.0), path_reuse: Some(true), ..large.clone() }));
    let open = parse(
        "pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\nmaterial \"a\" { diffuse 0.5 }\nobject \"ball\" material=\"a\" { sphere 1 }\n",
    );
    let alone = Settings { size: [640, 360], samples: 256, ..Settings::of(&open) };
    assert!(!cpu().start(&open, &alone).expect("starts").reuses_paths(), "a ball alone sees no other surface");
}

tests! {
    on_both_backends: [both_backends_share_the_same_light],
    plain: [splitting_and_ranges_of_samples_go_together, pictures_decide_for_themselves],
    plain slow: [closed_rooms_have_less_noise],
    plain long: [pictures_are_the_same],
}
