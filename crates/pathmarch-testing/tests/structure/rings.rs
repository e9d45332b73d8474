//! Rings: files of a crate that import each other.

use crate::imports::Imports;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Display, Formatter};

/// Files each of which needs all others, directly or through them.
pub struct Ring<'a> {
    /// The files, in the order of their paths.
    pub files: BTreeSet<&'a str>,
    /// Each import between two of them, with the names that the first takes from the second.
    pub ties: BTreeMap<(&'a str, &'a str), BTreeSet<String>>,
    /// Rings that remain without the imports between modules and their descendants.
    core: Vec<BTreeSet<&'a str>>,
}

/// Rings of a crate's files.
///
/// Imports make a graph of the files. Files that reach each other in it (a strongly connected component of at least two)
/// are a ring, with one exception: a module's file and the files below it may use each other. So if one of the files is an
/// ancestor of all others, it is taken out, and the rest is searched again. Therefore
///
/// - `x/mod.rs` may use `x/a.rs` and `x/b.rs`, which may use `x/mod.rs`, also if `x/a.rs` uses `x/b.rs`;
/// - `x/a.rs` and `x/b.rs` may not use each other, with or without `x/mod.rs`;
/// - a ring that leaves a module counts, also if it passes through the module's file: `x/mod.rs` needs `y.rs`, `y.rs` needs
///   `x/a.rs`, `x/a.rs` needs `x/mod.rs`.
pub fn find<'a>(imports: &Imports<'a>) -> Vec<Ring<'a>> {
    let ancestors = ancestors(imports);
    let is_head = |file: &&str, files: &BTreeSet<&str>| {
        files.iter().all(|other| other == file || ancestors.get(other).is_some_and(|above| above.contains(file)))
    };
    let mut rings = Vec::new();
    let mut searched = vec![imports.files.keys().flat_map(|(from, to)| [*from, *to]).collect::<BTreeSet<_>>()];
    while let Some(files) = searched.pop() {
        let ties = || imports.files.iter().filter(|((from, to), _)| files.contains(from) && files.contains(to));
        for mut files in components(&files, &ties().map(|(tie, _)| *tie).collect()) {
            if let Some(head) = files.iter().copied().find(|file| is_head(file, &files)) {
                files.remove(head);
                searched.push(files);
            } else {
                let ties = ties().filter(|((from, to), _)| files.contains(from) && files.contains(to));
                let ties: BTreeMap<_, _> = ties.map(|(tie, names)| (*tie, names.clone())).collect();
                let is_family =
                    |(from, to): &(&str, &str)| ancestors[from].contains(to) || ancestors[to].contains(from);
                let core = components(&files, &ties.keys().copied().filter(|tie| !is_family(tie)).collect());
                rings.push(Ring { files, ties, core });
            }
        }
    }
    rings.sort_by(|a, b| a.files.cmp(&b.files));
    rings
}

/// Files of the modules above each file.
fn ancestors<'a>(imports: &Imports<'a>) -> BTreeMap<&'a str, BTreeSet<&'a str>> {
    let modules = &imports.of.modules;
    let above = |module: usize| std::iter::successors(modules[module].parent, |module| modules[*module].parent);
    let files = modules.iter().enumerate().map(|(index, module)| {
        (
            module.file.as_str(),
            above(index).map(|above| modules[above].file.as_str()).filter(|file| *file != module.file),
        )
    });
    let mut ancestors: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    files.for_each(|(file, above)| ancestors.entry(file).or_default().extend(above));
    ancestors
}

/// Strongly connected components of at least two nodes.
fn components<'a>(nodes: &BTreeSet<&'a str>, arrows: &BTreeSet<(&'a str, &'a str)>) -> Vec<BTreeSet<&'a str>> {
    let reached = reachable(nodes, arrows);
    let component = |node: &&'a str| -> BTreeSet<&'a str> {
        reached[node].iter().copied().filter(|other| reached[other].contains(node)).collect()
    };
    let all: BTreeSet<_> = nodes.iter().map(component).filter(|component| component.len() > 1).collect();
    all.into_iter().collect()
}

/// Nodes that each node reaches by at least one arrow.
pub fn reachable<'a>(
    nodes: &BTreeSet<&'a str>,
    arrows: &BTreeSet<(&'a str, &'a str)>,
) -> BTreeMap<&'a str, BTreeSet<&'a str>> {
    let mut next: BTreeMap<_, Vec<_>> = BTreeMap::new();
    arrows.iter().for_each(|(from, to)| next.entry(*from).or_default().push(*to));
    let from = |node: &&'a str| {
        let mut reached = BTreeSet::new();
        let mut open = vec![*node];
        while let Some(node) = open.pop() {
            open.extend(next.get(node).into_iter().flatten().filter(|node| reached.insert(**node)));
        }
        (*node, reached)
    };
    nodes.iter().map(from).collect()
}

impl Display for Ring<'_> {
    /// Writes the ties that make it a ring. Files that are in it only because they and their modules use each other come
    /// last, as names.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let short = |file: &str| file.split_once("/src/").map_or(file, |(_, file)| file).to_owned();
        let folder = self.files.first().and_then(|file| file.split_once("/src/")).map_or("", |(folder, _)| folder);
        writeln!(f, "ring of {} files in {folder}/src", self.files.len())?;
        let mut others = self.files.clone();
        for ((from, to), names) in &self.ties {
            if self.core.is_empty() || self.core.iter().any(|core| core.contains(from) && core.contains(to)) {
                let names = names.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
                writeln!(f, "  {} takes from {}: {names}", short(from), short(to))?;
                others.retain(|file| file != from && file != to);
            }
        }
        if !others.is_empty() {
            writeln!(f, "  also tied: {}", others.into_iter().map(short).collect::<Vec<_>>().join(", "))?;
        }
        Ok(())
    }
}
