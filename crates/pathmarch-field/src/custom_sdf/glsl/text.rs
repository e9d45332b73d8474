//! Text for naga, with the place in the code from which each part comes.

use super::lexer::{Place, Token};
use std::ops::Range;

/// Text in which each part has a place in the code of the field.
#[derive(Debug, Default)]
pub(super) struct PlacedText {
    pub(super) text: String,
    /// Offsets in the text, rising, and the place of what starts there.
    pieces: Vec<(usize, Place)>,
}

impl PlacedText {
    /// Adds text that the code does not have.
    pub(super) fn add(&mut self, text: &str, at: Place) {
        self.pieces.push((self.text.len(), at));
        self.text.push_str(text);
    }

    pub(super) fn token(&mut self, token: &Token) {
        self.word(token, token.text);
    }

    /// Adds a word in the place of a token.
    pub(super) fn word(&mut self, token: &Token, word: &str) {
        self.add(word, token.at);
        self.text.push(if matches!(token.text, ";" | "{" | "}") { '\n' } else { ' ' });
    }

    pub(super) fn tokens(&mut self, tokens: &[Token]) {
        tokens.iter().for_each(|token| self.token(token));
    }

    /// Adds another text.
    pub(super) fn append(&mut self, other: &Self) {
        let offset = self.text.len();
        self.pieces.extend(other.pieces.iter().map(|(at, place)| (at + offset, *place)));
        self.text.push_str(&other.text);
    }

    /// Place in the code of a range of the text; `None` if the code has no part in it.
    pub(super) fn place(&self, range: &Range<usize>) -> Option<Range<usize>> {
        let first = self.pieces.partition_point(|(at, _)| *at <= range.start).checked_sub(1)?;
        let end = self.pieces.partition_point(|(at, _)| *at < range.end.max(range.start + 1));
        let mut places = self.pieces.get(first..end)?.iter().map(|(_, at)| *at).filter(|at| at.range().is_some());
        let start = places.next()?;
        places.next_back().map_or(start, |last| start.to(last)).range()
    }
}
