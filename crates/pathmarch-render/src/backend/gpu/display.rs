//! Display pass: tone-maps a film to 8-bit sRGB codes and reads them back.
//!
//! The readback has four bytes a pixel, a quarter of the film. Any window can show it, also one on another device, graphics
//! API or adapter. The tone curves are printed from [`crate::output::tonemap`].

use super::device::Device;
use super::slice::Progress;
use crate::error::RenderError;
use crate::mode::{Mode, uncertainty_wgsl};
use crate::output::tonemap::{self, Display};
use crate::wgsl::{declaration, shared_struct};

shared_struct! {
    /// Uniforms of the display pass.
    pub(super) struct DisplayUniforms as DisplayUniforms {
        width: u32,
        height: u32,
        /// Samples of every pixel.
        samples: u32,
        /// Further samples of the pixels above `row`, and in the eight rows from there of those left of `column`.
        begun: u32,
        row: u32,
        column: u32,
        /// Factor of radiance before the tone curve.
        gain: f32,
        /// Index of the tone curve.
        tonemap: u32,
        /// Not 0 if the film contains moments of luminance.
        variance: u32,
    }
}

/// Compiled display pass of a device.
pub(crate) struct DisplayPass {
    pipeline: wgpu::ComputePipeline,
    uniforms: wgpu::Buffer,
}

/// Buffers of the display pass for films up to a size.
pub(crate) struct DisplayBuffers {
    codes: wgpu::Buffer,
    copy: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

impl DisplayPass {
    pub(crate) fn new(gpu: &wgpu::Device) -> Self {
        let uniforms = declaration::<DisplayUniforms>();
        let code = tonemap::wgsl() + &uncertainty_wgsl() + &uniforms + include_str!("display.wgsl");
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("display"),
            source: wgpu::ShaderSource::Wgsl(code.into()),
        });
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("display"),
            layout: None,
            module: &module,
            entry_point: Some("show"),
            compilation_options: Default::default(),
            cache: None,
        });
        let uniforms = gpu.create_buffer(&wgpu::BufferDescriptor {
            label: Some("display"),
            size: size_of::<DisplayUniforms>() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { pipeline, uniforms }
    }

    /// Allocates the buffers for a film.
    pub(crate) fn buffers(&self, device: &Device, film: &wgpu::Buffer) -> Result<DisplayBuffers, RenderError> {
        let gpu = &device.device;
        let size = film.size() / 4;
        let buffer = |usage| {
            device.allocate(&wgpu::BufferDescriptor { label: Some("display"), size, usage, mapped_at_creation: false })
        };
        let codes = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC)?;
        let copy = buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ)?;
        let bindings = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("display"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.uniforms.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: film.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 2, resource: codes.as_entire_binding() },
            ],
        });
        Ok(DisplayBuffers { codes, copy, bindings })
    }

    /// Tone-maps a film: red, green, blue and 255 for each pixel. Waits for the device.
    pub(crate) fn show(
        &self,
        device: &Device,
        buffers: &DisplayBuffers,
        [width, height]: [u32; 2],
        Progress { samples, begun, row, column }: Progress,
        display: &Display,
        mode: Mode,
    ) -> Result<Vec<u8>, RenderError> {
        let (gain, tonemap) = (display.gain(), display.tonemap as u32);
        let variance = u32::from(mode == Mode::Variance);
        let uniforms = DisplayUniforms { width, height, samples, begun, row, column, gain, tonemap, variance };
        device.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("display") });
        {
            let mut pass = encoder
                .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("display"), timestamp_writes: None });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &buffers.bindings, &[]);
            pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
        }
        let bytes = 4 * u64::from(width) * u64::from(height);
        encoder.copy_buffer_to_buffer(&buffers.codes, 0, &buffers.copy, 0, bytes);
        device.queue.submit([encoder.finish()]);
        device.read(&buffers.copy, bytes, <[u8]>::to_vec)
    }
}
