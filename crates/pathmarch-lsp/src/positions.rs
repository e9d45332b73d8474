//! Bytes of a text as positions of the protocol: lines, and UTF-16 code units within them.

use lsp_types::{Position, Range};

/// Starts of the lines of a text.
pub(crate) struct Lines<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    /// Lines end with `\n`, `\r\n` or `\r`, as in the protocol.
    pub(crate) fn new(text: &'t str) -> Self {
        let bytes = text.as_bytes();
        let ends_line = |at: &usize| match bytes[*at] {
            b'\n' => true,
            b'\r' => bytes.get(at + 1) != Some(&b'\n'),
            _ => false,
        };
        let starts = std::iter::once(0).chain((0..bytes.len()).filter(ends_line).map(|at| at + 1)).collect();
        Self { text, starts }
    }
    /// Position of a byte; of the start of its character, if it is within one.
    pub(crate) fn position(&self, at: usize) -> Position {
        let at = self.text.floor_char_boundary(at);
        let line = self.starts.partition_point(|start| *start <= at) - 1;
        let units: usize = self.text[self.starts[line]..at].chars().map(char::len_utf16).sum();
        Position::new(line as u32, units as u32)
    }
    /// Positions of a range of bytes.
    pub(crate) fn range(&self, bytes: std::ops::Range<usize>) -> Range {
        Range::new(self.position(bytes.start), self.position(bytes.end))
    }
    /// Byte of a position. A position behind the end of its line is that end, one behind the text the end of the text.
    pub(crate) fn byte(&self, position: Position) -> usize {
        let Some(&start) = self.starts.get(position.line as usize) else { return self.text.len() };
        let end = self.starts.get(position.line as usize + 1).copied().unwrap_or(self.text.len());
        let line = self.text[start..end].trim_end_matches(['\r', '\n']);
        let mut units = 0;
        for (index, c) in line.char_indices() {
            units += c.len_utf16();
            if units > position.character as usize {
                return start + index;
            }
        }
        start + line.len()
    }
    /// Bytes of a range of positions.
    pub(crate) fn bytes(&self, range: Range) -> std::ops::Range<usize> {
        let start = self.byte(range.start);
        start..self.byte(range.end).max(start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn positions_count_utf_16_code_units() {
        let text = "aé𝄞b\r\n\u{feff}ü\rx\n";
        let lines = Lines::new(text);
        for (at, line, character) in [
            (0, 0, 0),
            (1, 0, 1),
            (3, 0, 2),
            (7, 0, 4),
            (8, 0, 5),
            (10, 1, 0),
            (13, 1, 1),
            (15, 1, 2),
            (16, 2, 0),
            (18, 3, 0),
        ] {
            assert_eq!(lines.position(at), Position::new(line, character), "byte {at}");
            assert_eq!(lines.byte(Position::new(line, character)), at);
        }
        assert_eq!(lines.byte(Position::new(0, 3)), 3, "within a surrogate pair");
        assert_eq!(lines.byte(Position::new(0, 99)), 8, "behind the line");
        assert_eq!(lines.byte(Position::new(99, 0)), text.len(), "behind the text");
    }

    proptest! {
        #[test]
        fn every_byte_comes_back(text in "[aé𝄞\r\n]{0,20}", at in 0..40_usize) {
            let at = text.floor_char_boundary(at.min(text.len()));
            // The end of a line and the place between its two characters are one position.
            prop_assume!(!(text[..at].ends_with('\r') && text[at..].starts_with('\n')));
            let lines = Lines::new(&text);
            prop_assert_eq!(lines.byte(lines.position(at)), at);
        }
    }
}
