//! Final renders in the background, while the window stays usable.
//!
//! The file equals that of `pathmarch render` for the same scene, settings and adapter: both use [`crate::picture`].

use crate::atomic_file::check_writable;
use crate::frames::{self, FrameRange};
use crate::picture::Rendered;
use pathmarch_render::aov::Layer;
use pathmarch_render::exposure::camera_stops;
use pathmarch_render::film::Film;
use pathmarch_render::image::ImageFormat;
use pathmarch_render::pathmarch_scene::{Animation, Moment, Scene};
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Backend, RenderError, Renderer, Settings, Shutter};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

/// Input of a background render.
#[derive(Clone, Debug)]
pub struct RenderRequest {
    /// The scene.
    pub scene: Arc<Scene>,
    /// Size, samples and limits.
    pub settings: Settings,
    /// Tone mapping and exposure of PNG and JPEG.
    pub display: Display,
    /// Additional layers; OpenEXR only.
    pub layers: Vec<Layer>,
    /// Output file; its extension selects the format.
    pub output: PathBuf,
    /// Render backend.
    pub backend: Backend,
    /// Part of the GPU adapter's name.
    pub adapter: Option<String>,
    /// Frame range of an animation; `None` renders one picture. `#` in the file name stands for the digits of the frame
    /// number.
    pub frames: Option<FrameSequence>,
    /// Read no file outside the folder of the scene.
    pub confined: bool,
}

/// Frames to render, one file each.
#[derive(Clone, Copy, Debug)]
pub struct FrameSequence {
    /// Range of frames.
    pub frames: FrameRange,
    /// Skip frames whose file exists and is whole.
    pub skip_existing: bool,
}

impl FrameSequence {
    /// File of the first frame.
    pub fn file(&self, pattern: &Path) -> PathBuf {
        frames::file(pattern, self.frames.numbers().next().unwrap_or(0))
    }
}

/// Progress of a [`BackgroundRender`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Samples per pixel done, including the fraction of the current one.
    pub samples: f64,
    /// Samples per pixel in total, over all frames.
    pub of: f64,
    /// Time since the first sample began, seconds.
    pub seconds: f64,
    /// Estimated time left, seconds; `None` before the first sample.
    pub remaining: Option<f64>,
    /// All samples are done; layers and file are being written.
    pub writing: bool,
}

const CONTINUE: u8 = 0;
const STOP_AND_KEEP: u8 = 1;
const CANCEL: u8 = 2;

#[derive(Default)]
struct State {
    samples: f64,
    started: Option<Instant>,
    writing: bool,
    outcome: Option<Result<String, String>>,
}

#[derive(Default)]
struct Shared {
    command: AtomicU8,
    state: Mutex<State>,
}

impl Shared {
    /// Locks the state, even after a panic of the other thread: every value is complete at any time.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn command(&self) -> u8 {
        self.command.load(Ordering::SeqCst)
    }
}

/// A render in progress. Dropping it cancels it; a file that is being written is finished.
pub struct BackgroundRender {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    of: f64,
    output: PathBuf,
}

impl BackgroundRender {
    /// Starts a render. Calls `wake` on another thread on progress and at the end.
    pub fn start(task: RenderRequest, wake: impl Fn() + Send + 'static) -> Self {
        let shared = Arc::<Shared>::default();
        let count = task.frames.as_ref().map_or(1, |sequence| sequence.frames.numbers().count());
        let (of, output) = (f64::from(task.settings.samples) * count as f64, task.output.clone());
        let thread_shared = shared.clone();
        let thread = std::thread::Builder::new().name("render".to_owned()).spawn(move || {
            let outcome = catch_unwind(AssertUnwindSafe(|| work(&task, &thread_shared, &wake))).unwrap_or_else(|_| {
                Err(format!("{}: not written: the renderer panicked, which is a bug", task.output.display()))
            });
            thread_shared.state().outcome = Some(outcome);
            wake();
        });
        let thread = match thread {
            Ok(thread) => Some(thread),
            Err(error) => {
                shared.state().outcome = Some(Err(format!("{}: not written: {error}", output.display())));
                None
            }
        };
        Self { shared, thread, of, output }
    }

    /// Output file.
    pub fn output(&self) -> &Path {
        &self.output
    }

