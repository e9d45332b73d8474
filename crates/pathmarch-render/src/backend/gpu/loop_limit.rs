//! Long paths on adapters that end the loops of an invocation.
//!
//! Mesa's llvmpipe ends *every* loop of an invocation once all its loops together have taken 65,535 turns
//! (`LP_MAX_TGSI_LOOP_ITERATIONS` in its source): the picture is then wrong, and nothing reports it. A path that is
//! sphere-traced through fractals takes more.
//!
//! **Idea.** Once the limit has struck, a loop of two turns takes only one, so that the kernel can tell. After each
//! surface of a path it asks; where loops were ended, the path as it was before that surface is kept, and goes on from
//! there in the next dispatch, which starts to count anew. So every dispatch brings every path at least one surface on, unless a
//! single surface takes more turns than the limit: then the job fails with a sentence that says so. Modes that trace no paths,
//! and paths that share a ray of the camera, are not resumed and fail likewise.
//!
//! **Cost.** Only software adapters have this in their kernels, and only scenes with loops ([`Field::has_loops`]): one
//! question for each surface, 96 bytes for each path of a submission, and a wait for each submission.

use super::device::Device;
use super::slice::Slice;
use crate::error::RenderError;
use crate::wgsl::shared_struct;
use bytemuck::{Pod, Zeroable};
#[cfg(doc)]
use pathmarch_field::Field;

/// Paths of a submission at most.
pub(super) const CAPACITY: u32 = 1 << 16;

/// Header of the suspended paths; the paths follow it.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Header {
    count: u32,
    round: u32,
    turns: u32,
    padding: u32,
}

shared_struct! {
    /// State of a path before a surface.
    pub(super) struct SuspendedPath as SuspendedPath {
        origin: [f32; 3],
        length: f32,
        direction: [f32; 3],
        scatter_pdf: f32,
        previous_vertex: [f32; 3],
        index_square: f32,
        throughput: [f32; 3],
        /// Number of surfaces that the path has left, or FINISHED.
        surfaces: u32,
        radiance: [f32; 3],
        passed_clear_glass: u32,
        medium: [f32; 3],
        padding: u32,
    }
}

/// Room for the paths of a submission that the adapter may cut short.
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
        let header = Header { count: 0, round, turns: 2, padding: 0 };
        device.queue.write_buffer(&self.buffer, 0, bytemuck::bytes_of(&header));
    }

    /// Has the count of a submission copied at its end.
    pub(super) fn end(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.buffer, 0, &self.copy, 0, size_of::<Header>() as u64);
    }

    /// Number of paths that the last submission left unfinished; waits for it.
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
