//! Input of both backends for one picture.

use crate::integrator::emitter_edges::{self, EmitterEdges};
use crate::integrator::guides::Guide;
use crate::integrator::photons::emission::Emission;
use crate::integrator::photons::path_count_choice::{CPU_LIGHT_RAY_COST, best_path_count, kernel_light_ray_cost};
use crate::integrator::photons::{self, default_path_count};
use crate::integrator::sample_counts_choice::{BestCounts, SampleCounts, best_sample_counts};
use crate::integrator::splitting::camera_ray_index;
use crate::integrator::{moments, packets, path_reuse, path_reuse_choice, splitting_choice};
use crate::mode::Mode;
use crate::preview::{self, Preview};
use crate::ray_stats::RayCounters;
use crate::scene::{FrameUniforms, KernelConfig, LightTree, PhotonMap, RenderScene, TraceContext, finite_bounds};
use crate::settings::Settings;
use crate::views;
use glam::Vec3;
use pathmarch_scene::{Caustics, Scene};
use std::sync::Arc;

/// Smallest number of paths of a picture that gets a kernel of its own on a software adapter: compiling it takes a few tenths
/// of a second.
const MIN_PATHS_FOR_CONSTANTS: f64 = 2e6;

/// Scene, frame, configuration and mode of a picture. Clones share the scene.
#[derive(Clone, Debug)]
pub(crate) struct RenderInput {
    pub(crate) scene: Arc<RenderScene>,
    pub(crate) frame: FrameUniforms,
    pub(crate) config: KernelConfig,
    pub(crate) mode: Mode,
    pub(crate) data: ModeData,
    /// Starts of light paths, with traced caustics.
    pub(crate) emission: Option<Arc<Emission>>,
    /// Number of light paths of each sample, if it is chosen.
    chosen_light_paths: Option<u32>,
    /// Edges of emitters that have further camera rays.
    pub(crate) edges: Option<Arc<EmitterEdges>>,
    /// True to record guides, see [`records_guides`](Self::records_guides).
    wants_guides: bool,
}

/// Data of a mode beyond the scene.
#[derive(Clone, Debug)]
pub(crate) enum ModeData {
    /// Path-traced modes.
    None,
    Preview(Arc<Preview>),
    /// Colours or numbers of a view, see [`views::table`].
    View(Arc<Vec<f32>>),
}

impl RenderInput {
    /// Input of a scene and settings that [`Settings::check`] accepts.
    pub(crate) fn new(scene: &Scene, settings: &Settings) -> Self {
        Self::with_tables(RenderScene::new(scene, settings.camera_of(scene)), scene, settings)
    }

    /// Input with these tables of the scene.
    pub(crate) fn with_tables(render_scene: RenderScene, scene: &Scene, settings: &Settings) -> Self {
        let camera = settings.camera_of(scene);
        let frame = FrameUniforms::new(scene, settings, &render_scene);
        let mut config = KernelConfig::new(&render_scene, settings);
        let traces_caustics = settings.caustics == Caustics::Traced && settings.mode.traces_paths();
        let emission = traces_caustics.then(|| Emission::new(&render_scene, scene, camera)).flatten();
        config.traced_caustics = emission.is_some();
        let data = match settings.mode {
            Mode::Path | Mode::Variance => ModeData::None,
            Mode::Preview => {
                let ctx =
                    TraceContext { scene: &render_scene, frame: &frame, config: &config, stats: None, photons: None };
                ModeData::Preview(Arc::new(Preview::new(scene, &ctx)))
            }
            mode => ModeData::View(Arc::new(views::table(mode, scene, camera))),
        };
        Self {
            scene: Arc::new(render_scene),
            frame,
            config,
            mode: settings.mode,
            data,
            emission: emission.map(Arc::new),
            chosen_light_paths: settings.light_paths,
            edges: None,
            wants_guides: false,
        }
    }

    /// Input that records guides where that is possible.
    pub(crate) fn with_guides(self) -> Self {
        Self { wants_guides: true, ..self }
    }

    /// True if guides are recorded: they are asked for, the picture is path-traced, and camera rays are not shared.
    pub(crate) fn records_guides(&self) -> bool {
        self.wants_guides && self.mode == Mode::Path && self.config.splitting == 1
    }

    /// Sets camera, size, seed, bounces and limits to those of other settings of the same scene. Returns false if other data
    /// depend on the camera, so that a new input is needed.
    pub(crate) fn reframe(&mut self, scene: &Scene, settings: &Settings) -> bool {
        let only_frame_changes = finite_bounds(scene).is_finite() && settings.mode != Mode::Depth;
        if only_frame_changes {
            self.edges = None;
            self.frame = FrameUniforms::new(scene, settings, &self.scene);
        }
        only_frame_changes
    }

