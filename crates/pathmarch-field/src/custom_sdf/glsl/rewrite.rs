//! Statements of GLSL that naga does not read, written in another way.

use super::lexer::{Kind, Place, Token};

/// Operators that set what is before them.
const ASSIGNS: [&str; 12] = ["=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=", "++"];

/// Tokens of a function as naga reads them. `members` are the names of all members of structures.
pub(super) fn rewritten<'a>(tokens: &[Token<'a>], members: &[&str]) -> Vec<Token<'a>> {
    let columns = components_of_columns(tokens, members);
    separate_arrays(&without_do(&columns))
}

/// Writes `mat2(v)` as `pm_mat2(v)`, a function of the prelude for all types of `v`.
pub(super) fn name_matrices(tokens: &mut [Token]) {
    for k in 0..tokens.len() {
        let is_call = tokens[k].is("mat2") && tokens.get(k + 1).is_some_and(|next| next.is("("));
        let value = tokens.get(k + 2).is_some_and(|token| token.kind != Kind::Number);
        if is_call && value && elements(&tokens[k..]) == Some(1) {
            tokens[k].text = "pm_mat2";
        }
    }
}

/// Writes `float a[2], b;` as `float a[2]; float b;`: naga takes what follows an array for arrays, too.
fn separate_arrays<'a>(tokens: &[Token<'a>]) -> Vec<Token<'a>> {
    let mut result: Vec<Token> = Vec::new();
    let mut rest = tokens;
    while !rest.is_empty() {
        let length = 1 + rest.iter().position(|token| matches!(token.text, ";" | "{" | "}")).unwrap_or(rest.len() - 1);
        let (statement, after) = rest.split_at(length);
        rest = after;
        let has_array = matches!(statement, [ty, name, open, ..] if ty.is_name() && name.is_name() && !ty.is("return")
            && matches!(open.text, "[" | "=" | ","))
            && statement.iter().any(|token| token.is("["));
        let mut depth = 0_usize;
        for token in statement {
            match token.text {
                "(" | "[" => depth += 1,
                ")" | "]" => depth = depth.saturating_sub(1),
                _ => {}
            }
            if has_array && depth == 0 && token.is(",") {
                result.push(Token { text: ";", ..*token });
                result.push(statement[0]);
            } else {
                result.push(*token);
            }
        }
    }
    result
}

/// Writes `m[0].x = a` as `m[0][0] = a`: naga assigns to no component of a column by name.
fn components_of_columns<'a>(tokens: &[Token<'a>], members: &[&str]) -> Vec<Token<'a>> {
    let mut result: Vec<Token> = Vec::with_capacity(tokens.len());
    let mut k = 0;
    while let Some(token) = tokens.get(k) {
        let index = tokens.get(k + 1).and_then(|name| component(name.text)).filter(|_| {
            let is_set = tokens.get(k + 2).is_some_and(|next| ASSIGNS.contains(&next.text) || next.is("--"));
            token.is(".") && k > 0 && tokens[k - 1].is("]") && is_set && !members.contains(&tokens[k + 1].text)
        });
        let Some(index) = index else {
            result.push(*token);
            k += 1;
            continue;
        };
        let at = tokens[k + 1].at;
        result.extend(
            [("[", Kind::Punctuation), (index, Kind::Number), ("]", Kind::Punctuation)].map(|(text, kind)| Token {
                kind,
                text,
                at,
                starts_line: false,
                spaced: false,
            }),
        );
        k += 2;
    }
    result
}

/// Index of a component, as in `v.y`.
fn component(name: &str) -> Option<&'static str> {
    let sets = ["xyzw", "rgba", "stpq"];
    let index = sets.iter().find_map(|set| set.find(name).filter(|_| name.len() == 1))?;
    ["0", "1", "2", "3"].get(index).copied()
}

/// Writes `do BODY while (c);` as `for (bool pm_again = true; pm_again; pm_again = (c)) BODY`.
fn without_do<'a>(tokens: &[Token<'a>]) -> Vec<Token<'a>> {
    let mut result = tokens.to_vec();
    // From the last, so that inner loops are written before those around them.
    for k in (0..tokens.len()).rev().filter(|&k| tokens[k].is("do")) {
        let Some(body_end) = statement_end(&result, k + 1) else { continue };
        let is_while = result.get(body_end).is_some_and(|token| token.is("while"));
        let end = body_end + 1;
        let Some(condition_end) =
            result.get(end).filter(|token| is_while && token.is("(")).and_then(|_| close(&result, end))
        else {
            continue;
        };
        let has_end = result.get(condition_end).is_some_and(|token| token.is(";"));
        let at = result[k].at;
        let mut written =
            words(&["for", "(", "bool", "pm_again", "=", "true", ";", "pm_again", ";", "pm_again", "="], at);
        written.extend_from_slice(&result[end..condition_end]);
        written.extend(words(&[")"], at));
        written.extend_from_slice(&result[k + 1..body_end]);
        result.splice(k..condition_end + usize::from(has_end), written);
    }
    result
}

