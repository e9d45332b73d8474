//! Diagnostics of scene files: what is wrong, where, what was expected, and the nearest correct name.
//!
//! The shape of the report is miette's: one [`SceneError`] for a file, its [`Mistake`]s as related diagnostics, each
//! with the text it complains of underlined. Printing is the caller's business.

use crate::source_text::SourceText;
use miette::{Diagnostic, SourceSpan};
use std::sync::Arc;
use thiserror::Error;

/// One thing wrong in a scene file, or a warning of something odd.
#[derive(Clone, Debug, Error)]
#[error("{message}")]
pub struct Mistake {
    /// One sentence: what is wrong.
    pub message: String,
    /// Stable name, as in `pathmarch::unknown_node`.
    pub code: &'static str,
    /// Label of the underlined text: what is wrong, or what was expected.
    pub label: String,
    /// Help: what to do.
    pub help: Option<String>,
    /// Bytes of the text to underline.
    pub span: SourceSpan,
    /// A second place with a label, such as the first of two nodes with the same name.
    pub also: Option<(SourceSpan, String)>,
    /// Names that would be right in place of a misspelt one, a thousand at most.
    pub expected: Vec<String>,
    /// The one of them that is nearest to the misspelt name, if any is near.
    pub suggestion: Option<String>,
    /// True for a warning.
    pub warning: bool,
    /// Name and text of the file.
    pub source_code: Arc<SourceText>,
}

impl Diagnostic for Mistake {
    fn code<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        Some(Box::new(self.code))
    }
    fn severity(&self) -> Option<miette::Severity> {
        Some(if self.warning { miette::Severity::Warning } else { miette::Severity::Error })
    }
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn std::fmt::Display>)
    }
    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        Some(&*self.source_code)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = miette::LabeledSpan> + '_>> {
        let label = |primary: bool, span: SourceSpan, text: &str| {
            let text = (!text.is_empty()).then(|| text.to_owned());
            let span = self.source_code.shown_part(span);
            if primary {
                miette::LabeledSpan::new_primary_with_span(text, span)
            } else {
                miette::LabeledSpan::new_with_span(text, span)
            }
        };
        let also = self.also.as_ref().map(|(span, text)| label(false, *span, text));
        Some(Box::new(std::iter::once(label(true, self.span, &self.label)).chain(also)))
    }
}

/// Everything wrong with a scene file, in the order of the file.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The text has mistakes.
    #[error("{}", count_in_words(.name, *.total, .mistakes.len()))]
    Mistakes {
        /// Path or name of the text.
        name: String,
        /// Number of mistakes.
        total: usize,
        /// The first hundred of them at most, in the order of the file.
        mistakes: Vec<Mistake>,
    },
    /// There is no text to look at.
    #[error("cannot read the scene {name}: {reason}")]
    Unreadable {
        /// Path of the file.
        name: String,
        /// Reason, a sentence without a full stop.
        reason: String,
        /// Help: what to do.
        help: String,
    },
}

fn count_in_words(name: &str, total: usize, kept: usize) -> String {
    match (total, total > kept) {
        (1, _) => format!("{name} has 1 mistake"),
        (_, false) => format!("{name} has {total} mistakes"),
        (_, true) => format!("{name} has {total} mistakes, of which {kept} are shown"),
    }
}

impl SceneError {
    /// The mistakes of the text; none when it could not be read.
    pub fn mistakes(&self) -> &[Mistake] {
        match self {
            Self::Mistakes { mistakes, .. } => mistakes,
            Self::Unreadable { .. } => &[],
        }
    }
}

impl Diagnostic for SceneError {
    fn code<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        match self {
            Self::Mistakes { .. } => Some(Box::new("pathmarch::scene")),
            Self::Unreadable { .. } => Some(Box::new("pathmarch::unreadable")),
        }
    }
    fn help<'a>(&'a self) -> Option<Box<dyn std::fmt::Display + 'a>> {
        match self {
            Self::Mistakes { .. } => None,
            Self::Unreadable { help, .. } => Some(Box::new(help)),
        }
    }
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        match self {
            Self::Mistakes { mistakes, .. } => Some(Box::new(mistakes.iter().map(|m| m as &dyn Diagnostic))),
            Self::Unreadable { .. } => None,
        }
    }
}
