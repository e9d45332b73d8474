//! Frames of an animation, one after the other; a frame is written once it is complete.

use super::arguments::Arguments;
use super::output::Output;
use super::progress::Progress;
use super::still::Task;
use crate::commands::merge::is_film;
use crate::frames::{self, FrameRange};
use pathmarch_cli::{DONE, Failure, INTERRUPTED, note, print_report};
use pathmarch_render::parts::FilmFile;
use pathmarch_render::pathmarch_scene::{Animation, Moment};
use pathmarch_render::{Renderer, image};
use serde_json::json;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What frames are rendered with.
pub(super) struct Frames<'a> {
    pub(super) arguments: &'a Arguments,
    pub(super) frames: FrameRange,
    pub(super) fps: f32,
    pub(super) pattern: &'a Path,
    pub(super) animation: Arc<Mutex<Animation>>,
    pub(super) renderer: &'a Renderer,
    pub(super) interrupted: &'a AtomicBool,
    pub(super) progress: &'a Progress,
}

/// True if the file of a frame is whole: it can be read to its end.
fn is_whole(file: &Path) -> bool {
    if is_film(file) {
        FilmFile::open(file).and_then(|mut film| film.part()).is_ok()
    } else {
        image::load(file).is_ok()
    }
}

impl Frames<'_> {
    /// Frames that are not there, or are torn; reports the latter.
    fn left(&self) -> Vec<u32> {
        let is_left = |frame: &u32| {
            let file = frames::file(self.pattern, *frame);
            if !self.arguments.skip_existing || !file.exists() {
                return true;
            }
            let is_whole = is_whole(&file);
            if !is_whole {
                note!("note: {} is damaged; rendering it again", file.display());
            }
            !is_whole
        };
        self.frames.numbers().filter(is_left).collect()
    }

    pub(super) fn run(&self) -> Result<u8, Failure> {
        let count = self.frames.numbers().count();
        let left = self.left();
        let skipped = count - left.len();
        if left.is_empty() {
            note!("all {count} frames exist already");
            return Ok(DONE);
        }
        let began = Instant::now();
        let (mut non_finite, mut warned) = (0, Vec::new());
        for (index, &frame) in left.iter().enumerate() {
            let rendered =
                self.frame((index, left.len()), frame, &mut warned).map_err(|failure| in_frame(frame, failure))?;
            // An incomplete frame is not written: its file would count as done.
            let Some(rejected) = rendered else {
                self.progress.finish();
                let (wrote, more) = (frame_count(index), left.len() - index);
                note!("interrupted: wrote {wrote}, {more} left; continue with --skip-existing --resume");
                return Ok(INTERRUPTED);
            };
            non_finite += rejected;
        }
        self.progress.finish();
        if non_finite > 0 {
            note!("warning: {non_finite} non-finite samples were discarded");
        }
        let there = if skipped > 0 { format!(", {skipped} existed already") } else { String::new() };
        let (wrote, seconds) = (frame_count(left.len()), began.elapsed().as_secs_f64());
        note!("wrote {wrote} to {} in {seconds:.1} s{there}", self.pattern.display());
        Ok(DONE)
    }

    /// Renders a frame and returns its number of rejected samples; `None` if it was interrupted.
    fn frame(
        &self,
        (index, count): (usize, usize),
        frame: u32,
        warned: &mut Vec<String>,
    ) -> Result<Option<u64>, Failure> {
        let moment = Moment::of_frame(frame, self.fps);
        let scene = self.animation.lock().unwrap_or_else(PoisonError::into_inner).at(moment)?;
        for warning in scene.warnings.iter().filter(|warning| !warned.contains(&warning.message)) {
            self.progress.suspend(|| print_report(warning));
        }
        warned.extend(scene.warnings.iter().map(|warning| warning.message.clone()));
        let task = Task {
            arguments: self.arguments,
            renderer: self.renderer,
            animation: &self.animation,
            scene: &scene,
            settings: self.arguments.settings(&scene)?,
            shutter: self.arguments.shutter(&scene, self.fps),
            output: &Output::of(&frames::file(self.pattern, frame))?,
            interrupted: self.interrupted,
            progress: self.progress,
            place: (index, count, Some(frame)),
            says_settings: index == 0,
        };
        let outcome = task.run()?;
        if outcome.interrupted || self.interrupted.load(Ordering::SeqCst) && outcome.film.samples < outcome.of {
            return Ok(None);
        }
        let (output, samples) = (task.output.name(), outcome.film.samples);
        self.progress.event("frame", [("frame", json!(frame)), ("output", json!(output)), ("samples", json!(samples))]);
        Ok(Some(outcome.film.non_finite()))
    }
}

fn frame_count(frames: usize) -> String {
    if frames == 1 { "1 frame".to_owned() } else { format!("{frames} frames") }
}

/// Adds the frame number to a failure.
fn in_frame(frame: u32, failure: Failure) -> Failure {
    match failure {
        Failure::Scene(error) => {
            note!("frame {frame} cannot be rendered; frames written before it are kept");
            Failure::Scene(error)
        }
        Failure::Interrupted => Failure::Interrupted,
        Failure::Usage(message) => Failure::Usage(format!("frame {frame}: {message}")),
        Failure::Other(message) => Failure::Other(format!("frame {frame}: {message}")),
    }
}
