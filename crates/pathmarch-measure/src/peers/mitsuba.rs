//! Mitsuba 3, a research path tracer, from the Python module `mitsuba`.

use super::{DescribedScene, PeerPicture, Python};
use pathmarch_cli::Failure;
use std::path::Path;

/// Mitsuba on the processor, through LLVM.
pub struct Mitsuba(Python);

impl Mitsuba {
    /// Finds Mitsuba; `None` if the interpreter has no module `mitsuba`.
    pub fn find(python: Python) -> Option<Self> {
        python.has("mitsuba").then_some(Self(python))
    }

    /// Version.
    pub fn version(&self) -> String {
        let lines = self.0.run("version.py", "import mitsuba; print('RESULT', mitsuba.__version__)", &[]);
        lines.ok().and_then(|lines| lines.first().cloned()).unwrap_or_default()
    }

    /// Renders a scene. The seconds exclude the compilation of the kernel and the building of the scene.
    pub fn render(
        &self,
        scene: &DescribedScene,
        size: [u32; 2],
        samples: u32,
        seed: u32,
        directory: &Path,
    ) -> Result<Vec<PeerPicture>, Failure> {
        let mut arguments = vec![scene.path.display().to_string(), directory.display().to_string()];
        arguments.extend(["--size".to_owned(), size[0].to_string(), size[1].to_string()]);
        arguments.extend(["--samples".to_owned(), samples.to_string(), "--seeds".to_owned(), seed.to_string()]);
        let script = include_str!("../../../../scripts/peers/render_mitsuba.py");
        self.0.run("render_mitsuba.py", script, &arguments)?.iter().map(|line| PeerPicture::parsed(line)).collect()
    }
}
