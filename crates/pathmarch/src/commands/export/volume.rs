//! Export of a volume of signed distances.

use super::{Arguments, interrupted, load_scene, with_progress};
use pathmarch_cli::{DONE, Failure, note};
use pathmarch_render::pathmarch_field::Field;
use pathmarch_render::pathmarch_field::mesh::DistanceGrid;
use pathmarch_render::pathmarch_scene::LengthUnit;
use pathmarch_render::volume_file::{VolumeFileError, VolumeFormat, save};
use std::time::Instant;

pub(super) fn run(arguments: &Arguments, format: VolumeFormat) -> Result<u8, Failure> {
    let scene = load_scene(arguments)?;
    if arguments.unit.is_some_and(|unit| LengthUnit::from(unit) != scene.unit) {
        return Err(Failure::Usage(format!(
            "distances are in the unit of the scene, {}: leave --unit out, or write a mesh",
            scene.unit.name()
        )));
    }
    let objects = arguments.solids(&scene)?;
    let roots: Vec<_> = objects.iter().map(|object| object.root.clone()).collect();
    let field = Field::new(&roots);
    let grid = DistanceGrid::new(&field, arguments.fineness(), arguments.bounds)
        .map_err(|error| Failure::Usage(error.to_string()))?;
    let started = Instant::now();
    match with_progress(arguments, scene.unit, &objects, |progress| save(&arguments.output, format, &grid, progress))? {
        Ok(()) => {
            report(arguments, &grid, scene.unit, started);
            Ok(DONE)
        }
        Err(VolumeFileError::Stopped) => Ok(interrupted()),
        Err(error) => Err(Failure::other(error)),
    }
}

/// Prints where the points are, and the node that shows the volume in its place.
fn report(arguments: &Arguments, grid: &DistanceGrid, unit: LengthUnit, started: Instant) {
    let ([width, height, depth], origin, cell) = (grid.size(), grid.origin(), grid.cell());
    let seconds = started.elapsed().as_secs_f64();
    let [x, y, z] = origin;
    note!(
        "wrote {}: {width} x {height} x {depth} distances in {}; the first at {x:.6} {y:.6} {z:.6}, steps of {cell:.6}; in {seconds:.1} s",
        arguments.output.display(),
        unit.name(),
    );
    let sides = grid.size().map(|side| (side - 1) as f64 * cell);
    let [x, y, z]: [f64; 3] = std::array::from_fn(|axis| origin[axis] + 0.5 * sides[axis]);
    let half = 0.5 * sides.into_iter().fold(0.0, f64::max);
    if VolumeFormat::from_path(&arguments.output) == Some(VolumeFormat::Npy) {
        let name = arguments.output.file_name().unwrap_or_default().to_string_lossy();
        note!("in a scene: mesh \"{name}\" as=\"field\" {{ scale {half:.6}; at {x:.6} {y:.6} {z:.6} }}");
    }
}
