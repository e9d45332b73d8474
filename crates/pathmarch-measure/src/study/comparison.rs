//! Each row of Tables 5.2 to 5.7 beside Cycles, on this machine: error over time at equal size, hits and filter.
//!
//! Both renderers are path tracers without bias, so that equal errors are equal pictures. Cycles renders once for each
//! number of samples; the mean of all its pictures shows whether both converge to one picture.

use super::Study;
use super::picture_grid::{Panel, save as save_grid};
use super::plot::{Line, Lines, SeriesLabelPosition, save};
use super::rows::Row;
use super::table::Table;
use crate::measure::{MAX_SAMPLES, Reference, ReferenceStore, start, unbiased, until};
use crate::peers::{Cycles, DescribedScene, PeerPicture};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;
use pathmarch_render::image::{Picture, PictureKind};
use pathmarch_render::metrics::flip::flip;
use pathmarch_render::pathmarch_scene::Scene;
use pathmarch_render::tonemap::{Display, srgb_decode};
use std::path::Path;
use std::time::Instant;

/// Samples of the thesis's pictures by Cycles.
const MOST: u32 = 128;
/// Cells along the longest side of meshes made from fields.
const CELLS: [u32; 3] = [128, 256, 512];

/// Picture, and what it took.
struct Point {
    samples: u32,
    seconds: f64,
    error: f64,
    picture: Picture,
}

/// Our pictures at doubling numbers of samples, until the error is below `target` and a second has passed, or the time
/// is up.
fn our_points(
    study: &Study,
    backend: usize,
    (scene, settings): (&Scene, &Settings),
    reference: &Reference,
    target: f64,
) -> Result<Vec<Point>, Failure> {
    let settings = Settings { samples: MAX_SAMPLES, ..settings.clone() };
    let mut job = start(&study.renderers[backend], scene, &settings)?;
    // Compiles the kernel.
    let mut warm_up = start(&study.renderers[backend], scene, &Settings { samples: 1, ..settings.clone() })?;
    until(&mut warm_up, 1, &study.interrupt)?;
    let (mut points, mut seconds, mut samples) = (Vec::new(), 0.0, 1);
    loop {
        let began = Instant::now();
        until(&mut job, samples, &study.interrupt)?;
        seconds += began.elapsed().as_secs_f64();
        let picture = job.film().map_err(Failure::other)?.mean();
        let error = reference.error_of(&picture)?;
        points.push(Point { samples, seconds, error, picture });
        if error < target && seconds > 1.0 || seconds > study.plan.reference_seconds {
            return Ok(points);
        }
        samples *= 2;
    }
}

/// Time at which the error falls to a value, seconds: on straight lines between the points in logarithms, continued
/// beyond the last with its slope; for errors above that of the first point, the time of that point.
fn seconds_to(error: f64, points: &[Point]) -> Option<f64> {
    let (first, last) = (points.first()?, points.last()?);
    if error >= first.error {
        return Some(first.seconds);
    }
    let crossing = points.windows(2).find(|pair| pair[0].error >= error && pair[1].error <= error);
    let (a, b) = match crossing {
        Some(pair) => (&pair[0], &pair[1]),
        None => (points.get(points.len().checked_sub(2)?)?, last),
    };
    let (x, y) = ((b.seconds / a.seconds).ln(), (b.error / a.error).ln());
    (y < 0.0).then(|| a.seconds * ((error / a.error).ln() / y * x).exp())
}

/// The picture that is ready after a second, or the first.
fn after_a_second(points: &[Point]) -> Option<&Point> {
    points.iter().rev().find(|point| point.seconds <= 1.0).or_else(|| points.first())
}

/// Mean of pictures, weighted by their samples.
fn mean(points: &[Point]) -> Option<Picture> {
    let all: u32 = points.iter().map(|point| point.samples).sum();
    let first = &points.first()?.picture;
    let mut mean = Picture::new(first.width, first.height);
    for point in points {
        let weight = point.samples as f32 / all as f32;
        for (sum, value) in mean.pixels.iter_mut().zip(&point.picture.pixels) {
            *sum = std::array::from_fn(|k| sum[k] + weight * value[k]);
        }
    }
    Some(mean)
}

