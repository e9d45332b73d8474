//! Integer expressions: conditions of `#if`, and sizes of arrays.

use super::lexer::{Kind, Token};

/// Binary operators by rising precedence.
const LEVELS: [&[&str]; 10] = [
    &["||"],
    &["&&"],
    &["|"],
    &["^"],
    &["&"],
    &["==", "!="],
    &["<", ">", "<=", ">="],
    &["<<", ">>"],
    &["+", "-"],
    &["*", "/", "%"],
];
/// Largest nesting of brackets and signs.
const MAX_DEPTH: usize = 64;

/// Value of an expression; names have the values that `name` gives. `None` if it is no integer expression.
pub(super) fn integer(tokens: &[Token], name: &dyn Fn(&str) -> Option<i64>) -> Option<i64> {
    let mut parser = Parser { tokens, at: 0, name };
    let value = parser.binary(0, 0)?;
    (parser.at == tokens.len()).then_some(value)
}

struct Parser<'t, 'a> {
    tokens: &'t [Token<'a>],
    at: usize,
    name: &'t dyn Fn(&str) -> Option<i64>,
}

impl Parser<'_, '_> {
    fn binary(&mut self, level: usize, depth: usize) -> Option<i64> {
        let Some(operators) = LEVELS.get(level) else { return self.unary(depth) };
        let mut left = self.binary(level + 1, depth)?;
        while let Some(operator) = self.tokens.get(self.at).filter(|token| operators.contains(&token.text)) {
            let operator = operator.text;
            self.at += 1;
            let right = self.binary(level + 1, depth)?;
            left = apply(operator, left, right)?;
        }
        Some(left)
    }

    fn unary(&mut self, depth: usize) -> Option<i64> {
        if depth > MAX_DEPTH {
            return None;
        }
        let token = *self.tokens.get(self.at)?;
        self.at += 1;
        match token.text {
            "-" => self.unary(depth + 1)?.checked_neg(),
            "+" => self.unary(depth + 1),
            "!" => Some(i64::from(self.unary(depth + 1)? == 0)),
            "~" => Some(!self.unary(depth + 1)?),
            "(" => {
                let value = self.binary(0, depth + 1)?;
                let closes = self.tokens.get(self.at).is_some_and(|token| token.is(")"));
                self.at += 1;
                closes.then_some(value)
            }
            text => match token.kind {
                Kind::Number => literal(text),
                Kind::Name => (self.name)(text),
                _ => None,
            },
        }
    }
}

fn literal(text: &str) -> Option<i64> {
    let text = text.trim_end_matches(['u', 'U']);
    match text.strip_prefix("0x").or(text.strip_prefix("0X")) {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}

fn apply(operator: &str, a: i64, b: i64) -> Option<i64> {
    Some(match operator {
        "||" => i64::from(a != 0 || b != 0),
        "&&" => i64::from(a != 0 && b != 0),
        "|" => a | b,
        "^" => a ^ b,
        "&" => a & b,
        "==" => i64::from(a == b),
        "!=" => i64::from(a != b),
        "<" => i64::from(a < b),
        ">" => i64::from(a > b),
        "<=" => i64::from(a <= b),
        ">=" => i64::from(a >= b),
        "<<" => a.checked_shl(u32::try_from(b).ok()?)?,
        ">>" => a.checked_shr(u32::try_from(b).ok()?)?,
        "+" => a.checked_add(b)?,
        "-" => a.checked_sub(b)?,
        "*" => a.checked_mul(b)?,
        "/" => a.checked_div(b)?,
        _ => a.checked_rem(b)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::custom_sdf::glsl::lexer::tokens;

    #[test]
    fn precedence_is_that_of_glsl() {
        let value = |text: &str| integer(&tokens(text), &|name| (name == "N").then_some(5));
        assert_eq!(value("1 + 2 * 3 == 7 && !(N < 5)"), Some(1));
        assert_eq!(value("(1 << 4) - 0x0f % 4"), Some(13));
        assert_eq!(value("1 / 0"), None);
        assert_eq!(value("1 +"), None);
        assert_eq!(value(&"(".repeat(100_000)), None);
    }
}
