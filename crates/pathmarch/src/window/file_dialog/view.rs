//! User interface of the file dialog.

use super::listing::{self, Entry};
use super::{Choice, FileDialog};
use crate::window::files::relative_time::relative_time;
use egui::{Align, Align2, Button, Key, Layout, Sense, TextEdit, TextStyle, Ui};
use std::time::SystemTime;

impl FileDialog {
    pub(super) fn path_row(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            if ui.add_enabled(self.directory.parent().is_some(), Button::new("Up")).clicked() {
                self.enter_parent();
            }
            let label = ui.label("Path");
            let field = ui.add(TextEdit::singleline(&mut self.path).desired_width(f32::INFINITY)).labelled_by(label.id);
            if field.changed() && self.path.ends_with(std::path::is_separator) {
                // Show the directory while its path is typed; an incomplete path is not an error yet.
                let directory = listing::resolve(&self.directory, &self.path);
                if let Ok(entries) = listing::read(&directory) {
                    self.set_entries(directory, entries);
                }
            }
            if field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                self.open_typed_path();
            }
        });
        ui.add_space(2.0);
    }

    pub(super) fn bookmark_list(&mut self, ui: &mut Ui) {
        let mut to = None;
        egui::ScrollArea::vertical().id_salt("bookmarks").show(ui, |ui| {
            ui.with_layout(Layout::top_down_justified(Align::LEFT), |ui| {
                for (name, directory) in &self.bookmarks {
                    let button = Button::selectable(*directory == self.directory, name).truncate();
                    if ui.add(button).on_hover_text(directory.to_string_lossy()).clicked() {
                        to = Some(directory.clone());
                    }
                }
            });
        });
        if let Some(directory) = to {
            self.enter(&directory);
        }
    }

    pub(super) fn file_list(&mut self, ui: &mut Ui) {
        if self.visible.is_empty() {
            ui.weak("No matching files");
        }
        let height = ui.text_style_height(&TextStyle::Button) + 4.0;
        let step = height + ui.spacing().item_spacing.y;
        let mut area = egui::ScrollArea::vertical().id_salt("files").auto_shrink(false);
        if std::mem::take(&mut self.scroll_to_selection)
            && let Some(selected) = self.selected
        {
            // Scroll the row to the middle.
            area = area.vertical_scroll_offset((selected as f32 * step - ui.available_height() / 2.0).max(0.0));
        }
        self.row_focused = false;
        let now = SystemTime::now();
        area.show_rows(ui, height, self.visible.len(), |ui, rows| {
            for row in rows {
                // Opening a directory replaces the list while it is drawn.
                let Some(entry) = self.visible.get(row).and_then(|index| self.entries.get(*index)) else { break };
                let response = show_entry(ui, entry, self.selected == Some(row), height, now);
                self.row_focused |= response.has_focus();
                if response.double_clicked() {
                    self.select(row);
                    self.accept();
                    break;
                }
                if response.clicked() || response.gained_focus() {
                    self.select(row);
                }
            }
        });
    }

    pub(super) fn actions(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        if let Some(error) = &self.error {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        if let Some(path) = &self.replace {
            let path = path.clone();
            ui.label(format!("{} already exists. Replace it?", path.file_name().unwrap_or_default().display()));
            ui.horizontal(|ui| {
                if ui.button("Replace").clicked() {
                    self.choice = Some(Choice::Chosen(path));
                }
                if ui.button("Do not replace").clicked() {
                    self.replace = None;
                }
            });
            return;
        }
        if let Some(name) = &mut self.name {
            let entered = ui.horizontal(|ui| {
                let label = ui.label("Name");
                let edit = TextEdit::singleline(&mut name.text).desired_width(f32::INFINITY);
                let field = ui.add(edit).labelled_by(label.id);
                if self.is_first_frame {
                    field.request_focus();
                }
                if field.changed() {
                    // From here on the typed name counts.
                    self.selected = None;
                }
                field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter))
            });
            if entered.inner {
                self.selected = None;
                self.accept();
            }
        }
        ui.horizontal(|ui| {
            if !self.options.extensions.is_empty() && ui.checkbox(&mut self.all_files, "All files").changed() {
                self.filter();
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let (verb, ready) = match &self.name {
                    Some(name) => ("Save", !name.text.trim().is_empty()),
                    None => ("Open", self.selected.is_some()),
                };
                if ui.add_enabled(ready, Button::new(verb)).clicked() {
                    self.accept();
                }
                if ui.button("Cancel").clicked() {
                    self.choice = Some(Choice::Cancelled);
                }
            });
        });
    }
}

/// Draws a row: name, size and time.
fn show_entry(ui: &mut Ui, entry: &Entry, selected: bool, height: f32, now: SystemTime) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(ui.available_width(), height), Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, ui.is_enabled(), selected, &entry.label));
    let style = ui.style().interact_selectable(&response, selected);
    if selected || response.hovered() || response.has_focus() {
        ui.painter().rect(rect, style.corner_radius, style.weak_bg_fill, style.bg_stroke, egui::StrokeKind::Inside);
    }
    let inner = rect.shrink2(egui::vec2(4.0, 0.0));
    let colour = if selected { style.text_color() } else { ui.visuals().weak_text_color() };
    let font = TextStyle::Body.resolve(ui.style());
    let time = entry.modified.map(|modified| relative_time(modified, now)).unwrap_or_default();
    ui.painter().text(inner.right_center(), Align2::RIGHT_CENTER, time, font.clone(), colour);
    let size = entry.size.map(listing::size_text).unwrap_or_default();
    ui.painter().text(inner.right_center() - egui::vec2(95.0, 0.0), Align2::RIGHT_CENTER, size, font, colour);
    let name = egui::WidgetText::from(&entry.label).into_galley(
        ui,
        Some(egui::TextWrapMode::Truncate),
        (inner.width() - 165.0).max(40.0),
        TextStyle::Button,
    );
    let elided = name.elided;
    let at = inner.left_center() - egui::vec2(0.0, name.size().y / 2.0);
    ui.painter().galley(at, name, style.text_color());
    if elided { response.on_hover_text(&entry.label) } else { response }
}
