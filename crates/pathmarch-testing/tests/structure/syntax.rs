//! Names, imports and conditions that the syntax of a file shows by itself.

use proc_macro2::{TokenStream, TokenTree};
use std::collections::BTreeSet;
use syn::ext::IdentExt;
use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, ExprLit, Ident, Item, ItemUse, Lit, Meta, MetaList, Token, UseTree};

/// One name that a `use` item imports.
pub struct Use {
    /// Name in the importing module, or `*`.
    pub name: String,
    /// Path that is imported; for a glob that of the module. It ends in `self` if it names a module and nothing else.
    pub path: Vec<String>,
}

/// First segment of a path that begins with `::`.
pub const EXTERN: &str = "::";

/// An identifier without `r#`.
pub fn text(ident: &Ident) -> String {
    ident.unraw().to_string()
}

/// True for code that only tests or documentation compile.
pub fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let condition = attribute.path().is_ident("cfg").then(|| attribute.parse_args::<Meta>().ok()).flatten();
        attribute.path().is_ident("test") || condition.is_some_and(|condition| demands_tests(&condition))
    })
}

fn demands_tests(condition: &Meta) -> bool {
    let Meta::List(list) = condition else {
        return condition.path().is_ident("test") || condition.path().is_ident("doc");
    };
    let parts = parts(list);
    let mut parts = parts.iter();
    match text(&list.path.segments[0].ident).as_str() {
        "all" => parts.any(demands_tests),
        "any" => parts.len() > 0 && parts.all(demands_tests),
        _ => false,
    }
}

/// Names that a `use` item imports.
pub fn uses(item: &ItemUse) -> Vec<Use> {
    let mut uses = Vec::new();
    let start = item.leading_colon.as_ref().map(|_| EXTERN.to_owned());
    flatten(&item.tree, &start.into_iter().collect::<Vec<_>>(), &mut uses);
    uses
}

fn flatten(tree: &UseTree, before: &[String], uses: &mut Vec<Use>) {
    let with = |ident: &Ident| [before, &[text(ident)]].concat();
    let mut leaf = |ident: &Ident, name: Option<&Ident>| {
        let own_name = before.last().filter(|_| ident == "self").cloned();
        let name = name.map(text).or(own_name).unwrap_or_else(|| text(ident));
        uses.push(Use { name, path: with(ident) });
    };
    match tree {
        UseTree::Path(path) => flatten(&path.tree, &with(&path.ident), uses),
        UseTree::Name(name) => leaf(&name.ident, None),
        UseTree::Rename(rename) => leaf(&rename.ident, Some(&rename.rename)),
        UseTree::Glob(_) => uses.push(Use { name: "*".to_owned(), path: before.to_vec() }),
        UseTree::Group(group) => group.items.iter().for_each(|tree| flatten(tree, before, uses)),
    }
}

/// Name of an item that is neither a module nor an import.
pub fn name_of(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(text(ident))
}

/// Value of `#[path = "…"]` or `#[cfg_attr(…, path = "…")]`.
pub fn path_attribute(attribute: &Attribute) -> Option<String> {
    path_in(&attribute.meta)
}

fn path_in(meta: &Meta) -> Option<String> {
    match meta {
        Meta::List(list) if list.path.is_ident("cfg_attr") => parts(list).iter().skip(1).find_map(path_in),
        Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(path), .. }) => Some(path.value()),
            _ => None,
        },
        _ => None,
    }
}

/// Items in the parentheses of an attribute.
fn parts(list: &MetaList) -> Punctuated<Meta, Token![,]> {
    list.parse_args_with(Punctuated::parse_terminated).unwrap_or_default()
}

/// Adds all identifiers among these tokens.
pub fn collect_words(tokens: TokenStream, words: &mut BTreeSet<String>) {
    for token in tokens {
        match token {
            TokenTree::Ident(ident) => {
                words.insert(text(&ident));
            }
            TokenTree::Group(group) => collect_words(group.stream(), words),
            _ => {}
        }
    }
}
