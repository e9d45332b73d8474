//! `pathmarch-measure bench --peers`: other renderers on the same scenes, in the same run.
//!
//! **Method.** In each round every renderer renders every scene once, with another seed. Peers take a given number of samples;
//! ours take as many as fit into the time of the slowest peer. The relMSE of a renderer is the variance of its own pictures over
//! rounds, divided by the square of the mean of ours plus 0.01: without bias, no reference is needed, and a bias shows in the
//! column of means. *Cost* is seconds x relMSE. With independent samples, as Mitsuba's, it does not depend on their number; with
//! those of Cycles and ours, which are spread evenly, it falls with the number, hence the equal time. Ratios are to the cheaper of our
//! backends; their spread is that over all pairs of rounds.
//!
//! **Limits.** Scenes that [`DescribedScene`] cannot describe have no peers. Settings are unbiased: `caustics "sampled"`, no clamp.
//! Our seconds and Mitsuba's exclude compilation and the building of the scene; those of Cycles include the latter.
//!
//! With `--thesis-shader`, frames of the thesis's program are timed beside frames of ours: one sample of every pixel with
//! four hits, each with a camera ray and a path of its own, as in a moving picture.

use super::Arguments;
use super::scenes::NamedScene;
use crate::measure::{self, Budget, Interrupt, median};
use crate::peers::{Cycles, DescribedScene, Mitsuba, PeerPicture, Python, ThesisFrame, ThesisProgram};
use crate::study::{describe_machine, letter_of};
use pathmarch_cli::{DONE, FAILED, Failure, note, outln};
use pathmarch_render::image::Picture;
use pathmarch_render::{Renderer, Settings};
use std::path::Path;

/// Cells of meshes made from fields.
const CELLS: u32 = 256;
/// Part of the denominator of relMSE.
const EPSILON: f64 = 0.01;
/// Scattering events after the first hit in frames of the thesis's program, which has four hits.
const PROGRAM_BOUNCES: u32 = 3;

/// Pictures of one renderer, a round each.
struct Pictures {
    name: String,
    is_ours: bool,
    rounds: Vec<PeerPicture>,
}

/// Renderers of other people that were found.
struct Peers {
    mitsuba: Option<(Mitsuba, String)>,
    cycles: Option<(Cycles, String)>,
    program: Option<ThesisProgram>,
}

impl Peers {
    fn find(arguments: &Arguments) -> Self {
        let python = Python::new(arguments.python.as_deref());
        let program = ThesisProgram::find(python.clone(), arguments.thesis_shader.as_deref());
        if !arguments.peers {
            return Self { mitsuba: None, cycles: None, program };
        }
        let named = |name: &str, version: String| format!("{name} {version}");
        let mitsuba = Mitsuba::find(python.clone()).map(|mitsuba| {
            let name = named("Mitsuba LLVM", mitsuba.version());
            (mitsuba, name)
        });
        let cycles = Cycles::find(python).map(|cycles| {
            let name = named("Cycles", cycles.version());
            (cycles, name)
        });
        Self { mitsuba, cycles, program }
    }

    /// A round of every peer that renders pictures.
    fn round(
        &self,
        described: &DescribedScene,
        [settings_samples, seed]: [u32; 2],
        size: [u32; 2],
        directory: &Path,
    ) -> Vec<(String, Result<PeerPicture, Failure>)> {
        let only = |name: &str, pictures: Result<Vec<PeerPicture>, Failure>| {
            let none = || Failure::Other(format!("{name} wrote no picture"));
            (name.to_owned(), pictures.and_then(|mut pictures| pictures.pop().ok_or_else(none)))
        };
        let mitsuba = self
            .mitsuba
            .iter()
            .map(|(mitsuba, name)| only(name, mitsuba.render(described, size, settings_samples, seed, directory)));
        let cycles = self.cycles.iter().map(|(cycles, name)| {
            only(name, cycles.render(described, size, &[settings_samples], seed, false, directory))
        });
        mitsuba.chain(cycles).collect()
    }
}

pub fn run(
    arguments: &Arguments,
    scenes: &[NamedScene],
    renderers: &[Renderer],
    interrupt: &Interrupt,
) -> Result<u8, Failure> {
    let peers = Peers::find(arguments);
    if peers.mitsuba.is_none() && peers.cycles.is_none() && peers.program.is_none() {
        let message = "no peer was found: pip install mitsuba bpy, and name their Python by --python; \
                       --thesis-shader needs moderngl";
        return Err(Failure::Other(message.to_owned()));
    }
    let [processor, memory, system] = describe_machine();
    let ([width, height], rounds) = (arguments.size(), arguments.rounds());
    outln!("{processor}; {memory}; {system}; {width}x{height}, {rounds} rounds\n");
    let mut measured = 0;
    if arguments.peers {
        outln!("| Scene | Renderer | Samples | Seconds | relMSE | Cost | Of ours | Spread | Mean, % |");
        outln!("|---|---|---|---|---|---|---|---|---|");
    }
    for chosen in scenes.iter().filter(|_| arguments.peers) {
        match measure_scene(arguments, chosen, (renderers, &peers), interrupt) {
            Ok(()) => measured += 1,
            Err(Failure::Interrupted) => return Err(Failure::Interrupted),
            Err(failure) => {
                note!("{}: skipped", chosen.name);
                failure.print();
            }
        }
    }
    if let Some(program) = &peers.program {
        measured += frames(arguments, scenes, (renderers, program), interrupt)?;
    }
    Ok(if measured > 0 { DONE } else { FAILED })
}

