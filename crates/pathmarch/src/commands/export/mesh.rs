//! Export of a triangle mesh.

use super::{Arguments, interrupted, load_scene, with_progress};
use pathmarch_cli::{DONE, Failure, note};
use pathmarch_render::mesh_file::{MeshFormat, mesh, save};
use pathmarch_render::pathmarch_field::mesh::MeshError;
use std::time::Instant;

/// Unit of length of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Unit {
    Mm,
    Cm,
    M,
    Inch,
}

impl Unit {
    /// Units in a metre, and name of the unit.
    fn per_metre(self) -> (f64, &'static str) {
        match self {
            Self::Mm => (1000.0, "mm"),
            Self::Cm => (100.0, "cm"),
            Self::M => (1.0, "m"),
            Self::Inch => (1.0 / 0.0254, "in"),
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let format = MeshFormat::from_path(&arguments.output)
        .map_err(|error| Failure::Usage(format!("{error}; .npy or .npz for distances")))?;
    let usual = format.unit().unwrap_or(if format == MeshFormat::Stl { "mm" } else { "m" });
    let unit = arguments.unit.unwrap_or(if usual == "mm" { Unit::Mm } else { Unit::M });
    if let Some(only) = format.unit().filter(|only| *only != unit.per_metre().1) {
        let extension = format.extension();
        return Err(Failure::Usage(format!(
            ".{extension} files are in {only}: leave --unit out, or write .stl, .ply or .obj"
        )));
    }
    let scene = load_scene(arguments)?;
    let objects = arguments.solids(&scene)?;
    let started = Instant::now();
    let made = with_progress(arguments, &objects, |progress| {
        mesh(&scene, &objects, arguments.fineness(), arguments.bounds, progress)
    })?;
    let mut mesh = match made {
        Ok(mesh) => mesh,
        Err(MeshError::Stopped) => return Ok(interrupted()),
        Err(error) => return Err(Failure::Usage(error.to_string())),
    };
    let (scale, unit) = unit.per_metre();
    mesh.positions.iter_mut().flatten().for_each(|v| *v = (f64::from(*v) * scale) as f32);
    save(&arguments.output, &mesh, &scene).map_err(Failure::other)?;
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
    Ok(DONE)
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
    let places = 3.0 - value.abs().max(1e-12).log10().floor();
    format!("{value:.0$}", places.max(0.0) as usize)
}
