//! Choice between the CPU and a software adapter, by measurement.
//!
//! The faster backend depends on the scene: sphere tracing is faster on the CPU backend, many analytic objects on llvmpipe.
//! Both render a small picture of the scene, with what each of them would choose for the whole, such as paths that share a
//! camera ray, and the faster one renders the whole. If the CPU needs less than [`MIN_CPU_TIME`] for the picture, it renders it
//! at once: a kernel is not worth its compilation.

use super::tracer::Tracer;
use crate::backend::RenderInput;
use crate::backend::cpu::CpuJob;
use crate::backend::gpu::{GpuContext, GpuJob, OFFLINE};
use crate::error::RenderError;
use crate::integrator::splitting::UNSPLIT_SAMPLES;
use crate::settings::Settings;
use pathmarch_scene::Scene;
use std::sync::Arc;
use web_time::Instant;

/// Backend of a picture.
pub(super) enum Choice {
    Gpu,
    Cpu {
        /// Reason for the notice, in one sentence.
        reason: String,
    },
}

/// Approximate number of pixels of the small picture on the CPU, and the smallest one on the adapter.
const PIXELS: f64 = 128.0 * 72.0;
/// Time of a sample on the CPU, in seconds, for which the small picture on the adapter has enough pixels: much longer than the
/// start of a dispatch.
const SAMPLE_TIME: f64 = 0.03;
/// Shortest measured time, seconds.
const MIN_TIME: f64 = 0.01;
/// Number of measurements; the fastest counts, so that other programs have little influence.
const ROUNDS: u32 = 3;
/// Time of a picture on the CPU below which no kernel is compiled, seconds.
const MIN_CPU_TIME: f64 = 1.0;

/// Measures both backends with small pictures. Returns the faster one, and its input for the whole.
pub(super) fn measure(
    scene: &Scene,
    settings: &Settings,
    input: &RenderInput,
    gpu: &Arc<GpuContext>,
) -> (Choice, RenderInput) {
    let mut on_cpu = input.clone();
    on_cpu.choose_for_cpu(settings);
    let cpu = sample_time(small_picture(scene, settings, &on_cpu, PIXELS), |input| {
        Ok(Tracer::Cpu(Box::new(CpuJob::new(input, UNSPLIT_SAMPLES))))
    });
    let cpu = match cpu {
        Ok(time) => time,
        Err(error) => return (Choice::Cpu { reason: error.to_string() }, on_cpu),
    };
    let [width, height] = settings.size.map(f64::from);
    if cpu * width * height * f64::from(settings.samples) < MIN_CPU_TIME {
        let reason = "the only GPU adapter is software, and the CPU renders this picture quickly".to_owned();
        return (Choice::Cpu { reason }, on_cpu);
    }
    let mut on_gpu = input.clone();
    on_gpu.choose_for_gpu(settings, gpu.is_software());
    let pixels = (SAMPLE_TIME / cpu).max(PIXELS);
    let gpu = sample_time(small_picture(scene, settings, &on_gpu, pixels), |input| {
        Ok(Tracer::Gpu(Box::new(GpuJob::new(gpu.clone(), &input, UNSPLIT_SAMPLES, OFFLINE)?)))
    });
    let reason = match gpu {
        Ok(gpu) if gpu < cpu => return (Choice::Gpu, on_gpu),
        Ok(gpu) => format!(
            "the only GPU adapter is software, and takes {:.1} times as long as the CPU for this scene",
            gpu / cpu.max(1e-12)
        ),
        Err(error) => error.to_string(),
    };
    (Choice::Cpu { reason }, on_cpu)
}

/// Input of a small picture with about this number of pixels.
fn small_picture(scene: &Scene, settings: &Settings, input: &RenderInput, pixels: f64) -> RenderInput {
    let [width, height] = settings.size.map(f64::from);
    let scale = (pixels / (width * height)).sqrt().min(1.0);
    let small = Settings { size: [width, height].map(|side| ((side * scale) as u32).max(1)), ..settings.clone() };
    let mut sample = input.clone();
    if !sample.reframe(scene, &small) {
        sample = RenderInput::new(scene, &small);
        sample.config = input.config;
    }
    sample
}

/// Shortest time of a sample of a pixel, seconds, without compilation.
fn sample_time(
    input: RenderInput,
    start: impl Fn(RenderInput) -> Result<Tracer, RenderError>,
) -> Result<f64, RenderError> {
    let pixels: f64 = input.frame.size().map(f64::from).iter().product();
    let splitting = input.config.splitting;
    let mut tracer = start(input)?;
    let (mut done, mut step, mut rounds, mut shortest) = (0, splitting, 0, f64::INFINITY);
    while rounds < ROUNDS {
        let started = Instant::now();
        done += step;
        while tracer.samples_done() < f64::from(done) {
            tracer.advance(done)?;
        }
        tracer.wait()?;
        let time = started.elapsed().as_secs_f64();
        shortest = shortest.min(time / (f64::from(step) * pixels));
        if time < MIN_TIME && step < 1 << 12 {
            step *= 2;
        } else {
            rounds += 1;
        }
    }
    Ok(shortest)
}
