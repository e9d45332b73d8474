//! Collects the mistakes of a file.

use crate::diagnostic::{Mistake, SceneError};
use crate::language::characters::is_forbidden;
use crate::language::tree::Span;
use miette::NamedSource;
use std::sync::Arc;

/// More mistakes than this are counted, not kept: nobody reads them, and printing each costs a walk over the file.
pub(crate) const KEPT: usize = 100;

/// Mistakes and warnings of a scene so far.
pub(crate) struct Report {
    /// What is being expanded, and what to say of it beside mistakes in what it is made of.
    pub(crate) within: Option<(Span, String)>,
    name: String,
    /// The text and those that it includes, one behind the other.
    sources: Vec<Source>,
    /// Where the text begins that is being read.
    base: u32,
    /// With the place among all texts.
    mistakes: Vec<(u32, Mistake)>,
    warnings: Vec<(u32, Mistake)>,
    total: usize,
}

/// A text and where it begins among all.
struct Source {
    base: u32,
    bytes: u32,
    code: Arc<NamedSource<String>>,
}

impl Source {
    fn new(base: u32, name: &str, text: &str) -> Self {
        // What does not show, or would command a terminal, is printed as a mark of the same number of bytes.
        let visible = |c: char| match c.len_utf8() {
            _ if !is_forbidden(c) => c,
            1 => '?',
            _ => char::REPLACEMENT_CHARACTER,
        };
        let code = Arc::new(NamedSource::new(name, text.chars().map(visible).collect()));
        Self { base, bytes: text.len() as u32, code }
    }
    /// A place among all texts as one of this.
    fn local(&self, span: Span) -> Span {
        Span { start: span.start - self.base, end: span.end - self.base }
    }
}

/// A mistake before it has found its file.
#[must_use]
pub(crate) struct Draft {
    code: &'static str,
    span: Span,
    message: String,
    label: String,
    help: Option<String>,
    also: Option<(Span, String)>,
}

/// A mistake at `span`.
pub(crate) fn draft(code: &'static str, span: Span, message: impl Into<String>) -> Draft {
    Draft { code, span, message: message.into(), label: "here".to_owned(), help: None, also: None }
}

impl Draft {
    /// What stands at the underlined text, or was expected there.
    pub(crate) fn label(self, label: impl Into<String>) -> Self {
        Self { label: label.into(), ..self }
    }
    /// What to do about it, a sentence.
    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
    /// Another place to show.
    pub(crate) fn also(self, span: Span, label: impl Into<String>) -> Self {
        Self { also: Some((span, label.into())), ..self }
    }
}

impl Report {
    pub(crate) fn new(name: &str, text: &str) -> Self {
        let sources = vec![Source::new(0, name, text)];
        let (mistakes, warnings) = (Vec::new(), Vec::new());
        Self { within: None, name: name.to_owned(), sources, base: 0, mistakes, warnings, total: 0 }
    }
    /// Begins with a text that is included, of which places are told from its own beginning; says where that is among all.
    pub(crate) fn begin(&mut self, name: &str, text: &str) -> u32 {
        // One byte apart, so that the end of one is not the beginning of the next.
        self.base = self.sources.last().map_or(0, |last| last.base + last.bytes + 1);
        self.sources.push(Source::new(self.base, name, text));
        self.base
    }
    /// Says that its form has been read: places are told among all texts again.
    pub(crate) fn end(&mut self) {
        self.base = 0;
    }
    /// The text of a place among all.
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
        let mistake = Mistake {
            message: draft.message,
            code: draft.code,
            label: draft.label,
            help,
            span: source.local(span).into(),
            also: shown,
            warning,
            source_code: source.code.clone(),
        };
        (span.start, mistake)
    }
    /// The text of a place, as it is shown, with marks for what does not show; and where it begins among all.
    pub(crate) fn text_at(&self, span: Span) -> (&str, usize) {
        let source = self.source(span);
        (source.code.inner(), source.base as usize)
    }
    /// How many mistakes there are so far.
    pub(crate) fn count_so_far(&self) -> usize {
        self.total
    }
    /// A mistake; the same at the same place is told once, however often it is expanded.
    pub(crate) fn add(&mut self, draft: Draft) {
        let same = |(start, mistake): &(u32, Mistake)| *start == draft.span.start && mistake.message == draft.message;
        if self.within.is_some() && self.mistakes.iter().any(same) {
            return;
        }
        self.total += 1;
        if self.mistakes.len() < KEPT {
            let mistake = self.finish(draft, false);
            self.mistakes.push(mistake);
        }
    }
    /// A mistake too many to be kept.
    pub(crate) fn count(&mut self) {
        self.total += 1;
    }
    /// Whether no more mistakes are kept.
    pub(crate) fn is_full(&self) -> bool {
        self.mistakes.len() == KEPT
    }
    /// Something allowed that is most likely not meant.
    pub(crate) fn warn(&mut self, draft: Draft) {
        if self.warnings.len() < KEPT {
            let warning = self.finish(draft, true);
            self.warnings.push(warning);
        }
    }
    /// Whether there is any mistake so far.
    pub(crate) fn has_mistakes(&self) -> bool {
        self.total > 0
    }
    /// The warnings, in the order of the file.
    pub(crate) fn into_warnings(mut self) -> Vec<Mistake> {
        self.warnings.sort_by_key(|(start, _)| *start);
        self.warnings.into_iter().map(|(_, warning)| warning).collect()
    }
    /// The mistakes, in the order of the file.
    pub(crate) fn into_error(mut self) -> SceneError {
        self.mistakes.sort_by_key(|(start, _)| *start);
        let mistakes = self.mistakes.into_iter().map(|(_, mistake)| mistake).collect();
        SceneError::Mistakes { name: self.name, total: self.total, mistakes }
    }
}

/// A name as shown in a message: in backquotes, not too long, no control characters.
pub(crate) fn shown(name: &str) -> String {
    let mut short: String = name.chars().take(40).flat_map(char::escape_debug).collect();
    if name.chars().nth(40).is_some() {
        short.push('…');
    }
    format!("`{}`", short.replace("\\\"", "\"").replace("\\'", "'"))
}
