//! Writes the gallery into a folder, for a web page: texts, pictures, the files that scenes name, and `gallery.json` with a list.
//!
//! `cargo run --release -p pathmarch-gallery --example export FOLDER`

use pathmarch_gallery::{ASSETS, EXAMPLES, Example};
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let folder = env::args_os().nth(1).map(PathBuf::from);
    let folder = folder.ok_or_else(|| io::Error::other("name a folder: export FOLDER"))?;
    for example in EXAMPLES {
        write(&folder, example.file, example.text.as_bytes())?;
        write(&folder, &picture(example), example.picture)?;
    }
    for (name, bytes) in ASSETS {
        write(&folder, name, bytes)?;
    }
    let scenes: Vec<String> = EXAMPLES.iter().map(entry).collect();
    let files: Vec<String> = ASSETS.iter().map(|(name, _)| format!("{name:?}")).collect();
    let json = format!("{{\"scenes\":[\n{}\n],\n\"files\":[{}]}}\n", scenes.join(",\n"), files.join(","));
    write(&folder, "gallery.json", json.as_bytes())
}

/// Name of the picture's file, which depends on its format.
fn picture(example: &Example) -> String {
    let extension = if example.picture.starts_with(b"\x89PNG") { "png" } else { "jpg" };
    format!("images/{}.{extension}", example.name)
}

/// Entry of the list. Names and descriptions are printable ASCII, for which Rust and JSON have the same escapes.
fn entry(example: &Example) -> String {
    let Example { name, doc, file, .. } = example;
    format!("{{\"name\":{name:?},\"doc\":{doc:?},\"file\":{file:?},\"picture\":{:?}}}", picture(example))
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> io::Result<()> {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap_or(folder))?;
    fs::write(path, bytes)
}
