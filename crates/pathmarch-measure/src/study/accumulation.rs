//! Error over the number of samples: Figure 5.3 of the thesis.
//!
//! relMSE against a converged reference whose own noise is subtracted ([`crate::measure`]), with the Sobol' sampler and
//! with independent random numbers, whose error falls as 1 / samples.

use super::picture_grid::{Panel, save as save_grid};
use super::plot::{Line, Lines, SeriesLabelPosition, save};
use super::table::Table;
use super::{Study, example};
use crate::measure::{Budget, Reference, render_for, start, until};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;
use pathmarch_render::image::Picture;
use pathmarch_render::pathmarch_scene::{Sampler, Scene};
use pathmarch_render::tonemap::Display;

const SCENES: [&str; 5] = ["grey-mandelbulb", "diffuse-sphere", "three-spheres", "open-room", "emitting-spheres"];
/// Fractal whose frames are shown, and compared with the thesis's accumulation.
const FRACTAL: &str = "grey-mandelbulb";

/// relMSE after 1, 2, 4, … samples, without points below the noise of the reference.
fn errors(
    study: &mut Study,
    backend: usize,
    scene: &Scene,
    settings: &Settings,
    reference: &Reference,
) -> Result<Vec<(u32, f64)>, Failure> {
    let mut job = start(&study.renderers[backend], scene, settings)?;
    let mut errors = Vec::new();
    let mut samples = 1;
    while samples <= settings.samples {
        until(&mut job, samples, &study.interrupt)?;
        let picture: Picture = job.film().map_err(Failure::other)?.mean();
        let error = reference.error_of(&picture)?;
        if error > 0.1 * reference.noise.unwrap_or(0.0) {
            errors.push((samples, error));
        }
        samples *= 2;
    }
    Ok(errors)
}

/// Exponent of the power law fitted to the points.
fn slope(points: &[(u32, f64)]) -> Option<f64> {
    let logarithms: Vec<_> = points.iter().map(|(samples, error)| (f64::from(*samples).ln(), error.ln())).collect();
    let count = logarithms.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logarithms.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let across: f64 = logarithms.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let along: f64 = logarithms.iter().map(|point| (point.0 - x).powi(2)).sum();
    (along > 0.0).then(|| across / along)
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let samples = study.plan.samples;
    let mut table = Table::new(["scene", "sampler", "samples", "relMSE", "relMSE of the reference"]);
    let mut summary =
        Table::new(["scene", "relMSE at 1 sample", "relMSE at the last", "exponent, Sobol'", "exponent, independent"]);
    let mut lines = Vec::new();
    let mut highest: f64 = 0.0;
    for name in SCENES {
        let scene = example(name)?;
        // The error is measured after every sample, so each one needs a camera ray of its own.
        let settings = Settings {
            size: study.plan.error_size,
            samples,
            splitting: Some(1),
            path_reuse: Some(false),
            ..Settings::of(&scene)
        };
        study.log(&format!("accumulation: {name}, comparing backends"));
        let times = study.time_view(&scene, &settings, settings.bounces)?;
        let backend = Study::fastest(&times);
        study.log(&format!("accumulation: {name}, reference of {} samples", 4 * samples));
        let half = |seed| {
            let settings = Settings { seed, ..settings.clone() };
            render_for(&study.renderers[backend], &scene, &settings, Budget::Samples(2 * samples), &study.interrupt)
        };
        let (a, b) = (half(1)?, half(2)?);
        let reference = Reference::from_halves(&a.picture, &b.picture, a.samples)?;
        study.log(&format!("accumulation: {name}, up to {samples} samples"));
        let mut slopes = Vec::new();
        for sampler in [Sampler::Sobol, Sampler::Independent] {
            let settings = Settings { sampler, ..settings.clone() };
            let errors = errors(study, backend, &scene, &settings, &reference)?;
            for (samples, error) in &errors {
                let noise = reference.noise.map_or_else(String::new, |noise| format!("{noise:.3e}"));
                table.push([
                    name.to_owned(),
                    sampler.name().to_owned(),
                    samples.to_string(),
                    format!("{error:.3e}"),
                    noise,
                ]);
            }
            slopes.push((slope(&errors), errors));
        }
        let [(sobol, errors), (independent, _)] = &slopes[..] else { continue };
        let exponent = |slope: &Option<f64>| slope.map_or("-".to_owned(), |slope| format!("{slope:.2}"));
        let at = |point: Option<&(u32, f64)>| point.map_or("-".to_owned(), |(_, error)| format!("{error:.2e}"));
        summary.push([name.to_owned(), at(errors.first()), at(errors.last()), exponent(sobol), exponent(independent)]);
        highest = highest.max(errors.first().map_or(0.0, |point| point.1));
        let points = errors.iter().map(|(samples, error)| (f64::from(*samples), *error)).collect();
        lines.push(Line { name: name.to_owned(), points, is_guide: false });
    }
    if highest > 0.0 {
        let guide = vec![(1.0, highest), (f64::from(samples), highest / f64::from(samples))];
        lines.push(Line { name: "1 / samples".to_owned(), points: guide, is_guide: true });
    }
    let [width, height] = study.plan.error_size;
    let plot = Lines {
        title: "Error by samples".to_owned(),
        x: "samples of each pixel".to_owned(),
        y: "relMSE against the converged picture".to_owned(),
        legend: SeriesLabelPosition::LowerLeft,
        lines,
    };
    save(study.directory, "accumulation", &plot)?;
    table.save(study.directory, "accumulation")?;

    let fractal = fractal(study)?;
    let conditions = study.conditions(&format!(
        "{width}x{height}, each scene with its own bounces, against {} samples whose own noise is taken off",
        4 * samples
    ));
    Ok(format!(
        "## Accumulation\n\nFigure 5.3 (page 60): a fractal as frames accumulate.\n\n{fractal}\nThe error as samples accumulate, \
         and the exponent with which it falls. Independent random numbers fall as one over the samples, -1; the program's \
         Sobol' points at least as fast.\n\n{}\n![Error by samples](accumulation.png)\n\n{conditions}",
        summary.markdown()
    ))
}

