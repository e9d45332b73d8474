//! Where a name is declared: in the text, or in a file that it includes.

use super::OpenText;
use super::hover::word_at;
use super::locate::{Located, Part, locate};
use super::symbols::range;
use crate::language;
use crate::language::keywords::{FIELD, INCLUDE, MATERIAL, PARAM, SHAPE};
use crate::language::read::params::declared_name;
use crate::language::tree::{Block, Node, Value};
use crate::source::read_text;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Place of a declaration.
#[derive(Clone, Debug, PartialEq)]
pub struct Definition {
    /// The file and its text; `None` for the text itself.
    pub file: Option<(PathBuf, String)>,
    /// Bytes of the declared name.
    pub range: Range<usize>,
}

/// Files that are searched for a declaration.
const MAX_FILES: usize = 1000;

impl OpenText {
    /// Declaration of the material, shape, field or parameter at byte `at`, or the included file.
    pub fn definition(&self, at: usize) -> Option<Definition> {
        let file = self.file.as_ref()?;
        let located = locate(file, at)?;
        if let (Part::Value(entry), INCLUDE) = (located.part, &*located.node.name.value)
            && let Value::Text(path) = &entry.value
        {
            let path = folder(Path::new(&self.name)).join(&**path);
            let text = read_text(&path).ok()?;
            return Some(Definition { file: Some((path, text)), range: 0..0 });
        }
        let (words, name) = wanted(&located, &self.text, at)?;
        if words.contains(&PARAM)
            && let Some(own) =
                located.parents.first().and_then(|parent| declaration(parent.child_nodes(), words, &name))
        {
            return Some(Definition { file: None, range: own });
        }
        let here = declaration(&file.nodes, words, &name).map(|range| Definition { file: None, range });
        here.or_else(|| in_files(file, Path::new(&self.name), words, &name))
    }
}

/// Words of the nodes that may declare the name at byte `at`, and the name.
fn wanted(located: &Located, text: &str, at: usize) -> Option<(&'static [&'static str], String)> {
    match located.part {
        Part::Name if !located.parents.is_empty() => Some((&[SHAPE, FIELD], located.node.name.value.to_string())),
        Part::Value(entry) => match (&entry.name, &entry.value) {
            (Some(name), Value::Text(value)) if name.value == MATERIAL => Some((&[MATERIAL], value.to_string())),
            _ => Some((&[PARAM], word_at(text, entry.value_span, at)?.to_owned())),
        },
        _ => None,
    }
}

/// Bytes of the name in the first of these nodes that declares it.
fn declaration(nodes: &[Node], words: &[&str], name: &str) -> Option<Range<usize>> {
    let declares = |node: &&Node| words.contains(&&*node.name.value) && declared_name(node) == Some(name);
    let entry = nodes.iter().find(declares)?.entries.iter().find(|entry| entry.name.is_none())?;
    Some(range(entry.value_span))
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

fn included<'n>(nodes: &'n [Node], path: &'n Path) -> impl Iterator<Item = PathBuf> + use<'n> {
    let includes = nodes.iter().filter(|node| node.name.value == INCLUDE);
    includes.filter_map(declared_name).map(|name| folder(path).join(name))
}

/// Searches the included files, each once.
fn in_files(file: &Block, path: &Path, words: &[&str], name: &str) -> Option<Definition> {
    let mut files: Vec<PathBuf> = included(&file.nodes, path).collect();
    let mut next = 0;
    while next < files.len().min(MAX_FILES) {
        let path = files[next].clone();
        next += 1;
        let Ok(text) = read_text(&path) else { continue };
        let Some(block) = language::nodes(&text).map(Block::into_owned) else { continue };
        if let Some(range) = declaration(&block.nodes, words, name) {
            return Some(Definition { file: Some((path, text)), range });
        }
        let more: Vec<PathBuf> = included(&block.nodes, &path).filter(|path| !files.contains(path)).collect();
        files.extend(more);
    }
    None
}
