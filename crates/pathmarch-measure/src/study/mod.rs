//! `pathmarch-measure study`: the evaluation of the thesis, chapter 5, repeated with pathmarch.
//!
//! **Idea.** One page of tables, plots and pictures, in independent parts. A part is a Markdown file with its tables,
//! plots and pictures beside it; the page, `README.md`, joins all existing parts, so that each can be repeated alone.
//!
//! **Source.** Carvalho 2020, chapters 2 to 5. The thesis's program runs from its published source, Cycles from PyPI's
//! `bpy`, both on scenes laid out after the thesis's figures ([`crate::peers`]).
//!
//! **Cost.** About an hour and a half on two cores; `--quick` takes seconds and only shows that everything works.

mod accumulation;
mod bounces;
mod comparison;
mod features;
mod figures;
mod machine;
mod marching;
mod picture_grid;
mod plot;
mod raster;
mod realtime;
mod rows;
mod table;
mod tables;

pub use machine::describe as describe_machine;
pub use rows::letter_of;

use crate::bench;
use crate::measure::{self, Budget, Interrupt};
use crate::peers::Python;
use clap::ValueEnum;
use pathmarch_cli::{BackendArgument, DONE, Failure, catch_interrupts, note, value_parsers};
use pathmarch_render::image::Picture;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::{Backend, Renderer, Settings};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Parts to repeat [default: all]
    #[arg(value_name = "NAME", value_enum)]
    parts: Vec<Part>,
    /// Output directory; existing files of the study are replaced, others are kept
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Small sizes and few samples, as a trial
    #[arg(long)]
    quick: bool,
    /// Size of the timed pictures [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// Size of the pictures whose error is measured [default: 640x360]
    #[arg(long, value_name = "WxH", value_parser = value_parsers::size, allow_hyphen_values = true)]
    error_size: Option<[u32; 2]>,
    /// Number of timed samples [default: 3]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((1, 1000)), allow_hyphen_values = true)]
    rounds: Option<u32>,
    /// Maximum number of samples whose error is measured; the reference has four times as many [default: 64]
    #[arg(long, value_name = "N", value_parser = value_parsers::whole((2, 65_536)), allow_hyphen_values = true)]
    samples: Option<u32>,
    /// Render time of each picture on the page [default: 15]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    picture_seconds: Option<f64>,
    /// Backend to time [default: every adapter, and the CPU; the fastest one renders the pictures]
    #[arg(long, value_enum)]
    backend: Option<BackendArgument>,
    /// GPU adapter, by a part of its name
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
    /// Render time of a reference [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = value_parsers::seconds, allow_hyphen_values = true)]
    reference_seconds: Option<f64>,
    /// Directory in which references are kept
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// Tables whose rows are compared with Cycles, such as 5.7; the others stay as an earlier run left them [default: all]
    #[arg(long = "table", value_name = "TABLE")]
    tables: Vec<String>,
    /// Python with the modules bpy (for Cycles) and moderngl (for the thesis's program), or blender [default: python3]
    #[arg(long, value_name = "PROGRAM")]
    python: Option<PathBuf>,
    /// The thesis's program: shaders/pathTracer.fs of github.com/Arukiap/Path-marcher
    #[arg(long, value_name = "FILE")]
    thesis_shader: Option<PathBuf>,
}

/// Time limit of a scene, seconds; no further round begins after it.
const TIME_LIMIT: f64 = 8.0;

/// A part of the study, in the order of the page.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The machine: Table 5.1
    Machine,
    /// Error over time beside Cycles, for each row of Tables 5.2 to 5.7
    Comparison,
    /// Time of a sample beside the thesis's program: Tables 5.2 to 5.7
    Tables,
    /// Frames a second in motion, against the thesis's 24
    Realtime,
    /// Cost and worth of bounces: Figures 5.1 and 5.2
    Bounces,
    /// Error over accumulated frames: Figure 5.3
    Accumulation,
    /// Features: Table 5.8
    Features,
    /// Fixed steps against sphere tracing: Figures 2.9 and 2.10
    Marching,
    /// Rasterisation beside marching: Figures 2.2 to 2.4
    Raster,
    /// The other figures
    Figures,
}

impl Part {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    fn study(self, study: &mut Study) -> Result<String, Failure> {
        match self {
            Self::Machine => machine::study(study),
            Self::Comparison => comparison::study(study),
            Self::Tables => tables::study(study),
            Self::Realtime => realtime::study(study),
            Self::Bounces => bounces::study(study),
            Self::Accumulation => accumulation::study(study),
            Self::Features => features::study(study),
            Self::Marching => marching::study(study),
            Self::Raster => raster::study(study),
            Self::Figures => figures::study(study),
        }
    }
}

