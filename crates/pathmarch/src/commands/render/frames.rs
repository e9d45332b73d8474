//! Frames of an animation, one after the other or several at a time; a frame is written once it is complete.
//!
//! Memory does not grow with the number of frames: it is that of the frames that are rendered at a time.

use super::arguments::Arguments;
use super::frame_denoiser::{FrameDenoiser, Turn};
use super::output::Output;
use super::progress::Progress;
use super::still::Task;
use crate::frames::{self, FrameRange};
use pathmarch_cli::{DONE, Failure, INTERRUPTED, note, print_report};
use pathmarch_render::Renderer;
use pathmarch_render::pathmarch_scene::{Animation, Moment};
use serde_json::json;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
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

/// Frames that one thread after the other takes, and what became of them.
struct Queue {
    /// Index of the next frame.
    next: AtomicUsize,
    /// True if no further frame is to be started.
    stop: AtomicBool,
    done: Mutex<Done>,
    /// Denoiser that joins the frames, if they are to be joined.
    denoiser: Option<FrameDenoiser>,
}

/// What became of the frames.
#[derive(Default)]
struct Done {
    wrote: usize,
    non_finite: u64,
    /// Warnings that were printed.
    warned: Vec<String>,
    /// First failure, in the order of the frames, and its frame.
    failure: Option<(u32, Failure)>,
}

impl Frames<'_> {
    /// Frames that are not there, or are torn; reports the latter.
    fn left(&self) -> Vec<u32> {
        let is_left = |frame: &u32| {
            let file = frames::file(self.pattern, *frame);
            if !self.arguments.skip_existing || !file.exists() {
                return true;
            }
            let is_whole = frames::is_whole(&file);
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
        let queue = Queue {
            next: AtomicUsize::new(0),
            stop: AtomicBool::new(false),
            done: Mutex::default(),
            denoiser: self.arguments.joins_frames().then(|| FrameDenoiser::new(self.frames.step())),
        };
        let threads = self.arguments.parallel.min(left.len());
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|| self.work(&left, &queue));
            }
            self.work(&left, &queue);
        });
        self.progress.finish();
        let Done { wrote, non_finite, failure, .. } = queue.done.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some((frame, failure)) = failure {
            return Err(in_frame(frame, failure));
        }
        if wrote < left.len() {
            let (wrote, more) = (frame_count(wrote), left.len() - wrote);
            note!("interrupted: wrote {wrote}, {more} left; continue with --skip-existing --resume");
            return Ok(INTERRUPTED);
        }
        if non_finite > 0 {
            note!("warning: {non_finite} non-finite samples were discarded");
        }
        let there = if skipped > 0 { format!(", {skipped} existed already") } else { String::new() };
        let (wrote, seconds) = (frame_count(left.len()), began.elapsed().as_secs_f64());
        note!("wrote {wrote} to {} in {seconds:.1} s{there}", self.pattern.display());
        Ok(DONE)
    }

    /// Renders frames of the queue until there are no more, one fails, or the program is interrupted.
    fn work(&self, left: &[u32], queue: &Queue) {
        let done = || queue.done.lock().unwrap_or_else(PoisonError::into_inner);
        while !queue.stop.load(Ordering::SeqCst) {
            let index = queue.next.fetch_add(1, Ordering::SeqCst);
            let Some(&frame) = left.get(index) else { break };
            let turn = queue.denoiser.as_ref().map(|denoiser| denoiser.turn(index, frame));
            match self.frame((index, left.len()), frame, turn.as_ref(), &done) {
                Ok(Some(rejected)) => {
                    let mut done = done();
                    (done.wrote, done.non_finite) = (done.wrote + 1, done.non_finite + rejected);
                }
                // An incomplete frame is not written: its file would count as done.
                Ok(None) => queue.stop.store(true, Ordering::SeqCst),
                Err(failure) => {
                    queue.stop.store(true, Ordering::SeqCst);
                    let mut done = done();
                    if done.failure.as_ref().is_none_or(|(first, _)| frame < *first) {
                        done.failure = Some((frame, failure));
                    }
                }
            }
        }
    }

    /// Renders a frame and returns its number of rejected samples; `None` if it was interrupted.
    fn frame<'d>(
        &self,
        (index, count): (usize, usize),
        frame: u32,
        turn: Option<&Turn>,
        done: &impl Fn() -> MutexGuard<'d, Done>,
    ) -> Result<Option<u64>, Failure> {
        let moment = Moment::of_frame(frame, self.fps);
        let scene = self.animation.lock().unwrap_or_else(PoisonError::into_inner).at(moment)?;
        let mut state = done();
        for warning in &scene.warnings {
            if !state.warned.contains(&warning.message) {
                self.progress.suspend(|| print_report(warning));
                state.warned.push(warning.message.clone());
            }
        }
        drop(state);
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
            turn,
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
