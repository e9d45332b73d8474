//! Scene texts that are edited: exact texts, every control, random edits.

mod controls;
mod edits;
mod formulas;
mod fuzz;
mod history;
mod own_fields;

use pathmarch_scene::document::{Document, Item, Path};

/// The node of this name or word; the first in the order of the file.
fn path(document: &Document, title: &str) -> Path {
    fn find(items: &[Item], title: &str) -> Option<Path> {
        let inside = |item: &Item| {
            if item.title() == title { Some(item.path.clone()) } else { find(&item.children, title) }
        };
        items.iter().find_map(inside)
    }
    find(document.outline(), title).unwrap_or_else(|| panic!("no {title} in\n{}", document.text()))
}

/// All nodes, parents before their children.
fn all_items(document: &Document) -> Vec<Item> {
    fn gather(items: &[Item], all: &mut Vec<Item>) {
        for item in items {
            all.push(item.clone());
            gather(&item.children, all);
        }
    }
    let mut all = Vec::new();
    gather(document.outline(), &mut all);
    all
}