    /// Current progress.
    pub fn progress(&self) -> Progress {
        let state = self.shared.state();
        let seconds = state.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        let left = self.of - state.samples;
        // The first samples include warm-up; without samples there is no estimate.
        let remaining = (state.samples > 0.0 && seconds > 0.0).then(|| (left * seconds / state.samples).max(0.0));
        Progress { samples: state.samples, of: self.of, seconds, remaining, writing: state.writing }
    }

    /// Cancels the render without a file, unless it is being written already.
    pub fn cancel(&self) {
        self.shared.command.store(CANCEL, Ordering::SeqCst);
    }

    /// Stops the render and writes what is done, at least one sample.
    pub fn stop_and_keep(&self) {
        // A cancelled render stays cancelled.
        let _ = self.shared.command.compare_exchange(CONTINUE, STOP_AND_KEEP, Ordering::SeqCst, Ordering::SeqCst);
    }

    /// Result in one sentence, once the render has ended.
    pub fn finished(&self) -> Option<Result<String, String>> {
        self.shared.state().outcome.clone()
    }
}

impl Drop for BackgroundRender {
    fn drop(&mut self) {
        self.cancel();
        let writing = {
            let state = self.shared.state();
            state.writing && state.outcome.is_none()
        };
        if writing && let Some(thread) = self.thread.take() {
            // Nobody is left to report the result to.
            let _ = thread.join();
        }
    }
}

/// Checks the output before rendering, rather than after an hour.
///
/// # Errors
/// Fails with a message: unknown format, layers in a format without them, or a file that cannot be written.
pub fn check_output(output: &Path, layers: &[Layer]) -> Result<(), String> {
    let format = ImageFormat::from_path(output).map_err(|error| error.to_string())?;
    if !layers.is_empty() && format != ImageFormat::Exr {
        return Err(format!(
            "{}: only OpenEXR can store layers; use the extension .exr, or turn layers off",
            output.display()
        ));
    }
    check_writable(output).map_err(|error| error.to_string())
}

/// Writes an existing film as a [`BackgroundRender`] would; returns a sentence.
///
/// # Errors
/// Fails with a message.
pub fn save_film(rendered: &Rendered, output: &Path, display: &Display, layers: &[Layer]) -> Result<String, String> {
    check_output(output, layers)?;
    rendered.write(output, display, layers)?;
    Ok(format!("Wrote {}: {}", output.display(), samples_of(rendered.film, rendered.settings)))
}

/// Number of samples, such as "16 of 64 samples", with a warning about non-finite ones.
fn samples_of(film: &Film, settings: &Settings) -> String {
    let mut text = if film.samples == settings.samples {
        format!("{} samples", film.samples)
    } else {
        format!("{} of {} samples", film.samples, settings.samples)
    };
    if film.non_finite() > 0 {
        text += &format!("; {} non-finite ones were discarded", film.non_finite());
    }
    text
}

/// Body of the thread.
fn work(task: &RenderRequest, shared: &Shared, wake: &impl Fn()) -> Result<String, String> {
    let renderer = Renderer::open(task.backend, task.adapter.as_deref()).map_err(|error| error.to_string())?;
    let animation = Animation::new(task.scene.source_name.as_str(), task.scene.source_text.as_str());
    let animation = if task.confined { animation.confined() } else { animation };
    let animation = Arc::new(Mutex::new(animation));
    let mut worker = Worker { task, shared, wake, renderer, animation, notice: None };
    shared.state().started = Some(Instant::now());
    let sentence = match &task.frames {
        None => worker.still()?,
        Some(sequence) => worker.frames(sequence)?,
    };
    Ok(sentence + &worker.notice.map(|notice| format!("; {notice}; rendered on the CPU")).unwrap_or_default())
}

/// Renders pictures one after the other.
struct Worker<'a, W> {
    task: &'a RenderRequest,
    shared: &'a Shared,
    wake: &'a W,
    renderer: Renderer,
    animation: Arc<Mutex<Animation>>,
    /// Reason why the CPU rendered the last picture.
    notice: Option<String>,
}

