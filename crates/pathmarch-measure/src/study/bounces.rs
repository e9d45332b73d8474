//! Cost and worth of bounces on three scenes: Figures 5.1 and 5.2 of the thesis.
//!
//! The thesis counts surface hits; `bounces` counts scattering events after the first hit.

use super::picture_grid::{Panel, save as save_grid};
use super::plot::{Line, Lines, SeriesLabelPosition, save};
use super::table::{Table, milliseconds};
use super::{Study, example};
use crate::measure::{Budget, ReferenceStore, render_for};
use crate::peers::{ThesisFrame, ThesisProgram};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;
use pathmarch_render::tonemap::Display;

/// Scenes, that of the figure first.
const SCENES: [&str; 3] = ["three-spheres", "open-room", "emitting-spheres"];
/// Letter of the first scene in the thesis's program.
const PROGRAM_SCENE: &str = "g";
const HITS: [u32; 6] = [1, 2, 4, 8, 16, 32];
/// Milliseconds of a frame at 24 frames a second, the thesis's limit of real time.
const REAL_TIME: f64 = 41.6;

/// Milliseconds of the thesis's program for each number of hits; empty without it.
fn program_times(study: &Study) -> Result<Vec<f64>, Failure> {
    let program = ThesisProgram::find(study.python.clone(), study.thesis_shader.as_deref());
    let Some(program) = program else { return Ok(Vec::new()) };
    study.log("bounces: the thesis's program");
    let camera = example(SCENES[0])?.cameras[0].clone();
    let frame = |hits| ThesisFrame { scene: PROGRAM_SCENE, camera: camera.clone(), hits };
    Ok(program.times(&HITS.map(frame), study.plan.size, study.plan.rounds)?.0)
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let backends = study.backends();
    let mut heads: Vec<String> = ["scene", "hits", "bounces"].map(str::to_owned).to_vec();
    heads.extend(backends.iter().map(|backend| format!("ms/sample, {backend}")));
    heads.extend(["ms, the thesis's program", "light", "relMSE in equal time"].map(str::to_owned));
    let mut table = Table::new(heads);
    let program = program_times(study)?;
    let (mut lines, mut optima, mut panels) = (Vec::new(), Vec::new(), Vec::new());
    let directory = tempfile::tempdir().map_err(Failure::other)?;
    let store_path = study.references.clone().unwrap_or_else(|| directory.path().to_owned());
    let store = ReferenceStore::new(store_path, study.plan.reference_seconds)?;
    for name in SCENES {
        let scene = example(name)?;
        let whole = Settings {
            size: study.plan.error_size,
            bounces: HITS[HITS.len() - 1] - 1,
            clamp: None,
            ..Settings::of(&scene)
        };
        let backend = Study::fastest(&study.time_view(&scene, &whole, whole.bounces)?);
        study.log(&format!("bounces: {name}, reference"));
        let reference =
            store.get(&format!("{name}-bounces"), &scene, &whole, &study.renderers[backend], &study.interrupt)?;
        let all_light = reference.picture.mean_colour().iter().sum::<f64>();
        let display = Display { tonemap: scene.render.tonemap, exposure_stops: scene.cameras[0].exposure };
        let mut of_scene: Vec<Line> = backends
            .iter()
            .map(|backend| Line { name: format!("{name}, {backend}"), points: Vec::new(), is_guide: false })
            .collect();
        let mut best: Option<(u32, f64)> = None;
        for (index, hits) in HITS.into_iter().enumerate() {
            study.log(&format!("bounces: {name}, {hits} hits"));
            let bounces = hits - 1;
            let full = Settings { size: study.plan.size, ..whole.clone() };
            let times = study.time_view(&scene, &full, bounces)?;
            for (line, time) in of_scene.iter_mut().zip(&times) {
                line.points.extend(time.map(|time| (f64::from(hits), time)));
            }
            let settings = Settings { bounces, ..whole.clone() };
            let renderer = &study.renderers[backend];
            let budget = Budget::Seconds(study.plan.bounce_seconds);
            let taken = render_for(renderer, &scene, &settings, budget, &study.interrupt)?;
            let error = reference.error_of(&taken.picture)?;
            if best.is_none_or(|(_, least)| error < least) {
                best = Some((hits, error));
            }
            if name == SCENES[0] {
                let settings = Settings { size: study.plan.size, clamp: scene.render.clamp, ..settings };
                let picture = study.render(&scene, &settings, None)?;
                panels.push(Panel::of(&picture, &display).reduced(3));
            }
            let light = taken.picture.mean_colour().iter().sum::<f64>() / all_light;
            let mut row = vec![name.to_owned(), hits.to_string(), bounces.to_string()];
            row.extend(times.iter().map(|time| milliseconds(*time)));
            let program = program.get(index).copied().filter(|_| name == SCENES[0]);
            row.extend([milliseconds(program), format!("{:.1} %", 100.0 * light), format!("{error:.2e}")]);
            table.push(row);
        }
        lines.extend(of_scene);
        optima.extend(best.map(|(hits, _)| format!("{hits} in `{name}`")));
    }
    let points = |times: &[f64]| HITS.iter().zip(times).map(|(hits, time)| (f64::from(*hits), *time)).collect();
    if !program.is_empty() {
        let name = format!("{}, the thesis's program", SCENES[0]);
        lines.push(Line { name, points: points(&program), is_guide: true });
    }
    let name = format!("24 frames a second, {REAL_TIME} ms");
    lines.push(Line { name, points: points(&[REAL_TIME; HITS.len()]), is_guide: true });
    let [width, height] = study.plan.size;
    let plot = Lines {
        title: "Time of a sample by surface hits".to_owned(),
        x: "surface hits of a path at most".to_owned(),
        y: format!("milliseconds for a sample of {width}x{height}"),
        legend: SeriesLabelPosition::UpperLeft,
        lines,
    };
    save(study.directory, "bounces", &plot)?;
    table.save(study.directory, "bounces")?;
    save_grid(&study.directory.join("bounces.jpg"), &panels, 3)?;
    let [error_width, error_height] = study.plan.error_size;
    let conditions = study.conditions(&format!(
        "times at {width}x{height}, median of {}; errors at {error_width}x{error_height} after {} s against 32 hits; \
         pictures of {} s",
        study.plan.rounds, study.plan.bounce_seconds, study.plan.picture_seconds
    ));
    Ok(format!(
        "## Bounces\n\nFigures 5.1 and 5.2 (pages 58 and 59). The thesis concludes that 4 to 6 bounces are best, its hits, and \
         takes 4. Here the question has a number: the error that remains after an equal time, of the light that is left out \
         and of the noise. It is least with {}. *Light* is the mean radiance, of that with 32 hits. Paths beyond the fifth hit \
         go on with three times the probability of what they still carry, which is why further hits cost less and less; the \
         thesis's program follows every path to its end.\n\n{}\n![1, 2, 4, 8, 16 and 32 hits](bounces.jpg)\n\nFigure 5.1: 1, 2, \
         4, 8, 16 and 32 hits.\n\n![Time by hits](bounces.png)\n\n{conditions}",
        optima.join(", "),
        table.markdown()
    ))
}
