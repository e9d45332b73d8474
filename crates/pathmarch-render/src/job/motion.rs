//! Motion blur: pictures of a scene that moves while the shutter is open.
//!
//! **Idea.** Every sample of a pixel samples the time at which the shutter is open, so that the mean over the samples is the
//! mean over that time (distributed ray tracing). Runs of [`RUN`] samples share a moment. Each run parses the scene at its
//! moment, and the films of all runs are added.
//!
//! **Source.** Cook, Porter, Carpenter 1984, "Distributed Ray Tracing". The moments are van der Corput's sequence, Owen
//! scrambled. Its order is shuffled so that moments are independent of the points within pixels, which have the same order
//! (Burley 2020, section 5). 2^k consecutive runs from a multiple of 2^k thus have one moment in each of 2^k equal parts of the
//! time. A moment is a pure function of seed and sample, so that films of adjoining sample ranges add up.
//!
//! **Cost.** Each run parses and prepares the scene, a few milliseconds for small scenes, and reads its film back once for
//! each sample. The kernel
//! is compiled once if only parameters change.

use super::tracer::Tracer;
use super::{BackendInfo, Renderer};
use crate::error::RenderError;
use crate::integrator::photons::default_path_count;
use crate::mode::Mode;
use crate::output::film::Film;
use crate::output::parts::Rect;
use crate::sampling::sobol::{hash, scramble_reversed};
use crate::settings::Settings;
use pathmarch_scene::{Animation, Moment, Scene};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of consecutive samples that share a moment. Two halve the cost of moments; more would be visible as separate
/// pictures if there are few samples.
const RUN: u32 = 2;

/// Time at which the shutter opens, and exposure time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// Moment at which it opens.
    pub opens: Moment,
    /// Exposure time, seconds.
    pub seconds: f64,
}

impl Shutter {
    /// Shutter that opens at the moment of a scene, for a fraction `part` of the frame time.
    pub fn open_for(scene: &Scene, part: f32, fps: f32) -> Self {
        Self { opens: scene.moment, seconds: f64::from(part) / f64::from(fps) }
    }
    /// Shutter that the scene declares.
    pub fn of(scene: &Scene) -> Self {
        Self::open_for(scene, scene.render.shutter, scene.render.fps)
    }
    /// True if a picture of a scene with these settings has motion blur.
    pub fn blurs(&self, scene: &Scene, settings: &Settings) -> bool {
        self.seconds > 0.0 && scene.animated && settings.mode == Mode::Path
    }
    /// Moment of a sample. The frame number stays the same.
    pub fn moment(&self, seed: u32, sample: u32) -> Moment {
        let run = sample / RUN;
        // To shuffle an index is to scramble its bits from the highest down; its reversed bits are van der Corput's number.
        let shuffled = scramble_reversed(run.reverse_bits(), hash(seed ^ 0x6d6f_7469)).reverse_bits();
        let scrambled = scramble_reversed(shuffled, hash(seed ^ 0x6f6e_2121)).reverse_bits();
        let share = (f64::from(scrambled) + 0.5) / 2.0_f64.powi(32);
        Moment { seconds: self.opens.seconds + share * self.seconds, frame: self.opens.frame }
    }
}

/// Picture of a moving scene that is being rendered.
pub(super) struct MotionBlur {
    renderer: Renderer,
    animation: Arc<Mutex<Animation>>,
    settings: Settings,
    shutter: Shutter,
    film: Film,
    /// Index of the first sample of the film.
    first_sample: u32,
    /// Tracer of the current run, and its number of samples that are not in the film.
    run: Option<(Tracer, u32)>,
    backend: Option<BackendInfo>,
    /// Rectangles that further samples are taken in; all if there are none.
    active: Vec<Rect>,
}

impl MotionBlur {
    /// Starts a picture; renders nothing yet.
    pub(super) fn new(
        renderer: Renderer,
        animation: Arc<Mutex<Animation>>,
        settings: &Settings,
        shutter: Shutter,
    ) -> Self {
        let rect = settings.rect();
        let film = Film::new(rect.width, rect.height);
        let first_sample = settings.first_sample;
        let (settings, active) = (settings.clone(), Vec::new());
        Self { renderer, animation, settings, shutter, film, first_sample, run: None, backend: None, active }
    }

    /// Backend of the latest run.
    pub(super) fn backend(&self) -> Option<&BackendInfo> {
        self.backend.as_ref()
    }

    pub(super) fn samples_done(&self) -> f64 {
        f64::from(self.film.samples) + self.run.as_ref().map_or(0.0, |(tracer, _)| tracer.samples_done())
    }

