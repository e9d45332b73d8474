//! Latency of live pictures, and processor time at rest.
//!
//! `cargo bench -p pathmarch-render --bench live -- [--size WIDTHxHEIGHT] [--gpu-only] [SCENE…]` prints medians for each scene
//! and backend: the time from the request to the first picture and to the full-size one (with a kernel that is not compiled
//! yet), from a change of a parameter to its picture, from a change of structure to its picture and to that of its kernel, the
//! size and time of pictures while the camera moves, full-size pictures a second while it moves, and the processor time in a
//! second of rest.

use pathmarch_render::live::{Live, LiveImage, RenderRequest, Status};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Settings};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

const REPEATS: usize = 5;
const FRAME_TIME: Duration = Duration::from_millis(33);
/// Frame time at which the full size is always chosen.
const UNLIMITED_TIME: Duration = Duration::from_secs(1000);

fn request(scene: &Arc<Scene>, samples: u32, size: [u32; 2]) -> RenderRequest {
    RenderRequest {
        scene: scene.clone(),
        settings: Settings { size, samples, ..Settings::of(scene) },
        display: Display::default(),
        auto_exposure: false,
        moving: false,
        frame_time: FRAME_TIME,
        reconstruct: Some(Default::default()),
    }
}

/// Waits for a picture that fulfils a condition; returns it and the time from `since`.
fn until(live: &Live, since: Instant, condition: impl Fn(&LiveImage, &Status) -> bool) -> (Arc<LiveImage>, Duration) {
    loop {
        if let Some(shown) = live.picture().filter(|shown| condition(shown, &live.status())) {
            return (shown.clone(), shown.at.saturating_duration_since(since));
        }
        assert!(since.elapsed() < Duration::from_secs(300), "no picture: {:?}", live.status());
        std::thread::sleep(Duration::from_micros(300));
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Processor time of this process so far, seconds; `None` if the system does not report it.
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    // User and system time, in hundredths of a second on every current Linux.
    Some((fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?) / 100.0)
}

/// Scene with another parameter, and scene with another structure.
fn variants(text: &str, turn: usize) -> (String, String) {
    let ball = format!("\nobject \"bench {turn}\" {{ sphere 0.1 {{ at 0 0.5 0 }} }}\n");
    let box_ = format!("\nobject \"bench {turn}\" {{ link 0.1 0.1 0.0{} {{ at 0 0.5 0 }} }}\n", turn % 9 + 1);
    let number = format!("{text}{}", ball.replace("0.1", &format!("0.{:02}", 10 + turn)));
    (number, format!("{text}{box_}"))
}

struct Row {
    first: Vec<f64>,
    whole: Vec<f64>,
    number: Vec<f64>,
    structure: Vec<f64>,
    compiled: Vec<f64>,
    frame: Vec<f64>,
    size: [u32; 2],
    /// Time of each full-size picture, milliseconds.
    full: Vec<f64>,
    rest: Option<f64>,
}

fn measure(path: &Path, backend: Backend, full_size: [u32; 2]) -> Row {
    let request = |scene: &Arc<Scene>, samples: u32| request(scene, samples, full_size);
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).expect("a scene file");
    let parse = |text: &str| Arc::new(Scene::parse(&name, text).expect("a scene"));
    let (mut first, mut whole, mut number, mut structure, mut compiled, mut frame) =
        (vec![], vec![], vec![], vec![], vec![], vec![]);
    let (mut size, mut full, mut rest) = ([0; 2], vec![], None);
    let is_gpu = backend == Backend::Gpu;
    for turn in 0..REPEATS {
        let milliseconds = |time: Duration| time.as_secs_f64() * 1e3;
        let started = Instant::now();
        let mut live = Live::new(backend, None, || {});
        let scene = parse(&format!("{text}{}", "\nobject \"bench\" { sphere 0.1 { at 0 0.5 0 } }\n"));
        let asked = live.show(request(&scene, 1));
        let (_, time) = until(&live, started, |shown, _| shown.request == asked && shown.samples >= 1.0);
        first.push(milliseconds(time));
        let ready = |status: &Status| !is_gpu || status.backend != "CPU";
        let done = |shown: &LiveImage, status: &Status| shown.size == full_size && status.resting && ready(status);
        let (_, time) = until(&live, started, done);
        whole.push(milliseconds(time));
        let (changed, other) = variants(&text, turn);
        let since = Instant::now();
        let scene = parse(&changed);
        let asked = live.show(RenderRequest { moving: true, ..request(&scene, 1) });
        let (_, time) = until(&live, since, |shown, _| shown.request == asked);
        number.push(milliseconds(time));
        let since = Instant::now();
        let scene = parse(&other);
        let asked = live.show(RenderRequest { moving: true, ..request(&scene, 1) });
        let (_, time) = until(&live, since, |shown, _| shown.request == asked);
        structure.push(milliseconds(time));
        let (_, time) = until(&live, since, |shown, status| {
            shown.request == asked && ready(status) && !status.compiling && shown.samples >= 1.0
        });
        compiled.push(milliseconds(time));
        let mut camera = scene.cameras[0].clone();
        for _ in 0..12 {
            camera.position[0] += 0.01;
            let still = request(&scene, 1);
            let settings = Settings { viewpoint: Some(camera.clone()), ..still.settings };
            let since = Instant::now();
            let asked = live.show(RenderRequest { settings, moving: true, ..still });
            let (shown, time) = until(&live, since, |shown, _| shown.request == asked);
            frame.push(milliseconds(time));
            size = shown.size;
        }
        for _ in 0..12 {
            camera.position[0] += 0.01;
            let still = request(&scene, 1);
            let settings = Settings { viewpoint: Some(camera.clone()), ..still.settings };
            let since = Instant::now();
            let asked = live.show(RenderRequest { settings, moving: true, frame_time: UNLIMITED_TIME, ..still });
            let (_, time) = until(&live, since, |shown, _| shown.request == asked);
            full.push(milliseconds(time));
        }
        live.show(request(&scene, 1));
        until(&live, Instant::now(), done);
        if let Some(before) = processor_seconds() {
            std::thread::sleep(Duration::from_secs(1));
            rest = processor_seconds().map(|after| after - before);
        }
    }
    Row { first, whole, number, structure, compiled, frame, size, full, rest }
}

