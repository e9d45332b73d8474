//! Reconstruction on the GPU: the passes of the `.wgsl` files of this folder, within the default limits of WebGPU.
//!
//! **Idea.** Every pass is a kernel over pixels. A pass reads what the one before wrote; guides, histories and pictures are
//! there twice, for the present film and for the one before. All of it stays on the device; the picture comes back as four
//! bytes a pixel.
//!
//! **Cost.** 344 bytes of memory for each pixel, those of the tracer's guides included; 440 in scenes with glossy surfaces. A film whose buffers the device cannot allocate is not reconstructed.

use super::motion::{self, LeafMotion, Motion};
use super::spatial::STEPS;
use super::temporal::camera_moves;
use super::{
    Changes, PassTime, PixelHistory, ReconstructOptions, antialiasing, fireflies, reflections, settles, spatial,
    temporal,
};
use crate::backend::RenderInput;
use crate::backend::gpu::shaders::{ShaderFile, shader_files, with_imports};
use crate::backend::gpu::{Device, GpuContext, GpuTimer, ReconstructedFilm};
use crate::error::RenderError;
use crate::output::tonemap::{self, Display};
use crate::scene::material::{DELTA, GLOSSY};
use crate::scene::{FrameUniforms, RenderScene};
use crate::wgsl::{declaration, shared_struct};
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::wgsl::Program;
use std::sync::Arc;
use std::time::Duration;

shared_struct! {
    /// Uniforms of all passes: both frames, the film and the options.
    pub(crate) struct PassUniforms as PassUniforms {
        position: [f32; 3],
        width: u32,
        right: [f32; 3],
        height: u32,
        up: [f32; 3],
        /// Side of a pixel at distance one, metres.
        pixel: f32,
        forward: [f32; 3],
        /// Longest history, samples; 0 if there is none.
        max_history: f32,
        past_position: [f32; 3],
        past_width: u32,
        past_right: [f32; 3],
        past_height: u32,
        past_up: [f32; 3],
        past_pixel: f32,
        past_forward: [f32; 3],
        /// Weight of the film's means in the picture.
        weight: f32,
        /// Size of the picture, pixels; that of the samples is `width` and `height`.
        shown_width: u32,
        shown_height: u32,
        past_shown_width: u32,
        past_shown_height: u32,
        /// Samples of every pixel.
        samples: u32,
        /// Further samples of the pixels above `row`, and in the eight rows from there of those left of `column`.
        begun: u32,
        row: u32,
        column: u32,
        /// Not 0 if the scene has changed since the last film.
        scene_changed: u32,
        camera_moves: u32,
        /// Not 0 if the picture is averaged with the last one.
        antialiases: u32,
        /// Index of the buffer to show.
        buffer: u32,
        /// Factor of radiance before the tone curve.
        gain: f32,
        /// Index of the tone curve.
        tonemap: u32,
        /// Not 0 if the film has samples enough to show edges; 2 if it is also mixed with the picture.
        settles: u32,
        /// Weight of a new picture in the average with the last one.
        new_weight: f32,
        /// Not 0 if light of facets is filtered apart; and in the last picture.
        has_facets: u32,
        past_has_facets: u32,
        padding: [u32; 2],
    }
}

static FILES: &[ShaderFile] = shader_files![
    "reconstruct/antialiasing" shares antialiasing::shared_wgsl,
    "reconstruct/base",
    "reconstruct/deformation",
    "reconstruct/facets",
    "reconstruct/history",
    "reconstruct/pass" shares || {
        [declaration::<PassUniforms>(), declaration::<LeafMotion>(), super::shared_wgsl(), temporal::shared_wgsl(),
            spatial::shared_wgsl(), fireflies::shared_wgsl(), motion::shared_wgsl()].concat()
    },
    "reconstruct/reflections" shares reflections::shared_wgsl,
    "reconstruct/show" shares tonemap::wgsl,
    "reconstruct/spatial",
    "reconstruct/temporal",
];

