//! List of the names that fit where the text cursor is.

use egui::{Key, Modifiers, Ui};
use pathmarch_render::pathmarch_scene::language_service::{Completion, Completions};
use std::ops::Range;

/// Largest number of names in sight.
const ROWS: usize = 9;

/// A list of names, one of them marked.
pub(crate) struct CompletionList {
    /// Bytes that the name replaces.
    range: Range<usize>,
    /// Text cursor when the list was made, bytes.
    at: usize,
    names: Vec<Name>,
    marked: usize,
    /// A name that was clicked.
    clicked: Option<usize>,
    /// The pointer is on the list.
    is_hovered: bool,
}

struct Name {
    label: String,
    insert: String,
    doc: String,
}

impl CompletionList {
    /// The names that begin with what stands before the cursor, before those that contain it; `None` without any.
    pub(crate) fn new(found: Completions, text: &str, at: usize) -> Option<Self> {
        let typed = text.get(found.range.start..at).unwrap_or_default().to_lowercase();
        let name = |completion: Completion| Name {
            insert: plain(&completion.insert),
            label: completion.label,
            doc: completion.help.map(|entry| entry.doc).unwrap_or_default(),
        };
        let mut names: Vec<Name> = found.list.into_iter().map(name).collect();
        names.retain(|name| name.label.to_lowercase().contains(&typed));
        names.sort_by_key(|name| !name.label.to_lowercase().starts_with(&typed));
        let is_complete = names.len() == 1 && names[0].label == text.get(found.range.clone()).unwrap_or_default();
        (!names.is_empty() && !is_complete).then_some(Self {
            range: found.range,
            at,
            names,
            marked: 0,
            clicked: None,
            is_hovered: false,
        })
    }

    /// Draws the list below the text cursor.
    pub(crate) fn show(&mut self, ui: &Ui, output: &egui::text_edit::TextEditOutput) {
        let Some(cursor) = output.cursor_range else { return };
        let place = output.galley.pos_from_cursor(cursor.primary).translate(output.galley_pos.to_vec2());
        let area = egui::Area::new(ui.scope_id().with("names")).order(egui::Order::Foreground);
        let shown = area.fixed_pos(place.left_bottom()).constrain(true).show(ui.ctx(), |ui| {
            egui::Frame::popup(ui.style()).show(ui, |ui| {
                let first = self.marked.saturating_sub(ROWS - 1);
                for (index, name) in self.names.iter().enumerate().skip(first).take(ROWS) {
                    let row = ui.selectable_label(index == self.marked, egui::RichText::new(&name.label).monospace());
                    if row.clicked() {
                        self.clicked = Some(index);
                    }
                }
                if self.names.len() > ROWS {
                    ui.weak(format!("{} of {}", self.marked + 1, self.names.len()));
                }
                if let Some(name) = self.names.get(self.marked).filter(|name| !name.doc.is_empty()) {
                    ui.set_max_width(360.0);
                    ui.separator();
                    ui.weak(&name.doc);
                }
            });
        });
        self.is_hovered = shown.response.contains_pointer();
    }

    /// Handles the keys of the list before the text gets them. Returns the name to put into the text, and where.
    pub(crate) fn chosen(&mut self, ui: &Ui, has_focus: bool) -> Option<(Range<usize>, &str)> {
        if let Some(index) = self.clicked.take() {
            return Some((self.range.clone(), &self.names[index].insert));
        }
        if !has_focus {
            return None;
        }
        let pressed = |key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
        let count = self.names.len();
        if pressed(Key::ArrowDown) {
            self.marked = (self.marked + 1) % count;
        }
        if pressed(Key::ArrowUp) {
            self.marked = (self.marked + count - 1) % count;
        }
        (pressed(Key::Tab) || pressed(Key::Enter)).then(|| (self.range.clone(), &*self.names[self.marked].insert))
    }

    /// True while the cursor, a byte of the text, is in the word of the list.
    pub(crate) fn belongs_to(&self, cursor: Option<usize>, has_focus: bool) -> bool {
        let is_near = cursor.is_some_and(|at| self.range.start <= at && at <= self.at + 1);
        is_near && has_focus || self.clicked.is_some() || self.is_hovered
    }
}

/// A snippet without its marks, as in `sphere ${1:0.5}`.
fn plain(snippet: &str) -> String {
    let mut text = String::new();
    let mut rest = snippet;
    while let Some(at) = rest.find('$') {
        text += &rest[..at];
        rest = &rest[at + 1..];
        if let Some(inside) = rest.strip_prefix('{') {
            let (mark, after) = inside.split_once('}').unwrap_or((inside, ""));
            text += mark.split_once(':').map_or("", |(_, word)| word);
            rest = after;
        } else {
            rest = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        }
    }
    text + rest
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn snippets_lose_their_marks() {
        assert_eq!(plain("sphere ${1:0.5}"), "sphere 0.5");
        assert_eq!(plain("union {\n\t$0\n}"), "union {\n\t\n}");
        assert_eq!(plain("include \"$1\""), "include \"\"");
        assert_eq!(plain("radius=${1:}"), "radius=");
    }
}
