//! Kernels that find a vector for each pixel of a live picture from its guides: [coverage by
//! emitters](crate::integrator::emitter_coverage), or [albedo](crate::integrator::pixel_albedo). They share the bindings of the
//! kernel of the samples, and write the vectors in place of the film.

use super::bindings;
use super::device::Device;
use super::kernel_cache::Kernel;
use super::slice::{MAX_GROUPS_ACROSS, Slice};
use super::table_memory::Table;
use crate::error::RenderError;
use std::sync::Arc;

/// Kernel for vectors of pixels, with the buffers that it shares with the kernel of the samples.
pub(super) struct PixelPass {
    pub(super) label: &'static str,
    pub(super) kernel: Arc<Kernel>,
    /// Number of pixels of a workgroup.
    pub(super) pixels_per_group: u32,
    /// All tables, by their bindings.
    pub(super) tables: Vec<(u32, Table)>,
    pub(super) slices: wgpu::Buffer,
    /// Vectors of the last picture.
    pub(super) vectors: Option<PixelVectors>,
}

/// Vectors of the pixels of a picture.
pub(super) struct PixelVectors {
    buffer: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

/// Bytes of the vector of a pixel.
const VECTOR_BYTES: u64 = 16;

impl PixelPass {
    /// Starts to find the vectors of the pixels of a picture of this size, for the slice's picture and samples. Returns their
    /// buffer, which may be larger.
    pub(super) fn start(
        &mut self,
        device: &Device,
        [width, height]: [u32; 2],
        slice: &Slice,
    ) -> Result<&wgpu::Buffer, RenderError> {
        let pixels = u64::from(width) * u64::from(height);
        let bytes = VECTOR_BYTES * pixels;
        let vectors = match self.vectors.take().filter(|vectors| vectors.buffer.size() >= bytes) {
            Some(vectors) => vectors,
            None => self.reserve(device, bytes)?,
        };
        device.queue.write_buffer(&self.slices, 0, bytemuck::bytes_of(slice));
        let label = Some(self.label);
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
        {
            let descriptor = wgpu::ComputePassDescriptor { label, timestamp_writes: None };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&self.kernel.pipeline);
            pass.set_bind_group(0, &vectors.bindings, &[0]);
            let groups = (pixels as u32).div_ceil(self.pixels_per_group);
            pass.dispatch_workgroups(groups.min(MAX_GROUPS_ACROSS), groups.div_ceil(MAX_GROUPS_ACROSS), 1);
        }
        device.queue.submit([encoder.finish()]);
        Ok(&self.vectors.insert(vectors).buffer)
    }

    /// Buffer for so many bytes of vectors.
    fn reserve(&self, device: &Device, bytes: u64) -> Result<PixelVectors, RenderError> {
        let buffer = device.allocate(&wgpu::BufferDescriptor {
            label: Some(self.label),
            size: bytes,
            usage: wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        })?;
        let slice = wgpu::BufferBinding {
            buffer: &self.slices,
            offset: 0,
            size: wgpu::BufferSize::new(size_of::<Slice>() as u64),
        };
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let mut entries = vec![
            entry(bindings::SLICE, wgpu::BindingResource::Buffer(slice)),
            entry(bindings::FILM, buffer.as_entire_binding()),
        ];
        entries.extend(self.tables.iter().map(|(binding, table)| entry(*binding, table.resource())));
        let bindings = device.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(self.label),
            layout: &self.kernel.layout,
            entries: &entries,
        });
        Ok(PixelVectors { buffer, bindings })
    }
}