/// Kernels of the passes, in the order in which they run.
struct Passes {
    divide: wgpu::ComputePipeline,
    find_fireflies: wgpu::ComputePipeline,
    spread_fireflies: wgpu::ComputePipeline,
    accumulate: wgpu::ComputePipeline,
    filter: FilterPasses,
    antialias: wgpu::ComputePipeline,
    compare_with_film: wgpu::ComputePipeline,
    mix_with_film: wgpu::ComputePipeline,
    show: wgpu::ComputePipeline,
}

/// Kernels of the spatial filter of one layer of light.
struct FilterPasses {
    start: wgpu::ComputePipeline,
    smooth_variance: wgpu::ComputePipeline,
    filter: [wgpu::ComputePipeline; STEPS.len()],
}

impl FilterPasses {
    fn new(gpu: &wgpu::Device, layer: &'static str) -> Self {
        let module = module(gpu, "reconstruct/spatial", layer);
        Self {
            start: pipeline(gpu, &module, "start_filter", &[]),
            smooth_variance: pipeline(gpu, &module, "smooth_variance", &[]),
            filter: STEPS.map(|step| pipeline(gpu, &module, "filter_once", &[("STEP", f64::from(step))])),
        }
    }
}

/// Kernels for the light of facets.
struct FacetPasses {
    divide: wgpu::ComputePipeline,
    add_up_rows: wgpu::ComputePipeline,
    find_images: wgpu::ComputePipeline,
    accumulate: wgpu::ComputePipeline,
    filter: FilterPasses,
}

impl FacetPasses {
    fn new(device: &Device) -> Result<Self, RenderError> {
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = module(gpu, "reconstruct/reflections", FACETS);
        let passes = Self {
            divide: pipeline(gpu, &module, "divide_reflected", &[]),
            add_up_rows: pipeline(gpu, &module, "add_up_rows", &[]),
            find_images: pipeline(gpu, &module, "find_images", &[]),
            accumulate: pipeline(gpu, &module, "accumulate_reflected", &[]),
            filter: FilterPasses::new(gpu, FACETS),
        };
        device.end_scope(validation)?;
        Ok(passes)
    }
}

/// Files of the layers of light.
const BASE: &str = "reconstruct/base";
const FACETS: &str = "reconstruct/facets";

/// Kernel that finds the points of objects that deform on their earlier surface; it is that of one structure of them.
struct DeformationPass {
    code: String,
    pipeline: wgpu::ComputePipeline,
}

impl DeformationPass {
    /// Code for the objects of an earlier field.
    fn code(program: &Program) -> String {
        let parameters =
            format!("@group(0) @binding(13) var<storage, read> field_parameters: {};\n", program.parameters_type());
        [&parameters, &program.code, &code("reconstruct/deformation", BASE)].map(String::as_str).concat()
    }

    fn new(device: &Device, code: String) -> Result<Self, RenderError> {
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let source = wgpu::ShaderSource::Wgsl(code.as_str().into());
        let label = Some("reconstruct/deformation");
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: Some("find_earlier_surface"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        device.end_scope(validation)?;
        Ok(Self { code, pipeline })
    }
}

/// Code of a shader file with its imports, for a layer of light.
fn code(file: &str, layer: &'static str) -> String {
    with_imports(file, FILES, &|name| (name == "layer").then_some(layer))
}

fn module(gpu: &wgpu::Device, file: &str, layer: &'static str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(code(file, layer).into());
    gpu.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(file), source })
}

fn pipeline(
    gpu: &wgpu::Device,
    module: &wgpu::ShaderModule,
    entry_point: &str,
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: None,
        module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
        cache: None,
    })
}

