//! Formatting of a document.

use crate::positions::Lines;
use lsp_types::TextEdit;
use pathmarch_scene::formatter;
use pathmarch_scene::language_service::OpenText;

/// The edit that formats a document; none if it is formatted or has mistakes of syntax, which its diagnostics report.
pub(crate) fn formatting(open: &OpenText) -> Vec<TextEdit> {
    match formatter::format(open.name(), open.text()) {
        Ok(formatted) if formatted != open.text() => vec![edit(open.text(), &formatted)],
        _ => Vec::new(),
    }
}

/// One edit of the lines that differ, so that the rest keeps its marks and folds.
fn edit(old: &str, new: &str) -> TextEdit {
    let lines = |text: &str| text.split_inclusive('\n').map(str::len).collect::<Vec<_>>();
    let (old_lines, new_lines) = (old.split_inclusive('\n'), new.split_inclusive('\n'));
    let same: usize = old_lines.zip(new_lines).take_while(|(a, b)| a == b).map(|(a, _)| a.len()).sum();
    let (old_rest, new_rest) = (&old[same..], &new[same..]);
    let backwards = lines(old_rest).into_iter().rev().zip(lines(new_rest).into_iter().rev());
    let mut end = 0;
    for (a, b) in backwards {
        if a != b || old_rest[old_rest.len() - end - a..] != new_rest[new_rest.len() - end - b..] {
            break;
        }
        end += a;
    }
    TextEdit::new(Lines::new(old).range(same..old.len() - end), new_rest[..new_rest.len() - end].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn an_edit_makes_the_new_text(old in "[ab\n]{0,16}", new in "[ab\n]{0,16}") {
            let edit = edit(&old, &new);
            let bytes = Lines::new(&old).bytes(edit.range);
            prop_assert_eq!(format!("{}{}{}", &old[..bytes.start], edit.new_text, &old[bytes.end..]), new);
        }
    }
}
