//! Imports of each file: from other files of its crate, and of other crates of the workspace.
//!
//! Counted are `use` items and paths that are written out: in expressions, types, patterns, attributes and the tokens of
//! macros. An import is one from the file that *defines* the name: re-exports are followed as long as they stay in the
//! crate. A path through a module takes nothing from that module's own file: `use crate::gpu; gpu::device::open()` is an
//! import from `gpu/device.rs` alone. Documentation, and code that only tests compile, take nothing.
//!
//! Methods are not seen, nor names that the macro of another file inserts.

use crate::modules::{Crate, Module};
use crate::names::{Names, Target};
use crate::syntax::{EXTERN, Use, is_for_tests, text, uses};
use proc_macro2::{TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};

/// The imports of a crate.
pub struct Imports<'a> {
    /// The crate itself.
    pub of: &'a Crate,
    /// Names that the first file takes from the second.
    pub files: BTreeMap<(&'a str, &'a str), BTreeSet<String>>,
    /// Files that name another crate of the workspace, by its package.
    pub crates: BTreeMap<&'a str, BTreeSet<&'a str>>,
}

/// Imports of all crates, in their order.
pub fn of_crates(crates: &[Crate]) -> Vec<Imports<'_>> {
    crates.iter().map(|krate| of_crate(krate, crates)).collect()
}

fn of_crate<'a>(krate: &'a Crate, crates: &'a [Crate]) -> Imports<'a> {
    let mut imports = Imports { of: krate, files: BTreeMap::new(), crates: BTreeMap::new() };
    for (index, module) in krate.modules.iter().enumerate().filter(|(_, module)| !module.is_test) {
        let names = Names { krate, crates };
        let mut collector = Collector { names, module: index, blocks: Vec::new(), modules: BTreeMap::new(), imports };
        module.items.iter().for_each(|item| collector.visit_item(item));
        collector.add_unused_modules();
        imports = collector.imports;
        if let Some(parent) = module.parent.filter(|_| module.is_declared_by_macro) {
            let name = module_name(&krate.modules[parent], index);
            add(&mut imports.files, &krate.modules[parent].file, &module.file, name);
        }
    }
    imports
}

fn module_name(parent: &Module, child: usize) -> &str {
    parent.children.iter().find(|(_, index)| **index == child).map_or("", |(name, _)| name)
}

type Files<'a> = BTreeMap<(&'a str, &'a str), BTreeSet<String>>;

fn add<'a>(files: &mut Files<'a>, from: &'a str, to: &'a str, name: &str) {
    if from != to {
        files.entry((from, to)).or_default().insert(name.to_owned());
    }
}

/// Collects the imports of one module.
struct Collector<'a> {
    names: Names<'a>,
    module: usize,
    /// Imports of the blocks around the current place, outermost first.
    blocks: Vec<Vec<Use>>,
    /// Modules that are imported, by their names here: their index, until a path leads through them.
    modules: BTreeMap<String, Option<usize>>,
    imports: Imports<'a>,
}

impl Collector<'_> {
    /// Adds the import that a path is, if it leads to another file.
    fn add_path(&mut self, path: &[String]) -> Option<usize> {
        let modules = &self.names.krate.modules;
        let from = modules[self.module].file.as_str();
        match self.names.resolve(self.module, &self.blocks, path)? {
            Target::Module(module) => return Some(module),
            Target::Crate(name) => {
                self.imports.crates.entry(name).or_default().insert(from);
            }
            Target::Item(module, name) => add(&mut self.imports.files, from, &modules[module].file, &name),
        }
        None
    }

    /// Adds a path that is written out.
    fn add_written(&mut self, path: &[String]) {
        if path.len() > 1 {
            self.modules.insert(path[0].clone(), None);
            self.add_path(path);
        } else if self.names.has_globs(self.module, &self.blocks) {
            self.add_path(path);
        }
    }

    fn add_use(&mut self, item: Use) {
        let module = self.add_path(&item.path);
        if item.path.len() > 1 {
            self.modules.insert(item.path[0].clone(), None);
        }
        if let Some(module) = module {
            if item.name == "*" {
                self.add_module("*", module);
            } else {
                self.modules.entry(item.name).or_insert(Some(module));
            }
        }
    }

    fn add_module(&mut self, name: &str, module: usize) {
        let modules = &self.names.krate.modules;
        add(&mut self.imports.files, &modules[self.module].file, &modules[module].file, name);
    }

    /// Counts an imported module as an import from its own file if nothing was seen that is taken through it.
    fn add_unused_modules(&mut self) {
        for (name, module) in std::mem::take(&mut self.modules) {
            if let Some(module) = module {
                self.add_module(&name, module);
            }
        }
    }

    /// Adds the paths among tokens: at least two names with `::` between them.
    fn add_tokens(&mut self, tokens: &TokenStream) {
        let tokens: Vec<_> = tokens.clone().into_iter().collect();
        let mut next = 0;
        while next < tokens.len() {
            if let TokenTree::Group(group) = &tokens[next] {
                self.add_tokens(&group.stream());
            }
            let path = path_at(&tokens, next);
            // `$name` may be any name, and what follows `>::` belongs to a type.
            let is_rest = next > 0 && (is_punct(&tokens, next - 1, '$') || is_punct(&tokens, next - 1, ':'));
            if path.len() > 1 && (!is_rest || path[0] == "crate") {
                self.add_written(&path);
            }
            // A name and two colons for each but the last.
            next += (3 * path.len()).saturating_sub(2).max(1);
        }
    }
}