/// Sizes, sample counts and times.
struct Plan {
    size: [u32; 2],
    error_size: [u32; 2],
    marching_size: [u32; 2],
    rounds: u32,
    samples: u32,
    /// Render time of each picture on the page.
    picture_seconds: f64,
    /// Most samples of Cycles.
    cycles_samples: u32,
    /// Cells along the longest side of the meshes that are rasterised.
    mesh_resolution: u32,
    reference_seconds: f64,
    /// Time of each picture in the study of bounces.
    bounce_seconds: f64,
    /// True for some rows and figures only.
    few_rows: bool,
}

impl Plan {
    fn of(arguments: &Arguments) -> Self {
        let small = arguments.quick;
        let size = |asked: Option<[u32; 2]>, full| asked.unwrap_or(if small { [64, 36] } else { full });
        let number = |asked: Option<u32>, quick, full| asked.unwrap_or(if small { quick } else { full });
        Self {
            size: size(arguments.size, [1280, 720]),
            error_size: size(arguments.error_size, [640, 360]),
            marching_size: size(None, [640, 360]),
            rounds: number(arguments.rounds, 1, 3),
            samples: number(arguments.samples, 4, 64),
            picture_seconds: arguments.picture_seconds.unwrap_or(if small { 0.1 } else { 15.0 }),
            cycles_samples: number(None, 2, 128),
            mesh_resolution: number(None, 24, 256),
            reference_seconds: arguments.reference_seconds.unwrap_or(if small { 0.2 } else { 60.0 }),
            bounce_seconds: if small { 0.1 } else { 3.0 },
            few_rows: small,
        }
    }
}

/// State shared by all parts.
struct Study<'a> {
    directory: &'a Path,
    plan: Plan,
    renderers: Vec<Renderer>,
    interrupt: Interrupt,
    python: Python,
    thesis_shader: Option<PathBuf>,
    references: Option<PathBuf>,
    /// Tables that are compared with Cycles; empty for all.
    tables: Vec<String>,
    /// Command line that repeats the study.
    command: String,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let directory = &arguments.output;
    match std::fs::create_dir(directory) {
        Err(error) if !directory.is_dir() => {
            return Err(Failure::Other(format!("{}: {error}; name an output directory", directory.display())));
        }
        _ => {}
    }
    let interrupt = Interrupt(catch_interrupts()?);
    let renderers = measure::renderers(arguments.backend.map(Into::into), arguments.adapter.as_deref())?;
    let plan = Plan::of(arguments);
    let mut study = Study {
        directory,
        plan,
        renderers,
        interrupt,
        python: Python::new(arguments.python.as_deref()),
        thesis_shader: arguments.thesis_shader.clone(),
        references: arguments.references.clone(),
        tables: arguments.tables.clone(),
        command: command(arguments),
    };
    let asked = |part: &Part| arguments.parts.is_empty() || arguments.parts.contains(part);
    for part in Part::value_variants().iter().copied().filter(asked) {
        let text = part.study(&mut study)?;
        study.write(&format!("{}.md", part.name()), &text)?;
        study.write_page()?;
    }
    note!("wrote {}", directory.join("README.md").display());
    Ok(DONE)
}

/// Command line with the same arguments.
fn command(arguments: &Arguments) -> String {
    let mut command = "pathmarch-measure study".to_owned();
    for part in &arguments.parts {
        command += &format!(" {}", part.name());
    }
    command += &format!(" -o {}", arguments.output.display());
    if arguments.quick {
        command += " --quick";
    }
    let sizes = [("size", arguments.size), ("error-size", arguments.error_size)];
    for (name, size) in sizes {
        if let Some([width, height]) = size {
            command += &format!(" --{name} {width}x{height}");
        }
    }
    let numbers = [("rounds", arguments.rounds), ("samples", arguments.samples)];
    for (name, number) in numbers {
        if let Some(number) = number {
            command += &format!(" --{name} {number}");
        }
    }
    if let Some(value) = arguments.backend.and_then(|backend| backend.to_possible_value()) {
        command += &format!(" --backend {}", value.get_name());
    }
    let times = [("reference-seconds", arguments.reference_seconds), ("picture-seconds", arguments.picture_seconds)];
    for (name, seconds) in times {
        if let Some(seconds) = seconds {
            command += &format!(" --{name} {seconds}");
        }
    }
    if arguments.thesis_shader.is_some() {
        command += " --thesis-shader pathTracer.fs";
    }
    if let Some(adapter) = &arguments.adapter {
        command += &format!(" --adapter \"{adapter}\"");
    }
    command
}

