//! Limits of constants and arrays, before naga reads them: it copies constants, and lays out arrays of any size.

use super::conditions::integer;
use super::items::{Item, ItemKind};
use super::lexer::{Token, fault};
use crate::custom_sdf::CodeDiagnostic;
use crate::custom_sdf::size::{MAX_ARRAY_SCALARS, MAX_NAMED_SCALARS};
use std::collections::HashMap;

/// Checks the constants and the sizes of arrays of these items.
pub(super) fn check(items: &[&Item]) -> Result<(), CodeDiagnostic> {
    let mut numbers: HashMap<&str, u64> = HashMap::new();
    let mut values: HashMap<&str, i64> = HashMap::new();
    let mut named = 0;
    for item in items {
        match &item.kind {
            ItemKind::Variable { value, sizes, ty, is_const } => {
                check_sizes(sizes, &values)?;
                check_sizes(ty, &values)?;
                let count = value.iter().map(|token| scalars(token, &numbers)).sum::<u64>();
                if count > u64::from(MAX_ARRAY_SCALARS) {
                    return Err(too_many(item, "variable or constant", count));
                }
                if *is_const {
                    numbers.insert(item.name, count.max(1));
                    if let Some(value) = integer(value, &|name| values.get(name).copied()) {
                        values.insert(item.name, value);
                    }
                }
            }
            _ => {
                check_sizes(&item.tokens, &values)?;
                let large = |token: &Token| Some(scalars(token, &numbers)).filter(|count| *count > 1);
                named += item.tokens.iter().filter_map(large).sum::<u64>();
                if named > MAX_NAMED_SCALARS {
                    return Err(too_many(
                        item,
                        "constants that functions name, each counted as often as it is named,",
                        named,
                    ));
                }
            }
        }
    }
    Ok(())
}

fn scalars(token: &Token, numbers: &HashMap<&str, u64>) -> u64 {
    match token.text.starts_with(|c: char| c.is_ascii_digit() || c == '.') && token.text != "." {
        true => 1,
        false => numbers.get(token.text).copied().unwrap_or_default(),
    }
}

fn too_many(item: &Item, what: &str, count: u64) -> CodeDiagnostic {
    let most = if count > MAX_NAMED_SCALARS { MAX_NAMED_SCALARS } else { u64::from(MAX_ARRAY_SCALARS) };
    let message = format!("The {what} at `{}` have {count} numbers; at most {most} are allowed.", item.name);
    fault(item.at, message, "too large", "Make the array smaller, or compute its elements where they are used.")
}

/// Checks every number in square brackets: it is the size of an array, or an index of one.
fn check_sizes(tokens: &[Token], values: &HashMap<&str, i64>) -> Result<(), CodeDiagnostic> {
    for (k, token) in tokens.iter().enumerate().filter(|(_, token)| token.is("[")) {
        let inner = tokens[k + 1..].split(|token| token.is("]")).next().unwrap_or_default();
        let size = integer(inner, &|name| values.get(name).copied());
        if let Some(size) = size.filter(|size| *size > i64::from(MAX_ARRAY_SCALARS)) {
            let message =
                format!("An array of {size} elements is too large; at most {MAX_ARRAY_SCALARS} numbers are allowed.");
            return Err(fault(inner.first().unwrap_or(token).at, message, "too large", "Make it smaller."));
        }
    }
    Ok(())
}
