//! Diagnostics: errors and warnings of the scene, with their lines.
//!
//! They cover the lower part of the viewport: a panel would resize the picture with every mistake while typing.

use crate::window::app::App;
use egui::{Pos2, Rect, RichText, Sense, Ui, UiBuilder};

impl App {
    /// Lists the errors of the scene text, or its warnings while the source is shown.
    pub(crate) fn diagnostics_panel(&mut self, ui: &mut Ui, viewport: Rect) {
        let Some(open) = &self.open else { return };
        let error = match open.document.scene() {
            Err(error) => error,
            Ok(scene) if !scene.warnings.is_empty() && self.preferences.show_source => {
                let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
                overlay(ui, viewport, 24.0 + 20.0 * warnings.len() as f32, |ui| {
                    for warning in warnings {
                        ui.colored_label(ui.visuals().warn_fg_color, format!("warning: {warning}"));
                    }
                });
                return;
            }
            Ok(_) => return,
        };
        let text = open.document.text();
        let mut lines: Vec<(usize, String, Option<String>)> = Vec::new();
        for mistake in error.mistakes() {
            let words = if mistake.label.is_empty() {
                mistake.message.clone()
            } else {
                format!("{} ({})", mistake.message, mistake.label)
            };
            // Errors in an included file name that file: the text shown here is another.
            let source = &mistake.source_code;
            if source.name() == open.document.name() {
                lines.push((mistake.span.offset(), words, mistake.help.clone()));
            } else {
                let before = source.inner().get(..mistake.span.offset()).unwrap_or_default();
                let line = 1 + before.matches('\n').count();
                lines.push((0, format!("in {}, line {line}: {words}", source.name()), mistake.help.clone()));
            }
        }
        if lines.is_empty() {
            lines.push((0, error.to_string(), None));
        }
        let mut go_to = None;
        overlay(ui, viewport, 44.0 + 62.0 * lines.len() as f32, |ui| {
            let title = if lines.len() == 1 { "1 error".to_owned() } else { format!("{} errors", lines.len()) };
            ui.horizontal_wrapped(|ui| {
                ui.colored_label(ui.visuals().error_fg_color, RichText::new(title).strong());
                if open.document.last_good().is_some() {
                    ui.weak("The picture shows the last version without errors.");
                }
            });
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                for (offset, message, help) in &lines {
                    ui.horizontal_wrapped(|ui| {
                        let before = text.get(..*offset).unwrap_or(text);
                        let line = 1 + before.matches('\n').count();
                        let column = 1 + before.rsplit('\n').next().map_or(0, |line| line.chars().count());
                        let place = RichText::new(format!("line {line}, column {column}")).strong();
                        let place = ui.add(egui::Label::new(place).sense(Sense::click()));
                        if place.on_hover_text("Click to go to this place in the source.").clicked() {
                            go_to = Some(*offset);
                        }
                        ui.label(message);
                    });
                    if let Some(help) = help {
                        // Help that lists all words leaves room for other mistakes; its tooltip has the rest.
                        ui.add(egui::Label::new(RichText::new(help).weak()).truncate());
                    }
                    let shown = line_at(text, *offset);
                    ui.indent(("excerpt", offset), |ui| {
                        ui.monospace(RichText::new(shown).color(ui.visuals().warn_fg_color));
                    });
                }
            });
        });
        if let Some(offset) = go_to {
            self.preferences.show_source = true;
            self.source.go_to = Some(offset);
        }
    }
}

/// Largest share of the viewport that diagnostics cover.
const MAX_SHARE: f32 = 0.65;

/// Draws contents above the lower part of the viewport, as high as they need.
fn overlay(ui: &mut Ui, viewport: Rect, height: f32, contents: impl FnOnce(&mut Ui)) {
    let top = viewport.max.y - height.min(MAX_SHARE * viewport.height());
    let rect = Rect::from_min_max(Pos2::new(viewport.min.x, top), viewport.max);
    // Clicks on it do not reach the viewport below.
    ui.interact(rect, ui.scope_id().with("diagnostics"), Sense::click_and_drag());
    ui.painter().rect_filled(rect, 0.0, ui.visuals().panel_fill);
    let mut inner = ui.new_child(UiBuilder::new().max_rect(rect.shrink(8.0)));
    inner.set_clip_rect(rect);
    contents(&mut inner);
}

/// Line of the text that contains a byte offset, trimmed.
fn line_at(text: &str, offset: usize) -> &str {
    let offset = (0..=offset.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    let end = text[offset..].find('\n').map_or(text.len(), |at| offset + at);
    text[start..end].trim()
}
