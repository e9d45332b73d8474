//! The same answers for a [`Document`], of which they read text, nodes and files.

use super::{Completions, Hover, OpenText, TextColour};
use crate::document::Document;

/// Names that fit at byte `at` of a document.
pub fn completions(document: &mut Document, at: usize) -> Completions {
    with_text(document, |text| text.completions(at))
}

/// Help on the word at byte `at` of a document.
pub fn hover(document: &mut Document, at: usize) -> Option<Hover> {
    with_text(document, |text| text.hover(at))
}

/// Colours that are written in a document.
pub fn colours(document: &mut Document) -> Vec<TextColour> {
    with_text(document, |text| text.colours())
}

/// Lends the files that a document has read to a text, so that none is read again.
fn with_text<T>(document: &mut Document, answer: impl FnOnce(&mut OpenText) -> T) -> T {
    let (file, values, assets) = document.lend();
    let mut text = OpenText {
        name: document.name().to_owned(),
        text: document.text().to_owned(),
        assets,
        file,
        values,
        mistakes: Vec::new(),
        refusal: None,
    };
    let answer = answer(&mut text);
    document.take_back(text.assets);
    answer
}
