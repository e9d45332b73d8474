//! Start of a request: reuse of the last one's scene and kernel, and levels of the picture's size.

use super::{Engine, RenderRequest};
use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::error::RenderError;
use crate::job::tracer::Tracer;
use crate::live::shared::lock;
use crate::mode::Mode;
use crate::preview_steps::PreviewSteps;
use crate::reconstruct::Reconstruction;
use crate::scene::RenderScene;
use crate::settings::Settings;
use pathmarch_scene::Camera;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time within which a kernel must be compiled to be waited for; else the CPU starts to render.
const COMPILE_WAIT: Duration = Duration::from_millis(30);

/// Size of a picture with as many paths as the probe for path reuse, pixels.
const PROBE_PIXELS: [u32; 2] = [256, 256];
/// Longest time of that probe, seconds.
const MAX_PROBE_SECONDS: f64 = 0.25;

/// Settings without those of the view, the size and the samples.
fn without_view(settings: &Settings) -> Settings {
    Settings { size: [1, 1], samples: 1, seed: 0, camera: 0, viewpoint: None, ..settings.clone() }
}

/// True if both settings show the same light, perhaps from another viewpoint.
fn same_light(a: &Settings, b: &Settings) -> bool {
    without_view(a) == without_view(b)
}

/// True if both settings have one kernel, and only the view, the size or a limit differs.
fn same_kernel(a: &Settings, b: &Settings) -> bool {
    let rest = |settings| Settings {
        bounces: 0,
        clamp: None,
        detail: 1.0,
        preview_steps: PreviewSteps::default(),
        ..without_view(settings)
    };
    rest(a) == rest(b)
}

/// True if only the number of samples and the exposure differ.
fn same_picture(a: &Settings, b: &Settings) -> bool {
    let rest = |settings: &Settings| {
        let viewpoint = settings.viewpoint.clone();
        let viewpoint = viewpoint.map(|camera| Camera { exposure: 0.0, auto_exposure: false, ..camera });
        Settings { samples: 1, viewpoint, ..settings.clone() }
    };
    rest(a) == rest(b)
}

/// True if pictures of a request are reconstructed.
fn is_reconstructed(request: &RenderRequest) -> bool {
    request.reconstruct.is_some() && request.settings.mode == Mode::Path
}

/// Input of a request with these settings.
fn input_of(request: &RenderRequest, settings: &Settings) -> RenderInput {
    let scene = &request.scene;
    let mut tables = RenderScene::new(scene, settings.camera_of(scene));
    if request.moving {
        tables.field = tables.field.with_coarse_grids();
    }
    let input = RenderInput::with_tables(tables, scene, settings);
    if is_reconstructed(request) { input.with_guides() } else { input }
}

impl Engine {
    /// Starts to render a request.
    pub(super) fn start_request(&mut self, number: u64, request: RenderRequest) -> Result<(), RenderError> {
        if let Err(error) = request.settings.check(&request.scene) {
            self.request = Some((number, request));
            self.fail(error.to_string());
            return Ok(());
        }
        lock(&self.shared.status).error = None;
        let old = self.request.replace((number, request.clone()));
        let old = old.map(|(_, old)| old).filter(|_| self.input.is_some() && self.tracer.is_some());
        let (same_scene, same_picture) = old.as_ref().map_or((false, false), |old| {
            let scene = Arc::ptr_eq(&old.scene, &request.scene) && same_kernel(&old.settings, &request.settings);
            // Moving pictures have seeds of their own.
            let same_seed = old.moving == request.moving && is_reconstructed(old) == is_reconstructed(&request);
            (scene, scene && same_seed && same_picture(&old.settings, &request.settings))
        });
        self.scene_changed |= old.as_ref().is_some_and(|old| {
            !Arc::ptr_eq(&old.scene, &request.scene) || !same_light(&old.settings, &request.settings)
        });
        if same_picture {
            // Only the number of samples or the display has changed.
            let differs = |old: &RenderRequest| {
                let shown = |request: &RenderRequest| (request.display, request.auto_exposure, request.reconstruct);
                shown(old) != shown(&request)
            };
            if old.as_ref().is_some_and(differs) && self.published_at.is_some() {
                self.publish()?;
            }
            return Ok(());
        }
        if self.first_image_since.is_some()
            && let Some(tracer) = &self.tracer
        {
            // The last request was too slow; its pace decides the size of the next one.
            let done = tracer.samples_done();
            self.update_pace(done);
            self.skipped_requests += 1;
        }
        self.level = self.first_level(&request);
        self.first_image_since = Some(Instant::now());
        let settings = self.level_settings(&request);
        // A tracer either records guides or does not.
        let same_guides = old.as_ref().is_none_or(|old| is_reconstructed(old) == is_reconstructed(&request));
        // What was in motion may be too coarse for a picture at rest.
        let is_fine = |input: &RenderInput| request.moving || !input.scene.field.has_coarse_grids();
        let reframed = same_scene
            && same_guides
            && self.input.as_ref().is_some_and(is_fine)
            && self.input.as_mut().is_some_and(|input| input.reframe(&request.scene, &settings));
        if reframed {
            return self.start_level();
        }
        self.input = Some(input_of(&request, &settings));
        self.gpu.start_scene();
        self.compile();
        // Most kernels are ready at once; the picture is then not rendered twice.
        self.gpu.wait_for_kernel(COMPILE_WAIT, &self.shared);
        self.tracer = None;
        self.start_level()
    }

