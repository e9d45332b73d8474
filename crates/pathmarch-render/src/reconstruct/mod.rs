//! Reconstruction: a clean picture from few samples of a moving scene.
//!
//! **Idea.** Radiance is divided by the albedo of the guide, so that textures are not blurred; the result is called
//! irradiance here. Direct and `indirect` light are apart. (1) `temporal`: every pixel finds its point in the last picture
//! and continues the mean of the pixels there, if they show the same point; `reflections` does so with the images in glossy
//! surfaces and with light of media; after a change of the scene, `changed_light` suits the past to the new light. (2) `spatial`: neighbours on the same surface are averaged over a footprint that
//! shrinks as the mean gets surer. (3) `antialiasing`: the picture is averaged with the last one, at up to twice the resolution of the samples.
//! (4) `emitters`: lamps that the camera sees are laid over it. (5) Once nothing moves, the plain mean of a film that was
//! started there takes over, and the picture is then that of a still render with the same estimator.
//!
//! Each step is written twice, for the CPU and in WGSL, and tests compare them: `cpu` and `gpu` run the steps.
//!
//! **Source.** Reprojection and edge-stopping filters guided by variance: Schied et al. 2017, "Spatiotemporal
//! Variance-Guided Filtering". Division by the albedo and an à-trous filter: Dammertz et al. 2010, "Edge-Avoiding À-Trous
//! Wavelet Transform for fast Global Illumination Filtering". Here the weights of the filter are symmetric, so that it
//! moves no energy out of highlights; the point in the last picture is validated by its position in space instead of a
//! depth, and pictures of different sizes share their history.
//!
//! **Limits.** What is seen through glass moves with its surface.

mod antialiasing;
mod changed_light;
mod cpu;
mod emitters;
mod film_view;
mod fireflies;
mod gpu;
mod gpu_buffers;
mod gpu_passes;
mod indirect;
mod means;
mod motion;
mod planes;
mod reflections;
mod sequence;
mod spatial;
mod surfaces;
mod temporal;

use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::integrator::guides::{FILM_SAMPLES, Guide};
use crate::job::tracer::Tracer;
use crate::output::tonemap::Display;
use crate::scene::light;
use crate::wgsl::shared_constants;
use cpu::CpuReconstruction;
use film_view::FilmView;
use glam::Vec3;
use gpu::GpuReconstruction;
pub use sequence::{Frame, Sequence};

pub(crate) use antialiasing::catmull_rom;
pub(crate) use motion::{EarlierPoint, EarlierPoints, Motion};
pub(crate) use temporal::Projection;

shared_constants! {
    /// Samples of a still film from which on its own noise decides its weight in each pixel.
    const SETTLING_SAMPLES: f32 = 32.0;
    /// Relative standard error of a still film that is hidden by reconstruction.
    const VISIBLE_NOISE: f32 = 0.1;
    /// Half the side of the square in which the errors of picture and film are compared, pixels.
    const BIAS_RADIUS: i32 = 2;
    /// Least variance of a pixel of the film, in its own variance.
    const OWN_VARIANCE: f32 = 0.5;
    /// Least variance of the light without that of facets, in that of all light.
    const LEAST_BASE_VARIANCE: f32 = 0.1;
    /// Longest history of an unchanged scene, samples.
    const MAX_HISTORY: f32 = 24.0;
    /// Largest irradiance whose square is a number.
    const MAX_IRRADIANCE: f32 = 1e15;
    /// Pixels of motion at which its colour is full.
    const FULL_MOTION: f32 = 32.0;
    /// Index of the picture among the buffers.
    const SHOWS_PICTURE: u32 = Buffer::Picture as u32;
    /// Index of the history length among the buffers.
    const SHOWS_HISTORY_LENGTH: u32 = Buffer::HistoryLength as u32;
    /// Index of the relative deviation among the buffers.
    const SHOWS_DEVIATION: u32 = Buffer::Deviation as u32;
}

/// Longest history after a change of the scene, samples. It is also clamped to the new light around each pixel.
const MAX_HISTORY_OF_CHANGED_SCENE: f32 = 6.0;

/// Stages of reconstruction, and the buffer that is shown. The default has all stages and shows the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReconstructOptions {
    /// Continues the means of the last picture.
    pub reprojection: bool,
    /// Spreads the energy of samples that are far brighter than their neighbours.
    pub firefly_filter: bool,
    /// Averages neighbours on the same surface.
    pub spatial_filter: bool,
    /// Finds the edges of emitters by further camera rays.
    pub emitter_edges: bool,
    /// Averages textures over pixels.
    pub texture_filter: bool,
    /// Averages the picture with the last one.
    pub antialiasing: bool,
    /// Shows moving pictures at up to twice the resolution of their samples; needs `antialiasing`.
    pub upscaling: bool,
    /// Buffer to show.
    pub buffer: Buffer,
}

impl Default for ReconstructOptions {
    fn default() -> Self {
        Self {
            reprojection: true,
            firefly_filter: true,
            spatial_filter: true,
            emitter_edges: true,
            texture_filter: true,
            antialiasing: true,
            upscaling: true,
            buffer: Buffer::Picture,
        }
    }
}

