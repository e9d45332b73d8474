//! Benchmark results: table, JSON file, and comparison with another run.

use pathmarch_cli::{Failure, out, outln};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Results with their settings.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Results {
    /// Version of the program.
    pub version: String,
    /// Size of the timed pictures, pixels.
    pub size: [u32; 2],
    /// Bounces of the timed pictures.
    pub bounces: u32,
    /// Rounds per scene.
    pub rounds: u32,
    /// Samples per round.
    pub samples: u32,
    /// Size of the pictures whose error is measured, if any.
    #[serde(default)]
    pub error_size: Option<[u32; 2]>,
    /// One entry for each scene and backend.
    pub entries: Vec<Entry>,
}

/// Results of a scene on a backend.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// Name of the scene.
    pub scene: String,
    /// Backend and adapter.
    pub backend: String,
    /// Rounds within the time limit.
    #[serde(default)]
    pub rounds: Option<u32>,
    /// Wall-clock milliseconds per sample of every pixel.
    pub ms_per_sample: Spread,
    /// GPU milliseconds per sample of every pixel.
    #[serde(default)]
    pub gpu_ms_per_sample: Option<f64>,
    /// Milliseconds until the first sample can begin.
    pub compile_ms: f64,
    /// Rays per pixel and sample.
    pub rays_per_pixel: f64,
    /// Field evaluations per ray.
    pub evaluations_per_ray: f64,
    /// Field evaluations per pixel and sample.
    #[serde(default)]
    pub evaluations_per_pixel: Option<f64>,
    /// Sphere-tracing steps: evaluations per ray that enters the sphere-traced field.
    #[serde(default)]
    pub steps_per_marched_ray: Option<f64>,
    /// Peak resident memory of a process that renders the scene, MiB.
    #[serde(default)]
    pub peak_mib: Option<f64>,
    /// Error after a given time.
    #[serde(default)]
    pub quality: Option<Quality>,
}

/// Statistics over several rounds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
}

/// Error of a picture after some time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Quality {
    /// Render time without compilation, seconds.
    pub seconds: f64,
    /// Samples per pixel in that time.
    pub samples: u32,
    /// Scattering events after the first hit, as the scene sets them.
    pub bounces: u32,
    /// relMSE minus the noise of the reference; absent if smaller than that noise.
    pub relmse: Option<f64>,
    /// Seconds x relMSE: cost of a given quality, independent of the number of samples.
    pub seconds_relmse: Option<f64>,
    /// relMSE of the reference itself, if known.
    pub reference_relmse: Option<f64>,
    /// Samples of the reference, if known.
    pub reference_samples: Option<u32>,
    /// Relative difference of the means of picture and reference.
    pub mean_difference: f64,
}

/// Formats a number with about three digits, or as a dash.
fn shown(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(value) if value != 0.0 && value.abs() < 0.01 => format!("{value:.2e}"),
        Some(value) if value.abs() < 10.0 => format!("{value:.2}"),
        Some(value) => format!("{value:.1}"),
    }
}

impl Results {
    /// Loads the results of an earlier run.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let text =
            std::fs::read_to_string(path).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
        serde_json::from_str(&text)
            .map_err(|error| Failure::Usage(format!("{} is not a file of `bench --json`: {error}", path.display())))
    }

    /// Writes the results as JSON.
    pub fn save(&self, path: &Path) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(Failure::other)?;
        std::fs::write(path, text + "\n").map_err(|error| Failure::Other(format!("{}: {error}", path.display())))
    }

    /// Prints the table's header.
    pub fn print_head(&self) {
        let [width, height] = self.size;
        outln!("{width}x{height}, {} bounces, {} rounds of {} samples", self.bounces, self.rounds, self.samples);
        out!(
            "{:<24} {:>9} {:>17} {:>8} {:>10} {:>8} {:>8} {:>7} {:>8}",
            "scene",
            "ms/sample",
            "min-max",
            "GPU ms",
            "compile ms",
            "rays/px",
            "evals/px",
            "steps",
            "peak MiB"
        );
        if let Some([width, height]) = self.error_size {
            let size = format!("{width}x{height}:");
            out!("  {size:>10} {:>7} {:>6} {:>9} {:>10} {:>9}", "seconds", "spp", "relMSE", "s x relMSE", "ref noise");
        }
        outln!("  backend");
    }

    /// Prints the ratios of these results to an earlier run; below 1 is less than before.
    pub fn print_ratios(&self, before: &Results) {
        if (before.size, before.bounces) != (self.size, self.bounces) {
            let description =
                |results: &Results| format!("{}x{} and {} bounces", results.size[0], results.size[1], results.bounces);
            outln!("\nwarning: different settings: {} before, {} now", description(before), description(self));
        }
        outln!(
            "\nnow / before: {:<12} {:>9} {:>10} {:>8} {:>10}  backend",
            "scene",
            "ms/sample",
            "evals/px",
            "MiB",
            "s x relMSE"
        );
        let ratio = |now: Option<f64>, then: Option<f64>| match (now, then) {
            (Some(now), Some(then)) if then > 0.0 => format!("{:.3}", now / then),
            _ => "-".to_owned(),
        };
        let mut logarithms = Vec::new();
        for now in &self.entries {
            let is_it = |then: &&Entry| then.scene == now.scene && then.backend == now.backend;
            let Some(then) = before.entries.iter().find(is_it) else {
                outln!("{:<24} not measured before, on {}", now.scene, now.backend);
                continue;
            };
            let cost = |entry: &Entry| entry.quality.as_ref().and_then(|quality| quality.seconds_relmse);
            outln!(
                "{:<24} {:>9} {:>10} {:>8} {:>10}  {}",
                now.scene,
                ratio(Some(now.ms_per_sample.median), Some(then.ms_per_sample.median)),
                ratio(now.evaluations_per_pixel, then.evaluations_per_pixel),
                ratio(now.peak_mib, then.peak_mib),
                ratio(cost(now), cost(then)),
                now.backend
            );
            logarithms.push((now.ms_per_sample.median / then.ms_per_sample.median).ln());
        }
        if !logarithms.is_empty() {
            let mean = (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp();
            outln!("{:<24} {mean:>9.3}  geometric mean", "all");
        }
    }
}

impl Entry {
    /// Prints the entry's row.
    pub fn print(&self) {
        let Spread { median, min, max } = self.ms_per_sample;
        out!(
            "{:<24} {median:>9.1} {:>17} {:>8} {:>10.1} {:>8.2} {:>8} {:>7} {:>8}",
            self.scene,
            format!("{min:.1}-{max:.1}"),
            shown(self.gpu_ms_per_sample),
            self.compile_ms,
            self.rays_per_pixel,
            shown(self.evaluations_per_pixel),
            shown(self.steps_per_marched_ray),
            self.peak_mib.map_or("-".to_owned(), |mebibytes| format!("{mebibytes:.0}")),
        );
        if let Some(quality) = &self.quality {
            let small = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2e}"));
            out!(
                "  {:>10} {:>7.2} {:>6} {:>9} {:>10} {:>9}",
                "",
                quality.seconds,
                quality.samples,
                small(quality.relmse),
                small(quality.seconds_relmse),
                small(quality.reference_relmse)
            );
        }
        outln!("  {}", self.backend);
    }
}