    /// Chooses what the settings leave open such that the picture converges soonest on a GPU.
    pub(crate) fn choose_for_gpu(&mut self, settings: &Settings, is_software: bool) {
        // Paths that share a camera ray cannot be resumed on adapters that end loops, see backend/gpu/loop_limit.rs.
        let limited = is_software && self.scene.field.has_loops();
        let samples = settings.whole_samples.unwrap_or(settings.samples);
        self.choose_constants(settings);
        self.choose_emitter_edges(settings, samples);
        let best = self.best_sample_counts(settings, samples, !limited);
        if limited {
            self.config.light_samples = best.light_alone;
        } else {
            if self.config.splitting <= path_reuse::MAX_SPLITTING {
                self.choose_path_reuse(
                    settings,
                    samples,
                    &best,
                    path_reuse_choice::kernel_connection_cost(is_software),
                );
            }
            self.set_sample_counts(&best);
            self.choose_splitting(settings, samples, true);
        }
        self.choose_light_paths(samples, kernel_light_ray_cost(is_software));
    }

    /// Chooses what the settings leave open such that the picture converges soonest on the CPU.
    pub(crate) fn choose_for_cpu(&mut self, settings: &Settings) {
        let samples = settings.whole_samples.unwrap_or(settings.samples);
        self.choose_emitter_edges(settings, samples);
        let best = self.best_sample_counts(settings, samples, false);
        self.choose_path_reuse(settings, samples, &best, path_reuse_choice::cpu_connection_cost(&self.config));
        self.set_sample_counts(&best);
        if !self.config.path_reuse {
            self.choose_splitting(settings, samples, false);
        }
        self.choose_light_paths(samples, CPU_LIGHT_RAY_COST);
    }

    /// Chooses the number of paths that share a camera ray such that the picture converges soonest, unless the settings tell it or
    /// several rays leave first surfaces; `in_lanes` on a GPU.
    fn choose_splitting(&mut self, settings: &Settings, samples: u32, in_lanes: bool) {
        if self.mode == Mode::Path && settings.splitting.is_none() && self.config.indirect_samples == 1 {
            self.config.splitting =
                splitting_choice::best_splitting(&self.scene, &self.frame, &self.config, samples, in_lanes);
        }
    }

    /// True if pixels can share light.
    pub(crate) fn can_reuse_paths(&self, settings: &Settings) -> bool {
        self.mode == Mode::Path
            && settings.crop.is_none()
            && settings.clamp.is_none()
            && path_reuse_choice::is_possible(&self.scene, &self.config)
    }

    /// True if a picture of these settings converges sooner on the CPU where pixels share light, with one sample of a light and of
    /// indirect light at each surface.
    pub(crate) fn path_reuse_pays_on_cpu(&self, settings: &Settings) -> bool {
        let mut input = self.clone();
        let cost = path_reuse_choice::cpu_connection_cost(&self.config);
        input.choose_path_reuse(settings, settings.samples, &BestCounts::one(), cost);
        input.config.path_reuse
    }

    /// Lets pixels share light if the settings ask for it, or if the picture then converges sooner than with several indirect
    /// samples; a connection costs as much as this number of rays.
    pub(crate) fn choose_path_reuse(
        &mut self,
        settings: &Settings,
        samples: u32,
        best: &BestCounts,
        connection_cost: f64,
    ) {
        self.config.path_reuse = self.can_reuse_paths(settings)
            && settings.path_reuse.unwrap_or_else(|| {
                let config = KernelConfig { light_samples: best.light_alone, ..self.config };
                path_reuse_choice::pays(&self.scene, &self.frame, &config, samples, best.error, connection_cost)
            });
    }

    /// Numbers of samples at first surfaces with which the picture converges soonest; `in_lanes` in a kernel that may split.
    fn best_sample_counts(&self, settings: &Settings, samples: u32, in_lanes: bool) -> BestCounts {
        if self.mode != Mode::Path || self.config.media || self.wants_guides {
            return BestCounts::one();
        }
        let best = || {
            let edges = self.edges.as_deref();
            best_sample_counts(&self.scene, &self.frame, &self.config, samples, edges, in_lanes)
        };
        match (settings.light_samples, settings.indirect_samples) {
            (None, None) => best(),
            (light, indirect) => BestCounts::given(SampleCounts {
                light: light.unwrap_or_else(|| best().light_alone),
                indirect: indirect.unwrap_or(1),
            }),
        }
    }

