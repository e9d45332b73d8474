//! Comments at the ends of lines that follow each other and start in one column: they stay in one column.

/// Comment at the end of a printed line.
pub(super) struct EndComment {
    /// Start among the bytes of the printed text.
    pub(super) at: usize,
    /// Column in the file, characters.
    pub(super) old_column: usize,
}

/// Moves comments to the right, each to the column of its neighbours if they shared one in the file.
pub(super) fn align(text: &str, comments: &[EndComment]) -> String {
    let mut aligned = String::with_capacity(text.len());
    let mut done = 0;
    let neighbours =
        |a: &EndComment, b: &EndComment| a.old_column == b.old_column && text[a.at..b.at].matches('\n').count() == 1;
    for group in comments.chunk_by(neighbours) {
        let columns: Vec<usize> = group.iter().map(|comment| column(text, comment.at)).collect();
        let widest = columns.iter().copied().max().unwrap_or(0);
        for (comment, column) in group.iter().zip(columns) {
            aligned.push_str(&text[done..comment.at]);
            aligned.push_str(&" ".repeat(widest - column));
            done = comment.at;
        }
    }
    aligned.push_str(&text[done..]);
    aligned
}

/// Column of a byte, characters.
fn column(text: &str, at: usize) -> usize {
    let start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
    text[start..at].chars().count()
}
