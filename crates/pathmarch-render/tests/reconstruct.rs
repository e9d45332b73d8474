//! Reconstructed sequences: nearer to the converged picture than their samples, with the same energy, without trails.

use crate::common::{cpu, on_both_backends, on_each_backend, parse};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::{block_means, relmse};
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use pathmarch_render::reconstruct::{Frame, ReconstructOptions, Sequence};
use pathmarch_render::{Renderer, Settings};
use pathmarch_testing::{ignore, plain, tests};
use std::ops::Range;
use std::sync::Arc;

const SIZE: [u32; 2] = [96, 54];

/// Room with a lamp, a ball and a mirror.
const ROOM: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0; fov 30 }\nrender { bounces 3 }\n\
    material \"white\" { diffuse 0.7 }\nmaterial \"red\" { diffuse 0.6 0.1 0.1 }\nmaterial \"lamp\" { emit 6 }\n\
    material \"mirror\" { metal 0.9; roughness 0 }\n\
    object \"floor\" material=\"white\" { rect 4 }\nobject \"back\" material=\"red\" { rect 4 { normal 0 0 1; at 0 1 -1.5 } }\n\
    object \"lamp\" material=\"lamp\" { rect 1 { normal 0 -1 0; at 0 2.2 0 } }\n\
    object \"ball\" material=\"white\" { sphere 0.4 { at 0.5 0.4 0.3 } }\n\
    object \"mirror\" material=\"mirror\" { box 0.6 1 0.1 { rotate 0 20 0; at -0.7 0.5 -0.5 } }";

fn room() -> Arc<Scene> {
    Arc::new(parse(ROOM))
}

/// Camera of the scene, moved to the right.
fn moved(scene: &Scene, x: f32) -> Camera {
    let mut camera = scene.cameras[0].clone();
    camera.position[0] += x;
    camera
}

/// A camera with a wide lens, focused at 3 m.
fn through_lens(camera: Camera) -> Camera {
    Camera { lens_radius: 0.15, focus: Some(3.0), ..camera }
}

fn sequence() -> Sequence {
    Sequence::new(&cpu(), ReconstructOptions::default())
}

fn settings(scene: &Scene, camera: Camera, samples: u32, seed: u32) -> Settings {
    Settings { size: SIZE, samples, seed, viewpoint: Some(camera), ..Settings::of(scene) }
}

fn next(sequence: &mut Sequence, scene: &Arc<Scene>, camera: Camera, seed: u32) -> Frame {
    sequence.render(scene, &settings(scene, camera, 1, seed)).expect("a picture")
}

fn converged(scene: &Scene, camera: Camera) -> Picture {
    cpu().render(scene, &settings(scene, camera, 512, 12345)).expect("a film").mean()
}

/// Mean of the channels of all pixels.
fn mean(picture: &Picture) -> f64 {
    picture.mean_colour().iter().sum::<f64>() / 3.0
}

/// These columns and rows of a picture.
fn part(picture: &Picture, columns: Range<u32>, rows: Range<u32>) -> Picture {
    let [width, height] = [&columns, &rows].map(|range| range.len() as u32);
    let pixels = rows.flat_map(|y| columns.clone().filter_map(move |x| picture.get(x, y)));
    Picture { width, height, pixels: pixels.collect() }
}

fn a_moving_picture_is_clean_and_keeps_its_energy() {
    let scene = room();
    let mut sequence = sequence();
    let mut last = None;
    for frame in 0..16 {
        last = Some(next(&mut sequence, &scene, moved(&scene, 0.02 * frame as f32), frame));
    }
    let last = last.expect("a frame");
    let reference = converged(&scene, moved(&scene, 0.3));
    let [before, after] =
        [&last.noisy, &last.reconstructed].map(|picture| relmse(picture, &reference).expect("finite"));
    let energy = mean(&last.reconstructed) / mean(&reference);
    println!("relMSE {before:.4} before, {after:.4} after; energy {energy:.4}");
    assert!(after < 0.1 * before, "{before} {after}");
    assert!((energy - 1.0).abs() < 0.02, "{energy}");
    let blocks = [&last.reconstructed, &reference].map(|picture| block_means(picture, 18));
    let error = relmse(&blocks[0], &blocks[1]).expect("finite");
    assert!(error < 3e-3, "blocks differ by {error}");
}

fn the_first_picture_is_clean_too() {
    let scene = room();
    let first = next(&mut sequence(), &scene, moved(&scene, 0.0), 7);
    let reference = converged(&scene, moved(&scene, 0.0));
    // Clipped as on a screen: the jagged edges of the lamp do not count as noise.
    let clipped = |picture: &Picture| Picture {
        pixels: picture.pixels.iter().map(|pixel| pixel.map(|channel| channel.min(1.0))).collect(),
        ..*picture
    };
    let [before, after] = [&first.noisy, &first.reconstructed]
        .map(|picture| relmse(&clipped(picture), &clipped(&reference)).expect("finite"));
    println!("relMSE {before:.4} before, {after:.4} after");
    assert!(after < 0.5 * before, "{before} {after}");
}

