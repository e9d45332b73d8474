//! Diagnostics: mistakes and warnings at their places in the text, and suggestions for misspelt names.

pub(crate) mod foreign_code;
pub(crate) mod missing_words;
pub(crate) mod report;
pub(crate) mod spelling;
