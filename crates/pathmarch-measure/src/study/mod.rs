//! `pathmarch-measure study`: the evaluation of the thesis, chapter 5, repeated with this program.
//!
//! **Idea.** One page of tables, plots and pictures, each part of it made by itself: what bounces cost and bring
//! ([`bounces`]), how the error falls as frames accumulate ([`accumulation`]), what each material and scene takes
//! ([`scenes`]), and what there is at all ([`features`]). A part is a Markdown file with its tables, plots and pictures
//! beside it; the page, `README.md`, is made of all parts that are there, so that one can be repeated alone.
//!
//! **Source.** Carvalho 2020, chapter 5. The times of its program on two cores were measured with its published source
//! and scenes laid out after its figures.
//!
//! **Cost.** By default a few minutes on two cores; `--quick` takes seconds and shows only that it works.

mod accumulation;
mod bounces;
mod features;
mod plot;
mod scenes;
mod table;

use crate::bench;
use crate::measure::{self, Effort, Watch};
use clap::ValueEnum;
use pathmarch_cli::{BackendArgument, DONE, Failure, numbers, watch_interrupts};
use pathmarch_render::image::{self, Picture, Provenance};
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::Display;
use pathmarch_render::{Renderer, Settings};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Which parts [default: all]
    #[arg(value_name = "NAME", value_enum)]
    parts: Vec<Part>,
    /// Where to write; files of the study that are there are replaced, others stay
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Small and short, to try it out
    #[arg(long)]
    quick: bool,
    /// Size of what is timed [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = numbers::size, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// Size of the pictures whose error is measured [default: 640x360]
    #[arg(long, value_name = "WxH", value_parser = numbers::size, allow_hyphen_values = true)]
    error_size: Option<[u32; 2]>,
    /// Size of the pictures on the page [default: 256x144]
    #[arg(long, value_name = "WxH", value_parser = numbers::size, allow_hyphen_values = true)]
    picture_size: Option<[u32; 2]>,
    /// Samples to measure the time of [default: 3]
    #[arg(long, value_name = "N", value_parser = numbers::whole((1, 1000)), allow_hyphen_values = true)]
    rounds: Option<u32>,
    /// Samples up to which the error is measured; its reference has four times as many [default: 64]
    #[arg(long, value_name = "N", value_parser = numbers::whole((2, 65_536)), allow_hyphen_values = true)]
    samples: Option<u32>,
    /// Samples of the pictures on the page [default: 48]
    #[arg(long, value_name = "N", value_parser = numbers::whole((1, 65_536)), allow_hyphen_values = true)]
    picture_samples: Option<u32>,
    /// What to render on [default: every adapter, and the CPU, are timed; the faster one takes the pictures]
    #[arg(long, value_enum)]
    backend: Option<BackendArgument>,
    /// The GPU adapter whose name contains this
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Seconds after which a scene is not timed once more.
const LONG: f64 = 8.0;

/// A part of the study.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// What bounces cost and bring: Figures 5.1 and 5.2
    Bounces,
    /// How the error falls: Figure 5.3
    Accumulation,
    /// What each material and scene takes: Tables 5.2 to 5.7
    Scenes,
    /// What the thesis's program, Cycles and pathmarch have: Table 5.8
    Features,
}

impl Part {
    fn name(self) -> &'static str {
        match self {
            Self::Bounces => "bounces",
            Self::Accumulation => "accumulation",
            Self::Scenes => "scenes",
            Self::Features => "features",
        }
    }
}

/// Sizes and numbers of samples.
struct Plan {
    size: [u32; 2],
    error_size: [u32; 2],
    picture_size: [u32; 2],
    rounds: u32,
    samples: u32,
    picture_samples: u32,
}

impl Plan {
    fn of(arguments: &Arguments) -> Self {
        let small = arguments.quick;
        let size = |asked: Option<[u32; 2]>, full| asked.unwrap_or(if small { [64, 36] } else { full });
        let number = |asked: Option<u32>, quick, full| asked.unwrap_or(if small { quick } else { full });
        Self {
            size: size(arguments.size, [1280, 720]),
            error_size: size(arguments.error_size, [640, 360]),
            picture_size: size(arguments.picture_size, [256, 144]),
            rounds: number(arguments.rounds, 1, 3),
            samples: number(arguments.samples, 4, 64),
            picture_samples: number(arguments.picture_samples, 4, 48),
        }
    }
}

/// The work of all parts.
struct Study<'a> {
    directory: &'a Path,
    plan: Plan,
    renderers: Vec<Renderer>,
    watch: Watch,
    /// What was asked for, for whoever repeats it.
    command: String,
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let directory = &arguments.output;
    match std::fs::create_dir(directory) {
        Err(error) if !directory.is_dir() => {
            return Err(Failure::Other(format!("{}: {error}; name a directory to write to", directory.display())));
        }
        _ => {}
    }
    let watch = Watch(watch_interrupts()?);
    let renderers = measure::renderers(arguments.backend.map(Into::into), arguments.adapter.as_deref())?;
    let plan = Plan::of(arguments);
    let mut study = Study { directory, plan, renderers, watch, command: command(arguments) };
    let asked = |part: &Part| arguments.parts.is_empty() || arguments.parts.contains(part);
    for part in Part::value_variants().iter().copied().filter(asked) {
        let text = match part {
            Part::Bounces => bounces::study(&mut study)?,
            Part::Accumulation => accumulation::study(&mut study)?,
            Part::Scenes => scenes::study(&mut study)?,
            Part::Features => features::study(&mut study)?,
        };
        study.write(&format!("{}.md", part.name()), &text)?;
        study.write_page()?;
    }
    eprintln!("wrote {}", directory.join("README.md").display());
    Ok(DONE)
}

