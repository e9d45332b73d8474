//! Denoiser of frames, which takes them in their order and passes the past from one to the next.
//!
//! Frames may be rendered several at a time; each waits for the filter of the one before, so that the pictures do not
//! depend on how many there are.

use pathmarch_cli::Failure;
use pathmarch_render::denoise::{Features, HalfFilms, SequenceDenoiser};
use pathmarch_render::image::Picture;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Denoiser of the frames of a run.
pub(super) struct FrameDenoiser {
    /// Difference between the numbers of consecutive frames.
    step: u32,
    state: Mutex<State>,
    turn_ended: Condvar,
}

#[derive(Default)]
struct State {
    /// Index of the frame whose turn it is.
    index: usize,
    /// Number of the last denoised frame.
    last: Option<u32>,
    denoiser: SequenceDenoiser,
}

/// Turn of a frame; dropped, it waits for those before and passes on, so that frames that fail hold up no others.
pub(super) struct Turn<'a> {
    frames: &'a FrameDenoiser,
    index: usize,
    frame: u32,
}

impl FrameDenoiser {
    /// Denoiser of frames that are `step` apart.
    pub(super) fn new(step: u32) -> Self {
        Self { step, state: Mutex::default(), turn_ended: Condvar::new() }
    }

    /// Turn of the frame of this index in the run, which starts at 0, and of this number.
    pub(super) fn turn(&self, index: usize, frame: u32) -> Turn<'_> {
        Turn { frames: self, index, frame }
    }

    /// State in the turn of a frame.
    fn wait(&self, index: usize) -> MutexGuard<'_, State> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let waits = self.turn_ended.wait_while(state, |state| state.index != index);
        waits.unwrap_or_else(PoisonError::into_inner)
    }
}

impl Turn<'_> {
    /// Denoised picture, and whether the frame before has helped: it must be that of the last turn, not one that an
    /// earlier run has written.
    pub(super) fn denoise(&self, films: HalfFilms, features: &Features) -> Result<(Picture, bool), Failure> {
        let mut state = self.frames.wait(self.index);
        let before = self.frame.checked_sub(self.frames.step);
        if state.last.is_none() || state.last != before {
            state.denoiser.forget();
        }
        let has_past = state.denoiser.has_past();
        let picture = state.denoiser.denoise(films, features).map_err(Failure::other)?;
        state.last = Some(self.frame);
        Ok((picture, has_past))
    }
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.frames.wait(self.index).index += 1;
        self.frames.turn_ended.notify_all();
    }
}
