//! Adaptive sampling: the error that was asked for, more samples where there is more noise, and no bias.

use crate::common::{cpu, data, on_each_backend, parse};
use pathmarch_render::denoise::{Denoiser, Features};
use pathmarch_render::image::{self, Picture};
use pathmarch_render::metrics::relmse;
use pathmarch_render::parts::{FilmPart, Rect};
use pathmarch_render::pathmarch_scene::{Animation, Caustics, Moment, Scene};
use pathmarch_render::{AdaptiveTile, Mode, RenderError, Renderer, Settings, Shutter};
use pathmarch_testing::{plain, tests};
use std::sync::{Arc, Mutex};

fn render(renderer: &Renderer, scene: &Scene, settings: &Settings, noise: f32) -> (Picture, Vec<AdaptiveTile>) {
    let mut job = renderer.start_adaptive(scene, settings, noise).expect("starts");
    let mut share = 0.0;
    job.run(|| false, |job| share = job.share_done()).expect("renders");
    assert!((share - 1.0).abs() < 1e-9, "{share} of the work is done");
    let (film, tiles) = job.film().expect("a film");
    (film.mean(), tiles)
}

fn every_tile_has_the_error_that_was_asked_for(renderer: &Renderer) {
    for name in ["cornell", "rough_metal"] {
        let scene = Scene::load(data(&format!("{name}.kdl"))).expect("a valid scene");
        let reference = image::load(&data(&format!("{name}.exr"))).expect("a picture").picture;
        let size = [reference.width, reference.height];
        let settings = Settings { size, samples: 4096, ..Settings::of(&scene) };
        let noise = 0.04;
        let (picture, tiles) = render(renderer, &scene, &settings, noise);
        let error = relmse(&picture, &reference).expect("one size").sqrt();
        let worst = tiles.iter().map(|tile| tile.error).fold(0.0, f32::max);
        let estimated = tiles.iter().map(|tile| f64::from(tile.error).powi(2) * tile.rect.pixels() as f64).sum::<f64>();
        let estimated = (estimated / f64::from(size[0] * size[1])).sqrt();
        let samples = || tiles.iter().map(|tile| tile.samples);
        let (least, most) = (samples().min().unwrap_or(0), samples().max().unwrap_or(0));
        println!(
            "{name}: {least} to {most} samples, error {error:.4}, estimated {estimated:.4}, worst tile {worst:.4}"
        );
        // The reference has noise of its own, and its colours count one by one.
        assert!(error < 1.2 * f64::from(noise), "{name}: error {error}");
        assert!(worst < noise, "{name}: a tile has {worst}");
        assert!(most >= 2 * least, "{name}: {least} to {most} samples");
    }
}

/// A lit wall on the left, and noise from a small lamp on the right.
const UNEVEN: &str = "pathmarch 1\ncamera { position 0 0 4; target 0 0 0; fov 50 }\nrender { bounces 3 }\nsky 0.5\n\
    material \"mirror\" { metal 0.9; roughness 0.5 }\nmaterial \"lamp\" { emit 400 }\n\
    object \"ball\" material=\"mirror\" { sphere 0.9 { at 1.6 0 0 } }\n\
    object \"lamp\" material=\"lamp\" { sphere 0.02 { at 1.6 2.5 0.5 } }";

/// Means over pixels of pictures of many seeds agree with that of many samples.
fn samples_that_are_chosen_do_not_bias_the_picture() {
    let scene = parse(UNEVEN);
    let renderer = cpu();
    let settings = Settings { size: [40, 24], samples: 512, ..Settings::of(&scene) };
    let mean = |picture: &Picture| picture.mean_colour()[0];
    let whole = Settings { samples: 16_384, seed: 9, ..settings.clone() };
    let truth = mean(&renderer.render(&scene, &whole).expect("renders").mean());
    let means: Vec<f64> = (0..48)
        .map(|seed| mean(&render(&renderer, &scene, &Settings { seed: 100 + seed, ..settings.clone() }, 0.3).0))
        .collect();
    let n = means.len() as f64;
    let average = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|mean| (mean - average).powi(2)).sum::<f64>() / (n - 1.0);
    let z = (average - truth) / (variance / n).sqrt();
    println!("mean {average:.5} instead of {truth:.5}, Z {z:.2}");
    assert!(z.abs() < 3.0, "mean {average} instead of {truth}, Z {z}");
}

