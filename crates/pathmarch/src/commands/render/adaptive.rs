//! One picture with `--noise`: as many samples for each tile as its error asks for.

use super::checkpoint::{self, Checkpoint};
use super::still::{Outcome, Reached, Task, check_memory};
use super::{print_settings, render_failure};
use pathmarch_cli::{Failure, note};
use pathmarch_render::film::Film;
use pathmarch_render::parts::{FilmHeader, FilmPart};
use pathmarch_render::{AdaptiveJob, AdaptiveTile};
use std::sync::atomic::Ordering;
use std::time::Instant;

impl Task<'_> {
    /// Renders a picture whose tiles have a relative error below `noise`.
    pub(super) fn run_adaptive(&self, noise: f32) -> Result<Outcome, Failure> {
        let (arguments, settings) = (self.arguments, &self.settings);
        check_memory(settings, 6)?;
        let (mut job, header, mut checkpoint) = self.begin_adaptive(noise)?;
        if self.says_settings {
            print_settings(arguments, job.backend(), settings, self.progress);
        }
        let picture = self.picture(0);
        let late = || arguments.seconds.is_some_and(|seconds| picture.started.elapsed().as_secs_f64() >= seconds);
        let ends = || self.interrupted.load(Ordering::SeqCst) || late();
        loop {
            let pauses = || checkpoint.as_ref().is_some_and(Checkpoint::is_due);
            job.run(
                || ends() || pauses(),
                |job| self.progress.show_share(&picture, job.share_done(), job.is_planned()),
            )
            .map_err(render_failure)?;
            if job.is_done() || ends() {
                break;
            }
            let parts = job.parts().map_err(render_failure)?;
            // A full disk must not end a long render.
            if let Some(Err(failure)) = checkpoint.as_mut().map(|checkpoint| checkpoint.save(&header, &parts)) {
                self.progress.suspend(|| note!("warning: no checkpoint: {}", failure.message()));
            }
        }
        self.progress.completed(&picture);
        let (halves, tiles) = job.halves().map_err(render_failure)?;
        let seconds = picture.started.elapsed().as_secs_f64();
        let interrupted = !job.is_done() && self.interrupted.load(Ordering::SeqCst);
        let written = !interrupted || self.place.2.is_none();
        let film = halves.film().clone();
        let mut denoising = None;
        if written {
            let started = Instant::now();
            let counts = film.sample_counts();
            let mean = counts.iter().map(|count| u64::from(*count)).sum::<u64>() / counts.len().max(1) as u64;
            let denoised = arguments.denoise.map(|denoiser| self.denoised(halves, denoiser, mean.max(1) as u32));
            let denoised = denoised.transpose()?;
            denoising = denoised.as_ref().map(|_| started.elapsed().as_secs_f64());
            super::write(arguments, job.backend(), self.scene, settings, &film, denoised, self.output)?;
        }
        let mut kept = None;
        if let Some(checkpoint) = &mut checkpoint {
            if job.is_done() {
                checkpoint.remove();
            } else {
                checkpoint.save(&header, &job.parts().map_err(render_failure)?)?;
                kept = Some(checkpoint.path().display().to_string());
            }
        }
        let adaptive = Some(reached(&film, &tiles, noise));
        let (of, rendered) = (settings.samples, film.samples);
        Ok(Outcome { film, of, rendered, seconds, adaptive, denoising, written, interrupted, checkpoint: kept })
    }

    /// The job, from its checkpoint on if it is to be resumed, the header of checkpoints, and the checkpoint.
    fn begin_adaptive(&self, noise: f32) -> Result<(AdaptiveJob, FilmHeader, Option<Checkpoint>), Failure> {
        let start = |parts| {
            let (animation, scene, settings) = (self.animation, self.scene, &self.settings);
            let job = self.renderer.start_adaptive_motion_blur(animation, scene, settings, self.shutter, noise, parts);
            job.map_err(render_failure)
        };
        let job = start(None)?;
        let header = FilmHeader {
            size: self.settings.size,
            samples: [0, job.most_samples()],
            identity: job.identity(self.scene, self.shutter),
            engines: vec![job.engine()],
            notes: Default::default(),
            regions: Vec::new(),
        };
        let checkpoint = self.output.file().map(Checkpoint::of);
        let Some(film) = self.film_to_resume(checkpoint.as_ref())? else {
            return Ok((job, header, checkpoint));
        };
        let path = film.path().to_owned();
        let samples = header.samples;
        let parts = checkpoint::parts(film, &header.identity, &header.engines[0], self.settings.rect(), samples)?;
        let parts: [FilmPart; 3] = parts.try_into().map_err(|_| checkpoint::wrong_regions(&path))?;
        Ok((start(Some(parts))?, header, checkpoint))
    }
}

fn reached(film: &Film, tiles: &[AdaptiveTile], noise: f32) -> Reached {
    let samples = || tiles.iter().map(|tile| tile.samples);
    let (least, most) = (samples().min().unwrap_or(0), samples().max().unwrap_or(0));
    let counts = film.sample_counts();
    let mean = counts.iter().map(|count| f64::from(*count)).sum::<f64>() / counts.len().max(1) as f64;
    let samples = format!("{least} to {most} samples of a pixel, {mean:.0} on average,");
    let worst = tiles.iter().map(|tile| tile.error).fold(0.0, f32::max);
    if !worst.is_finite() {
        return Reached { samples, error: "The error cannot be estimated yet.".to_owned(), worst: None };
    }
    let squares = tiles.iter().map(|tile| f64::from(tile.error).powi(2) * tile.rect.pixels() as f64).sum::<f64>();
    let error = (squares / counts.len().max(1) as f64).sqrt();
    let above = tiles.iter().filter(|tile| tile.error > noise).count();
    let above = match above {
        0 => String::new(),
        n => format!("; {n} of {} tiles are above {noise}", tiles.len()),
    };
    let error = format!("estimated relative error {error:.4}, of the worst tile {worst:.4}{above}");
    Reached { samples, error, worst: Some(worst) }
}
