//! Quick fixes: the nearest correct name, and the version that a scene starts with.

use crate::positions::Lines;
use lsp_types::{CodeAction, CodeActionKind, CodeActionOrCommand, Range, TextEdit, Uri, WorkspaceEdit};
use pathmarch_scene::Mistake;
use pathmarch_scene::language_service::OpenText;
use std::collections::HashMap;

/// Fixes of the mistakes that touch a range of a document.
pub(crate) fn actions(uri: &Uri, open: &OpenText, range: Range) -> Vec<CodeActionOrCommand> {
    let lines = Lines::new(open.text());
    let asked = lines.bytes(range);
    let touches = |mistake: &&Mistake| {
        let (start, end) = (mistake.span.offset(), mistake.span.offset() + mistake.span.len());
        mistake.source_code.name() == open.name() && start <= asked.end && asked.start <= end
    };
    open.mistakes().iter().filter(touches).filter_map(|mistake| fix(uri, open.text(), &lines, mistake)).collect()
}

fn fix(uri: &Uri, text: &str, lines: &Lines, mistake: &Mistake) -> Option<CodeActionOrCommand> {
    let (title, edit) = match &mistake.suggestion {
        Some(name) => (format!("Change to `{name}`"), renaming(text, lines, mistake, name)?),
        None if mistake.code == "pathmarch::version" && mistake.also.is_none() && !text.contains("pathmarch ") => {
            let start = text.len() - text.trim_start_matches('\u{feff}').len();
            let edit = TextEdit::new(lines.range(start..start), "pathmarch 1\n".to_owned());
            ("Insert `pathmarch 1`".to_owned(), edit)
        }
        None => return None,
    };
    // Keys of this type are compared by their text, which never changes.
    #[allow(clippy::mutable_key_type)]
    let changes = HashMap::from([(uri.clone(), vec![edit])]);
    let edit = WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() };
    let kind = Some(CodeActionKind::QUICKFIX);
    let action = CodeAction { title, kind, edit: Some(edit), is_preferred: Some(true), ..CodeAction::default() };
    Some(CodeActionOrCommand::CodeAction(action))
}

/// The correct name in place of the misspelt one, in quotes where that has them or where it needs them.
fn renaming(text: &str, lines: &Lines, mistake: &Mistake, name: &str) -> Option<TextEdit> {
    let bytes = mistake.span.offset()..mistake.span.offset() + mistake.span.len();
    let written = text.get(bytes.clone())?;
    let is_bare = name.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '#'));
    let new = if written.starts_with('"') || !is_bare { quoted(name) } else { name.to_owned() };
    Some(TextEdit::new(lines.range(bytes), new))
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('\\', "\\\\").replace('"', "\\\""))
}