/// Renders all rounds of a scene, and prints a row for each renderer.
fn measure_scene(
    arguments: &Arguments,
    chosen: &NamedScene,
    (renderers, peers): (&[Renderer], &Peers),
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let scene = &chosen.scene;
    let settings = measure::unbiased(Settings { size: arguments.size(), ..Settings::of(scene) });
    let directory = tempfile::tempdir().map_err(Failure::other)?;
    let described = DescribedScene::write(scene, &settings, CELLS, directory.path())?;
    scene.field.build_shape_grids();
    let mut all: Vec<Pictures> = Vec::new();
    for seed in 1..=arguments.rounds() {
        interrupt.check()?;
        note!("{}: round {seed}", chosen.name);
        let mut found = Vec::new();
        for (name, picture) in peers.round(&described, [arguments.samples(), seed], settings.size, directory.path()) {
            match picture {
                Ok(picture) => found.push((name, false, picture)),
                Err(failure) => failure.print(),
            }
        }
        let none = || Failure::Other("no peer renders this scene".to_owned());
        let seconds = found.iter().map(|(.., picture)| picture.seconds).max_by(f64::total_cmp).ok_or_else(none)?;
        for renderer in renderers {
            let settings = Settings { seed, ..settings.clone() };
            let taken = measure::render_for(renderer, scene, &settings, Budget::Seconds(seconds), interrupt)?;
            let measure::TimedPicture { picture, samples, seconds } = taken;
            let picture = PeerPicture { samples, seconds, megabytes: None, picture };
            found.push((measure::backend_label(renderer), true, picture));
        }
        for (name, is_ours, picture) in found {
            match all.iter_mut().find(|pictures| pictures.name == name) {
                Some(pictures) => pictures.rounds.push(picture),
                None => all.push(Pictures { name, is_ours, rounds: vec![picture] }),
            }
        }
    }
    print(&chosen.name, &all);
    Ok(())
}

fn print(scene: &str, all: &[Pictures]) {
    let reference = mean(all.iter().filter(|pictures| pictures.is_ours).flat_map(|pictures| &pictures.rounds));
    let cost = |pictures: &Pictures, rounds: &[usize]| {
        let chosen: Vec<&PeerPicture> = rounds.iter().map(|round| &pictures.rounds[*round]).collect();
        seconds(&chosen) * variance(&chosen, &reference)
    };
    let every: Vec<usize> = (0..all.iter().map(|pictures| pictures.rounds.len()).min().unwrap_or(0)).collect();
    let ours = all.iter().filter(|pictures| pictures.is_ours);
    let best = ours.min_by(|a, b| cost(a, &every).total_cmp(&cost(b, &every)));
    let Some(best) = best.filter(|_| every.len() > 1) else {
        note!("{scene}: two rounds are needed at least");
        return;
    };
    for pictures in all {
        let rounds: Vec<&PeerPicture> = pictures.rounds.iter().collect();
        let ratio = |rounds: &[usize]| cost(pictures, rounds) / cost(best, rounds);
        let pairs = every.iter().flat_map(|a| every[a + 1..].iter().map(|b| [*a, *b]));
        let ratios: Vec<f64> = pairs.map(|pair| ratio(&pair)).collect();
        let spread = [f64::min, f64::max].map(|pick| ratios.iter().copied().reduce(pick).unwrap_or(1.0));
        let [difference, deviation] = mean_difference(&rounds, &reference);
        outln!(
            "| {scene} | {} | {} | {:.2} | {:.2e} | {:.2e} | {} | {}-{} | {:+.2} ± {:.2} |",
            pictures.name,
            rounds[0].samples,
            seconds(&rounds),
            variance(&rounds, &reference),
            cost(pictures, &every),
            factor(ratio(&every)),
            factor(spread[0]),
            factor(spread[1]),
            100.0 * difference,
            100.0 * deviation,
        );
    }
}

/// A ratio with two significant digits.
fn factor(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.1}") } else { format!("{ratio:.0}") }
}

/// Median time of the rounds, seconds.
fn seconds(rounds: &[&PeerPicture]) -> f64 {
    median(&rounds.iter().map(|picture| picture.seconds).collect::<Vec<f64>>())
}

/// Mean of pictures, weighted by their samples.
fn mean<'a>(pictures: impl Iterator<Item = &'a PeerPicture>) -> Vec<[f64; 3]> {
    let (mut sum, mut weight) = (Vec::new(), 0.0);
    for PeerPicture { picture, samples, .. } in pictures {
        sum.resize(picture.pixels.len(), [0.0; 3]);
        weight += f64::from(*samples);
        for (sum, pixel) in sum.iter_mut().zip(&picture.pixels) {
            *sum = std::array::from_fn(|k| sum[k] + f64::from(*samples) * f64::from(pixel[k]));
        }
    }
    sum.into_iter().map(|pixel: [f64; 3]| pixel.map(|value| value / weight)).collect()
}