/// As a screen shows it, in linear light.
fn shown(picture: &Picture, display: &Display) -> Picture {
    let pixels = picture.pixels.iter().map(|pixel| display.encode(*pixel).map(srgb_decode)).collect();
    Picture { pixels, ..*picture }
}

/// What a row found out.
struct Compared {
    cells: Vec<String>,
    lines: [Line; 2],
}

fn compare(
    study: &Study,
    cycles: &Cycles,
    (name, label): (&str, &str),
    (scene, settings, backend): (&Scene, &Settings, usize),
    (described, reference): (&DescribedScene, &Reference),
    directory: &Path,
) -> Result<Compared, Failure> {
    let samples: Vec<u32> =
        (0..).map(|power| 1 << power).take_while(|samples| *samples <= study.plan.cycles_samples).collect();
    study.log(&format!("comparison: {label}, Cycles"));
    let pictures = cycles.render(described, settings.size, &samples, 0, false, directory)?;
    let point = |PeerPicture { samples, seconds, picture, .. }| -> Result<Point, Failure> {
        Ok(Point { samples, seconds, error: reference.error_of(&picture)?, picture })
    };
    let theirs: Vec<Point> = pictures.into_iter().map(point).collect::<Result<_, _>>()?;
    let none = || Failure::Other("Cycles wrote no picture".to_owned());
    let last = theirs.last().ok_or_else(none)?;
    study.log(&format!("comparison: {label}, pathmarch"));
    let ours = our_points(study, backend, (scene, settings), reference, last.error)?;
    let converged = mean(&theirs).ok_or_else(none)?;
    let display = Display { tonemap: scene.render.tonemap, exposure_stops: settings.camera_of(scene).exposure };
    let shown_reference = shown(&reference.picture, &display);
    let flip_of =
        |picture: &Picture| flip(&shown(picture, &display), &shown_reference, PictureKind::Ldr).map_err(Failure::other);
    let (our_second, their_second) =
        (after_a_second(&ours).ok_or_else(none)?, after_a_second(&theirs).ok_or_else(none)?);

    let shown = [&our_second.picture, &their_second.picture, &last.picture, &reference.picture];
    let mut panels: Vec<Panel> = shown.map(|picture| Panel::of(picture, &display).reduced(2)).to_vec();
    let compared = [&our_second.picture, &their_second.picture, &last.picture, &converged];
    let maps = compared.map(flip_of);
    let mut flips = Vec::new();
    for map in maps {
        let map = map?;
        flips.push(map.mean());
        panels.push(Panel::of_errors(&map).reduced(2));
    }
    save_grid(&study.directory.join(format!("comparison-{name}.jpg")), &panels, 4)?;

    let ours_to_theirs = seconds_to(last.error, &ours);
    let number = |value: f64| if value < 10.0 { format!("{value:.2}") } else { format!("{value:.0}") };
    let mean_difference = reference.mean_difference(&converged);
    let cells = vec![
        format!("{:+.2} %", 100.0 * mean_difference),
        format!("{:.4}", flips[3]),
        format!("{} / {:.2e}", our_second.samples, our_second.error),
        format!("{} / {:.2e}", their_second.samples, their_second.error),
        format!("{:.3} / {:.3}", flips[0], flips[1]),
        format!("{} / {:.2e}", number(last.seconds), last.error),
        ours_to_theirs.map_or("-".to_owned(), number),
        ours_to_theirs.map_or("-".to_owned(), |ours| format!("{:.1}", last.seconds / ours)),
    ];
    let line = |name: String, points: &[Point]| Line {
        name,
        points: points.iter().filter(|point| point.error > 0.0).map(|point| (point.seconds, point.error)).collect(),
        is_guide: false,
    };
    Ok(Compared {
        cells,
        lines: [line(format!("{label}, pathmarch"), &ours), line(format!("{label}, Cycles"), &theirs)],
    })
}

/// Table of the row whose surface becomes a mesh.
const MESH_TABLE: &str = "5.7";

fn mesh_name(row: &Row, cells: u32) -> String {
    format!("{}-{cells}", row.name())
}

/// Caption and picture of a row.
fn picture(row: &Row, name: &str) -> String {
    let [figure, theirs] = row.figures;
    let figures = if figure == theirs { format!("Figure {figure}") } else { format!("Figures {figure} and {theirs}") };
    format!("{figures}, {}:\n\n![{}](comparison-{name}.jpg)\n\n", row.title.to_lowercase(), row.title)
}

