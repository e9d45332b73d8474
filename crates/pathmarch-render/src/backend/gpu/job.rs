//! Picture being rendered on the GPU.
//!
//! Each scene has its own kernel ([`super::compose`]). A dispatch computes one sample of a band of rows, or several. The job
//! adapts the bands and the number of dispatches in a submission to a target time: weak adapters stay responsive, strong ones
//! stay busy. Two submissions are in flight. The camera and the size of the picture may change without a new job.

use super::GpuContext;
use super::bindings;
use super::display::DisplayBuffers;
use super::encode::LightRecord;
use super::kernel_cache::{Kernel, KernelSource};
use super::loop_limit::{self, SuspendedPaths};
use super::pixel_pass::PixelPass;
use super::slice::{BAND, MAX_GROUPS_ACROSS, Progress, Slice};
use super::table_memory::{FilmMemory, Table};
use super::timer::GpuTimer;
use crate::backend::RenderInput;
use crate::error::RenderError;
use crate::integrator::emitter_coverage::COVERAGES_PER_GROUP;
use crate::integrator::emitter_edges::{EDGES_PER_GROUP, EmitterEdges};
use crate::integrator::guides::FILM_SAMPLES;
use crate::integrator::pixel_albedo::ALBEDOS_PER_GROUP;
use crate::integrator::splitting;
use crate::mode::Mode;
use crate::output::film::Film;
use crate::output::parts::Rect;
use crate::output::tonemap::Display;
use crate::scene::{FrameUniforms, KernelConfig, PhotonMap};
use bytemuck::Zeroable;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;
use web_time::Instant;

/// Target time of a submission for offline rendering.
pub(crate) const OFFLINE: Duration = Duration::from_millis(25);
/// Target time of a submission for live pictures, which must react to input.
pub(crate) const LIVE: Duration = Duration::from_millis(10);
/// Largest number of dispatches in a submission.
const MAX_DISPATCHES: usize = 256;
/// Largest number of shapes that a kernel contains as code; shapes of a grid are data.
pub(crate) const MAX_LEAVES: usize = 2048;

/// Picture being rendered.
pub(crate) struct GpuJob {
    device: Arc<GpuContext>,
    kernel: Arc<Kernel>,
    /// Kernel for the edges of emitters, and the edges.
    edges: Option<(Arc<Kernel>, Arc<EmitterEdges>)>,
    /// Coverage by emitters, if guides are recorded.
    coverage: Option<PixelPass>,
    /// Albedos of pixels, if guides are recorded.
    albedos: Option<PixelPass>,
    bindings: wgpu::BindGroup,
    frame: wgpu::Buffer,
    /// True if the kernel contains the frame.
    frame_is_constant: bool,
    slices: wgpu::Buffer,
    slice_stride: u32,
    film: FilmMemory,
    /// Guides, if they are recorded.
    guides: Option<wgpu::Buffer>,
    /// Photon maps, with traced caustics.
    photons: Option<Photons>,
    display_buffers: Option<DisplayBuffers>,
    size: [u32; 2],
    /// Pixels of films.
    rect: Rect,
    /// Pixels that further samples are taken of, and the index of the rectangle that is rendered.
    active: Vec<Rect>,
    current: usize,
    /// Buffer of the last film that was taken, to be used again.
    staging: Option<wgpu::Buffer>,
    first_sample: u32,
    /// Work submitted so far.
    submitted: Progress,
    /// Target time of a submission.
    target: Duration,
    /// Work of a submission of about that time: samples, summed over pixels.
    quota: f64,
    /// Its `splitting` is the largest number of samples that share a camera ray.
    config: KernelConfig,
    /// Largest number of samples of a pixel in a dispatch that do not.
    samples_per_dispatch: u32,
    /// Width of the pixels of a workgroup.
    group_width: u32,
    /// Submissions in flight: index, work and time of submission.
    in_flight: VecDeque<(wgpu::SubmissionIndex, f64, Instant)>,
    last_completion: Instant,
    timer: Option<GpuTimer>,
    /// Suspended paths, if the adapter limits loops.
    suspended: Option<SuspendedPaths>,
    /// Bounces of the paths, if paths can be resumed.
    bounces: Option<u32>,
    pub(crate) compile_time: Duration,
}

