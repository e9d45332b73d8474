//! Export of a triangle mesh.

use super::{Arguments, interrupted, load_scene, with_progress};
use pathmarch_cli::{DONE, Failure, note};
use pathmarch_render::mesh_file::{MeshFormat, mesh, save};
use pathmarch_render::pathmarch_field::PrintReport;
use pathmarch_render::pathmarch_field::mesh::{Fineness, MeshError};
use pathmarch_render::pathmarch_scene::{Camera, LengthUnit, Scene};
use std::time::Instant;

/// Unit of length of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Unit {
    Mm,
    Cm,
    M,
    #[value(alias = "in")]
    Inch,
}

impl From<Unit> for LengthUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Mm => Self::Mm,
            Unit::Cm => Self::Cm,
            Unit::M => Self::M,
            Unit::Inch => Self::In,
        }
    }
}

/// Unit of the numbers in a file: that of the format; otherwise that of the arguments; otherwise millimetres for printers, and
/// the unit of the scene.
fn unit_of_file(arguments: &Arguments, format: MeshFormat, scene: &Scene) -> Result<LengthUnit, Failure> {
    let asked = arguments.unit.map(LengthUnit::from);
    let Some(only) = format.unit().and_then(LengthUnit::of) else {
        return Ok(asked.unwrap_or(if format == MeshFormat::Stl { LengthUnit::Mm } else { scene.unit }));
    };
    if asked.is_some_and(|unit| unit != only) {
        let (extension, only) = (format.extension(), only.name());
        return Err(Failure::Usage(format!(
            ".{extension} files are in {only}: leave --unit out, or write .stl, .ply or .obj"
        )));
    }
    Ok(only)
}

pub(super) fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let format = MeshFormat::from_path(&arguments.output)
        .map_err(|error| Failure::Usage(format!("{error}; .npy or .npz for distances")))?;
    let scene = load_scene(arguments)?;
    let unit = unit_of_file(arguments, format, &scene)?;
    let objects = arguments.solids(&scene)?;
    let started = Instant::now();
    let made = with_progress(arguments, scene.unit, &objects, |progress| {
        mesh(&scene, &objects, arguments.fineness(), arguments.bounds, progress)
    })?;
    let mut mesh = match made {
        Ok(mesh) => mesh,
        Err(MeshError::Stopped) => return Ok(interrupted()),
        Err(error) => return Err(Failure::Usage(error.to_string())),
    };
    let scale = scene.unit.metres() / unit.metres();
    mesh.positions.iter_mut().flatten().for_each(|v| *v = (f64::from(*v) * scale) as f32);
    let cameras = scene.cameras.iter().map(|camera| scaled(camera, scale as f32)).collect();
    let scene = Scene { cameras, ..scene };
    save(&arguments.output, &mesh, &scene).map_err(Failure::other)?;
    let unit = unit.name();
    // Volumes and areas of parts in millimetres are usual in centimetres.
    let (reported, per) = if unit == "mm" { ("cm", 10.0_f64) } else { (unit, 1.0) };
    note!(
        "wrote {}: {} triangles, {} vertices, {} {unit}, {} {reported}³, {} {reported}² in {:.1} s",
        arguments.output.display(),
        mesh.triangles.len(),
        mesh.positions.len(),
        extent(&mesh.positions).map(in_figures).join(" x "),
        in_figures(mesh.volume() / per.powi(3)),
        in_figures(mesh.area() / per.powi(2)),
        started.elapsed().as_secs_f64(),
    );
    if matches!(format, MeshFormat::Stl | MeshFormat::ThreeMf)
        && let Some(report) = mesh.print_report()
    {
        let cell = match arguments.fineness() {
            Fineness::Cell(cell) => f64::from(cell) * scale,
            Fineness::Resolution(cells) => extent(&mesh.positions).into_iter().fold(0.0, f64::max) / f64::from(cells),
        };
        note!("{}", for_printers(&report, unit, cell));
    }
    Ok(DONE)
}

/// `cell` is the size of a cell of the grid. As in "thinnest wall 0.8 mm; 12 % of the surface overhangs by more than 45° (y is up)".
fn for_printers(report: &PrintReport, unit: &str, cell: f64) -> String {
    let wall = report.thinnest_wall.map_or_else(
        || "no walls found".to_owned(),
        |thickness| format!("thinnest wall {} {unit}", in_figures(f64::from(thickness))),
    );
    let percent = 100.0 * report.overhang_share;
    let share = match () {
        () if percent == 0.0 => "nothing".to_owned(),
        () if percent < 1.0 => "less than 1 % of the surface".to_owned(),
        () => format!("{percent:.0} % of the surface"),
    };
    let is_coarse = report.thinnest_wall.is_some_and(|thickness| f64::from(thickness) < 2.0 * cell);
    let advice = if is_coarse { "; the wall is thinner than two cells: raise --resolution to measure it" } else { "" };
    format!("{wall}; {share} overhangs by more than 45° (y is up){advice}")
}

/// Camera whose lengths are scaled, as files with cameras need it.
fn scaled(camera: &Camera, scale: f32) -> Camera {
    Camera {
        position: camera.position.map(|v| v * scale),
        target: camera.target.map(|v| v * scale),
        lens_radius: camera.lens_radius * scale,
        focus: camera.focus.map(|focus| focus * scale),
        ..camera.clone()
    }
}

/// Edge lengths of the bounding box of points.
fn extent(points: &[[f32; 3]]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let along = points.iter().map(|point| f64::from(point[axis]));
        let (min, max) = along.fold((f64::MAX, f64::MIN), |(min, max), v| (min.min(v), max.max(v)));
        (max - min).max(0.0)
    })
}

/// Formats a number with four significant digits.
fn in_figures(value: f64) -> String {
    // Rounding may add a digit before the point.
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let places = 3.0 - rounded.abs().max(1e-12).log10().floor();
    format!("{value:.0$}", places.max(0.0) as usize)
}