impl Passes {
    fn new(device: &Device) -> Result<Self, RenderError> {
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let module = |file: &str| module(gpu, file, BASE);
        let pipeline = |module: &wgpu::ShaderModule, entry_point: &str| pipeline(gpu, module, entry_point, &[]);
        let [temporal, spatial, show] = ["reconstruct/temporal", "reconstruct/spatial", "reconstruct/show"].map(module);
        let passes = Self {
            divide: pipeline(&temporal, "divide"),
            find_fireflies: pipeline(&spatial, "find_fireflies"),
            spread_fireflies: pipeline(&spatial, "spread_fireflies"),
            accumulate: pipeline(&temporal, "accumulate"),
            filter: FilterPasses::new(gpu, BASE),
            antialias: pipeline(&module("reconstruct/antialiasing"), "antialias"),
            compare_with_film: pipeline(&show, "compare_with_film"),
            mix_with_film: pipeline(&show, "mix_with_film"),
            show: pipeline(&show, "show"),
        };
        device.end_scope(validation)?;
        Ok(passes)
    }
}

/// Buffers of a film that the next one reads.
struct FilmBuffers {
    guides: wgpu::Buffer,
    history: wgpu::Buffer,
    colours: wgpu::Buffer,
}

/// Buffers for the light of facets.
struct FacetBuffers {
    /// Histories of the present film and of the one before.
    histories: [wgpu::Buffer; 2],
    /// Filtered light without that of facets.
    base: wgpu::Buffer,
    images: wgpu::Buffer,
}

/// All buffers, for films and pictures of up to `pixels` pixels.
struct Buffers {
    pixels: u64,
    /// Those for the light of facets; `None` before there are any.
    facets: Option<FacetBuffers>,
    /// Those of the present film and of the one before.
    films: [FilmBuffers; 2],
    /// Estimates that a pass reads and those that it writes.
    estimates: [wgpu::Buffer; 2],
    earlier: wgpu::Buffer,
    screen: wgpu::Buffer,
    copy: wgpu::Buffer,
}

/// Bytes of the guides of a pixel.
const GUIDE_BYTES: u64 = 64;
/// Bytes of the history of a pixel.
const HISTORY_BYTES: u64 = 32;
/// Bytes of a colour or an estimate.
const COLOUR_BYTES: u64 = 16;
/// Bytes of a point in the earlier scene.
const EARLIER_BYTES: u64 = 16;
/// Bytes of a pixel of the screen.
const SCREEN_BYTES: u64 = 4;

impl Buffers {
    /// Allocates buffers, also for the light of facets if it is there; `None` if the device cannot.
    fn new(device: &Device, pixels: u64, has_facets: bool) -> Option<Self> {
        let limits = device.device.limits();
        if GUIDE_BYTES * pixels > limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) {
            return None;
        }
        let buffer = |label, bytes: u64, usage| {
            let size = bytes * pixels;
            device.allocate(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false }).ok()
        };
        let copied = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let storage = wgpu::BufferUsages::STORAGE | copied;
        let film = || {
            Some(FilmBuffers {
                guides: buffer("guides", GUIDE_BYTES, storage)?,
                history: buffer("history", HISTORY_BYTES, storage)?,
                colours: buffer("colours", COLOUR_BYTES, storage)?,
            })
        };
        let readback = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let facets = || {
            let history = || buffer("history of facets", HISTORY_BYTES, storage);
            Some(FacetBuffers {
                histories: [history()?, history()?],
                base: buffer("base", COLOUR_BYTES, storage)?,
                images: buffer("images", COLOUR_BYTES, storage)?,
            })
        };
        Some(Self {
            pixels,
            facets: if has_facets { Some(facets()?) } else { None },
            films: [film()?, film()?],
            estimates: [buffer("estimates", COLOUR_BYTES, storage)?, buffer("estimates", COLOUR_BYTES, storage)?],
            earlier: buffer("earlier points", EARLIER_BYTES, storage)?,
            screen: buffer("screen", SCREEN_BYTES, storage)?,
            copy: buffer("screen copy", SCREEN_BYTES, readback)?,
        })
    }

    /// Copies the films of smaller buffers.
    fn copy_films(&self, device: &Device, old: &Self) {
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("copy history") });
        for (new, old) in self.films.iter().zip(&old.films) {
            for (new, old) in [(&new.guides, &old.guides), (&new.history, &old.history), (&new.colours, &old.colours)] {
                encoder.copy_buffer_to_buffer(old, 0, new, 0, old.size());
            }
        }
        if let (Some(new), Some(old)) = (&self.facets, &old.facets) {
            for (new, old) in new.histories.iter().zip(&old.histories) {
                encoder.copy_buffer_to_buffer(old, 0, new, 0, old.size());
            }
        }
        device.queue.submit([encoder.finish()]);
    }
}

