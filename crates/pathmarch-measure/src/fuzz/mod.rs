//! `pathmarch-measure fuzz`: random inputs for everything that reads files of strangers.
//!
//! **Idea.** An input of the corpus, or one made from the registry, is changed at random: bytes, numbers, words and ranges are
//! replaced, doubled, removed or exchanged with those of others. A target reads it. A panic, or more than a second, is a
//! failure; its input is kept. No coverage guides the choice, so that it runs on stable Rust, at the full speed of the release build.
//!
//! Inputs follow from the seed, so that a run can be repeated.

mod corpus;
mod mutation;
mod targets;

use crate::measure::make_directory;
use clap::ValueEnum;
use corpus::corpus;
use mutation::Random;
use pathmarch_cli::{DONE, FAILED, Failure, note, value_parsers};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use targets::{Target, without_gpu};

/// Arguments of `fuzz`.
#[derive(clap::Args)]
pub struct Arguments {
    /// What reads the inputs [default: all]
    #[arg(value_enum)]
    targets: Vec<Target>,
    /// Seconds for each target
    #[arg(long, value_name = "N", default_value = "60", value_parser = value_parsers::seconds)]
    seconds: f64,
    /// Number of inputs for each target, instead of a time
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Seed of the inputs
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Directory for inputs that fail
    #[arg(long, value_name = "DIRECTORY", default_value = "fuzz-failures")]
    failures: PathBuf,
}

/// Runs the targets.
///
/// # Errors
/// If files cannot be written.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let targets = if arguments.targets.is_empty() { Target::value_variants() } else { &arguments.targets };
    // A panic is reported with its input.
    std::panic::set_hook(Box::new(|_| {}));
    let mut code = DONE;
    for target in targets {
        if fuzz(arguments, *target)? > 0 {
            code = FAILED;
        }
    }
    Ok(code)
}

/// Runs one target, and returns the number of failures.
fn fuzz(arguments: &Arguments, target: Target) -> Result<u64, Failure> {
    let scratch = tempfile::tempdir().map_err(Failure::other)?;
    let seeds = corpus(target);
    let mut random = Random::new(arguments.seed);
    if let Some(reason) = without_gpu().filter(|_| target == Target::GpuField) {
        note!("note: no fields are rendered on a GPU: {reason}");
        return Ok(0);
    }
    let (started, mut inputs, mut accepted, mut failures) = (Instant::now(), 0_u64, 0_u64, 0_u64);
    let mut slowest = Duration::ZERO;
    while arguments.count.map_or(started.elapsed().as_secs_f64() < arguments.seconds, |count| inputs < count) {
        let input = target.input(&mut random, &seeds);
        let began = Instant::now();
        let result = catch_unwind(AssertUnwindSafe(|| target.run(&input, scratch.path())));
        let mut took = began.elapsed();
        // On a busy machine any input may take long once.
        for _ in 0..2 {
            if took > target.limit() && result.is_ok() {
                let began = Instant::now();
                let _ = catch_unwind(AssertUnwindSafe(|| target.run(&input, scratch.path())));
                took = took.min(began.elapsed());
            }
        }
        (inputs, slowest) = (inputs + target.cases(), slowest.max(took));
        accepted += if matches!(&result, Ok(Ok(true))) { target.cases() } else { 0 };
        let reason = match result {
            Err(_) => Some("panic".to_owned()),
            Ok(Err(reason)) => Some(reason),
            Ok(Ok(_)) => (took > target.limit()).then(|| format!("took {:.1} s", took.as_secs_f64())),
        };
        if let Some(reason) = reason {
            failures += 1;
            keep(arguments, target, inputs, &input, &reason)?;
        }
    }
    note!(
        "{target:?}: {inputs} inputs in {:.0} s, {accepted} accepted, slowest {:.0} ms, {failures} failures{}",
        started.elapsed().as_secs_f64(),
        slowest.as_secs_f64() * 1000.0,
        peak_memory().map_or_else(String::new, |megabytes| format!(", at most {megabytes} MB of memory"))
    );
    Ok(failures)
}

/// Largest resident memory of this process so far, MB; `None` where Linux does not report it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    kilobytes.split_whitespace().next()?.parse::<u64>().ok().map(|kilobytes| kilobytes >> 10)
}

/// Keeps an input that failed.
fn keep(arguments: &Arguments, target: Target, number: u64, input: &[u8], reason: &str) -> Result<(), Failure> {
    make_directory(&arguments.failures)?;
    let path = arguments.failures.join(format!("{target:?}-{}-{number}", arguments.seed).to_lowercase());
    std::fs::write(&path, input).map_err(Failure::other)?;
    note!("{}: {reason}", path.display());
    Ok(())
}
