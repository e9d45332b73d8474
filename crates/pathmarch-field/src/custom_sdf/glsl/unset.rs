//! Variables that the distance function reads, and only other functions of a shader set.

use super::items::{Item, ItemKind};
use super::lexer::{Token, fault};
use crate::custom_sdf::CodeDiagnostic;

/// Operators that set what is before them.
const ASSIGNS: [&str; 10] = ["=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "++"];

/// Warnings of needed variables without a value that only functions set which are not needed.
pub(super) fn warnings(items: &[Item], needed: &[usize]) -> Vec<CodeDiagnostic> {
    let is_variable =
        |item: &Item| matches!(&item.kind, ItemKind::Variable { value, is_const: false, .. } if value.is_empty());
    let variables = (0..items.len()).filter(|index| needed.contains(index) && is_variable(&items[*index]));
    let setters = |name: &str, is_needed: bool| {
        let functions = (0..items.len()).filter(|index| needed.contains(index) == is_needed).map(|index| &items[index]);
        functions.filter(|item| sets(&item.tokens, name)).collect::<Vec<_>>()
    };
    let warning = |index: usize| {
        let item = &items[index];
        let setter = if setters(item.name, true).is_empty() {
            setters(item.name, false).first().copied()?
        } else {
            return None;
        };
        let message =
            format!("`{}` is 0 here: only `{}` sets it, which the distance does not call.", item.name, setter.name);
        let help = "Give it a value where it is declared, or make it a `uniform`, which is a parameter of the field.";
        Some(fault(item.at, message, "without a value", help))
    };
    variables.filter_map(warning).collect()
}

/// True if these tokens set a variable, or give it to a function.
fn sets(tokens: &[Token], name: &str) -> bool {
    (0..tokens.len()).filter(|&k| tokens[k].is(name)).any(|k| {
        let mut rest = &tokens[k + 1..];
        // Components and elements.
        while let [dot, _, ..] = rest
            && matches!(dot.text, "." | "[")
        {
            let end = if dot.is("[") { rest.iter().position(|token| token.is("]")) } else { Some(1) };
            rest = end.and_then(|end| rest.get(end + 1..)).unwrap_or_default();
        }
        let is_argument = k > 0 && matches!(tokens[k - 1].text, "(" | ",");
        let ends = rest.first().is_some_and(|next| matches!(next.text, ")" | ","));
        rest.first().is_some_and(|next| ASSIGNS.contains(&next.text)) || (is_argument && ends)
    })
}
