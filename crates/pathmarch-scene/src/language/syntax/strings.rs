//! Quoted strings of KDL 2: `"one line"`, `"""` over several lines, and both raw between `#`.
//!
//! Strings over several lines lose the white space that precedes the closing quotes, as specified: first, `\` at the
//! end of a line is resolved, then the margin is removed, then other escapes are resolved.

use super::Reader;
use crate::language::characters::{is_newline, is_space};
use crate::language::diagnostics::report::draft;
use crate::language::tree::{Span, Value};
use std::borrow::Cow;

impl<'t> Reader<'t, '_> {
    /// A string that starts at the reader's place with `"`, or with `#`s and `"`. Already reported where `Bad`.
    pub(super) fn quoted(&mut self) -> Value<'t> {
        let start = self.at();
        let hashes = self.rest().bytes().take_while(|&b| b == b'#').count();
        let raw = hashes > 0;
        let several_lines = self.rest()[hashes..].starts_with("\"\"\"");
        let opening = hashes + if several_lines { 3 } else { 1 };
        self.skip(opening);
        let closing = format!("{}{}", if several_lines { "\"\"\"" } else { "\"" }, &"#".repeat(hashes));
        let body = self.rest();
        let mut length = None;
        // A `\` before white space joins lines: all the white space after it belongs to it.
        let (mut escaped, mut joining) = (false, false);
        for (index, c) in body.char_indices() {
            let white = is_space(c) || is_newline(c);
            if escaped || joining && white {
                joining = white;
                escaped = false;
                continue;
            }
            joining = false;
            if c == '\\' && !raw {
                escaped = true;
            } else if c == '"' && body[index..].starts_with(&closing) {
                length = Some(index);
                break;
            } else if is_newline(c) && !several_lines {
                break;
            }
        }
        let Some(length) = length else {
            let end = match several_lines {
                true => self.text_length(),
                false => self.at() + body.find(is_newline).unwrap_or(body.len()),
            };
            let shown = if several_lines { start + opening } else { end };
            self.move_to(end);
            self.report.add(
                draft("pathmarch::syntax", Span::new(start, shown), "This string is not closed.")
                    .label(format!("expected a closing {closing}"))
                    .help("Close it on the same line, or write it between \"\"\" lines."),
            );
            return Value::Bad;
        };
        let body = &body[..length];
        self.skip(length + closing.len());
        let span = Span::new(start, self.at());
        if several_lines {
            self.dedented(body, raw, span)
        } else if raw || !body.contains('\\') {
            Value::Text(Cow::Borrowed(body))
        } else {
            self.unescaped(&join_lines(body), span)
        }
    }

    fn dedented(&mut self, body: &str, raw: bool, span: Span) -> Value<'t> {
        let body = body.replace("\r\n", "\n").replace(is_newline, "\n");
        let body = if raw { body } else { join_lines(&body) };
        let mut lines: Vec<&str> = body.split('\n').collect();
        let margin = lines.pop().unwrap_or_default();
        let framed = lines.first() == Some(&"") && margin.chars().all(is_space);
        let blank = |line: &&str| line.chars().all(is_space);
        if !framed || !lines.iter().all(|line| blank(line) || line.starts_with(margin)) {
            self.report.add(
                draft("pathmarch::syntax", span, "This string of several lines is not laid out as it must be.")
                    .label("in this string")
                    .help("Put the quotes on lines of their own, and start every line with the white space that stands before the closing quotes."),
            );
            return Value::Bad;
        }
        let lines: Vec<&str> =
            lines[1..].iter().map(|line| if blank(line) { "" } else { &line[margin.len()..] }).collect();
        let text = lines.join("\n");
        if raw { Value::Text(Cow::Owned(text)) } else { self.unescaped(&text, span) }
    }

    fn unescaped(&mut self, body: &str, span: Span) -> Value<'t> {
        let mut text = String::with_capacity(body.len());
        let mut rest = body;
        while let Some(at) = rest.find('\\') {
            text.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            let Some(c) = rest.chars().next() else { break };
            rest = &rest[c.len_utf8()..];
            let plain = match c {
                'n' => Some('\n'),
                'r' => Some('\r'),
                't' => Some('\t'),
                'b' => Some('\u{8}'),
                'f' => Some('\u{c}'),
                's' => Some(' '),
                '\\' | '"' => Some(c),
                'u' => {
                    let code = rest.strip_prefix('{').and_then(|rest| rest.split_once('}'));
                    let valid = code.filter(|(digits, _)| (1..=6).contains(&digits.len()));
                    let value = valid.and_then(|(digits, _)| u32::from_str_radix(digits, 16).ok());
                    let after = code.map(|(_, after)| after);
                    let unicode = value.filter(|_| valid.is_some_and(|(d, _)| !d.starts_with('+')));
                    rest = after.unwrap_or(rest);
                    unicode.and_then(char::from_u32)
                }
                _ => None,
            };
            let Some(plain) = plain else {
                self.report.add(
                    draft("pathmarch::syntax", span, format!("`\\{}` is not an escape.", c.escape_debug()))
                        .label("in this string")
                        .help("Escapes are \\n \\r \\t \\b \\f \\s \\\\ \\\" and \\u{…}. Write \\\\ for a backslash, or #\"…\"# for a string without escapes."),
                );
                return Value::Bad;
            };
            text.push(plain);
        }
        text.push_str(rest);
        Value::Text(Cow::Owned(text))
    }
}

