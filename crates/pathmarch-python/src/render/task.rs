//! A picture to render, without Python.

use crate::failure::Failure;
use crate::interruptible::Watcher;
use crate::renderers;
use pathmarch_render::aov::{self, Layer};
use pathmarch_render::denoise::{Denoiser, Features, HalfBuffers};
use pathmarch_render::film::Film;
use pathmarch_render::image::{ChannelValues, Picture};
use pathmarch_render::parts::{FilmPart, SampleRecorder};
use pathmarch_render::pathmarch_scene::{Animation, Scene};
use pathmarch_render::{Backend, BackendInfo, Job, RenderError, Settings, Shutter};
use std::sync::{Arc, Mutex};

/// A picture to render.
pub struct Task {
    pub animation: Arc<Mutex<Animation>>,
    /// The animation at the moment at which the shutter opens.
    pub scene: Arc<Scene>,
    pub settings: Settings,
    pub shutter: Shutter,
    pub backend: Backend,
    /// Part of the name of a GPU adapter.
    pub adapter: Option<String>,
    pub layers: Vec<Layer>,
    pub denoiser: Option<Denoiser>,
}

/// A rendered picture.
pub struct Rendered {
    pub picture: Picture,
    /// The picture before it was denoised.
    pub noisy: Option<Picture>,
    /// Channels of each layer.
    pub layers: Vec<(Layer, Vec<ChannelValues>)>,
    /// Samples of each pixel.
    pub samples: u32,
    pub backend: BackendInfo,
    /// False if the callback has ended it before all samples were done.
    pub complete: bool,
}

/// Result of the work.
pub type Outcome = Result<Rendered, Failure>;

impl Task {
    /// Renders until all samples are done, or the watcher stops the work.
    ///
    /// # Errors
    /// [`Failure`]: a backend that fails, too little memory, or an animation that is no scene while the shutter is
    /// open.
    pub fn run(&self, watcher: &Watcher<Outcome>) -> Outcome {
        let rendered = self.rendered(watcher);
        if let Err(Failure::Render(_)) = &rendered {
            renderers::forget();
        }
        rendered
    }

    fn rendered(&self, watcher: &Watcher<Outcome>) -> Outcome {
        self.check_memory()?;
        let renderer = renderers::renderer(self.backend, self.adapter.clone())?;
        let mut job = renderer.start_motion_blur(&self.animation, &self.scene, &self.settings, self.shutter)?;
        match self.denoiser {
            None => self.samples(&mut job, watcher),
            Some(denoiser) => self.denoised(&mut job, denoiser, watcher),
        }
    }

    fn samples(&self, job: &mut Job, watcher: &Watcher<Outcome>) -> Outcome {
        let mut part = FilmPart::new(self.settings.rect());
        record(job, &mut part, watcher)?;
        self.finished(job, &part.film())
    }

    fn denoised(&self, job: &mut Job, denoiser: Denoiser, watcher: &Watcher<Outcome>) -> Outcome {
        let mut halves = HalfBuffers::new(&self.settings);
        record(job, &mut halves, watcher)?;
        let rendered = self.finished(job, &halves.film())?;
        if !rendered.complete {
            return Ok(rendered);
        }
        let (animation, scene, settings) = (&self.animation, &self.scene, &self.settings);
        let features = Features::trace_motion_blur(animation, scene, settings, self.shutter, halves.samples())?;
        let picture = denoiser.denoise(&halves, &features).map_err(|error| Failure::Render(error.to_string()))?;
        Ok(Rendered { picture, noisy: Some(rendered.picture), ..rendered })
    }

    /// The picture of a film, with its layers if it is complete.
    fn finished(&self, job: &Job, film: &Film) -> Outcome {
        let complete = film.samples >= self.settings.samples;
        let layers = if complete { self.layers(film)? } else { Vec::new() };
        let (picture, backend) = (self.settings.mode.picture(film), job.backend().clone());
        Ok(Rendered { picture, noisy: None, layers, samples: film.samples, backend, complete })
    }

    fn layers(&self, film: &Film) -> Result<Vec<(Layer, Vec<ChannelValues>)>, Failure> {
        if self.layers.is_empty() {
            return Ok(Vec::new());
        }
        let aovs = aov::render(&self.scene, &self.settings)?;
        let values = |layer: Layer| layer.channels(&aovs, film).into_iter().map(|channel| channel.values).collect();
        Ok(self.layers.iter().map(|&layer| (layer, values(layer))).collect())
    }

    /// Fails if there is no memory for the films, instead of ending the process when it is needed.
    fn check_memory(&self) -> Result<(), Failure> {
        /// Bytes of a pixel: sums of blocks, of a block and of the picture, and the arrays.
        const PIXEL: usize = 49 + 6 * 12;
        let films = if self.denoiser.is_some() { 2 } else { 1 };
        let bytes = self.settings.rect().pixels().saturating_mul(PIXEL * films);
        let [width, height] = self.settings.size;
        Vec::<u8>::new()
            .try_reserve_exact(bytes)
            .map_err(|_| Failure::Memory(format!("a picture of {width}x{height} needs {} MB of memory", bytes >> 20)))
    }
}

fn record(job: &mut Job, recorder: &mut impl SampleRecorder, watcher: &Watcher<Outcome>) -> Result<(), RenderError> {
    job.record(recorder, |_| watcher.is_stopped(), |done| watcher.report(done))
}