fn words<'a>(texts: &[&'static str], at: Place) -> Vec<Token<'a>> {
    let kind = |text: &str| if text.starts_with(|c: char| c.is_alphabetic()) { Kind::Name } else { Kind::Punctuation };
    texts.iter().map(|text| Token { kind: kind(text), text, at, starts_line: false, spaced: true }).collect()
}

/// Index behind the statement that starts here.
fn statement_end(tokens: &[Token], start: usize) -> Option<usize> {
    let mut at = start;
    match tokens.get(at)?.text {
        "{" => close(tokens, at),
        "for" | "while" | "if" | "switch" => {
            at = statement_end(tokens, close(tokens, at + 1)?)?;
            match tokens.get(at).is_some_and(|token| token.is("else")) {
                true => statement_end(tokens, at + 1),
                false => Some(at),
            }
        }
        _ => {
            while !tokens.get(at)?.is(";") {
                at = if matches!(tokens[at].text, "(" | "[" | "{") { close(tokens, at)? } else { at + 1 };
            }
            Some(at + 1)
        }
    }
}

/// Index behind the bracket that closes the one here.
fn close(tokens: &[Token], open: usize) -> Option<usize> {
    let mut depth = 0_usize;
    for (k, token) in tokens.iter().enumerate().skip(open) {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.checked_sub(1)?,
            _ => {}
        }
        if depth == 0 {
            return Some(k + 1);
        }
    }
    None
}

/// Number of elements of an array whose brackets at `open` are empty, as its initial value has them.
pub(super) fn element_count(tokens: &[Token], open: usize) -> Option<usize> {
    let is_empty = tokens.get(open)?.is("[") && tokens.get(open + 1)?.is("]");
    let after = tokens.get(open + 2..).filter(|_| is_empty)?;
    let value = match after.first()?.text {
        "(" | "=" => after,
        // The name follows the brackets.
        _ => after.get(1..).filter(|rest| rest.first().is_some_and(|token| token.is("=")))?,
    };
    elements(value)
}

/// Number of elements in the first brackets of a value: `vec3[](a, b)` or `{a, b}`.
pub(super) fn elements(value: &[Token]) -> Option<usize> {
    let open = value.iter().position(|token| matches!(token.text, "(" | "{" | ";"))?;
    let end = close(value, open).filter(|_| !value[open].is(";"))?;
    let (mut depth, mut count) = (0_usize, 1);
    for token in &value[open + 1..end - 1] {
        match token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth = depth.saturating_sub(1),
            "," if depth == 0 => count += 1,
            _ => {}
        }
    }
    Some(count).filter(|_| end > open + 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::custom_sdf::glsl::lexer::tokens;

    fn texts(code: &str) -> String {
        let all = rewritten(&tokens(code), &["w"]);
        all.iter().map(|token| token.text).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn loops_with_their_condition_behind_are_for_loops() {
        let head = "for ( bool pm_again = true ; pm_again ; pm_again = (";
        assert_eq!(texts("do { a(); } while (b < (1)); c;"), format!("{head} b < ( 1 ) ) ) {{ a ( ) ; }} c ;"));
        assert_eq!(texts("do if (x) y; else z; while (b);"), format!("{head} b ) ) if ( x ) y ; else z ;"));
        let inner = format!("{head} d ) ) {{ a ; }}");
        assert_eq!(texts("do { do { a; } while (d); } while (b);"), format!("{head} b ) ) {{ {inner} }}"));
        assert_eq!(texts("do { a;"), "do { a ;");
    }

    #[test]
    fn components_of_columns_are_set_by_their_index() {
        assert_eq!(
            texts("j[0].x = 1.; j[i+1].g *= 2.; j[0].y;"),
            "j [ 0 ] [ 0 ] = 1. ; j [ i + 1 ] [ 1 ] *= 2. ; j [ 0 ] . y ;"
        );
        // A member of a structure.
        assert_eq!(texts("s[0].w = 1.;"), "s [ 0 ] . w = 1. ;");
    }

    #[test]
    fn matrices_of_one_value_are_named() {
        let mut all = tokens("mat2 f(mat2 m) { return mat2(1.) * mat2(a, b) * mat2(cos(vec4(1, 2, 3, 4))); }");
        name_matrices(&mut all);
        let named: Vec<usize> = (0..all.len()).filter(|&k| all[k].is("pm_mat2")).collect();
        assert_eq!(named.len(), 1);
        assert!(all[named[0] + 2].is("cos"));
    }

    #[test]
    fn elements_are_counted() {
        let count = |code: &str| {
            let all = tokens(code);
            all.iter().position(|token| token.is("[")).and_then(|open| element_count(&all, open))
        };
        assert_eq!(count("vec3 v[] = vec3[](vec3(1, 2, 3), b);"), Some(2));
        assert_eq!(count("float[] v = float[3](1., 2., 3.);"), Some(3));
        assert_eq!(count("float v[] = {1., f(2, 3)};"), Some(2));
        assert_eq!(count("float v[2] = x;"), None);
        assert_eq!(count("float v[] = x;"), None);
    }
}