/// Origin of each byte of a string's value: start of its character in `written`, the string with its quotes as in the
/// file. The string must be one that could be read.
pub(crate) fn origins(written: &str) -> Vec<usize> {
    decoded(written).into_iter().flat_map(|(c, at)| std::iter::repeat_n(at, c.len_utf8())).collect()
}

/// The characters of a string's value, and where in `written` each comes from: the steps of [`Reader::quoted`] once more.
fn decoded(written: &str) -> Vec<(char, usize)> {
    let hashes = written.bytes().take_while(|&b| b == b'#').count();
    let quotes = match &written[hashes..] {
        rest if rest.starts_with("\"\"\"") => 3,
        rest if rest.starts_with('"') => 1,
        _ => 0,
    };
    let opening = if quotes == 0 { 0 } else { hashes + quotes };
    let body = &written[opening..written.len() - opening];
    let mut chars: Vec<(char, usize)> = body.char_indices().map(|(at, c)| (c, at + opening)).collect();
    let escapes = hashes == 0 && quotes > 0;
    if quotes == 3 {
        let joined = |index: usize| chars[index].0 == '\r' && chars.get(index + 1).is_some_and(|(c, _)| *c == '\n');
        let kept: Vec<usize> = (0..chars.len()).filter(|&index| !joined(index)).collect();
        chars = kept.into_iter().map(|index| chars[index]).collect();
        chars.iter_mut().filter(|(c, _)| is_newline(*c)).for_each(|(c, _)| *c = '\n');
    }
    if escapes {
        chars = without_joins(&chars);
    }
    if quotes == 3 {
        chars = without_margin(&chars);
    }
    if escapes { resolved(&chars) } else { chars }
}

/// Without each `\` and the white space and newlines after it.
fn without_joins(chars: &[(char, usize)]) -> Vec<(char, usize)> {
    let white = |index: usize| chars.get(index).is_some_and(|(c, _)| is_space(*c) || is_newline(*c));
    let mut kept = Vec::new();
    let mut at = 0;
    while at < chars.len() {
        if chars[at].0 == '\\' && white(at + 1) {
            at += 1;
            while white(at) {
                at += 1;
            }
            continue;
        }
        let taken = if chars[at].0 == '\\' { 2 } else { 1 };
        kept.extend(chars[at..].iter().take(taken));
        at += taken;
    }
    kept
}

