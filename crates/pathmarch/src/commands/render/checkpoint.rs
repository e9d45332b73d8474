//! Checkpoints: the film of a render that is not finished, kept beside its output.
//!
//! A checkpoint is written whole, and the one before is kept until the next: if the last one is damaged, the one before is
//! used.

use pathmarch_cli::{Failure, note};
use pathmarch_render::parts::{FilmFile, FilmFileError, FilmHeader, FilmPart, Identity, Rect, save};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two checkpoints.
const INTERVAL: Duration = Duration::from_secs(60);
/// Time between two checkpoints, at least, in times that it takes to write one: checkpoints cost at most 2 % of the time.
const COSTS: u32 = 50;

/// Checkpoint of an output file.
pub(super) struct Checkpoint {
    file: PathBuf,
    previous: PathBuf,
    written: Instant,
    cost: Duration,
}

impl Checkpoint {
    /// Checkpoint of this output; nothing is read or written yet.
    pub(super) fn of(output: &Path) -> Self {
        let named = |end: &str| {
            let mut name = OsString::from(output);
            name.push(end);
            PathBuf::from(name)
        };
        let (file, previous) = (named(".checkpoint"), named(".checkpoint.previous"));
        Self { file, previous, written: Instant::now(), cost: Duration::ZERO }
    }

    /// True if one is there.
    pub(super) fn exists(&self) -> bool {
        self.file.exists() || self.previous.exists()
    }

    /// Prints that one is there and is not used.
    pub(super) fn say_unfinished(&self) {
        note!("note: {} is of a render that was not finished; --resume would go on from there", self.file.display());
    }

    /// True if it is time for the next.
    pub(super) fn is_due(&self) -> bool {
        self.written.elapsed() >= interval().max(self.cost * COSTS)
    }

    /// Path of the file.
    pub(super) fn path(&self) -> &Path {
        &self.file
    }

    pub(super) fn save(&mut self, header: &FilmHeader, parts: &[FilmPart]) -> Result<(), Failure> {
        let started = Instant::now();
        if self.file.exists() {
            std::fs::rename(&self.file, &self.previous)
                .map_err(|error| Failure::Other(format!("{}: {error}", self.previous.display())))?;
        }
        save(&self.file, header, parts).map_err(Failure::other)?;
        (self.cost, self.written) = (started.elapsed(), Instant::now());
        Ok(())
    }

    /// Removes it once its picture is written.
    pub(super) fn remove(&self) {
        for file in [&self.file, &self.previous] {
            let _ = std::fs::remove_file(file);
        }
    }

    /// Last valid checkpoint; reports damaged ones.
    pub(super) fn open(&self) -> Result<Option<FilmFile>, Failure> {
        for file in [&self.file, &self.previous] {
            if !file.exists() {
                continue;
            }
            // Reading it to the end finds damage in its pixels.
            match FilmFile::open(file).and_then(|mut film| film.parts().map(|_| film)) {
                Ok(film) => return Ok(Some(film)),
                Err(error @ FilmFileError::Io { .. }) => return Err(Failure::other(error)),
                Err(error) => note!("warning: {error}"),
            }
        }
        Ok(None)
    }
}

/// Time between two checkpoints; tests shorten it.
fn interval() -> Duration {
    let seconds = std::env::var("PATHMARCH_CHECKPOINT_SECONDS").ok().and_then(|text| text.parse().ok());
    let seconds = seconds.filter(|seconds: &f64| (0.0..=1e6).contains(seconds));
    seconds.map_or(INTERVAL, Duration::from_secs_f64)
}

/// Failure of a checkpoint with a wrong number of parts.
pub(super) fn wrong_regions(path: &Path) -> Failure {
    Failure::Other(format!("{}: the number of its regions is wrong", path.display()))
}

/// Parts of a checkpoint, if it is one of this picture.
pub(super) fn parts(
    mut film: FilmFile,
    identity: &Identity,
    engine: &str,
    rect: Rect,
    samples: [u32; 2],
) -> Result<Vec<FilmPart>, Failure> {
    let refuse = |reason: String| {
        let path = film.path().display();
        Err(Failure::Usage(format!(
            "--resume: {path} is the checkpoint of another picture: {reason}; render without --resume to begin anew"
        )))
    };
    let header = film.header();
    if let Some(difference) = header.identity.difference("there", identity, "here") {
        return refuse(difference);
    }
    if header.engines != [engine] {
        return refuse(format!("it was rendered on {} and this is {engine}", header.engines.join(", ")));
    }
    if header.regions.iter().any(|region| region.rect != rect) {
        return refuse("the crop differs".to_owned());
    }
    let found = header
        .regions
        .iter()
        .fold(Default::default(), |all: pathmarch_render::parts::SampleSet, region| all.union(&region.samples()));
    match found.ranges() {
        [] => {}
        [[start, end]] if *start == samples[0] && *end <= samples[1] => {}
        _ => {
            return refuse(format!(
                "it has the samples {found}, which are not the first of {}..{}",
                samples[0], samples[1]
            ));
        }
    }
    film.parts().map_err(Failure::other)
}
