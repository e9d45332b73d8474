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
pub(crate) struct GpuTimer {
    timestamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
    /// Number of passes since the last readback.
    passes: u32,
    total: Duration,
}

impl GpuTimer {
    /// Creates a timer; `None` if the adapter does not support timestamps.
    pub(crate) fn new(device: &Device) -> Result<Option<Self>, RenderError> {
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
    pub(crate) fn is_full(&self) -> bool {
        self.passes == PASSES
    }

    /// Timestamps that the next pass must write. The timer must not be full.
    pub(crate) fn next(&mut self) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = 2 * self.passes;
        self.passes += 1;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.timestamps,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// Total time of all passes so far; waits for them.
    pub(crate) fn read(&mut self, device: &Device) -> Result<Duration, RenderError> {
        let passes: Duration = self.read_passes(device)?.iter().sum();
        self.total += passes;
        Ok(self.total)
    }

    /// Time of each pass since the last readback; waits for them.
    pub(crate) fn read_passes(&mut self, device: &Device) -> Result<Vec<Duration>, RenderError> {
        if self.passes == 0 {
            return Ok(Vec::new());
        }
        let timestamps = 2 * self.passes;
        let bytes = u64::from(timestamps) * TIMESTAMP_BYTES;
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("timestamps") });
        encoder.resolve_query_set(&self.timestamps, 0..timestamps, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.copy, 0, bytes);
        device.queue.submit([encoder.finish()]);
        self.passes = 0;
        let period = f64::from(device.queue.get_timestamp_period()) * 1e-9;
        let duration =
            |[began, ended]: &[u64; 2]| Duration::from_secs_f64(ended.saturating_sub(*began) as f64 * period);
        device.read(&self.copy, bytes, |bytes| bytemuck::cast_slice(bytes).iter().map(duration).collect())
    }
}