/// Names from this token on, as far as `::` joins them.
fn path_at(tokens: &[TokenTree], start: usize) -> Vec<String> {
    let name = |index: usize| match tokens.get(index) {
        Some(TokenTree::Ident(ident)) => Some(text(ident)),
        _ => None,
    };
    let joined = |index: &usize| is_punct(tokens, index - 2, ':') && is_punct(tokens, index - 1, ':');
    let Some(first) = name(start) else { return Vec::new() };
    let rest = (start + 3..).step_by(3).take_while(joined).map_while(name);
    std::iter::once(first).chain(rest).collect()
}

fn is_punct(tokens: &[TokenTree], index: usize, character: char) -> bool {
    matches!(tokens.get(index), Some(TokenTree::Punct(punct)) if punct.as_char() == character)
}

/// Visits what is compiled without tests.
macro_rules! skip_tests {
    ($($visit:ident: $node:ident),* $(,)?) => {
        $(fn $visit(&mut self, node: &'ast syn::$node) {
            if !is_for_tests(&node.attrs) {
                visit::$visit(self, node);
            }
        })*
    };
}

impl<'ast> Visit<'ast> for Collector<'_> {
    skip_tests! {
        visit_arm: Arm,
        visit_expr_block: ExprBlock,
        visit_field: Field,
        visit_field_value: FieldValue,
        visit_impl_item_const: ImplItemConst,
        visit_impl_item_fn: ImplItemFn,
        visit_impl_item_macro: ImplItemMacro,
        visit_impl_item_type: ImplItemType,
        visit_item_const: ItemConst,
        visit_item_enum: ItemEnum,
        visit_item_fn: ItemFn,
        visit_item_impl: ItemImpl,
        visit_item_macro: ItemMacro,
        visit_item_static: ItemStatic,
        visit_item_struct: ItemStruct,
        visit_item_trait: ItemTrait,
        visit_item_type: ItemType,
        visit_item_union: ItemUnion,
        visit_local: Local,
        visit_stmt_macro: StmtMacro,
        visit_trait_item_const: TraitItemConst,
        visit_trait_item_fn: TraitItemFn,
        visit_trait_item_type: TraitItemType,
        visit_variant: Variant,
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_for_tests(&item.attrs) {
            uses(item).into_iter().for_each(|item| self.add_use(item));
        }
    }

    fn visit_block(&mut self, block: &'ast syn::Block) {
        let imported = block.stmts.iter().filter_map(|statement| match statement {
            syn::Stmt::Item(syn::Item::Use(item)) if !is_for_tests(&item.attrs) => Some(uses(item)),
            _ => None,
        });
        self.blocks.push(imported.flatten().collect());
        visit::visit_block(self, block);
        self.blocks.pop();
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let start = path.leading_colon.as_ref().map(|_| EXTERN.to_owned()).into_iter();
        self.add_written(&start.chain(path.segments.iter().map(|segment| text(&segment.ident))).collect::<Vec<_>>());
        visit::visit_path(self, path);
    }

    fn visit_token_stream(&mut self, tokens: &'ast TokenStream) {
        self.add_tokens(tokens);
    }

    /// `pub(in path)` takes nothing.
    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}
}