/// Light that a pass works on.
#[derive(Clone, Copy, PartialEq)]
enum Layer {
    Base,
    Facets,
}

/// Where a pass works: the layer, the estimates that it reads, and the size of the picture.
#[derive(Clone, Copy)]
struct Target {
    layer: Layer,
    source: usize,
    size: [u32; 2],
}

/// What a film showed.
struct Shown {
    scene: Arc<RenderScene>,
    frame: FrameUniforms,
    /// Size of the picture, pixels.
    size: [u32; 2],
    has_facets: bool,
}

/// State between the pictures of a sequence.
pub(super) struct GpuReconstruction {
    device: Arc<GpuContext>,
    passes: Passes,
    /// Passes for the light of facets; `None` before there is any.
    facet_passes: Option<FacetPasses>,
    /// Pass for objects that deform; `None` before there were any.
    deformation: Option<DeformationPass>,
    uniforms: wgpu::Buffer,
    buffers: Option<Buffers>,
    /// Index of the present film's buffers.
    turn: usize,
    past: Option<Shown>,
    present: Option<Shown>,
    changes: Changes,
    /// Timer of the passes of sequences; `None` in windows, and on adapters without timestamps.
    timer: Option<GpuTimer>,
    /// Passes of the last picture, if there is a timer.
    pub(super) passes_done: Vec<PassTime>,
}

impl GpuReconstruction {
    pub(super) fn new(device: &Arc<GpuContext>) -> Result<Self, RenderError> {
        let uniforms = device.allocate(&wgpu::BufferDescriptor {
            label: Some("reconstruction"),
            size: size_of::<PassUniforms>() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })?;
        Ok(Self {
            passes: Passes::new(device)?,
            facet_passes: None,
            deformation: None,
            device: device.clone(),
            uniforms,
            buffers: None,
            turn: 0,
            past: None,
            present: None,
            changes: Changes::default(),
            timer: None,
            passes_done: Vec::new(),
        })
    }

    /// Times the passes of all further pictures, if the adapter can.
    pub(super) fn time_passes(&mut self) -> Result<(), RenderError> {
        self.timer = GpuTimer::new(&self.device)?;
        Ok(())
    }

    /// True if it runs on this device.
    pub(super) fn is_on(&self, device: &Arc<GpuContext>) -> bool {
        Arc::ptr_eq(&self.device, device)
    }

    /// Starts another film: of another view, size or moment, or of a changed scene.
    pub(super) fn start_film(&mut self, scene_changed: bool) {
        let present = self.present.take();
        self.changes.start_film(present.is_some(), scene_changed);
        if present.is_some() {
            self.past = present;
            self.turn = 1 - self.turn;
        }
    }

    /// Reconstructs a film and tone-maps it: red, green, blue and 255 for each pixel. `None` without memory.
    pub(super) fn show(
        &mut self,
        film: &ReconstructedFilm,
        input: &RenderInput,
        weight: f32,
        size: [u32; 2],
        options: &ReconstructOptions,
        display: &Display,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        let has_facets = input.scene.materials.iter().any(|material| material.has(GLOSSY) && !material.has(DELTA));
        if !self.reserve(u64::from(size[0]) * u64::from(size[1]), has_facets) {
            return Ok(None);
        }
        if has_facets && self.facet_passes.is_none() {
            self.facet_passes = Some(FacetPasses::new(&self.device)?);
        }
        let changed_past = self.past.as_ref().filter(|_| self.changes.scene);
        let motion = changed_past.map_or_else(Motion::default, |past| Motion::new(&past.scene, &input.scene));
        let earlier_field = motion.earlier_field.as_ref();
        let field_parameters = earlier_field.map(|field| self.start_deformation(field)).transpose()?;
        let uniforms = PassUniforms {
            has_facets: u32::from(has_facets),
            ..self.uniforms_of(film, &input.frame, weight, size, options, display)
        };
        self.device.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let records = motion.records(&input.scene);
        let leaf_motions = self.uploaded("leaf motions", &records)?;
        let codes = self.run(film, &leaf_motions, field_parameters.as_ref(), &uniforms, options)?;
        self.present = Some(Shown { scene: input.scene.clone(), frame: input.frame, size, has_facets });
        Ok(codes)
    }