fn pixels_get_samples_where_noise_is(renderer: &Renderer) {
    let scene = parse(UNEVEN);
    let crop = Rect { x: 7, y: 3, width: 150, height: 70 };
    for crop in [None, Some(crop)] {
        let settings = Settings { size: [160, 96], samples: 100, crop, ..Settings::of(&scene) };
        let mut job = renderer.start_adaptive(&scene, &settings, 0.02).expect("starts");
        assert!(!job.is_planned());
        job.run(|| false, |_| {}).expect("renders");
        let (film, tiles) = job.film().expect("a film");
        assert!(job.is_planned() && job.is_done());
        let rect = settings.rect();
        assert_eq!(tiles.iter().map(|tile| tile.rect.pixels()).sum::<usize>(), rect.pixels());
        let counts = film.sample_counts();
        for tile in &tiles {
            for y in tile.rect.y..tile.rect.bottom() {
                for x in tile.rect.x..tile.rect.right() {
                    let pixel = (y - rect.y) * rect.width + x - rect.x;
                    assert_eq!(counts[pixel as usize], tile.samples, "pixel {x} {y}");
                }
            }
        }
        let of = |x: u32, y: u32| {
            let holds = |tile: &&AdaptiveTile| tile.rect.intersection(&Rect { x, y, width: 1, height: 1 }).is_some();
            tiles.iter().find(holds).map_or(0, |tile| tile.samples)
        };
        assert_eq!(of(10, 80 - 10), 16, "nothing but sky");
        assert_eq!(of(125, 40), 100, "the ball in the light of a small lamp");
    }
}

fn the_picture_so_far_has_the_samples_that_are_done() {
    let scene = parse(UNEVEN);
    let settings = Settings { size: [96, 64], samples: 4096, ..Settings::of(&scene) };
    let mut job = cpu().start_adaptive(&scene, &settings, 0.005).expect("starts");
    job.run(|| true, |_| {}).expect("renders");
    let (film, tiles) = job.film().expect("a film");
    let first = film.sample_counts();
    assert!(first.iter().all(|count| (1..=16).contains(count)) && tiles[0].error.is_infinite());
    while job.share_done() < 0.5 || !job.is_planned() {
        job.advance().expect("renders");
    }
    let (film, _) = job.film().expect("a film");
    let counts = film.sample_counts();
    assert!(counts.iter().all(|count| *count >= 16) && counts.iter().any(|count| *count > 64));
    assert!(film.mean().pixels.iter().flatten().all(|value| value.is_finite()));
}

fn a_seed_gives_one_picture() {
    let scene = parse(UNEVEN);
    let settings = Settings { size: [64, 40], samples: 128, ..Settings::of(&scene) };
    let [first, second] = [0.03, 0.03].map(|noise| render(&cpu(), &scene, &settings, noise).0);
    assert_eq!(first, second);
    let one = Settings { samples: 1, ..settings };
    let (picture, tiles) = render(&cpu(), &scene, &one, 0.5);
    assert_eq!((picture.width, tiles[0].samples), (64, 2), "each half has a sample");
}

/// The uneven scene with a ball that moves while the shutter is open.
fn moving() -> Animation {
    let text = UNEVEN.replace("at 1.6 0 0", "at \"1.6 - t\" 0 0").replace("bounces 3", "bounces 3; shutter 0.5; fps 2");
    Animation::new("moving.kdl", text)
}

/// Interrupted after every slice, or after some, a picture goes on to the samples and the plan of the uninterrupted one.
fn an_interrupted_picture_goes_on_to_the_same(renderer: &Renderer) {
    let animation = Arc::new(Mutex::new(moving()));
    for shutter_part in [0.0, 0.5] {
        let scene = animation.lock().expect("no panic").at(Moment::default()).expect("a scene");
        let shutter = Shutter::open_for(&scene, shutter_part, 2.0);
        let settings = Settings { size: [64, 40], samples: 96, ..Settings::of(&scene) };
        let start = |parts: Option<[FilmPart; 3]>| {
            let job = renderer.start_adaptive_motion_blur(&animation, &scene, &settings, shutter, 0.008, parts);
            job.expect("starts")
        };
        let mut whole = start(None);
        whole.run(|| false, |_| {}).expect("renders");
        let (film, tiles) = whole.film().expect("a film");
        let least = tiles.iter().map(|tile| tile.samples).min();
        assert!(tiles.iter().any(|tile| Some(tile.samples) > least), "{tiles:?}");
        let (mut job, mut runs) = (start(None), 1);
        while !job.is_done() {
            for _ in 0..1 + runs % 7 {
                job.advance().expect("renders");
            }
            let parts = job.parts().expect("films");
            job = start(Some(parts));
            runs += 1;
        }
        assert!(runs > 8, "{runs}");
        assert_eq!(job.film().expect("a film"), (film, tiles), "{runs} runs, shutter {shutter_part}");
    }
}

