//! `pathmarch-measure hybrid`: first hits of camera rays by the rasteriser, against the hierarchy of triangles.
//!
//! **Idea.** A rasteriser draws triangle ids and depths. A kernel intersects the ray of each pixel with the triangle of its id by
//! the renderer's own test, so that hits are those of the hierarchy to the last bit. The ray traverses the hierarchy if it
//! misses that triangle, or if depths bend much over 3x3 pixels: at edges another triangle may be nearer.
//!
//! **Offsets.** The renderer draws an offset in the pixel for each ray; a rasteriser has one for all pixels. Both are measured:
//! `own` offsets, as the renderer's pictures have, and a `common` one, with other noise.
//!
//! **Method.** Passes and whole samples take turns; medians are reported. The pictures of both ways are compared pixel by pixel, and by the larger
//! relMSE of their distances and their normals. The time of a whole sample with bounces, by the renderer, shows how much of a
//! frame could be gained: the rasteriser only replaces camera rays. Preview and views (`--mode`) have a common offset already.
//!
//! **Limits.** Details smaller than a pixel that no sample of the raster hits are lost; differing pixels count them.

mod passes;
mod torus;

use crate::measure::{self, Interrupt, MAX_SAMPLES};
use passes::{Gpu, NO_HIT, Pass, Passes, PixelHit, median};
use pathmarch_cli::{DONE, Failure, catch_interrupts, note, outln, value_parsers};
use pathmarch_render::image::Picture;
use pathmarch_render::metrics::relmse;
use pathmarch_render::pathmarch_scene::settings;
use pathmarch_render::{Backend, Job, Mode, Renderer, Settings};
use std::time::Instant;
use torus::{MeshScene, Offsets};

/// Most rounds: modes without noise take sixteen samples, of which the first is warm-up.
const MAX_ROUNDS: u32 = 15;

#[derive(clap::Args)]
pub struct Arguments {
    /// Numbers of triangles
    #[arg(long, value_name = "N", num_args = 1.., default_values_t = [100_000, 1_000_000, 10_000_000], value_parser = value_parsers::whole((100, 20_000_000)))]
    triangles: Vec<u32>,
    /// Sizes of pictures
    #[arg(long, value_name = "WxH", num_args = 1.., default_values = ["640x360", "1280x720"], value_parser = value_parsers::size)]
    size: Vec<[u32; 2]>,
    /// Number of rounds
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = value_parsers::whole((1, MAX_ROUNDS)), allow_hyphen_values = true)]
    rounds: u32,
    /// Scattering events after the first hit, of the whole sample
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = value_parsers::whole(settings::BOUNCES), allow_hyphen_values = true)]
    bounces: u32,
    /// Quantity of the whole sample: path, preview, normal, ...
    #[arg(long, value_name = "NAME", default_value = Mode::Path.name(), value_parser = parse_mode)]
    mode: Mode,
    /// Leave out triangles seen from behind, as closed meshes allow
    #[arg(long)]
    cull: bool,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

fn parse_mode(text: &str) -> Result<Mode, String> {
    Mode::from_name(text).ok_or_else(|| format!("expected one of {}", Mode::ALL.map(Mode::name).join(", ")))
}

/// Columns of the report.
const COLUMNS: &str = "triangles | size | offsets | BVH, ms | raster, ms | ids to hits, ms | BVH / (raster + ids) | fallback | \
                       differing pixels | relMSE | sample, ms | gain of a sample | sample on the CPU backend, ms";

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let interrupt = Interrupt(catch_interrupts()?);
    let renderer = Renderer::open(Backend::Gpu, arguments.adapter.as_deref()).map_err(Failure::other)?;
    let cpu = Renderer::open(Backend::Cpu, None).map_err(Failure::other)?;
    let gpu = Gpu::open(&renderer.backend().adapter)?;
    outln!("{}; largest storage buffer {} MiB\n", renderer.backend().adapter, gpu.max_binding >> 20);
    outln!("| {COLUMNS} |\n|{}", "---|".repeat(COLUMNS.split('|').count()));
    for &triangles in &arguments.triangles {
        note!("hybrid: {triangles} triangles");
        let mesh = MeshScene::torus(triangles)?;
        let (bytes, most) = (mesh.bvh_bytes() >> 20, gpu.max_binding >> 20);
        if mesh.bvh_bytes() > gpu.max_binding {
            note!("hybrid: a hierarchy of {bytes} MiB exceeds {most} MiB; the raster alone is measured");
        }
        for &size in &arguments.size {
            for offsets in Offsets::ALL {
                let passes = Passes::new(&gpu, &mesh, size, offsets, arguments.cull);
                let mut samples = [
                    SampleTimer::start(arguments, &renderer, &mesh, size, &interrupt)?,
                    SampleTimer::start(arguments, &cpu, &mesh, size, &interrupt)?,
                ];
                let mut time_samples = || samples.iter_mut().try_for_each(|sample| sample.next(&interrupt));
                let row = Row::measure(&passes, &mesh, size, arguments.rounds, &mut time_samples)?;
                outln!("| {} |", row.cells(&mesh, size, offsets, samples.map(SampleTimer::median)).join(" | "));
            }
        }
    }
    Ok(DONE)
}

