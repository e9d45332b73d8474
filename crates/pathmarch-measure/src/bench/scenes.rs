//! Selection of scenes: files, directories, gallery examples, generated scenes, and sets of these.

use super::generated;
use pathmarch_cli::Failure;
use pathmarch_render::pathmarch_scene::Scene;
use std::path::{Path, PathBuf};

/// A scene with its name.
pub struct NamedScene {
    /// Name in results.
    pub name: String,
    /// Command-line argument that selects only this scene.
    pub argument: PathBuf,
    /// The scene.
    pub scene: Scene,
}

/// File and text of every gallery example.
fn examples() -> impl Iterator<Item = (&'static str, &'static str)> {
    pathmarch_gallery::EXAMPLES.iter().map(|example| (example.file, example.text))
}

/// Scenes on which other renderers were timed.
static QUALITY: &[(&str, &str)] = &[
    ("benchmarks/diffuse-sphere-plane.kdl", include_str!("../../../../scenes/benchmarks/diffuse-sphere-plane.kdl")),
    (
        "benchmarks/diffuse-sphere-plane-area.kdl",
        include_str!("../../../../scenes/benchmarks/diffuse-sphere-plane-area.kdl"),
    ),
    ("benchmarks/cornell-box.kdl", include_str!("../../../../scenes/benchmarks/cornell-box.kdl")),
    ("benchmarks/closed-metal-room.kdl", include_str!("../../../../scenes/benchmarks/closed-metal-room.kdl")),
    ("benchmarks/closed-emitting-room.kdl", include_str!("../../../../scenes/benchmarks/closed-emitting-room.kdl")),
];

/// Scenes of the default set, beside those of the thesis.
const DEFAULT_EXTRAS: [&str; 8] =
    ["mandelbulb", "mandelbox", "cubes", "cornell", "glass-still-life", "lights-64", "union-1000", "union-10000"];

/// Names of a set of scenes.
fn set(name: &str) -> Option<Vec<String>> {
    let thesis = || {
        let mut names: Vec<_> =
            examples().filter(|(file, _)| file.starts_with("thesis/")).map(|(file, _)| stem(Path::new(file))).collect();
        names.sort();
        names
    };
    match name {
        "default" => Some(thesis().into_iter().chain(DEFAULT_EXTRAS.map(str::to_owned)).collect()),
        "thesis" => Some(thesis()),
        "quality" => Some(QUALITY.iter().map(|(file, _)| stem(Path::new(file))).collect()),
        _ => None,
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Text of an example or generated scene.
pub fn built_in(name: &str) -> Option<String> {
    if let Some(made) = generated::ALL.iter().find(|made| made.name == name) {
        return Some(made.text());
    }
    let is_it = |(file, _): &(&str, &str)| stem(Path::new(file)) == name;
    examples().chain(QUALITY.iter().copied()).find(is_it).map(|(_, text)| text.to_owned())
}

/// Loads all scenes of the arguments; errors are reported before anything is measured.
pub fn chosen(arguments: &[PathBuf]) -> Result<Vec<NamedScene>, Failure> {
    let default = [PathBuf::from("default")];
    let arguments = if arguments.is_empty() { &default[..] } else { arguments };
    let mut chosen = Vec::new();
    for argument in arguments {
        let name = argument.to_string_lossy().into_owned();
        if argument.is_dir() {
            for path in files(argument)? {
                chosen.push(NamedScene { name: stem(&path), scene: Scene::load(&path)?, argument: path });
            }
        } else if argument.exists() {
            chosen.push(NamedScene { name: stem(argument), scene: Scene::load(argument)?, argument: argument.clone() });
        } else if let Some(names) = set(&name) {
            for name in names {
                chosen.extend(read(&name).transpose()?);
            }
        } else {
            chosen.push(read(&name).ok_or_else(|| unknown(&name))??);
        }
    }
    Ok(chosen)
}

fn read(name: &str) -> Option<Result<NamedScene, Failure>> {
    let text = built_in(name)?;
    let scene = Scene::parse(&format!("{name}.kdl"), &text);
    Some(scene.map_err(Failure::from).map(|scene| NamedScene { name: name.to_owned(), argument: name.into(), scene }))
}

fn files(directory: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |error: std::io::Error| Failure::Usage(format!("{}: {error}", directory.display()));
    let mut paths = Vec::new();
    for file in std::fs::read_dir(directory).map_err(failed)? {
        let path = file.map_err(failed)?.path();
        if path.extension().is_some_and(|extension| extension == "kdl") {
            paths.push(path);
        }
    }
    if paths.is_empty() {
        return Err(Failure::Usage(format!("{}: this directory contains no scenes (.kdl)", directory.display())));
    }
    paths.sort();
    Ok(paths)
}

fn unknown(name: &str) -> Failure {
    let known = examples().map(|(file, _)| file).chain(QUALITY.iter().map(|(file, _)| *file));
    let known = known.map(|file| stem(Path::new(file))).chain(generated::ALL.iter().map(|made| made.name.to_owned()));
    let nearest = known.min_by_key(|known| strsim::damerau_levenshtein(known, name));
    let meant = nearest.filter(|nearest| strsim::damerau_levenshtein(nearest, name) <= 3);
    let meant = meant.map(|nearest| format!("; did you mean {nearest}?")).unwrap_or_default();
    Failure::Usage(format!(
        "{name}: no such file, directory, example (of the gallery, union-100, union-1000, \
         union-10000, moving-10000, lights-64, lights-1000, lights-10000, foggy-lights-64, foggy-lights-1000) \
         or set (default, thesis, quality){meant}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_scenes() {
        for (name, least) in [("default", 29), ("thesis", 21), ("quality", 5)] {
            let scenes = chosen(&[name.into()]).expect("all can be read");
            assert!(scenes.len() >= least, "{name}: {}", scenes.len());
            let mut names: Vec<_> = scenes.iter().map(|chosen| chosen.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), scenes.len(), "{name}: each once");
        }
        assert!(chosen(&["three-sphere".into()]).err().is_some_and(
            |failure| matches!(failure, Failure::Usage(message) if message.contains("did you mean three-spheres"))
        ));
    }
}