fn uniform_light_stays_as_it_is() {
    // Under a white sky everything white is white, whatever is averaged with what.
    let text = "pathmarch 1\ncamera { position 0 1 4; target 0 0.5 0 }\nrender { bounces 16 }\nsky 1\n\
        material \"white\" { diffuse 1 }\nobject \"ball\" material=\"white\" { sphere 0.5 { at 0 0.5 0 } }";
    let scene = Arc::new(parse(text));
    let mut sequence = sequence();
    for frame in 0..6 {
        let shown = next(&mut sequence, &scene, moved(&scene, 0.03 * frame as f32), frame).reconstructed;
        for pixel in &shown.pixels {
            assert!(pixel.iter().all(|channel| (channel - 1.0).abs() < 1e-3), "{pixel:?}");
        }
    }
}

fn nothing_stays_where_an_object_was() {
    let at = |x: f32| Arc::new(parse(&ROOM.replace("at 0.5 0.4 0.3", &format!("at {x} 0.4 0.3"))));
    let [before, after] = [at(-0.2), at(0.7)];
    let reference = converged(&after, moved(&after, 0.0));
    // Columns and rows of the ball before it jumped.
    let region = |picture: &Picture| {
        let pixels = (30..44).flat_map(|y| (38..48).filter_map(move |x| picture.get(x, y)));
        pixels.map(|pixel| f64::from(pixel.iter().sum::<f32>())).sum::<f64>()
    };
    // The mean of several sequences: four samples of so few pixels are uncertain by some percent.
    const SEQUENCES: u32 = 6;
    let [mut with_past, mut without] = [0.0; 2];
    for number in 0..SEQUENCES {
        let [mut moved_there, mut always_there] = [sequence(), sequence()];
        for frame in 0..8 {
            next(&mut moved_there, &before, moved(&before, 0.0), 100 * number + frame);
        }
        let last = |sequence: &mut Sequence| {
            let frames = (8..12).map(|frame| next(sequence, &after, moved(&after, 0.0), 100 * number + frame));
            frames.last().map_or(0.0, |frame| region(&frame.reconstructed))
        };
        with_past += last(&mut moved_there) / f64::from(SEQUENCES);
        without += last(&mut always_there) / f64::from(SEQUENCES);
    }
    let [trail, error] = [with_past / without, with_past / region(&reference)];
    println!("vacated pixels: {trail:.4} of those without a past, {error:.4} of the reference");
    assert!((trail - 1.0).abs() < 0.02, "{trail}");
    assert!((error - 1.0).abs() < 0.1, "{error}");
}

fn light_that_is_switched_off_fades_at_once() {
    let bright = room();
    let dim = Arc::new(parse(&ROOM.replace("emit 6", "emit 0.3")));
    let mut sequence = sequence();
    for frame in 0..24 {
        next(&mut sequence, &bright, moved(&bright, 0.0), frame);
    }
    let [high, low] = [&bright, &dim].map(|scene| mean(&converged(scene, moved(scene, 0.0))));
    let mut left = Vec::new();
    for frame in 24..32 {
        let shown = next(&mut sequence, &dim, moved(&dim, 0.0), frame);
        left.push((mean(&shown.reconstructed) - low) / (high - low));
    }
    println!("left of the step after each picture: {left:.3?}");
    assert!(left[7].abs() < 0.1, "{left:?}");
}

/// A lamp gets redder and weaker in every picture.
fn light_that_changes_its_colour_does_not_lag() {
    let room = |frame: u32| {
        let [green, blue] = [0.94f32, 0.88].map(|factor| 6.0 * factor.powi(frame as i32));
        Arc::new(parse(&ROOM.replace("emit 6", &format!("emit 6 {green} {blue}"))))
    };
    let mut sequence = sequence();
    let frames = (0..16).map(|frame| next(&mut sequence, &room(frame), moved(&room(frame), 0.0), frame));
    let shown = frames.last().expect("a frame").reconstructed.mean_colour();
    let [before, now] = [14, 15].map(|frame| converged(&room(frame), moved(&room(frame), 0.0)).mean_colour());
    // Pictures by which the channels that change are late.
    let late: [f64; 2] = [1, 2].map(|k| (shown[k] - now[k]) / (before[k] - now[k]));
    println!("green and blue are {late:.3?} pictures late; red {:.4}", shown[0] / now[0]);
    // Means over six pictures are five late.
    assert!(late.iter().all(|late| late.abs() < 1.2), "{late:?}");
    assert!((shown[0] / now[0] - 1.0).abs() < 0.02);
}