    /// Buffer with records, of at least one.
    fn uploaded<T: bytemuck::Pod>(&self, label: &str, records: &[T]) -> Result<wgpu::Buffer, RenderError> {
        let buffer = self.device.allocate(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size_of_val(records).max(size_of::<T>()) as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })?;
        self.device.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(records));
        Ok(buffer)
    }

    /// Compiles the pass for the objects of an earlier field, unless it is that of the last picture, and uploads their numbers.
    fn start_deformation(&mut self, earlier_field: &Field) -> Result<wgpu::Buffer, RenderError> {
        let program = Program::new(earlier_field);
        let code = DeformationPass::code(&program);
        if self.deformation.as_ref().is_none_or(|pass| pass.code != code) {
            self.deformation = Some(DeformationPass::new(&self.device, code)?);
        }
        self.uploaded("earlier field", &program.parameters)
    }

    /// Colours of the last picture.
    pub(super) fn colours(&self) -> Result<Vec<Vec3>, RenderError> {
        let (Some(buffers), Some(Shown { size, .. })) = (&self.buffers, &self.present) else { return Ok(Vec::new()) };
        let colours = self.read_back::<[f32; 4]>(&buffers.estimates[0], *size)?;
        Ok(colours.into_iter().map(|[r, g, b, _]| Vec3::new(r, g, b)).collect())
    }

    /// Histories of all pixels of the last picture.
    pub(super) fn histories(&self) -> Result<Vec<PixelHistory>, RenderError> {
        let (Some(buffers), Some(Shown { frame, .. })) = (&self.buffers, &self.present) else { return Ok(Vec::new()) };
        let histories = self.read_back::<[f32; 8]>(&buffers.films[self.turn].history, frame.size())?;
        let of =
            |[_, _, _, length, _, _, x, y]: [f32; 8]| PixelHistory { before: (x > -1e8).then_some([x, y]), length };
        Ok(histories.into_iter().map(of).collect())
    }

    /// Records of all pixels in a buffer.
    fn read_back<T: bytemuck::Pod>(&self, buffer: &wgpu::Buffer, size: [u32; 2]) -> Result<Vec<T>, RenderError> {
        let bytes = size_of::<T>() as u64 * u64::from(size[0]) * u64::from(size[1]);
        let copy = self.device.allocate(&wgpu::BufferDescriptor {
            label: Some("copy"),
            size: bytes,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        })?;
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("copy") });
        encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, bytes);
        self.device.queue.submit([encoder.finish()]);
        self.device.read(&copy, bytes, |bytes| bytemuck::cast_slice(bytes).to_vec())
    }

    /// Allocates buffers for so many pixels; returns false if the device cannot.
    fn reserve(&mut self, pixels: u64, has_facets: bool) -> bool {
        let suffices = |buffers: &Buffers| buffers.pixels >= pixels && (buffers.facets.is_some() || !has_facets);
        if self.buffers.as_ref().is_some_and(suffices) {
            return true;
        }
        let pixels = self.buffers.as_ref().map_or(pixels, |buffers| buffers.pixels.max(pixels));
        let Some(new) = Buffers::new(&self.device, pixels, has_facets) else {
            (self.buffers, self.past, self.present) = (None, None, None);
            return false;
        };
        if let Some(old) = &self.buffers {
            new.copy_films(&self.device, old);
        }
        self.buffers = Some(new);
        true
    }

    fn uniforms_of(
        &self,
        film: &ReconstructedFilm,
        frame: &FrameUniforms,
        weight: f32,
        size: [u32; 2],
        options: &ReconstructOptions,
        display: &Display,
    ) -> PassUniforms {
        let past = self.past.as_ref();
        let (past_frame, past_size) = past.map_or((frame, size), |past| (&past.frame, past.size));
        let reprojects = past.is_some() && options.reprojection;
        PassUniforms {
            position: frame.position,
            width: frame.width,
            right: frame.right,
            height: frame.height,
            up: frame.up,
            pixel: frame.pixel,
            forward: frame.forward,
            max_history: if reprojects { self.changes.max_history * (1.0 - weight) } else { 0.0 },
            past_position: past_frame.position,
            past_width: past_frame.width,
            past_right: past_frame.right,
            past_height: past_frame.height,
            past_up: past_frame.up,
            past_pixel: past_frame.pixel,
            past_forward: past_frame.forward,
            weight,
            shown_width: size[0],
            shown_height: size[1],
            past_shown_width: past_size[0],
            past_shown_height: past_size[1],
            samples: film.samples,
            begun: film.begun,
            row: film.row,
            column: film.column,
            scene_changed: u32::from(self.changes.scene),
            camera_moves: u32::from(camera_moves(past_frame, frame)),
            antialiases: u32::from(past.is_some() && options.antialiasing),
            buffer: options.buffer as u32,
            gain: display.gain(),
            tonemap: display.tonemap as u32,
            settles: u32::from(settles(film.samples)) << u32::from(frame.size() == size),
            new_weight: antialiasing::new_weight(film.samples),
            has_facets: 0,
            past_has_facets: u32::from(past.is_some_and(|past| past.has_facets)),
            padding: [0; 2],
        }
    }

    /// Runs all passes and reads the codes of the picture back.
    fn run(
        &mut self,
        film: &ReconstructedFilm,
        leaf_motions: &wgpu::Buffer,
        field_parameters: Option<&wgpu::Buffer>,
        uniforms: &PassUniforms,
        options: &ReconstructOptions,
    ) -> Result<Option<Vec<u8>>, RenderError> {
        let Some(buffers) = &self.buffers else { return Ok(None) };
        let gpu = &self.device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let traced = [uniforms.width, uniforms.height];
        let size = [uniforms.shown_width, uniforms.shown_height];
        let facets = buffers.facets.as_ref().filter(|_| uniforms.has_facets != 0);
        let mut recorder = PassRecorder {
            gpu,
            encoder: gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("reconstruct") }),
            timer: self.timer.take(),
            names: Vec::new(),
            sources: PassSources {
                uniforms: &self.uniforms,
                film: film.film,
                leaf_motions,
                field_parameters,
                buffers,
                facets,
                films: [&buffers.films[self.turn], &buffers.films[1 - self.turn]],
                turn: self.turn,
            },
        };
        let pixels = u64::from(traced[0]) * u64::from(traced[1]);
        let present = &buffers.films[self.turn];
        recorder.encoder.copy_buffer_to_buffer(film.guides, 0, &present.guides, 0, GUIDE_BYTES * pixels);
        let passes = &self.passes;
        let target = Target { layer: Layer::Base, source: 0, size: traced };
        recorder.run("division by the albedo", &passes.divide, &[0, 1, 2, 4, 7, 12], target);
        if let (Some(pass), Some(_)) = (&self.deformation, field_parameters) {
            recorder.run("deformation", &pass.pipeline, &[0, 2, 4, 12, 13], target);
        }
        recorder.spread_fireflies(passes, options, target);
        recorder.run("reprojection", &passes.accumulate, &[0, 2, 3, 5, 6, 7, 12], target);
        recorder.filter(&passes.filter, options, target);
        if let (Some(facets), Some(facet_passes)) = (facets, &self.facet_passes) {
            let (bytes, target) = (COLOUR_BYTES * pixels, Target { layer: Layer::Facets, ..target });
            recorder.encoder.copy_buffer_to_buffer(&buffers.estimates[0], 0, &facets.base, 0, bytes);
            recorder.run("reflections", &facet_passes.divide, &[0, 2, 7], target);
            recorder.spread_fireflies(passes, options, target);
            recorder.run("reflections", &facet_passes.add_up_rows, &[0, 2, 7, 15], target);
            recorder.run("reflections", &facet_passes.find_images, &[0, 2, 8, 15], target);
            recorder.encoder.copy_buffer_to_buffer(&buffers.estimates[1], 0, &facets.images, 0, bytes);
            recorder.run("reflections", &facet_passes.accumulate, &[0, 2, 3, 5, 6, 7, 12, 15], target);
            recorder.filter(&facet_passes.filter, options, target);
        }
        let target = Target { size, ..target };
        recorder.run("anti-aliasing", &passes.antialias, &[0, 2, 3, 7, 9, 10, 12, 14], target);
        if settles(film.samples) && traced == size {
            recorder.run("mix with the film", &passes.compare_with_film, &[0, 1, 2, 8, 10], target);
        }
        recorder.run("mix with the film", &passes.mix_with_film, &[0, 1, 2, 7, 8, 10], target);
        recorder.run("display", &passes.show, &[0, 5, 7, 11], target);
        let bytes = SCREEN_BYTES * u64::from(size[0]) * u64::from(size[1]);
        let PassRecorder { mut encoder, timer, names, .. } = recorder;
        encoder.copy_buffer_to_buffer(&buffers.screen, 0, &buffers.copy, 0, bytes);
        self.device.queue.submit([encoder.finish()]);
        self.device.end_scope(validation)?;
        self.timer = timer;
        if let Some(timer) = &mut self.timer {
            self.passes_done = pass_times(&names, &timer.read_passes(&self.device)?);
        }
        self.device.read(&buffers.copy, bytes, <[u8]>::to_vec).map(Some)
    }
}

