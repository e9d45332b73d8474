//! Collects the mistakes of a file.

use super::characters::is_forbidden;
use super::scope::Scope;
use super::tree::Span;
use crate::diagnostic::{Mistake, SceneError};
use miette::NamedSource;
use std::sync::Arc;

/// More mistakes than this are counted, not kept: nobody reads them, and printing each costs a walk over the file.
pub(crate) const KEPT: usize = 100;

/// The mistakes of a file so far, and what its formulas may name.
pub(crate) struct Report {
    pub(crate) scope: Scope,
    name: String,
    source: Arc<NamedSource<String>>,
    mistakes: Vec<Mistake>,
    warnings: Vec<Mistake>,
    total: usize,
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
        // What does not show, or would command a terminal, is printed as a mark of the same number of bytes.
        let visible = |c: char| match c.len_utf8() {
            _ if !is_forbidden(c) => c,
            1 => '?',
            _ => char::REPLACEMENT_CHARACTER,
        };
        let source = Arc::new(NamedSource::new(name, text.chars().map(visible).collect()));
        let (mistakes, warnings) = (Vec::new(), Vec::new());
        Self { scope: Scope::default(), name: name.to_owned(), source, mistakes, warnings, total: 0 }
    }
    fn finish(&self, draft: Draft, warning: bool) -> Mistake {
        Mistake {
            message: draft.message,
            code: draft.code,
            label: draft.label,
            help: draft.help,
            span: draft.span.into(),
            also: draft.also.map(|(span, label)| (span.into(), label)),
            warning,
            source_code: self.source.clone(),
        }
    }
    /// The text as it is shown: with marks for what does not show.
    pub(crate) fn text(&self) -> &str {
        self.source.inner()
    }
    /// How many mistakes there are so far.
    pub(crate) fn count_so_far(&self) -> usize {
        self.total
    }
    /// A mistake.
    pub(crate) fn add(&mut self, draft: Draft) {
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
        self.warnings.sort_by_key(|warning| warning.span.offset());
        self.warnings
    }
    /// The mistakes, in the order of the file.
    pub(crate) fn into_error(mut self) -> SceneError {
        self.mistakes.sort_by_key(|mistake| mistake.span.offset());
        SceneError::Mistakes { name: self.name, total: self.total, mistakes: self.mistakes }
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
