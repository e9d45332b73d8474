//! Included files: `include "parts.kdl"`.
//!
//! Their parameters, materials, custom SDFs, declared shapes, objects and lights are read as if they were written after
//! those of the scene, except that parameters come first. Cameras, render settings and the sky are ignored, so that any
//! scene can be included. Spans of their nodes continue after the text of the scene, as if all texts were one;
//! [`Report`](crate::language::diagnostics::report::Report) knows the ranges. A file counts once, however often it is
//! included. Cost: reading the files, each time.

use super::arguments::{arguments, missing_arguments, no_children, properties, string};
use super::context::Context;
use super::unexpected::unexpected_node;
use super::version::{Version, version};
use crate::diagnostic::SceneError;
use crate::language::diagnostics::report::{draft, shown};
use crate::language::keywords::{FIELD, INCLUDE, PARAM, SHAPE, TOP};
use crate::language::syntax;
use crate::language::tree::{Block, Node};
use crate::source::{MAX_BYTES, read_text};
use pathmarch_mesh::files::canonicalize;
use std::path::{Path, PathBuf};

/// Nodes that are taken from an included file.
const TAKEN: &[&str] = &[PARAM, "material", FIELD, SHAPE, "object", "sun", "point", "spot"];
/// Files within files; deeper is refused.
const MAX_DEPTH: usize = 16;
/// Files of one scene; more are refused.
const MAX_FILES: usize = 1000;

/// Included files.
#[derive(Default)]
pub(crate) struct Included {
    /// In the order in which their files are first included, those of a file behind those that it includes.
    pub(crate) nodes: Vec<Node<'static>>,
    /// The files, as their paths are found.
    pub(crate) files: Vec<PathBuf>,
    bytes: usize,
    /// The same without detours, to be compared.
    seen: Vec<PathBuf>,
}

impl Included {
    /// Reads the files that the scene `name` includes. Reports files that cannot be included.
    pub(crate) fn of(name: &str, text: &str, file: &Block, context: &mut Context) -> Self {
        let mut all = Self { bytes: text.len(), ..Self::default() };
        let mut around: Vec<PathBuf> = canonicalize(Path::new(name)).into_iter().collect();
        all.follow(Path::new(name), &file.nodes, &mut around, context);
        all
    }

    /// Reads the files that the nodes of the file at `path` include; `around` are this file and those that include it.
    fn follow(&mut self, path: &Path, nodes: &[Node], around: &mut Vec<PathBuf>, context: &mut Context) {
        for node in nodes.iter().filter(|node| node.name.value == INCLUDE) {
            let usage = "`include \"parts.kdl\"`";
            properties(node, &[], context);
            no_children(node, context);
            let entries = arguments(node, 1, usage, context);
            let Some(entry) = entries.first() else {
                missing_arguments(node, usage, context);
                continue;
            };
            let Some(given) = string(entry, "The path of a file", context) else { continue };
            let refused = |message: String, label: &str, help: &str| {
                draft("pathmarch::include", entry.value_span, message).label(label).help(help)
            };
            let found = path.parent().unwrap_or(Path::new("")).join(given);
            if context.refuses(&found, entry) {
                continue;
            }
            let whole = canonicalize(&found).unwrap_or_else(|_| found.clone());
            if around.contains(&whole) {
                let message = format!("{} would include itself.", shown(given));
                context.report.add(refused(message, "this file is around", "Put what both need into a third file."));
                continue;
            }
            if self.seen.contains(&whole) {
                continue;
            }
            if around.len() > MAX_DEPTH || self.seen.len() == MAX_FILES {
                let message =
                    format!("Files are included more than {MAX_DEPTH} deep, or more than {MAX_FILES} of them.");
                context.report.add(refused(message, "one too many", "Include fewer."));
                continue;
            }
            self.seen.push(whole.clone());
            self.files.push(found.clone());
            let text = match read_text(&found) {
                Ok(text) if self.bytes + text.len() <= MAX_BYTES => text,
                Ok(_) => {
                    let message = format!("The scene and what it includes are larger than {} MiB.", MAX_BYTES >> 20);
                    context.report.add(refused(message, "this is too much", "Leave parts of it out."));
                    continue;
                }
                Err(error) => {
                    let (reason, help) = match error {
                        SceneError::Unreadable { reason, help, .. } => (reason, help),
                        other => (other.to_string(), String::new()),
                    };
                    let message = format!("{} cannot be included: {reason}.", shown(given));
                    context.report.add(refused(message, "of this file", &help));
                    continue;
                }
            };
            self.bytes += text.len();
            let name = found.display().to_string();
            let base = context.report.begin(&name, &text);
            let block = syntax::read(&text, &mut context.report).map(Block::into_owned);
            context.report.end();
            let Some(mut block) = block else { continue };
            block.shift(base);
            if version(&block, context) == Version::Other {
                continue;
            }
            for node in block.nodes.iter().filter(|node| !TOP.contains(&&*node.name.value)) {
                unexpected_node(&node.name, TOP, "at the top of a scene", context);
            }
            around.push(whole);
            self.follow(&found, &block.nodes, around, context);
            around.pop();
            self.nodes.extend(block.nodes.into_iter().filter(|node| TAKEN.contains(&&*node.name.value)));
        }
    }
}