/// Lines between the quotes, without the white space that precedes the closing ones.
fn without_margin(chars: &[(char, usize)]) -> Vec<(char, usize)> {
    let lines: Vec<&[(char, usize)]> = chars.split(|(c, _)| *c == '\n').collect();
    let margin = lines.last().map_or(0, |line| line.len());
    let mut kept: Vec<(char, usize)> = Vec::new();
    // The first and the last are those of the quotes; the newline before a line is the character behind the last one.
    let mut behind = lines.first().map_or(0, |line| line.len());
    for (index, line) in lines.iter().enumerate().skip(1).take(lines.len().saturating_sub(2)) {
        if index > 1 {
            kept.push(chars[behind]);
        }
        behind += 1 + line.len();
        if !line.iter().all(|(c, _)| is_space(*c)) {
            kept.extend(line.iter().skip(margin));
        }
    }
    kept
}

/// Resolves escapes.
fn resolved(chars: &[(char, usize)]) -> Vec<(char, usize)> {
    let mut kept = Vec::new();
    let mut rest = chars.iter();
    while let Some(&(c, at)) = rest.next() {
        if c != '\\' {
            kept.push((c, at));
            continue;
        }
        let plain = match rest.next().map_or('\\', |(c, _)| *c) {
            'n' => '\n',
            'r' => '\r',
            't' => '\t',
            'b' => '\u{8}',
            'f' => '\u{c}',
            's' => ' ',
            'u' => {
                let code: String = rest.by_ref().map(|(c, _)| *c).skip(1).take_while(|c| *c != '}').collect();
                u32::from_str_radix(&code, 16).ok().and_then(char::from_u32).unwrap_or(char::REPLACEMENT_CHARACTER)
            }
            c => c,
        };
        kept.push((plain, at));
    }
    kept
}

/// Removes each `\` with the white space and newlines after it.
fn join_lines(body: &str) -> String {
    let mut text = String::with_capacity(body.len());
    let mut rest = body;
    while let Some(at) = rest.find('\\') {
        text.push_str(&rest[..at]);
        let after = &rest[at + 1..];
        let next = after.chars().next();
        match next {
            Some(c) if is_space(c) || is_newline(c) => {
                rest = after.trim_start_matches(|c| is_space(c) || is_newline(c));
            }
            Some(c) => {
                text.push('\\');
                text.push(c);
                rest = &after[c.len_utf8()..];
            }
            None => {
                text.push('\\');
                rest = after;
            }
        }
    }
    text.push_str(rest);
    text
}

#[cfg(test)]
mod tests {
    use super::{decoded, origins};
    use crate::language::tree::Value;

    /// The value of a string, by the reader.
    fn read(written: &str) -> Option<String> {
        let text = format!("node {written}");
        let file = crate::language::nodes(&text)?;
        match &file.nodes.first()?.entries.first()?.value {
            Value::Text(text) => Some(text.to_string()),
            _ => None,
        }
    }

    #[test]
    fn places_are_those_of_the_value() {
        for written in [
            r#""plain""#,
            r#""tab\tand\u{e9} and \\ and \" end""#,
            "\"joined \\\n   line\"",
            "\"ä\\sö\"",
            r##"#"raw \n "quoted""#"##,
            "\"\"\"\n    one\n      two\n\n    thr\\\\ee\n    \"\"\"",
            "\"\"\"\r\n\tone\r\n\t\ttwo\r\n   \r\n\tthree\r\n\t\"\"\"",
            "\"\"\"\n  one \\\n      two\n  three\\n\n  \"\"\"",
            "##\"\"\"\n  raw \\n\n    \"\"\" in it\n  \"\"\"##",
            "\"\"\"\n\"\"\"",
            "bare",
        ] {
            let value = read(written).unwrap_or_else(|| panic!("{written}"));
            let by_places: String = decoded(written).into_iter().map(|(c, _)| c).collect();
            assert_eq!(value, by_places, "{written}");
            assert_eq!(origins(written).len(), value.len(), "{written}");
        }
        let written = "\"\"\"\n    one\n      two\n    \"\"\"";
        let at = origins(written)[read(written).expect("read").find("two").expect("there")];
        assert_eq!(&written[at..at + 3], "two");
    }
}