/// A lamp moves over a glossy floor and a box of metal.
fn both_backends_follow_a_moving_lamp(renderers: &mut [Renderer; 2]) {
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    for frame in 0..6 {
        let lamp = format!("rect 0.8 0.8 {{ at {} 1.1 -1.5;", 0.2 + 0.1 * frame as f32);
        let text = glossy_room("0.25").replace("sphere 0.4", "box 0.6 0.8 0.6");
        let scene = Arc::new(parse(&text.replace("rect 0.8 0.8 { at 0.2 1.1 -1.5;", &lamp)));
        let error = difference(&mut sequences, &scene, &settings(&scene, moved(&scene, 0.0), 1, frame), SIZE);
        println!("frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-4, "{frame}: {error}");
    }
}

fn sizes_jumps_and_cuts_leave_finite_pictures(renderer: &Renderer) {
    let scenes = [room(), Arc::new(parse(&ROOM.replace("sphere 0.4", "torus 0.4 0.1")))];
    let mut sequence = Sequence::new(renderer, ReconstructOptions::default());
    for frame in 0..12 {
        let scene = &scenes[frame as usize / 5 % 2];
        let mut camera = moved(scene, if frame % 3 == 0 { 40.0 } else { 0.0 });
        if frame % 4 == 3 {
            // Looks away from everything.
            camera.target[2] = 100.0;
        }
        let size = [[96, 54], [1, 1], [33, 70], [5, 3]][frame as usize % 4];
        let settings = Settings { size, ..settings(scene, camera, 1, frame) };
        let shown = sequence.render(scene, &settings).expect("a picture").reconstructed;
        assert_eq!([shown.width, shown.height], size);
        assert!(shown.pixels.iter().flatten().all(|channel| channel.is_finite() && *channel >= 0.0), "{frame}");
    }
}

fn rejected_samples_leave_no_trail(renderer: &Renderer) {
    // The sum of both lamps is no number.
    let text = GLOSSY_ROOM.replace("object \"floor\"", "material \"sun\" { emit 3e38 }\n\
        object \"suns\" material=\"sun\" { union { sphere 0.2 { at 0.5 1.5 0 }; sphere 0.2 { at 1 1.5 0 } } }\nobject \"floor\"");
    let [scene, dark] = [Arc::new(parse(&text)), Arc::new(parse(&text.replace("3e38", "0.01")))];
    let mut sequence = Sequence::new(renderer, ReconstructOptions::default());
    let mut rejected = 0;
    for frame in 0..8 {
        let scene = if frame < 4 { &scene } else { &dark };
        let shown = next(&mut sequence, scene, moved(scene, 0.02 * frame as f32), frame);
        rejected += shown.noisy.pixels.iter().flatten().filter(|channel| !channel.is_finite()).count();
        let finite = |picture: &Picture| picture.pixels.iter().flatten().all(|channel| channel.is_finite());
        assert!(finite(&shown.noisy) && finite(&shown.reconstructed), "{frame}");
        if frame == 7 {
            let brightest = shown.reconstructed.pixels.iter().flatten().copied().fold(0.0, f32::max);
            assert!(brightest < 20.0, "{brightest}");
        }
    }
    assert_eq!(rejected, 0);
}

fn pictures_that_do_not_fit_are_shown_as_they_are([_, renderer]: &mut [Renderer; 2]) {
    if !renderer.backend().adapter.contains("llvmpipe") {
        ignore("only Mesa's software device is known to have buffers of at most 128 MiB");
    }
    let scene = room();
    let mut sequence = Sequence::new(renderer, ReconstructOptions::default());
    // Guides of 64 bytes for each pixel, in a buffer of at most 128 MiB.
    for (size, fits) in [([64, 36], true), ([2048, 1200], false), ([64, 36], true)] {
        let settings = Settings { size, ..settings(&scene, moved(&scene, 0.0), 1, 1) };
        let frame = sequence.render(&scene, &settings).expect("a picture");
        assert_eq!(frame.reconstructed == frame.noisy, !fits, "{size:?}");
    }
}

fn a_still_picture_of_many_samples_is_not_altered() {
    let scene = room();
    let mut sequence = sequence();
    next(&mut sequence, &scene, moved(&scene, 0.1), 1);
    let still = settings(&scene, moved(&scene, 0.1), 128, 0);
    let shown = sequence.render(&scene, &still).expect("a picture");
    assert_eq!(shown.reconstructed, cpu().render(&scene, &still).expect("a film").mean());
}

/// Share of the pixels whose channels differ by less than 0.1.
fn share_of_equal(a: &Picture, b: &Picture) -> f64 {
    let equal = |(a, b): &(&[f32; 3], &[f32; 3])| (0..3).all(|k| (a[k] - b[k]).abs() < 0.1);
    a.pixels.iter().zip(&b.pixels).filter(equal).count() as f64 / a.pixels.len() as f64
}

/// relMSE between the next pictures of two sequences.
fn difference(sequences: &mut [Sequence; 2], scene: &Arc<Scene>, settings: &Settings, size: [u32; 2]) -> f64 {
    let next = |sequence: &mut Sequence| sequence.render_upscaled(scene, settings, size).expect("a picture");
    let [a, b] = sequences.each_mut().map(next);
    relmse(&a.reconstructed, &b.reconstructed).expect("finite")
}

fn both_backends_reconstruct_alike(renderers: &mut [Renderer; 2]) {
    let at = |x: f32| Arc::new(parse(&ROOM.replace("at 0.5 0.4 0.3", &format!("at {x} 0.4 0.3"))));
    let balls = [at(0.5), at(0.53), at(0.56), at(0.6)];
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    for frame in 0..8 {
        let scene = &balls[(frame as usize).saturating_sub(3).min(3)];
        let settings = settings(scene, moved(scene, 0.02 * frame as f32), 1, frame);
        let size = if frame % 3 == 2 { SIZE.map(|side| 2 * side) } else { SIZE };
        let [a, b] =
            sequences.each_mut().map(|sequence| sequence.render_upscaled(scene, &settings, size).expect("a picture"));
        let error = relmse(&a.reconstructed, &b.reconstructed).expect("finite");
        let lengths = share_of_equal(&a.history_length, &b.history_length);
        let motion = share_of_equal(&a.motion, &b.motion);
        println!("frame {frame}: relMSE {error:.2e}; equal histories {lengths:.4}, motions {motion:.4}");
        assert!(error < 1e-5 && lengths > 0.98 && motion > 0.98, "{frame}: {error} {lengths} {motion}");
    }
    // Lamps, in front of each other, at another size.
    let lamps = Arc::new(parse(LAMPS));
    for frame in 8..11 {
        let settings = settings(&lamps, moved(&lamps, 0.03 * frame as f32), 1, frame);
        let size = if frame == 10 { [150, 96] } else { SIZE };
        let error = difference(&mut sequences, &lamps, &settings, size);
        println!("lamps, frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-5, "{frame}: {error}");
    }
    let lamps = Arc::new(parse(LAMPS_OUT_OF_FOCUS));
    for frame in 11..15 {
        let x = 0.02 * frame.min(13) as f32;
        // At rest, a film of several samples.
        let settings = settings(&lamps, moved(&lamps, x), if frame == 14 { 9 } else { 1 }, frame);
        let size = if frame == 13 { [150, 96] } else { SIZE };
        let error = difference(&mut sequences, &lamps, &settings, size);
        println!("lamps out of focus, frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-5, "{frame}: {error}");
    }
    // A lens, focused in front of everything.
    let scene = &balls[3];
    for frame in 0..3 {
        let settings = settings(scene, through_lens(moved(scene, 0.02 * frame as f32)), 1, frame);
        let error = difference(&mut sequences, scene, &settings, SIZE);
        println!("lens, frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-5, "{frame}: {error}");
    }
    // At rest, films of several samples, of which the pixels of the second share light.
    for path_reuse in [None, Some(true)] {
        let settings = Settings { path_reuse, ..settings(scene, moved(scene, 0.14), 9, 8) };
        let [a, b] = sequences.each_mut().map(|sequence| sequence.render(scene, &settings).expect("a picture"));
        let [error, noisy] = [relmse(&a.reconstructed, &b.reconstructed), relmse(&a.noisy, &b.noisy)]
            .map(|error| error.expect("finite"));
        println!("at rest, path reuse {path_reuse:?}: relMSE {error:.2e}, of the samples {noisy:.2e}");
        assert!(error < 1e-5 && noisy < 1e-5, "{path_reuse:?}: {error}, of the samples {noisy}");
    }
}

/// Glossy floor and a ball of rough metal under a lamp.
const GLOSSY_ROOM: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 0.6 0; fov 30 }\nrender { bounces 2 }\n\
    sky 0.1 0.1 0.15\nmaterial \"floor\" { principled 0.3 0.2 0.1; roughness 0.25 }\n\
    material \"gold\" { metal 1 0.7 0.3; roughness 0.3 }\nmaterial \"lamp\" { emit 6 }\n\
    object \"floor\" material=\"floor\" { rect 6 }\n\
    object \"lamp\" material=\"lamp\" { rect 0.8 0.8 { at 0.2 1.1 -1.5; normal 0 0 1 } }\n\
    object \"ball\" material=\"gold\" { sphere 0.4 { at -0.6 0.4 0.3 } }";

/// The glossy room with a floor of this roughness.
fn glossy_room(roughness: &str) -> String {
    GLOSSY_ROOM.replace("roughness 0.25", &format!("roughness {roughness}"))
}

fn both_backends_filter_facets_alike(renderers: &mut [Renderer; 2]) {
    // After a reflection in a ball, rounding decides what single samples hit.
    for (object, roughness, most) in [("box 0.6 0.8 0.6", "0.25", 1e-4), ("sphere 0.41", "0.5", 5e-4)] {
        let scene = Arc::new(parse(&glossy_room(roughness).replace("sphere 0.4", object)));
        let plain = Arc::new(parse(ROOM));
        let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
        // In between, a scene without facets.
        for frame in 0..10 {
            let scene = if frame == 5 { &plain } else { &scene };
            let settings = settings(scene, moved(scene, 0.04 * frame as f32), 1, frame);
            let error = difference(&mut sequences, scene, &settings, SIZE);
            println!("{object}, frame {frame}: relMSE {error:.2e}");
            assert!(error < most, "{frame}: {error}");
        }
        let settings = settings(&scene, moved(&scene, 0.36), 9, 8);
        let error = difference(&mut sequences, &scene, &settings, SIZE);
        println!("{object}, at rest: relMSE {error:.2e}");
        assert!(error < most, "{error}");
    }
}

fn reflections_stay_where_they_are_while_the_camera_moves() {
    for (roughness, most) in [("0.25", 0.12), ("0.5", 0.02)] {
        let scene = Arc::new(parse(&glossy_room(roughness)));
        let mut sequence = sequence();
        let frames = (0..20).map(|frame| next(&mut sequence, &scene, moved(&scene, 0.05 * frame as f32), frame));
        let last = frames.last().expect("a frame");
        let reference = converged(&scene, moved(&scene, 0.95));
        // The floor in front, with the reflection of the lamp.
        let floor = |picture: &Picture| part(picture, 20..80, 34..54);
        let error = |picture: &Picture| relmse(&floor(picture), &floor(&reference)).expect("finite");
        let [before, after] = [&last.noisy, &last.reconstructed].map(error);
        let energy = mean(&floor(&last.reconstructed)) / mean(&floor(&reference));
        println!("roughness {roughness}: relMSE {before:.4} before, {after:.4} after; energy {energy:.4}");
        assert!(after < most * before, "{roughness}: {before} {after}");
        assert!((energy - 1.0).abs() < 0.08, "{roughness}: {energy}");
    }
}

/// Fog with a bright ball in it, whose light a board blocks, before a wall and the sky; a cloud, and a glossy floor.
const FOGGY_ROOM: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 0.9 0; fov 30 }\nrender { bounces 2 }\n\
    sky 0.02 0.02 0.03\nfog { scatter 0.1; absorb 0.02 }\nmaterial \"lamp\" { emit 9 7 4 }\n\
    material \"floor\" { principled 0.3 0.2 0.1; roughness 0.25 }\nmaterial \"cloud\" { medium 2; absorb 0.2 }\n\
    object \"floor\" material=\"floor\" { rect 6 }\nobject \"wall\" { rect 3 1 { normal 0 0 1; at -1.5 0.5 -3 } }\n\
    object \"lamp\" material=\"lamp\" { sphere 0.12 { at 0 0.9 0 } }\nobject \"board\" { rect 0.6 0.6 { normal -1 0 0; at 0.3 1 0 } }\n\
    object \"post\" { box 0.2 3 0.2 { at -0.6 1 2 } }\nobject \"cloud\" material=\"cloud\" { sphere 0.3 { at 0.9 0.4 0.8 } }";

fn both_backends_filter_light_of_media_alike(renderers: &mut [Renderer; 2]) {
    let scene = Arc::new(parse(FOGGY_ROOM));
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    // Seeds for which rounding does not decide what single samples hit.
    for (frame, seed) in [4, 5, 6, 9].into_iter().enumerate() {
        let samples = if frame == 3 { 9 } else { 1 };
        let settings = settings(&scene, moved(&scene, 0.04 * seed as f32), samples, seed);
        let error = difference(&mut sequences, &scene, &settings, SIZE);
        println!("frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-4, "{frame}: {error}");
    }
}

fn light_in_fog_stays_where_it_is_while_the_camera_moves() {
    let scene = Arc::new(parse(FOGGY_ROOM));
    let mut sequence = sequence();
    // The camera circles around the lamp.
    let around = |angle: f32| {
        let mut camera = scene.cameras[0].clone();
        camera.position = [5.0 * angle.sin(), 1.0, 5.0 * angle.cos()];
        camera
    };
    let frames = (0..20).map(|frame| next(&mut sequence, &scene, around(0.03 * frame as f32), frame));
    let last = frames.last().expect("a frame");
    let reference = converged(&scene, around(0.57));
    // Without the lamp in the middle, whose edges are noisy.
    let of_fog = |picture: &Picture| {
        let is_apart = |(x, y): &(u32, u32)| x.abs_diff(48) > 9 || y.abs_diff(27) > 9;
        let places = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))).filter(is_apart);
        let pixels: Vec<[f32; 3]> = places.filter_map(|(x, y)| picture.get(x, y)).collect();
        Picture { width: pixels.len() as u32, height: 1, pixels }
    };
    let [before, after, truth] = [&last.noisy, &last.reconstructed, &reference].map(of_fog);
    let energy = mean(&after) / mean(&truth);
    let [before, after] = [&before, &after].map(|picture| relmse(picture, &truth).expect("finite"));
    println!("relMSE {before:.5} before, {after:.5} after; energy {energy:.4}");
    assert!(after < 0.05 * before, "{before} {after}");
    assert!((energy - 1.0).abs() < 0.04, "{energy}");
}

