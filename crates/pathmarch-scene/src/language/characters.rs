//! Classes of characters and the form of numbers in KDL 2 (<https://kdl.dev/spec>).

/// Characters that end a line. (CR LF counts as two, which makes no difference here.)
pub(crate) const fn is_newline(c: char) -> bool {
    matches!(c, '\r' | '\n' | '\u{85}' | '\u{b}' | '\u{c}' | '\u{2028}' | '\u{2029}')
}

/// Characters of white space within a line.
pub(crate) const fn is_space(c: char) -> bool {
    matches!(c, '\t' | ' ' | '\u{a0}' | '\u{1680}' | '\u{2000}'..='\u{200a}' | '\u{202f}' | '\u{205f}' | '\u{3000}')
}

/// Characters that no file may contain: control characters, direction overrides, byte order marks inside the text.
pub(crate) const fn is_forbidden(c: char) -> bool {
    matches!(c,
        '\0'..='\u{8}' | '\u{e}'..='\u{1f}' | '\u{7f}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}'
        | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// Forbidden characters of a text from this byte on, and where they start. Most texts have none, and few are not ASCII.
pub(crate) fn forbidden_in(text: &str, from: usize) -> impl Iterator<Item = (usize, char)> {
    let may_be_forbidden = |byte: u8| !byte.is_ascii() || is_forbidden(char::from(byte));
    let first = text.bytes().skip(from).position(may_be_forbidden).map_or(text.len(), |index| from + index);
    text[first..].char_indices().filter(|(_, c)| is_forbidden(*c)).map(move |(index, c)| (first + index, c))
}

/// Characters of bare words.
#[inline]
pub(crate) fn is_word(c: char) -> bool {
    const ASCII: [bool; 128] = {
        let mut table = [false; 128];
        let mut code = 0;
        while code < 128 {
            let c = code as u8 as char;
            let ends_words = matches!(c, '\\' | '/' | '(' | ')' | '{' | '}' | '[' | ']' | ';' | '"' | '#' | '=');
            table[code] = !(ends_words || is_space(c) || is_newline(c) || is_forbidden(c));
            code += 1;
        }
        table
    };
    match ASCII.get(c as usize) {
        Some(is_word) => *is_word,
        None => !(is_space(c) || is_newline(c) || is_forbidden(c)),
    }
}

/// True for a word that starts like a number.
pub(crate) fn looks_like_number(word: &str) -> bool {
    let unsigned = word.strip_prefix(['+', '-']).unwrap_or(word);
    let digits = unsigned.strip_prefix('.').unwrap_or(unsigned);
    digits.starts_with(|c: char| c.is_ascii_digit())
}

/// Digits with underscores between or after them.
fn is_digits(text: &str, radix: u32) -> bool {
    text.starts_with(|c: char| c.is_digit(radix)) && text.chars().all(|c| c == '_' || c.is_digit(radix))
}

/// True for digits with at most one point between them, as most numbers are.
fn is_plain(word: &[u8]) -> bool {
    let is_digit = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_digit);
    let point = word.iter().position(|byte| *byte == b'.').unwrap_or(word.len());
    let mut digits = word.iter().enumerate().filter(|(index, _)| *index != point);
    is_digit(word.first()) && is_digit(word.last()) && digits.all(|(_, byte)| byte.is_ascii_digit())
}

/// The number that a word spells: decimal with fraction and exponent, or `0x`, `0o`, `0b`; `None` if it spells none.
pub(crate) fn number(word: &str) -> Option<f64> {
    let (sign, unsigned) = match word.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, word.strip_prefix('+').unwrap_or(word)),
    };
    if is_plain(unsigned.as_bytes()) {
        return unsigned.parse::<f64>().ok().map(|value| sign * value);
    }
    for (prefix, radix) in [("0x", 16), ("0o", 8), ("0b", 2)] {
        if let Some(digits) = unsigned.strip_prefix(prefix) {
            let value = digits.chars().filter_map(|c| c.to_digit(radix));
            return is_digits(digits, radix)
                .then(|| sign * value.fold(0.0, |value, digit| value * f64::from(radix) + f64::from(digit)));
        }
    }
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, Some(exponent.strip_prefix(['+', '-']).unwrap_or(exponent))),
        None => (unsigned, None),
    };
    let (whole, fraction) = match mantissa.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (mantissa, None),
    };
    let valid = is_digits(whole, 10)
        && fraction.is_none_or(|digits| is_digits(digits, 10))
        && exponent.is_none_or(|digits| is_digits(digits, 10));
    valid.then(|| unsigned.replace('_', "").parse::<f64>().ok()).flatten().map(|value| sign * value)
}
