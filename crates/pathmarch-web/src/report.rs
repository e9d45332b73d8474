//! Mistakes of a text, for the page.

use pathmarch_render::pathmarch_scene::{Mistake, Scene, SceneError};
use serde::Serialize;

/// Mistake or warning.
#[derive(Serialize)]
pub(crate) struct Report<'a> {
    message: &'a str,
    label: &'a str,
    help: Option<&'a str>,
    /// Start and end in the text, UTF-16 units, as JavaScript counts.
    span: [usize; 2],
    /// Line, from 1.
    line: usize,
    warning: bool,
}

impl<'a> Report<'a> {
    fn new(text: &str, mistake: &'a Mistake) -> Self {
        let start = mistake.span.offset();
        let [from, to] = [start, start + mistake.span.len()].map(|byte| utf16_offset(text, byte));
        let line = 1 + text.bytes().take(start).filter(|byte| *byte == b'\n').count();
        let Mistake { message, label, help, warning, .. } = mistake;
        Self { message, label, help: help.as_deref(), span: [from, to], line, warning: *warning }
    }

    /// What hinders a text from being read at all.
    fn unreadable(reason: &'a str, help: &'a str) -> Self {
        Self { message: reason, label: "", help: Some(help), span: [0, 0], line: 1, warning: false }
    }
}

/// Mistakes of a text, or the warnings of its scene.
pub(crate) fn reports<'a>(text: &str, read: Result<&'a Scene, &'a SceneError>) -> Vec<Report<'a>> {
    match read {
        Ok(scene) => scene.warnings.iter().map(|warning| Report::new(text, warning)).collect(),
        Err(SceneError::Mistakes { mistakes, .. }) => {
            mistakes.iter().map(|mistake| Report::new(text, mistake)).collect()
        }
        Err(SceneError::Unreadable { reason, help, .. }) => vec![Report::unreadable(reason, help)],
    }
}

/// Number of UTF-16 units before a byte of a text.
fn utf16_offset(text: &str, byte: usize) -> usize {
    let characters = text.char_indices().take_while(|(at, _)| *at < byte);
    characters.map(|(_, character)| character.len_utf16()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_as_javascript_does() {
        assert_eq!(utf16_offset("a\u{1F600}é b", 8), 5);
        assert_eq!(utf16_offset("ab", 7), 2);
    }
}
