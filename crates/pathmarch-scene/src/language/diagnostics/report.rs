//! Collector of mistakes and warnings.

use super::spelling::nearest;
use crate::diagnostic::{Mistake, SceneError};
use crate::language::characters::{forbidden_in, is_forbidden};
use crate::language::tree::Span;
use crate::source_text::SourceText;
use std::sync::Arc;

/// Largest number of mistakes that are kept; the others are only counted.
pub(crate) const KEPT: usize = 100;

/// Largest number of names that a mistake lists.
const MAX_EXPECTED: usize = 1000;

/// Mistakes and warnings of a scene so far.
pub(crate) struct Report {
    /// Use of a declared shape that is being expanded, and its label beside mistakes in the declaration.
    pub(crate) within: Option<(Span, String)>,
    name: String,
    /// The text and those that it includes, one behind the other.
    sources: Vec<Source>,
    /// Start of the text that is being parsed.
    base: u32,
    /// Byte whose mistakes are kept, however many there are.
    watched: Option<u32>,
    /// Mistakes, each with its start among all texts.
    mistakes: Vec<(u32, Mistake)>,
    warnings: Vec<(u32, Mistake)>,
    total: usize,
}

/// A text and its start among all texts.
struct Source {
    base: u32,
    bytes: u32,
    code: Arc<SourceText>,
}

impl Source {
    fn new(base: u32, name: &str, text: &str) -> Self {
        // What does not show, or would command a terminal, is printed as a mark of the same number of bytes.
        let visible = |c: char| match c.len_utf8() {
            _ if !is_forbidden(c) => c,
            1 => '?',
            _ => char::REPLACEMENT_CHARACTER,
        };
        let visible = match forbidden_in(text, 0).next() {
            None => text.to_owned(),
            Some(_) => text.chars().map(visible).collect(),
        };
        let code = Arc::new(SourceText::new(name, visible));
        Self { base, bytes: text.len() as u32, code }
    }
    /// Span within this text of a span among all texts.
    fn local(&self, span: Span) -> Span {
        Span { start: span.start - self.base, end: span.end - self.base }
    }
}

/// A diagnostic under construction, with spans among all texts.
#[must_use]
pub(crate) struct Draft {
    code: &'static str,
    span: Span,
    message: String,
    label: String,
    help: Option<String>,
    also: Option<(Span, String)>,
    expected: Vec<String>,
}

/// A mistake at `span`.
pub(crate) fn draft(code: &'static str, span: Span, message: impl Into<String>) -> Draft {
    Draft {
        code,
        span,
        message: message.into(),
        label: "here".to_owned(),
        help: None,
        also: None,
        expected: Vec::new(),
    }
}

impl Draft {
    /// Sets the label of the underlined text.
    pub(crate) fn label(self, label: impl Into<String>) -> Self {
        Self { label: label.into(), ..self }
    }
    /// Help: what to do, a sentence.
    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
    /// Names that would be right in place of a misspelt one.
    pub(crate) fn expected<'n>(self, names: impl IntoIterator<Item = &'n str>) -> Self {
        Self { expected: names.into_iter().take(MAX_EXPECTED).map(str::to_owned).collect(), ..self }
    }
    /// Adds a second place with a label.
    pub(crate) fn also(self, span: Span, label: impl Into<String>) -> Self {
        Self { also: Some((span, label.into())), ..self }
    }
}

