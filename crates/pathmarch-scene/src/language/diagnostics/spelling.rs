//! Suggestions for misspelt names.

/// The nearest of `known` to a misspelt name: one edit for every three letters or part of them; a swap is one edit.
pub(crate) fn nearest<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    if name.chars().nth(40).is_some() {
        return None;
    }
    let lower = name.to_lowercase();
    let allowed = name.chars().count().div_ceil(3);
    known
        .into_iter()
        .map(|word| (strsim::damerau_levenshtein(&lower, &word.to_lowercase()), word))
        .filter(|(edits, word)| *edits <= allowed && *edits < word.chars().count())
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, word)| word)
}

/// "a", "a and b", "a, b and c", each in backquotes.
pub(crate) fn listed<'k>(names: impl IntoIterator<Item = &'k str>, joint: &str) -> String {
    let names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => only.clone(),
        Some((last, others)) => format!("{} {joint} {last}", others.join(", ")),
    }
}

/// "Did you mean `…`?", or which names there are.
pub(crate) fn suggestion(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(word) => format!("Did you mean `{word}`?"),
        None if known.is_empty() => "Nothing is allowed here.".to_owned(),
        None => format!("Expected {}.", listed(known.iter().copied(), "or")),
    }
}

#[cfg(test)]
mod tests {
    use super::{listed, nearest};
    use crate::language::keywords::solids;

    #[test]
    fn nearest_names() {
        for (misspelt, right) in [
            ("spere", Some("sphere")),
            ("shpere", Some("sphere")),
            ("Sphere", Some("sphere")),
            ("BOX", Some("box")),
            ("bx", Some("box")),
            ("tours", Some("torus")),
            ("substract", Some("subtract")),
            ("intersection", Some("intersect")),
            ("unoin", Some("union")),
            ("x", None),
            ("teapot", None),
            ("", None),
        ] {
            assert_eq!(nearest(misspelt, solids()), right, "{misspelt}");
        }
        assert_eq!(nearest(&"a".repeat(1000), ["a"]), None);
    }

    /// One edit away from a name, it is the nearest; unless it is another name or as near to one.
    #[test]
    fn every_name_is_found() {
        for name in solids() {
            let doubled = format!("{}{name}", &name[..1]);
            assert_eq!(nearest(&doubled, solids()), Some(name));
        }
    }

    #[test]
    fn lists() {
        assert_eq!(listed(["a", "b", "c"], "or"), "`a`, `b` or `c`");
        assert_eq!(listed(["a"], "or"), "`a`");
    }
}