/// Buffer of reconstruction that can be shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Buffer {
    /// The picture itself.
    #[default]
    Picture,
    /// Motion since the last picture: red to the right and green downwards, both half without motion and full at 32
    /// pixels; blue where a point was hidden.
    Motion,
    /// Number of samples in the mean of each pixel, from black to white at 24.
    HistoryLength,
    /// Standard deviation of the mean, divided by the mean.
    Deviation,
}

impl Buffer {
    /// All buffers.
    pub const ALL: [Self; 4] = [Self::Picture, Self::Motion, Self::HistoryLength, Self::Deviation];

    /// Name, as windows show it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Picture => "picture",
            Self::Motion => "motion",
            Self::HistoryLength => "history length",
            Self::Deviation => "relative deviation",
        }
    }
}

/// True if a film has enough samples for [`settled_weight`].
fn settles(samples: u32) -> bool {
    samples >= 4
}

/// Changes since the last film.
#[derive(Clone, Copy, Debug, Default)]
struct Changes {
    /// Longest history, samples.
    max_history: f32,
    /// True if the scene has changed since the last film.
    scene: bool,
}

impl Changes {
    /// Changes at the start of another film; `has_past` if there was one.
    fn start_film(&mut self, has_past: bool, scene_changed: bool) {
        if has_past {
            *self = Self { max_history: MAX_HISTORY, scene: false };
        }
        if scene_changed {
            *self = Self { max_history: MAX_HISTORY_OF_CHANGED_SCENE, scene: true };
        }
    }
}

/// Reconstruction on the backend of its tracer.
#[derive(Default)]
pub(crate) struct Reconstruction {
    cpu: CpuReconstruction,
    gpu: Option<GpuReconstruction>,
    /// True if GPUs time the passes.
    times_passes: bool,
}

impl Reconstruction {
    /// Starts another film: of another view, size or moment, or of a changed scene.
    pub(crate) fn start_film(&mut self, scene_changed: bool) {
        self.cpu.start_film(scene_changed);
        if let Some(gpu) = &mut self.gpu {
            gpu.start_film(scene_changed);
        }
    }

    /// Reconstructs the film of a tracer, whose means have this weight in the picture, and tone-maps it: red, green, blue
    /// and 255 for each pixel. `size` is that of the picture. `None` if the tracer has no guides, or the GPU no memory.
    pub(crate) fn show(
        &mut self,
        tracer: &mut Tracer,
        input: &RenderInput,
        film_weight: f32,
        size: [u32; 2],
        options: &ReconstructOptions,
        display: &Display,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        match tracer {
            Tracer::Cpu(job) => {
                let Some(guides) = job.guides() else { return Ok(None) };
                let (means, samples) = (job.means(), job.samples_done() as u32);
                let first_sample = job.first_sample();
                let film =
                    FilmView { input, guides: &guides, means: &means, samples, first_sample, weight: film_weight };
                let picture = self.cpu.picture(&film, size, options);
                let buffer = self.cpu.buffer(options.buffer, size);
                Ok(Some(buffer.unwrap_or_else(|| display.encode_rgba(&picture))))
            }
            Tracer::Gpu(job) => {
                // A lens blurs textures.
                let averages_textures = options.texture_filter && input.frame.lens_radius == 0.0;
                let Some(film) = job.reconstructed_film(size, [options.emitter_edges, averages_textures])? else {
                    return Ok(None);
                };
                if self.gpu.as_ref().is_none_or(|gpu| !gpu.is_on(film.device)) {
                    let mut gpu = GpuReconstruction::new(film.device)?;
                    if self.times_passes {
                        gpu.time_passes()?;
                    }
                    self.gpu = Some(gpu);
                }
                let Some(gpu) = &mut self.gpu else { return Ok(None) };
                gpu.show(&film, input, film_weight, size, options, display)
            }
        }
    }
}

impl Reconstruction {
    /// Reconstructs the film of a tracer, as [`show`](Self::show) does: a linear picture. `means` are those of the film.
    fn picture(
        &mut self,
        tracer: &mut Tracer,
        input: &RenderInput,
        means: &[Vec3],
        size: [u32; 2],
        options: &ReconstructOptions,
    ) -> Result<Option<Vec<Vec3>>, RenderError> {
        let weight = film_weight(tracer.samples_done() as u32, u32::MAX);
        if let Tracer::Cpu(job) = tracer {
            let Some(guides) = job.guides() else { return Ok(None) };
            let (samples, first_sample) = (job.samples_done() as u32, job.first_sample());
            let film = FilmView { input, guides: &guides, means, samples, first_sample, weight };
            return Ok(Some(self.cpu.picture(&film, size, options)));
        }
        let shown = self.show(tracer, input, weight, size, options, &Display::default())?;
        let Some(gpu) = self.gpu.as_ref().filter(|_| shown.is_some()) else { return Ok(None) };
        gpu.colours().map(Some)
    }