/// Weight of a frame in the thesis's accumulation: `mix(previous, new, 0.05)` in its shader, kept in 8 bits.
const BLEND: f32 = 0.05;

/// Adds a frame as the thesis's program does: blended in display codes, which are rounded.
fn blend(codes: &mut [[u8; 3]], frame: &[[f32; 3]]) {
    for (code, value) in codes.iter_mut().zip(frame) {
        for k in 0..3 {
            let old = f32::from(code[k]) / 255.0;
            code[k] = ((old + BLEND * (value[k].clamp(0.0, 1.0) - old)) * 255.0).round() as u8;
        }
    }
}

/// Root mean square difference of shown pictures, in 255ths.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let square = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|k| f64::from(a[k] - b[k]).powi(2)).sum::<f64>();
    255.0 * (a.iter().zip(b).map(square).sum::<f64>() / (3 * a.len()) as f64).sqrt()
}

/// A fractal frame by frame: our mean, and the thesis's blend.
fn fractal(study: &mut Study) -> Result<String, Failure> {
    let scene = example(FRACTAL)?;
    let size = study.plan.error_size;
    let settings = Settings { size, splitting: Some(1), path_reuse: Some(false), ..Settings::of(&scene) };
    let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
    let shown =
        |picture: &Picture| -> Vec<[f32; 3]> { picture.pixels.iter().map(|pixel| display.encode(*pixel)).collect() };
    let times = study.time_view(&scene, &Settings { size: study.plan.size, ..settings.clone() }, settings.bounces)?;
    let backend = Study::fastest(&times);
    study.log(&format!("accumulation: {FRACTAL}, frames"));
    let reference = study.render(&scene, &Settings { seed: 1, ..settings.clone() }, Some(4 * study.plan.samples))?;
    let expected = shown(&reference);
    let most = study.plan.samples;
    let mut job = start(&study.renderers[backend], &scene, &Settings { samples: most, ..settings.clone() })?;
    let mut before: Option<Picture> = None;
    let mut codes = Vec::new();
    let (mut panels, mut table) =
        (Vec::new(), Table::new(["frames", "our mean, 255ths", "the thesis's blend, 255ths"]));
    for frame in 1..=most {
        until(&mut job, frame, &study.interrupt)?;
        let mean = job.film().map_err(Failure::other)?.mean();
        let single = Picture {
            pixels: match &before {
                None => mean.pixels.clone(),
                Some(before) => {
                    let only = |(now, before): (&[f32; 3], &[f32; 3])| -> [f32; 3] {
                        std::array::from_fn(|k| frame as f32 * now[k] - (frame - 1) as f32 * before[k])
                    };
                    mean.pixels.iter().zip(&before.pixels).map(only).collect()
                }
            },
            ..mean
        };
        let single = shown(&single);
        match frame {
            1 => codes = single.iter().map(|pixel| pixel.map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8)).collect(),
            _ => blend(&mut codes, &single),
        }
        if frame.is_power_of_two() {
            let blended: Vec<[f32; 3]> = codes.iter().map(|code| code.map(|v| f32::from(v) / 255.0)).collect();
            table.push([
                frame.to_string(),
                format!("{:.2}", difference(&shown(&mean), &expected)),
                format!("{:.2}", difference(&blended, &expected)),
            ]);
            if [1, 4, 16, 64].contains(&frame) {
                panels.push(Panel::of(&mean, &display));
            }
        }
        before = Some(mean);
    }
    save_grid(&study.directory.join("accumulation.jpg"), &panels, 2)?;
    table.save(study.directory, "accumulation-fractal")?;
    let [width, height] = study.plan.size;
    let worth = times[backend].map_or_else(String::new, |time| {
        format!(
            "A sample of this fractal takes {time:.0} ms at {width}x{height} on this machine, so that a second is worth {:.1} \
             samples; the thesis reports 76.9 ms on its GPU, and that a second of accumulation looks like over 32 samples \
             (section 5.6), which are 13 frames.",
            1e3 / time
        )
    });
    Ok(format!(
        "![1, 4, 16 and 64 frames](accumulation.jpg)\n\n`{FRACTAL}` after 1, 4, 16 and 64 frames of one sample. {worth}\n\n\
         The difference of the shown picture from the converged one, root mean square, of our mean in 32-bit floats, and of \
         the same frames blended as the thesis's program does, with a weight of 0.05 in 8 bits: such a blend is worth 39 \
         frames at most, and frames are clipped before they are averaged, which darkens.\n\n{}",
        table.markdown()
    ))
}

#[cfg(test)]
mod tests {
    use super::{blend, slope};

    #[test]
    fn a_blend_of_fixed_weight_forgets_its_first_frame() {
        let mut codes = vec![[255; 3]];
        (0..200).for_each(|_| blend(&mut codes, &[[0.5; 3]]));
        assert!(codes[0][0].abs_diff(128) <= 10, "{codes:?}");
    }

    #[test]
    fn slopes_are_exponents() {
        let points = [(1, 8.0), (2, 2.0), (4, 0.5)];
        assert!(slope(&points).is_some_and(|slope| (slope + 2.0).abs() < 1e-9));
        assert_eq!(slope(&points[..1]), None);
        assert_eq!(slope(&[]), None);
    }
}