    /// Renders a slice of the work towards `samples` samples.
    pub(super) fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        if self.film.samples >= samples {
            return Ok(());
        }
        let (mut tracer, left) = match self.run.take() {
            Some(run) => run,
            None => self.start_run()?,
        };
        // One by one, so that the sum is the same wherever runs of several samples start and end.
        tracer.advance(1)?;
        if tracer.samples_done() < 1.0 {
            self.run = Some((tracer, left));
            return Ok(());
        }
        self.add(&mut tracer)?;
        self.run = (left > 1).then_some((tracer, left - 1));
        Ok(())
    }

    /// True if every pixel has the same number of samples.
    pub(super) fn is_whole(&self) -> bool {
        self.run.as_ref().is_none_or(|(tracer, _)| tracer.samples_done() == 0.0)
    }

    /// Takes the film so far, and starts a new one at the next sample.
    pub(super) fn take(&mut self) -> Result<Film, RenderError> {
        let film = self.film()?;
        self.first_sample += film.samples;
        self.film = Film::new(film.width, film.height);
        Ok(film)
    }

    /// Takes further samples only in these rectangles. The film must be whole.
    pub(super) fn restrict(&mut self, rects: Vec<Rect>) {
        if let Some((tracer, _)) = &mut self.run {
            tracer.restrict(rects.clone());
        }
        self.active = rects;
    }

    /// Starts the run of the next sample, at its moment.
    fn start_run(&mut self) -> Result<(Tracer, u32), RenderError> {
        let first = self.first_sample + self.film.samples;
        let end = self.settings.first_sample + self.settings.samples;
        let samples = (RUN - first % RUN).min(end - first);
        let moment = self.shutter.moment(self.settings.seed, first);
        let scene = self.animation.lock().unwrap_or_else(PoisonError::into_inner).at(moment)?;
        // Runs are too short to decide on path reuse and to find edges, and a range of samples may cut one.
        let settings = Settings {
            first_sample: first,
            samples,
            light_samples: Some(self.settings.light_samples.unwrap_or(1)),
            indirect_samples: Some(self.settings.indirect_samples.unwrap_or(1)),
            light_paths: self.settings.light_paths.or(Some(default_path_count(self.settings.size))),
            path_reuse: Some(false),
            emitter_edges: Some(false),
            ..self.settings.clone()
        };
        let (mut tracer, backend) = self.renderer.trace(&scene, &settings)?;
        if !self.active.is_empty() {
            tracer.restrict(self.active.clone());
        }
        self.backend = Some(backend);
        Ok((tracer, samples))
    }

    fn add(&mut self, tracer: &mut Tracer) -> Result<(), RenderError> {
        let taken = tracer.take()?;
        self.film.add(&tracer.finish(taken)?).map_err(|error| RenderError::Settings(error.to_string()))
    }

    /// Film so far: of the runs that are done, and of the run that is begun.
    pub(super) fn film(&mut self) -> Result<Film, RenderError> {
        if let Some((mut tracer, left)) = self.run.take().filter(|_| !self.is_whole()) {
            while tracer.samples_done() < 1.0 {
                tracer.advance(1)?;
            }
            self.add(&mut tracer)?;
            self.run = (left > 1).then_some((tracer, left - 1));
        }
        Ok(self.film.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::{RUN, Shutter};
    use pathmarch_scene::Moment;

    const SHUTTER: Shutter = Shutter { opens: Moment { seconds: 2.0, frame: 48 }, seconds: 0.5 };

    #[test]
    fn moments_are_spread_over_the_time() {
        for (seed, block, count) in [(0, 0, 1), (0, 0, 16), (1, 3, 16), (7, 1, 64), (9, 0, 256)] {
            let moments = (block * count..(block + 1) * count).map(|run| SHUTTER.moment(seed, run * RUN));
            let mut parts: Vec<u32> =
                moments.map(|moment| ((moment.seconds - 2.0) / 0.5 * f64::from(count)) as u32).collect();
            parts.sort_unstable();
            assert_eq!(parts, (0..count).collect::<Vec<_>>(), "seed {seed}, block {block}");
        }
        assert_eq!(SHUTTER.moment(3, RUN), SHUTTER.moment(3, 2 * RUN - 1));
        assert_ne!(SHUTTER.moment(3, RUN), SHUTTER.moment(3, 2 * RUN));
        assert_eq!(SHUTTER.moment(3, 4).frame, 48);
    }

    /// Over seeds, moments are uniform, and the moments of two runs are independent of their order.
    #[test]
    fn moments_have_no_order() {
        let seeds = 4000;
        let share = |seed, run: u32| (SHUTTER.moment(seed, run * RUN).seconds - 2.0) / 0.5;
        for run in [0, 1, 5, 63] {
            let mean: f64 = (0..seeds).map(|seed| share(seed, run)).sum::<f64>() / f64::from(seeds);
            assert!((mean - 0.5).abs() < 0.02, "{mean}");
            let below = (0..seeds).filter(|seed| share(*seed, run) < share(*seed, run + 1)).count();
            assert!((below as f64 / f64::from(seeds) - 0.5).abs() < 0.03, "{below}");
        }
    }
}
