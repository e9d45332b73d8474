//! `pathmarch check`: read scenes, report every mistake.

use pathmarch_cli::{DONE, FAILED, Failure, USAGE, print_report};
use pathmarch_render::pathmarch_field::graph::Kind;
use pathmarch_render::pathmarch_field::lipschitz_check::check_lipschitz;
use pathmarch_render::pathmarch_field::{Field, Node, Placement};
use pathmarch_render::pathmarch_scene::Scene;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Look for places where a surface is nearer than the field says, object by object
    #[arg(long)]
    field: bool,
}

/// Points that an object is looked at from.
const POINTS: u32 = 20_000;
/// Shorter steps than this share of those declared are a fault.
const LEAST_FACTOR: f32 = 0.99;

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let mut code = DONE;
    for path in &arguments.scenes {
        match Scene::load(path) {
            Ok(scene) => {
                for warning in &scene.warnings {
                    print_report(warning);
                }
                println!(
                    "{}: good: {} shapes in {} objects, {} materials, {} lights, {} cameras",
                    path.display(),
                    scene.field.leaves().len(),
                    scene.objects.len(),
                    scene.materials.len(),
                    scene.lights.len(),
                    scene.cameras.len(),
                );
                if arguments.field && !(field_is_safe(&scene) & declarations_are_true(&scene)) {
                    code = code.max(FAILED);
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

/// Prints what a survey finds of each object; whether all of it is as declared.
fn field_is_safe(scene: &Scene) -> bool {
    let mut safe = true;
    for object in &scene.objects {
        let field = Field::new(std::slice::from_ref(&object.root));
        let finding = check_lipschitz(&field, POINTS);
        let declared = field.lipschitz();
        if finding.safe_factor >= LEAST_FACTOR {
            println!("  {}: safe; slope up to {:.3}, {declared} is declared", object.name, finding.slope);
            continue;
        }
        safe = false;
        let [x, y, z] = finding.at;
        let shape = field.leaves().get(finding.leaf as usize).map_or("field", |leaf| &*leaf.shape.info().name);
        println!(
            "  {}: NOT SAFE: at {x:.3} {y:.3} {z:.3} the surface of `{shape}` is {:.2} times nearer than a step of its \
             distance; steps {:.2} times as long are safe, which is a Lipschitz constant of {:.2} instead of {declared}",
            object.name,
            1.0 / finding.safe_factor,
            finding.safe_factor,
            declared / finding.safe_factor,
        );
    }
    safe
}

/// Slopes above this are more than rounding.
const STEEPEST: f32 = 1.01;

/// Prints which of the scene's own shapes are steeper than they say; whether all are as declared.
fn declarations_are_true(scene: &Scene) -> bool {
    let mut seen: Vec<(&str, &[f32])> = Vec::new();
    let mut safe = true;
    for leaf in scene.field.leaves() {
        let name = &*leaf.shape.info().name;
        let Some(declared) = leaf.shape.declared_lipschitz() else { continue };
        if seen.contains(&(name, &leaf.params)) {
            continue;
        }
        seen.push((name, &leaf.params));
        let params = leaf.params[..leaf.shape.params().len()].to_vec();
        let kind = Kind::Shape { shape: leaf.shape.clone(), params, tag: 0 };
        let field = Field::new(&[Node { kind, placement: Placement::default() }]);
        let slope = check_lipschitz(&field, POINTS).slope;
        let steepest = declared * slope;
        if slope <= STEEPEST {
            println!("  field `{name}`: as declared; slope up to {steepest:.3}, lipschitz {declared}");
            continue;
        }
        safe = false;
        let enough = (steepest * 102.0).ceil() / 100.0;
        println!(
            "  field `{name}`: NOT SAFE: its slope is up to {steepest:.3}, {slope:.2} times the declared lipschitz {declared}; \
             lipschitz {enough} would be safe"
        );
    }
    safe
}
