//! `pathmarch check`: read scenes, report every mistake.

use crate::exit::{DONE, Failure, USAGE, print_report};
use pathmarch_render::pathmarch_scene::Scene;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The scene files
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
}

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
            }
            Err(error) => {
                print_report(&error);
                code = USAGE;
            }
        }
    }
    Ok(code)
}
