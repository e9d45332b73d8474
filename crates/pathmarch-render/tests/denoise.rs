//! Denoised pictures: nearer to the references than their samples, with the same energy; edges, textures and pictures
//! without noise stay as they are.

use crate::common::{cpu, data, on_each_backend, parse};
use pathmarch_render::denoise::{DenoiseError, Denoiser, Features, HalfBuffers, HalfFilms, SequenceDenoiser};
use pathmarch_render::film::Film;
use pathmarch_render::image::{self, Picture};
use pathmarch_render::metrics::relmse;
use pathmarch_render::parts::SampleRecorder;
use pathmarch_render::pathmarch_scene::{Animation, Moment, Scene};
use pathmarch_render::{Renderer, Settings, Shutter};
use pathmarch_testing::{plain, tests};
use std::sync::{Arc, Mutex};

fn halves(renderer: &Renderer, scene: &Scene, settings: &Settings) -> HalfBuffers {
    let mut halves = HalfBuffers::new(settings);
    let mut job = renderer.start(scene, settings).expect("starts");
    job.record(&mut halves, |_| false, |_| {}).expect("renders");
    halves
}

fn denoised(halves: &HalfBuffers, scene: &Scene, settings: &Settings) -> Picture {
    let features = Features::trace(scene, settings, halves.samples()).expect("features");
    Denoiser::Regression.denoise(halves, &features).expect("a picture")
}

/// Picture of a scene before and after denoising.
fn both(renderer: &Renderer, scene: &Scene, settings: &Settings) -> [Picture; 2] {
    let halves = halves(renderer, scene, settings);
    [halves.film().mean(), denoised(&halves, scene, settings)]
}

fn assert_same_mean(before: &Picture, after: &Picture, name: &str) {
    let pairs = before.mean_colour().into_iter().zip(after.mean_colour());
    for (before, after) in pairs {
        assert!((after - before).abs() <= 1e-5 * before, "{name}: mean {after} instead of {before}");
    }
}

/// Scenes with committed references, samples, the least factor by which relMSE falls, and the largest relMSE that is left.
const GAINS: [(&str, u32, f64, f64); 4] = [
    ("cornell", 16, 15.0, 3.5e-4),
    ("mirror", 16, 5.0, 4e-3),
    ("rough_metal", 16, 4.0, 2.5e-3),
    ("many_lights", 16, 1.3, 6.5e-3),
];

fn errors_fall_and_energy_is_kept(renderer: &Renderer) {
    for (name, samples, least_gain, largest) in GAINS {
        let scene = Scene::load(data(&format!("{name}.kdl"))).expect("a valid scene");
        let reference = image::load(&data(&format!("{name}.exr"))).expect("a picture").picture;
        let size = [reference.width, reference.height];
        let [before, after] = both(renderer, &scene, &Settings { size, samples, ..Settings::of(&scene) });
        let [error_before, error_after] =
            [&before, &after].map(|picture| relmse(picture, &reference).expect("one size"));
        println!("{name}: relMSE {error_before:.2e} -> {error_after:.2e}");
        let falls = error_after * least_gain < error_before && error_after < largest;
        assert!(falls, "{name}: relMSE {error_before:.2e} -> {error_after:.2e}");
        assert_same_mean(&before, &after, name);
    }
}

/// Checker in front of the sky, with a bump map and an edge.
const CHECKER: &str = "pathmarch 1\ncamera { position 0 0 3; target 0 0 0; fov 50 }\nrender { bounces 2 }\n\
    sky 0.6\nsun { direction 1 1 2; irradiance 2; angle 1 }\n\
    material \"checker\" { diffuse { checker size=0.1 { colour 0.05; colour 0.8 } } }\n\
    object \"wall\" material=\"checker\" { box 2 1 0.2 }\nobject \"ball\" { sphere 0.3 { at 0.2 0 0.4 } }";