/// Timer of whole samples with bounces.
struct SampleTimer {
    /// `None` if the backend refuses the scene.
    job: Option<Job>,
    /// Milliseconds.
    times: Vec<f64>,
}

impl SampleTimer {
    /// Starts a picture; its first sample is warm-up.
    fn start(
        arguments: &Arguments,
        renderer: &Renderer,
        mesh: &MeshScene,
        size: [u32; 2],
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let &Arguments { bounces, mode, .. } = arguments;
        let settings = Settings { size, bounces, mode, samples: MAX_SAMPLES, ..Settings::of(&mesh.scene) };
        let job = renderer.start(&mesh.scene, &settings).map_err(|error| note!("hybrid: {error}")).ok();
        let mut timer = Self { job, times: Vec::new() };
        timer.next(interrupt)?;
        timer.times.clear();
        Ok(timer)
    }

    fn next(&mut self, interrupt: &Interrupt) -> Result<(), Failure> {
        let Some(job) = &mut self.job else { return interrupt.check() };
        let next = job.samples_done() as u32 + 1;
        let began = Instant::now();
        measure::until(job, next, interrupt)?;
        self.times.push(began.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    /// Median milliseconds.
    fn median(self) -> Option<f64> {
        self.job.map(|_| median(self.times))
    }
}

/// Figures of one picture.
struct Row {
    raster_ms: f64,
    /// `None` if the hierarchy does not fit.
    hits: Option<HitFigures>,
}

/// Figures of both ways to the hits.
struct HitFigures {
    bvh_ms: f64,
    ids_ms: f64,
    /// Share of pixels whose ray traverses the hierarchy.
    fallback: f64,
    differing: usize,
    relmse: f64,
}

impl Row {
    /// Measures the passes in turns with other work, `beside`.
    fn measure(
        passes: &Passes,
        mesh: &MeshScene,
        size: [u32; 2],
        rounds: u32,
        beside: &mut dyn FnMut() -> Result<(), Failure>,
    ) -> Result<Self, Failure> {
        match passes.time_interleaved(passes.possible(), rounds, beside)?[..] {
            [bvh_ms, raster_ms, ids_ms] => {
                let (exact, from_ids) = (passes.hits(Pass::Bvh)?, passes.hits(Pass::Ids)?);
                let fallbacks = from_ids.iter().filter(|hit| hit.is_fallback).count();
                let differs = |(a, b): &(&PixelHit, &PixelHit)| a.t != b.t || a.triangle != b.triangle;
                let hits = HitFigures {
                    bvh_ms,
                    ids_ms,
                    fallback: fallbacks as f64 / from_ids.len() as f64,
                    differing: exact.iter().zip(&from_ids).filter(differs).count(),
                    relmse: larger_relmse(mesh, size, &exact, &from_ids)?,
                };
                Ok(Self { raster_ms, hits: Some(hits) })
            }
            ref times => Ok(Self { raster_ms: times[0], hits: None }),
        }
    }

    /// Cells of the report, in the order of [`COLUMNS`].
    fn cells(
        &self,
        mesh: &MeshScene,
        [width, height]: [u32; 2],
        offsets: Offsets,
        samples: [Option<f64>; 2],
    ) -> Vec<String> {
        let [sample, on_cpu] = samples.map(|sample| sample.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.0}")));
        let hits = |cell: &dyn Fn(&HitFigures) -> String| self.hits.as_ref().map_or_else(|| "-".to_owned(), cell);
        let sum = |hits: &HitFigures| self.raster_ms + hits.ids_ms;
        let gain = |hits: &HitFigures, sample: f64| format!("{:.1} %", 100.0 * (hits.bvh_ms - sum(hits)) / sample);
        vec![
            mesh.mesh().triangles.len().to_string(),
            format!("{width}x{height}"),
            offsets.name().to_owned(),
            hits(&|hits| format!("{:.2}", hits.bvh_ms)),
            format!("{:.2}", self.raster_ms),
            hits(&|hits| format!("{:.2}", hits.ids_ms)),
            hits(&|hits| format!("{:.2}", hits.bvh_ms / sum(hits))),
            hits(&|hits| format!("{:.1} %", 100.0 * hits.fallback)),
            hits(&|hits| hits.differing.to_string()),
            hits(&|hits| format!("{:.1e}", hits.relmse)),
            sample,
            hits(&|hits| samples[0].map_or_else(|| "-".to_owned(), |sample| gain(hits, sample))),
            on_cpu,
        ]
    }
}

/// The larger one of the relMSE of distances and that of normals, of first hits against exact ones.
fn larger_relmse(
    mesh: &MeshScene,
    [width, height]: [u32; 2],
    exact: &[PixelHit],
    hits: &[PixelHit],
) -> Result<f64, Failure> {
    let triangles = mesh.triangles_in_kernel_order();
    let normal = |hit: &PixelHit| {
        let [a, b, c] = triangles[hit.triangle as usize].map(|vertex| mesh.mesh().positions[vertex as usize]);
        (0.5 + 0.5 * (b - a).cross(c - a).normalize_or_zero()).into()
    };
    let picture = |hits: &[PixelHit], value: &dyn Fn(&PixelHit) -> [f32; 3]| {
        let pixel = |hit: &PixelHit| if hit.triangle == NO_HIT { [0.0; 3] } else { value(hit) };
        Picture { width, height, pixels: hits.iter().map(pixel).collect() }
    };
    let error = |value: &dyn Fn(&PixelHit) -> [f32; 3]| relmse(&picture(hits, value), &picture(exact, value));
    let (distance, normal) = (error(&|hit| [hit.t; 3]), error(&normal));
    Ok(distance.map_err(Failure::other)?.max(normal.map_err(Failure::other)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The preferred adapter; `None` if it cannot rasterise ids, unless `PATHMARCH_REQUIRE_GPU` is set.
    fn gpu() -> Option<Gpu> {
        let renderer = Renderer::open(Backend::Gpu, None).map_err(Failure::other);
        let gpu = renderer.and_then(|renderer| Gpu::open(&renderer.backend().adapter));
        let is_required = std::env::var_os("PATHMARCH_REQUIRE_GPU").is_some();
        assert!(gpu.is_ok() || !is_required, "a GPU is required");
        gpu.ok()
    }

    #[test]
    fn rasterised_ids_lead_to_the_hits_of_the_hierarchy() {
        let Some(gpu) = gpu() else { return };
        let mesh = MeshScene::torus(5000).expect("a scene");
        let size = [480, 270];
        for (offsets, culls_back) in [(Offsets::Own, false), (Offsets::Common, false), (Offsets::Common, true)] {
            let passes = Passes::new(&gpu, &mesh, size, offsets, culls_back);
            let (exact, from_ids) = (passes.hits(Pass::Bvh).expect("hits"), passes.hits(Pass::Ids).expect("hits"));
            let hits = exact.iter().filter(|hit| hit.triangle != NO_HIT).count();
            assert!(hits > 20_000 && hits < 100_000, "{hits} of 129,600 pixels");
            let by_raster = from_ids.iter().filter(|hit| hit.triangle != NO_HIT && !hit.is_fallback).count();
            assert!(by_raster > hits / 2, "{offsets:?}: {by_raster} of {hits} hits without the hierarchy");
            let error = larger_relmse(&mesh, size, &exact, &from_ids).expect("pictures of one size");
            assert!(error <= 1e-6, "{offsets:?}: relMSE {error:e}");
        }
    }
}
