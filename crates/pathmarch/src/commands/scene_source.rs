//! Where a scene comes from: a file, standard input, or the gallery.

use pathmarch_cli::Failure;
use pathmarch_gallery::{ASSETS, EXAMPLES};
use pathmarch_render::pathmarch_scene::{Animation, Moment, Scene, SceneError};
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest scene on standard input, bytes.
const MAX_BYTES: u64 = 16 << 20;

/// Name of standard input in diagnostics.
pub const STANDARD_INPUT: &str = "standard input";

/// Reads standard input as text.
///
/// # Errors
/// If it cannot be read, or is not UTF-8.
pub fn read_standard_input() -> Result<String, Failure> {
    let mut text = String::new();
    let read = std::io::stdin().lock().take(MAX_BYTES + 1).read_to_string(&mut text);
    read.map_err(|error| Failure::Other(format!("{STANDARD_INPUT}: {error}")))?;
    Ok(text)
}

/// Source of a scene.
pub enum SceneSource {
    /// File.
    File(PathBuf),
    /// Name and text.
    Text(String, String),
    /// Example of the gallery, in a directory with the files that it uses.
    Example {
        /// The file.
        scene: PathBuf,
        /// Its directory, which is removed with this.
        _directory: tempfile::TempDir,
    },
}

impl SceneSource {
    /// Source of a name: `-` is standard input; the name of an example is that, unless there is such a file.
    ///
    /// # Errors
    /// If standard input cannot be read, or the files of an example cannot be written.
    pub fn of(path: &Path) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self::Text(STANDARD_INPUT.to_owned(), read_standard_input()?));
        }
        let example = EXAMPLES.iter().find(|example| Path::new(example.name) == path).filter(|_| !path.exists());
        let Some(example) = example else {
            return similar_example(path).map_or(Ok(Self::File(path.to_owned())), |name| {
                Err(Failure::Usage(format!(
                    "{}: there is no such file; did you mean the example \"{name}\"?",
                    path.display()
                )))
            });
        };
        let directory = tempfile::tempdir().map_err(Failure::other)?;
        let scene = directory.path().join(format!("{}.kdl", example.name));
        std::fs::write(&scene, example.text).map_err(Failure::other)?;
        // Examples in a subdirectory name the files of the directory above.
        for (name, bytes) in ASSETS {
            std::fs::write(directory.path().join(name), bytes).map_err(Failure::other)?;
        }
        Ok(Self::Example { scene, _directory: directory })
    }

    /// The animation; a still scene is one, too. Unless `allow_files` is true, it reads no file outside its folder.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn animation(&self, allow_files: bool) -> Result<Animation, Failure> {
        let animation = match self {
            Self::File(path) | Self::Example { scene: path, .. } => Animation::load(path)?,
            Self::Text(name, text) => Animation::new(name.clone(), text.clone()),
        };
        Ok(if allow_files { animation } else { animation.confined() })
    }
}

/// Example with nearly this name, if there is no such file and the name has neither folder nor extension.
fn similar_example(path: &Path) -> Option<&'static str> {
    let name = path.to_str().filter(|name| !name.contains(['/', '\\', '.']) && !path.exists())?;
    let edits = |example: &&str| strsim::damerau_levenshtein(example, name);
    let names = EXAMPLES.iter().map(|example| example.name);
    names.min_by_key(edits).filter(|example| edits(example) <= name.len().div_ceil(4))
}

/// Loads a still scene; unless `allow_files` is true, it reads no file outside its folder.
///
/// # Errors
/// Those of [`Scene::load`].
pub fn load(path: &Path, allow_files: bool) -> Result<Scene, SceneError> {
    let animation = Animation::load(path)?;
    let mut animation = if allow_files { animation } else { animation.confined() };
    animation.at(Moment::default())
}
