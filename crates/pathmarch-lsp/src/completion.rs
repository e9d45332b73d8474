//! Completion and help.

use crate::positions::Lines;
use lsp_types::{
    CompletionItem, CompletionItemKind, CompletionTextEdit, Documentation, Hover, HoverContents, InsertTextFormat,
    MarkupContent, MarkupKind, Position, TextEdit,
};
use pathmarch_scene::language_service::{Completion, CompletionKind, OpenText};
use pathmarch_scene::reference::Entry;

fn markdown(value: String) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value }
}

/// Names that fit a position. Without `snippets`, the editor inserts text as it is.
pub(crate) fn completions(open: &mut OpenText, position: Position, snippets: bool) -> Vec<CompletionItem> {
    let at = Lines::new(open.text()).byte(position);
    let found = open.completions(at);
    let range = Lines::new(open.text()).range(found.range);
    let item = |completion: Completion| {
        let new_text = inserted(&completion, snippets);
        let is_snippet = snippets && matches!(completion.kind, CompletionKind::Node | CompletionKind::Property);
        CompletionItem {
            kind: Some(kind(completion.kind)),
            detail: completion.help.as_ref().map(|help| help.title.replace('`', "")),
            documentation: completion.help.as_ref().map(|help| Documentation::MarkupContent(markdown(help.markdown()))),
            insert_text_format: Some(if is_snippet { InsertTextFormat::SNIPPET } else { InsertTextFormat::PLAIN_TEXT }),
            text_edit: Some(CompletionTextEdit::Edit(TextEdit { range, new_text })),
            label: completion.label,
            ..CompletionItem::default()
        }
    };
    found.list.into_iter().map(item).collect()
}

fn inserted(completion: &Completion, snippets: bool) -> String {
    match completion.kind {
        CompletionKind::Node if !snippets => completion.label.clone(),
        CompletionKind::Property if !snippets => format!("{}=", completion.label),
        _ => completion.insert.clone(),
    }
}

fn kind(kind: CompletionKind) -> CompletionItemKind {
    match kind {
        CompletionKind::Node => CompletionItemKind::CLASS,
        CompletionKind::Property => CompletionItemKind::PROPERTY,
        CompletionKind::Value => CompletionItemKind::VALUE,
        CompletionKind::Formula => CompletionItemKind::VARIABLE,
    }
}

/// Help on the word at a position.
pub(crate) fn hover(open: &OpenText, position: Position) -> Option<Hover> {
    let lines = Lines::new(open.text());
    let hover = open.hover(lines.byte(position))?;
    let meanings: Vec<String> = hover.meanings.iter().map(Entry::markdown).collect();
    let contents = HoverContents::Markup(markdown(meanings.join("\n\n---\n\n")));
    Some(Hover { contents, range: Some(lines.range(hover.range)) })
}
