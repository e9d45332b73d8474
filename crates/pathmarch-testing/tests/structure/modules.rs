//! The modules of each crate, read from its source files as the compiler finds them.
//!
//! `mod x;` names `x.rs` or `x/mod.rs`; `#[path]` and inline modules change where to look. Modules that a macro of the
//! crate declares are found by their files: a file that no `mod` line names belongs to the closest module above it with a
//! macro call that contains its name. Code for tests or documentation alone is left out.

use crate::syntax::{Use, collect_words, is_for_tests, name_of, path_attribute, text, uses};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};
use syn::{Attribute, Item, ItemMod};

/// A crate of the workspace.
pub struct Crate {
    /// Name of its package.
    pub name: String,
    /// All modules, parents before children. The first is the root of the library, if the crate has one.
    pub modules: Vec<Module>,
}

/// A module, in a file of its own or inline.
#[derive(Default)]
pub struct Module {
    /// File that contains it, relative to the workspace, with `/`.
    pub file: String,
    /// Index of the module that declares it; none for the root of a crate.
    pub parent: Option<usize>,
    /// Indices of its modules by name.
    pub children: BTreeMap<String, usize>,
    /// Names of its other items.
    pub names: BTreeSet<String>,
    /// Imports that are in scope in the whole module.
    pub uses: Vec<Use>,
    /// Its items but modules.
    pub items: Vec<Item>,
    /// True if only tests or documentation compile it.
    pub is_test: bool,
    /// True if a macro declares it.
    pub is_declared_by_macro: bool,
    is_inline: bool,
    /// Folder of the files of its children.
    folder: PathBuf,
    /// Words in the macro calls among its items.
    macro_words: BTreeSet<String>,
}

/// Reads every crate of the workspace, in the order of their names.
///
/// # Panics
/// If a file cannot be read or parsed, or no module declares it.
pub fn read_crates(workspace: &Path) -> Vec<Crate> {
    let mut folders = files_in(&workspace.join("crates"));
    folders.push(workspace.join("scenes"));
    folders.retain(|folder| folder.join("Cargo.toml").exists());
    let mut crates: Vec<_> = folders.iter().map(|folder| read_crate(workspace, folder)).collect();
    crates.sort_by(|a, b| a.name.cmp(&b.name));
    crates
}

fn read_crate(workspace: &Path, folder: &Path) -> Crate {
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).expect("Cargo.toml");
    let name = manifest.lines().find_map(|line| line.strip_prefix("name = ")).expect("a name in Cargo.toml");
    let mut reader = Reader { workspace, modules: Vec::new(), files: BTreeSet::new() };
    let roots = ["src/lib.rs", "src/main.rs", "lib.rs"].map(|root| folder.join(root));
    for root in roots.iter().filter(|root| root.exists()) {
        reader.read_file(root.clone(), None, true, false);
    }
    reader.read_files_of_macros(&sources(&folder.join("src")));
    Crate { name: name.trim_matches('"').to_owned(), modules: reader.modules }
}

struct Reader<'a> {
    workspace: &'a Path,
    modules: Vec<Module>,
    /// Files that were read.
    files: BTreeSet<PathBuf>,
}

