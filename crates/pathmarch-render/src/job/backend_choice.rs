//! Choice between the CPU and a software adapter, by measurement.
//!
//! Which of both is quicker depends on the scene: sphere tracing is quicker on the CPU backend, many analytic objects on
//! llvmpipe. A small picture of the scene on each of them decides. A picture that the CPU renders within [`WORTH`] is not worth
//! the compilation of a kernel, and is rendered there at once.

use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{GpuContext, GpuJob, WHOLE};
use crate::error::RenderError;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Backend of a picture.
pub(super) enum Choice {
    Gpu,
    Cpu {
        /// One sentence.
        reason: String,
    },
}

/// Pixels of the pictures that are compared, about.
const PIXELS: f64 = 128.0 * 72.0;
/// Samples of each; the quickest counts, so that work of other programs does not decide.
const ROUNDS: u32 = 3;
/// Time of a picture on the CPU below which nothing is compiled.
const WORTH: Duration = Duration::from_secs(1);

/// Measures both backends with a small picture.
pub(super) fn measure(scene: &Scene, settings: &Settings, input: &RenderInput, gpu: &Arc<GpuContext>) -> Choice {
    let [width, height] = settings.size.map(f64::from);
    let scale = (PIXELS / (width * height)).sqrt().min(1.0);
    let size = [width, height].map(|side| ((side * scale) as u32).max(1));
    let small = Settings { size, samples: ROUNDS, splitting: Some(1), ..settings.clone() };
    let mut sample = input.clone();
    if !sample.reframe(scene, &small) {
        sample = RenderInput::new(scene, &small);
    }
    sample.config.splitting = 1;
    let pixels = f64::from(size[0]) * f64::from(size[1]);
    let cpu = time_on_cpu(&sample);
    let whole = cpu.mul_f64(width * height / pixels * f64::from(settings.samples));
    if whole < WORTH {
        return Choice::Cpu {
            reason: "the only GPU adapter is software, and this picture is quick on the CPU".to_owned(),
        };
    }
    match time_on_gpu(&sample, gpu) {
        Ok(time) if time < cpu => Choice::Gpu,
        Ok(time) => {
            let times = time.as_secs_f64() / cpu.as_secs_f64().max(1e-9);
            let reason =
                format!("the only GPU adapter is software, and takes {times:.1} times as long as the CPU here");
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
    let mut job = GpuJob::new(gpu.clone(), input, 0, WHOLE)?;
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
