//! Mistakes of scenes as diagnostics, each at the file that contains it.

use crate::files::uri_of;
use crate::positions::Lines;
use lsp_types::{Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString, Range, Uri};
use pathmarch_scene::Mistake;
use pathmarch_scene::language_service::OpenText;
use std::collections::BTreeMap;
use std::path::Path;

/// Diagnostics by the URI of their file.
pub(crate) type ByFile = BTreeMap<String, Vec<Diagnostic>>;

/// Diagnostics of a document and of the files that it includes; those of the document may be none.
pub(crate) fn diagnostics(uri: &Uri, open: &OpenText) -> ByFile {
    let mut found = ByFile::from([(uri.as_str().to_owned(), Vec::new())]);
    for mistake in open.mistakes() {
        let name = mistake.source_code.name();
        let file = if name == open.name() { Some(uri.clone()) } else { uri_of(Path::new(name)) };
        let file = file.unwrap_or_else(|| uri.clone());
        let diagnostic = diagnostic(&file, mistake);
        found.entry(file.as_str().to_owned()).or_default().push(diagnostic);
    }
    if let Some((reason, help)) = open.refusal() {
        let message = format!("This text cannot be read: {reason}. {help}");
        let refusal = Diagnostic::new_simple(Range::default(), message);
        found.entry(uri.as_str().to_owned()).or_default().push(Diagnostic { source: source(), ..refusal });
    }
    found
}

fn source() -> Option<String> {
    Some("pathmarch".to_owned())
}

fn diagnostic(file: &Uri, mistake: &Mistake) -> Diagnostic {
    let lines = Lines::new(mistake.source_code.inner());
    let range = |span: miette::SourceSpan| lines.range(span.offset()..span.offset() + span.len());
    let severity = if mistake.warning { DiagnosticSeverity::WARNING } else { DiagnosticSeverity::ERROR };
    let label = Some(&mistake.label).filter(|label| !label.is_empty() && *label != "here");
    let label = label.map_or_else(String::new, |label| format!(" ({label})"));
    let help = mistake.help.as_ref().map_or_else(String::new, |help| format!("\n{help}"));
    let also = mistake.also.as_ref().map(|(span, message)| {
        let location = Location::new(file.clone(), range(*span));
        vec![DiagnosticRelatedInformation { location, message: message.clone() }]
    });
    Diagnostic {
        range: range(mistake.span),
        severity: Some(severity),
        code: Some(NumberOrString::String(mistake.code.to_owned())),
        source: source(),
        message: format!("{}{label}{help}", mistake.message),
        related_information: also,
        ..Diagnostic::default()
    }
}