/// Lamps of several sizes and colours before a dim wall, one before another.
const LAMPS: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0; fov 30 }\nrender { bounces 1 }\n\
    material \"wall\" { diffuse 0.4 0.3 0.2 }\nmaterial \"white\" { emit 20 }\nmaterial \"red\" { emit 9 2 1 }\n\
    object \"wall\" material=\"wall\" { rect 9 { normal 0 0 1; at 0 1 -1.5 } }\n\
    object \"ball\" material=\"wall\" { sphere 0.3 { at -0.4 0.8 0.5 } }\n\
    object \"a\" material=\"white\" { sphere 0.2 { at 0.6 1.2 0 } }\n\
    object \"b\" material=\"red\" { sphere 0.4 { at 0.9 0.9 -0.6 } }\n\
    object \"c\" material=\"white\" { box 0.5 0.3 0.1 { rotate 0 0 20; at -0.7 1.4 0 } }\n\
    object \"d\" material=\"red\" { sphere 0.02 { at 0 1.5 0.5 } }";

fn lamps_have_clean_edges_while_the_camera_moves() {
    let scene = Arc::new(parse(LAMPS));
    let reference = converged(&scene, moved(&scene, 0.3));
    let errors = [true, false].map(|emitter_edges| {
        let mut sequence = Sequence::new(&cpu(), ReconstructOptions { emitter_edges, ..ReconstructOptions::default() });
        let frames = (0..11).map(|frame| next(&mut sequence, &scene, moved(&scene, 0.03 * frame as f32), frame));
        let last = frames.last().expect("a frame").reconstructed;
        let (error, energy) = (relmse(&last, &reference).expect("finite"), mean(&last) / mean(&reference));
        println!("edges {emitter_edges}: relMSE {error:.4}, energy {energy:.4}");
        assert!((energy - 1.0).abs() < 0.02, "{energy}");
        error
    });
    assert!(errors[0] < 0.3 * errors[1], "{errors:?}");
}

