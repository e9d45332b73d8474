//! One picture with `--noise`: as many samples for each tile as its error asks for.

use super::still::{Outcome, Reached, Task, check_memory};
use super::{print_settings, render_failure};
use pathmarch_cli::Failure;
use pathmarch_render::AdaptiveTile;
use pathmarch_render::film::Film;
use std::sync::atomic::Ordering;

impl Task<'_> {
    /// Renders a picture whose tiles have a relative error below `noise`.
    pub(super) fn run_adaptive(&self, noise: f32) -> Result<Outcome, Failure> {
        let (arguments, settings) = (self.arguments, &self.settings);
        if self.shutter.blurs(self.scene, settings) {
            return Err(Failure::Usage(
                "--noise: a moving scene with a shutter has no adaptive sampling yet; use --samples, or --shutter 0"
                    .to_owned(),
            ));
        }
        check_memory(settings, 3)?;
        let mut job = self.renderer.start_adaptive(self.scene, settings, noise).map_err(render_failure)?;
        if self.says_settings {
            print_settings(arguments, job.backend(), settings, self.progress);
        }
        let picture = self.picture(0);
        let late = || arguments.seconds.is_some_and(|seconds| picture.started.elapsed().as_secs_f64() >= seconds);
        let stop = || self.interrupted.load(Ordering::SeqCst) || late();
        job.run(stop, |job| self.progress.show_share(&picture, job.share_done(), job.is_planned()))
            .map_err(render_failure)?;
        self.progress.completed(&picture);
        let (film, tiles) = job.film().map_err(render_failure)?;
        let seconds = picture.started.elapsed().as_secs_f64();
        let interrupted = !job.is_done() && self.interrupted.load(Ordering::SeqCst);
        let written = !interrupted || self.place.2.is_none();
        if written {
            super::write(arguments, job.backend(), self.scene, settings, &film, None, self.output)?;
        }
        let adaptive = Some(reached(&film, &tiles, noise));
        let (of, rendered) = (settings.samples, film.samples);
        Ok(Outcome { film, of, rendered, seconds, adaptive, denoising: None, written, interrupted, checkpoint: None })
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
