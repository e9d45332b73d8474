//! Source editor: the text of the scene, with coloured syntax, names that fit, help, and marks of errors and colours beside the
//! line numbers.

use crate::window::app::App;
use crate::window::source_editor::{CompletionList, Margin, byte_of, set_cursor};
use egui::text::CCursor;
use egui::{Ui, Vec2};
use pathmarch_render::pathmarch_scene::language_service::in_document;
use pathmarch_render::pathmarch_scene::reference::Entry;
use std::time::Duration;

/// A pause in typing that begins a new undo step, seconds.
const TYPING_PAUSE: f64 = 1.0;
/// Longer texts list names only when asked to, bytes: each list reads the text twice.
const MAX_TYPED: usize = 200_000;

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
                ui.weak("Ctrl + Space lists names, Alt + drag changes a number.");
            });
            egui::ScrollArea::both().auto_shrink([false, false]).show(ui, |ui| {
                ui.spacing_mut().item_spacing.x = 4.0;
                ui.horizontal_top(|ui| changed = self.source_text(ui, &mut text));
            });
        });
        if changed {
            let now = ui.input(|input| input.time);
            if now - self.last_typed_at > TYPING_PAUSE && !self.source.drag.is_active() {
                self.undo_group += 1;
            }
            self.last_typed_at = now;
            let undo_group = self.undo_group;
            self.edit(|open| {
                open.document.replace_text(text, "Typing", Some(undo_group));
                Ok(())
            });
            self.list_names_after_typing();
        }
    }

    /// Draws the margin and the text; returns true if it was changed.
    fn source_text(&mut self, ui: &mut Ui, text: &mut String) -> bool {
        let id = ui.make_persistent_id("scene text");
        self.source.coloured.update(ui, text);
        let margin = Margin::space(ui, &self.source.coloured);
        let accepted = self.choose_name(ui, id, text);
        let go_to = self.source.go_to.take().map(|byte| text.get(..byte).unwrap_or(text).chars().count());
        if let Some(index) = go_to.or(accepted) {
            set_cursor(ui, id, index);
        }
        let coloured = &mut self.source.coloured;
        let mut layout = |ui: &Ui, text: &dyn egui::TextBuffer, _: f32| coloured.galley(ui, text.as_str());
        let edit = egui::TextEdit::multiline(text).id(id).code_editor().layouter(&mut layout);
        let edit = edit.frame(egui::Frame::NONE).desired_width(f32::INFINITY).margin(egui::Margin::ZERO);
        let output = edit.show(ui);
        let response = &output.response;
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::MultilineTextInput, true, "Scene text"));
        let typed = response.changed();
        let cursor = output.cursor_range.map(|range| usize::from(range.primary.index));
        self.source.cursor = cursor;
        let at = cursor.map(|index| byte_of(text, index));
        self.source.list.take_if(|list| !list.belongs_to(at, response.has_focus()));
        if go_to.is_some() {
            let row = output.galley.pos_from_cursor(CCursor::new(go_to.unwrap_or_default()));
            ui.scroll_to_rect(row.translate(output.galley_pos.to_vec2()).expand2(Vec2::new(40.0, 40.0)), None);
            response.request_focus();
        }
        let dragged = self.source.drag.update(ui, &output, text);
        let coloured = match &mut self.open {
            Some(open) => self.source.margin.show(ui, margin, &output, &mut open.document, text),
            None => false,
        };
        self.hover_help(ui, &output, text);
        let wanted =
            response.has_focus() && ui.input_mut(|input| input.consume_key(egui::Modifiers::CTRL, egui::Key::Space));
        if wanted && let Some(index) = cursor {
            self.list_names(byte_of(text, index));
        }
        if let Some(list) = &mut self.source.list {
            list.show(ui, &output);
        }
        typed || accepted.is_some() || dragged || coloured
    }

    /// Puts the chosen name of the list into the text; returns the new cursor, in characters.
    fn choose_name(&mut self, ui: &Ui, id: egui::Id, text: &mut String) -> Option<usize> {
        let has_focus = ui.memory(|memory| memory.has_focus(id));
        let (range, name) = self.source.list.as_mut()?.chosen(ui, has_focus)?;
        let (end, fits) = (range.start + name.len(), text.get(range.clone()).is_some());
        if fits {
            text.replace_range(range, name);
        }
        self.source.list = None;
        ui.memory_mut(|memory| memory.request_focus(id));
        fits.then(|| text[..end].chars().count())
    }

    /// Lists the names that fit at a byte of the text.
    fn list_names(&mut self, at: usize) {
        let Some(open) = &mut self.open else { return };
        let found = in_document::completions(&mut open.document, at);
        self.source.list = CompletionList::new(found, open.document.text(), at);
    }

    /// Lists names while a word is typed.
    fn list_names_after_typing(&mut self) {
        let Some(open) = &self.open else { return };
        let text = open.document.text();
        let at = self.source.cursor.map(|index| byte_of(text, index));
        let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
        let word = at.map_or("", |at| text[..at].rsplit(|c| !is_name(c)).next().unwrap_or_default());
        match at {
            Some(at) if text.len() < MAX_TYPED && word.len() > 1 && word.starts_with(char::is_alphabetic) => {
                self.list_names(at);
            }
            _ => self.source.list = None,
        }
    }

    /// Help on the word under a resting pointer.
    fn hover_help(&mut self, ui: &Ui, output: &egui::text_edit::TextEditOutput, text: &str) {
        let rests = ui.input(|input| input.pointer.time_since_last_movement() > 0.4 && !input.pointer.any_down());
        let Some(at) = output.response.hover_pos().filter(|_| self.source.list.is_none()) else {
            self.source.help = None;
            return;
        };
        let cursor: usize = output.galley.cursor_from_pos(at - output.galley_pos).index.into();
        let is_on_text = output.galley.pos_from_cursor(CCursor::new(cursor)).translate(output.galley_pos.to_vec2());
        let byte = byte_of(text, cursor);
        let Some(open) = &mut self.open else { return };
        let revision = open.document.revision();
        match &self.source.help {
            Some((known, of, help)) if (*known, *of) == (byte, revision) => {
                if let Some(help) = help {
                    let response: &egui::Response = &output.response;
                    response.clone().on_hover_text_at_pointer(help);
                }
            }
            _ if !rests => {
                self.source.help = None;
                ui.ctx().request_repaint_after(Duration::from_millis(450));
            }
            _ if (is_on_text.center() - at).length() > 14.0 => self.source.help = None,
            _ => {
                let hover = in_document::hover(&mut open.document, byte);
                let entry = |entry: &Entry| {
                    let title = entry.title.replace('`', "");
                    std::iter::once(format!("{title}\n{}", entry.doc))
                        .chain(entry.details.iter().cloned())
                        .collect::<Vec<_>>()
                        .join("\n")
                };
                let help = hover.map(|hover| hover.meanings.iter().map(entry).collect::<Vec<_>>().join("\n\n"));
                self.source.help = Some((byte, revision, help));
                ui.ctx().request_repaint();
            }
        }
    }
}
