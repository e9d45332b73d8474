//! One picture: its samples with checkpoints, and its file.

use super::arguments::Arguments;
use super::checkpoint::{self, Checkpoint};
use super::frame_denoiser::Turn;
use super::output::Output;
use super::progress::{Picture, Progress};
use super::samples::Samples;
use super::{print_settings, render_failure};
use crate::film_notes;
use crate::picture::Denoised;
use pathmarch_cli::{Failure, note};
use pathmarch_render::denoise::{Denoiser, Features, HalfFilms};
use pathmarch_render::film::Film;
use pathmarch_render::parts::{self, FilmFile, FilmHeader, Identity};
use pathmarch_render::pathmarch_scene::{Animation, Scene};
use pathmarch_render::{Job, Renderer, Settings, Shutter};
use std::ffi::OsString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// A picture to render.
pub(super) struct Task<'a> {
    pub(super) arguments: &'a Arguments,
    pub(super) renderer: &'a Renderer,
    pub(super) animation: &'a Arc<Mutex<Animation>>,
    pub(super) scene: &'a Scene,
    pub(super) settings: Settings,
    pub(super) shutter: Shutter,
    pub(super) output: &'a Output,
    pub(super) interrupted: &'a AtomicBool,
    pub(super) progress: &'a Progress,
    /// Its number among the frames, their number, and its frame.
    pub(super) place: (usize, usize, Option<u32>),
    /// Its turn among the frames that are joined by the denoiser.
    pub(super) turn: Option<&'a Turn<'a>>,
    /// True if the settings are printed.
    pub(super) says_settings: bool,
}

/// Film and figures of a render.
pub(super) struct Outcome {
    pub(super) film: Film,
    /// Samples of the whole picture.
    pub(super) of: u32,
    /// Samples that this run rendered.
    pub(super) rendered: u32,
    pub(super) seconds: f64,
    /// Samples and error of the tiles, with `--noise`.
    pub(super) adaptive: Option<Reached>,
    /// Seconds of the denoiser, if there is one.
    pub(super) denoising: Option<f64>,
    /// True if the output was written; an interrupted frame or film is not, because its file would count as done.
    pub(super) written: bool,
    /// True if it is not complete because it was interrupted.
    pub(super) interrupted: bool,
    /// File from which `--resume` goes on.
    pub(super) checkpoint: Option<String>,
}

/// Samples and error of the tiles of a picture.
pub(super) struct Reached {
    /// Numbers of samples, for a message.
    pub(super) samples: String,
    /// Errors, for a message.
    pub(super) error: String,
    /// Largest relative error of a tile; `None` before it can be estimated.
    pub(super) worst: Option<f32>,
}

