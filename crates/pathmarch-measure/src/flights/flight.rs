//! Flights: built-in ones, and scenes of files.

use crate::bench;
use pathmarch_cli::Failure;
use pathmarch_render::pathmarch_scene::{Animation, Camera, Scene};
use std::path::{Path, PathBuf};

/// Frames of a flight.
pub(super) const FRAMES: u32 = 48;
/// Frames in motion; the others show one second at rest.
pub(super) const MOVING_FRAMES: u32 = 24;
pub(super) const FPS: f32 = 24.0;
/// Degrees by which the camera turns in the scene of a file without motion of its own.
const TURN: f32 = 20.0;

/// Sequence to reconstruct.
#[derive(Clone)]
pub(super) struct Flight {
    pub(super) name: String,
    /// Built-in scene, or the text of a scene.
    scene: Source,
    /// Degrees by which the camera turns about its target in the whole flight.
    turn: f32,
}

#[derive(Clone)]
enum Source {
    BuiltIn(&'static str),
    Text(&'static str),
    File(PathBuf),
}

/// Ball that rolls over a checker.
const MOVING_OBJECT: &str = r#"pathmarch 1
camera { position 0 1.6 4; target 0 0.4 0 }
render { bounces 3 }
sky "gradient" { zenith 0.3 0.45 0.7; horizon 0.8 0.85 0.9 }
sun { direction 1 2 1; irradiance 2; angle 3 }
material "checker" { diffuse { checker size=0.4 { colour 0.1; colour 0.8 } } }
material "red" { diffuse 0.7 0.15 0.1 }
object "ground" material="checker" { plane }
object "ball" material="red" { sphere 0.5 { at "1.6*min(t, 1.5) - 1.2" 0.5 0 } }
object "block" material="red" { box 0.5 1.2 0.5 { at 0 0.6 -1 } }
"#;

/// Room whose lamp dims to a twentieth after half a second.
const SWITCHED_LIGHT: &str = r#"pathmarch 1
camera { position 0 1 5.15; target 0 0.99 0; fov 27.2 }
render { bounces 4 }
param power "8 - 7.6*step(0.5, t)"
material "white" { diffuse 0.74 }
material "red" { diffuse 0.62 0.06 0.04 }
material "lamp" { emit power }
object "floor" material="white" { rect 3.4 2.4 }
object "ceiling" material="white" { rect 3.4 2.4 { normal 0 -1 0; at 0 2 0 } }
object "back wall" material="white" { rect 3.4 2 { rotate 90 0 0; at 0 1 -1.2 } }
object "left wall" material="red" { box 0.1 2 2.4 { at -1.75 1 0 } }
object "right wall" material="white" { box 0.1 2 2.4 { at 1.75 1 0 } }
object "tall box" material="white" { box 0.62 1.25 0.62 { rotate 0 43 0; at -0.62 0.625 -0.38 } }
object "lamp" material="lamp" { rect 1.3 0.9 { normal 0 -1 0; at 0 1.995 -0.1 } }
"#;

/// Drops that melt together, and a bar that twists.
const DEFORMING_OBJECTS: &str = r#"pathmarch 1
camera { position 0 1.6 4; target 0 0.5 0 }
render { bounces 3 }
sky "gradient" { zenith 0.3 0.45 0.7; horizon 0.8 0.85 0.9 }
sun { direction 1 2 1; irradiance 2; angle 3 }
material "checker" { diffuse { checker size=0.4 { colour 0.1; colour 0.8 } } }
material "red" { diffuse 0.7 0.15 0.1 }
material "blue" { diffuse 0.15 0.3 0.7 }
object "ground" material="checker" { plane }
object "drops" material="red" {
  union smooth="0.1 + 0.4*min(t, 1)" {
    sphere "0.5 + 0.1*min(t, 1)" { at "-0.9 + 0.4*min(t, 1)" 0.6 0 }
    sphere 0.45 { at "0.6 - 0.4*min(t, 1)" 0.6 0 }
  }
}
object "bar" material="blue" { twist "0.2*min(t, 1)" { box 0.35 1.6 0.35; at 1.2 0.8 -0.8 } }
"#;

/// Built-in flights: name, scene, degrees by which the camera turns.
const BUILT_IN: [(&str, Source, f32); 7] = [
    ("camera", Source::BuiltIn("cornell"), 12.0),
    ("object", Source::Text(MOVING_OBJECT), 0.0),
    ("melt", Source::Text(DEFORMING_OBJECTS), 0.0),
    ("light", Source::Text(SWITCHED_LIGHT), 0.0),
    ("glass", Source::BuiltIn("glass-still-life"), 20.0),
    ("fractal", Source::BuiltIn("mandelbulb"), 30.0),
    ("lights", Source::BuiltIn("many-lights"), 20.0),
];

/// All built-in flights.
pub(super) fn built_in() -> Vec<Flight> {
    let flight = |(name, scene, turn): (&str, Source, f32)| Flight { name: name.to_owned(), scene, turn };
    BUILT_IN.into_iter().map(flight).collect()
}

/// Built-in flight of this name, or that of a scene file.
pub(super) fn parse(text: &str) -> Result<Flight, String> {
    if let Some(flight) = built_in().into_iter().find(|flight| flight.name == text) {
        return Ok(flight);
    }
    let path = Path::new(text);
    match path.file_stem().filter(|_| path.is_file()) {
        Some(stem) => {
            let name = stem.to_string_lossy().into_owned();
            Ok(Flight { name, scene: Source::File(path.to_owned()), turn: TURN })
        }
        None => Err(format!("expected a scene file or one of {}", BUILT_IN.map(|(name, ..)| name).join(", "))),
    }
}

impl Flight {
    /// Scene of every moment.
    pub(super) fn animation(&self) -> Result<Animation, Failure> {
        let text = match &self.scene {
            Source::File(path) => return Ok(Animation::load(path)?),
            Source::Text(text) => (*text).to_owned(),
            Source::BuiltIn(name) => {
                bench::built_in(name).ok_or_else(|| Failure::Other(format!("there is no example {name}")))?
            }
        };
        Ok(Animation::new(&self.name, text))
    }

    /// Camera of a frame: turned about the vertical through its target. That of a moving scene in a file moves as the file
    /// says.
    pub(super) fn camera(&self, scene: &Scene, frame: u32) -> Camera {
        let mut camera = scene.cameras[0].clone();
        let turn = if scene.animated && matches!(self.scene, Source::File(_)) { 0.0 } else { self.turn };
        let angle = (turn * frame.min(MOVING_FRAMES) as f32 / MOVING_FRAMES as f32).to_radians();
        let (sine, cosine) = angle.sin_cos();
        let [x, y, z] = std::array::from_fn(|k| camera.position[k] - camera.target[k]);
        let turned = [x * cosine + z * sine, y, z * cosine - x * sine];
        camera.position = std::array::from_fn(|k| camera.target[k] + turned[k]);
        camera
    }
}
