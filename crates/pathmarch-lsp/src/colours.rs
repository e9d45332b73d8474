//! Colours of a text, for swatches and colour pickers.

use crate::positions::Lines;
use lsp_types::{Color, ColorInformation, ColorPresentation, Range, TextEdit};
use pathmarch_scene::language_service::{OpenText, display_colour, written_colours};

/// Every colour of a document. Radiance above 1 is shown as its hue.
pub(crate) fn colours(open: &OpenText) -> Vec<ColorInformation> {
    let lines = Lines::new(open.text());
    let shown = open.colours().into_iter().map(|colour| {
        let ([red, green, blue], _) = display_colour(colour.value);
        ColorInformation { range: lines.range(colour.range), color: Color { red, green, blue, alpha: 1.0 } }
    });
    shown.collect()
}

/// Ways to write a colour in a range. That of a radiance keeps its strength.
pub(crate) fn presentations(open: &OpenText, colour: Color, range: Range) -> Vec<ColorPresentation> {
    let bytes = Lines::new(open.text()).bytes(range);
    let old = open.colours().into_iter().find(|colour| colour.range == bytes);
    let scale = old.map_or(1.0, |old| display_colour(old.value).1);
    let ways = written_colours([colour.red, colour.green, colour.blue], scale);
    let presentation = |text: String| ColorPresentation {
        label: text.clone(),
        text_edit: Some(TextEdit::new(range, text)),
        additional_text_edits: None,
    };
    ways.into_iter().map(presentation).collect()
}
