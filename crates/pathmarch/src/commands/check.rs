//! `pathmarch check`: read scenes, report every mistake.

use crate::exit::{DONE, FAILED, Failure, USAGE, print_report};
use pathmarch_render::pathmarch_field::Field;
use pathmarch_render::pathmarch_field::survey::survey;
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
                if arguments.field && !field_is_safe(&scene) {
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
        let finding = survey(&field, POINTS);
        let declared = field.lipschitz();
        if finding.safe_factor >= LEAST_FACTOR {
            println!("  {}: safe; slope up to {:.3}, {declared} is declared", object.name, finding.slope);
            continue;
        }
        safe = false;
        let [x, y, z] = finding.at;
        let shape = field.leaves().get(finding.leaf as usize).map_or("field", |leaf| leaf.shape.info().name);
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
