//! The first page: example scenes to start from.
//!
//! Scenes and their pictures are part of the program, so that it needs no other file. A scene is opened as a copy without
//! a file of its own: saving asks for one.

use super::app::App;
use super::files::After;
use super::saving::write_atomically;
use egui::{ColorImage, Image, RichText, TextureHandle, TextureOptions, Ui, Vec2};
use pathmarch_cli::AppDirs;
use pathmarch_gallery::{ASSETS, EXAMPLES, Example};
use std::path::PathBuf;

/// Points of an example's picture.
const CARD: Vec2 = Vec2::new(240.0, 135.0);

#[derive(Default)]
pub(super) struct Gallery {
    /// Where the pictures that scenes need are.
    home: Option<PathBuf>,
    /// Pictures of the examples, as far as they are unpacked.
    textures: Vec<TextureHandle>,
}

impl Gallery {
    /// The name and text of an example.
    pub(super) fn scene(&mut self, index: usize) -> Option<(String, String)> {
        let example = EXAMPLES.get(index)?;
        let home = self.home().join(example.file);
        Some((home.display().to_string(), example.text.to_owned()))
    }

    /// Unpacks a few more pictures, so that the page is there at once.
    fn unpack(&mut self, ctx: &egui::Context) {
        const AT_ONCE: usize = 3;
        let next = self.textures.len();
        for example in EXAMPLES.iter().skip(next).take(AT_ONCE) {
            let image = image::load_from_memory(example.picture).map(|picture| {
                let (width, height) = (2.0 * CARD.x, 2.0 * CARD.y);
                let small = picture.resize_to_fill(width as u32, height as u32, image::imageops::FilterType::Triangle);
                let size = [small.width() as usize, small.height() as usize];
                ColorImage::from_rgba_unmultiplied(size, &small.to_rgba8())
            });
            // The pictures are part of the program, and a test opens each.
            let image = image.unwrap_or_else(|_| ColorImage::filled([2, 2], egui::Color32::BLACK));
            self.textures.push(ctx.load_texture(example.name, image, TextureOptions::LINEAR));
        }
        if self.textures.len() < EXAMPLES.len() {
            ctx.request_repaint();
        }
    }

    /// The folder of the scenes where they are at hand, else one with what they need.
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
    // Without them a scene says which picture it misses.
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

impl App {
    pub(super) fn gallery_page(&mut self, ui: &mut Ui) {
        self.gallery.unpack(ui.ctx());
        let mut chosen = None;
        egui::CentralPanel::default().show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                ui.add_space(14.0);
                ui.vertical_centered(|ui| {
                    ui.label(RichText::new("pathmarch").size(34.0).strong());
                    ui.label("Distance fields, path-traced. Choose a scene to start from.");
                    ui.add_space(8.0);
                    ui.horizontal(|ui| {
                        let width = 250.0;
                        ui.add_space((ui.available_width() - width).max(0.0) * 0.5);
                        if ui.button("New scene").on_hover_text("A ball on a floor.").clicked() {
                            chosen = Some(After::New);
                        }
                        if ui.button("Open a file…").on_hover_text("A .kdl file.").clicked() {
                            chosen = Some(After::Open);
                        }
                        if let Some(path) = self.preferences.recent.first() {
                            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                            let words = path.display().to_string();
                            if ui.button(format!("Go on with {name}")).on_hover_text(words).clicked() {
                                chosen = Some(After::OpenFile(path.clone()));
                            }
                        }
                    });
                });
                ui.add_space(14.0);
                let columns = ((ui.available_width() + 10.0) / (CARD.x + 22.0)).floor().max(1.0) as usize;
                let margin = 0.5 * (ui.available_width() - columns as f32 * (CARD.x + 22.0)).max(0.0);
                for (row, examples) in EXAMPLES.chunks(columns).enumerate() {
                    ui.horizontal_top(|ui| {
                        ui.add_space(margin);
                        for (column, example) in examples.iter().enumerate() {
                            let index = row * columns + column;
                            if card(ui, example, self.gallery.textures.get(index)) {
                                chosen = Some(After::Example(index));
                            }
                        }
                    });
                    ui.add_space(6.0);
                }
            });
        });
        if let Some(after) = chosen {
            self.proceed(after);
        }
    }
}

/// An example's picture, name and line; whether it was chosen.
fn card(ui: &mut Ui, example: &'static Example, picture: Option<&TextureHandle>) -> bool {
    let size = Vec2::new(CARD.x + 12.0, CARD.y + 48.0);
    let card = ui.allocate_ui(size, |ui| {
        ui.vertical(|ui| {
            let clicked = match picture {
                Some(texture) => {
                    let image = Image::new((texture.id(), CARD)).corner_radius(4.0).alt_text(example.name);
                    ui.add(egui::Button::image(image).frame(false)).on_hover_text(example.doc).clicked()
                }
                None => ui.add_sized(CARD, egui::Button::new(example.name)).clicked(),
            };
            ui.strong(example.name);
            ui.add(egui::Label::new(example.doc).wrap());
            clicked
        })
        .inner
    });
    card.inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::Scene;

    /// Every example opens from the page: the files that it reads are found.
    #[test]
    fn every_example_opens() {
        let mut gallery = Gallery::default();
        for index in 0..EXAMPLES.len() {
            let (name, text) = gallery.scene(index).expect("an example");
            Scene::parse(&name, &text).expect("a scene");
        }
    }
}
