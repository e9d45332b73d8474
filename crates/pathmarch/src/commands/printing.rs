//! Walls and overhangs of solids that are to be printed, in words.

use pathmarch_render::mesh_file::mesh;
use pathmarch_render::pathmarch_field::mesh::Fineness;
use pathmarch_render::pathmarch_field::{Field, PrintReport};
use pathmarch_render::pathmarch_scene::{LengthUnit, Object, Scene};
use serde_json::{Value, json};
use std::ops::ControlFlow;

/// Cells along the longest side of an object that is checked.
const CELLS: u32 = 128;
/// Walls thinner than this need care with a common nozzle of 0.4 mm, metres.
const THIN_WALL: f64 = 0.8e-3;

/// Walls and overhangs of an object.
pub struct Printability<'a> {
    pub object: &'a str,
    unit: LengthUnit,
    /// Edges of the object, in `unit`.
    size: [f64; 3],
    report: PrintReport,
    /// Size of a cell of the grid, in `unit`.
    cell: f64,
}

impl Printability<'_> {
    /// Checks each finite solid of a scene. An object that cannot be meshed has the reason.
    pub fn of(scene: &Scene) -> Vec<Result<Printability<'_>, String>> {
        let unit = if scene.unit == LengthUnit::In { LengthUnit::In } else { LengthUnit::Mm };
        let objects = scene.objects.iter().filter(|object| is_finite_solid(object));
        objects.map(|object| check(scene, object, unit)).collect()
    }

    /// As in "20 x 10 x 5 mm; thinnest wall 0.8 mm; nothing overhangs by more than 45° (y is up)".
    pub fn in_words(&self) -> String {
        let [x, y, z] = self.size.map(in_figures);
        let thin = self.report.thinnest_wall.is_some_and(|wall| f64::from(wall) * self.unit.metres() < THIN_WALL);
        let advice = if thin { "; a wall is thinner than two lines of a nozzle of 0.4 mm" } else { "" };
        format!(
            "{x} x {y} x {z} {}; {}{advice}",
            self.unit.name(),
            for_printers(&self.report, self.unit.name(), self.cell)
        )
    }

    pub fn json(&self) -> Value {
        json!({"object": self.object, "unit": self.unit.name(), "size": self.size,
            "thinnest_wall": self.report.thinnest_wall, "overhang_share": self.report.overhang_share})
    }
}

fn is_finite_solid(object: &Object) -> bool {
    let field = Field::new(std::slice::from_ref(&object.root));
    field.bounds().is_finite() && !field.leaves().iter().all(|leaf| leaf.shape.info().sheet)
}

fn check<'a>(scene: &Scene, object: &'a Object, unit: LengthUnit) -> Result<Printability<'a>, String> {
    let name = &object.name;
    let mut mesh = mesh(scene, &[object], Fineness::Resolution(CELLS), None, &|_| ControlFlow::Continue(()))
        .map_err(|error| format!("{name}: {error}"))?;
    let scale = scene.unit.metres() / unit.metres();
    mesh.positions.iter_mut().flatten().for_each(|v| *v = (f64::from(*v) * scale) as f32);
    let report = mesh.print_report().ok_or_else(|| format!("{name}: it has no surface"))?;
    let size = extent(&mesh.positions);
    let cell = size.into_iter().fold(0.0, f64::max) / f64::from(CELLS);
    Ok(Printability { object: name, unit, size, report, cell })
}

/// `cell` is the size of a cell of the grid. As in "thinnest wall 0.8 mm; 12 % of the surface overhangs by more than 45° (y is up)".
pub fn for_printers(report: &PrintReport, unit: &str, cell: f64) -> String {
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
    let advice = if is_coarse { "; the wall is thinner than two cells: `export --resolution` measures it" } else { "" };
    format!("{wall}; {share} overhangs by more than 45° (y is up){advice}")
}

/// Edge lengths of the bounding box of points.
pub fn extent(points: &[[f32; 3]]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let along = points.iter().map(|point| f64::from(point[axis]));
        let (min, max) = along.fold((f64::MAX, f64::MIN), |(min, max), v| (min.min(v), max.max(v)));
        (max - min).max(0.0)
    })
}

/// Formats a number with four significant digits.
pub fn in_figures(value: f64) -> String {
    // Rounding may add a digit before the point.
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let places = 3.0 - rounded.abs().max(1e-12).log10().floor();
    format!("{value:.0$}", places.max(0.0) as usize)
}
