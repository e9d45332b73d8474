//! Places in a text: bytes, characters, and the text cursor.

use egui::Ui;
use egui::text::{CCursor, CCursorRange};

/// Byte of a character of a text.
pub(crate) fn byte_of(text: &str, index: usize) -> usize {
    text.char_indices().nth(index).map_or(text.len(), |(byte, _)| byte)
}

/// Puts the text cursor of a field behind so many characters.
pub(crate) fn set_cursor(ui: &Ui, id: egui::Id, index: usize) {
    let mut state = egui::text_edit::TextEditState::load(ui.ctx(), id).unwrap_or_default();
    state.cursor.set_char_range(Some(CCursorRange::one(CCursor::new(index))));
    state.store(ui.ctx(), id);
}