/// Motion blur: the adaptive picture is that of many samples, and blurred.
fn moving_scenes_are_blurred() {
    let animation = Arc::new(Mutex::new(moving()));
    let scene = animation.lock().expect("no panic").at(Moment::default()).expect("a scene");
    let (renderer, settings) = (cpu(), Settings { size: [64, 40], samples: 2048, ..Settings::of(&scene) });
    let picture = |shutter: Shutter| {
        let job = renderer.start_adaptive_motion_blur(&animation, &scene, &settings, shutter, 0.02, None);
        let mut job = job.expect("starts");
        job.run(|| false, |_| {}).expect("renders");
        job.film().expect("a film").0.mean()
    };
    let (blurred, still) = (picture(Shutter::of(&scene)), picture(Shutter::open_for(&scene, 0.0, 2.0)));
    let mut whole = renderer.start_motion_blur(&animation, &scene, &settings, Shutter::of(&scene)).expect("starts");
    whole.run(|_| false, |_| {}).expect("renders");
    let reference = whole.film().expect("a film").mean();
    let [error, apart] = [&blurred, &still].map(|picture| relmse(picture, &reference).expect("one size").sqrt());
    println!("error {error:.4}, without blur {apart:.4}");
    assert!(error < 0.05 && apart > 2.0 * error, "{error} {apart}");
}

/// Halves of a picture with adaptive sampling are denoised, and better than before.
fn halves_are_denoised() {
    let name = data("cornell.kdl");
    let scene = Scene::load(&name).expect("a valid scene");
    let reference = image::load(&name.with_extension("exr")).expect("a picture").picture;
    let settings = Settings { size: [reference.width, reference.height], samples: 512, ..Settings::of(&scene) };
    let mut job = cpu().start_adaptive(&scene, &settings, 0.08).expect("starts");
    job.run(|| false, |_| {}).expect("renders");
    let (halves, tiles) = job.halves().expect("films");
    let counts = halves.film().sample_counts();
    assert!(counts.iter().min() < counts.iter().max() && tiles.iter().all(|tile| tile.error.is_finite()));
    let features = Features::trace(&scene, &settings, 32).expect("features");
    let before = relmse(&halves.film().mean(), &reference).expect("one size");
    let after = relmse(&Denoiser::Regression.denoise(halves, &features).expect("a picture"), &reference);
    let after = after.expect("one size");
    println!("relMSE {before:.2e} -> {after:.2e}");
    assert!(after < 0.3 * before, "{before} {after}");
}

fn what_cannot_be_done_is_refused() {
    let scene = parse(UNEVEN);
    let settings = Settings { size: [32, 20], samples: 64, ..Settings::of(&scene) };
    for noise in [0.0, -1.0, f32::NAN, 2.0] {
        let error = cpu().start_adaptive(&scene, &settings, noise).err();
        assert!(matches!(error, Some(RenderError::Settings(_))), "{noise}");
    }
    let preview = Settings { mode: Mode::Preview, ..settings };
    let error = cpu().start_adaptive(&scene, &preview, 0.1).err().map(|error| error.to_string());
    assert!(error.is_some_and(|error| error.contains("path-traced")));
}

fn pictures_have_the_light_paths_that_are_asked_for() {
    let scene = parse(include_str!("data/caustic_point.kdl"));
    let picture = |light_paths| {
        let settings =
            Settings { size: [48, 32], samples: 8, caustics: Caustics::Traced, light_paths, ..Settings::of(&scene) };
        render(&cpu(), &scene, &settings, 0.05).0
    };
    let default = picture(None);
    // The least number that is chosen, more than half the number of pixels.
    assert_eq!(default, picture(Some(4096)));
    assert_ne!(default, picture(Some(64)));
}

tests! {
    plain: [
        pictures_have_the_light_paths_that_are_asked_for,
        samples_that_are_chosen_do_not_bias_the_picture,
        the_picture_so_far_has_the_samples_that_are_done,
        a_seed_gives_one_picture,
        what_cannot_be_done_is_refused,
        moving_scenes_are_blurred,
        halves_are_denoised,
    ],
    on_each_backend: [
        an_interrupted_picture_goes_on_to_the_same,
        every_tile_has_the_error_that_was_asked_for,
        pixels_get_samples_where_noise_is,
    ],
}
