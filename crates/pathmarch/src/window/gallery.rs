//! Gallery of example scenes.
//!
//! Scenes and thumbnails are part of the program, which needs no other files. An example opens as an unsaved copy.

use crate::atomic_file::write_atomically;
use egui::{ColorImage, TextureHandle, TextureOptions, Vec2};
use pathmarch_cli::AppDirs;
use pathmarch_gallery::{ASSETS, EXAMPLES};
use std::path::PathBuf;

/// Size of a thumbnail, points.
pub(crate) const CARD: Vec2 = Vec2::new(240.0, 135.0);

#[derive(Default)]
pub(crate) struct Gallery {
    /// Directory of the image files that scenes use.
    home: Option<PathBuf>,
    /// Thumbnails decoded so far.
    pub(crate) textures: Vec<TextureHandle>,
}

impl Gallery {
    /// Name and text of an example.
    pub(crate) fn scene(&mut self, index: usize) -> Option<(String, String)> {
        let example = EXAMPLES.get(index)?;
        let home = self.home().join(example.file);
        Some((home.display().to_string(), example.text.to_owned()))
    }

    /// Decodes a few more thumbnails, so that the page appears at once.
    pub(crate) fn unpack(&mut self, ctx: &egui::Context) {
        const AT_ONCE: usize = 3;
        let next = self.textures.len();
        for example in EXAMPLES.iter().skip(next).take(AT_ONCE) {
            let image = image::load_from_memory(example.picture).map(|picture| {
                let (width, height) = (2.0 * CARD.x, 2.0 * CARD.y);
                let small = picture.resize_to_fill(width as u32, height as u32, image::imageops::FilterType::Triangle);
                let size = [small.width() as usize, small.height() as usize];
                ColorImage::from_rgba_unmultiplied(size, &small.to_rgba8())
            });
            // Thumbnails are part of the program, and a test opens each.
            let image = image.unwrap_or_else(|_| ColorImage::filled([2, 2], egui::Color32::BLACK));
            self.textures.push(ctx.load_texture(example.name, image, TextureOptions::LINEAR));
        }
        if self.textures.len() < EXAMPLES.len() {
            ctx.request_repaint();
        }
    }

    /// Source directory of the scenes if it exists, else a directory with their image files.
    fn home(&mut self) -> PathBuf {
        self.home.get_or_insert_with(find_home).clone()
    }
}

fn find_home() -> PathBuf {
    let sources = pathmarch_gallery::folder();
    if sources.is_dir() {
        return sources.to_owned();
    }
    let home = AppDirs::of_user().map_or_else(std::env::temp_dir, |dirs| dirs.recovery).with_file_name("gallery");
    // If this fails, the scene reports the missing image.
    if std::fs::create_dir_all(&home).is_ok() {
        for (name, bytes) in ASSETS {
            let path = home.join(name);
            if std::fs::metadata(&path).map(|meta| meta.len()).ok() != Some(bytes.len() as u64) {
                drop(write_atomically(&path, bytes));
            }
        }
    }
    home
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::Scene;

    /// Every example opens: the files that it uses are found.
    #[test]
    fn every_example_opens() {
        let mut gallery = Gallery::default();
        for index in 0..EXAMPLES.len() {
            let (name, text) = gallery.scene(index).expect("an example");
            Scene::parse(&name, &text).expect("a scene");
        }
    }
}