/// Buffers that passes bind.
struct PassSources<'a> {
    uniforms: &'a wgpu::Buffer,
    film: &'a wgpu::Buffer,
    leaf_motions: &'a wgpu::Buffer,
    field_parameters: Option<&'a wgpu::Buffer>,
    buffers: &'a Buffers,
    facets: Option<&'a FacetBuffers>,
    /// Those of the present film and of the one before.
    films: [&'a FilmBuffers; 2],
    turn: usize,
}

impl PassSources<'_> {
    fn buffer(&self, binding: u32, target: Target) -> &wgpu::Buffer {
        let ([present, past], buffers) = (self.films, self.buffers);
        let [history, past_history] = match (target.layer, self.facets) {
            (Layer::Facets, Some(facets)) => [&facets.histories[self.turn], &facets.histories[1 - self.turn]],
            _ => [&present.history, &past.history],
        };
        match binding {
            0 => self.uniforms,
            1 => self.film,
            2 => &present.guides,
            3 => &past.guides,
            4 => self.leaf_motions,
            5 => history,
            6 => past_history,
            7 => &buffers.estimates[target.source],
            8 => &buffers.estimates[1 - target.source],
            9 => &past.colours,
            10 => &present.colours,
            11 => &buffers.screen,
            12 => &buffers.earlier,
            13 => self.field_parameters.unwrap_or(self.uniforms),
            // Without light of facets, nothing reads it.
            14 => self.facets.map_or(&past.colours, |facets| &facets.base),
            _ => self.facets.map_or(&past.colours, |facets| &facets.images),
        }
    }
}

