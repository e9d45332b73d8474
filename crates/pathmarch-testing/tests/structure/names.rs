//! Meaning of a path in a module: the rules of Rust for names, as far as the syntax shows them.

use crate::modules::Crate;
use crate::syntax::{EXTERN, Use};

/// Destination of a path.
pub enum Target<'a> {
    /// A module of the same crate.
    Module(usize),
    /// Another item of the same crate: the module that defines it, and its name.
    Item(usize, String),
    /// Another crate of the workspace.
    Crate(&'a str),
}

/// Most re-exports on the way to a definition; names that import each other end there.
const MAX_STEPS: usize = 16;

/// The names of a crate, with the crates that it may name.
#[derive(Clone, Copy)]
pub struct Names<'a> {
    /// The crate.
    pub krate: &'a Crate,
    /// All crates of the workspace.
    pub crates: &'a [Crate],
}

impl<'a> Names<'a> {
    /// Target of a path in a module, within blocks with these imports; none for names from outside of the workspace, local
    /// names and unknown ones.
    pub fn resolve(self, module: usize, blocks: &[Vec<Use>], path: &[String]) -> Option<Target<'a>> {
        self.follow(module, blocks, path, MAX_STEPS)
    }

    /// True if names of other modules may be in scope without being named.
    pub fn has_globs(self, module: usize, blocks: &[Vec<Use>]) -> bool {
        self.uses(module, blocks).any(|item| item.name == "*")
    }

    fn uses<'b>(self, module: usize, blocks: &'b [Vec<Use>]) -> impl Iterator<Item = &'b Use>
    where
        'a: 'b,
    {
        blocks.iter().rev().flatten().chain(&self.krate.modules[module].uses)
    }

    fn follow(self, module: usize, blocks: &[Vec<Use>], path: &[String], steps: usize) -> Option<Target<'a>> {
        let steps = steps.checked_sub(1)?;
        let (first, rest) = path.split_first()?;
        let modules = &self.krate.modules;
        let mut target = match first.as_str() {
            EXTERN => return self.named_crate(rest.first()?),
            "crate" => Target::Module(std::iter::successors(Some(module), |module| modules[*module].parent).last()?),
            "self" => Target::Module(module),
            "super" => Target::Module(modules[module].parent?),
            name => self.start(module, blocks, name, rest.is_empty(), steps)?,
        };
        for (index, name) in rest.iter().enumerate() {
            target = match target {
                Target::Module(module) if name == "self" => Target::Module(module),
                Target::Module(module) if name == "super" => Target::Module(modules[module].parent?),
                Target::Module(module) => self.member(module, name, index + 1 == rest.len(), steps),
                found => found,
            };
        }
        Some(target)
    }

    /// Target of the first name of a path.
    fn start(self, module: usize, blocks: &[Vec<Use>], name: &str, is_last: bool, steps: usize) -> Option<Target<'a>> {
        let this = &self.krate.modules[module];
        if let Some(child) = this.children.get(name).filter(|_| !is_last) {
            return Some(Target::Module(*child));
        }
        let imported = || {
            let mut uses = self.uses(module, blocks).filter(|item| item.name == name && item.path != [name]);
            uses.find_map(|item| self.follow(module, blocks, &item.path, steps))
        };
        let own = || this.names.contains(name).then(|| Target::Item(module, name.to_owned()));
        let child = || this.children.get(name).map(|child| Target::Module(*child));
        let others = || self.through_globs(module, blocks, name, is_last, steps);
        imported().or_else(own).or_else(child).or_else(others).or_else(|| self.named_crate(name))
    }

    /// Target of a name in another module. A name that is unknown there is defined by one of its macros.
    fn member(self, module: usize, name: &str, is_last: bool, steps: usize) -> Target<'a> {
        match self.start(module, &[], name, is_last, steps) {
            None | Some(Target::Crate(_)) => Target::Item(module, name.to_owned()),
            Some(target) => target,
        }
    }

    fn through_globs(
        self,
        module: usize,
        blocks: &[Vec<Use>],
        name: &str,
        is_last: bool,
        steps: usize,
    ) -> Option<Target<'a>> {
        let mut globs = self.uses(module, blocks).filter(|item| item.name == "*");
        globs.find_map(|glob| match self.follow(module, blocks, &glob.path, steps)? {
            Target::Module(other) if other != module => self
                .start(other, &[], name, is_last, steps.checked_sub(1)?)
                .filter(|target| !matches!(target, Target::Crate(_))),
            _ => None,
        })
    }

    fn named_crate(self, name: &str) -> Option<Target<'a>> {
        let krate = self.crates.iter().find(|krate| krate.name.replace('-', "_") == name)?;
        // The program of a crate names its library like any other.
        Some(if krate.name == self.krate.name { Target::Module(0) } else { Target::Crate(&krate.name) })
    }
}
