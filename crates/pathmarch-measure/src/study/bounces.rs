//! Cost and contribution of bounces: Figures 5.1 and 5.2 of the thesis, three rough metal spheres before a wall.
//!
//! The thesis counts surface hits; `bounces` counts scattering events after the first hit.

use super::plot::{Line, Lines, SeriesLabelPosition, save};
use super::table::{Table, milliseconds};
use super::{Study, example};
use pathmarch_cli::Failure;
use pathmarch_render::Settings;

const SCENE: &str = "three-spheres";
/// Surface hits, and milliseconds of the thesis's program on two cores at 1280x720.
const HITS: [(u32, f64); 6] = [(1, 437.0), (2, 941.0), (4, 1558.0), (8, 2281.0), (16, 3422.0), (32, 5375.0)];
/// Picture size of those times.
const THESIS_SIZE: [u32; 2] = [1280, 720];

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let scene = example(SCENE)?;
    let backends = study.backends();
    let mut heads = vec!["hits".to_owned(), "bounces".to_owned()];
    heads.extend(backends.iter().map(|backend| format!("ms/sample, {backend}")));
    heads.extend(["ms/sample, the thesis's program".to_owned(), "light".to_owned()]);
    let mut table = Table::new(heads);
    let mut lines: Vec<_> =
        backends.iter().map(|name| Line { name: name.clone(), points: Vec::new(), is_guide: false }).collect();
    let mut rows = Vec::new();
    for (hits, then) in HITS {
        study.log(&format!("bounces: {hits} hits"));
        let bounces = hits - 1;
        let times = study.time(&scene, bounces, study.plan.size)?;
        for (line, time) in lines.iter_mut().zip(&times) {
            line.points.extend(time.map(|time| (f64::from(hits), time)));
        }
        let settings = Settings { bounces, ..study.picture_settings(&scene) };
        let name = format!("bounces-{hits}.jpg");
        let picture = study.picture(&name, &scene, &settings, Study::fastest(&times))?;
        rows.push((hits, then, times, picture.mean_colour().iter().sum::<f64>()));
    }
    let all_light = rows.last().map_or(1.0, |row| row.3);
    for (hits, then, times, light) in &rows {
        let mut row = vec![hits.to_string(), (hits - 1).to_string()];
        row.extend(times.iter().map(|time| milliseconds(*time)));
        row.extend([milliseconds(Some(*then)), format!("{:.1} %", 100.0 * light / all_light)]);
        table.push(row);
    }
    let then = HITS.map(|(hits, then)| (f64::from(hits), then)).to_vec();
    lines.push(Line { name: "the thesis's program, 2 cores, 1280x720".to_owned(), points: then, is_guide: true });
    let [width, height] = study.plan.size;
    let plot = Lines {
        title: "Time of a sample by surface hits, three spheres".to_owned(),
        x: "surface hits of a path at most".to_owned(),
        y: format!("milliseconds for a sample of {width}x{height}"),
        legend: SeriesLabelPosition::UpperLeft,
        lines,
    };
    save(study.directory, "bounces", &plot)?;
    table.save(study.directory, "bounces")?;
    let mut pictures =
        Table::new(HITS.map(|(hits, _)| if hits == 1 { "1 hit".to_owned() } else { format!("{hits} hits") }));
    pictures.push(HITS.map(|(hits, _)| format!("![{hits} hits](bounces-{hits}.jpg)")));
    let size_note = if study.plan.size == THESIS_SIZE { "" } else { " The thesis's program was timed at 1280x720." };
    let conditions = study.conditions(&format!(
        "times at {width}x{height}, median of {} where there is time; pictures of {} samples",
        study.plan.rounds, study.plan.picture_samples
    ));
    Ok(format!(
        "## Bounces\n\nFigures 5.1 and 5.2: `{SCENE}`. *Light* is the mean radiance of the picture, of that with 32 hits. \
         Paths beyond the fifth hit go on with three times the probability of what they still carry, which is why further hits cost \
         less and less; the thesis's program follows every path to its end.{size_note}\n\n{}\n{}\n\
         ![Time by hits](bounces.png)\n\n{conditions}",
        pictures.markdown(),
        table.markdown()
    ))
}
