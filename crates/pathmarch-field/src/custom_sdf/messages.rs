//! Messages of naga as sentences.

use naga::valid::ValidationError;
use std::error::Error;

/// Largest length of a message, characters; some of naga's quote the code.
pub(super) const MAX_MESSAGE: usize = 200;

/// A message of naga as one sentence.
pub(super) fn sentence(text: &str) -> String {
    let mut short: String = text.chars().take(MAX_MESSAGE).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(MAX_MESSAGE).is_some() {
        short.push('…');
    }
    let text = short.trim().trim_end_matches('.');
    let mut chars = text.chars();
    let first: String = chars.next().map(|c| c.to_uppercase().collect()).unwrap_or_default();
    format!("{first}{}.", chars.as_str())
}

/// Innermost cause of an error, as a sentence.
pub(super) fn innermost(error: &ValidationError) -> String {
    let mut cause: &dyn Error = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    sentence(&without_handles(&cause.to_string()))
}

/// Removes naga's handles from a message, as in "expression Some([3])".
fn without_handles(message: &str) -> String {
    let is_handle = |word: &str| {
        let word = word.trim_end_matches([',', ':']);
        let inner = word.strip_prefix("Some(").and_then(|word| word.strip_suffix(')')).unwrap_or(word);
        let digits = inner.strip_prefix('[').and_then(|inner| inner.strip_suffix(']'));
        digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()))
    };
    message.split(' ').filter(|word| !is_handle(word)).collect::<Vec<_>>().join(" ")
}