fn a_picture_with_little_noise_gets_no_worse() {
    let scene = parse(CHECKER);
    let settings = |samples, seed| Settings { size: [96, 54], samples, seed, ..Settings::of(&scene) };
    let reference = cpu().render(&scene, &settings(2048, 1)).expect("a film").mean();
    for (samples, limit) in [(8, 1.1), (512, 1.02)] {
        let [before, after] = both(&cpu(), &scene, &settings(samples, 2));
        let errors = [before, after].map(|picture| relmse(&picture, &reference).expect("one size"));
        assert!(errors[1] < limit * errors[0], "{samples} samples: relMSE {errors:?}");
    }
}

/// Wall that fills the picture.
const WALL: &str =
    "pathmarch 1\ncamera { position 0 0 1; target 0 0 0; fov 50 }\nobject \"wall\" { rect 99 { normal 0 0 1 } }";

/// Half buffers of films made up of a function of sample and pixel.
fn made_up(size: [u32; 2], samples: u32, value: impl Fn(u32, usize) -> [f32; 3]) -> HalfBuffers {
    let mut halves = HalfBuffers::new(&Settings { size, samples, ..Settings::of(&parse(WALL)) });
    for sample in 0..samples {
        let mut film = Film::new(size[0], size[1]);
        film.samples = 1;
        film.sums.iter_mut().enumerate().for_each(|(pixel, sum)| *sum = value(sample, pixel));
        halves.record(sample, film);
    }
    halves
}

