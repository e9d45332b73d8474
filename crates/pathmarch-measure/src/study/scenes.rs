//! Time of each material and scene: Tables 5.2 to 5.7 of the thesis.
//!
//! Paths have up to four surface hits (`bounces 3`), which the thesis calls four bounces.

use super::plot::{Bars, save};
use super::table::{Table, milliseconds};
use super::{Study, example};
use pathmarch_cli::Failure;

/// Picture size of the thesis program's times.
const THESIS_SIZE: [u32; 2] = [1280, 720];
/// Scattering events after the first hit.
const BOUNCES: u32 = 3;

/// A scene of the thesis with its published times.
struct Row {
    kind: &'static str,
    scene: &'static str,
    figure: &'static str,
    /// Milliseconds per frame on the Radeon R9 390, as published.
    published: Option<&'static str>,
    /// Milliseconds of the thesis's program on two cores with Mesa's software OpenGL, 1280x720.
    then: Option<f64>,
}

const fn row(
    kind: &'static str,
    scene: &'static str,
    figure: &'static str,
    published: Option<&'static str>,
    then: Option<f64>,
) -> Row {
    Row { kind, scene, figure, published, then }
}

static ROWS: [Row; 25] = [
    row("diffuse", "diffuse-sphere", "5.5", Some("6-10"), Some(640.0)),
    row("diffuse", "solids", "4.6", None, None),
    row("diffuse", "combinations", "4.7", None, None),
    row("diffuse", "twisted-cube", "2.2", None, None),
    row("diffuse", "soft-shadows", "5.7", None, None),
    row("specular", "metal-room-rough-90", "5.8", Some("26-29"), Some(2561.0)),
    row("specular", "metal-room-rough-50", "5.8", Some("26-29"), Some(2561.0)),
    row("specular", "metal-room-rough-05", "5.8", Some("26-29"), Some(2561.0)),
    row("specular", "three-spheres", "5.1", None, Some(1558.0)),
    row("specular", "specular-prisms", "-", None, None),
    row("refractive", "glass-prism", "5.10", Some("29-37"), Some(1199.0)),
    row("refractive", "refractive-prisms", "-", None, None),
    row("refractive", "caustics", "section 5.3.3", None, None),
    row("refractive", "caustics-fast", "section 5.3.3", None, None),
    row("global light", "open-room-sky", "5.12", Some("14-25"), Some(1773.0)),
    row("global light", "open-room", "5.12", Some("14-25"), Some(1773.0)),
    row("emissive", "metal-light", "-", None, None),
    row("emissive", "green-lamp", "4.13", None, None),
    row("emissive", "emitting-spheres", "5.14", Some("14.3"), Some(694.0)),
    row("fractal", "grey-mandelbulb", "5.16", Some("45.5"), Some(5504.0)),
    row("fractal", "mandelbulb-landscape", "5.4", None, None),
    row("fractal", "inside-mandelbox", "5.4", None, None),
    row("fractal", "cream-julia", "2.11", None, None),
    row("fractal", "cubes", "2.11", None, None),
    row("fractal", "orbit-traps", "5.17", None, None),
];

pub fn study(study: &mut Study) -> Result<String, Failure> {
    let backends = study.backends();
    let mut heads = vec!["kind".to_owned(), "scene".to_owned(), "figure".to_owned()];
    heads.extend(backends.iter().map(|backend| format!("ms/sample, {backend}")));
    heads.extend(
        ["the thesis's program, ms", "that, times the best of ours", "Radeon R9 390, published, ms"].map(str::to_owned),
    );
    let mut table = Table::new(heads.clone());
    heads.insert(0, String::new());
    let mut shown = Table::new(heads);
    let mut bars: Vec<(String, Vec<Option<f64>>)> = backends.iter().map(|name| (name.clone(), Vec::new())).collect();
    bars.push(("the thesis's program, 2 cores, 1280x720".to_owned(), Vec::new()));
    for (index, row) in ROWS.iter().enumerate() {
        study.log(&format!("scenes: {} ({}/{})", row.scene, index + 1, ROWS.len()));
        let scene = example(row.scene)?;
        let times = study.time(&scene, BOUNCES, study.plan.size)?;
        let fastest = Study::fastest(&times);
        let settings = study.picture_settings(&scene);
        study.picture(&format!("scene-{}.jpg", row.scene), &scene, &settings, fastest)?;
        for ((_, values), time) in bars.iter_mut().zip(times.iter().copied().chain([row.then])) {
            values.push(time);
        }
        // Compare only times of the same size.
        let then = row.then.filter(|_| study.plan.size == THESIS_SIZE);
        let ratio = then.zip(times[fastest]).map(|(then, now)| format!("{:.1}", then / now));
        let mut cells = vec![row.kind.to_owned(), row.scene.to_owned(), row.figure.to_owned()];
        cells.extend(times.iter().map(|time| milliseconds(*time)));
        cells.push(milliseconds(row.then));
        cells.push(ratio.unwrap_or("-".to_owned()));
        cells.push(row.published.unwrap_or("-").to_owned());
        table.push(cells.clone());
        cells.insert(0, format!("![{0}](scene-{0}.jpg)", row.scene));
        shown.push(cells);
    }
    let [width, height] = study.plan.size;
    let plot = Bars {
        title: "Time of a sample with four surface hits".to_owned(),
        x: format!("milliseconds for a sample of {width}x{height}"),
        groups: ROWS.iter().map(|row| row.scene.to_owned()).collect(),
        series: bars,
    };
    save(study.directory, "scenes", &plot)?;
    table.save(study.directory, "scenes")?;
    let conditions = study.conditions(&format!(
        "times at {width}x{height}, `bounces {BOUNCES}`, median of {} where there is time; pictures of {} samples with each scene's own bounces",
        study.plan.rounds, study.plan.picture_samples
    ));
    Ok(format!(
        "## Materials and scenes\n\nTables 5.2 to 5.7, by kind of material. Paths have at most four surface hits, which the \
         thesis calls four bounces. Its program was timed at 1280x720 on 2 cores of a 2.5 GHz Xeon with Mesa's software \
         OpenGL, after two edits that only make it faster (a constant scene, an unrolled loop over it; as published the \
         first scene takes 41.8 s), on scenes laid out after its figures; the published times are those of a frame on a \
         Radeon R9 390. Unlike those frames, our samples include light through all hits, and no rays are \
         lost.\n\n{}\n![Times of all scenes](scenes.png)\n\n{conditions}",
        shown.markdown()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_of_the_thesis_has_its_row() {
        let rows: Vec<_> = ROWS.iter().map(|row| row.scene).collect();
        for file in
            pathmarch_gallery::EXAMPLES.iter().map(|example| example.file).filter(|file| file.starts_with("thesis/"))
        {
            let name = file.trim_start_matches("thesis/").trim_end_matches(".kdl");
            assert!(rows.contains(&name), "{name}");
        }
        for row in &ROWS {
            assert!(example(row.scene).is_ok(), "{}", row.scene);
        }
    }
}
