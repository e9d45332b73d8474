//! Live pictures: first picture, refinement, rest, changes of the scene, and loss of the device.

use crate::common::{cpu, for_each_backend, parse, scenes, with_gpu};
use pathmarch_render::exposure::suitable_stops;
use pathmarch_render::live::{Live, LiveImage, RenderRequest, Status};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::reconstruct::ReconstructOptions;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Renderer, Settings};
use pathmarch_testing::{plain, tests};
use std::sync::Arc;
use std::time::{Duration, Instant};

const SCENE: &str = "pathmarch 1\ncamera { position 0 1 4; target 0 0.5 0 }\nsky 0.6 0.8 1\n\
    sun { direction 1 2 1; irradiance 2 }\nmaterial \"red\" { diffuse 0.8 0.1 0.1 }\n\
    object \"ball\" material=\"red\" { sphere 1 { at 0 0.5 0 } }\nobject \"floor\" { plane { at 0 -0.5 0 } }";

/// Time after which a test fails; long enough for any machine.
const TIMEOUT: Duration = Duration::from_secs(900);

fn scene() -> Arc<Scene> {
    Arc::new(parse(SCENE))
}

fn request(scene: &Arc<Scene>, size: [u32; 2], samples: u32) -> RenderRequest {
    RenderRequest {
        scene: scene.clone(),
        settings: Settings { size, samples, ..Settings::of(scene) },
        display: Display::default(),
        auto_exposure: false,
        moving: false,
        frame_time: Duration::from_millis(30),
        reconstruct: Some(ReconstructOptions::default()),
    }
}

/// True if `backend` renders; the CPU does in place of the GPU while the kernel is compiled.
fn renders_on(backend: Backend, status: &Status) -> bool {
    (status.backend == "CPU") == (backend == Backend::Cpu)
}

