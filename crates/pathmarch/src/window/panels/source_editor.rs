//! Source editor: the text of the scene.

use crate::window::app::App;
use egui::{RichText, Ui};

/// A pause in typing that begins a new undo step, seconds.
const TYPING_PAUSE: f64 = 1.0;

impl App {
    /// Draws the editor with line numbers.
    pub(crate) fn source_panel(&mut self, ui: &mut Ui) {
        let Some(open) = &self.open else { return };
        let mut text = open.document.text().to_owned();
        let line = open.view.selection.active().and_then(|path| open.document.line_of(path));
        let mut changed = false;
        egui::Panel::bottom("source").resizable(true).default_size(220.0).max_size(600.0).show(ui, |ui| {
            ui.horizontal(|ui| {
                ui.strong("Source");
                if let Some(line) = line {
                    ui.weak(format!("selection: line {line}"));
                }
            });
            egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    let count = text.split('\n').count();
                    let numbers: Vec<String> = (1..=count).map(|line| format!("{line:>4}")).collect();
                    ui.add(egui::Label::new(RichText::new(numbers.join("\n")).monospace().weak()).selectable(false));
                    // Do not wrap lines, so that they stay beside their numbers.
                    let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, _: f32| {
                        let font = egui::TextStyle::Monospace.resolve(ui.style());
                        let colour = ui.visuals().widgets.inactive.text_color();
                        ui.fonts_mut(|fonts| fonts.layout_no_wrap(text.as_str().to_owned(), font, colour))
                    };
                    let edit = egui::TextEdit::multiline(&mut text).code_editor().layouter(&mut layout);
                    let edit = edit.frame(egui::Frame::NONE);
                    let response = ui.add(edit.desired_width(f32::INFINITY).margin(egui::Margin::ZERO));
                    response
                        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::MultilineTextInput, true, "Scene text"));
                    changed = response.changed();
                });
            });
        });
        if changed {
            let now = ui.input(|input| input.time);
            if now - self.last_typed_at > TYPING_PAUSE {
                self.undo_group += 1;
            }
            self.last_typed_at = now;
            let undo_group = self.undo_group;
            self.edit(|open| {
                open.document.replace_text(text, "Typing", Some(undo_group));
                Ok(())
            });
        }
    }
}
