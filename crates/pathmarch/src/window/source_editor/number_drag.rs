//! Numbers of the text as sliders: Alt and a drag to the left or right.

use super::positions::byte_of;
use egui::{Sense, Ui};
use pathmarch_render::pathmarch_scene::language_service::{Token, TokenKind, highlight};
use std::ops::Range;

/// Points of a drag that change the last digit by one.
const POINTS_PER_STEP: f32 = 4.0;

/// Drag of a number of the text.
#[derive(Default)]
pub(crate) struct NumberDrag {
    dragged: Option<Dragged>,
}

struct Dragged {
    /// Bytes of the number now.
    range: Range<usize>,
    /// Value and decimals at the start.
    start: f64,
    decimals: usize,
    /// Distance so far, points.
    distance: f32,
}

impl NumberDrag {
    /// True while a number is dragged.
    pub(crate) fn is_active(&self) -> bool {
        self.dragged.is_some()
    }

    /// Changes the number under the pointer while Alt is held and the pointer dragged; returns true if it has changed.
    pub(crate) fn update(&mut self, ui: &Ui, output: &egui::text_edit::TextEditOutput, text: &mut String) -> bool {
        let alt = ui.input(|input| input.modifiers.alt);
        if !alt && self.dragged.is_none() {
            return false;
        }
        // Above the text, so that the drag selects nothing.
        let rect = output.response.rect.intersect(ui.clip_rect());
        let response = ui.interact(rect, output.response.id.with("numbers"), Sense::drag());
        if response.drag_started() {
            let at = ui.input(|input| input.pointer.press_origin());
            let index = at.map(|at| output.galley.cursor_from_pos(at - output.galley_pos).index);
            self.dragged = index.and_then(|index| number_at(text, byte_of(text, index.into())));
        }
        if response.hovered() {
            ui.set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        let is_over = response.drag_stopped() || !ui.input(|input| input.pointer.any_down());
        let changed = self.dragged.as_mut().is_some_and(|dragged| dragged.moved_by(response.drag_delta().x, text));
        if is_over {
            self.dragged = None;
        }
        changed
    }
}

impl Dragged {
    fn moved_by(&mut self, points: f32, text: &mut String) -> bool {
        self.distance += points;
        let steps = f64::from((self.distance / POINTS_PER_STEP).trunc());
        let value = self.start + steps * 10.0_f64.powi(-(self.decimals as i32));
        // Not -0.
        let value = if value.abs() < 0.5 * 10.0_f64.powi(-(self.decimals as i32)) { 0.0 } else { value };
        let written = format!("{value:.*}", self.decimals);
        if points == 0.0 || text.get(self.range.clone()).is_none_or(|now| now == written) {
            return false;
        }
        text.replace_range(self.range.clone(), &written);
        self.range.end = self.range.start + written.len();
        true
    }
}

/// The number at a byte of a text.
fn number_at(text: &str, at: usize) -> Option<Dragged> {
    let is_it = |token: &Token| token.kind == TokenKind::Number && token.range.start <= at && at <= token.range.end;
    let range = highlight(text).into_iter().find(is_it)?.range;
    let word = &text[range.clone()];
    // Numbers with exponents or another base have no last digit to change.
    let start: f64 = word.parse().ok().filter(|_| !word.contains(['e', 'E', '_']))?;
    let decimals = word.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    Some(Dragged { range, start, decimals, distance: 0.0 })
}
