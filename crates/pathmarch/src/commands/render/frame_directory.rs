//! Frames of a video: they are rendered into a directory beside it, which is removed once the video is complete.

use super::arguments::Arguments;
use crate::frames::{self, FrameRange};
use crate::video::{Encoder, Frame};
use pathmarch_cli::{Failure, note};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Directory of the frames of a video.
pub(super) struct FrameDirectory {
    path: PathBuf,
    pattern: PathBuf,
}

impl FrameDirectory {
    /// Directory of this video; it is not created yet.
    pub(super) fn of(video: &Path) -> Self {
        let mut name = OsString::from(video);
        name.push(".frames");
        let path = PathBuf::from(name);
        Self { pattern: path.join("######.png"), path }
    }

    /// Creates the directory, and returns the pattern of its files. Frames of an earlier run are removed unless they are to be
    /// skipped.
    pub(super) fn create(&self, arguments: &Arguments) -> Result<&Path, Failure> {
        if self.path.exists() && !arguments.skip_existing {
            self.remove()?;
        }
        std::fs::create_dir_all(&self.path).map_err(|error| self.failure(&error))?;
        Ok(&self.pattern)
    }

    /// Makes the video of its frames, and removes it.
    pub(super) fn encode(&self, video: &Path, range: FrameRange, fps: f32) -> Result<(), Failure> {
        let count = range.numbers().count();
        let mut encoder: Option<Encoder> = None;
        for number in range.numbers() {
            let frame = Frame::load(&frames::file(&self.pattern, number), 0.0)?;
            let encoder = match &mut encoder {
                Some(encoder) => encoder,
                none => none.insert(Encoder::start(video, frame.size, fps, count)?),
            };
            encoder.add(&frame)?;
        }
        encoder.map_or(Ok(()), Encoder::finish)?;
        self.remove()?;
        note!("wrote {}: {count} frames at {fps} frames per second", video.display());
        Ok(())
    }

    fn remove(&self) -> Result<(), Failure> {
        std::fs::remove_dir_all(&self.path).map_err(|error| self.failure(&error))
    }

    fn failure(&self, error: &std::io::Error) -> Failure {
        Failure::Other(format!("{}: {error}", self.path.display()))
    }
}
