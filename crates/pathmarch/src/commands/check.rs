//! `pathmarch check`: reads scenes and reports every error.

use super::counted;
use super::printing::Printability;
use super::scene_source::load;
use pathmarch_cli::{DONE, FAILED, Failure, USAGE, outln, print_report};
use pathmarch_render::pathmarch_field::graph::{Kind, Leaf};
use pathmarch_render::pathmarch_field::lipschitz_check::check_lipschitz;
use pathmarch_render::pathmarch_field::{Aabb, Field, MeshReport, MeshSurface, Node, Placement};
use pathmarch_render::pathmarch_scene::{Mistake, Scene, SceneError};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    /// Scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Test the distance field of each object for steps that are too long
    #[arg(long)]
    field: bool,
    /// Measure walls and overhangs of each finite object, as a printer needs them
    #[arg(long)]
    print: bool,
    /// Allow the scene to read files outside its folder
    #[arg(long)]
    allow_files: bool,
    /// Print a line of JSON for each scene
    #[arg(long, conflicts_with = "field")]
    json: bool,
}

/// Number of sample points for each object.
const SAMPLE_POINTS: u32 = 20_000;
/// Smallest safe share of a declared step that passes.
const MIN_SAFE_FACTOR: f32 = 0.99;

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let mut code = DONE;
    for path in &arguments.scenes {
        let scene = load(path, arguments.allow_files);
        if arguments.json {
            code = code.max(print_json(path, &scene, arguments.print));
            continue;
        }
        match scene {
            Ok(scene) => {
                for warning in &scene.warnings {
                    print_report(warning);
                }
                outln!("{}: OK: {}{}", path.display(), contents(&scene), size_in_words(&scene));
                print_meshes(&scene);
                if arguments.print {
                    print_walls(&scene);
                }
                if arguments.field {
                    if !(check_objects(&scene) & check_custom_shapes(&scene)) {
                        code = code.max(FAILED);
                    }
                } else {
                    warn_of_custom_shapes(&scene);
                }
            }
            Err(error) => {
                print_report(&error);
                code = USAGE;
            }
        }
    }
    Ok(code)
}

/// Prints what is in a scene, or its mistakes, as JSON; returns the exit code.
fn print_json(path: &Path, scene: &Result<Scene, SceneError>, walls: bool) -> u8 {
    let mistake = |mistake: &Mistake| {
        let before = &mistake.source_code.inner()[..mistake.span.offset()];
        let line = 1 + before.matches('\n').count();
        let column = 1 + before.chars().rev().take_while(|c| *c != '\n').count();
        let file = mistake.source_code.name();
        json!({"file": file, "line": line, "column": column, "code": mistake.code, "message": mistake.message,
            "label": mistake.label, "help": mistake.help})
    };
    let (value, code) = match scene {
        Ok(scene) => {
            let counts = json!({"shapes": scene.field.leaves().len(), "objects": scene.objects.len(),
                "materials": scene.materials.len(), "lights": scene.lights.len(), "cameras": scene.cameras.len()});
            let warnings: Vec<_> = scene.warnings.iter().map(mistake).collect();
            let (unit, size) = (scene.unit.name(), size(scene));
            let mut value =
                json!({"scene": path, "ok": true, "counts": counts, "unit": unit, "size": size, "warnings": warnings});
            if walls {
                let each = |checked: Result<Printability, String>| match checked {
                    Ok(checked) => checked.json(),
                    Err(why) => json!({"error": why}),
                };
                value["print"] = Printability::of(scene).into_iter().map(each).collect();
            }
            (value, DONE)
        }
        Err(error) => {
            let mistakes: Vec<_> = error.mistakes().iter().map(mistake).collect();
            (json!({"scene": path, "ok": false, "error": error.to_string(), "mistakes": mistakes}), USAGE)
        }
    };
    outln!("{value}");
    code
}

/// Prints walls and overhangs of each finite object.
fn print_walls(scene: &Scene) {
    let all = Printability::of(scene);
    if all.is_empty() {
        outln!("  nothing to print: no object is a finite solid");
    }
    for checked in all {
        match checked {
            Ok(checked) => outln!("  {}: {}", checked.object, checked.in_words()),
            Err(why) => outln!("  {why}"),
        }
    }
}

/// Prints what stands between each mesh and a good field: holes, flipped and duplicate triangles, thin walls.
fn print_meshes(scene: &Scene) {
    let mut seen: Vec<(*const MeshSurface, u32)> = Vec::new();
    for mesh in scene.field.leaves().iter().filter_map(|leaf| leaf.shape.mesh()) {
        let voxel = mesh.voxel();
        let key = (Arc::as_ptr(mesh.surface()), voxel.to_bits());
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let object =
            scene.field.leaves().iter().find(|leaf| leaf.shape.mesh().is_some_and(|other| std::ptr::eq(other, mesh)));
        let name = object.map_or("mesh", |leaf| &*scene.objects[leaf.object as usize].name);
        // The scene's reader has checked the triangles.
        if let Ok(report) = MeshReport::new(mesh.surface().mesh(), voxel) {
            outln!("  {name}: {}", report.to_string().replace('\n', "\n    "));
        }
    }
}