    /// Sets the numbers of samples at first surfaces. One indirect sample is left where pixels share light or paths share camera
    /// rays.
    fn set_sample_counts(&mut self, best: &BestCounts) {
        let may_have_several = !self.config.path_reuse && self.config.splitting == 1;
        let alone = SampleCounts { light: best.light_alone, indirect: 1 };
        let counts = if may_have_several { best.counts } else { alone };
        (self.config.light_samples, self.config.indirect_samples) = (counts.light, counts.indirect);
    }

    /// Traces further camera rays at the edges of emitters if the settings ask for it, or if the picture has enough `samples`
    /// for it to pay.
    fn choose_emitter_edges(&mut self, settings: &Settings, samples: u32) {
        let is_possible = self.mode == Mode::Path && !self.config.media && !self.wants_guides;
        if is_possible && settings.emitter_edges.unwrap_or_else(|| emitter_edges::pay(self.frame.size(), samples)) {
            self.edges = EmitterEdges::new(&self.context(None)).map(Arc::new);
        }
    }

    /// Makes the numbers of the field and of the frame constants of a kernel for a software adapter, if the picture has
    /// enough samples for a kernel of its own.
    fn choose_constants(&mut self, settings: &Settings) {
        let pixels: f64 = self.frame.size().map(f64::from).iter().product();
        self.config.constant_numbers = pixels * f64::from(settings.samples) >= MIN_PATHS_FOR_CONSTANTS;
    }

    /// Context of the picture's rays on the CPU.
    pub(crate) fn context<'a>(&'a self, stats: Option<&'a RayCounters>) -> TraceContext<'a> {
        TraceContext { scene: &self.scene, frame: &self.frame, config: &self.config, stats, photons: None }
    }

    /// Light tree of a picture that traces paths.
    pub(crate) fn light_tree(&self) -> Option<&LightTree> {
        self.scene.light_tree.as_ref().filter(|_| self.mode.traces_paths())
    }

    /// Preview data; `None` in other modes.
    pub(crate) fn preview(&self) -> Option<&Preview> {
        match &self.data {
            ModeData::Preview(preview) => Some(preview),
            ModeData::None | ModeData::View(_) => None,
        }
    }

    /// Photon map of a sample, with traced caustics. Samples that share a camera ray share a map.
    pub(crate) fn photon_map(&self, sample: u32) -> Option<PhotonMap> {
        let index = camera_ray_index(sample, self.config.splitting);
        let (emission, count) = (self.emission.as_ref()?, self.light_paths()?);
        // A caustic is a bounce.
        (self.frame.bounces > 0).then(|| photons::photon_map(&self.context(None), emission, index, count))
    }

    /// Number of light paths of each sample, with traced caustics.
    pub(crate) fn light_paths(&self) -> Option<u32> {
        let count = || self.chosen_light_paths.unwrap_or_else(|| default_path_count(self.frame.size()));
        self.emission.is_some().then(count)
    }

    /// Chooses the number of light paths such that the picture converges soonest, unless the settings tell it. A ray of a light path
    /// costs as much as this number of rays of other paths.
    pub(crate) fn choose_light_paths(&mut self, samples: u32, ray_cost: f64) {
        if let (Some(emission), None, Mode::Path) = (&self.emission, self.chosen_light_paths, self.mode) {
            self.chosen_light_paths = best_path_count(&self.context(None), emission, samples, ray_cost);
        }
    }

    /// Radiance and guides of sample `sample` of each pixel of a path-traced picture without shared camera rays.
    pub(crate) fn sample_with_guides(
        &self,
        ctx: &TraceContext,
        pixels: &[(u32, u32)],
        sample: u32,
    ) -> (Vec<Vec3>, Vec<Guide>) {
        packets::trace_with_guides(ctx, pixels, sample)
    }

    /// Values of `samples` samples of each pixel, from index `first` on, pixel by pixel: radiance, or colours of a view. There
    /// is more than one sample only if they share a camera ray. The context is that of the input, with the photon map of the
    /// samples.
    pub(crate) fn samples_of(&self, ctx: &TraceContext, pixels: &[(u32, u32)], first: u32, samples: u32) -> Vec<Vec3> {
        match &self.data {
            ModeData::None if self.mode == Mode::Variance => moments::moments(ctx, pixels, first),
            ModeData::None => packets::trace(ctx, pixels, first, samples),
            ModeData::Preview(preview) => preview::trace(ctx, preview, pixels, first),
            ModeData::View(table) => views::view(ctx, self.mode, table, pixels, first),
        }
    }
}
