//! A picture being rendered on the GPU.
//!
//! The kernel ([`super::kernel`]) is printed for the scene. A dispatch computes one sample of
//! a band of rows; bands and the number of dispatches in a submission adapt so that a submission takes about
//! [`TARGET`], which keeps displays alive on weak adapters and strong ones busy. Two submissions are in flight.

use super::Device;
use super::kernel::kernel;
use crate::error::RenderError;
use crate::film::Film;
use crate::frame::Prepared;
use bytemuck::{Pod, Zeroable};
use pathmarch_field::wgsl::{MAX_UNIFORM_VECTORS, Program};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};
use wgpu::util::DeviceExt;

/// Aim for the time of one submission.
const TARGET: Duration = Duration::from_millis(25);
/// The most dispatches in a submission.
const MAX_DISPATCHES: usize = 256;
/// A submission that takes this long has hung.
const HUNG: Duration = Duration::from_secs(120);
/// Storage buffers that the kernel binds at most: leaves, materials, lights, film, tables, sky, and the parameters of a
/// large field.
pub(crate) const STORAGE_BUFFERS: u32 = 7;
/// Shapes beyond which a field is too large to be compiled as code.
pub(crate) const MAX_LEAVES: usize = 2048;

/// The layout is that of `Slice` in `transport/frame.wgsl`.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Slice {
    sample: u32,
    first_row: u32,
    rows: u32,
    padding: u32,
}

pub(crate) struct GpuJob {
    device: Arc<Device>,
    pipeline: wgpu::ComputePipeline,
    bindings: wgpu::BindGroup,
    slices: wgpu::Buffer,
    slice_stride: u32,
    film: wgpu::Buffer,
    size: [u32; 2],
    first_sample: u32,
    /// Samples and rows handed to the GPU.
    submitted: (u32, u32),
    /// Rows of one sample that take about [`TARGET`].
    quota: f64,
    in_flight: VecDeque<(wgpu::SubmissionIndex, f64, Instant)>,
    last_completion: Instant,
    pub(crate) compile_time: Duration,
}