fn main() {
    let (mut given, mut full_size, mut backends) = (Vec::new(), [1280, 720], vec![Backend::Cpu, Backend::Gpu]);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--gpu-only" => backends = vec![Backend::Gpu],
            "--size" => {
                let text = arguments.next().unwrap_or_default();
                let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
                full_size = sides.expect("--size WIDTHxHEIGHT, such as 1280x720");
            }
            // Cargo adds `--bench`.
            flag if flag.starts_with("--") => {}
            scene => given.push(PathBuf::from(scene)),
        }
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let usual = ["thesis/diffuse-sphere.kdl", "cornell.kdl", "glass-still-life.kdl"];
    let scenes = if given.is_empty() { usual.iter().map(|scene| root.join(scene)).collect() } else { given };
    println!("{} x {}, medians of {REPEATS}, milliseconds", full_size[0], full_size[1]);
    println!(
        "{:22} {:8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>8} {:>10} {:>9} {:>9}",
        "scene", "backend", "first", "whole", "number", "structure", "compiled", "moving", "size", "whole/s", "rest"
    );
    for path in scenes {
        for &backend in &backends {
            if backend == Backend::Gpu && pathmarch_render::Renderer::open(backend, None).is_err() {
                continue;
            }
            let row = measure(&path, backend, full_size);
            println!(
                "{:22} {:8} {:8.1} {:8.1} {:8.1} {:9.1} {:9.1} {:8.1} {:>10} {:9.1} {:>9}",
                path.file_stem().unwrap_or_default().to_string_lossy(),
                format!("{backend:?}"),
                median(row.first),
                median(row.whole),
                median(row.number),
                median(row.structure),
                median(row.compiled),
                median(row.frame),
                format!("{}x{}", row.size[0], row.size[1]),
                1e3 / median(row.full),
                row.rest.map_or("unknown".to_owned(), |seconds| format!("{:.0} ms/s", seconds * 1e3)),
            );
        }
    }
}