/// Recorder of the passes of a picture.
struct PassRecorder<'a> {
    gpu: &'a wgpu::Device,
    encoder: wgpu::CommandEncoder,
    timer: Option<GpuTimer>,
    names: Vec<&'static str>,
    sources: PassSources<'a>,
}

impl PassRecorder<'_> {
    fn run(&mut self, name: &'static str, pipeline: &wgpu::ComputePipeline, bindings: &[u32], target: Target) {
        let entry = |&binding: &u32| wgpu::BindGroupEntry {
            binding,
            resource: self.sources.buffer(binding, target).as_entire_binding(),
        };
        let entries: Vec<_> = bindings.iter().map(entry).collect();
        let layout = pipeline.get_bind_group_layout(0);
        let group = self.gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("reconstruct"),
            layout: &layout,
            entries: &entries,
        });
        self.names.push(name);
        let timestamp_writes = self.timer.as_mut().map(GpuTimer::next);
        let descriptor = wgpu::ComputePassDescriptor { label: Some(name), timestamp_writes };
        let mut pass = self.encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(target.size[0].div_ceil(8), target.size[1].div_ceil(8), 1);
    }

    fn spread_fireflies(&mut self, passes: &Passes, options: &ReconstructOptions, target: Target) {
        if options.firefly_filter {
            self.run("fireflies", &passes.find_fireflies, &[0, 2, 7, 8], target);
            self.run("fireflies", &passes.spread_fireflies, &[0, 2, 7, 8], target);
        }
    }

    /// Filters the means of a layer: the last pass writes the estimates of index 0.
    fn filter(&mut self, passes: &FilterPasses, options: &ReconstructOptions, target: Target) {
        let images = if target.layer == Layer::Facets { &[15][..] } else { &[] };
        let [first, others] = [[0, 2, 5, 7], [0, 2, 7, 8]].map(|bindings| [&bindings, images].concat());
        self.run("spatial filter", &passes.start, &first, target);
        let filters = std::iter::once(&passes.smooth_variance).chain(&passes.filter);
        for (k, pipeline) in filters.filter(|_| options.spatial_filter).enumerate() {
            self.run("spatial filter", pipeline, &others, Target { source: k % 2, ..target });
        }
    }
}

