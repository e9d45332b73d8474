//! Error over the number of samples: Figure 5.3 of the thesis.
//!
//! relMSE against a converged reference whose own noise is subtracted ([`crate::measure`]), with the Sobol' sampler and
//! with independent random numbers, whose error falls as 1 / samples.

use super::plot::{Line, Lines, SeriesLabelPosition, save};
use super::table::Table;
use super::{Study, example};
use crate::measure::{Budget, Reference, render_for, start, until};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;
use pathmarch_render::image::Picture;
use pathmarch_render::pathmarch_scene::{Sampler, Scene};

const SCENES: [&str; 4] = ["diffuse-sphere", "three-spheres", "open-room", "emitting-spheres"];
/// Scene whose pictures are shown.
const PICTURED_SCENE: &str = "open-room";

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
        let settings = Settings { size: study.plan.error_size, samples, splitting: Some(1), ..Settings::of(&scene) };
        study.log(&format!("accumulation: {name}, comparing backends"));
        let times = study.time(&scene, settings.bounces, settings.size)?;
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

    let scene = example(PICTURED_SCENE)?;
    let shown: Vec<_> = [1, 4, 16, 64].into_iter().filter(|shown| *shown <= samples).collect();
    let mut pictures = Table::new(shown.iter().map(|shown| format!("{shown} spp")));
    for shown in &shown {
        let settings = Settings { samples: *shown, ..study.picture_settings(&scene) };
        study.picture(&format!("accumulation-{shown}.jpg"), &scene, &settings, 0)?;
    }
    pictures.push(shown.iter().map(|shown| format!("![{shown} samples](accumulation-{shown}.jpg)")));
    let conditions = study.conditions(&format!(
        "{width}x{height}, each scene with its own bounces, against {} samples whose own noise is taken off",
        4 * samples
    ));
    Ok(format!(
        "## Accumulation\n\nAfter Figure 5.3, which shows a fractal: the error as samples accumulate; pictures of `{PICTURED_SCENE}`. Sums are kept in 32-bit \
         floats, so that the error goes on falling; the thesis's program keeps a blend of fixed weight in 8 bits, which \
         stops improving at about 39 samples. Independent random numbers fall as one over the samples, -1; the program's \
         Sobol' points at least as fast.\n\n{}\n{}\n![Error by samples](accumulation.png)\n\n{conditions}",
        pictures.markdown(),
        summary.markdown()
    ))
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn slopes_are_exponents() {
        let points = [(1, 8.0), (2, 2.0), (4, 0.5)];
        assert!(slope(&points).is_some_and(|slope| (slope + 2.0).abs() < 1e-9));
        assert_eq!(slope(&points[..1]), None);
        assert_eq!(slope(&[]), None);
    }
}