impl Report {
    pub(crate) fn new(name: &str, text: &str) -> Self {
        let sources = vec![Source::new(0, name, text)];
        let (mistakes, warnings) = (Vec::new(), Vec::new());
        Self { within: None, name: name.to_owned(), sources, base: 0, watched: None, mistakes, warnings, total: 0 }
    }
    /// Keeps every mistake at a byte of the text.
    pub(crate) fn watching(self, at: u32) -> Self {
        Self { watched: Some(at), ..self }
    }
    /// Registers an included text; until [`Self::end`], spans are relative to it. Returns its start among all texts.
    pub(crate) fn begin(&mut self, name: &str, text: &str) -> u32 {
        // One byte apart, so that the end of one is not the beginning of the next.
        self.base = self.sources.last().map_or(0, |last| last.base + last.bytes + 1);
        self.sources.push(Source::new(self.base, name, text));
        self.base
    }
    /// Ends the included text: spans are among all texts again.
    pub(crate) fn end(&mut self) {
        self.base = 0;
    }
    /// Text that contains a span among all texts.
    fn source(&self, span: Span) -> &Source {
        let at = self.sources.partition_point(|source| source.base <= span.start);
        &self.sources[at.max(1) - 1]
    }
    fn finish(&self, draft: Draft, warning: bool) -> (u32, Mistake) {
        let among_all = |span: Span| Span { start: span.start + self.base, end: span.end + self.base };
        let span = among_all(draft.span);
        let source = self.source(span);
        let also = draft.also.map(|(span, label)| (among_all(span), label)).or_else(|| self.within.clone());
        let (mut shown, mut help) = (None, draft.help);
        if let Some((other, label)) = also {
            let place = self.source(other);
            let local = place.local(other);
            if place.base == source.base {
                shown = Some((local.into(), label));
            } else {
                // One report shows one file.
                let line = 1 + place.code.inner()[..local.start as usize].matches('\n').count();
                let more = format!("In {}, line {line}: {label}.", place.code.name());
                help = Some(help.map_or_else(|| more.clone(), |help| format!("{help} {more}")));
            }
        }
        let local = source.local(span);
        let word = source.code.inner().get(local.start as usize..local.end as usize).unwrap_or_default();
        let suggestion = nearest(word.trim_matches('"'), draft.expected.iter().map(String::as_str));
        let mistake = Mistake {
            suggestion: suggestion.map(str::to_owned),
            message: draft.message,
            code: draft.code,
            label: draft.label,
            help,
            span: local.into(),
            also: shown,
            expected: draft.expected,
            warning,
            source_code: source.code.clone(),
        };
        (span.start, mistake)
    }
    /// Text that contains a span, as it is shown, with marks for invisible characters; and its start among all texts.
    pub(crate) fn text_at(&self, span: Span) -> (&str, usize) {
        let source = self.source(span);
        (source.code.inner(), source.base as usize)
    }
    /// Number of mistakes so far.
    pub(crate) fn count_so_far(&self) -> usize {
        self.total
    }
    /// Adds a mistake. The same mistake at the same place is added once, however often a declaration is expanded.
    pub(crate) fn add(&mut self, draft: Draft) {
        let same = |(start, mistake): &(u32, Mistake)| *start == draft.span.start && mistake.message == draft.message;
        if self.within.is_some() && self.mistakes.iter().any(same) {
            return;
        }
        self.total += 1;
        let is_watched = self.watched.is_some_and(|at| draft.span.start <= at && at < draft.span.end);
        if self.mistakes.len() < KEPT || is_watched {
            let mistake = self.finish(draft, false);
            self.mistakes.push(mistake);
        }
    }
    /// Counts a mistake without keeping it.
    pub(crate) fn count(&mut self) {
        self.total += 1;
    }
    /// True if no more mistakes are kept.
    pub(crate) fn is_full(&self) -> bool {
        self.mistakes.len() >= KEPT && self.watched.is_none()
    }
    /// Adds a warning.
    pub(crate) fn warn(&mut self, draft: Draft) {
        if self.warnings.len() < KEPT {
            let warning = self.finish(draft, true);
            self.warnings.push(warning);
        }
    }
    /// True if there is any mistake so far.
    pub(crate) fn has_mistakes(&self) -> bool {
        self.total > 0
    }
    /// Returns the warnings in the order of the file.
    pub(crate) fn into_warnings(mut self) -> Vec<Mistake> {
        self.warnings.sort_by_key(|(start, _)| *start);
        self.warnings.into_iter().map(|(_, warning)| warning).collect()
    }
    /// Returns the mistakes in the order of the file.
    pub(crate) fn into_error(mut self) -> SceneError {
        self.mistakes.sort_by_key(|(start, _)| *start);
        let mistakes = self.mistakes.into_iter().map(|(_, mistake)| mistake).collect();
        SceneError::Mistakes { name: self.name, total: self.total, mistakes }
    }
}

/// Name as messages show it: in backquotes, shortened, without control characters.
pub(crate) fn shown(name: &str) -> String {
    let mut short: String = name.chars().take(40).flat_map(char::escape_debug).collect();
    if name.chars().nth(40).is_some() {
        short.push('…');
    }
    format!("`{}`", short.replace("\\\"", "\"").replace("\\'", "'"))
}
