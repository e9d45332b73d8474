//! Tables 5.2 to 5.7 of the thesis, row for row: time of a sample with four surface hits, by the thesis's program and by
//! ours, with closed-form intersections and with every shape sphere-traced.

use super::Study;
use super::plot::{Bars, save};
use super::rows::Row;
use super::table::{Table, milliseconds};
use crate::peers::{ThesisFrame, ThesisProgram};
use pathmarch_cli::Failure;
use pathmarch_render::pathmarch_field::{Field, Node};
use pathmarch_render::pathmarch_scene::Scene;

/// Scattering events after the first hit; the thesis counts four bounces, which are four surface hits.
pub const BOUNCES: u32 = 3;

/// Heads of the ratios of the program's time to ours.
const RATIOS: [&str; 2] = ["program / best of ours", "program / best, all marched"];

/// Scene whose shapes are all sphere-traced.
fn marched(scene: &Scene) -> Scene {
    let roots: Vec<Node> = scene.objects.iter().map(|object| object.root.clone()).collect();
    Scene { field: Field::all_sphere_traced(&roots), ..scene.clone() }
}

/// Milliseconds of the thesis's program for each row; empty without the program.
fn program_times(study: &Study, rows: &[&Row]) -> Result<(Vec<Option<f64>>, String), Failure> {
    let program = ThesisProgram::find(study.python.clone(), study.thesis_shader.as_deref());
    let Some(program) = program else { return Ok((vec![None; rows.len()], String::new())) };
    study.log("tables: the thesis's program");
    let mut frames = Vec::new();
    for row in rows {
        let (scene, settings) = row.load(study.plan.size)?;
        let camera = settings.camera_of(&scene).clone();
        frames.extend(row.program.map(|scene| ThesisFrame { scene, camera, hits: BOUNCES + 1 }));
    }
    let (times, device) = program.times(&frames, study.plan.size, study.plan.rounds)?;
    let mut times = times.into_iter();
    Ok((rows.iter().map(|row| row.program.and_then(|_| times.next())).collect(), device))
}

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let rows: Vec<&Row> = study.rows().collect();
    let (program, device) = program_times(study, &rows)?;
    let backends = study.backends();
    let mut heads: Vec<String> =
        ["table", "row", "published, R9 390", "the thesis's program"].map(str::to_owned).to_vec();
    heads.extend(backends.iter().map(|backend| format!("pathmarch, {backend}")));
    heads.extend(backends.iter().map(|backend| format!("all marched, {backend}")));
    heads.extend(RATIOS.map(str::to_owned));
    let mut table = Table::new(heads);
    let best = |times: &[Option<f64>]| times.iter().flatten().copied().min_by(f64::total_cmp);
    let mut bars: Vec<(String, Vec<Option<f64>>)> = backends.iter().map(|name| (name.clone(), Vec::new())).collect();
    bars.push(("the thesis's program".to_owned(), Vec::new()));
    for (row, program) in rows.iter().zip(program) {
        study.log(&format!("tables: {}", row.label()));
        let (scene, settings) = row.load(study.plan.size)?;
        let marched = marched(&scene);
        let ours = study.time_view(&scene, &settings, BOUNCES)?;
        let all_marched = study.time_view(&marched, &settings, BOUNCES)?;
        for ((_, values), time) in bars.iter_mut().zip(ours.iter().copied().chain([program])) {
            values.push(time);
        }
        let ratio = |times: &[Option<f64>]| {
            program.zip(best(times)).map_or("-".to_owned(), |(program, ours)| format!("{:.1}", program / ours))
        };
        let mut cells = vec![row.table.to_owned(), row.title.to_owned(), format!("{}", row.published)];
        cells.push(milliseconds(program));
        cells.extend(ours.iter().chain(&all_marched).map(|time| milliseconds(*time)));
        cells.extend([ratio(&ours), ratio(&all_marched)]);
        table.push(cells);
    }
    table.save(study.directory, "tables")?;
    let lost = RATIOS.map(|head| table.losses(head, 1));
    let losses: String = lost
        .into_iter()
        .zip(["The thesis's program is faster for one frame", "With all marched it is faster"])
        .filter_map(|(rows, begin)| Some(format!("**{begin}** in: {}.\n\n", rows?)))
        .collect();
    let [width, height] = study.plan.size;
    let plot = Bars {
        title: "Time of a sample with four surface hits".to_owned(),
        x: format!("milliseconds for a sample of {width}x{height}"),
        groups: rows.iter().map(|row| row.label()).collect(),
        series: bars,
    };
    save(study.directory, "tables", &plot)?;
    let of_program = match &*device {
        "" => "the thesis's program was not measured: give `--thesis-shader`".to_owned(),
        device => format!("the thesis's program on OpenGL ({device})"),
    };
    let conditions = study.conditions(&format!(
        "milliseconds a sample at {width}x{height}, `bounces {BOUNCES}`, median of {}; {of_program}",
        study.plan.rounds
    ));
    Ok(format!(
        "## Tables 5.2 to 5.7\n\n{losses}Milliseconds for a frame of one sample, at most four surface hits, which the thesis calls four \
         bounces. The first column of times is the thesis's own, on its Radeon R9 390; all others are of this machine and \
         this run. The scenes of the thesis are not published; both programs render those laid out after its figures, the \
         thesis's program with two edits that only make it faster (a constant scene, an unrolled loop over it). Convex solids \
         and their sharp combinations are met in closed form here, so that hardly a solid of these tables is marched; \
         *all marched* has every shape sphere-traced, as the thesis does. What a sample of ours holds and a frame of the \
         program does not: light after the first hit, and rays that are not lost ([features](#features)). The program has \
         no ambient light alone.\n\n{}\n![Times of all rows](tables.png)\n\n{conditions}",
        table.markdown()
    ))
}
