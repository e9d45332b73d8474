//! Cycles, Blender's path tracer, from the Python module `bpy`.

use super::{DescribedScene, PeerPicture, Python};
use pathmarch_cli::Failure;
use std::path::Path;

/// Cycles on the processor.
pub struct Cycles(Python);

/// Cost of a scene before its first sample.
pub struct Setup {
    pub seconds: f64,
    /// Rise of resident memory while it is built and rendered, MB, where it is known.
    pub megabytes: Option<f64>,
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
        let pictures = self.render(scene, size, &[1, 3], 0, false, directory)?;
        let [one, three] = &pictures[..] else { return Err(Failure::Other("Cycles wrote no picture".to_owned())) };
        let seconds = (one.seconds - (three.seconds - one.seconds) / 2.0).max(0.0);
        Ok(Setup { seconds, megabytes: one.megabytes })
    }

    /// Renders a scene once for each number of samples, each time with another seed. The seconds include the building of
    /// the scene, and with `denoise` Open Image Denoise.
    pub fn render(
        &self,
        scene: &DescribedScene,
        size: [u32; 2],
        samples: &[u32],
        seed: u32,
        denoise: bool,
        directory: &Path,
    ) -> Result<Vec<PeerPicture>, Failure> {
        let mut arguments = vec![scene.path.display().to_string(), directory.display().to_string()];
        arguments.extend(["--size".to_owned(), size[0].to_string(), size[1].to_string()]);
        arguments.extend(denoise.then(|| "--oidn".to_owned()));
        arguments.extend(["--seed".to_owned(), seed.to_string(), "--samples".to_owned()]);
        arguments.extend(samples.iter().map(u32::to_string));
        let lines =
            self.0.run("render_cycles.py", include_str!("../../../../scripts/peers/render_cycles.py"), &arguments)?;
        lines.iter().map(|line| PeerPicture::parsed(line)).collect()
    }
}
