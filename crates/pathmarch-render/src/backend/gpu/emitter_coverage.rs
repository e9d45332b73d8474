//! Coverage of the pixels of live pictures by emitters, on the GPU.

use super::bindings;
use super::device::Device;
use super::kernel_cache::Kernel;
use super::slice::{MAX_GROUPS_ACROSS, Slice};
use super::table_memory::Table;
use crate::error::RenderError;
use crate::integrator::emitter_coverage::COVERAGES_PER_GROUP;
use std::sync::Arc;

/// Kernel for coverages, with the buffers that it shares with the kernel of the samples.
pub(super) struct CoveragePass {
    pub(super) kernel: Arc<Kernel>,
    /// All tables, by their bindings.
    pub(super) tables: Vec<(u32, Table)>,
    pub(super) slices: wgpu::Buffer,
    /// Coverages of the last picture.
    pub(super) coverages: Option<Coverages>,
}

/// Coverages of a picture.
pub(super) struct Coverages {
    /// Vector of each pixel, see [`Coverage`](crate::integrator::emitter_coverage::Coverage).
    buffer: wgpu::Buffer,
    bindings: wgpu::BindGroup,
}

/// Bytes of the coverage of a pixel.
const COVERAGE_BYTES: u64 = 16;

impl CoveragePass {
    /// Starts to find the coverages of a picture of this size. Returns their buffer, which may be larger.
    pub(super) fn start(
        &mut self,
        device: &Device,
        size: [u32; 2],
        first_sample: u32,
    ) -> Result<&wgpu::Buffer, RenderError> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let bytes = COVERAGE_BYTES * pixels;
        let coverages = match self.coverages.take().filter(|coverages| coverages.buffer.size() >= bytes) {
            Some(coverages) => coverages,
            None => self.reserve(device, bytes)?,
        };
        let slice = Slice { sample: first_sample, columns: size[0], rows: size[1], ..bytemuck::Zeroable::zeroed() };
        device.queue.write_buffer(&self.slices, 0, bytemuck::bytes_of(&slice));
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("coverage") });
        {
            let descriptor = wgpu::ComputePassDescriptor { label: Some("coverage"), timestamp_writes: None };
            let mut pass = encoder.begin_compute_pass(&descriptor);
            pass.set_pipeline(&self.kernel.pipeline);
            pass.set_bind_group(0, &coverages.bindings, &[0]);
            let groups = (pixels as u32).div_ceil(COVERAGES_PER_GROUP);
            pass.dispatch_workgroups(groups.min(MAX_GROUPS_ACROSS), groups.div_ceil(MAX_GROUPS_ACROSS), 1);
        }
        device.queue.submit([encoder.finish()]);
        Ok(&self.coverages.insert(coverages).buffer)
    }

    /// Buffer for so many bytes of coverages.
    fn reserve(&self, device: &Device, bytes: u64) -> Result<Coverages, RenderError> {
        let buffer = device.allocate(&wgpu::BufferDescriptor {
            label: Some("coverages"),
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
            label: Some("coverage"),
            layout: &self.kernel.layout,
            entries: &entries,
        });
        Ok(Coverages { buffer, bindings })
    }
}
