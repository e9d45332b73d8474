//! Long paths on adapters that limit the loops of an invocation.
//!
//! Mesa's llvmpipe ends *every* loop of an invocation after 65,535 iterations of all its loops together
//! (`LP_MAX_TGSI_LOOP_ITERATIONS` in its source). The picture is then wrong, and no error is reported. Sphere-traced paths
//! through fractals exceed the limit.
//!
//! **Idea.** Beyond the limit, a loop of two iterations takes only one, so that the kernel can detect it. The kernel checks
//! after each surface of a path. If loops were ended, it stores the path's state before that surface, and the next dispatch
//! resumes the path from there with a new count. Every dispatch advances every path by at least one surface, unless a single
//! surface exceeds the limit: then the job fails with an error message. Modes that trace no paths, and paths that share a
//! camera ray, are not resumed and fail likewise.
//!
//! **Cost.** Only kernels for software adapters include this, and only for scenes with loops ([`Field::has_loops`]): one check
//! for each surface, 160 bytes for each path of a submission, and a wait for each submission.

use super::device::Device;
use super::slice::Slice;
use crate::error::RenderError;
use crate::wgsl::shared_struct;
use bytemuck::{Pod, Zeroable};
#[cfg(doc)]
use pathmarch_field::Field;

/// Largest number of paths of a submission.
pub(super) const CAPACITY: u32 = 1 << 16;

/// Header of the buffer of suspended paths; the paths follow it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Header {
    count: u32,
    round: u32,
    iterations: u32,
    padding: u32,
}

shared_struct! {
    /// State of a suspended path, before a surface.
    pub(super) struct SuspendedPath as SuspendedPath {
        origin: [f32; 3],
        length: f32,
        direction: [f32; 3],
        scatter_pdf: f32,
        previous_vertex: [f32; 3],
        index_square: f32,
        throughput: [f32; 3],
        /// Number of surfaces from which the path has continued, or FINISHED.
        surfaces: u32,
        radiance: [f32; 3],
        /// Bit 0: its lights are counted; bit 1: it met photons.
        flags: u32,
        medium: [f32; 3],
        wavelength: f32,
        previous_normal: [f32; 3],
        medium_solids: u32,
        medium_scattering: [f32; 3],
        medium_forward: f32,
        medium_emission: [f32; 3],
        padding: u32,
        medium_around: [u32; 4],
    }
}

/// Buffer for the paths of a submission that the adapter may interrupt.
pub(super) struct SuspendedPaths {
    pub(super) buffer: wgpu::Buffer,
    copy: wgpu::Buffer,
}

impl SuspendedPaths {
    pub(super) fn new(device: &Device) -> Result<Self, RenderError> {
        let (storage, read) = (wgpu::BufferUsages::STORAGE, wgpu::BufferUsages::MAP_READ);
        let header = size_of::<Header>() as u64;
        let buffer = |label, size, usage| {
            device.allocate(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let paths = u64::from(CAPACITY) * size_of::<SuspendedPath>() as u64;
        let (to, from) = (wgpu::BufferUsages::COPY_DST, wgpu::BufferUsages::COPY_SRC);
        Ok(Self {
            buffer: buffer("suspended paths", header + paths, storage | to | from)?,
            copy: buffer("suspended paths copy", header, read | to)?,
        })
    }

    /// Sets the header for a submission.
    pub(super) fn begin(&self, device: &Device, round: u32) {
        let header = Header { count: 0, round, iterations: 2, padding: 0 };
        device.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&header));
    }

    /// Copies the count at the end of a submission.
    pub(super) fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &self.copy, 0, size_of::<Header>() as u64);
    }

    /// Number of unfinished paths of the last submission; waits for it.
    pub(super) fn count(&self, device: &Device) -> Result<u32, RenderError> {
        let bytes = size_of::<Header>() as u64;
        device.read(&self.copy, bytes, |bytes| bytemuck::pod_read_unaligned::<Header>(bytes).count)
    }
}

/// Assigns each slice its range of slots for suspended paths.
pub(super) fn assign_slots(slices: &mut [Slice]) {
    let mut first_slot = 0;
    for slice in slices {
        slice.first_slot = first_slot;
        first_slot += slice.rows * slice.columns;
    }
}
