//! Formatter of scene files.
//!
//! **Idea.** The text is parsed into a tree that keeps everything but white space (`tree.rs`) and printed again
//! (`print.rs`): four spaces for each level of braces, one space between words, at most one blank line between nodes.
//! Braces on one line stay there if the line fits in [`MAX_WIDTH`] columns; others have a line for each of theirs, and
//! nodes that share a line go on sharing it. Comments that stand in one column stay in one column (`columns.rs`). Words,
//! numbers and strings stay as they are written; a string or a comment of several lines moves as a whole with the line
//! that it starts on.
//!
//! **Cost.** Linear in the text; 0.7 MB take about 50 ms.

mod columns;
mod parse;
mod print;
#[cfg(test)]
mod tests;
mod tree;

use crate::diagnostic::SceneError;
use crate::language::diagnostics::report::Report;
use crate::language::syntax;
use crate::source::{MAX_BYTES, too_large};

/// Longest line that braces may be on, characters.
pub const MAX_WIDTH: usize = 120;

/// Formats the text of a scene file, which may have mistakes of meaning. `name` is its path, for diagnostics. The result
/// has the same nodes and comments in the same order, and is formatted to itself.
///
/// # Errors
/// [`SceneError::Mistakes`] with the mistakes of syntax; [`SceneError::Unreadable`] for a text of more than 16 MiB.
pub fn format(name: &str, text: &str) -> Result<String, SceneError> {
    if text.len() > MAX_BYTES {
        let (reason, help) = too_large();
        return Err(SceneError::Unreadable { name: name.to_owned(), reason, help });
    }
    let mut report = Report::new(name, text);
    syntax::read(text, &mut report);
    if report.has_mistakes() {
        return Err(report.into_error());
    }
    let mark = if text.starts_with('\u{feff}') { "\u{feff}" } else { "" };
    let (file, newline) = parse::parse(text, mark.len());
    let (body, comments) = print::print(&file, newline);
    Ok(format!("{mark}{}", columns::align(&body, &comments)))
}
