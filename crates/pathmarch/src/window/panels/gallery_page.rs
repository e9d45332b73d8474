//! Start page: the gallery of example scenes.

use crate::window::app::App;
use crate::window::app::requests::PendingAction;
use crate::window::gallery::CARD;
use egui::{Image, RichText, TextureHandle, Ui, Vec2};
use pathmarch_gallery::{EXAMPLES, Example};

impl App {
    pub(crate) fn gallery_page(&mut self, ui: &mut Ui) {
        self.gallery.unpack(ui.ctx());
        let mut chosen = None;
        egui::CentralPanel::default().show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                ui.add_space(14.0);
                ui.vertical_centered(|ui| {
                    ui.label(RichText::new("pathmarch").size(34.0).strong());
                    ui.label("A path tracer for distance fields. Choose a scene to start with.");
                    ui.add_space(8.0);
                    ui.horizontal(|ui| {
                        let width = 250.0;
                        ui.add_space((ui.available_width() - width).max(0.0) * 0.5);
                        if ui.button("New scene").on_hover_text("A sphere on a floor.").clicked() {
                            chosen = Some(PendingAction::New);
                        }
                        if ui.button("Open file…").on_hover_text("Open a .kdl scene file.").clicked() {
                            chosen = Some(PendingAction::Open);
                        }
                        if let Some(path) = self.preferences.recent.first() {
                            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                            let words = path.display().to_string();
                            if ui.button(format!("Continue with {name}")).on_hover_text(words).clicked() {
                                chosen = Some(PendingAction::OpenFile(path.clone()));
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
                                chosen = Some(PendingAction::Example(index));
                            }
                        }
                    });
                    ui.add_space(6.0);
                }
            });
        });
        if let Some(after) = chosen {
            self.run_pending(after);
        }
    }
}

/// Draws a card with picture, name and description; returns true if it was clicked.
fn card(ui: &mut Ui, example: &'static Example, picture: Option<&TextureHandle>) -> bool {
    // Name and two lines of text. The space is the same for all cards, so that columns and rows stay aligned.
    let size = Vec2::new(CARD.x + 12.0, CARD.y + 58.0);
    let (rect, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let mut ui = ui.new_child(egui::UiBuilder::new().max_rect(rect).layout(*ui.layout()));
    ui.set_clip_rect(rect.intersect(ui.clip_rect()));
    let card = {
        ui.vertical(|ui| {
            ui.set_max_width(CARD.x);
            let clicked = match picture {
                Some(texture) => {
                    let image = Image::new((texture.id(), CARD)).corner_radius(4.0).alt_text(example.name);
                    ui.add(egui::Button::image(image).frame(false)).clicked()
                }
                None => ui.add_sized(CARD, egui::Button::new(example.name)).clicked(),
            };
            ui.strong(example.name);
            ui.add(egui::Label::new(example.doc).wrap());
            clicked
        })
    };
    card.inner
}
