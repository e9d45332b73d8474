//! The program of the thesis: its published fragment shader, in an OpenGL context without a window.

use super::{Python, parsed};
use pathmarch_cli::Failure;
use pathmarch_render::pathmarch_scene::Camera;
use std::path::{Path, PathBuf};

/// The published shader, `shaders/pathTracer.fs` of Arukiap/Path-marcher.
pub struct ThesisProgram {
    python: Python,
    shader: PathBuf,
}

/// Frame of the program.
#[derive(Clone, Debug)]
pub struct ThesisFrame {
    /// Letter of the scene, `a` to `g`.
    pub scene: &'static str,
    /// Camera.
    pub camera: Camera,
    /// Surface hits of a path.
    pub hits: u32,
}

impl ThesisProgram {
    /// The program, from its shader. `None` without a shader, or if the interpreter has no module `moderngl`.
    pub fn find(python: Python, shader: Option<&Path>) -> Option<Self> {
        let shader = shader?.to_owned();
        (python.has("moderngl") && shader.is_file()).then_some(Self { python, shader })
    }

    /// Median milliseconds of each frame, and the name of the OpenGL device.
    pub fn times(&self, frames: &[ThesisFrame], size: [u32; 2], rounds: u32) -> Result<(Vec<f64>, String), Failure> {
        #[derive(serde::Deserialize)]
        struct Line {
            milliseconds: f64,
            device: String,
        }
        let described: Vec<_> = frames
            .iter()
            .map(|ThesisFrame { scene, camera, hits }| {
                serde_json::json!({
                    "scene": scene, "hits": hits,
                    "position": camera.position, "target": camera.target, "fov": camera.fov,
                })
            })
            .collect();
        let mut arguments = vec![self.shader.display().to_string(), serde_json::Value::from(described).to_string()];
        arguments.extend(["--size".to_owned(), size[0].to_string(), size[1].to_string()]);
        arguments.extend(["--rounds".to_owned(), rounds.to_string()]);
        let lines = self.python.run(
            "render_thesis.py",
            include_str!("../../../../scripts/peers/render_thesis.py"),
            &arguments,
        )?;
        let lines: Vec<Line> = lines.iter().map(|line| parsed(line)).collect::<Result<_, _>>()?;
        let device = lines.first().map_or_else(String::new, |line| line.device.clone());
        Ok((lines.into_iter().map(|line| line.milliseconds).collect(), device))
    }
}
