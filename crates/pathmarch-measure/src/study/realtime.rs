//! Frames a second of the live picture, with the camera in motion, against the thesis's criterion of real time.

use super::Study;
use super::table::Table;
use super::tables::BOUNCES;
use pathmarch_cli::Failure;
use pathmarch_render::pathmarch_scene::{Camera, Scene};
use pathmarch_render::reconstruct::{ReconstructOptions, Sequence};
use pathmarch_render::{Renderer, Settings};
use std::sync::Arc;

/// Frames a second that the thesis calls real time (section 5.1).
const REAL_TIME: f64 = 24.0;
/// Degrees by which the camera turns from frame to frame.
const TURN: f32 = 0.5;

/// Median seconds of a moving frame: tracing, and reconstruction.
fn frame_seconds(study: &Study, renderer: &Renderer, scene: &Arc<Scene>, size: [u32; 2]) -> Result<[f64; 2], Failure> {
    let mut sequence = Sequence::new(renderer, ReconstructOptions::default());
    let mut times: [Vec<f64>; 2] = Default::default();
    for number in 0..=2 * study.plan.rounds {
        study.interrupt.check()?;
        let settings = Settings::of(scene);
        let viewpoint = Some(turned(settings.camera_of(scene), TURN * number as f32));
        let settings = Settings { size, bounces: BOUNCES, samples: 1, seed: number, viewpoint, ..settings };
        let frame = sequence.render(scene, &settings).map_err(Failure::other)?;
        if number > 0 {
            times[0].push(frame.trace_seconds);
            times[1].push(frame.reconstruct_seconds);
        }
    }
    Ok(times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    }))
}

/// Camera turned by degrees about the vertical through its target.
fn turned(camera: &Camera, degrees: f32) -> Camera {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let [x, y, z]: [f32; 3] = std::array::from_fn(|k| camera.position[k] - camera.target[k]);
    let offset = [x * cosine + z * sine, y, z * cosine - x * sine];
    Camera { position: std::array::from_fn(|k| camera.target[k] + offset[k]), ..camera.clone() }
}

/// Largest size of 16:9 that was seen to reach real time with reconstruction; `None` below 64 pixels of width.
fn real_time_size(
    study: &Study,
    renderer: &Renderer,
    scene: &Arc<Scene>,
    (full, seconds): ([u32; 2], f64),
) -> Result<Option<[u32; 2]>, Failure> {
    if seconds * REAL_TIME <= 1.0 {
        return Ok(Some(full));
    }
    let (mut width, mut seconds) = (f64::from(full[0]), seconds);
    for _ in 0..6 {
        // Costs are nearly in proportion to pixels; a little less is asked for than would just suffice.
        width *= (0.97 / (seconds * REAL_TIME)).sqrt();
        let size = [(width / 16.0).floor() as u32 * 16, (width / 16.0).floor() as u32 * 9];
        if size[0] < 64 {
            return Ok(None);
        }
        let [trace, reconstruction] = frame_seconds(study, renderer, scene, size)?;
        seconds = trace + reconstruction;
        if seconds * REAL_TIME <= 1.0 {
            return Ok(Some(size));
        }
        width = f64::from(size[0]);
    }
    Ok(None)
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let mut heads = vec!["scene".to_owned(), "published, fps".to_owned()];
    for backend in study.backends() {
        heads.extend([
            format!("{backend}: fps, samples alone"),
            format!("{backend}: fps, reconstructed"),
            format!("{backend}: {REAL_TIME} fps at"),
        ]);
    }
    let mut table = Table::new(heads);
    let rows: Vec<_> = study.rows().filter(|row| row.camera == "main").collect();
    let mut scenes: Vec<(&str, Option<f64>)> =
        rows.iter().map(|row| (row.scene, Some(1000.0 / row.published))).collect();
    if !study.plan.few_rows {
        scenes.extend([("three-spheres", None), ("mandelbulb-landscape", None), ("inside-mandelbox", None)]);
    }
    for (name, published) in scenes {
        study.log(&format!("realtime: {name}"));
        let scene = Arc::new(super::example(name)?);
        let mut cells = vec![name.to_owned(), published.map_or("-".to_owned(), |fps| format!("{fps:.0}"))];
        for renderer in &study.renderers {
            let full = study.plan.size;
            let [trace, reconstruction] = frame_seconds(study, renderer, &scene, full)?;
            let size = real_time_size(study, renderer, &scene, (full, trace + reconstruction))?;
            cells.extend([
                format!("{:.1}", 1.0 / trace),
                format!("{:.1}", 1.0 / (trace + reconstruction)),
                size.map_or("-".to_owned(), |[width, height]| format!("{width}x{height}")),
            ]);
        }
        table.push(cells);
    }
    table.save(study.directory, "realtime")?;
    let [width, height] = study.plan.size;
    let conditions = study.conditions(&format!(
        "one sample a frame at {width}x{height}, `bounces {BOUNCES}`, the camera turning by {TURN}° a frame; median of {} frames",
        2 * study.plan.rounds
    ));
    Ok(format!(
        "## Real time\n\nThe thesis calls {REAL_TIME} frames a second real time (section 5.1); its frames are single samples, and \
         noise shows while the camera moves. *Reconstructed* frames are clean in motion ([reconstruction.md]\
         (../reconstruction.md)). The last column of each backend is a size at which a reconstructed frame takes at most \
         41.6 ms; the window shows it at up to twice that size, and takes the CPU where the only \
         adapter is software.\n\n{}\n{conditions}",
        table.markdown()
    ))
}
