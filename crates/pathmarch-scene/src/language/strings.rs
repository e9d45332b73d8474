//! Quoted strings of KDL 2: `"one line"`, `"""` over several lines, and both raw between `#`.
//!
//! Several lines lose the white space that stands before the closing quotes, as the specification asks: first `\` at
//! the end of a line is resolved, then the margin goes, then the other escapes.

use super::characters::{is_newline, is_space};
use super::report::draft;
use super::syntax::Reader;
use super::tree::{Span, Value};
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
                draft("pathmarch::syntax", Span::new(start, shown), "This string has no end.")
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
                    draft("pathmarch::syntax", span, format!("`\\{}` is no escape.", c.escape_debug()))
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