/// The command line that asks for the same.
fn command(arguments: &Arguments) -> String {
    let mut command = "pathmarch-measure study".to_owned();
    for part in &arguments.parts {
        command += &format!(" {}", part.name());
    }
    command += &format!(" -o {}", arguments.output.display());
    if arguments.quick {
        command += " --quick";
    }
    let sizes =
        [("size", arguments.size), ("error-size", arguments.error_size), ("picture-size", arguments.picture_size)];
    for (name, size) in sizes {
        if let Some([width, height]) = size {
            command += &format!(" --{name} {width}x{height}");
        }
    }
    let numbers =
        [("rounds", arguments.rounds), ("samples", arguments.samples), ("picture-samples", arguments.picture_samples)];
    for (name, number) in numbers {
        if let Some(number) = number {
            command += &format!(" --{name} {number}");
        }
    }
    if let Some(value) = arguments.backend.and_then(|backend| backend.to_possible_value()) {
        command += &format!(" --backend {}", value.get_name());
    }
    if let Some(adapter) = &arguments.adapter {
        command += &format!(" --adapter \"{adapter}\"");
    }
    command
}

/// The scene of an example's name.
fn example(name: &str) -> Result<Scene, Failure> {
    let text = bench::built_in(name).ok_or_else(|| Failure::Other(format!("there is no example {name}")))?;
    Ok(Scene::parse(&format!("{name}.kdl"), &text)?)
}

impl Study<'_> {
    fn say(&self, what: &str) {
        eprintln!("{what}");
    }

    fn write(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.directory.join(name);
        std::fs::write(&path, text).map_err(|error| Failure::Other(format!("{}: {error}", path.display())))
    }

    /// Makes the page of all parts that are there.
    fn write_page(&self) -> Result<(), Failure> {
        let mut page = format!(
            "# The evaluation of the thesis, repeated\n\nCarvalho, \"Combining the Ray Marching and Rasterization rendering \
             models\", University of Porto, 2020, chapter 5, measured again with pathmarch {}. Each part says what it ran on \
             and the command that repeats it; its numbers stand beside it as CSV, its plots as SVG.\n",
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

    /// Short names of the backends, all different.
    fn backends(&self) -> Vec<String> {
        let names: Vec<_> = self.renderers.iter().map(|renderer| renderer.backend().name).collect();
        let is_alone = |name: &String| names.iter().filter(|other| *other == name).count() == 1;
        let both = names.iter().zip(&self.renderers);
        both.map(|(name, renderer)| if is_alone(name) { name.clone() } else { measure::described(renderer) }).collect()
    }

    /// What a part ran on, and how to repeat it.
    fn conditions(&self, what: &str) -> String {
        let backends: Vec<_> = self.renderers.iter().map(measure::described).collect();
        format!(
            "*pathmarch {}, on {}; {what}. `{}`*\n",
            env!("CARGO_PKG_VERSION"),
            backends.join(" and "),
            self.command
        )
    }

    /// Median milliseconds of a sample on each backend, none where it cannot render the scene.
    fn time(&mut self, scene: &Scene, bounces: u32, size: [u32; 2]) -> Result<Vec<Option<f64>>, Failure> {
        let rounds = self.plan.rounds;
        let settings = Settings { size, bounces, samples: 1 + rounds, ..Settings::of(scene) };
        let (mut jobs, mut able) = (Vec::new(), Vec::new());
        for renderer in &mut self.renderers {
            self.watch.check()?;
            match measure::start(renderer, scene, &settings) {
                Ok(job) => jobs.push(job),
                Err(failure) => {
                    eprintln!("not on {}:", measure::described(renderer));
                    failure.print();
                    able.push(false);
                    continue;
                }
            }
            able.push(true);
        }
        let times = measure::time_in_turn(&mut jobs, 1..=rounds, 1, LONG, &self.watch)?;
        let mut medians = times.iter().map(|times| times.spread()[0]);
        Ok(able.into_iter().map(|able| able.then(|| medians.next()).flatten()).collect())
    }

    /// The backend with the least of these times.
    fn fastest(times: &[Option<f64>]) -> usize {
        let time = |index: &usize| times[*index].unwrap_or(f64::INFINITY);
        (0..times.len()).min_by(|a, b| time(a).total_cmp(&time(b))).unwrap_or(0)
    }

    /// Renders a picture of the page and writes it; returns it for whoever measures it.
    fn picture(&mut self, name: &str, scene: &Scene, settings: &Settings, backend: usize) -> Result<Picture, Failure> {
        let effort = Effort::Samples(settings.samples);
        let taken = measure::take(&mut self.renderers[backend], scene, settings, effort, &self.watch)?;
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: settings.camera_of(scene).exposure };
        let path = self.directory.join(name);
        image::save(&path, &taken.picture, &display, &Provenance::default()).map_err(Failure::other)?;
        Ok(taken.picture)
    }

    /// What the page's pictures of a scene have.
    fn picture_settings(&self, scene: &Scene) -> Settings {
        Settings { size: self.plan.picture_size, samples: self.plan.picture_samples, ..Settings::of(scene) }
    }
}
