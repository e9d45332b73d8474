//! Cycles, Blender's path tracer, from the Python module `bpy`.

use super::{DescribedScene, Python, parsed};
use pathmarch_cli::Failure;
use pathmarch_render::image::{self, Picture};
use std::path::Path;

/// Cycles on the processor.
pub struct Cycles(Python);

/// A picture by Cycles.
pub struct CyclesPicture {
    /// Samples of each pixel.
    pub samples: u32,
    /// Time of the render, with the building of the scene, seconds.
    pub seconds: f64,
    /// Rise of resident memory by the first render of the run, MB, where it is known.
    pub megabytes: Option<f64>,
    /// Mean of the samples.
    pub picture: Picture,
}

/// Cost of a scene before its first sample.
pub struct Setup {
    pub seconds: f64,
    /// Rise of resident memory while it is built and rendered, MB, where it is known.
    pub megabytes: Option<f64>,
}

#[derive(serde::Deserialize)]
struct Line {
    samples: u32,
    seconds: f64,
    megabytes: Option<f64>,
    picture: String,
}

impl Cycles {
    /// Finds Cycles; `None` if the interpreter has no module `bpy`.
    pub fn find(python: Python) -> Option<Self> {
        python.has("bpy").then_some(Self(python))
    }

    /// Version of Blender.
    pub fn version(&self) -> String {
        let lines = self.0.run("version.py", "import bpy; print('RESULT', bpy.app.version_string)", &[]);
        lines.ok().and_then(|lines| lines.first().cloned()).unwrap_or_default()
    }

    /// Cost of a render before its first sample: the scene's meshes and their BVH.
    pub fn setup(&self, scene: &DescribedScene, size: [u32; 2], directory: &Path) -> Result<Setup, Failure> {
        let pictures = self.render(scene, size, &[1, 3], false, directory)?;
        let [one, three] = &pictures[..] else { return Err(Failure::Other("Cycles wrote no picture".to_owned())) };
        let seconds = (one.seconds - (three.seconds - one.seconds) / 2.0).max(0.0);
        Ok(Setup { seconds, megabytes: one.megabytes })
    }

    /// Renders a scene once for each number of samples, each time with another seed. `denoise`: with Open Image Denoise,
    /// which the seconds include.
    pub fn render(
        &self,
        scene: &DescribedScene,
        size: [u32; 2],
        samples: &[u32],
        denoise: bool,
        directory: &Path,
    ) -> Result<Vec<CyclesPicture>, Failure> {
        let mut arguments = vec![scene.path.display().to_string(), directory.display().to_string()];
        arguments.extend(["--size".to_owned(), size[0].to_string(), size[1].to_string()]);
        arguments.extend(denoise.then(|| "--oidn".to_owned()));
        arguments.push("--samples".to_owned());
        arguments.extend(samples.iter().map(u32::to_string));
        let lines =
            self.0.run("render_cycles.py", include_str!("../../../../scripts/peers/render_cycles.py"), &arguments)?;
        let picture = |line: &String| {
            let Line { samples, seconds, megabytes, picture } = parsed(line)?;
            let picture = image::load(Path::new(&picture)).map_err(Failure::other)?.picture;
            Ok(CyclesPicture { samples, seconds, megabytes, picture })
        };
        lines.iter().map(picture).collect()
    }
}
