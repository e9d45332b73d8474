//! Export of a triangle mesh.

use super::{Arguments, interrupted, load_scene, with_progress};
use crate::commands::printing::{extent, for_printers, in_figures};
use pathmarch_cli::{DONE, Failure, note};
use pathmarch_render::mesh_file::{MeshFormat, mesh, save};
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
