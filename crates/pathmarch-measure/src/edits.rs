//! `pathmarch-measure edits`: time from a changed number to the picture of the changed scene, as in the window.
//!
//! **Method.** The first number of the last shape is moved to and fro, as by a slider; a scene in motion goes on by a frame
//! instead. *Document* is the time until the text is changed and read, *first sample* the time from there to the first picture
//! of a live renderer, whose size that renderer chooses for a picture that moves. *Other view* is the time to the first picture
//! after a movement of the camera instead, for the same number of pixels. What an edit takes beyond that is what the edit
//! costs: *edit* is document and first sample without other view. All take turns; the report has the medians.

use crate::bench;
use crate::measure::median;
use pathmarch_cli::{BackendArgument, DONE, Failure, outln, value_parsers};
use pathmarch_render::live::{Live, RenderRequest};
use pathmarch_render::pathmarch_scene::Moment;
use pathmarch_render::pathmarch_scene::document::{Document, Item, Path as NodePath, Value};
use pathmarch_render::reconstruct::ReconstructOptions;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, Settings};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Longest wait for a picture.
const LIMIT: Duration = Duration::from_secs(60);

#[derive(clap::Args)]
pub struct Arguments {
    /// Scenes: scene files, or examples and generated scenes by name
    #[arg(default_values = ["union-1000", "lights-1000"])]
    scenes: Vec<PathBuf>,
    /// Number of edits of each scene
    #[arg(long, value_name = "N", default_value_t = 21, value_parser = value_parsers::whole((1, 10_000)), allow_hyphen_values = true)]
    edits: u32,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: [u32; 2],
    /// Render backend
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendArgument,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    outln!(
        "{:20} {:>8} {:>12} {:>16} {:>14} {:>8} {:>12}",
        "scene",
        "shapes",
        "document ms",
        "first sample ms",
        "other view ms",
        "edit ms",
        "picture"
    );
    for scene in &arguments.scenes {
        let name = scene.to_string_lossy().into_owned();
        let text = match bench::built_in(&name) {
            Some(text) => text,
            None => std::fs::read_to_string(scene).map_err(|error| Failure::Usage(format!("{name}: {error}")))?,
        };
        measure(arguments, &name, Document::new(name.clone(), text))?;
    }
    Ok(DONE)
}

/// Path, key and value of the first number of the last shape.
fn number_of_last_shape(document: &Document) -> Option<(NodePath, String, f32)> {
    fn shapes<'a>(items: &'a [Item], found: &mut Vec<&'a Item>) {
        for item in items {
            if item.children.is_empty() {
                found.push(item);
            }
            shapes(&item.children, found);
        }
    }
    let mut items = Vec::new();
    shapes(document.outline(), &mut items);
    items.iter().rev().filter(|item| item.path.indexes().len() > 1).find_map(|item| {
        document.controls(&item.path).into_iter().find_map(|control| match control.value {
            Value::Number(value) if value > 0.0 && control.given => {
                Some((item.path.clone(), control.key.into_owned(), value))
            }
            _ => None,
        })
    })
}

fn measure(arguments: &Arguments, name: &str, mut document: Document) -> Result<(), Failure> {
    let scene = document.scene().map_err(Failure::other)?.clone();
    let number = number_of_last_shape(&document);
    if number.is_none() && !scene.animated {
        return Err(Failure::Usage(format!("{name}: no shape with a number, and nothing moves")));
    }
    let fps = scene.render.fps;
    let backend = Backend::from(arguments.backend);
    let (sender, pictures) = channel();
    let mut live = Live::new(backend, None, move || {
        // The receiver outlives the renderer.
        let _ = sender.send(());
    });
    let mut request = RenderRequest {
        settings: Settings { size: arguments.size, ..Settings::of(&scene) },
        scene,
        display: Display::default(),
        auto_exposure: false,
        moving: true,
        frame_time: Duration::from_millis(33),
        reconstruct: Some(ReconstructOptions::default()),
    };
    show(&mut live, &request, &pictures)?;
    let shapes = request.scene.field.leaves().len();
    let mut times: [Vec<f64>; 4] = Default::default();
    let mut size = [0; 2];
    for edit in 0..arguments.edits {
        let factor = if edit % 2 == 0 { 0.98 } else { 1.0 };
        let started = Instant::now();
        match &number {
            Some((path, key, value)) if !request.scene.animated => {
                document.set(path, key, Value::Number(value * factor), Some(1)).map_err(Failure::other)?;
            }
            _ => document.set_moment(Moment::of_frame(edit + 1, fps)),
        }
        request.scene = document.scene().map_err(Failure::other)?.clone();
        let reading = milliseconds(started);
        let started = Instant::now();
        size = show(&mut live, &request, &pictures)?;
        let rendering = milliseconds(started);
        let mut camera = request.settings.camera_of(&request.scene).clone();
        camera.position[0] += 1e-3;
        request.settings.viewpoint = Some(camera);
        let started = Instant::now();
        let of_view = show(&mut live, &request, &pictures)?;
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        let viewing = milliseconds(started) * pixels(size) / pixels(of_view);
        for (times, time) in times.iter_mut().zip([reading, rendering, viewing, reading + rendering - viewing]) {
            times.push(time);
        }
    }
    let [reading, rendering, viewing, edit] = times.map(|times| median(&times));
    let picture = format!("{}x{}", size[0], size[1]);
    outln!("{name:20} {shapes:>8} {reading:>12.1} {rendering:>16.1} {viewing:>14.1} {edit:>8.1} {picture:>12}");
    Ok(())
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1000.0
}

/// Shows a request, waits for its first picture, and returns its size.
fn show(live: &mut Live, request: &RenderRequest, pictures: &Receiver<()>) -> Result<[u32; 2], Failure> {
    let number = live.show(request.clone());
    let end = Instant::now() + LIMIT;
    loop {
        if let Some(picture) = live.picture().filter(|picture| picture.request == number) {
            return Ok(picture.size);
        }
        if let Some(error) = live.status().error {
            return Err(Failure::Usage(error));
        }
        pictures
            .recv_timeout(end.saturating_duration_since(Instant::now()))
            .map_err(|_| Failure::Usage("no picture after a minute".to_owned()))?;
    }
}
