//! Scene built in code, without scene text: `cargo run --release -p pathmarch-render --example built_in_code` writes
//! `spiral.png` here, a spiral of blended balls on a floor.

use pathmarch_render::pathmarch_field::{Node, Placement};
use pathmarch_render::pathmarch_scene::parts::{camera, material, operator, shape};
use pathmarch_render::pathmarch_scene::{Light, Object, Scene, SceneParts, Sky};
use pathmarch_render::{Backend, Renderer, Settings, image, tonemap::Display};

/// Indices of the materials.
const CLAY: usize = 0;
const SLATE: usize = 1;

/// Renders the scene and writes the picture.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut balls = Vec::new();
    for index in 0..20 {
        let angle = 0.5 * index as f32;
        let radius = 0.15 + 0.01 * index as f32;
        let at = [(0.1 * angle) * angle.cos(), radius, (0.1 * angle) * angle.sin()];
        let placement = Placement { at: Some(at), ..Placement::default() };
        balls.push(Node { placement, ..shape("sphere", &[radius], CLAY)? });
    }
    let spiral = operator("union", Some(0.1.into()), balls)?;
    let scene = Scene::from_parts(SceneParts {
        cameras: vec![camera([0.0, 2.5, 4.0], [0.0, 0.1, 0.0])],
        sky: Sky::Gradient { zenith: [0.2, 0.4, 0.8], horizon: [0.8, 0.9, 1.0], ground: [0.1; 3] },
        lights: vec![Light::Sun { direction: [1.0, 2.0, 1.0], irradiance: [3.0; 3], angle: 1.0, penumbra: None }],
        materials: vec![
            material("clay", "diffuse", &[("albedo", [0.7, 0.22, 0.08])])?,
            material("slate", "diffuse", &[("albedo", [0.12, 0.2, 0.3])])?,
        ],
        objects: vec![
            Object { name: "spiral".to_owned(), material: CLAY, root: spiral },
            Object { name: "floor".to_owned(), material: SLATE, root: shape("plane", &[], SLATE)? },
        ],
        ..SceneParts::default()
    })?;
    let settings = Settings { size: [160, 90], samples: 16, ..Settings::of(&scene) };
    let film = Renderer::open(Backend::Auto, None)?.render(&scene, &settings)?;
    image::save("spiral.png".as_ref(), &film.mean(), &Display::default(), &image::Provenance::default())?;
    Ok(())
}