/// Small lamps far out of focus, of which two overlap, one is hidden in part, and one is before the focus.
const LAMPS_OUT_OF_FOCUS: &str = "pathmarch 1\ncamera { position 0 1 4; target 0 1 0; fov 40; lens radius=0.15 focus=4 }\n\
    render { bounces 2 }\nsky 0.05\nmaterial \"wall\" { diffuse 0.5 }\nmaterial \"white\" { emit 90 }\n\
    material \"red\" { emit 60 8 5 }\nmaterial \"blue\" { emit 5 8 40 }\n\
    object \"wall\" material=\"wall\" { rect 60 { normal 0 0 1; at 0 1 -9 } }\n\
    object \"ball\" material=\"wall\" { sphere 0.3 { at -0.7 0.9 0 } }\n\
    object \"a\" material=\"white\" { sphere 0.08 { at 1 1.6 -7 } }\n\
    object \"b\" material=\"red\" { sphere 0.06 { at 1.2 1.5 -6 } }\n\
    object \"c\" material=\"red\" { box 0.1 0.1 0.05 { at -1.2 1.2 -5 } }\n\
    object \"d\" material=\"blue\" { sphere 0.02 { at 0.1 0.8 1.5 } }";

fn lamps_out_of_focus_are_discs_while_the_camera_moves() {
    let scene = Arc::new(parse(LAMPS_OUT_OF_FOCUS));
    let settings = Settings { emitter_edges: Some(true), ..settings(&scene, moved(&scene, 0.2), 512, 12345) };
    let reference = cpu().render(&scene, &settings).expect("a film").mean();
    let [error, without] = [true, false].map(|emitter_edges| {
        let mut sequence = Sequence::new(&cpu(), ReconstructOptions { emitter_edges, ..ReconstructOptions::default() });
        let render = |frame: u32| next(&mut sequence, &scene, moved(&scene, 0.02 * frame as f32), frame).reconstructed;
        let pictures: Vec<Picture> = (0..11).map(render).collect();
        let error = relmse(&pictures[10], &reference).expect("finite");
        let energy = pictures[5..].iter().map(mean).sum::<f64>() / (6.0 * mean(&reference));
        println!("edges {emitter_edges}: relMSE {error:.4}, energy {energy:.4}");
        assert!(!emitter_edges || (energy - 1.0).abs() < 0.02, "{energy}");
        error
    });
    assert!(error < 0.3 * without, "{error}, without edges {without}");
}