    /// Times of the passes of the last picture; empty on GPUs without timestamps.
    fn passes(&self, tracer: &Tracer) -> Vec<PassTime> {
        match tracer {
            Tracer::Cpu(_) => self.cpu.passes.clone(),
            Tracer::Gpu(_) => self.gpu.as_ref().map(|gpu| gpu.passes_done.clone()).unwrap_or_default(),
        }
    }

    /// Histories of all pixels of the last picture.
    fn histories(&self, tracer: &Tracer) -> Result<Vec<PixelHistory>, RenderError> {
        match (tracer, &self.gpu) {
            (Tracer::Cpu(_), _) => Ok(self.cpu.histories()),
            (Tracer::Gpu(_), Some(gpu)) => gpu.histories(),
            (Tracer::Gpu(_), None) => Ok(Vec::new()),
        }
    }
}

/// Time of a pass of reconstruction.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name, in plain words.
    pub name: &'static str,
    /// Time on the processor that runs it, seconds.
    pub seconds: f64,
}

/// History of a pixel.
struct PixelHistory {
    /// Position in the last picture of what is in the middle of the pixel, pixels of its samples; `None` where it was hidden.
    before: Option<[f32; 2]>,
    /// Number of samples in the mean.
    length: f32,
}

/// Position of the point of each pixel in the last picture, relative to the pixel: columns, rows, and 1 where that picture
/// shows the point, else 0. The pictures have these sizes.
fn motions(histories: &[PixelHistory], size: [u32; 2], last_size: [u32; 2]) -> Vec<[f32; 3]> {
    let scale: [f32; 2] = std::array::from_fn(|k| size[k] as f32 / last_size[k] as f32);
    let of = |(index, history): (usize, &PixelHistory)| {
        let Some([x, y]) = history.before else { return [0.0; 3] };
        let (column, row) = (index % size[0] as usize, index / size[0] as usize);
        [x * scale[0] - column as f32 - 0.5, y * scale[1] - row as f32 - 0.5, 1.0]
    };
    histories.iter().enumerate().map(of).collect()
}

/// Weight of a still film of `samples` samples, of which `target` are wanted.
pub(crate) fn film_weight(samples: u32, target: u32) -> f32 {
    if samples >= target.min(FILM_SAMPLES) {
        return 1.0;
    }
    let done = samples.saturating_sub(1) as f32 / (FILM_SAMPLES - 1) as f32;
    // Noise falls with the root of the samples only: the film may take over late.
    done * done
}

/// Size of a moving picture of samples of size `traced`: up to twice that, but not above `full`.
pub(crate) fn upscaled_size(traced: [u32; 2], full: [u32; 2]) -> [u32; 2] {
    std::array::from_fn(|k| (2 * traced[k]).min(full[k]).max(traced[k]))
}

/// Variance of a mean of `samples` samples in a pixel with this mean luminance of the irradiance.
fn film_variance(guide: &Guide, irradiance: f32, samples: f32) -> f32 {
    (guide.square - irradiance * irradiance).max(0.0) / samples
}

/// Variance of the luminance of samples without the light of facets, if `direct` is the mean of the direct light. Both are
/// taken for independent. It is that of all other light, so that it is rather too large for the direct one.
fn variance_without_facets(guide: &Guide, direct: f32) -> f32 {
    let [all, of_facets] = [guide.divisor(), guide.reflection_divisor()];
    let mean = direct + luminance((guide.indirect + guide.reflected.radiance) / all);
    let variance = (guide.square - mean * mean).max(0.0);
    if !guide.has_layer() {
        return variance;
    }
    let unit = luminance(of_facets / all);
    let mean_of_facets = luminance(guide.reflected.radiance / of_facets);
    let variance_of_facets = (guide.reflected.square - mean_of_facets * mean_of_facets).max(0.0) * unit * unit;
    (variance - variance_of_facets).max(LEAST_BASE_VARIANCE * variance)
}

/// Weight of a film of `samples` samples in a pixel with this mean luminance of the irradiance and its variance, from its own
/// noise: near 1 once that cannot be seen. Nothing but the film shows edges as they are.
fn settled_weight(guide: &Guide, [irradiance, variance]: [f32; 2], samples: f32) -> f32 {
    let visible = variance.sqrt() / (VISIBLE_NOISE * irradiance.max(1e-4));
    let clean = (1.0 - visible).max(0.0);
    let settled = if guide.is_mixed { 1.0 } else { clean * clean };
    settled * (samples / SETTLING_SAMPLES).min(1.0)
}

/// Irradiance of the direct light of a mean of the film; 0 if it is not finite, as for rejected samples.
fn direct_irradiance(mean: Vec3, guide: &Guide) -> Vec3 {
    let irradiance = (mean - guide.reflected.radiance - guide.indirect).max(Vec3::ZERO) / guide.divisor();
    if irradiance.is_finite() { irradiance.min(Vec3::splat(MAX_IRRADIANCE)) } else { Vec3::ZERO }
}

/// Luminance of a linear Rec. 709 colour.
fn luminance(colour: Vec3) -> f32 {
    light::luminance(colour.into())
}