const _: () = assert!(STEPS.len() % 2 == 1, "the last pass of the filter writes the estimates of index 0");

/// Times of passes, those of one name added up.
fn pass_times(names: &[&'static str], times: &[Duration]) -> Vec<PassTime> {
    let mut passes: Vec<PassTime> = Vec::new();
    for (name, time) in names.iter().zip(times) {
        match passes.iter_mut().find(|pass| pass.name == *name) {
            Some(pass) => pass.seconds += time.as_secs_f64(),
            None => passes.push(PassTime { name, seconds: time.as_secs_f64() }),
        }
    }
    passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wgsl::check_layout;
    use naga::valid::{Capabilities, ValidationFlags, Validator};
    use pathmarch_scene::Scene;

    #[test]
    fn structures_have_one_layout_in_both_languages() {
        check_layout::<PassUniforms>();
        check_layout::<LeafMotion>();
    }

    #[test]
    fn passes_are_valid_and_within_the_default_limits() {
        let scene = "pathmarch 1\ncamera { position 0 1 5; target 0 0 0 }\nsky 1\nobject \"drops\" {\n\
            union smooth=0.3 { sphere 0.5 { at 0.5 1 0 }; twist 90 { box 0.5 } } }\nobject \"fractal\" { mandelbulb }";
        let field = Scene::parse("test.kdl", scene).expect("a scene").field;
        let deformation = DeformationPass::code(&Program::new(&field.of_objects(&[0, 1])));
        for (file, layer) in FILES.iter().flat_map(|file| [(file, BASE), (file, FACETS)]) {
            let code =
                if file.name == "reconstruct/deformation" { deformation.clone() } else { code(file.name, layer) };
            let module =
                naga::front::wgsl::parse_str(&code).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&code)));
            let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
            let info = info.unwrap_or_else(|error| panic!("{}: {error:?}", file.name));
            for (k, entry) in module.entry_points.iter().enumerate() {
                let used =
                    module.global_variables.iter().filter(|(handle, _)| !info.get_entry_point(k)[*handle].is_empty());
                let buffers = used.count() as u32;
                assert!(
                    buffers <= wgpu::Limits::default().max_storage_buffers_per_shader_stage,
                    "{}: {buffers}",
                    entry.name
                );
            }
        }
    }

    #[test]
    fn every_file_is_listed() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/reconstruct");
        for entry in std::fs::read_dir(folder).expect("is readable") {
            let name = entry.expect("is readable").file_name().into_string().expect("is Unicode");
            if let Some(name) = name.strip_suffix(".wgsl") {
                assert!(FILES.iter().any(|file| file.name == format!("reconstruct/{name}")), "{name}");
            }
        }
    }
}
