//! Picture in ten lines: `cargo run --release -p pathmarch-render --example ten_lines` writes `ball.png` here.

use pathmarch_render::{Backend, Renderer, Settings, image, pathmarch_scene::Scene, tonemap::Display};

const SCENE: &str = "pathmarch 1
camera { position 0 1 4; target 0 0 0 }
sky 0.4 0.6 1
sun { direction 1 2 1; irradiance 3 }
object \"ball\" { sphere 1 }";

/// Renders the scene and writes the picture.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::parse("ball.kdl", SCENE)?;
    let settings = Settings { size: [160, 90], samples: 16, ..Settings::of(&scene) };
    let film = Renderer::open(Backend::Auto, None)?.render(&scene, &settings)?;
    image::save("ball.png".as_ref(), &film.mean(), &Display::default(), &image::Provenance::default())?;
    Ok(())
}
