//! Figures of a benchmark: as a table, as JSON, and beside those of another run.

use pathmarch_cli::Failure;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Everything that was measured, and how.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Results {
    /// Version of the program.
    pub version: String,
    /// Of the timed pictures.
    pub size: [u32; 2],
    /// Of the timed pictures.
    pub bounces: u32,
    /// Times of each scene.
    pub rounds: u32,
    /// In each round.
    pub samples: u32,
    /// Of the pictures whose error is measured, where one is.
    #[serde(default)]
    pub error_size: Option<[u32; 2]>,
    /// One for each scene and backend.
    pub entries: Vec<Entry>,
}

/// The figures of a scene on a backend.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// The scene's name.
    pub scene: String,
    /// Backend and adapter.
    pub backend: String,
    /// Rounds that there was time for.
    #[serde(default)]
    pub rounds: Option<u32>,
    /// Milliseconds on the wall for one sample of every pixel.
    pub ms_per_sample: Spread,
    /// Milliseconds on the GPU's own clock for it.
    #[serde(default)]
    pub gpu_ms_per_sample: Option<f64>,
    /// Milliseconds until the first sample could begin.
    pub compile_ms: f64,
    /// Rays of a sample of one pixel.
    pub rays_per_pixel: f64,
    /// Evaluations of the marched field for each of them.
    pub evaluations_per_ray: f64,
    /// Evaluations for a sample of one pixel.
    #[serde(default)]
    pub evaluations_per_pixel: Option<f64>,
    /// Steps of a march: evaluations for each ray that came near what is marched.
    #[serde(default)]
    pub steps_per_marched_ray: Option<f64>,
    /// Peak resident memory of a process that renders the scene, MiB.
    #[serde(default)]
    pub peak_mib: Option<f64>,
    /// The error after a time.
    #[serde(default)]
    pub quality: Option<Quality>,
}

/// Of several rounds.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Spread {
    /// The middle one.
    pub median: f64,
    /// The least.
    pub min: f64,
    /// The most.
    pub max: f64,
}

/// How far a picture was from the converged one after some time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Quality {
    /// Seconds of rendering, without compilation.
    pub seconds: f64,
    /// Samples of each pixel in that time.
    pub samples: u32,
    /// Scattering events after the first hit: the scene's own.
    pub bounces: u32,
    /// relMSE, the reference's noise taken off; absent where that hides it.
    pub relmse: Option<f64>,
    /// Seconds times relMSE: what a given quality costs, whatever the number of samples.
    pub seconds_relmse: Option<f64>,
    /// The reference's own relMSE, where it is known.
    pub reference_relmse: Option<f64>,
    /// The reference's samples, where they are known.
    pub reference_samples: Option<u32>,
    /// Relative difference of the means of picture and reference.
    pub mean_difference: f64,
}

/// A number to about three digits, or a dash.
fn shown(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(value) if value != 0.0 && value.abs() < 0.01 => format!("{value:.2e}"),
        Some(value) if value.abs() < 10.0 => format!("{value:.2}"),
        Some(value) => format!("{value:.1}"),
    }
}

impl Results {
    /// Reads the file of an earlier run.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let text =
            std::fs::read_to_string(path).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
        serde_json::from_str(&text)
            .map_err(|error| Failure::Usage(format!("{} is not a file of `bench --json`: {error}", path.display())))
    }

    /// Writes them as JSON.
    pub fn save(&self, path: &Path) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(Failure::other)?;
        std::fs::write(path, text + "\n").map_err(|error| Failure::Other(format!("{}: {error}", path.display())))
    }

    /// The lines above the table.
    pub fn print_head(&self) {
        let [width, height] = self.size;
        println!("{width}x{height}, {} bounces, {} rounds of {} samples", self.bounces, self.rounds, self.samples);
        print!(
            "{:<24} {:>9} {:>17} {:>8} {:>10} {:>8} {:>8} {:>7} {:>8}",
            "scene", "ms/sample", "min-max", "GPU ms", "compile ms", "rays/px", "evals/px", "steps", "peak MiB"
        );
        if let Some([width, height]) = self.error_size {
            let size = format!("{width}x{height}:");
            print!(
                "  {size:>10} {:>7} {:>6} {:>9} {:>10} {:>9}",
                "seconds", "spp", "relMSE", "s x relMSE", "ref noise"
            );
        }
        println!("  backend");
    }

    /// The ratios of these figures to those of an earlier run: below 1 is less than then.
    pub fn print_ratios(&self, before: &Results) {
        if (before.size, before.bounces) != (self.size, self.bounces) {
            let told =
                |results: &Results| format!("{}x{} and {} bounces", results.size[0], results.size[1], results.bounces);
            println!("\nnot the same pictures: {} then, {} now", told(before), told(self));
        }
        println!(
            "\nnow / then: {:<12} {:>9} {:>10} {:>8} {:>10}  backend",
            "scene", "ms/sample", "evals/px", "MiB", "s x relMSE"
        );
        let ratio = |now: Option<f64>, then: Option<f64>| match (now, then) {
            (Some(now), Some(then)) if then > 0.0 => format!("{:.3}", now / then),
            _ => "-".to_owned(),
        };
        let mut logarithms = Vec::new();
        for now in &self.entries {
            let is_it = |then: &&Entry| then.scene == now.scene && then.backend == now.backend;
            let Some(then) = before.entries.iter().find(is_it) else {
                println!("{:<24} not measured then, on {}", now.scene, now.backend);
                continue;
            };
            let cost = |entry: &Entry| entry.quality.as_ref().and_then(|quality| quality.seconds_relmse);
            println!(
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
            println!("{:<24} {mean:>9.3}  geometric mean", "all");
        }
    }
}

impl Entry {
    /// Its line of the table.
    pub fn print(&self) {
        let Spread { median, min, max } = self.ms_per_sample;
        print!(
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
            print!(
                "  {:>10} {:>7.2} {:>6} {:>9} {:>10} {:>9}",
                "",
                quality.seconds,
                quality.samples,
                small(quality.relmse),
                small(quality.seconds_relmse),
                small(quality.reference_relmse)
            );
        }
        println!("  {}", self.backend);
    }
}