/// Fails if a picture of this size, or a field of so many shapes, is too large for the device.
fn check_limits(device: &GpuContext, size: [u32; 2], shapes: usize) -> Result<(), RenderError> {
    let too_large = |what| Err(RenderError::TooLarge { adapter: device.description.name.clone(), what });
    let limits = device.device.limits();
    if film_bytes(size) > limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) {
        return too_large(format!("a picture of {}x{} pixels", size[0], size[1]));
    }
    if shapes > MAX_LEAVES {
        return too_large(format!("a field of {shapes} shapes (the limit is {MAX_LEAVES})"));
    }
    Ok(())
}

/// Fails if a table of the scene exceeds a binding of the device.
fn check_tables(device: &GpuContext, source: &KernelSource, photon_bytes: usize) -> Result<(), RenderError> {
    let limits = device.device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    for (name, bytes) in [
        ("parameters of shapes", size_of_val(&source.parameters[..])),
        ("meshes, pictures and other tables", size_of_val(&source.data.words[..])),
        ("pixels of the sky, nodes of lights and photons", size_of_val(&source.data.vectors[..]) + photon_bytes),
    ] {
        if bytes as u64 > limit {
            let what = format!("{} MiB of {name} (the limit is {} MiB)", bytes >> 20, limit >> 20);
            return Err(RenderError::TooLarge { adapter: device.description.name.clone(), what });
        }
    }
    Ok(())
}

/// Photon maps, which the CPU traces, and their place in a buffer of the kernel.
struct Photons {
    input: RenderInput,
    buffer: wgpu::Buffer,
    /// Offset, and the largest number of bytes.
    offset: u64,
    capacity: usize,
}

impl Photons {
    /// Uploads the map of a sample, for the submissions after this call.
    fn upload(&self, queue: &wgpu::Queue, sample: u32) {
        if let Some(map) = self.input.photon_map(sample) {
            queue.write_buffer(&self.buffer, self.offset, bytemuck::cast_slice(&map.encoded()));
        }
    }
}

/// Bytes of a photon map of a picture, with traced caustics.
fn photon_bytes(input: &RenderInput) -> usize {
    size_of::<[f32; 4]>() * input.light_paths().map_or(0, PhotonMap::encoded_length)
}

fn film_bytes([width, height]: [u32; 2]) -> u64 {
    16 * u64::from(width) * u64::from(height)
}

/// Film that is reconstructed, and its guides.
pub(crate) struct ReconstructedFilm<'a> {
    pub(crate) device: &'a Arc<GpuContext>,
    pub(crate) film: &'a wgpu::Buffer,
    pub(crate) guides: &'a wgpu::Buffer,
    /// Coverages of the pixels of the picture by emitters; `None` if they are not wanted, or if it cannot show any.
    pub(crate) coverages: Option<&'a wgpu::Buffer>,
    /// Albedos of the pixels of the picture; `None` if they are not wanted, or if they are those of the samples.
    pub(crate) albedos: Option<&'a wgpu::Buffer>,
    /// Samples of every pixel.
    pub(crate) samples: u32,
    /// Further samples of the pixels above `row`, and in the eight rows from there of those left of `column`.
    pub(crate) begun: u32,
    pub(crate) row: u32,
    pub(crate) column: u32,
}

impl GpuJob {
    /// Starts a picture. `target` is the target time of a submission: [`OFFLINE`] or [`LIVE`].
    pub(crate) fn new(
        device: Arc<GpuContext>,
        input: &RenderInput,
        first_sample: u32,
        target: Duration,
    ) -> Result<Self, RenderError> {
        check_limits(&device, input.frame.size(), input.scene.field.shapes_as_code())?;
        let source = KernelSource::new(input, &device);
        Self::of_source(device, input, &source, first_sample, target)
    }