/// relMSE of one of several pictures that differ by their noise.
fn variance(rounds: &[&PeerPicture], reference: &[[f64; 3]]) -> f64 {
    let count = rounds.len() as f64;
    let of_channel = |(index, reference): (usize, f64)| {
        let values = || rounds.iter().map(move |round| f64::from(round.picture.pixels[index / 3][index % 3]));
        let mean = values().sum::<f64>() / count;
        let variance = values().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        variance / (reference * reference + EPSILON)
    };
    let channels = reference.as_flattened().iter().copied().enumerate().map(of_channel);
    channels.sum::<f64>() / reference.as_flattened().len() as f64
}

/// Relative difference of the mean of all pixels from the reference's, and the standard deviation of that over rounds.
fn mean_difference(rounds: &[&PeerPicture], reference: &[[f64; 3]]) -> [f64; 2] {
    let whole = reference.as_flattened().iter().sum::<f64>() / reference.len() as f64;
    let difference = |picture: &Picture| picture.mean_colour().iter().sum::<f64>() / whole - 1.0;
    let all: Vec<f64> = rounds.iter().map(|round| difference(&round.picture)).collect();
    let count = all.len() as f64;
    let mean = all.iter().sum::<f64>() / count;
    let variance = all.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [mean, (variance / count).sqrt()]
}

/// Frames of one sample and four hits, by the thesis's program and by ours, in turns. Returns the number of scenes.
fn frames(
    arguments: &Arguments,
    scenes: &[NamedScene],
    (renderers, program): (&[Renderer], &ThesisProgram),
    interrupt: &Interrupt,
) -> Result<u32, Failure> {
    let mut measured = 0;
    outln!(
        "\n| Scene | Thesis's program, ms | Ours, ms | Backend | Times faster | Spread |\n|---|---|---|---|---|---|"
    );
    for NamedScene { name, scene, .. } in scenes {
        let Some(letter) = letter_of(name) else {
            note!("{name}: the thesis's program has no such scene");
            continue;
        };
        let rounds = arguments.rounds();
        let settings = Settings { size: arguments.size(), bounces: PROGRAM_BOUNCES, ..Settings::of(scene) };
        let settings = Settings { samples: 1 + rounds, splitting: Some(1), path_reuse: Some(false), ..settings };
        let frame = ThesisFrame { scene: letter, camera: settings.camera_of(scene).clone(), hits: PROGRAM_BOUNCES + 1 };
        let mut jobs = Vec::new();
        for renderer in renderers {
            let mut job = measure::start(renderer, scene, &settings)?;
            measure::until(&mut job, 1, interrupt)?;
            jobs.push(job);
        }
        let (mut theirs, mut ours) = (Vec::new(), vec![Vec::new(); renderers.len()]);
        for round in 0..rounds {
            theirs.extend(program.times(std::slice::from_ref(&frame), settings.size, 3)?.0);
            for (job, times) in jobs.iter_mut().zip(&mut ours) {
                let began = std::time::Instant::now();
                measure::until(job, round + 2, interrupt)?;
                times.push(began.elapsed().as_secs_f64() * 1e3);
            }
        }
        for (renderer, times) in renderers.iter().zip(&ours) {
            let ratios: Vec<f64> = theirs.iter().zip(times).map(|(theirs, ours)| theirs / ours).collect();
            let [low, high] = [f64::min, f64::max].map(|pick| ratios.iter().copied().reduce(pick).unwrap_or(1.0));
            let [theirs, ours] = [&theirs, times].map(|times| median(times));
            let backend = measure::backend_label(renderer);
            let ratio = factor(theirs / ours);
            outln!("| {name} | {theirs:.0} | {ours:.0} | {backend} | {ratio} | {}-{} |", factor(low), factor(high));
        }
        measured += 1;
    }
    Ok(measured)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures whose pixels differ from 2 by a known amount.
    fn picture(offset: f32) -> PeerPicture {
        let picture = Picture::from_fn(8, 8, |x, _| [2.0 + if x % 2 == 0 { offset } else { -offset }; 3]);
        PeerPicture { samples: 4, seconds: f64::from(offset), megabytes: None, picture }
    }

    #[test]
    fn variances_and_means_are_those_of_known_pictures() {
        let pictures = [picture(-0.1), picture(0.0), picture(0.1)];
        let rounds: Vec<&PeerPicture> = pictures.iter().collect();
        let reference = mean(pictures.iter());
        assert!((variance(&rounds, &reference) - 0.01 / 4.01).abs() < 1e-7);
        let [difference, deviation] = mean_difference(&rounds, &reference);
        assert!(difference.abs() < 1e-7 && deviation < 1e-7);
        assert!(seconds(&rounds).abs() < 1e-9);
        assert_eq!([0.123, 9.94, 123.4].map(factor), ["0.1", "9.9", "123"]);
    }
}