impl<W: Fn()> Worker<'_, W> {
    fn still(&mut self) -> Result<String, String> {
        let (task, started) = (self.task, Instant::now());
        let written = self.picture(&task.scene, &task.display, &task.output, 0.0, true)?;
        Ok(match written {
            Some(sentence) => format!("{sentence} in {:.1} s", started.elapsed().as_secs_f64()),
            None => format!("Cancelled: {} was not written", task.output.display()),
        })
    }

    fn frames(&mut self, sequence: &FrameSequence) -> Result<String, String> {
        let (task, started) = (self.task, Instant::now());
        let fps = task.scene.render.fps;
        let (mut wrote, mut skipped) = (0, 0);
        let first_stops = self.stops_of_frames()?;
        for (index, frame) in sequence.frames.numbers().enumerate() {
            if self.shared.command() != CONTINUE {
                break;
            }
            let output = frames::file(&task.output, frame);
            if sequence.skip_existing && output.exists() && frames::is_whole(&output) {
                skipped += 1;
                continue;
            }
            let in_frame = |error: String| format!("frame {frame}: {error}; frames written before it are kept");
            let scene = self.animation.lock().unwrap_or_else(PoisonError::into_inner).at(Moment::of_frame(frame, fps));
            let scene = scene.map_err(|error| in_frame(error.to_string()))?;
            let camera = task.settings.camera_of(&scene);
            let exposure_stops = if camera.auto_exposure { first_stops } else { camera.exposure };
            let display = Display { exposure_stops, ..task.display };
            let before = f64::from(task.settings.samples) * index as f64;
            let written = self.picture(&scene, &display, &output, before, false).map_err(in_frame)?;
            wrote += u32::from(written.is_some());
        }
        let files = if wrote == 1 { "1 frame".to_owned() } else { format!("{wrote} frames") };
        let begun = if self.shared.command() == CONTINUE { "Wrote" } else { "Stopped; wrote" };
        let there = if skipped > 0 { format!(", {skipped} existed already") } else { String::new() };
        let seconds = started.elapsed().as_secs_f64();
        Ok(format!("{begun} {files} to {} in {seconds:.1} s{there}", task.output.display()))
    }

    /// Exposure of all frames if it follows the picture: that of the first moment.
    fn stops_of_frames(&self) -> Result<f32, String> {
        let settings = &self.task.settings;
        if !settings.camera_of(&self.task.scene).auto_exposure {
            return Ok(0.0);
        }
        let scene = self.animation.lock().unwrap_or_else(PoisonError::into_inner).at(Moment::default());
        let scene = scene.map_err(|error| error.to_string())?;
        self.renderer.meter(&scene, settings).map_err(|error| error.to_string())
    }

    /// Renders and writes one picture; returns a sentence, or `None` if it was cancelled. `before`: samples of the
    /// previous pictures. A picture with fewer samples is written only if `may_be_partial`.
    fn picture(
        &mut self,
        scene: &Scene,
        display: &Display,
        output: &Path,
        before: f64,
        may_be_partial: bool,
    ) -> Result<Option<String>, String> {
        let (task, shared) = (self.task, self.shared);
        check_output(output, &task.layers)?;
        let fail = |error: RenderError| error.to_string();
        let shutter = Shutter::of(scene);
        let mut job = self.renderer.start_motion_blur(&self.animation, scene, &task.settings, shutter).map_err(fail)?;
        let stop = |done: f64| match shared.command() {
            CONTINUE => false,
            STOP_AND_KEEP if may_be_partial => done >= 1.0,
            _ => true,
        };
        let progress = |done| {
            shared.state().samples = before + done;
            (self.wake)();
        };
        job.run(stop, progress).map_err(fail)?;
        self.notice.clone_from(&job.backend().notice);
        let is_cancelled = || shared.command() == CANCEL || !may_be_partial && shared.command() != CONTINUE;
        if is_cancelled() {
            return Ok(None);
        }
        let film = job.film().map_err(fail)?;
        {
            // From here on a drop waits for the file; before, it cancels.
            let mut state = shared.state();
            if is_cancelled() {
                return Ok(None);
            }
            state.writing = true;
            state.samples = before + f64::from(film.samples);
        }
        (self.wake)();
        let camera = task.settings.camera_of(scene);
        let follows = task.settings.mode.has_auto_exposure(camera) && may_be_partial;
        let exposure_stops = if follows { camera_stops(camera, Some(&film)) } else { display.exposure_stops };
        let display = &Display { exposure_stops, ..*display };
        let rendered =
            Rendered { scene, settings: &task.settings, film: &film, backend: job.backend(), denoised: None };
        let sentence = save_film(&rendered, output, display, &task.layers);
        shared.state().writing = false;
        sentence.map(Some)
    }
}

#[cfg(test)]
mod tests;