impl Reader<'_> {
    fn add(&mut self, module: Module) -> usize {
        self.modules.push(module);
        self.modules.len() - 1
    }

    /// Reads a file and all modules below it. The children of a file that owns its folder are beside it.
    fn read_file(&mut self, file: PathBuf, parent: Option<usize>, owns_folder: bool, is_test: bool) -> usize {
        let text = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let beside = owns_folder || file.ends_with("mod.rs");
        let folder = if beside { folder_of(&file) } else { file.with_extension("") };
        let relative = file.strip_prefix(self.workspace).expect("a file of the workspace");
        let module = self.add(Module {
            file: relative.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/"),
            parent,
            is_test: is_test || is_for_tests(&parsed.attrs),
            folder,
            ..Module::default()
        });
        self.files.insert(file);
        self.read_items(module, parsed.items);
        module
    }

    fn read_items(&mut self, module: usize, items: Vec<Item>) {
        for item in items {
            let this = &mut self.modules[module];
            match item {
                Item::Mod(declaration) => {
                    self.read_module(module, declaration);
                    continue;
                }
                Item::Use(ref item) if !is_for_tests(&item.attrs) => this.uses.extend(uses(item)),
                Item::Macro(ref call) if call.ident.is_none() => {
                    collect_words(call.mac.tokens.clone(), &mut this.macro_words);
                }
                _ => this.names.extend(name_of(&item)),
            }
            self.modules[module].items.push(item);
        }
    }

    fn read_module(&mut self, parent: usize, declaration: ItemMod) {
        let name = text(&declaration.ident);
        let is_test = self.modules[parent].is_test || is_for_tests(&declaration.attrs);
        let modules = match declaration.content {
            Some((_, items)) => {
                let module = self.add_inline(parent, &name, is_test);
                self.read_items(module, items);
                vec![module]
            }
            None => {
                let files = self.files_of(&self.modules[parent], &name, &declaration.attrs);
                files.into_iter().map(|(file, owns)| self.read_file(file, Some(parent), owns, is_test)).collect()
            }
        };
        if !is_test {
            self.modules[parent].children.entry(name).or_insert(modules[0]);
        }
    }

    fn add_inline(&mut self, parent: usize, name: &str, is_test: bool) -> usize {
        let Module { file, folder, .. } = &self.modules[parent];
        let (file, folder) = (file.clone(), folder.join(name));
        self.add(Module { file, parent: Some(parent), is_test, is_inline: true, folder, ..Module::default() })
    }

    /// Files that a declaration without content names, each with whether it owns its folder: the usual one first, then those
    /// of `#[path]` and `#[cfg_attr(…, path)]`.
    fn files_of(&self, parent: &Module, name: &str, attributes: &[Attribute]) -> Vec<(PathBuf, bool)> {
        let plain = parent.folder.join(format!("{name}.rs"));
        let usual = if plain.exists() { plain } else { parent.folder.join(name).join("mod.rs") };
        let file = self.workspace.join(&parent.file);
        let base = if parent.is_inline { parent.folder.clone() } else { folder_of(&file) };
        let is_moved = attributes.iter().any(|attribute| attribute.path().is_ident("path"));
        let usual = (!is_moved).then_some((usual, false));
        let others = attributes.iter().filter_map(path_attribute).map(|path| (normal(&base.join(path)), true));
        usual.into_iter().chain(others).collect()
    }

    /// Reads the files that no `mod` line names.
    fn read_files_of_macros(&mut self, sources: &[PathBuf]) {
        loop {
            let unread = |file: &&PathBuf| !self.files.contains(*file);
            let found = sources.iter().filter(unread).find_map(|file| Some((file, self.declaring_macro(file)?)));
            let Some((file, (mut module, mut names))) = found else { break };
            let name = names.pop().expect("the file's own name");
            for folder in names {
                let child = self.modules[module].children.get(&folder).copied();
                let inline = child.unwrap_or_else(|| self.add_inline(module, &folder, self.modules[module].is_test));
                self.modules[module].children.insert(folder, inline);
                module = inline;
            }
            let child = self.read_file(file.clone(), Some(module), false, self.modules[module].is_test);
            self.modules[child].is_declared_by_macro = true;
            self.modules[module].children.insert(name, child);
        }
        let unread: Vec<_> = sources.iter().filter(|file| !self.files.contains(*file)).collect();
        assert!(unread.is_empty(), "files that no module declares: {unread:?}");
    }

    /// Closest module above a file with a macro call that contains the names from there to the file, and these names.
    fn declaring_macro(&self, file: &Path) -> Option<(usize, Vec<String>)> {
        let place = if file.ends_with("mod.rs") { folder_of(file) } else { file.with_extension("") };
        place.ancestors().skip(1).find_map(|folder| {
            let names = place.strip_prefix(folder).ok()?.iter().map(|name| name.to_string_lossy().into_owned());
            let names: Vec<_> = names.collect();
            let declares =
                |module: &Module| module.folder == folder && names.iter().all(|name| module.macro_words.contains(name));
            Some((self.modules.iter().position(declares)?, names))
        })
    }
}

/// A path without `..`.
fn normal(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |path, part| match part {
        Component::ParentDir => folder_of(&path),
        part => path.join(part),
    })
}

fn folder_of(file: &Path) -> PathBuf {
    file.parent().expect("a file in a folder").to_owned()
}

/// Entries of a folder in the order of their names; none if it does not exist.
fn files_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<_> = entries.map(|entry| entry.expect("a readable folder").path()).collect();
    files.sort();
    files
}

/// All source files in a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let is_source = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "rs");
    let files = files_in(folder).into_iter();
    files.flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] }).filter(is_source).collect()
}