/// Contents of a scene, as in "6 shapes in 2 objects, 3 materials, 1 light, 1 camera".
fn contents(scene: &Scene) -> String {
    let emits = |leaf: &&Leaf| scene.materials[leaf.tag as usize].emits();
    let lamps = scene.field.leaves().iter().filter(emits).count();
    let lights = match lamps {
        0 => counted(scene.lights.len(), "light"),
        _ => format!("{} ({} emitting)", counted(scene.lights.len() + lamps, "light"), counted(lamps, "shape")),
    };
    format!(
        "{} in {}, {}, {lights}, {}",
        counted(scene.field.leaves().len(), "shape"),
        counted(scene.objects.len(), "object"),
        counted(scene.materials.len(), "material"),
        counted(scene.cameras.len(), "camera"),
    )
}

/// Edges of the bounds of all finite objects, in the unit of the scene; `None` if there are none.
fn size(scene: &Scene) -> Option<[f32; 3]> {
    let finite = scene.field.object_bounds().iter().filter(|bounds| bounds.is_finite() && !bounds.is_empty());
    let bounds = finite.copied().reduce(Aabb::union)?;
    Some(std::array::from_fn(|axis| bounds.max[axis] - bounds.min[axis]))
}

/// As in "; 20 x 15 x 4 cm".
fn size_in_words(scene: &Scene) -> String {
    let figures = |v: f32| format!("{:.*}", (2.0 - v.max(1e-9).log10().floor()).max(0.0) as usize, v);
    size(scene).map_or_else(String::new, |size| {
        let [x, y, z] = size.map(figures);
        format!("; {x} x {y} x {z} {}", scene.unit.name())
    })
}

/// Sample points for each custom shape, without `--field`.
const FEW_POINTS: u32 = 2000;

/// Warns of custom shapes that are steeper than declared, as far as a short look shows.
fn warn_of_custom_shapes(scene: &Scene) {
    let shapes = custom_shapes(scene);
    for (name, declared, field) in &shapes {
        let slope = check_lipschitz(field, FEW_POINTS).slope;
        if slope > MAX_SLOPE {
            outln!(
                "  warning: field `{name}` is {slope:.2} times as steep as its lipschitz {declared} allows: holes and \
                 errors are likely; `pathmarch check --field` measures it"
            );
        } else {
            outln!("  field `{name}`: {FEW_POINTS} points look safe; `pathmarch check --field` tests it thoroughly");
        }
    }
}

/// Custom shapes with different parameters: name, declared Lipschitz constant, field of the shape alone.
fn custom_shapes(scene: &Scene) -> Vec<(String, f32, Field)> {
    let mut seen: Vec<(&str, &[f32])> = Vec::new();
    let mut found = Vec::new();
    for leaf in scene.field.leaves() {
        let name = &*leaf.shape.info().name;
        let Some(declared) = leaf.shape.declared_lipschitz() else { continue };
        if seen.contains(&(name, &leaf.params)) {
            continue;
        }
        seen.push((name, &leaf.params));
        let params = leaf.params[..leaf.shape.params().len()].to_vec();
        let kind = Kind::Shape { shape: leaf.shape.clone(), params, tag: 0 };
        found.push((name.to_owned(), declared, Field::new(&[Node { kind, placement: Placement::default() }])));
    }
    found
}

/// Prints the result of the Lipschitz check for each object; returns true if all are safe.
fn check_objects(scene: &Scene) -> bool {
    let mut safe = true;
    for object in &scene.objects {
        let field = Field::new(std::slice::from_ref(&object.root));
        let finding = check_lipschitz(&field, SAMPLE_POINTS);
        let declared = field.lipschitz();
        if finding.safe_factor >= MIN_SAFE_FACTOR {
            outln!("  {}: safe; slope up to {:.3}, declared {declared}", object.name, finding.slope);
            continue;
        }
        safe = false;
        let [x, y, z] = finding.at;
        let shape = field.leaves().get(finding.leaf as usize).map_or("field", |leaf| &*leaf.shape.info().name);
        outln!(
            "  {}: NOT SAFE: at {x:.3} {y:.3} {z:.3} the surface of `{shape}` is {:.2} times nearer than the step of its \
             distance; steps {:.2} times as long are safe, which is a Lipschitz constant of {:.2} instead of {declared}",
            object.name,
            1.0 / finding.safe_factor,
            finding.safe_factor,
            declared / finding.safe_factor,
        );
    }
    safe
}

/// Slopes up to this are rounding errors.
const MAX_SLOPE: f32 = 1.01;

/// Prints custom shapes that are steeper than their declared Lipschitz constant; returns true if there are none.
fn check_custom_shapes(scene: &Scene) -> bool {
    let mut safe = true;
    for (name, declared, field) in custom_shapes(scene) {
        let slope = check_lipschitz(&field, SAMPLE_POINTS).slope;
        let steepest = declared * slope;
        if slope <= MAX_SLOPE {
            outln!("  field `{name}`: safe; slope up to {steepest:.3}, declared lipschitz {declared}");
            continue;
        }
        safe = false;
        let enough = (steepest * 102.0).ceil() / 100.0;
        outln!(
            "  field `{name}`: NOT SAFE: its slope is up to {steepest:.3}, {slope:.2} times the declared lipschitz {declared}; \
             lipschitz {enough} would be safe"
        );
    }
    safe
}
