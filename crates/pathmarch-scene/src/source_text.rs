//! Text of a scene as diagnostics quote it.
//!
//! A report quotes whole lines, and a hundred mistakes in one line of 16 MB would print it a hundred times. Of a long
//! line only the part around the mistake is quoted.

use memchr::{memchr, memchr_iter, memrchr};
use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// Longest line that is quoted as a whole, bytes.
const MAX_LINE: usize = 400;
/// Bytes of a longer line that are quoted before and after the start of a mistake.
const AROUND: usize = 80;

/// Name and text of a scene file.
#[derive(Clone, Debug)]
pub struct SourceText {
    name: String,
    text: String,
}

impl SourceText {
    /// Text of the file of this name.
    pub fn new(name: impl Into<String>, text: String) -> Self {
        Self { name: name.into(), text }
    }
    /// Path or name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// The text.
    pub fn inner(&self) -> &str {
        &self.text
    }

    /// Bytes of the line that contains `at`, without its end.
    fn line(&self, at: usize) -> (usize, usize) {
        let bytes = self.text.as_bytes();
        let at = at.min(bytes.len());
        let start = memrchr(b'\n', &bytes[..at]).map_or(0, |end| end + 1);
        let end = memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |length| at + length);
        (start, end)
    }

    /// Quoted part of the line that contains `at`; `None` if the line is short.
    fn excerpt(&self, at: usize) -> Option<(usize, usize)> {
        let (start, end) = self.line(at);
        let boundary = |at: usize| (0..=at).rev().find(|at| self.text.is_char_boundary(*at)).unwrap_or(0);
        let cut = || (boundary(at.saturating_sub(AROUND)).max(start), boundary(end.min(at + AROUND)));
        (end - start > MAX_LINE).then(cut)
    }

    /// Part of a span that is underlined: all of it unless it has a long line, else no more than its first line.
    pub(crate) fn shown_part(&self, span: SourceSpan) -> SourceSpan {
        let (start, first_end) = self.line(span.offset());
        let (_, end) = self.line(span.offset() + span.len().saturating_sub(1));
        let end = match self.excerpt(span.offset()) {
            Some((_, end)) => end,
            None if self.text[start..end].lines().any(|line| line.len() > MAX_LINE) => first_end,
            None => return span,
        };
        (span.offset(), span.len().min(end.saturating_sub(span.offset()))).into()
    }
}

impl SourceCode for SourceText {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let name = self.name.clone();
        // A span of several lines may end in a long one.
        let last = span.offset() + span.len().saturating_sub(1);
        let neighbours_are_short = || {
            let (start, _) = self.line(span.offset());
            let (_, end) = self.line(last);
            self.excerpt(start.saturating_sub(1)).is_none() && self.excerpt(end + 1).is_none()
        };
        if self.excerpt(span.offset()).is_none() && self.excerpt(last).is_none() {
            let [before, after] = if neighbours_are_short() { [lines_before, lines_after] } else { [0, 0] };
            let contents = self.text.read_span(span, before, after)?;
            let (data, line, column) = (contents.data(), contents.line(), contents.column());
            let (span, count) = (*contents.span(), contents.line_count());
            return Ok(Box::new(MietteSpanContents::new_named(name, data, span, line, column, count)));
        }
        let (start, end) = self.excerpt(span.offset()).unwrap_or_else(|| self.line(span.offset()));
        let line = memchr_iter(b'\n', &self.text.as_bytes()[..start]).count();
        let (line_start, _) = self.line(span.offset());
        // Without lines around it, miette asks where the mistake is.
        let first = if lines_before == 0 { span.offset().min(end) } else { start };
        let data = &self.text.as_bytes()[start..end];
        let span = (start, end - start).into();
        Ok(Box::new(MietteSpanContents::new_named(name, data, span, line, first - line_start, 1)))
    }
}