/// Loads an example by name.
fn example(name: &str) -> Result<Scene, Failure> {
    let text = bench::built_in(name).ok_or_else(|| Failure::Other(format!("there is no example {name}")))?;
    Ok(Scene::parse(&format!("{name}.kdl"), &text)?)
}

impl Study<'_> {
    fn log(&self, what: &str) {
        note!("{what}");
    }

    fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.directory.join(name);
        std::fs::write(&path, text).map_err(|error| Failure::Other(format!("{}: {error}", path.display())))
    }

    /// Writes the page of all existing parts.
    fn write_page(&self) -> Result<(), Failure> {
        let mut page = format!(
            "# The evaluation of the thesis, repeated\n\nRúben André Campos de Carvalho, \"Combining the Ray Marching and \
             Rasterization rendering models to provide real-time high-fidelity graphics\", Master's thesis, University of \
             Porto, June 2020: every table and figure of what its program did, again, with pathmarch {}. Each part states what \
             it ran on and the command that repeats it; its tables are also available as CSV, its plots as SVG.\n",
            env!("CARGO_PKG_VERSION")
        );
        for part in Part::value_variants() {
            let path = self.directory.join(format!("{}.md", part.name()));
            if let Ok(text) = std::fs::read_to_string(path) {
                page += "\n";
                page += &text;
            }
        }
        self.write("README.md", &page)
    }

    /// Short, distinct names of the backends.
    fn backends(&self) -> Vec<String> {
        let names: Vec<_> = self.renderers.iter().map(|renderer| renderer.backend().name).collect();
        let is_alone = |name: &String| names.iter().filter(|other| *other == name).count() == 1;
        let both = names.iter().zip(&self.renderers);
        both.map(|(name, renderer)| if is_alone(name) { name.clone() } else { measure::backend_label(renderer) })
            .collect()
    }

    /// Hardware and command line of a part.
    fn conditions(&self, what: &str) -> String {
        let backends: Vec<_> = self.renderers.iter().map(measure::backend_label).collect();
        format!(
            "*pathmarch {}, on {}; {what}. `{}`*\n",
            env!("CARGO_PKG_VERSION"),
            backends.join(" and "),
            self.command
        )
    }

    /// Median milliseconds per sample on each backend; `None` if it cannot render the scene.
    fn time_view(&mut self, scene: &Scene, settings: &Settings, bounces: u32) -> Result<Vec<Option<f64>>, Failure> {
        let rounds = self.plan.rounds;
        let settings = Settings { bounces, samples: 1 + rounds, ..settings.clone() };
        let (mut jobs, mut able) = (Vec::new(), Vec::new());
        for renderer in &mut self.renderers {
            self.interrupt.check()?;
            match measure::start(renderer, scene, &settings) {
                Ok(job) => jobs.push(job),
                Err(failure) => {
                    note!("not on {}:", measure::backend_label(renderer));
                    failure.print();
                    able.push(false);
                    continue;
                }
            }
            able.push(true);
        }
        let times = measure::time_interleaved(&mut jobs, 1..=rounds, 1, TIME_LIMIT, &self.interrupt)?;
        let mut medians = times.iter().map(|times| times.spread()[0]);
        Ok(able.into_iter().map(|able| able.then(|| medians.next()).flatten()).collect())
    }

    /// Index of the fastest backend.
    fn fastest(times: &[Option<f64>]) -> usize {
        let time = |index: &usize| times[*index].unwrap_or(f64::INFINITY);
        (0..times.len()).min_by(|a, b| time(a).total_cmp(&time(b))).unwrap_or(0)
    }

    /// Renders a picture of the page on the backend that suits the scene: with so many samples, or for
    /// [`Plan::picture_seconds`].
    fn render(&self, scene: &Scene, settings: &Settings, samples: Option<u32>) -> Result<Picture, Failure> {
        let renderer = Renderer::open(Backend::Auto, None).map_err(Failure::other)?;
        let budget = samples.map_or(Budget::Seconds(self.plan.picture_seconds), Budget::Samples);
        Ok(measure::render_for(&renderer, scene, settings, budget, &self.interrupt)?.picture)
    }
}
