//! Selection: nodes of the scene in the order in which they were selected.

use pathmarch_render::pathmarch_scene::document::{Document, Item, Path};

/// Word and name of a node.
type Title = (String, Option<String>);

/// The selected nodes. The last one is active: the inspector and the gizmo show it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Selection {
    paths: Vec<Path>,
    /// Titles of each node and of those around it, from the top of the file.
    titles: Vec<Vec<Title>>,
}

impl Selection {
    /// All selected nodes; the active one is last.
    pub(crate) fn paths(&self) -> &[Path] {
        &self.paths
    }
    /// The active node.
    pub(crate) fn active(&self) -> Option<&Path> {
        self.paths.last()
    }
    pub(crate) fn contains(&self, path: &Path) -> bool {
        self.paths.contains(path)
    }
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
    /// Selects these nodes alone.
    pub(crate) fn set(&mut self, document: &Document, paths: impl IntoIterator<Item = Path>) {
        self.clear();
        paths.into_iter().for_each(|path| self.add(document, path));
    }
    /// Adds a node, which becomes active.
    pub(crate) fn add(&mut self, document: &Document, path: Path) {
        self.remove(&path);
        let Some(titles) = titles(document, &path) else { return };
        self.paths.push(path);
        self.titles.push(titles);
    }
    /// Adds a node, or removes it if it is selected.
    pub(crate) fn toggle(&mut self, document: &Document, path: Path) {
        if !self.remove(&path) {
            self.add(document, path);
        }
    }
    /// Removes a node; returns true if it was selected.
    fn remove(&mut self, path: &Path) -> bool {
        let Some(index) = self.paths.iter().position(|other| other == path) else { return false };
        self.paths.remove(index);
        self.titles.remove(index);
        true
    }
    /// Finds the selected nodes again in a document that has changed.
    pub(crate) fn restore(&mut self, document: &Document) {
        let found: Vec<Path> =
            self.paths.iter().zip(&self.titles).filter_map(|(path, titles)| find(document, path, titles)).collect();
        self.set(document, found);
    }
}

fn title(item: &Item) -> Title {
    (item.word.clone(), item.name.clone())
}

/// Titles along a path; `None` if it leads nowhere.
fn titles(document: &Document, path: &Path) -> Option<Vec<Title>> {
    let ends = 1..=path.indexes().len();
    ends.map(|end| document.item(&Path::from(path.indexes()[..end].to_vec())).map(title)).collect()
}

/// The node that once had this path and these titles.
fn find(document: &Document, path: &Path, titles: &[Title]) -> Option<Path> {
    let mut items = document.outline();
    let mut found = None;
    for (&index, title) in path.indexes().iter().zip(titles) {
        let item = same(items, index, title)?;
        items = &item.children;
        found = Some(item.path.clone());
    }
    found
}

/// The sibling with this title: the one at this index, the first other one, or one of this word at this index.
fn same<'i>(items: &'i [Item], index: usize, wanted: &Title) -> Option<&'i Item> {
    let here = items.get(index);
    let is_same = |item: &&Item| item.word == wanted.0 && item.name == wanted.1;
    here.filter(is_same).or_else(|| items.iter().find(is_same)).or_else(|| here.filter(|item| item.word == wanted.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "pathmarch 1\ncamera { position 0 0 5; target 0 0 0 }\nsky 1\nobject \"a\" { sphere; box }\n\
                        object \"b\" { union { sphere; box } }\n";

    fn path(indexes: &[usize]) -> Path {
        Path::from(indexes.to_vec())
    }

    #[test]
    fn nodes_are_found_again_where_they_have_moved_to() {
        let mut document = Document::new("test.kdl", TEXT);
        let mut selection = Selection::default();
        selection.set(&document, [path(&[3, 1]), path(&[4, 0, 0])]);
        assert_eq!(selection.paths(), [path(&[3, 1]), path(&[4, 0, 0])]);
        let text =
            TEXT.replace("sky 1\n", "sky 1\nobject \"first\" { plane }\n").replace("sphere; box }\no", "box }\no");
        document.replace_text(text, "Test", None);
        selection.restore(&document);
        assert_eq!(selection.paths(), [path(&[4, 0]), path(&[5, 0, 0])]);
        document.replace_text(TEXT.replace("object \"b\"", "object \"c\""), "Test", None);
        selection.restore(&document);
        assert_eq!(selection.paths(), [path(&[3, 1])], "there is no object b any more");
    }

    #[test]
    fn what_is_gone_is_no_longer_selected() {
        let mut document = Document::new("test.kdl", TEXT);
        let mut selection = Selection::default();
        selection.set(&document, [path(&[3, 1]), path(&[9])]);
        assert_eq!(selection.paths(), [path(&[3, 1])], "there is no ninth node");
        selection.toggle(&document, path(&[3, 0]));
        selection.toggle(&document, path(&[3, 1]));
        assert_eq!(selection.active(), Some(&path(&[3, 0])));
        document.replace_text(TEXT.replace("sphere; box }\n", "cone }\n"), "Test", None);
        selection.restore(&document);
        assert_eq!(selection.paths(), []);
    }
}