    /// Size of a request's first picture.
    fn first_level(&self, request: &RenderRequest) -> [u32; 2] {
        let time = if request.moving { request.frame_time } else { request.frame_time.max(Duration::from_millis(60)) };
        let level = self.pace().size_within(request.settings.size, time);
        if request.moving {
            level
        } else {
            self.pace().next_level(level.map(|side| side.div_ceil(2)), request.settings.size)
        }
    }

    /// Settings of the present level.
    fn level_settings(&self, request: &RenderRequest) -> Settings {
        let mut settings = Settings { size: self.level, ..request.settings.clone() };
        if request.moving && is_reconstructed(request) {
            // Pictures that are averaged need random numbers of their own, also beside the one at rest that follows.
            settings.seed = settings.seed.wrapping_add(0x9e37_79b9);
            settings.first_sample = self.next_moving_sample;
        }
        settings
    }

    /// True if pixels of a request share light. They do not in motion, where reconstruction hides the same noise for less, nor on
    /// GPUs, where that would be another kernel.
    fn reuses_paths(&self, request: &RenderRequest) -> bool {
        let pays = || self.path_reuse.as_ref().is_some_and(|(scene, pays)| *pays && Arc::ptr_eq(scene, &request.scene));
        let is_possible = |input: &RenderInput| input.can_reuse_paths(&request.settings);
        !request.moving
            && self.is_left_to_cpu()
            && self.input.as_ref().is_some_and(is_possible)
            && request.settings.path_reuse.unwrap_or_else(pays)
    }

    /// True if no GPU is used or will be soon.
    fn is_left_to_cpu(&self) -> bool {
        matches!(self.tracer, None | Some(Tracer::Cpu(_))) && !self.gpu.is_compiling() && !self.gpu.has_kernel()
    }

    /// Chooses whether pixels of the scene of a request share light at rest, if that does not take long. Returns true if they now
    /// do and did not before.
    pub(super) fn choose_path_reuse(&mut self, request: &RenderRequest) -> bool {
        let is_chosen = self.path_reuse.as_ref().is_some_and(|(scene, _)| Arc::ptr_eq(scene, &request.scene));
        if is_chosen || request.settings.path_reuse.is_some() || !self.is_left_to_cpu() {
            return false;
        }
        let Some(input) = &self.input else { return false };
        let is_short = self.cpu_pace.seconds(PROBE_PIXELS) <= MAX_PROBE_SECONDS;
        let pays = is_short && input.path_reuse_pays_on_cpu(&request.settings);
        self.path_reuse = Some((request.scene.clone(), pays));
        pays
    }

    /// Starts to compile the scene's kernel, if the GPU needs it.
    pub(super) fn compile(&mut self) {
        if let Some(mut input) = self.input.clone() {
            input.config.path_reuse = false;
            self.gpu.compile(&input, &self.shared);
        }
    }

    /// Takes a kernel that is ready, and moves the picture from the CPU to the GPU.
    pub(super) fn poll_kernel(&mut self) -> Result<(), RenderError> {
        if !self.gpu.poll_kernel(&self.shared) {
            return Ok(());
        }
        // The scene may have changed during the compilation.
        self.compile();
        if self.gpu.has_kernel() && !matches!(self.tracer, Some(Tracer::Gpu(_))) {
            self.tracer = None;
            let Some((_, request)) = self.request.clone() else { return Ok(()) };
            self.level = self.first_level(&request);
            return self.start_level();
        }
        Ok(())
    }

    /// Starts the picture of the present level.
    pub(super) fn start_level(&mut self) -> Result<(), RenderError> {
        let begun = self.tracer.as_ref().map_or(1.0, |tracer| tracer.samples_done().ceil().max(1.0));
        self.next_moving_sample = self.next_moving_sample.wrapping_add(begun as u32);
        let Some((_, request)) = &self.request else { return Ok(()) };
        let settings = self.level_settings(request);
        let reuses_paths = self.reuses_paths(request);
        let Some(input) = &mut self.input else { return Ok(()) };
        if [input.frame.width, input.frame.height] != self.level && !input.reframe(&request.scene, &settings) {
            *input = input_of(request, &settings);
            self.tracer = None;
        }
        if input.config.path_reuse != reuses_paths {
            input.config.path_reuse = reuses_paths;
            self.tracer = None;
        }
        let reframed = match &mut self.tracer {
            Some(tracer) => tracer.reframe(input, settings.first_sample)?,
            None => false,
        };
        let first = settings.first_sample;
        self.first_sample = first;
        if !reframed && let Some(input) = &self.input {
            let cpu = || Tracer::Cpu(Box::new(CpuJob::new(input.clone(), first)));
            let tracer = match self.gpu.tracer(input, first) {
                Some(Err(error @ RenderError::TooLarge { .. })) => {
                    self.gpu.refuse(&error, &self.shared);
                    cpu()
                }
                Some(tracer) => tracer?,
                None => cpu(),
            };
            self.tracer = Some(tracer);
        }
        if is_reconstructed(request) {
            self.reconstruction.start_film(std::mem::take(&mut self.scene_changed));
        } else {
            self.reconstruction = Reconstruction::default();
        }
        self.last_measurement = (0.0, Instant::now());
        self.published_samples = 0.0;
        self.metered_samples = 0.0;
        Ok(())
    }
}
