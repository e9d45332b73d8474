//! GPU timer: duration of compute passes on the device's own clock.
//!
//! **Idea.** A pass writes a timestamp at its beginning and one at its end; the timer sums their differences. The sum excludes
//! the work of the CPU between passes. Next to the wall-clock time it shows whether the kernel or the CPU is the bottleneck.
//!
//! **Cost.** Two timestamps for each pass, and a readback of 16 KiB on request. A job has a timer only if it is asked to
//! measure.

use super::device::Device;
use crate::error::RenderError;
use std::time::Duration;

/// Largest number of passes between two readbacks.
const PASSES: u32 = 1024;
/// Size of a timestamp, bytes.
const TIMESTAMP_BYTES: u64 = wgpu::QUERY_SIZE as u64;

/// Timer of compute passes.
pub(super) struct GpuTimer {
    timestamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
    /// Number of passes since the last readback.
    passes: u32,
    total: Duration,
}

impl GpuTimer {
    /// Creates a timer; `None` if the adapter does not support timestamps.
    pub(super) fn new(device: &Device) -> Result<Option<Self>, RenderError> {
        if !device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let buffer = |label, usage| {
            device.allocate(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 2 * u64::from(PASSES) * TIMESTAMP_BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Ok(Some(Self {
            timestamps: device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timestamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES,
            }),
            resolved: buffer("timestamps", wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC)?,
            copy: buffer("timestamps copy", wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ)?,
            passes: 0,
            total: Duration::ZERO,
        }))
    }

    /// True if it must be read before the next pass.
    pub(super) fn is_full(&self) -> bool {
        self.passes == PASSES
    }

    /// Timestamps that the next pass must write. The timer must not be full.
    pub(super) fn next(&mut self) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = 2 * self.passes;
        self.passes += 1;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.timestamps,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// Total time of all passes so far; waits for them.
    pub(super) fn read(&mut self, device: &Device) -> Result<Duration, RenderError> {
        if self.passes > 0 {
            let timestamps = 2 * self.passes;
            let bytes = u64::from(timestamps) * TIMESTAMP_BYTES;
            let mut encoder =
                device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("timestamps") });
            encoder.resolve_query_set(&self.timestamps, 0..timestamps, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, bytes);
            device.queue.submit([encoder.finish()]);
            let ticks = device.read(&self.copy, bytes, |bytes| {
                let pairs = bytemuck::cast_slice::<u8, [u64; 2]>(bytes);
                pairs.iter().map(|[began, ended]| ended.saturating_sub(*began)).sum::<u64>()
            })?;
            let nanoseconds = ticks as f64 * f64::from(device.queue.get_timestamp_period());
            self.total += Duration::from_secs_f64(nanoseconds * 1e-9);
            self.passes = 0;
        }
        Ok(self.total)
    }
}