impl GpuJob {
    pub(crate) fn new(device: Arc<Device>, prepared: &Prepared, first_sample: u32) -> Result<Self, RenderError> {
        let frame = &prepared.frame;
        let gpu = &device.device;
        let limits = gpu.limits();
        let film_bytes = 16 * u64::from(frame.width) * u64::from(frame.height);
        if film_bytes > limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) {
            return Err(RenderError::TooLarge {
                adapter: device.description.name.clone(),
                what: format!("a picture of {}x{} pixels", frame.width, frame.height),
            });
        }
        if prepared.leaves.len() > MAX_LEAVES {
            return Err(RenderError::TooLarge {
                adapter: device.description.name.clone(),
                what: format!("a field of {} shapes (at most {MAX_LEAVES} are compiled)", prepared.leaves.len()),
            });
        }
        let program = Program::new(&prepared.field);
        let started = Instant::now();
        let validation = gpu.push_error_scope(wgpu::ErrorFilter::Validation);
        let memory = gpu.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let uniform_parameters = program.parameters.len() <= MAX_UNIFORM_VECTORS;
        let layout = bind_group_layout(gpu, uniform_parameters);
        let descriptor = wgpu::ShaderModuleDescriptor {
            label: Some("trace"),
            source: wgpu::ShaderSource::Wgsl(kernel(prepared, &program).into()),
        };
        // SAFETY: every loop of the kernel counts to a constant or to `bounces`, lights or iterations checked on the CPU,
        // and every index comes from tables built together with it; no text of a user is in it.
        let module = unsafe { gpu.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) };
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("trace"),
            layout: Some(&gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("trace"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            })),
            module: &module,
            entry_point: Some("trace"),
            compilation_options: Default::default(),
            cache: None,
        });
        let constant = |label, contents: &[u8], usage| {
            // A binding may not be empty.
            let contents = if contents.is_empty() { &[0; 256] } else { contents };
            gpu.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let (uniform, storage) = (wgpu::BufferUsages::UNIFORM, wgpu::BufferUsages::STORAGE);
        let slice_stride = limits.min_uniform_buffer_offset_alignment.max(16);
        let slices = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("slices"),
            size: u64::from(slice_stride) * MAX_DISPATCHES as u64,
            usage: uniform | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let film = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("film"),
            size: film_bytes,
            usage: storage | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let parameters_usage = if uniform_parameters { uniform } else { storage };
        let buffers = [
            constant("frame", bytemuck::bytes_of(frame), uniform),
            constant("parameters", bytemuck::cast_slice(&program.parameters), parameters_usage),
            constant("leaves", bytemuck::cast_slice(&prepared.leaves), storage),
            constant("materials", bytemuck::cast_slice(&prepared.materials), storage),
            constant("lights", bytemuck::cast_slice(&prepared.lights), storage),
            constant("tables", bytemuck::cast_slice(&prepared.tables), storage),
            constant("sky", bytemuck::cast_slice(&prepared.sky.texels()), storage),
        ];
        let slice = wgpu::BufferBinding { buffer: &slices, offset: 0, size: wgpu::BufferSize::new(16) };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let bindings = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("trace"),
            layout: &layout,
            entries: &[
                entry(0, buffers[0].as_entire_binding()),
                entry(1, wgpu::BindingResource::Buffer(slice)),
                entry(2, buffers[1].as_entire_binding()),
                entry(3, buffers[2].as_entire_binding()),
                entry(4, buffers[3].as_entire_binding()),
                entry(5, buffers[4].as_entire_binding()),
                entry(6, film.as_entire_binding()),
                entry(7, buffers[5].as_entire_binding()),
                entry(8, buffers[6].as_entire_binding()),
            ],
        });
        for scope in [memory, validation] {
            if let Some(error) = pollster::block_on(scope.pop()) {
                return Err(device.error(error));
            }
        }
        let now = Instant::now();
        let mut job = Self {
            device,
            pipeline,
            bindings,
            slices,
            slice_stride,
            film,
            size: [frame.width, frame.height],
            first_sample,
            submitted: (0, 0),
            quota: 8.0,
            in_flight: VecDeque::new(),
            last_completion: now,
            compile_time: Duration::ZERO,
        };
        // Drivers compile at the first dispatch: make one of no rows.
        job.submit(&[Slice { sample: 0, first_row: 0, rows: 0, padding: 0 }], 0.0);
        job.complete_oldest()?;
        job.compile_time = started.elapsed();
        Ok(job)
    }

    fn submit(&mut self, slices: &[Slice], rows: f64) {
        let gpu = &self.device.device;
        let mut bytes = vec![0; self.slice_stride as usize * slices.len()];
        for (place, slice) in bytes.chunks_mut(self.slice_stride as usize).zip(slices) {
            place[..16].copy_from_slice(bytemuck::bytes_of(slice));
        }
        self.device.queue.write_buffer(&self.slices, 0, &bytes);
        let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("trace") });
        {
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("trace"), timestamp_writes: None });
            pass.set_pipeline(&self.pipeline);
            for (k, slice) in slices.iter().enumerate() {
                pass.set_bind_group(0, &self.bindings, &[k as u32 * self.slice_stride]);
                pass.dispatch_workgroups(self.size[0].div_ceil(8), slice.rows.div_ceil(8).max(1), 1);
            }
        }
        let index = self.device.queue.submit([encoder.finish()]);
        self.in_flight.push_back((index, rows, Instant::now()));
    }

    /// Waits for the oldest submission and learns from its time.
    fn complete_oldest(&mut self) -> Result<(), RenderError> {
        let Some((index, rows, submitted)) = self.in_flight.pop_front() else { return Ok(()) };
        self.device
            .device
            .poll(wgpu::PollType::Wait { submission_index: Some(index), timeout: Some(HUNG) })
            .map_err(|error| self.device.error(format!("{error} after {} s", HUNG.as_secs())))?;
        self.device.check()?;
        let now = Instant::now();
        // It ran from the completion of the one before, or from its own submission.
        let took = now.duration_since(self.last_completion.max(submitted)).as_secs_f64().max(1e-6);
        self.last_completion = now;
        if rows > 0.0 {
            let fitting = rows * TARGET.as_secs_f64() / took;
            let rows_of_all = f64::from(self.size[1]) * MAX_DISPATCHES as f64;
            self.quota = fitting.clamp(self.quota * 0.25, self.quota * 4.0).clamp(8.0, rows_of_all);
        }
        Ok(())
    }

    /// Does about [`TARGET`] of work towards `samples` samples of every pixel.
    pub(crate) fn advance(&mut self, samples: u32) -> Result<(), RenderError> {
        let mut slices = Vec::new();
        let mut rows_left = self.quota as u32;
        let (mut sample, mut row) = self.submitted;
        while rows_left > 0 && sample < samples && slices.len() < MAX_DISPATCHES {
            // Whole workgroups of eight rows, so that no lane is idle.
            let rows = rows_left.next_multiple_of(8).min(self.size[1] - row);
            slices.push(Slice { sample: self.first_sample + sample, first_row: row, rows, padding: 0 });
            rows_left = rows_left.saturating_sub(rows);
            row += rows;
            if row == self.size[1] {
                (sample, row) = (sample + 1, 0);
            }
        }
        if !slices.is_empty() {
            let rows = slices.iter().map(|slice| f64::from(slice.rows)).sum();
            self.submit(&slices, rows);
            self.submitted = (sample, row);
        }
        while self.in_flight.len() > usize::from(!slices.is_empty()) {
            self.complete_oldest()?;
        }
        Ok(())
    }

    /// Whole samples handed to the GPU, and rows of the next one.
    pub(crate) fn submitted(&self) -> (u32, u32) {
        self.submitted
    }

    /// Waits for everything handed to the GPU.
    pub(crate) fn wait(&mut self) -> Result<(), RenderError> {
        while !self.in_flight.is_empty() {
            self.complete_oldest()?;
        }
        Ok(())
    }

    /// Reads the film back; the caller has seen to it that no sample is half done.
    pub(crate) fn film(&mut self) -> Result<Film, RenderError> {
        self.wait()?;
        let gpu = &self.device.device;
        let memory = gpu.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let copy = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("film copy"),
            size: self.film.size(),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        if let Some(error) = pollster::block_on(memory.pop()) {
            return Err(self.device.error(error));
        }
        let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("film copy") });
        encoder.copy_buffer_to_buffer(&self.film, 0, &copy, 0, self.film.size());
        self.device.queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        copy.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only if this function has already failed.
            let _ = sender.send(result);
        });
        gpu.poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(HUNG) })
            .map_err(|error| self.device.error(error))?;
        self.device.check()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(self.device.error(error)),
            Err(error) => return Err(self.device.error(error)),
        }
        let view = copy.slice(..).get_mapped_range().map_err(|error| self.device.error(error))?;
        let sums: &[[f32; 4]] = bytemuck::cast_slice(&view);
        let mut film = Film::new(self.size[0], self.size[1]);
        film.samples = self.submitted.0;
        for (pixel, &[r, g, b, left_out]) in sums.iter().enumerate() {
            film.sums[pixel] = [r, g, b];
            film.leave_out(pixel, left_out as u32);
        }
        Ok(film)
    }
}

fn bind_group_layout(gpu: &wgpu::Device, uniform_parameters: bool) -> wgpu::BindGroupLayout {
    let entry = |binding, ty, has_dynamic_offset| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    };
    let uniform = wgpu::BufferBindingType::Uniform;
    let table = wgpu::BufferBindingType::Storage { read_only: true };
    let film = wgpu::BufferBindingType::Storage { read_only: false };
    gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("trace"),
        entries: &[
            entry(0, uniform, false),
            entry(1, uniform, true),
            entry(2, if uniform_parameters { uniform } else { table }, false),
            entry(3, table, false),
            entry(4, table, false),
            entry(5, table, false),
            entry(6, film, false),
            entry(7, table, false),
            entry(8, table, false),
        ],
    })
}
