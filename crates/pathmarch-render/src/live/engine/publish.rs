//! Results of the renderer's thread: pictures, films and the status.

use super::{Engine, LiveImage, MIN_PUBLISH_RATIO, PUBLISH_INTERVAL, Status};
use crate::error::RenderError;
use crate::job::tracer::Tracer;
use crate::live::shared::{FilmReply, lock};
use crate::output::exposure::suitable_stops;
use crate::output::tonemap::Display;
use crate::reconstruct::{self, Buffer, upscaled_size};
use crate::settings::Settings;
use std::sync::Arc;
use std::time::Instant;

/// Share of the way to the suitable exposure that a moving picture goes at once.
const ADAPTATION: f32 = 0.25;

impl Engine {
    /// True if a picture with `done` of `target` samples is to be published: the first, the last, and some between.
    pub(super) fn is_due(&self, done: f64, target: u32) -> bool {
        let is_first = self.published_samples < 1.0 && done >= 1.0;
        let interval = PUBLISH_INTERVAL.max(MIN_PUBLISH_RATIO * self.reconstruction_time);
        let is_better =
            done >= 1.0 && self.published_at.is_none_or(|at| at.elapsed() >= interval) && done > self.published_samples;
        let is_last = done >= f64::from(target) && done > self.published_samples;
        is_first || is_better || is_last
    }

    /// Publishes the picture so far.
    pub(super) fn publish(&mut self) -> Result<(), RenderError> {
        let display = self.display()?;
        let (Some((number, request)), Some(tracer)) = (&self.request, &mut self.tracer) else { return Ok(()) };
        let samples = tracer.samples_done();
        // Only a picture at rest has a last sample; until then, and at smaller sizes, there is always more to come.
        let rests = !request.moving && self.level == request.settings.size;
        let target = if rests { request.settings.samples } else { u32::MAX };
        let weight = reconstruct::film_weight(samples as u32, target);
        let mut size = self.level;
        let mut codes = None;
        if let (Some(options), Some(input)) = (request.reconstruct, &self.input)
            && (weight < 1.0 || options.buffer != Buffer::Picture)
        {
            let began = Instant::now();
            let shown = if options.upscaling { upscaled_size(size, request.settings.size) } else { size };
            codes = self.reconstruction.show(tracer, input, weight, shown, &options, &display)?;
            if codes.is_some() {
                (size, self.reconstruction_time) = (shown, began.elapsed());
            }
        }
        let codes = match codes {
            Some(codes) => codes,
            None => tracer.show(&display, request.settings.mode)?,
        };
        // Nobody takes the picture for a finished one, or for one of another backend, because of an older status.
        self.update_status();
        let now = Instant::now();
        self.serial += 1;
        let exposure_stops = display.exposure_stops;
        let image = LiveImage { size, codes, exposure_stops, samples, request: *number, serial: self.serial, at: now };
        *lock(&self.shared.picture) = Some(Arc::new(image));
        self.published_at = Some(now);
        self.published_samples = samples;
        self.update_status();
        (self.shared.notify)();
        Ok(())
    }

    /// Tone curve and exposure of the next picture. An automatic exposure is measured each time the samples have doubled, and for
    /// the last one.
    fn display(&mut self) -> Result<Display, RenderError> {
        let (Some((_, request)), Some(tracer)) = (&self.request, &mut self.tracer) else {
            return Ok(Display::default());
        };
        if !request.auto_exposure {
            self.metered_stops = None;
            return Ok(request.display);
        }
        let samples = tracer.samples_done();
        let is_first = self.metered_samples == 0.0;
        let is_last = self.level == request.settings.size && samples >= f64::from(request.settings.samples);
        if tracer.is_whole() && (is_first || is_last || samples >= 2.0 * self.metered_samples) {
            let film = tracer.film()?;
            self.metered_samples = f64::from(film.samples);
            if let Some(stops) = suitable_stops(&film) {
                let follows = self.metered_stops.filter(|_| request.moving);
                self.metered_stops = Some(follows.map_or(stops, |last| last + ADAPTATION * (stops - last)));
            }
        }
        Ok(Display { exposure_stops: self.metered_stops.unwrap_or(0.0), ..request.display })
    }

    /// Film of the full-size picture, and its settings.
    pub(super) fn film(&mut self) -> FilmReply {
        let Some((_, request)) = self.request.clone() else { return Err("there is no picture yet".to_owned()) };
        let Some(tracer) = &mut self.tracer else { return Err("there is no picture yet".to_owned()) };
        if self.level != request.settings.size {
            return Err("the picture is not rendered at its full size yet".to_owned());
        }
        let film = tracer.film().map_err(|error| error.to_string())?;
        if film.samples == 0 {
            return Err("no sample of the picture is done yet".to_owned());
        }
        // A moving picture has a seed and samples of its own.
        let seed = self.input.as_ref().map_or(request.settings.seed, |input| input.frame.seed);
        // What was chosen is part of what the picture is.
        let path_reuse = if self.shares_light() { Some(true) } else { request.settings.path_reuse };
        let first_sample = self.first_sample;
        let settings = Settings { samples: film.samples, seed, first_sample, path_reuse, ..request.settings };
        Ok((film, settings))
    }

    /// Updates the status; calls the owner when the picture is finished or rendering resumes.
    pub(super) fn update_status(&self) {
        let mut status = lock(&self.shared.status);
        let full_size = self.request.as_ref().map(|(_, request)| request.settings.size);
        let Status { backend, adapter, samples, samples_per_second, compiling, resting, notice, .. } = &mut *status;
        match (&self.tracer, self.gpu.device()) {
            (Some(Tracer::Gpu(_)), Some(device)) => {
                backend.clone_from(&device.description.backend);
                adapter.clone_from(&device.description.name);
                *notice = None;
            }
            (Some(_), _) => {
                "CPU".clone_into(backend);
                *adapter = format!("{} threads", rayon::current_num_threads());
            }
            (None, _) => {}
        }
        *samples = match &self.tracer {
            Some(tracer) if full_size == Some(self.level) => tracer.samples_done(),
            _ => 0.0,
        };
        let pace = if self.shares_light() { &self.sharing_pace } else { self.pace() };
        *samples_per_second = full_size.map_or(0.0, |size| 1.0 / pace.seconds(size));
        *compiling = self.gpu.is_compiling();
        let was_resting = std::mem::replace(resting, self.tracer.is_some() && !self.has_work());
        let changed = was_resting != *resting;
        drop(status);
        if changed {
            (self.shared.notify)();
        }
    }
}