    /// Starts a picture, as [`new`](Self::new), with the source of its kernel.
    pub(crate) fn of_source(
        device: Arc<GpuContext>,
        input: &RenderInput,
        source: &KernelSource,
        first_sample: u32,
        target: Duration,
    ) -> Result<Self, RenderError> {
        let frame_record = &input.frame;
        let size = frame_record.size();
        check_limits(&device, size, input.scene.field.shapes_as_code())?;
        let photon_bytes = photon_bytes(input);
        check_tables(&device, source, photon_bytes)?;
        let started = Instant::now();
        let kernel = device.kernels.compile(&device, source, &source.code)?;
        let edges = match (&source.edges, &input.edges) {
            (Some(code), Some(edges)) => Some((device.kernels.compile(&device, source, code)?, edges.clone())),
            _ => None,
        };
        let compiled =
            |code: &Option<String>| code.as_ref().map(|code| device.kernels.compile(&device, source, code)).transpose();
        let [coverage, albedos] = [compiled(&source.coverage)?, compiled(&source.albedos)?];
        let gpu = &device.device;
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let out_of_memory = gpu.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let (uniform, storage) = (wgpu::BufferUsages::UNIFORM, wgpu::BufferUsages::STORAGE);
        let copied = wgpu::BufferUsages::COPY_DST;
        let bindings = &source.bindings;
        let constant = |binding, label, contents: &[u8]| {
            // A binding must not be empty or smaller than its declaration.
            let size = bindings.bytes(binding, contents.len()) as u64;
            let kind = if bindings.is_uniform(binding) { uniform } else { storage };
            let descriptor =
                wgpu::BufferDescriptor { label: Some(label), size, usage: kind | copied, mapped_at_creation: false };
            let buffer = gpu.create_buffer(&descriptor);
            device.queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        let table = |(binding, label, contents)| {
            let table = match bindings.texel(binding) {
                Some(element) => Table::texture(&device, label, element, contents),
                None => Table::Buffer(constant(binding, label, contents)),
            };
            (binding, table)
        };
        let slice_stride =
            (size_of::<Slice>() as u32).next_multiple_of(gpu.limits().min_uniform_buffer_offset_alignment);
        let slices = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("slices"),
            size: u64::from(slice_stride) * MAX_DISPATCHES as u64,
            usage: uniform | copied,
            mapped_at_creation: false,
        });
        let film = FilmMemory::new(&device, source.bindings.memory(bindings::FILM), film_bytes(size));
        let film_table = film.table();
        let guide_bytes = 4 * film_bytes(size);
        let limits = gpu.limits();
        let guides_fit = guide_bytes <= limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let guides = source.bindings.has_guides.then(|| {
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: Some("guides"),
                // A kernel that stores no guides needs a binding nevertheless.
                size: if guides_fit { guide_bytes } else { 256 },
                usage: storage | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        });
        let frame = constant(bindings::FRAME, "frame", bytemuck::bytes_of(frame_record));
        let lights: Vec<LightRecord> = input.scene.lights.iter().map(LightRecord::new).collect();
        let photon_offset = size_of_val(&source.data.vectors[..]);
        let mut vectors: Vec<u8> = bytemuck::cast_slice(&source.data.vectors).to_vec();
        vectors.resize(photon_offset + photon_bytes, 0);
        let tables = [
            (bindings::PARAMETERS, "parameters", bytemuck::cast_slice(&source.parameters)),
            (bindings::LEAVES, "leaves", bytemuck::cast_slice(&input.scene.leaves)),
            (bindings::MATERIALS, "materials", bytemuck::cast_slice(&input.scene.materials)),
            (bindings::LIGHTS, "lights", bytemuck::cast_slice(&lights)),
            (bindings::SCENE_DATA, "scene data", bytemuck::cast_slice(&source.data.words)),
            (bindings::VECTORS, "vectors", &vectors[..]),
        ]
        .map(table);
        let light_tree = input.light_tree().filter(|_| source.bindings.is_uniform(bindings::LIGHT_TREE));
        let light_tree =
            light_tree.map(|tree| constant(bindings::LIGHT_TREE, "light tree", bytemuck::cast_slice(&tree.nodes)));
        let slice =
            wgpu::BufferBinding { buffer: &slices, offset: 0, size: wgpu::BufferSize::new(size_of::<Slice>() as u64) };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let used: Vec<u32> = source.bindings.all().collect();
        let mut entries = vec![
            entry(bindings::FRAME, frame.as_entire_binding()),
            entry(bindings::SLICE, wgpu::BindingResource::Buffer(slice)),
            entry(bindings::FILM, film_table.resource()),
        ];
        entries.extend(tables.iter().map(|(binding, table)| entry(*binding, table.resource())));
        entries.extend(light_tree.iter().map(|nodes| entry(bindings::LIGHT_TREE, nodes.as_entire_binding())));
        entries.extend(guides.iter().map(|guides| entry(bindings::GUIDES, guides.as_entire_binding())));
        let suspended = match source.bindings.loops_are_limited {
            true => Some(SuspendedPaths::new(&device)?),
            false => None,
        };
        entries.extend(suspended.iter().map(|paths| entry(bindings::SUSPENDED, paths.buffer.as_entire_binding())));
        entries.retain(|entry| used.contains(&entry.binding));
        let bind_group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("trace"),
            layout: &kernel.layout,
            entries: &entries,
        });
        for scope in [out_of_memory, validation] {
            device.end_scope(scope)?;
        }
        let vectors = tables.iter().find_map(|(binding, table)| match table {
            Table::Buffer(buffer) if *binding == bindings::VECTORS => Some(buffer.clone()),
            _ => None,
        });
        let photons = vectors.filter(|_| photon_bytes > 0).map(|buffer| Photons {
            input: input.clone(),
            buffer,
            offset: photon_offset as u64,
            capacity: photon_bytes,
        });
        let pass = |label, kernel, pixels_per_group| {
            let buffer = |binding| move |buffer| (binding, Table::Buffer(buffer));
            let mut tables = tables.to_vec();
            tables.push(buffer(bindings::FRAME)(frame.clone()));
            tables.extend(light_tree.clone().map(buffer(bindings::LIGHT_TREE)));
            tables.extend(guides.clone().map(buffer(bindings::GUIDES)));
            tables.retain(|(binding, _)| used.contains(binding));
            PixelPass { label, kernel, pixels_per_group, tables, slices: slices.clone(), vectors: None }
        };
        let coverage = coverage.map(|kernel| pass("coverage", kernel, COVERAGES_PER_GROUP));
        let albedos = albedos.map(|kernel| pass("albedos of pixels", kernel, ALBEDOS_PER_GROUP));
        let may_resume = input.mode.traces_paths() && input.config.splitting == 1;
        let mut job = Self {
            device,
            kernel,
            edges,
            coverage,
            albedos,
            bindings: bind_group,
            frame,
            frame_is_constant: source.bindings.frame_is_constant(),
            slices,
            slice_stride,
            film,
            guides: guides.filter(|_| guides_fit),
            photons,
            display_buffers: None,
            size,
            rect: Rect::of(size),
            active: vec![Rect::of(size)],
            current: 0,
            staging: None,
            first_sample,
            submitted: Progress::default(),
            target,
            quota: f64::from(BAND * 64),
            config: input.config,
            samples_per_dispatch: source.bindings.samples_per_dispatch,
            group_width: 8 * source.bindings.pixels_per_lane,
            in_flight: VecDeque::new(),
            last_completion: Instant::now(),
            timer: None,
            suspended,
            bounces: may_resume.then_some(frame_record.bounces),
            compile_time: Duration::ZERO,
        };
        // Browsers compile without that, and nothing can wait there.
        if !cfg!(target_family = "wasm") && !job.kernel.is_warm() {
            // Many drivers compile at the first dispatch: submits one without rows.
            job.submit(&[Slice { columns: 1, ..Slice::zeroed() }], 0);
            job.complete_oldest()?;
            job.kernel.set_warm();
        }
        job.compile_time = started.elapsed();
        Ok(job)
    }

    /// Starts again with another frame of the same scene. Returns false if that needs a new job.
    pub(crate) fn reframe(&mut self, frame: &FrameUniforms, first_sample: u32) -> Result<bool, RenderError> {
        let size = frame.size();
        if film_bytes(size) > self.film.buffer.size() || self.frame_is_constant {
            return Ok(false);
        }
        if let Some(photons) = &mut self.photons {
            photons.input.frame = *frame;
            if photon_bytes(&photons.input) > photons.capacity {
                return Ok(false);
            }
        }
        self.wait()?;
        self.edges = None;
        self.size = size;
        (self.rect, self.active, self.current) = (Rect::of(size), vec![Rect::of(size)], 0);
        self.bounces = self.bounces.map(|_| frame.bounces);
        (self.submitted, self.first_sample) = (Progress::default(), first_sample);
        self.device.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(frame));
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("clear") });
        self.film.clear(&mut encoder, film_bytes(size));
        self.device.queue.submit([encoder.finish()]);
        Ok(true)
    }

    /// Tone-maps the film so far to 8-bit codes: red, green, blue and 255 for each pixel. Waits for all submissions.
    pub(crate) fn show(&mut self, display: &Display, mode: Mode) -> Result<Vec<u8>, RenderError> {
        self.wait()?;
        let pass = self.device.display();
        if self.display_buffers.is_none() {
            self.display_buffers = Some(pass.buffers(&self.device, &self.film.buffer)?);
        }
        let Some(buffers) = &self.display_buffers else { return Ok(Vec::new()) };
        let mut encoder =
            self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("film") });
        self.film.update(&mut encoder);
        self.device.queue.submit([encoder.finish()]);
        pass.show(&self.device, buffers, self.size, self.submitted, display, mode)
    }

    /// Film so far, if its guides are recorded, for a picture of this size; with coverages by emitters and albedos of pixels, if
    /// they are wanted. Waits for all submissions.
    pub(crate) fn reconstructed_film(
        &mut self,
        size: [u32; 2],
        [wants_coverages, wants_albedos]: [bool; 2],
    ) -> Result<Option<ReconstructedFilm<'_>>, RenderError> {
        self.wait()?;
        let Progress { samples, begun, row, column } = self.submitted;
        let (device, film) = (&self.device, &self.film.buffer);
        let Some(guides) = self.guides.as_ref() else { return Ok(None) };
        let [columns, rows] = size;
        let slice = Slice { sample: self.first_sample, samples: samples.max(1), columns, rows, ..Slice::zeroed() };
        let coverage = self.coverage.as_mut().filter(|_| wants_coverages);
        let coverages = coverage.map(|pass| pass.start(device, size, &slice)).transpose()?;
        let albedos = self.albedos.as_mut().filter(|_| wants_albedos);
        let albedos = albedos.map(|pass| pass.start(device, size, &slice)).transpose()?;
        Ok(Some(ReconstructedFilm { device, film, guides, coverages, albedos, samples, begun, row, column }))
    }

    /// Submits slices; a `round` after the first resumes their suspended paths.
    fn submit(&mut self, slices: &[Slice], round: u32) {
        if let Some(suspended) = &self.suspended {
            suspended.begin(&self.device, round);
        }
        let gpu = &self.device.device;
        let mut bytes = vec![0; self.slice_stride as usize * slices.len()];
        for (place, slice) in bytes.chunks_mut(self.slice_stride as usize).zip(slices) {
            place[..size_of::<Slice>()].copy_from_slice(bytemuck::bytes_of(slice));
        }
        self.device.queue.write_buffer(&self.slices, 0, &bytes);
        let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("trace") });
        {
            let timestamp_writes = self.timer.as_mut().map(GpuTimer::next);
            let mut pass =
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("trace"), timestamp_writes });
            for (k, slice) in slices.iter().enumerate() {
                pass.set_pipeline(&self.kernel.pipeline);
                pass.set_bind_group(0, &self.bindings, &[k as u32 * self.slice_stride]);
                let groups = [slice.columns.div_ceil(self.group_width), slice.rows.div_ceil(BAND).max(1)];
                pass.dispatch_workgroups(groups[0], groups[1], 1);
                if let Some((kernel, _)) = self.edges.as_ref().filter(|_| slice.edges > 0 && round == 0) {
                    let groups = slice.edges.div_ceil(EDGES_PER_GROUP);
                    pass.set_pipeline(&kernel.pipeline);
                    pass.dispatch_workgroups(groups.min(MAX_GROUPS_ACROSS), groups.div_ceil(MAX_GROUPS_ACROSS), 1);
                }
            }
        }
        if let Some(suspended) = &self.suspended {
            suspended.end(&mut encoder);
        }
        let index = self.device.queue.submit([encoder.finish()]);
        let samples = slices.iter().map(Slice::work).sum();
        self.in_flight.push_back((index, samples, Instant::now()));
    }

    /// Waits for the oldest submission; adapts the work of the next ones to its time.
    fn complete_oldest(&mut self) -> Result<(), RenderError> {
        let Some((index, samples, submitted)) = self.in_flight.pop_front() else { return Ok(()) };
        let timeout = self.device.timeout();
        self.device
            .device
            .poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: Some(timeout) })
            .map_err(|error| self.device.error(format!("{error} after {} s", timeout.as_secs())))?;
        self.device.check()?;
        self.adapt(samples, submitted);
        Ok(())
    }

    /// Adapts the work of the next submissions to the time of one that is complete now.
    fn adapt(&mut self, samples: f64, submitted: Instant) {
        let now = Instant::now();
        // It started after the one before was complete, or at its own submission.
        let took = now.duration_since(self.last_completion.max(submitted)).as_secs_f64().max(1e-6);
        self.last_completion = now;
        if samples > 0.0 {
            let fitting = samples * self.target.as_secs_f64() / took;
            let most = f64::from(self.size[0]) * f64::from(self.size[1]) * MAX_DISPATCHES as f64;
            self.quota = fitting.clamp(self.quota * 0.25, self.quota * 4.0).clamp(f64::from(BAND * 8), most);
        }
    }

    /// Next slice towards `upto` samples, of about `work` samples summed over pixels: whole workgroups, and whole bands if
    /// they fit.
    fn next_slice(&mut self, upto: u32, work: f64) -> Slice {
        let Rect { x, y, width, height } = self.active[self.current];
        let Progress { samples, row, column, .. } = self.submitted;
        let sample = self.first_sample + samples;
        if self.is_whole() {
            let sharing = splitting::samples_sharing_ray(sample, self.config.splitting, upto - samples);
            self.submitted.begun = sharing.max(self.samples_per_dispatch.min(upto - samples));
        }
        let begun = self.submitted.begun;
        let pixels = work / f64::from(begun);
        let slice = |rows: u32, columns: u32| Slice {
            sample,
            samples: begun,
            first_row: y + row,
            rows: rows.min(height - row),
            first_column: x + column,
            columns,
            guide_samples: if self.guides.is_some() && samples < FILM_SAMPLES { samples + 1 } else { 0 },
            ..Slice::zeroed()
        };
        let band = f64::from(width) * f64::from(BAND);
        let slice = if column > 0 || pixels < band {
            let columns = ((pixels / f64::from(BAND)) as u32).max(1).next_multiple_of(self.group_width);
            let columns = columns.min(width - column);
            slice(BAND, columns)
        } else {
            slice((pixels / band) as u32 * BAND, width)
        };
        let slice = self.with_edges(slice);
        let next = &mut self.submitted;
        next.column = column + slice.columns;
        if next.column == width {
            (next.row, next.column) = (row + slice.rows, 0);
        }
        if next.row == height {
            self.current = (self.current + 1) % self.active.len();
            *next = match self.current {
                0 => Progress { samples: samples + begun, ..Progress::default() },
                _ => Progress { samples, begun, ..Progress::default() },
            };
        }
        slice
    }

    /// The slice, with the edges of emitters in its rows.
    fn with_edges(&self, slice: Slice) -> Slice {
        let Some((_, edges)) = &self.edges else { return slice };
        let places = edges.in_rows(slice.first_row..slice.first_row + slice.rows);
        Slice { first_edge: places.start as u32, edges: places.len() as u32, ..slice }
    }

    /// Slices of a submission towards `samples` samples of every pixel.
    fn next_slices(&mut self, samples: u32) -> Vec<Slice> {
        let mut slices = Vec::new();
        if let Some(photons) = self.photons.as_ref().filter(|_| self.is_whole() && self.submitted.samples < samples) {
            photons.upload(&self.device.queue, self.first_sample + self.submitted.samples);
        }
        let mut left = match self.suspended {
            Some(_) => self.quota.min(f64::from(loop_limit::CAPACITY - 8 * BAND)),
            None => self.quota,
        };
        while left > 0.0 && self.submitted.samples < samples && slices.len() < MAX_DISPATCHES {
            let slice = self.next_slice(samples, left);
            left -= slice.work();
            slices.push(slice);
            // The next sample has other photons.
            if self.photons.is_some() && self.is_whole() {
                break;
            }
        }
        slices
    }

    /// Submits work as [`advance`](Self::advance) and waits for it.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn advance_async(&mut self, samples: u32) -> Result<(), RenderError> {
        let slices = self.next_slices(samples);
        if slices.is_empty() {
            return Ok(());
        }
        self.submit(&slices, 0);
        self.device.finished().await?;
        if let Some((_, samples, submitted)) = self.in_flight.pop_front() {
            self.adapt(samples, submitted);
        }
        Ok(())
    }

    /// Film so far. The caller ensures that no sample is half done.
    #[cfg(target_family = "wasm")]
    pub(crate) async fn film_async(&mut self) -> Result<Film, RenderError> {
        let copy = self.copy_film(false)?;
        let device = self.device.clone();
        let film = device.read_async(&copy.buffer, copy.bytes, |bytes| self.film_of(copy.samples, bytes)).await?;
        self.staging = Some(copy.buffer);
        Ok(film)
    }

    /// Submits work towards `samples` samples of every pixel, for about the target time.
    pub(crate) fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        if self.timer.as_ref().is_some_and(GpuTimer::is_full) {
            self.gpu_time()?;
        }
        let mut slices = self.next_slices(samples);
        if self.suspended.is_some() && !slices.is_empty() {
            loop_limit::assign_slots(&mut slices);
            return self.trace_to_the_end(&slices);
        }
        if !slices.is_empty() {
            self.submit(&slices, 0);
        }
        while self.in_flight.len() > usize::from(!slices.is_empty()) {
            self.complete_oldest()?;
        }
        Ok(())
    }

    /// Traces the paths of slices and resumes them until all have ended.
    fn trace_to_the_end(&mut self, slices: &[Slice]) -> Result<(), RenderError> {
        // Each round advances every path by at least one surface.
        for round in 0..=self.bounces.map_or(0, |bounces| bounces + 2) {
            if self.timer.as_ref().is_some_and(GpuTimer::is_full) {
                self.gpu_time()?;
            }
            self.submit(slices, round);
            self.wait()?;
            let Some(suspended) = &self.suspended else { return Ok(()) };
            if suspended.count(&self.device)? == 0 {
                return Ok(());
            }
        }
        Err(RenderError::LoopLimit { adapter: self.device.description.name.clone() })
    }

    /// Submitted samples of every pixel, with a fraction for one that is begun.
    pub(crate) fn samples_done(&self) -> f64 {
        let Progress { samples, begun, row, column } = self.submitted;
        if self.is_whole() {
            return f64::from(samples);
        }
        let pixels = |rects: &[Rect]| rects.iter().map(|rect| rect.pixels() as f64).sum::<f64>();
        let Rect { width, height, .. } = self.active[self.current];
        let band = BAND.min(height - row);
        let done = pixels(&self.active[..self.current]) + f64::from(row * width + band * column);
        f64::from(samples) + f64::from(begun) * done / pixels(&self.active)
    }

    /// True if every pixel has the same number of submitted samples.
    pub(crate) fn is_whole(&self) -> bool {
        self.current == 0 && self.submitted.row == 0 && self.submitted.column == 0
    }

    /// Waits for all submissions.
    pub(crate) fn wait(&mut self) -> Result<(), RenderError> {
        while !self.in_flight.is_empty() {
            self.complete_oldest()?;
        }
        Ok(())
    }

    /// Starts to measure the GPU time; returns false if the adapter does not support it.
    pub(crate) fn measure_gpu_time(&mut self) -> Result<bool, RenderError> {
        self.timer = GpuTimer::new(&self.device)?;
        Ok(self.timer.is_some())
    }

    /// GPU time since the measurement started; `None` without measurement. Waits for all submissions.
    pub(crate) fn gpu_time(&mut self) -> Result<Option<Duration>, RenderError> {
        self.wait()?;
        self.timer.as_mut().map(|timer| timer.read(&self.device)).transpose()
    }

    /// Renders only some pixels; films have only these.
    pub(crate) fn cropped(self, rect: Rect) -> Self {
        Self { rect, active: vec![rect], ..self }
    }

    /// Takes further samples only in these rectangles. The caller ensures that no sample is half done.
    pub(crate) fn restrict(&mut self, rects: Vec<Rect>) {
        self.active = rects;
    }

    /// Configuration of its kernel.
    pub(crate) fn config(&self) -> &KernelConfig {
        &self.config
    }

    /// True if edges of emitters have further camera rays.
    pub(crate) fn traces_edges(&self) -> bool {
        self.edges.is_some()
    }

    /// Number of light paths of each sample, with traced caustics.
    pub(crate) fn light_paths(&self) -> Option<u32> {
        self.photons.as_ref().and_then(|photons| photons.input.light_paths())
    }

    /// Reads the film back. The caller ensures that no sample is half done.
    pub(crate) fn film(&mut self) -> Result<Film, RenderError> {
        let copy = self.copy_film(false)?;
        self.finish(copy)
    }

    /// Starts to read the film back, and a new film at the next sample. Does not wait. The caller ensures that no sample is
    /// half done.
    pub(crate) fn take(&mut self) -> Result<FilmCopy, RenderError> {
        let copy = self.copy_film(true)?;
        self.first_sample += self.submitted.samples;
        self.submitted = Progress::default();
        Ok(copy)
    }

    /// Submits a copy of the rows of the film that are rendered; clears the film if `clear` is true.
    fn copy_film(&mut self, clear: bool) -> Result<FilmCopy, RenderError> {
        let row = 16 * u64::from(self.size[0]);
        let (start, bytes) = (row * u64::from(self.rect.y), row * u64::from(self.rect.height));
        let buffer = match self.staging.take().filter(|buffer| buffer.size() == bytes) {
            Some(buffer) => buffer,
            None => self.device.allocate(&wgpu::BufferDescriptor {
                label: Some("film copy"),
                size: bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })?,
        };
        let gpu = &self.device.device;
        let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("film copy") });
        self.film.update(&mut encoder);
        encoder.copy_buffer_to_buffer(&self.film.buffer, start, &buffer, 0, bytes);
        if clear {
            self.film.clear(&mut encoder, film_bytes(self.size));
        }
        let submission = self.device.queue.submit([encoder.finish()]);
        Ok(FilmCopy { buffer, bytes, submission, samples: self.submitted.samples })
    }

    /// Waits for a copy of a film, and reads it.
    pub(crate) fn finish(&mut self, copy: FilmCopy) -> Result<Film, RenderError> {
        let film = self
            .device
            .read_submitted(&copy.buffer, copy.bytes, copy.submission, |bytes| self.film_of(copy.samples, bytes))?;
        self.staging = Some(copy.buffer);
        Ok(film)
    }

    /// Film of the bytes of a copy: sums, and the number of rejected samples, of each pixel of the rows that are rendered.
    fn film_of(&self, samples: u32, bytes: &[u8]) -> Film {
        let Rect { x, width, height, .. } = self.rect;
        let columns = x as usize..(x + width) as usize;
        let row = self.size[0] as usize;
        let sums: &[[f32; 4]] = bytemuck::cast_slice(bytes);
        let mut film = Film::new(width, height);
        film.samples = samples;
        let rows = film.sums.par_chunks_mut(width as usize).zip(sums.par_chunks(row));
        let rejected = rows.map(|(pixels, sums)| {
            let sums = &sums[columns.clone()];
            pixels.iter_mut().zip(sums).for_each(|(pixel, [r, g, b, _])| *pixel = [*r, *g, *b]);
            sums.iter().any(|[.., rejected]| *rejected > 0.0)
        });
        let rows: Vec<bool> = rejected.collect();
        for (y, _) in rows.into_iter().enumerate().filter(|(_, rejected)| *rejected) {
            for (x, [.., count]) in sums[y * row..][columns.clone()].iter().enumerate() {
                film.count_rejected(y * width as usize + x, *count as u32);
            }
        }
        film
    }
}

/// Film that is being read back.
pub(crate) struct FilmCopy {
    buffer: wgpu::Buffer,
    bytes: u64,
    submission: wgpu::SubmissionIndex,
    samples: u32,
}