/// Pseudo-random number, 0 to 1.
fn noise(sample: u32, pixel: usize) -> f32 {
    let mut state = (pixel as u32).wrapping_mul(747_796_405) ^ sample.wrapping_mul(2_891_336_453);
    for _ in 0..3 {
        state = (state ^ (state >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    (state >> 8) as f32 / 16_777_216.0
}

fn constants_stay_and_noise_goes() {
    let (scene, size) = (parse(WALL), [64, 48]);
    let settings = Settings { size, ..Settings::of(&scene) };
    let constant = made_up(size, 8, |_, _| [0.25, 0.5, 1.0]);
    for pixel in denoised(&constant, &scene, &settings).pixels {
        assert!(pixel.iter().zip([0.25, 0.5, 1.0]).all(|(a, b)| (a - b).abs() < 1e-4 * b), "{pixel:?}");
    }
    let noisy = made_up(size, 8, |sample, pixel| [0.5 + noise(sample, pixel); 3]);
    let truth = Picture::from_fn(size[0], size[1], |_, _| [1.0; 3]);
    let errors = [noisy.film().mean(), denoised(&noisy, &scene, &settings)]
        .map(|picture| relmse(&picture, &truth).expect("one size"));
    assert!(errors[1] * 20.0 < errors[0], "relMSE {errors:?}");
}

/// A shadow, which no feature shows, is kept when its contrast is well above the noise.
fn edges_of_shadows_are_kept() {
    let (scene, size) = (parse(WALL), [64, 48]);
    let settings = Settings { size, ..Settings::of(&scene) };
    let light = |pixel: usize| if pixel % 64 < 29 { 0.2 } else { 1.0 };
    let halves = made_up(size, 8, |sample, pixel| [light(pixel) * (0.9 + 0.2 * noise(sample, pixel)); 3]);
    let after = denoised(&halves, &scene, &settings);
    for y in 4..44 {
        let [dark, bright] = [28, 29].map(|x| after.get(x, y).expect("inside")[0]);
        assert!(dark < 0.3 && bright > 0.9, "row {y}: {dark}, {bright}");
    }
}

fn fireflies_spread_no_blotches_and_extremes_stay_finite() {
    let (scene, size) = (parse(WALL), [64, 48]);
    let settings = Settings { size, ..Settings::of(&scene) };
    let firefly = 64 * 24 + 32;
    for brightness in [1e3, 1e29] {
        let halves = made_up(size, 8, |sample, pixel| {
            let is_firefly = pixel == firefly && sample == 3;
            [if is_firefly { brightness } else { 0.5 + noise(sample, pixel) }; 3]
        });
        let after = denoised(&halves, &scene, &settings);
        assert_eq!(after.non_finite(), 0, "{brightness:e}");
        assert_same_mean(&halves.film().mean(), &after, "firefly");
        // The energy is spread over all pixels.
        let (mean, largest) = (after.mean_colour()[0], after.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max));
        assert!(f64::from(largest) < 2.0 * mean, "{brightness:e}: {largest}, mean {mean}");
    }
}

fn tiny_pictures_and_single_samples_are_denoised() {
    let scene = parse(CHECKER);
    for (size, samples) in [([1, 1], 1), ([1, 1], 16), ([1, 9], 4), ([13, 2], 3), ([40, 30], 1), ([40, 30], 2)] {
        let [before, after] = both(&cpu(), &scene, &Settings { size, samples, ..Settings::of(&scene) });
        assert_eq!((after.width, after.height, after.non_finite()), (size[0], size[1], 0));
        assert_same_mean(&before, &after, &format!("{size:?}, {samples} samples"));
    }
}

/// The samples are those of a picture that is not denoised, whatever their number; sums differ in the order of additions.
fn halves_add_up_to_the_film(renderer: &Renderer) {
    let scene = parse(CHECKER);
    for (samples, splitting) in [(1, 1), (7, 1), (40, 1), (61, 4)] {
        let settings = Settings { size: [24, 16], samples, splitting: Some(splitting), ..Settings::of(&scene) };
        let halves = halves(renderer, &scene, &settings);
        let (sums, film) = (halves.film(), renderer.render(&scene, &settings).expect("a film"));
        assert_eq!((sums.samples, sums.non_finite()), (film.samples, film.non_finite()));
        for (found, expected) in sums.sums.iter().flatten().zip(film.sums.iter().flatten()) {
            assert!((found - expected).abs() <= 4e-6 * expected, "{samples} samples: {found}, {expected}");
        }
        let means = HalfFilms::from(&halves).means();
        assert!(samples == 1 || (0.3..0.7).contains(&means.first_share), "{samples}: {}", means.first_share);
        for (pixel, whole) in means.whole.iter().enumerate() {
            let sum = means.halves[1][pixel].lerp(means.halves[0][pixel], means.first_share);
            assert!(
                (sum - whole).abs().max_element() <= 1e-5 * whole.max_element(),
                "{samples} samples, pixel {pixel}"
            );
        }
    }
}

fn motion_blur_is_denoised() {
    let text = "pathmarch 1\ncamera { position 0 0.5 5; target 0 0.5 0; fov 40 }\nrender { size 64 36; samples 16; bounces 1 }\n\
        sky 0.4 0.5 0.6\nsun { direction 1 2 1.5; irradiance 2; angle 40 }\n\
        object \"ball\" { sphere 0.5 { at \"2*t - 1\" 0.5 0 } }\nobject \"ground\" { plane }";
    let shutter = Shutter { opens: Moment { seconds: 0.0, frame: 0 }, seconds: 1.0 };
    let mut animation = Animation::new("motion.kdl", text);
    let scene = animation.at(shutter.opens).expect("a scene");
    let animation = Arc::new(Mutex::new(animation));
    let render = |samples| {
        let settings = Settings { samples, ..Settings::of(&scene) };
        let mut job = cpu().start_motion_blur(&animation, &scene, &settings, shutter).expect("starts");
        let mut halves = HalfBuffers::new(&settings);
        job.record(&mut halves, |_| false, |_| {}).expect("renders");
        (halves, settings)
    };
    let reference = render(1024).0.film().mean();
    let (halves, settings) = render(16);
    let features = Features::trace_motion_blur(&animation, &scene, &settings, shutter, 16).expect("features");
    let after = Denoiser::Regression.denoise(&halves, &features).expect("a picture");
    let errors = [&halves.film().mean(), &after].map(|picture| relmse(picture, &reference).expect("one size"));
    assert!(errors[1] < errors[0], "relMSE {errors:?}");
}

fn features_of_another_size_are_refused() {
    let scene = parse(WALL);
    let features = Features::trace(&scene, &Settings { size: [4, 4], ..Settings::of(&scene) }, 4).expect("features");
    let halves = made_up([5, 4], 4, |_, _| [1.0; 3]);
    let result = Denoiser::Regression.denoise(&halves, &features);
    assert!(matches!(result, Err(DenoiseError::SizeMismatch)));
}

/// Frames of a sequence on the CPU: denoised one by one, and joined.
fn sequence(frames: u32, scene: impl Fn(u32) -> Scene, samples: u32) -> Vec<[Picture; 2]> {
    let mut denoiser = SequenceDenoiser::new();
    let frame = |frame| {
        let scene = scene(frame);
        let settings = Settings { samples, ..Settings::of(&scene) };
        let halves = halves(&cpu(), &scene, &settings);
        let features = Features::trace(&scene, &settings, samples).expect("features");
        let apart = Denoiser::Regression.denoise(&halves, &features).expect("a picture");
        [apart, denoiser.denoise(&halves, &features).expect("a picture")]
    };
    (0..frames).map(frame).collect()
}

/// Wall with a board in front of it, below a small lamp. The camera is `x` metres to the right.
fn board(x: f32, power: f32) -> Scene {
    parse(&format!(
        "pathmarch 1\ncamera {{ position {x} 0 2; target {x} 0 0; fov 53.130102 }}\n\
         render {{ size 96 64; bounces 2 }}\nmaterial \"lamp\" {{ emit {power} }}\n\
         material \"checker\" {{ diffuse {{ checker size=0.25 {{ colour 0.2; colour 0.8 }} }} }}\n\
         object \"wall\" material=\"checker\" {{ rect 9 9 {{ normal 0 0 1 }} }}\n\
         object \"lamp\" material=\"lamp\" {{ rect 1 1 {{ normal 0 -1 0; at 0 2 1 }} }}\n\
         object \"board\" {{ box 1 0.05 0.5 {{ at 0 0.3 0.3 }} }}"
    ))
}

/// Width of a pixel of these pictures on the wall, metres: 2 m / 64.
const WALL_PIXEL: f32 = 0.03125;

/// Mean absolute difference of pixels at `chosen` in a picture and of those `shift` pixels to the right in another.
fn change(now: &Picture, before: &Picture, shift: i64, chosen: impl Fn(u32, u32) -> bool) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for y in 0..now.height {
        for x in (0..now.width).filter(|x| chosen(*x, y)) {
            let there = u32::try_from(i64::from(x) + shift).ok().and_then(|x| before.get(x, y));
            let (Some(a), Some(b)) = (now.get(x, y), there) else { continue };
            sum += (0..3).map(|k| f64::from((a[k] - b[k]).abs())).sum::<f64>();
            count += 3;
        }
    }
    assert!(count > 300, "{count} values");
    sum / f64::from(count)
}

fn pictures_at_rest_are_those_of_stills() {
    for (index, [apart, joined]) in sequence(3, |_| board(0.0, 20.0), 8).iter().enumerate() {
        assert!(apart == joined, "frame {index}");
    }
}

/// Each frame is shifted by two pixels, so that the frame before is known without interpolation.
fn noise_does_not_flicker_when_the_camera_moves() {
    let frames = sequence(6, |frame| board(2.0 * WALL_PIXEL * frame as f32, 20.0), 8);
    assert!(frames[0][0] == frames[0][1], "the first frame is a still");
    let is_wall = |_: u32, y: u32| y > 36;
    let flicker = |k: usize| -> f64 {
        (3..6).map(|frame: usize| change(&frames[frame][k], &frames[frame - 1][k], 2, is_wall)).sum()
    };
    let (apart, joined) = (flicker(0), flicker(1));
    println!("change on the wall: apart {apart:.2e}, joined {joined:.2e}");
    assert!(joined < 0.6 * apart, "{joined} of {apart}");
    let scene = board(10.0 * WALL_PIXEL, 20.0);
    let reference = cpu().render(&scene, &Settings { samples: 1024, seed: 1, ..Settings::of(&scene) });
    let reference = reference.expect("a film").mean();
    let errors = frames[5].each_ref().map(|picture| relmse(picture, &reference).expect("one size"));
    println!("relMSE: {errors:?}");
    assert!(errors[1] < errors[0], "relMSE {errors:?}");
}

fn a_light_that_switches_leaves_no_trail() {
    let power = |frame: u32| if frame < 4 { 20.0 } else { 1.0 };
    let frames = sequence(6, |frame| board(2.0 * WALL_PIXEL * frame as f32, power(frame)), 8);
    for frame in [4, 5] {
        let scene = board(2.0 * WALL_PIXEL * frame as f32, power(frame));
        let reference = cpu().render(&scene, &Settings { samples: 1024, seed: 1, ..Settings::of(&scene) });
        let reference = reference.expect("a film").mean();
        let errors = frames[frame as usize].each_ref().map(|picture| relmse(picture, &reference).expect("one size"));
        println!("frame {frame}: relMSE {errors:?}");
        assert!(errors[1] < 1.01 * errors[0], "frame {frame}: relMSE {errors:?}");
    }
}

/// A wall with a roof moves before the sky: light on it moves along.
fn moved_objects_are_followed() {
    let scene = |frame: u32| {
        let x = 3.0 * WALL_PIXEL * frame as f32 - 0.5;
        parse(&format!(
            "pathmarch 1\ncamera {{ position 0 0 2; target 0 0 0; fov 53.130102 }}\n\
             render {{ size 96 64; bounces 2 }}\nsky 1\n\
             object \"niche\" {{ union {{ box 1 1.2 0.4 {{ at 0 0 -0.2 }}; box 1 0.1 1 {{ at 0 0.5 0.5 }}; at {x} 0 0 }} }}"
        ))
    };
    let frames = sequence(6, scene, 8);
    // The face of the wall, 32 pixels wide, in the last frame: x = -0.03.
    let is_face = |x: u32, y: u32| (36..60).contains(&x) && (26..46).contains(&y);
    let flicker = [0, 1].map(|k: usize| change(&frames[5][k], &frames[4][k], -3, is_face));
    println!("change on the object: {flicker:?}");
    assert!(flicker[1] < 0.6 * flicker[0], "{flicker:?}");
}

fn sequences_start_anew_when_told_and_at_another_size() {
    let scene = board(0.0, 20.0);
    let mut denoiser = SequenceDenoiser::new();
    let mut next = |seed: u32, size: [u32; 2], forgets: bool| {
        let settings = Settings { samples: 8, seed, size, ..Settings::of(&scene) };
        let halves = halves(&cpu(), &scene, &settings);
        let features = Features::trace(&scene, &settings, 8).expect("features");
        if forgets {
            denoiser.forget();
            assert!(!denoiser.has_past());
        }
        let joined = denoiser.denoise(&halves, &features).expect("a picture");
        joined == Denoiser::Regression.denoise(&halves, &features).expect("a picture")
    };
    assert!(next(0, [48, 32], false), "the first");
    assert!(!next(1, [48, 32], false), "another seed");
    assert!(next(2, [48, 32], true), "forgotten");
    assert!(next(3, [40, 30], false), "another size");
}

tests! {
    plain: [
        a_picture_with_little_noise_gets_no_worse,
        constants_stay_and_noise_goes,
        edges_of_shadows_are_kept,
        fireflies_spread_no_blotches_and_extremes_stay_finite,
        tiny_pictures_and_single_samples_are_denoised,
        motion_blur_is_denoised,
        features_of_another_size_are_refused,
        pictures_at_rest_are_those_of_stills,
        noise_does_not_flicker_when_the_camera_moves,
        a_light_that_switches_leaves_no_trail,
        moved_objects_are_followed,
        sequences_start_anew_when_told_and_at_another_size,
    ],
    on_each_backend: [errors_fall_and_energy_is_kept, halves_add_up_to_the_film],
}