/// The room, with a ball of this radius.
fn room_with_ball(radius: f32) -> Arc<Scene> {
    Arc::new(parse(&ROOM.replace("sphere 0.4 {", &format!("sphere {radius} {{"))))
}

fn a_growing_ball_keeps_its_past() {
    let mut sequence = sequence();
    let mut last = None;
    for frame in 0..6 {
        let scene = room_with_ball(0.1 + 0.12 * frame as f32);
        last = Some(next(&mut sequence, &scene, moved(&scene, 0.0), frame));
    }
    let last = last.expect("a frame");
    // Pixels in the middle of the ball, whose centre is at (0.5, 0.4, 0.3).
    let (x, y) = (48.0 + 0.5 / 4.7 * 27.0 / 0.268, 27.0 + 0.5 / 4.7 * 27.0 / 0.268);
    let radius = 0.34 / 4.7 * 27.0 / 0.268;
    let inside = |column: u32, row: u32| (column as f32 + 0.5 - x).hypot(row as f32 + 0.5 - y) < radius;
    let mut pixels = Vec::new();
    for (column, row) in (0..SIZE[1]).flat_map(|row| (0..SIZE[0]).map(move |column| (column, row))) {
        if inside(column, row) {
            pixels.push((column, row));
        }
    }
    let kept = pixels.iter().filter(|(x, y)| last.motion.get(*x, *y).is_some_and(|[.., is_known]| is_known == 1.0));
    let share = kept.count() as f32 / pixels.len() as f32;
    println!("{share:.3} of {} pixels of the ball have a past", pixels.len());
    assert!(pixels.len() > 60 && share > 0.95, "{share}");
}

fn mirror_images_keep_their_past_while_the_camera_moves() {
    let scene = room();
    let mut sequence = sequence();
    let mut last = None;
    for frame in 0..8 {
        last = Some(next(&mut sequence, &scene, moved(&scene, 0.04 * frame as f32), frame));
    }
    let lengths = last.expect("a frame").history_length;
    // Pixels of the mirror; those to the left of them show what has just come into sight. Where they have contrast and little
    // noise, histories are short.
    let pixels = (28..38).flat_map(|row| (34..38).map(move |column| (column, row)));
    let found: Vec<[f32; 3]> = pixels.filter_map(|(column, row)| lengths.get(column, row)).collect();
    let share = found.iter().filter(|length| length[0] >= 3.0).count() as f32 / found.len() as f32;
    println!("{share:.3} of {} pixels of the mirror have a past", found.len());
    assert!(found.len() == 40 && share > 0.95, "{share}");
}

/// A mirror before a white wall, which shows a dark wall behind the camera.
const MIRROR: &str = "pathmarch 1\ncamera { position 0 1 6; target 0 1 0; fov 30 }\nrender { bounces 2 }\nsky 1\n\
    material \"white\" { diffuse 0.8 }\nmaterial \"black\" { diffuse 0.05 }\n\
    material \"mirror\" { metal 0.9; roughness 0 }\n\
    object \"wall\" material=\"white\" { rect 20 { normal 0 0 1; at 0 1 -1.5 } }\n\
    object \"behind\" material=\"black\" { rect 40 { normal 0 0 -1; at 0 1 14 } }\n\
    object \"mirror\" material=\"mirror\" { rect 1.2 { normal 0 0 1; at 0 1 0 } }";

