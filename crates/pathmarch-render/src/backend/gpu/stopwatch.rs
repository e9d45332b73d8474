//! How long compute passes take on the device's own clock.
//!
//! **Idea.** A pass writes a timestamp where it begins and one where it ends; their differences are summed. That leaves out
//! what the processor does between passes, so that next to the time on the wall it tells whether a picture waits for its
//! kernel or for us.
//!
//! **Cost.** Two timestamps for each pass, and a buffer of 16 KiB read when somebody asks. Only a job that is asked to
//! measure has one.

use super::device::Device;
use crate::error::RenderError;
use std::time::Duration;

/// Passes between two readings.
const PASSES: u32 = 1024;
/// Bytes of a timestamp.
const STAMP: u64 = wgpu::QUERY_SIZE as u64;

/// A clock for compute passes.
pub(super) struct Stopwatch {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copy: wgpu::Buffer,
    /// Passes since the last reading.
    passes: u32,
    total: Duration,
}

impl Stopwatch {
    /// None where the adapter has no timestamps.
    pub(super) fn new(device: &Device) -> Result<Option<Self>, RenderError> {
        if !device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let buffer = |label, usage| {
            device.allocate(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 2 * u64::from(PASSES) * STAMP,
                usage,
                mapped_at_creation: false,
            })
        };
        Ok(Some(Self {
            stamps: device.device.create_query_set(&wgpu::QuerySetDescriptor {
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

    /// Whether it must be read before another pass.
    pub(super) fn is_full(&self) -> bool {
        self.passes == PASSES
    }

    /// What the next pass has to write; it must not be full.
    pub(super) fn next(&mut self) -> wgpu::ComputePassTimestampWrites<'_> {
        let first = 2 * self.passes;
        self.passes += 1;
        wgpu::ComputePassTimestampWrites {
            query_set: &self.stamps,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        }
    }

    /// The time of all passes so far; waits for them.
    pub(super) fn read(&mut self, device: &Device) -> Result<Duration, RenderError> {
        if self.passes > 0 {
            let stamps = 2 * self.passes;
            let bytes = u64::from(stamps) * STAMP;
            let mut encoder =
                device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("timestamps") });
            encoder.resolve_query_set(&self.stamps, 0..stamps, &self.resolved, 0);
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
