//! Margin of the text: line numbers, marks of mistakes with their words, swatches of colours.

use super::coloured_text::ColouredText;
use egui::text::CCursor;
use egui::{Color32, Rect, Sense, Ui, Vec2};
use pathmarch_render::pathmarch_scene::Mistake;
use pathmarch_render::pathmarch_scene::document::Document;
use pathmarch_render::pathmarch_scene::language_service::{TextColour, display_colour, in_document, written_colours};
use std::ops::Range;

/// Width of the marks beside the line numbers, points.
const MARKS: f32 = 26.0;

/// Margin with the colours of a text and its revision.
#[derive(Default)]
pub(crate) struct Margin {
    revision: Option<u64>,
    colours: Vec<(TextColour, Place)>,
    mistakes: Vec<(usize, Place)>,
}

/// Ends of a range of the text.
#[derive(Clone, Copy)]
struct Place {
    /// Line of its start, from 0.
    line: usize,
    /// Characters before its ends.
    start: usize,
    end: usize,
}

/// Finds ranges of a text in its order.
struct Finder<'t> {
    text: &'t str,
    byte: usize,
    line: usize,
    characters: usize,
}

impl Finder<'_> {
    fn place(&mut self, from: usize, to: usize) -> Place {
        if from < self.byte {
            (self.byte, self.line, self.characters) = (0, 0, 0);
        }
        let passed = self.text.get(self.byte..from).unwrap_or_default();
        self.line += passed.matches('\n').count();
        self.characters += passed.chars().count();
        self.byte += passed.len();
        let length = self.text.get(from..to).map_or(0, |part| part.chars().count());
        Place { line: self.line, start: self.characters, end: self.characters + length }
    }
}

impl Margin {
    /// Takes the space of the margin and draws the line numbers.
    pub(crate) fn space(ui: &mut Ui, coloured: &ColouredText) -> Rect {
        let Some(numbers) = coloured.numbers.clone() else { return Rect::NOTHING };
        let (rect, _) = ui.allocate_exact_size(numbers.size() + Vec2::new(MARKS, 0.0), Sense::hover());
        ui.painter().galley(rect.min, numbers, ui.visuals().weak_text_color());
        rect
    }

    /// Draws the marks; returns true if a colour of the text was changed.
    pub(crate) fn show(
        &mut self,
        ui: &mut Ui,
        margin: Rect,
        output: &egui::text_edit::TextEditOutput,
        document: &mut Document,
        text: &mut String,
    ) -> bool {
        // A text that has just been typed is not read yet.
        if document.text() != text.as_str() {
            return false;
        }
        let mistakes = mistakes_of(document);
        let revision = document.revision();
        if self.revision != Some(revision) {
            let start = || Finder { text, byte: 0, line: 0, characters: 0 };
            let mut finder = start();
            let ours = mistakes.iter().enumerate().filter(|(_, mistake)| mistake.source_code.name() == document.name());
            let place = |(index, mistake): (usize, &Mistake)| {
                let from = mistake.span.offset();
                (index, finder.place(from, from + mistake.span.len()))
            };
            self.mistakes = ours.map(place).collect();
            let mut finder = start();
            let colours = in_document::colours(document).into_iter();
            self.colours = colours
                .map(|colour| {
                    let Range { start, end } = colour.range;
                    (colour, finder.place(start, end))
                })
                .collect();
            self.revision = Some(revision);
        }
        let mistakes = mistakes_of(document);
        let clip = ui.clip_rect().y_range();
        let offset = output.galley_pos.to_vec2();
        let is_seen = |place: &Place| {
            output
                .galley
                .rows
                .get(place.line)
                .is_some_and(|row| clip.intersects(row.rect().translate(offset).y_range()))
        };
        let cursor = |index: usize| output.galley.pos_from_cursor(CCursor::new(index)).translate(offset);
        for (index, place) in self.mistakes.iter().filter(|(_, place)| is_seen(place)) {
            let Some(mistake) = mistakes.get(*index) else { continue };
            let row = cursor(place.start);
            let colour = if mistake.warning { ui.visuals().warn_fg_color } else { ui.visuals().error_fg_color };
            let end = cursor(place.end);
            let line = if end.min.y > row.min.y { row.min.x + 12.0 } else { end.min.x.max(row.min.x + 4.0) };
            ui.painter().hline(row.min.x..=line, row.max.y, (1.5, colour));
            let mark = Rect::from_center_size(egui::pos2(margin.max.x - 6.0, row.center().y), Vec2::splat(12.0));
            ui.painter().circle_filled(mark.center(), 4.0, colour);
            let words =
                [&mistake.message, &mistake.label].into_iter().chain(&mistake.help).filter(|words| !words.is_empty());
            let words = words.cloned().collect::<Vec<_>>().join("\n");
            let response = ui.interact(mark, output.response.id.with(("mistake", *index)), Sense::hover());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &mistake.message));
            response.on_hover_text(words);
        }
        let mut change = None;
        let mut last_row = f32::NEG_INFINITY;
        for (index, (colour, place)) in self.colours.iter().enumerate().filter(|(_, (_, place))| is_seen(place)) {
            let row = cursor(place.start);
            let ([r, g, b], scale) = display_colour(colour.value);
            let [r, g, b] = [r, g, b].map(|channel| (channel * 255.0).round() as u8);
            let shown = Color32::from_rgb(r, g, b);
            let end = cursor(place.end);
            ui.painter().hline(row.min.x..=end.min.x, row.max.y - 0.5, (2.5, shown));
            // The margin has room for the first colour of a line.
            if row.min.y > last_row {
                last_row = row.min.y;
                let swatch =
                    Rect::from_center_size(egui::pos2(margin.max.x - 18.0, row.center().y), Vec2::new(10.0, 11.0));
                ui.painter().rect(
                    swatch,
                    2.0,
                    shown,
                    ui.visuals().widgets.inactive.fg_stroke,
                    egui::StrokeKind::Inside,
                );
                let response = ui.interact(swatch, output.response.id.with(("swatch", index)), Sense::click());
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColorWell, true, "Colour in the text"));
                let response = response.on_hover_text("Click to change the colour.");
                let mut picked = shown;
                let popup = egui::Popup::menu(&response).close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside);
                popup.show(|ui| {
                    ui.spacing_mut().slider_width = 200.0;
                    egui::color_picker::color_picker_color32(ui, &mut picked, egui::color_picker::Alpha::Opaque);
                });
                if picked != shown {
                    let channels = [picked.r(), picked.g(), picked.b()].map(|channel| f32::from(channel) / 255.0);
                    change = Some((colour.range.clone(), channels, scale));
                }
            }
        }
        let Some((range, channels, scale)) = change else { return false };
        let is_string = text[range.clone()].starts_with('"');
        let ways = written_colours(channels, scale);
        let written = ways.iter().find(|way| way.starts_with('"') == is_string).or(ways.first());
        let Some(written) = written.filter(|written| text[range.clone()] != ***written) else { return false };
        text.replace_range(range, written);
        true
    }
}

fn mistakes_of(document: &Document) -> &[Mistake] {
    match document.scene() {
        Ok(scene) => &scene.warnings,
        Err(error) => error.mistakes(),
    }
}