impl Task<'_> {
    /// Renders with checkpoints.
    pub(super) fn run(&self) -> Result<Outcome, Failure> {
        self.progress.preparing(&self.arguments.scene_name());
        if let Some(noise) = self.arguments.noise {
            return self.run_adaptive(noise);
        }
        let (mut job, mut samples, before, header, mut checkpoint) = self.begin()?;
        if self.says_settings {
            print_settings(self.arguments, job.backend(), &self.settings, self.progress);
        }
        if self.settings.path_reuse == Some(true) && !job.reuses_paths() {
            note!("note: --path-reuse has no effect: it is for path-traced pictures of diffuse surfaces");
        }
        if self.settings.emitter_edges == Some(true) && !job.traces_emitter_edges() {
            note!("note: --emitter-edges has no effect: no lamp is in view, or there are fog, media or priorities");
        }
        let picture = self.picture(before);
        let of = self.settings.samples;
        let late = || self.arguments.seconds.is_some_and(|seconds| picture.started.elapsed().as_secs_f64() >= seconds);
        let ends = |done: f64| self.interrupted.load(Ordering::SeqCst) || late() && f64::from(before) + done >= 1.0;
        let mut done = before;
        while done < of {
            let doubled =
                if self.progress.estimates_error() { done.max(1).next_power_of_two().max(16) } else { u32::MAX };
            let doubled = if doubled == done { doubled.saturating_mul(2) } else { doubled };
            let pauses =
                |now: f64| checkpoint.as_ref().is_some_and(Checkpoint::is_due) || before + now as u32 >= doubled;
            let progress = |now: f64| self.progress.show(&picture, now, &self.settings);
            samples.record(&mut job, |now| ends(now) || pauses(now), progress).map_err(render_failure)?;
            done = samples.count();
            if done >= doubled {
                self.progress.record(&picture, done, &samples.film().mean().pixels);
            }
            let is_due = checkpoint.as_ref().is_some_and(Checkpoint::is_due);
            if let Some(checkpoint) = checkpoint.as_mut().filter(|_| is_due && done < of) {
                // A full disk must not end a long render.
                if let Err(failure) = checkpoint.save(&header, samples.parts()) {
                    self.progress.suspend(|| note!("warning: no checkpoint: {}", failure.message()));
                }
            }
            if ends(f64::from(done - before)) {
                break;
            }
        }
        self.progress.completed(&picture);
        let seconds = picture.started.elapsed().as_secs_f64();
        let film = samples.film();
        let interrupted = done < of && self.interrupted.load(Ordering::SeqCst);
        let written = !interrupted || self.place.2.is_none() && !matches!(self.output, Output::Film(_));
        let mut denoising = None;
        if written {
            let write = self.write(&job, &film, &header, &samples);
            denoising = write.map_err(|failure| self.rescue(failure, checkpoint.as_mut(), &header, &samples))?;
        }
        let checkpoint = self.close(checkpoint, &header, &samples, done < of)?;
        Ok(Outcome {
            film,
            of,
            rendered: done - before,
            seconds,
            adaptive: None,
            denoising,
            written,
            interrupted,
            checkpoint,
        })
    }

    fn start(&self, settings: &Settings) -> Result<Job, Failure> {
        check_memory(settings, if self.arguments.denoise.is_some() { 2 } else { 1 })?;
        let job = self.renderer.start_motion_blur(self.animation, self.scene, settings, self.shutter);
        job.map_err(render_failure)
    }

    pub(super) fn picture(&self, before: u32) -> Picture {
        let (index, count, frame) = self.place;
        Picture { index, count, frame, started: Instant::now(), before, samples: self.settings.samples }
    }

    /// Film of the checkpoint, if the picture is to be resumed and has one. Prints notes of a checkpoint that is not used, or that
    /// is missing.
    pub(super) fn film_to_resume(&self, checkpoint: Option<&Checkpoint>) -> Result<Option<FilmFile>, Failure> {
        let is_still = self.place.2.is_none();
        let film = match checkpoint {
            Some(checkpoint) if self.arguments.resume => checkpoint.open()?,
            Some(checkpoint) if checkpoint.exists() && is_still => {
                checkpoint.say_unfinished();
                None
            }
            _ => None,
        };
        if film.is_none() && self.arguments.resume && is_still {
            note!("note: there is no checkpoint; rendering from the first sample");
        }
        Ok(film)
    }

    /// The job, the samples of the checkpoint, their number, and the checkpoint.
    fn begin(&self) -> Result<(Job, Samples, u32, FilmHeader, Option<Checkpoint>), Failure> {
        let (settings, denoiser) = (&self.settings, self.arguments.denoise);
        let job = self.start(settings)?;
        let (first, end) = (settings.first_sample, settings.first_sample + settings.samples);
        let header = FilmHeader {
            size: settings.size,
            samples: [first, self.whole_end()],
            identity: self.identity(&job),
            engines: vec![job.engine()],
            notes: film_notes::notes(
                self.arguments.display(self.scene, settings, None),
                self.arguments.has_auto_exposure(self.scene, settings),
                settings,
                self.scene,
            ),
            regions: Vec::new(),
        };
        let checkpoint = self.output.file().map(Checkpoint::of);
        let Some(film) = self.film_to_resume(checkpoint.as_ref())? else {
            return Ok((job, Samples::new(settings, denoiser), 0, header, checkpoint));
        };
        let path = film.path().to_owned();
        let parts = checkpoint::parts(film, &header.identity, &header.engines[0], settings.rect(), [first, end])?;
        let samples = Samples::of(parts, settings, denoiser).ok_or_else(|| checkpoint::wrong_regions(&path))?;
        let before = samples.count();
        if before == 0 || before >= settings.samples {
            return Ok((job, samples, before.min(settings.samples), header, checkpoint));
        }
        let rest = Settings {
            first_sample: first + before,
            samples: settings.samples - before,
            whole_samples: Some(settings.whole_samples.unwrap_or(settings.samples)),
            light_samples: Some(job.light_samples()),
            indirect_samples: Some(job.indirect_samples()),
            light_paths: job.light_paths(),
            path_reuse: Some(job.reuses_paths()),
            emitter_edges: Some(job.traces_emitter_edges()),
            splitting: Some(job.splitting()).filter(|_| settings.mode.traces_paths()).or(settings.splitting),
            ..settings.clone()
        };
        Ok((self.start(&rest)?, samples, before, header, checkpoint))
    }

    /// End of the samples of the whole picture, of which this may be a part.
    fn whole_end(&self) -> u32 {
        let end = self.settings.first_sample + self.settings.samples;
        self.settings.whole_samples.map_or(end, |whole| whole.max(end))
    }

    /// Identity of the samples of a job.
    fn identity(&self, job: &Job) -> Identity {
        let mut identity = job.identity(self.scene, self.shutter);
        if self.arguments.denoise.is_some() {
            identity.0.insert("--denoise".to_owned(), "given".to_owned());
        }
        identity
    }

    /// Writes the output, and returns the seconds of the denoiser.
    fn write(&self, job: &Job, film: &Film, header: &FilmHeader, samples: &Samples) -> Result<Option<f64>, Failure> {
        let (arguments, settings) = (self.arguments, &self.settings);
        if let Output::Film(file) = self.output {
            return parts::save(file, header, samples.parts()).map(|()| None).map_err(Failure::other);
        }
        let started = Instant::now();
        let denoised = match samples {
            Samples::Part(_) => None,
            Samples::Halves(halves, denoiser) => Some(self.denoised(halves.into(), *denoiser, halves.samples())?),
        };
        let denoising = denoised.as_ref().map(|_| started.elapsed().as_secs_f64());
        super::write(arguments, job.backend(), self.scene, settings, film, denoised, self.output)?;
        Ok(denoising)
    }

    /// Denoised picture of films with so many samples of a pixel.
    pub(super) fn denoised(&self, films: HalfFilms, denoiser: Denoiser, samples: u32) -> Result<Denoised, Failure> {
        let features = Features::trace_motion_blur(self.animation, self.scene, &self.settings, self.shutter, samples);
        let features = features.map_err(render_failure)?;
        let (picture, is_joined) = match self.turn {
            Some(turn) => turn.denoise(films, &features)?,
            None => (denoiser.denoise(films, &features).map_err(Failure::other)?, false),
        };
        Ok(Denoised { denoiser, is_joined, picture })
    }

    /// Keeps the samples of a picture that cannot be written, beside it or among temporary files, and adds where to the failure.
    fn rescue(
        &self,
        failure: Failure,
        checkpoint: Option<&mut Checkpoint>,
        header: &FilmHeader,
        samples: &Samples,
    ) -> Failure {
        let Some(checkpoint) = checkpoint else { return failure };
        if checkpoint.save(header, samples.parts()).is_ok() {
            let path = checkpoint.path().display();
            return Failure::Other(format!("{}; its samples are in {path}: write it with --resume", failure.message()));
        }
        let mut name = OsString::from(format!("pathmarch-{}-", std::process::id()));
        name.push(checkpoint.path().file_name().unwrap_or_default());
        let temporary = std::env::temp_dir().join(name);
        if parts::save(&temporary, header, samples.parts()).is_err() {
            return failure;
        }
        let (path, place) = (temporary.display(), checkpoint.path().display());
        Failure::Other(format!(
            "{}; its samples are in {path}: move that file to {place} and write the picture with --resume",
            failure.message()
        ))
    }

    /// Removes the checkpoint of a complete picture, and writes that of another.
    fn close(
        &self,
        checkpoint: Option<Checkpoint>,
        header: &FilmHeader,
        samples: &Samples,
        incomplete: bool,
    ) -> Result<Option<String>, Failure> {
        let Some(mut checkpoint) = checkpoint else { return Ok(None) };
        if incomplete && samples.count() > 0 {
            checkpoint.save(header, samples.parts())?;
            return Ok(Some(checkpoint.path().display().to_string()));
        }
        checkpoint.remove();
        Ok(None)
    }
}

/// Fails if there is no memory for the films, instead of ending the program when it is needed.
pub(super) fn check_memory(settings: &Settings, films: usize) -> Result<(), Failure> {
    /// Bytes of a pixel and a film: sums of blocks, of a block, and of the picture.
    const PIXEL: usize = 49 + 4 * 12;
    let bytes = settings.rect().pixels().saturating_mul(PIXEL * films);
    Vec::<u8>::new().try_reserve_exact(bytes).map_err(|_| {
        let [width, height] = settings.size;
        Failure::Other(format!(
            "a picture of {width}x{height} needs {} MB of memory; render it in parts with --crop",
            bytes >> 20
        ))
    })
}

/// Backend and adapter of a checkpoint, if one is to be resumed.
pub(super) fn engine_of_checkpoint(arguments: &Arguments, output: &Output) -> Option<String> {
    let file = output.file().filter(|_| arguments.resume)?;
    let film: FilmFile = Checkpoint::of(file).open().ok()??;
    film.header().engines.first().cloned()
}