fn outlines_of_mirrors_move_with_them() {
    let scene = Arc::new(parse(MIRROR));
    let mut sequence = sequence();
    let frames = (0..20).map(|frame| {
        let settings = settings(&scene, moved(&scene, 0.05 * frame as f32), 1, 7);
        sequence.render(&scene, &Settings { first_sample: frame, ..settings }).expect("a picture").reconstructed
    });
    let last = frames.last().expect("a frame");
    let reference = converged(&scene, moved(&scene, 0.95));
    // Means of columns, in rows that show the mirror.
    let column = |picture: &Picture, x: u32| {
        (20..34).filter_map(|y| picture.get(x, y)).map(|pixel| f64::from(pixel[1])).sum::<f64>() / 14.0
    };
    let [wall, mirror] = [20, 48].map(|x| column(&reference, x));
    // Pixels by which the left and the right edge are off.
    let lags = [35..41, 55..61]
        .map(|columns| columns.map(|x| column(&last, x) - column(&reference, x)).sum::<f64>() / (wall - mirror));
    println!("edges are off by {lags:.3?} pixels");
    // With the motion of the image, it is about 0.2 and -0.3.
    assert!(wall > 4.0 * mirror && lags.iter().all(|lag| lag.abs() < 0.15), "{lags:?}");
}

/// Ball of chrome before a gradient.
const CHROME: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0; fov 30 }\nrender { bounces 2 }\n\
    sky \"gradient\" { zenith 0.1 0.3 1; horizon 1 0.8 0.6 }\nmaterial \"mirror\" { metal 0.9; roughness 0 }\n\
    object \"ball\" material=\"mirror\" { sphere 1 { at 0 1 0 } }";

