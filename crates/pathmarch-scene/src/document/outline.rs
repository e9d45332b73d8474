//! The tree of a file as people see it: nodes, not the parameters in them.

use super::path::Path;

/// What a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ItemKind {
    /// `pathmarch 1`
    Version,
    /// A camera.
    Camera,
    /// Picture size and quality.
    Render,
    /// What surrounds the scene.
    Sky,
    /// A sun.
    Sun,
    /// A point light.
    Point,
    /// A material.
    Material,
    /// An object.
    Object,
    /// A shape of the registry.
    Shape,
    /// An operator of the registry.
    Operator,
    /// Anything else; a mistake.
    Other,
}

/// A node as it stands in the tree of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Where it stands.
    pub path: Path,
    /// What it is.
    pub kind: ItemKind,
    /// Its first word: `sphere`, `object`.
    pub word: String,
    /// Its name, of those that have one; a camera without is `main`.
    pub name: Option<String>,
    /// Its own `material=`; for a material, the word of its kind.
    pub material: Option<String>,
    /// Nodes within it, in the order of the file.
    pub children: Vec<Item>,
}
