//! Motion blur: the picture is the mean over the time that the shutter is open, on both backends.

use crate::common::{cpu, on_each_backend, worst_block};
use pathmarch_render::film::Film;
use pathmarch_render::pathmarch_scene::{Animation, Moment};
use pathmarch_render::{Renderer, Settings, Shutter};
use pathmarch_testing::{plain, tests};
use std::sync::{Arc, Mutex};

/// Lit ball that crosses half of the picture in a second, over a static ground.
const SCENE: &str = "pathmarch 1
camera { position 0 0.5 5; target 0 0.5 0; fov 40 }
render { size 64 36; samples 256; bounces 1 }
sky 0.4 0.5 0.6
sun { direction 1 2 1.5; irradiance 2; angle 10 }
material \"red\" { diffuse 0.8 0.2 0.1 }
object \"ball\" material=\"red\" { sphere 0.5 { at \"2*t - 1\" 0.5 0 } }
object \"ground\" { plane }";
const OPEN: Shutter = Shutter { opens: Moment { seconds: 0.0, frame: 0 }, seconds: 1.0 };

fn animation() -> Animation {
    Animation::new("motion.kdl", SCENE)
}

fn settings(samples: u32, first_sample: u32, seed: u32) -> Settings {
    let scene = animation().at(Moment::default()).expect("a scene");
    Settings { samples, first_sample, seed, ..Settings::of(&scene) }
}

fn blurred(renderer: &Renderer, settings: &Settings, shutter: Shutter) -> Film {
    let mut animation = animation();
    let scene = animation.at(shutter.opens).expect("a scene");
    let animation = Arc::new(Mutex::new(animation));
    let mut job = renderer.start_motion_blur(&animation, &scene, settings, shutter).expect("starts");
    job.run(|_| false, |_| {}).expect("renders");
    let film = job.film().expect("a film");
    assert_eq!((film.samples, film.non_finite()), (settings.samples, 0));
    film
}

fn still(renderer: &Renderer, seconds: f64, settings: &Settings) -> Film {
    let scene = animation().at(Moment { seconds, frame: 0 }).expect("a scene");
    renderer.render(&scene, settings).expect("renders")
}

fn blur_is_the_mean_over_the_time(renderer: &Renderer) {
    let name = renderer.backend().name;
    // Sixty-four still pictures with few samples each.
    let mut mean = Film::new(64, 36);
    for k in 0..64 {
        let at = (f64::from(k) + 0.5) / 64.0;
        mean.add(&still(renderer, at, &settings(8, 0, 100 + k))).expect("equal sizes");
    }
    let film = blurred(renderer, &settings(256, 0, 1), OPEN);
    let (blur, mean) = (film.mean(), mean.mean());
    let error = worst_block(&blur, &mean, 4);
    let still_error = worst_block(&still(renderer, 0.5, &settings(256, 0, 1)).mean(), &mean, 4);
    println!("{name}: worst block {error:.4}, of the ball at rest {still_error:.4}");
    assert!(error < 0.05 && still_error > 0.5, "{name}: {error} {still_error}");
    // An exposure time of zero shows the moment at which the shutter opens.
    let shut = Shutter { opens: Moment { seconds: 0.5, frame: 0 }, seconds: 0.0 };
    let frozen = worst_block(
        &blurred(renderer, &settings(16, 0, 1), shut).mean(),
        &still(renderer, 0.5, &settings(16, 0, 1)).mean(),
        1,
    );
    assert!(frozen < 1e-3, "{name}: {frozen}");
}

fn ranges_of_samples_add_up(renderer: &Renderer) {
    let whole = blurred(renderer, &settings(24, 0, 5), OPEN);
    let mut parts = blurred(renderer, &settings(10, 0, 5), OPEN);
    parts.add(&blurred(renderer, &settings(14, 10, 5), OPEN)).expect("equal sizes");
    let error = worst_block(&parts.mean(), &whole.mean(), 1);
    assert!(error < 1e-4, "{}: {error}", renderer.backend().name);
}

fn mistakes_of_a_moment_are_reported() {
    let mut animation = Animation::new("motion.kdl", SCENE.replace("sphere 0.5", "sphere \"0.9 - t\""));
    let scene = animation.at(OPEN.opens).expect("a scene");
    let animation = Arc::new(Mutex::new(animation));
    let mut job = cpu().start_motion_blur(&animation, &scene, &settings(64, 0, 0), OPEN).expect("starts");
    let error = job.run(|_| false, |_| {}).expect_err("the radius becomes negative");
    assert!(job.samples_done() < 64.0);
    assert!(error.to_string().contains("motion.kdl has 1 mistake"), "{error}");
}

tests! {
    plain: [mistakes_of_a_moment_are_reported],
    on_each_backend: [blur_is_the_mean_over_the_time, ranges_of_samples_add_up],
}
