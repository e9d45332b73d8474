//! What a film shows: parts of one picture have the same.

use std::collections::BTreeMap;

/// Scene, settings and version of a film, by name. Parts merge, and renders go on, only if all of them agree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Identity(pub BTreeMap<String, String>);

impl Identity {
    /// Identity of these names and values.
    pub fn new<N: Into<String>>(values: impl IntoIterator<Item = (N, String)>) -> Self {
        Self(values.into_iter().map(|(name, value)| (name.into(), value)).collect())
    }

    /// What differs, as in "seed is 1 here and 2 there"; `None` if nothing does.
    pub fn difference(&self, here: &str, other: &Self, there: &str) -> Option<String> {
        let none = String::from("missing");
        let names: std::collections::BTreeSet<&String> = self.0.keys().chain(other.0.keys()).collect();
        let value = |identity: &'_ Self, name: &String| shortened(identity.0.get(name).unwrap_or(&none));
        let differences: Vec<String> = names
            .into_iter()
            .filter(|name| self.0.get(*name) != other.0.get(*name))
            .map(|name| format!("{name} is {} {here} and {} {there}", value(self, name), value(other, name)))
            .collect();
        (!differences.is_empty()).then(|| differences.join("; "))
    }
}

/// Hashes are shown by their start.
fn shortened(value: &str) -> String {
    match value.char_indices().nth(60) {
        Some(_) => format!("{}…", value.chars().take(12).collect::<String>()),
        None => value.to_owned(),
    }
}
