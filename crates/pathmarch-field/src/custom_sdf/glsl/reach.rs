//! Declarations that the distance function needs, in an order in which each is declared before its use.

use super::items::{Item, ItemKind};
use super::lexer::{Token, fault};
use crate::custom_sdf::CodeDiagnostic;
use std::collections::{HashMap, HashSet};

/// Functions of GLSL that WGSL lacks, and those of the prelude that replace them.
const REPLACED: [(&str, &str); 4] =
    [("inverse", "pm_inverse"), ("outerProduct", "pm_outerProduct"), ("isnan", "pm_isnan"), ("isinf", "pm_isinf")];

/// Name to use for a name of the code.
pub(super) fn replaced<'n>(name: &'n str, declared: &HashSet<&str>) -> &'n str {
    let found = REPLACED.iter().find(|(own, _)| *own == name && !declared.contains(own));
    found.map_or(name, |(_, other)| other)
}

/// Indices of the items that are needed: functions after those that they call, all others before them.
pub(super) fn needed(items: &[Item], own: usize, roots: &[usize]) -> Vec<usize> {
    let declared: HashSet<&str> = items[..own].iter().map(|item| item.name).collect();
    let mut by_name: HashMap<&str, Vec<usize>> = HashMap::new();
    for (index, item) in items.iter().enumerate() {
        // Those of the prelude are used where the code has none.
        if index < own || !declared.contains(item.name) {
            by_name.entry(item.name).or_default().push(index);
        }
    }
    let callees = |index: usize| {
        let references = items[index].references().map(|token| replaced(token.text, &declared));
        let mut all: Vec<usize> = references.filter_map(|name| by_name.get(name)).flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let mut done = HashSet::new();
    let mut order = Vec::new();
    for &root in roots {
        // Depth first, without recursion: calls may be as deep as the code is long.
        let mut stack = vec![(root, callees(root).into_iter())];
        done.insert(root);
        while let Some((index, rest)) = stack.last_mut() {
            match rest.next() {
                Some(next) if done.insert(next) => stack.push((next, callees(next).into_iter())),
                Some(_) => {}
                None => {
                    order.push(*index);
                    stack.pop();
                }
            }
        }
    }
    let is_function = |index: &usize| matches!(items[*index].kind, ItemKind::Function { .. });
    let (functions, mut others): (Vec<_>, Vec<_>) = order.into_iter().partition(is_function);
    others.sort_unstable();
    // Those of the prelude first.
    others.sort_by_key(|index| *index < own);
    others.into_iter().chain(functions).collect()
}

/// What only shaders of pictures have: the start of a name, and what to do about it.
const FOREIGN: [(&str, &str); 10] = [
    ("texture", "A field has no pictures: write a formula in its place."),
    ("texelFetch", "A field has no pictures: write a formula in its place."),
    ("iChannel", "A field has no pictures: write a formula in its place."),
    ("image", "A field has no pictures: write a formula in its place."),
    ("iTimeDelta", "A distance does not depend on the frame: write a number in its place."),
    ("iDate", "A field has no clock: use `iTime`, which is a `param`."),
    ("gl_", "A distance depends on the point alone."),
    ("dFdx", "A field has no derivatives."),
    ("dFdy", "A field has no derivatives."),
    ("fwidth", "A field has no derivatives."),
];

/// Names in a function that fields do not have.
pub(super) fn foreign(item: &Item, is_known: &dyn Fn(&str) -> bool) -> Vec<CodeDiagnostic> {
    let is_foreign = |token: &&Token| !is_known(token.text);
    let found = item.references().filter(is_foreign).filter_map(|token| {
        let calls = token.text.starts_with("texture") || token.text.starts_with("image");
        let (_, help) = FOREIGN.iter().find(|(start, _)| token.text.starts_with(start))?;
        // Other names may start like this, too: only calls are meant.
        let is_call = || {
            item.tokens.iter().skip_while(|other| !std::ptr::eq(*other, token)).nth(1).is_some_and(|next| next.is("("))
        };
        (!calls || is_call())
            .then(|| fault(token.at, format!("`{}` is not for a field.", token.text), "not in a field", help))
    });
    found.collect()
}