fn both_backends_leave_no_trail_of_the_sky_in_a_ball(renderers: &mut [Renderer; 2]) {
    let scene = Arc::new(parse(CHROME));
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    let reference = converged(&scene, moved(&scene, 0.95));
    for frame in 0..20 {
        let settings = settings(&scene, moved(&scene, 0.05 * frame as f32), 1, frame);
        let [a, b] = sequences.each_mut().map(|sequence| sequence.render(&scene, &settings).expect("a picture"));
        let error = relmse(&a.reconstructed, &b.reconstructed).expect("finite");
        println!("frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-5, "frame {frame}: {error}");
        if frame == 19 {
            let [before, after] = [&a.noisy, &a.reconstructed]
                .map(|picture| relmse(&middle_of_ball(picture), &middle_of_ball(&reference)).expect("finite"));
            println!("relMSE {before:.2e} before, {after:.2e} after");
            // With the past of any sky, it is about ten times as large.
            assert!(after < 1.5 * before, "{before} {after}");
        }
    }
}

/// A dark ball at this place along a smooth floor of metal.
fn over_metal(x: f32) -> Arc<Scene> {
    Arc::new(parse(&format!(
        "pathmarch 1\ncamera {{ position 0 1 5; target 0 0.4 0; fov 30 }}\nrender {{ bounces 2 }}\nsky 0.8 0.9 1\n\
         material \"metal\" {{ metal 0.8; roughness 0.05 }}\nmaterial \"dark\" {{ diffuse 0.1 0.05 0.05 }}\n\
         object \"floor\" material=\"metal\" {{ plane }}\nobject \"ball\" material=\"dark\" {{ sphere 0.5 {{ at {x} 0.5 0 }} }}"
    )))
}

fn both_backends_follow_what_a_floor_mirrors(renderers: &mut [Renderer; 2]) {
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    for frame in 0..8 {
        let scene = over_metal(0.15 * frame as f32 - 0.6);
        let settings = settings(&scene, moved(&scene, 0.0), 1, frame);
        let [a, b] = sequences.each_mut().map(|sequence| sequence.render(&scene, &settings).expect("a picture"));
        let error = relmse(&a.reconstructed, &b.reconstructed).expect("finite");
        println!("frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-4, "{frame}: {error}");
        if frame == 7 {
            let reference = converged(&scene, moved(&scene, 0.0));
            // What the floor in front of the ball mirrors.
            let floor = |picture: &Picture| part(picture, 30..90, 40..54);
            let error = relmse(&floor(&a.reconstructed), &floor(&reference)).expect("finite");
            println!("relMSE {error:.4} of what the floor mirrors");
            // With the weights of other surfaces in anti-aliasing, it is 0.24.
            assert!(error < 0.16, "{error}");
        }
    }
}

/// The middle of the ball of `CHROME`.
fn middle_of_ball(picture: &Picture) -> Picture {
    part(picture, 38..58, 17..37)
}

fn lacquer_has_no_grain_while_the_camera_moves() {
    let lacquer = "principled 0.5 0.05 0.04; roughness 0.4; coat 1; coat-roughness 0.03";
    let scene = Arc::new(parse(&CHROME.replace("metal 0.9; roughness 0", lacquer)));
    let mut sequence = sequence();
    let frames = (0..20).map(|frame| next(&mut sequence, &scene, moved(&scene, 0.05 * frame as f32), frame));
    let last = frames.last().expect("a frame");
    let reference = middle_of_ball(&converged(&scene, moved(&scene, 0.95)));
    let [before, after] = [&last.noisy, &last.reconstructed].map(middle_of_ball);
    let energy = mean(&after) / mean(&reference);
    let [before, after] = [before, after].map(|picture| relmse(&picture, &reference).expect("finite"));
    println!("relMSE {before:.2e} before, {after:.2e} after; energy {energy:.4}");
    // Where points as far apart as those of chrome do not share light, it is 0.06.
    assert!(after < 0.02 * before, "{before} {after}");
    assert!((energy - 1.0).abs() < 0.05, "{energy}");
}

/// Checker to the horizon, with a ball of bricks.
const TEXTURED: &str = "pathmarch 1\ncamera { position 0 0.7 4; target 0 0.6 0; fov 40 }\nrender { bounces 2 }\n\
    sky \"gradient\" { zenith 0.7 0.78 0.9; horizon 0.9 0.86 0.8; ground 0.35 0.3 0.26 }\n\
    material \"checker\" { diffuse { checker size=0.3 { colour 0.1; colour 0.8 } } }\n\
    material \"brick\" { principled { brick length=0.2 course=0.07 mortar=0.02 { colour 0.6; colour 0.3 0.1 0.05 } } }\n\
    object \"floor\" material=\"checker\" { plane }\n\
    object \"ball\" material=\"brick\" { sphere 0.6 { rotate 10 20 0; at 0 0.6 0 } }";

fn textures_have_no_grain_while_the_camera_moves() {
    let scene = Arc::new(parse(TEXTURED));
    // At the size of the samples, and enlarged.
    for factor in [1, 2] {
        let size = SIZE.map(|side| factor * side);
        let many = Settings { size, ..settings(&scene, moved(&scene, 0.33), 256, 12345) };
        let reference = cpu().render(&scene, &many).expect("a film").mean();
        let errors = [true, false].map(|texture_filter| {
            let options = ReconstructOptions { texture_filter, ..ReconstructOptions::default() };
            let mut sequence = Sequence::new(&cpu(), options);
            let frame = |frame: u32| {
                let settings = settings(&scene, moved(&scene, 0.03 * frame as f32), 1, frame);
                sequence.render_upscaled(&scene, &settings, size).expect("a picture")
            };
            let shown = (0..12).map(frame).last().expect("a frame").reconstructed;
            let energy = mean(&shown) / mean(&reference);
            assert!((energy - 1.0).abs() < 0.02, "{energy}");
            relmse(&shown, &reference).expect("finite")
        });
        println!("{size:?}: relMSE {errors:.4?}");
        assert!(errors[0] < 0.5 * errors[1], "{size:?}: {errors:?}");
    }
}

fn both_backends_average_textures_alike(renderers: &mut [Renderer; 2]) {
    let scene = Arc::new(parse(TEXTURED));
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    let twice = SIZE.map(|side| 2 * side);
    // In motion, enlarged, and at rest.
    for (frame, x, size, samples) in [(0, 0.0, SIZE, 1), (1, 0.05, SIZE, 1), (2, 0.1, twice, 1), (3, 0.1, SIZE, 3)] {
        let settings = settings(&scene, moved(&scene, x), samples, frame);
        let error = difference(&mut sequences, &scene, &settings, size);
        println!("frame {frame}: relMSE {error:.2e}");
        assert!(error < 1e-5, "frame {frame}: {error}");
    }
}

fn both_backends_follow_a_growing_ball(renderers: &mut [Renderer; 2]) {
    let mut sequences = renderers.each_ref().map(|renderer| Sequence::new(renderer, ReconstructOptions::default()));
    for frame in 0..5 {
        let scene = room_with_ball(0.3 + 0.03 * frame as f32);
        let settings = settings(&scene, moved(&scene, 0.02 * frame as f32), 1, frame);
        let [a, b] = sequences.each_mut().map(|sequence| sequence.render(&scene, &settings).expect("a picture"));
        let error = relmse(&a.reconstructed, &b.reconstructed).expect("finite");
        let lengths = share_of_equal(&a.history_length, &b.history_length);
        let motion = share_of_equal(&a.motion, &b.motion);
        println!("frame {frame}: relMSE {error:.2e}; equal histories {lengths:.4}, motions {motion:.4}");
        assert!(error < 1e-5 && lengths > 0.98 && motion > 0.98, "{frame}: {error} {lengths} {motion}");
    }
}

tests! {
    on_each_backend: [sizes_jumps_and_cuts_leave_finite_pictures, rejected_samples_leave_no_trail],
    on_both_backends: [
        both_backends_reconstruct_alike,
        both_backends_filter_facets_alike,
        both_backends_follow_a_moving_lamp,
        both_backends_filter_light_of_media_alike,
        both_backends_average_textures_alike,
        both_backends_follow_a_growing_ball,
        both_backends_leave_no_trail_of_the_sky_in_a_ball,
        both_backends_follow_what_a_floor_mirrors,
        pictures_that_do_not_fit_are_shown_as_they_are,
    ],
    plain: [
        a_moving_picture_is_clean_and_keeps_its_energy,
        the_first_picture_is_clean_too,
        uniform_light_stays_as_it_is,
        nothing_stays_where_an_object_was,
        a_growing_ball_keeps_its_past,
        mirror_images_keep_their_past_while_the_camera_moves,
        outlines_of_mirrors_move_with_them,
        reflections_stay_where_they_are_while_the_camera_moves,
        lacquer_has_no_grain_while_the_camera_moves,
        light_in_fog_stays_where_it_is_while_the_camera_moves,
        lamps_have_clean_edges_while_the_camera_moves,
        textures_have_no_grain_while_the_camera_moves,
        lamps_out_of_focus_are_discs_while_the_camera_moves,
        light_that_is_switched_off_fades_at_once,
        light_that_changes_its_colour_does_not_lag,
        a_still_picture_of_many_samples_is_not_altered,
    ],
}