const HEADS: [&str; 8] = [
    "means, converged",
    "FLIP, converged",
    "ours after 1 s: samples / relMSE",
    "Cycles after 1 s",
    "FLIP after 1 s, ours / Cycles",
    "Cycles, 128 samples: s / relMSE",
    "ours to that error, s",
    "times faster",
];

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let Some(cycles) = Cycles::find(study.python.clone()) else {
        return Ok(
            "## Beside Cycles\n\nNot measured: Python has no module `bpy` (`pip install bpy`, or `--python`).\n"
                .to_owned(),
        );
    };
    let directory = tempfile::tempdir().map_err(Failure::other)?;
    let store_path = study.references.clone().unwrap_or_else(|| directory.path().to_owned());
    let store = ReferenceStore::new(store_path, study.plan.reference_seconds)?;
    let heads = ["table", "row", "published: Cycles 2.8"].into_iter().chain(HEADS);
    let mut table = Table::new(heads);
    let mut meshes = Table::new([
        "cells",
        "triangles",
        "mesh, s",
        "Cycles: scene and BVH, s",
        "Cycles: memory, MB",
        "mean distance from the surface",
        "largest",
        "means, converged",
        "FLIP, converged",
    ]);
    // Tables that are asked for, and none for those whose plot stays.
    let asked = study.tables.clone();
    let is_asked = |table: &str| asked.is_empty() || asked.iter().any(|asked| asked == table);
    let saved = table.saved_rows(study.directory, "comparison");
    if !is_asked(MESH_TABLE) {
        meshes.saved_rows(study.directory, "comparison-meshes").into_iter().for_each(|row| meshes.push(row));
    }
    let mut plots: Vec<(&str, Vec<Line>)> = Vec::new();
    let mut pictures = String::new();
    let rows: Vec<&Row> = study.rows().collect();
    for row in rows {
        let label = row.label();
        if !is_asked(row.table) {
            let found = saved.iter().find(|saved| saved[0] == row.table && saved[1] == row.title);
            let missing = || Failure::Other(format!("no earlier run has the row {label}: leave --table out"));
            table.push(found.ok_or_else(missing)?.clone());
            pictures += &picture(row, &if row.table == MESH_TABLE { mesh_name(row, CELLS[2]) } else { row.name() });
            if plots.last().is_none_or(|(table, _)| *table != row.table) {
                plots.push((row.table, Vec::new()));
            }
            continue;
        }
        let (scene, settings) = row.load(study.plan.error_size)?;
        let settings = unbiased(settings);
        let times = study.time_view(&scene, &settings, settings.bounces)?;
        let backend = Study::fastest(&times);
        study.log(&format!("comparison: {label}, reference"));
        let renderer = &study.renderers[backend];
        let reference = store.get(&row.name(), &scene, &settings, renderer, &study.interrupt)?;
        let few = if study.plan.few_rows { &CELLS[..1] } else { &CELLS[..] };
        for cells in few.iter().rev() {
            let described = DescribedScene::write(&scene, &settings, *cells, directory.path())?;
            let (name, label) = if described.triangles > 0 {
                (mesh_name(row, *cells), format!("{label}, {cells} cells"))
            } else {
                (row.name(), label.clone())
            };
            let view = (&scene, &settings, backend);
            let compared = compare(study, &cycles, (&name, &label), view, (&described, &reference), directory.path())?;
            let is_first = std::ptr::eq(cells, &few[few.len() - 1]);
            if is_first {
                let first = [row.table, row.title, row.cycles].map(str::to_owned).into_iter();
                let mut cells = compared.cells.clone();
                if described.triangles > 0 {
                    // The error of Cycles is that of the mesh, so that times to it say nothing.
                    let ratios = cells.len() - 2;
                    cells[ratios..].fill("-".to_owned());
                }
                table.push(first.chain(cells));
                pictures += &picture(row, &name);
                match plots.last_mut().filter(|(table, _)| *table == row.table) {
                    Some((_, lines)) => lines.extend(compared.lines),
                    None => plots.push((row.table, compared.lines.into())),
                }
            }
            if described.triangles == 0 {
                break;
            }
            let setup = cycles.setup(&described, settings.size, directory.path())?;
            meshes.push([
                cells.to_string(),
                described.triangles.to_string(),
                format!("{:.1}", described.mesh_seconds),
                format!("{:.1}", setup.seconds),
                setup.megabytes.map_or("-".to_owned(), |megabytes| format!("{megabytes:.0}")),
                format!("{:.1e}", described.distances[0]),
                format!("{:.1e}", described.distances[1]),
                compared.cells[0].clone(),
                compared.cells[1].clone(),
            ]);
        }
    }
    table.save(study.directory, "comparison")?;
    meshes.save(study.directory, "comparison-meshes")?;
    let mut graphs = String::new();
    for (number, lines) in plots {
        let name = format!("comparison-{}", number.replace('.', "-"));
        graphs += &format!("![Error by time, Table {number}]({name}.png)\n\n");
        if lines.is_empty() {
            continue;
        }
        let plot = Lines {
            title: format!("Error by time, Table {number}"),
            x: "seconds".to_owned(),
            y: "relMSE".to_owned(),
            legend: SeriesLabelPosition::LowerLeft,
            lines,
        };
        save(study.directory, &name, &plot)?;
    }
    let losses = table.losses(HEADS[7], 1).map_or_else(String::new, |rows| {
        format!(
            "**Cycles is faster** to its error of {MOST} samples in: {rows}. A few bright samples make most of the error there, so \
             that the ratio is as uncertain as they are rare.\n\n"
        )
    });
    let [width, height] = study.plan.error_size;
    let conditions = study.conditions(&format!(
        "Cycles {} on the same cores; {width}x{height}, the scene's own bounces in both, one sample after the other, a box \
         filter, no clamping, no denoiser, no adaptive sampling; our fastest backend; references of {} s, whose own noise is \
         subtracted",
        cycles.version(),
        study.plan.reference_seconds
    ));
    Ok(format!(
        "## Beside Cycles\n\n{}Every row of Tables 5.2 to 5.7, with Cycles on the same machine. *Converged*: the mean of all \
         pictures by Cycles against our reference, where a difference of the means beyond noise would be a difference of the \
         light. Spheres are meshes of 131,072 faces in Cycles, and the mandelbulb one of {} cells along its side. Lights have \
         no size in either, so that neither finds the caustics of a point through glass.\n\n{}\nTo show the mandelbulb in \
         Cycles, its surface has to become triangles first, as in Figure 5.15. It is thickened by half a cell, since it is \
         rougher than any mesh; what remains is the error of the shape, which no number of samples removes, and there is no \
         ratio for it. Memory is what its first render adds at most, beside Blender's own copy of the mesh:\n\n{}\nPictures of each row: ours \
         after 1 s, Cycles after 1 s, Cycles with {MOST} samples, our reference; below them the FLIP error of the first \
         three, and of the mean of all pictures by Cycles, from black (0) to white (1).\n\n{pictures}{graphs}{conditions}",
        losses,
        CELLS[2],
        table.markdown(),
        meshes.markdown()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(values: &[(f64, f64)]) -> Vec<Point> {
        let point = |(seconds, error): &(f64, f64)| Point {
            samples: 1,
            seconds: *seconds,
            error: *error,
            picture: Picture::new(1, 1),
        };
        values.iter().map(point).collect()
    }

    #[test]
    fn times_are_interpolated_in_logarithms() {
        let points = points(&[(1.0, 1.0), (4.0, 0.25), (16.0, 0.0625)]);
        let close = |error: f64, expected: f64| {
            let found = seconds_to(error, &points).expect("reached");
            assert!((found / expected - 1.0).abs() < 1e-9, "{error}: {found}");
        };
        close(0.5, 2.0);
        close(0.125, 8.0);
        close(0.0625 / 4.0, 64.0);
        close(2.0, 1.0);
        assert_eq!(seconds_to(0.5, &[]), None);
    }

    #[test]
    fn means_are_weighted_by_samples() {
        let point = |samples: u32, value: f32| Point {
            samples,
            seconds: 1.0,
            error: 1.0,
            picture: Picture::from_fn(1, 1, |_, _| [value; 3]),
        };
        let mean = mean(&[point(1, 4.0), point(3, 0.0)]).expect("pictures");
        assert_eq!(mean.pixels[0], [1.0; 3]);
    }
}
