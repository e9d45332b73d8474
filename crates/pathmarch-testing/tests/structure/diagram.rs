//! The diagram at the top of `ARCHITECTURE.md`: the crates, and the modules at the top of [`DETAILED`].
//!
//! It lies between the lines [`START`] and [`END`] as Mermaid flowcharts. An arrow leads from what imports to what is
//! imported; arrows that others imply are left out (transitive reduction) unless parts need each other in a ring. The root
//! file of a crate, which declares and re-exports, is not drawn.

use crate::imports::Imports;
use crate::rings::reachable;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The crate whose modules are drawn.
pub const DETAILED: &str = "pathmarch-render";
/// First line of the diagram in the document.
pub const START: &str = "<!-- rooms -->";
/// Last line.
pub const END: &str = "<!-- /rooms -->";

/// A flowchart.
pub struct Diagram {
    subject: String,
    /// Label of each node.
    nodes: BTreeMap<String, String>,
    /// Arrows between nodes, each with an import that demands it.
    arrows: BTreeMap<(String, String), String>,
    /// True if the arrows that others imply are left out.
    is_reduced: bool,
}

/// The diagrams of a workspace.
pub fn of_workspace(crates: &[Imports]) -> Vec<Diagram> {
    let detailed = crates.iter().filter(|imports| imports.of.name == DETAILED).map(of_modules);
    std::iter::once(of_crates(crates)).chain(detailed).map(reduced).collect()
}

fn of_crates(crates: &[Imports]) -> Diagram {
    let name = |imports: &Imports| imports.of.name.clone();
    let arrows = crates.iter().flat_map(|imports| {
        let others = imports.crates.iter();
        others.map(|(other, files)| {
            let reason = files.first().map(|file| format!("{file} imports {other}"));
            ((name(imports), (*other).to_owned()), reason.unwrap_or_default())
        })
    });
    Diagram {
        subject: "The crates".to_owned(),
        nodes: crates.iter().map(|imports| (name(imports), name(imports))).collect(),
        arrows: arrows.collect(),
        is_reduced: false,
    }
}

fn of_modules(imports: &Imports) -> Diagram {
    let name = &imports.of.name;
    let part = |file: &str| {
        let (_, inside) = file.split_once("/src/")?;
        let (top, label) = match inside.split_once('/') {
            Some((folder, _)) => (folder, format!("{folder}/")),
            None => (inside.strip_suffix(".rs")?, inside.to_owned()),
        };
        (top != "lib" && top != "main").then(|| (format!("{name}/{top}"), label))
    };
    let mut nodes = BTreeMap::new();
    for (node, label) in
        imports.of.modules.iter().filter(|module| !module.is_test).filter_map(|module| part(&module.file))
    {
        // A folder `x/` beside `x.rs` names both.
        let known = nodes.entry(node).or_insert_with(|| label.clone());
        if label.ends_with('/') {
            *known = label;
        }
    }
    let arrows = imports.files.iter().rev().filter_map(|((from, to), names)| {
        let arrow = (part(from)?.0, part(to)?.0);
        let names = names.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        (arrow.0 != arrow.1).then(|| (arrow, format!("{from} takes from {to}: {names}")))
    });
    Diagram { subject: format!("The modules of `{name}`"), is_reduced: false, nodes, arrows: arrows.collect() }
}

/// Without the arrows that others imply, if no nodes need each other.
fn reduced(mut diagram: Diagram) -> Diagram {
    let names = diagram.nodes.keys().map(String::as_str).collect();
    let arrows: BTreeSet<_> = diagram.arrows.keys().map(|(from, to)| (from.as_str(), to.as_str())).collect();
    let reached = reachable(&names, &arrows);
    diagram.is_reduced = reached.iter().all(|(node, others)| !others.contains(node));
    if diagram.is_reduced {
        let is_implied = |(from, to): &(&str, &str)| {
            arrows.iter().any(|(start, between)| start == from && between != to && reached[between].contains(to))
        };
        let implied: Vec<_> =
            arrows.iter().filter(|arrow| is_implied(arrow)).map(|(a, b)| (a.to_string(), b.to_string())).collect();
        implied.iter().for_each(|arrow| drop(diagram.arrows.remove(arrow)));
    }
    diagram
}

/// Name of a node in Mermaid, which knows few characters.
fn id(node: &str) -> String {
    node.replace(|c: char| !c.is_alphanumeric(), "_")
}

fn node_line((node, label): (&String, &String)) -> String {
    format!("{}[\"{label}\"]", id(node))
}

fn arrow_line((from, to): &(String, String)) -> String {
    format!("{} --> {}", id(from), id(to))
}

/// The text from [`START`] to [`END`].
fn block(diagrams: &[Diagram]) -> String {
    let mut text = format!("{START}\n");
    for Diagram { subject, nodes, arrows, is_reduced } in diagrams {
        let which = if *is_reduced {
            "arrows that follow from others are left out"
        } else {
            "all arrows are drawn, since some need each other"
        };
        let lines = nodes.iter().map(node_line).chain(arrows.keys().map(arrow_line));
        let lines: String = lines.map(|line| format!("    {line}\n")).collect();
        write!(
            text,
            "{subject}. An arrow leads to what one needs; {which}.\n\n```mermaid\nflowchart TD\n{lines}```\n\n"
        )
        .expect("text");
    }
    text + END
}

/// Place of the diagram in a document.
fn place(document: &str) -> Result<std::ops::Range<usize>, String> {
    let start = document.find(START).ok_or(format!("no line {START}"))?;
    let length = document[start..].find(END).ok_or(format!("no line {END}"))?;
    Ok(start..start + length + END.len())
}

/// The document with these diagrams.
pub fn replace(document: &str, diagrams: &[Diagram]) -> Result<String, String> {
    let place = place(document)?;
    Ok([&document[..place.start], &block(diagrams), &document[place.end..]].concat())
}

/// Compares the diagram of a document with these; the error contains each difference, and the diagram as it must be.
pub fn compare(document: &str, diagrams: &[Diagram]) -> Result<(), String> {
    let wanted = block(diagrams);
    let found = place(document).map(|place| &document[place]);
    if found == Ok(wanted.as_str()) {
        return Ok(());
    }
    let mut mistakes = found.as_ref().err().cloned().into_iter().collect::<Vec<_>>();
    let is_content = |line: &&str| line.contains(" --> ") || line.contains('[');
    let drawn: BTreeSet<_> = found.unwrap_or_default().lines().map(str::trim).filter(is_content).collect();
    let mut known = BTreeSet::new();
    for Diagram { nodes, arrows, .. } in diagrams {
        let nodes = nodes.iter().map(|(name, label)| (node_line((name, label)), name.clone()));
        let arrows = arrows.iter().map(|(arrow, reason)| (arrow_line(arrow), reason.clone()));
        for (line, reason) in nodes.chain(arrows) {
            if !drawn.contains(line.as_str()) {
                mistakes.push(format!("missing:  {line}   ({reason})"));
            }
            known.insert(line);
        }
    }
    mistakes.extend(drawn.iter().filter(|line| !known.contains(**line)).map(|line| format!("too much: {line}")));
    if mistakes.is_empty() {
        mistakes.push("nodes and arrows are right, their order or the text around them is not".to_owned());
    }
    Err(format!("{}\n\nIt must be\n\n{wanted}", mistakes.join("\n")))
}