/// Waits until a picture and the status fulfil a condition.
fn until(live: &Live, what: &str, condition: impl Fn(&LiveImage, &Status) -> bool) -> Arc<LiveImage> {
    let started = Instant::now();
    loop {
        let (picture, status) = (live.picture(), live.status());
        if let Some(picture) = picture.filter(|picture| condition(picture, &status)) {
            return picture;
        }
        assert!(started.elapsed() < TIMEOUT, "waited too long for {what}: {status:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn the_picture_equals_that_of_render_and_then_rests(backend: Backend) {
    let scene = scene();
    let request = request(&scene, [96, 54], 12);
    let mut live = Live::new(backend, None, || {});
    let number = live.show(request.clone());
    let shown = until(&live, "the whole picture", |shown, status| {
        shown.request == number && shown.samples == 12.0 && status.resting && renders_on(backend, status)
    });
    assert_eq!(shown.size, request.settings.size);
    let (film, settings) = live.film().recv().expect("an answer").expect("a film");
    let expected = Renderer::open(backend, None).expect("a backend").render(&scene, &request.settings).expect("a film");
    assert_eq!(settings, request.settings);
    assert!(film == expected, "{backend:?}: the films differ");
    let mean = film.mean();
    for (pixel, codes) in mean.pixels.iter().zip(shown.codes.chunks(4)) {
        let expected = request.display.encode_8bit(*pixel);
        for channel in 0..3 {
            assert!(expected[channel].abs_diff(codes[channel]) <= 1, "{codes:?} for {expected:?}");
        }
        assert_eq!(codes[3], 255);
    }
    // No further picture is published.
    let serial = live.picture().expect("a picture").serial;
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(live.picture().expect("a picture").serial, serial);
    // More samples continue the same film.
    live.show(RenderRequest { settings: Settings { samples: 16, ..request.settings.clone() }, ..request.clone() });
    until(&live, "more samples", |shown, status| shown.samples == 16.0 && status.resting);
    // Another exposure shows the same film.
    let brighter = Display { exposure_stops: 2.0, ..request.display };
    let number = live.show(RenderRequest {
        display: brighter,
        settings: Settings { samples: 16, ..request.settings.clone() },
        ..request.clone()
    });
    let bright = until(&live, "another exposure", |shown, _| shown.request == number);
    let sum = |shown: &LiveImage| shown.codes.iter().map(|&code| u64::from(code)).sum::<u64>();
    assert!(bright.samples == 16.0 && sum(&bright) > sum(&shown));
}

/// Pixels of a closed room share light at rest, but not those of an open one.
fn pixels_at_rest_share_light_where_that_pays() {
    let path = scenes().into_iter().find(|path| path.ends_with("cornell-box.kdl")).expect("there");
    let closed = Scene::load(&path).expect("a valid scene");
    for (scene, pays) in [(Arc::new(closed), true), (scene(), false)] {
        let request = request(&scene, [192, 108], 128);
        let mut live = Live::new(Backend::Cpu, None, || {});
        live.show(RenderRequest { moving: true, ..request.clone() });
        until(&live, "a picture in motion", |shown, _| shown.samples >= 1.0);
        let moving = live.film().recv().expect("an answer");
        assert!(moving.is_err() || moving.is_ok_and(|(_, settings)| settings.path_reuse.is_none()));
        let number = live.show(request.clone());
        until(&live, "the whole picture", |shown, status| shown.request == number && status.resting);
        let (film, settings) = live.film().recv().expect("an answer").expect("a film");
        assert_eq!(settings.path_reuse, pays.then_some(true));
        let same = Settings {
            splitting: Some(1),
            light_samples: Some(1),
            emitter_edges: Some(false),
            path_reuse: Some(pays),
            ..settings
        };
        assert!(film == cpu().render(&scene, &same).expect("a film"), "another picture than that of render");
    }
}

/// A picture in motion has coarse shape grids, one at rest those of `render`.
fn a_picture_of_many_shapes_at_rest_equals_that_of_render(backend: Backend) {
    let balls: String = (0..64)
        .map(|k| format!("sphere 0.3 {{ at {} {} {} }}\n", 0.5 * f64::from(k % 4), 0.5 * f64::from(k / 16), k / 4 % 4))
        .collect();
    let text = format!(
        "pathmarch 1\ncamera {{ position 2 3 6; target 0.7 0.7 0.7 }}\nsky 1\nobject \"balls\" {{ union smooth=0.1 {{ {balls} }} }}"
    );
    let scene = Arc::new(parse(&text));
    let request = request(&scene, [96, 54], 4);
    let mut live = Live::new(backend, None, || {});
    let number = live.show(RenderRequest { moving: true, ..request.clone() });
    until(&live, "a picture in motion", |shown, status| shown.request == number && renders_on(backend, status));
    let number = live.show(request.clone());
    until(&live, "the whole picture", |shown, status| {
        shown.request == number && shown.samples == 4.0 && status.resting && renders_on(backend, status)
    });
    let (film, _) = live.film().recv().expect("an answer").expect("a film");
    let expected = Renderer::open(backend, None).expect("a backend").render(&scene, &request.settings).expect("a film");
    assert!(film == expected, "{backend:?}: the films differ");
}

fn an_automatic_exposure_is_that_of_the_film_at_rest(backend: Backend) {
    let scene = scene();
    let fixed = request(&scene, [96, 54], 12);
    let mut live = Live::new(backend, None, || {});
    for (reconstruct, serial) in [(fixed.reconstruct, 0), (None, 1)] {
        let request = RenderRequest { auto_exposure: true, reconstruct, ..fixed.clone() };
        let number = live.show(request.clone());
        let shown = until(&live, "the whole picture", |shown, status| {
            shown.request == number
                && shown.samples == 12.0
                && status.resting
                && renders_on(backend, status)
                && (serial == 0 || shown.serial > serial)
        });
        let (film, _) = live.film().recv().expect("an answer").expect("a film");
        let stops = suitable_stops(&film).expect("light");
        assert!(stops != 0.0 && shown.exposure_stops == stops, "{backend:?}: {} for {stops}", shown.exposure_stops);
        let display = Display { exposure_stops: stops, ..request.display };
        for (pixel, codes) in film.mean().pixels.iter().zip(shown.codes.chunks(4)) {
            let expected = display.encode_8bit(*pixel);
            assert!((0..3).all(|channel| expected[channel].abs_diff(codes[channel]) <= 1), "{codes:?} {expected:?}");
        }
    }
    // Without it, the same film is shown with the exposure of the request.
    let number = live.show(RenderRequest { reconstruct: None, ..fixed.clone() });
    let shown = until(&live, "the exposure of the request", |shown, _| shown.request == number);
    assert_eq!((shown.exposure_stops, shown.samples), (0.0, 12.0));
}

fn a_moving_picture_is_small_and_grows_when_it_rests(backend: Backend) {
    let scene = scene();
    let mut live = Live::new(backend, None, || {});
    let whole = request(&scene, [640, 360], 1);
    live.show(whole.clone());
    until(&live, "a picture", |shown, status| shown.samples >= 1.0 && status.resting && renders_on(backend, status));
    let mut camera = scene.cameras[0].clone();
    let mut last = 0;
    for step in 0..10 {
        camera.position[0] = 0.05 * step as f32;
        let moving = RenderRequest {
            settings: Settings { viewpoint: Some(camera.clone()), ..whole.settings.clone() },
            moving: true,
            frame_time: Duration::from_micros(100),
            ..whole.clone()
        };
        last = live.show(moving);
        let shown = until(&live, "a frame", |shown, _| shown.request == last);
        assert!(shown.size[0] < 640 && shown.samples >= 1.0, "{:?}", shown.size);
    }
    let resting =
        RenderRequest { settings: Settings { viewpoint: Some(camera), ..whole.settings.clone() }, ..whole.clone() };
    live.show(resting.clone());
    let shown = until(&live, "the whole picture", |shown, status| shown.request > last && status.resting);
    assert_eq!(shown.size, [640, 360]);
    let (film, _) = live.film().recv().expect("an answer").expect("a film");
    let expected = Renderer::open(backend, None).expect("a backend").render(&scene, &resting.settings);
    assert!(film == expected.expect("a film"), "{backend:?}: moving leaves traces");
}

fn lamps_keep_their_light_while_the_view_moves(backend: Backend) {
    let lamp = "material \"lamp\" { emit 0.9 }\nobject \"lamp\" material=\"lamp\" { sphere 0.5 { at 0 1.2 1 } }\nobject \"ball\"";
    let text = SCENE.replace("sky 0.6 0.8 1", "sky 0.02").replace("irradiance 2", "irradiance 0.1");
    let scene = Arc::new(parse(&text.replace("object \"ball\"", lamp)));
    let mut live = Live::new(backend, None, || {});
    let whole = request(&scene, [160, 90], 1);
    live.show(whole.clone());
    until(&live, "a picture", |shown, status| shown.samples >= 1.0 && status.resting && renders_on(backend, status));
    let still = Renderer::open(Backend::Cpu, None).expect("the CPU");
    let mut camera = scene.cameras[0].clone();
    for step in 0..12 {
        camera.position[0] = 0.05 * step as f32;
        let settings = Settings { viewpoint: Some(camera.clone()), ..whole.settings.clone() };
        let number = live.show(RenderRequest { settings: settings.clone(), moving: true, ..whole.clone() });
        let shown = until(&live, "a frame", |shown, _| shown.request == number);
        // Most of the light is that of the lamp, whatever the size of the picture.
        let linear = |code: u8| (f32::from(code) / 255.0).powf(2.2);
        let mean = shown.codes.chunks(4).map(|codes| linear(codes[0])).sum::<f32>() / (shown.codes.len() / 4) as f32;
        let still = still.render(&scene, &Settings { samples: 64, ..settings }).expect("a film").mean();
        let expected = still.pixels.iter().map(|pixel| linear(whole.display.encode_8bit(*pixel)[0])).sum::<f32>();
        let expected = expected / still.pixels.len() as f32;
        assert!((mean / expected - 1.0).abs() < 0.03, "{backend:?}, {step}: {mean} for {expected}");
    }
}

fn requests_faster_than_pictures_still_show_some(backend: Backend) {
    let scene = scene();
    let mut live = Live::new(backend, None, || {});
    let mut camera = scene.cameras[0].clone();
    let mut serials = std::collections::BTreeSet::new();
    let started = Instant::now();
    // Each picture takes longer than the pause between requests: if none were waited for, none would be published.
    while serials.len() < 5 {
        camera.position[0] += 0.001;
        let request = request(&scene, [1920, 1080], 1);
        live.show(RenderRequest {
            settings: Settings { viewpoint: Some(camera.clone()), ..request.settings },
            moving: true,
            frame_time: Duration::from_millis(40),
            ..request
        });
        std::thread::sleep(Duration::from_millis(2));
        serials.extend(live.picture().map(|shown| shown.serial));
        assert!(started.elapsed() < TIMEOUT, "{backend:?}: {} pictures", serials.len());
    }
}

fn a_changed_scene_is_shown(backend: Backend) {
    let mut live = Live::new(backend, None, || {});
    // Changes of parameters; then of structure, twice and back.
    let texts = [
        SCENE.to_owned(),
        SCENE.replace("0.8 0.1 0.1", "0.1 0.8 0.1"),
        SCENE.replace("sphere 1", "torus 1 0.4"),
        SCENE.to_owned(),
    ];
    for text in texts {
        let scene = Arc::new(parse(&text));
        let request = request(&scene, [64, 36], 4);
        let number = live.show(request.clone());
        until(&live, "the changed scene", |shown, status| {
            shown.request == number && status.resting && !status.compiling && renders_on(backend, status)
        });
        let (film, _) = live.film().recv().expect("an answer").expect("a film");
        let expected = Renderer::open(backend, None).expect("a backend").render(&scene, &request.settings);
        assert!(film == expected.expect("a film"), "{backend:?}: not the picture of\n{text}");
    }
}

fn a_lost_device_is_replaced() {
    let scene = scene();
    let mut live = Live::new(Backend::Gpu, None, || {});
    let request = request(&scene, [64, 36], 64);
    live.show(request.clone());
    until(&live, "a picture on the GPU", |shown, status| shown.samples >= 1.0 && status.backend != "CPU");
    live.lose_device();
    let changed = Arc::new(parse(&SCENE.replace("sphere 1", "sphere 0.7")));
    let number = live.show(RenderRequest { scene: changed.clone(), ..request.clone() });
    until(&live, "a picture on the CPU", |shown, status| {
        shown.request == number && shown.samples >= 1.0 && status.backend == "CPU" && status.notice.is_some()
    });
    until(&live, "the GPU to come back", |_, status| status.backend != "CPU" && status.resting);
    let (film, _) = live.film().recv().expect("an answer").expect("a film");
    let expected = Renderer::open(Backend::Gpu, None).expect("a backend").render(&changed, &request.settings);
    assert!(film == expected.expect("a film"));
}

fn the_cpu_renders_scenes_that_the_gpu_refuses() {
    let mut live = Live::new(Backend::Gpu, None, || {});
    // More shapes than a kernel may contain; shape grids are of unions.
    let balls: String = (0..2100).map(|k| format!("sphere 0.01 {{ at {} {} 0 }};", k % 50, k / 50)).collect();
    let many = Arc::new(parse(&format!("{SCENE}\nobject \"many\" {{ subtract {{ box 3 3 0.015; {balls} }} }}")));
    let number = live.show(request(&many, [32, 18], 1));
    until(&live, "many shapes", |shown, status| {
        shown.request == number && shown.samples >= 1.0 && status.backend == "CPU" && status.notice.is_some()
    });
    assert!(live.status().notice.is_some_and(|notice| notice.contains("2103 shapes")), "{:?}", live.status());
    // The GPU renders the next scene again.
    let number = live.show(request(&scene(), [32, 18], 1));
    until(&live, "few shapes", |shown, status| shown.request == number && status.resting && status.backend != "CPU");
    assert_eq!(live.status().notice, None);
}

fn an_invalid_request_is_reported_and_the_next_one_renders() {
    let scene = scene();
    let mut live = Live::new(Backend::Cpu, None, || {});
    assert!(live.film().recv().expect("an answer").is_err());
    let bad = request(&scene, [0, 0], 4);
    live.show(bad.clone());
    let started = Instant::now();
    while live.status().error.is_none() {
        assert!(started.elapsed() < TIMEOUT, "no error");
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(live.status().error.expect("an error").contains("0x0"));
    live.show(request(&scene, [32, 18], 2));
    until(&live, "a picture", |shown, status| shown.samples == 2.0 && status.error.is_none());
}

tests! {
    plain: [an_invalid_request_is_reported_and_the_next_one_renders, pixels_at_rest_share_light_where_that_pays],
    for_each_backend: [
        the_picture_equals_that_of_render_and_then_rests,
        a_picture_of_many_shapes_at_rest_equals_that_of_render,
        an_automatic_exposure_is_that_of_the_film_at_rest,
        a_moving_picture_is_small_and_grows_when_it_rests,
        lamps_keep_their_light_while_the_view_moves,
        requests_faster_than_pictures_still_show_some,
        a_changed_scene_is_shown,
    ],
    with_gpu: [a_lost_device_is_replaced, the_cpu_renders_scenes_that_the_gpu_refuses],
}
