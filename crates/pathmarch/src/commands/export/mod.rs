//! `pathmarch export`: exports objects of a scene as a triangle mesh, or as a volume of distances.

mod mesh;
mod volume;

use super::scene_source::load;
use super::{listed, progress_bar};
use mesh::Unit;
use pathmarch_cli::{Failure, INTERRUPTED, catch_interrupts, check_output, note, print_report, value_parsers};
use pathmarch_render::pathmarch_field::mesh::Fineness;
use pathmarch_render::pathmarch_field::{Aabb, Field};
use pathmarch_render::pathmarch_scene::{LengthUnit, Object, Scene};
use pathmarch_render::volume_file::VolumeFormat;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene file
    scene: PathBuf,
    /// File to write: a mesh (.stl, .ply, .obj, .glb, .3mf, .usda, .usdz) or a volume of distances (.npy, .npz)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Object to export; can be repeated [default: all solids, as one mesh]
    #[arg(long = "object", value_name = "NAME")]
    objects: Vec<String>,
    /// Allow the scene to read files outside its folder
    #[arg(long)]
    allow_files: bool,
    /// Number of cells along the longest side
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = value_parsers::whole((1, 100_000)), allow_hyphen_values = true)]
    resolution: u32,
    /// Size of a cell, in the unit of the scene, instead of a resolution
    #[arg(long, value_name = "LENGTH", value_parser = parse_cell, allow_hyphen_values = true, conflicts_with = "resolution")]
    cell: Option<f32>,
    /// Unit of the numbers in the file [default: mm for .stl and .3mf, as printers expect; m for .glb and USD; the unit of the scene for others]
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,
    /// Clip to a box, given by two corners in the unit of the scene: "-1 0 -1 1 2 1"
    #[arg(long, value_name = "X Y Z X Y Z", value_parser = parse_bounds, allow_hyphen_values = true)]
    bounds: Option<Aabb>,
    /// Leave out infinite objects, instead of refusing them
    #[arg(long)]
    skip_infinite: bool,
}

fn parse_cell(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|cell: &f32| *cell > 0.0 && cell.is_finite())
        .ok_or("expected a length above 0, such as 0.01".to_owned())
}

fn parse_bounds(text: &str) -> Result<Aabb, String> {
    let words = text.split([' ', ',']).filter(|word| !word.is_empty());
    let numbers: Vec<f32> = words.map_while(|word| word.parse().ok()).collect();
    match numbers[..] {
        [a, b, c, d, e, f] if numbers.iter().all(|v| v.is_finite()) && a < d && b < e && c < f => {
            Ok(Aabb { min: [a, b, c], max: [d, e, f] })
        }
        _ => Err("expected the smaller corner and the larger one, such as \"-1 0 -1 1 2 1\"".to_owned()),
    }
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    match VolumeFormat::from_path(&arguments.output) {
        Some(format) => volume::run(arguments, format),
        None => mesh::run(arguments),
    }
}

/// Loads the scene and prints its warnings.
fn load_scene(arguments: &Arguments) -> Result<Scene, Failure> {
    check_output(&arguments.output)?;
    let scene = load(&arguments.scene, arguments.allow_files)?;
    for warning in &scene.warnings {
        print_report(warning);
    }
    Ok(scene)
}

/// Says what is exported, and runs `work` with a progress bar; Ctrl-C stops it.
fn with_progress<T>(
    arguments: &Arguments,
    unit: LengthUnit,
    objects: &[&Object],
    work: impl FnOnce(&(dyn Fn(f32) -> ControlFlow<()> + Sync)) -> T,
) -> Result<T, Failure> {
    let interrupted = catch_interrupts()?;
    note!(
        "{}: {}, {}",
        arguments.scene.display(),
        listed(objects.iter().map(|object| object.name.as_str())),
        match arguments.fineness() {
            Fineness::Resolution(cells) => format!("{cells} cells along the longest side"),
            Fineness::Cell(cell) => format!("cells of {cell} {}", unit.name()),
        }
    );
    let bar = progress_bar(1000);
    let made = work(&|share| {
        bar.set_position((share * 1000.0) as u64);
        bar.set_message(format!("{:.0} %", share * 100.0));
        if interrupted.load(Ordering::SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    Ok(made)
}

/// Exit code of an export that Ctrl-C stopped.
fn interrupted() -> u8 {
    note!("interrupted: nothing was written");
    INTERRUPTED
}

impl Arguments {
    fn fineness(&self) -> Fineness {
        self.cell.map_or(Fineness::Resolution(self.resolution), Fineness::Cell)
    }

    /// Objects to export; each one has an inside and finite bounds.
    fn solids<'a>(&self, scene: &'a Scene) -> Result<Vec<&'a Object>, Failure> {
        let is_sheet = |object: &&Object| {
            Field::new(std::slice::from_ref(&object.root)).leaves().iter().all(|leaf| leaf.shape.info().sheet)
        };
        let names = |objects: &[&Object]| listed(objects.iter().map(|object| object.name.as_str()));
        let (sheets, solids) = if self.objects.is_empty() {
            scene.objects.iter().partition(is_sheet)
        } else {
            let found = self.objects.iter().map(|name| object(scene, name)).collect::<Result<Vec<_>, _>>()?;
            found.into_iter().partition::<Vec<_>, _>(is_sheet)
        };
        if solids.is_empty() || !sheets.is_empty() && !self.objects.is_empty() {
            return Err(Failure::Usage(if sheets.is_empty() {
                "the scene has no objects".to_owned()
            } else {
                format!("{}: sheets without thickness have no inside; use a thin box instead", names(&sheets))
            }));
        }
        if !sheets.is_empty() {
            note!("note: left out sheets without thickness: {}", names(&sheets));
        }
        let is_endless = |object: &&Object| !Field::new(std::slice::from_ref(&object.root)).bounds().is_finite();
        let (endless, finite): (Vec<_>, Vec<_>) = solids.iter().copied().partition(is_endless);
        if endless.is_empty() || self.bounds.is_some() {
            return Ok(solids);
        }
        if self.skip_infinite && !finite.is_empty() {
            note!("note: left out infinite objects: {}", names(&endless));
            return Ok(finite);
        }
        Err(Failure::Usage(format!(
            "infinite: {}; select objects with --object, or clip them with --bounds",
            names(&endless)
        )))
    }
}

/// Finds an object by name.
fn object<'a>(scene: &'a Scene, name: &str) -> Result<&'a Object, Failure> {
    scene.objects.iter().find(|object| object.name == name).ok_or_else(|| {
        let known = scene.objects.iter().map(|object| object.name.as_str());
        let nearest = known.clone().min_by_key(|known| strsim::damerau_levenshtein(known, name));
        let hint = nearest.map(|nearest| format!("; did you mean \"{nearest}\"? It has {}", listed(known)));
        Failure::Usage(format!("the scene has no object \"{name}\"{}", hint.unwrap_or_default()))
    })
}
