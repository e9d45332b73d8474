//! Choice between the CPU and a software adapter, by measurement.
//!
//! The faster backend depends on the scene: sphere tracing is faster on the CPU backend, many analytic objects on llvmpipe.
//! Both render a small picture of the scene, and the faster one renders the whole. If the CPU needs less than
//! [`MIN_CPU_TIME`] for the picture, it renders it at once: a kernel is not worth its compilation.

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{GpuContext, GpuJob, OFFLINE};
use crate::error::RenderError;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;
use std::time::Duration;
use web_time::Instant;

/// Backend of a picture.
pub(super) enum Choice {
    Gpu,
    Cpu {
        /// Reason for the notice, in one sentence.
        reason: String,
    },
}

/// Approximate number of pixels of the small pictures.
const PIXELS: f64 = 128.0 * 72.0;
/// Samples of the small pictures; the fastest counts, so that other programs have little influence.
const ROUNDS: u32 = 3;
/// Time of a picture on the CPU below which no kernel is compiled.
const MIN_CPU_TIME: Duration = Duration::from_secs(1);

/// Measures both backends with a small picture.
pub(super) fn measure(scene: &Scene, settings: &Settings, input: &RenderInput, gpu: &Arc<GpuContext>) -> Choice {
    let [width, height] = settings.size.map(f64::from);
    let scale = (PIXELS / (width * height)).sqrt().min(1.0);
    let size = [width, height].map(|side| ((side * scale) as u32).max(1));
    let small = Settings { size, samples: ROUNDS, splitting: Some(1), ..settings.clone() };
    let mut sample = input.clone();
    if !sample.reframe(scene, &small) {
        sample = RenderInput::new(scene, &small);
        sample.config.constant_numbers = input.config.constant_numbers;
    }
    sample.config.splitting = 1;
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    let cpu = time_on_cpu(&sample);
    let whole = cpu.mul_f64(width * height / pixels * f64::from(settings.samples));
    if whole < MIN_CPU_TIME {
        return Choice::Cpu {
            reason: "the only GPU adapter is software, and the CPU renders this picture quickly".to_owned(),
        };
    }
    match time_on_gpu(&sample, gpu) {
        Ok(time) if time < cpu => Choice::Gpu,
        Ok(time) => {
            let times = time.as_secs_f64() / cpu.as_secs_f64().max(1e-9);
            let reason = format!(
                "the only GPU adapter is software, and takes {times:.1} times as long as the CPU for this scene"
            );
            Choice::Cpu { reason }
        }
        Err(error) => Choice::Cpu { reason: error.to_string() },
    }
}

/// Shortest time of a sample on the CPU.
fn time_on_cpu(input: &RenderInput) -> Duration {
    let mut job = CpuJob::new(input.clone(), 0);
    let rounds = (1..=ROUNDS).map(|samples| {
        let started = Instant::now();
        job.advance(samples);
        started.elapsed()
    });
    rounds.min().unwrap_or_default()
}

/// Shortest time of a sample on the adapter, without compilation.
fn time_on_gpu(input: &RenderInput, gpu: &Arc<GpuContext>) -> Result<Duration, RenderError> {
    let mut job = GpuJob::new(gpu.clone(), input, 0, OFFLINE)?;
    let mut shortest = Duration::MAX;
    for samples in 1..=ROUNDS {
        let started = Instant::now();
        while job.samples_done() < f64::from(samples) {
            job.advance(samples)?;
        }
        job.wait()?;
        shortest = shortest.min(started.elapsed());
    }
    Ok(shortest)
}
